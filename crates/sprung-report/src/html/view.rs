//! Converts the texts of a document to the values that the template expects.

use std::collections::BTreeMap;

use minijinja::{Value, context};

use super::super::document::{
    BarRow, Block, Document, Finding, Fold, IntervalRow, Intervals, Layout, Row, Section, Table,
    Tone,
};

/// Returns the template values of all sections; the data of figures are separate.
pub(super) fn sections(document: &Document) -> Value {
    let mut before = Before::default();
    document
        .sections
        .iter()
        .map(|section| section_view(section, &mut before))
        .collect()
}

/// What stands before a block on the page.
#[derive(Default)]
struct Before<'a> {
    figures: usize,
    /// Code of the finding that first told a cause and a condition.
    told: BTreeMap<(&'a str, &'a str), &'a str>,
}

/// Returns the CSS class of a tone.
pub(super) fn tone(tone: Tone) -> &'static str {
    match tone {
        Tone::Good => "good",
        Tone::Doubtful => "doubtful",
        Tone::Bad => "bad",
        Tone::Neutral => "neutral",
    }
}

fn section_view<'a>(section: &'a Section, before: &mut Before<'a>) -> Value {
    let blocks: Value = section
        .blocks
        .iter()
        .map(|block| block_view(block, before))
        .collect();
    let fold = match section.fold {
        Fold::Open => "open",
        Fold::Screen => "screen",
        Fold::Detail => "detail",
    };
    context! {
        id => section.id.as_str(),
        heading => section.heading.as_str(),
        lead => section.lead.as_str(),
        fold,
        blocks,
    }
}

fn block_view<'a>(block: &'a Block, before: &mut Before<'a>) -> Value {
    match block {
        Block::Paragraph(text) => context! { kind => "paragraph", text => text },
        Block::Code(text) => context! { kind => "code", text => text },
        Block::KeyValues(pairs) => {
            let pairs: Value = pairs
                .iter()
                .map(|(key, value)| context! { key => key, value => value })
                .collect();
            context! { kind => "key_values", pairs }
        }
        Block::Table(table) => table_view(table),
        Block::Figure(figure) => {
            let index = before.figures;
            before.figures += 1;
            let layout = match figure.layout {
                Layout::Stack => "stack",
                Layout::Grid => "grid",
                Layout::Overview => "overview",
                Layout::Half => "half",
            };
            context! { kind => "figure", id => figure.id.as_str(), caption => figure.caption.as_str(), layout, index }
        }
        Block::Drawing(drawing) => {
            context! {
                kind => "drawing",
                svg => Value::from_safe_string(drawing.svg.to_owned()),
                caption => drawing.caption.as_str(),
            }
        }
        // The script finds the data of each arm by its place among all arms.
        Block::Skeleton(shown) => {
            context! { kind => "skeleton", caption => shown.caption.as_str() }
        }
        Block::Intervals(shown) => intervals_view(shown),
        Block::Bars(shown) => {
            let rows: Value = shown.rows.iter().map(bar_row_view).collect();
            let ticks: Value = (shown.ticks.iter())
                .map(|(at, text)| context! { at => part(*at), text })
                .collect();
            context! { kind => "bars", caption => shown.caption.as_str(), names => &shown.names, ticks, rows }
        }
        Block::Findings(findings) => {
            let findings: Value = (findings.iter())
                .map(|finding| finding_view(finding, before))
                .collect();
            context! { kind => "findings", findings }
        }
    }
}

/// Returns intervals, with neighbouring rows of one group together.
fn intervals_view(shown: &Intervals) -> Value {
    let groups: Value = (shown.rows.chunk_by(|a, b| a.group == b.group))
        .map(|rows| {
            let heading = rows.first().map_or("", |row| row.group.as_str());
            let count = rows.len();
            let rows: Value = rows.iter().map(interval_row_view).collect();
            context! { heading, count, rows }
        })
        .collect();
    let ticks: Value = (shown.ticks.iter())
        .map(|(at, text)| context! { at => half(*at), text })
        .collect();
    context! {
        kind => "intervals",
        caption => shown.caption.as_str(),
        names => &shown.names,
        ticks,
        groups,
        folded => shown.folded,
    }
}

/// Returns a position between -1 and 1 in percent of the width.
fn half(at: f64) -> String {
    format!("{:.2}", 50.0 + 50.0 * at.clamp(-1.0, 1.0))
}

/// Returns a row of intervals, with positions in percent of the row's width.
fn interval_row_view(row: &IntervalRow) -> Value {
    let marks: Value = (row.marks.iter().enumerate())
        .map(|(lane, mark)| {
            let at = mark.filter(|mark| mark.at.abs() <= OUTSIDE);
            let ends = mark.and_then(|mark| mark.interval);
            let lowest = mark.map(|mark| ends.map_or(mark.at, |ends| ends[0].min(mark.at)));
            let highest = mark.map(|mark| ends.map_or(mark.at, |ends| ends[1].max(mark.at)));
            context! {
                color => lane % COLORS,
                shape => lane % SHAPES,
                at => at.map(|mark| half(mark.at)),
                low => ends.map(|ends| half(ends[0])),
                high => ends.map(|ends| half(-ends[1])),
                cut_low => lowest.is_some_and(|lowest| lowest < -OUTSIDE),
                cut_high => highest.is_some_and(|highest| highest > OUTSIDE),
            }
        })
        .collect();
    let label = shortened(&row.label);
    context! {
        // A narrow place may cut a label that is short enough elsewhere.
        title => (row.label.chars().count() > CUT_LABEL).then_some(row.label.as_str()),
        label => label.as_deref().unwrap_or(&row.label),
        scale => row.scale.as_str(),
        tone => tone(row.tone),
        marks,
    }
}

/// Returns a position between 0 and 1 in percent.
fn part(at: f64) -> String {
    format!("{:.2}", 100.0 * at.clamp(0.0, 1.0))
}

fn bar_row_view(row: &BarRow) -> Value {
    let bars: Value = (row.bars.iter().enumerate())
        .map(|(lane, bar)| {
            context! {
                color => lane % COLORS,
                length => bar.as_ref().map(|bar| part(bar.length)),
                text => bar.as_ref().map_or("", |bar| bar.text.as_str()),
            }
        })
        .collect();
    context! { label => row.label.as_str(), tone => tone(row.tone), bars }
}

/// Position beyond which a mark or the end of an interval lies outside a row.
const OUTSIDE: f64 = 1.0 + 1e-9;

/// A longer label of a row has a tooltip.
const CUT_LABEL: usize = 18;

/// Numbers of colours and of shapes of marks in the style sheet.
const COLORS: usize = 7;
const SHAPES: usize = 3;

fn finding_view<'a>(finding: &'a Finding, before: &mut Before<'a>) -> Value {
    let meaning = (finding.cause.as_str(), finding.condition.as_str());
    let told_under = before.told.get(&meaning).copied();
    if told_under.is_none() && !finding.cause.is_empty() {
        before.told.insert(meaning, &finding.code);
    }
    let label = match finding.severity {
        Tone::Good => "ok",
        Tone::Doubtful => "doubtful",
        Tone::Bad => "problem",
        Tone::Neutral => "note",
    };
    context! {
        tone => tone(finding.severity),
        label,
        code => finding.code.as_str(),
        title => finding.title.as_str(),
        text => finding.text.as_str(),
        remedy => finding.remedy.as_str(),
        cause => finding.cause.as_str(),
        condition => finding.condition.as_str(),
        ignore => finding.ignore.as_str(),
        told_under,
    }
}

fn table_view(table: &Table) -> Value {
    let places: Vec<Option<usize>> = (0..table.columns.len())
        .map(|column| column_places(table, column))
        .collect();
    let columns: Value = table
        .columns
        .iter()
        .map(|column| context! { heading => column.heading.as_str(), numeric => column.numeric })
        .collect();
    let rows: Value = (table.rows.iter().enumerate())
        .map(|(i, row)| {
            let heading = table.headings.iter().find(|(before, _)| *before == i);
            let row = row_view(row, table, &places);
            context! { heading => heading.map(|(_, text)| text), ..row }
        })
        .collect();
    context! { kind => "table", caption => table.caption.as_str(), columns, rows }
}

fn row_view(row: &Row, table: &Table, places: &[Option<usize>]) -> Value {
    let cells: Value = row
        .cells
        .iter()
        .enumerate()
        .map(|(column, text)| {
            let numeric = table.columns.get(column).is_some_and(|c| c.numeric);
            let most = places.get(column).copied().flatten();
            let digits = decimals(text);
            let pad = most.zip(digits).map_or(0, |(most, digits)| most - digits);
            // A number without decimal point also needs space for the point.
            let whole = pad > 0 && digits == Some(0);
            let short = shortened(text).filter(|_| column == 0);
            context! {
                title => short.as_ref().map(|_| text),
                text => short.as_ref().unwrap_or(text),
                numeric,
                pad,
                whole,
            }
        })
        .collect();
    context! { tone => tone(row.tone), cells }
}

/// Returns the beginning of a long name; `None` for a name that is short enough. The full name is a
/// tooltip and the content of exported tables.
fn shortened(name: &str) -> Option<String> {
    const LONGEST: usize = 34;
    (name.chars().count() > LONGEST).then(|| {
        let start: String = name.chars().take(LONGEST - 2).collect();
        let words = start
            .rsplit_once(' ')
            .map_or(start.as_str(), |(words, _)| words);
        format!("{words} …")
    })
}

/// Returns the largest number of decimals in a numeric column of plain numbers.
fn column_places(table: &Table, column: usize) -> Option<usize> {
    if !table.columns[column].numeric {
        return None;
    }
    table
        .rows
        .iter()
        .filter_map(|row| row.cells.get(column))
        .filter_map(|text| decimals(text))
        .max()
}

/// Returns the number of decimals of a plain number; `None` for other text.
fn decimals(text: &str) -> Option<usize> {
    let digits = text.trim_start_matches(['-', '+', '\u{2212}']);
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let plain =
        !whole.is_empty() && (whole.chars().chain(fraction.chars())).all(|c| c.is_ascii_digit());
    plain.then_some(fraction.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_end_between_words() {
        assert_eq!(shortened("joint1.stiffness"), None);
        let long = "link1.izz + link2.iyy + 0.0998*link3.m + link4.m";
        assert_eq!(shortened(long).unwrap(), "link1.izz + link2.iyy + …");
        assert_eq!(shortened(&"x".repeat(50)).unwrap().chars().count(), 34);
    }

    #[test]
    fn only_plain_numbers_have_decimals() {
        assert_eq!(decimals("12.345"), Some(3));
        assert_eq!(decimals("\u{2212}7"), Some(0));
        for other in ["", "-", "1e-3", "3 %", "fixed", "1.2 ± 0.1"] {
            assert_eq!(decimals(other), None, "{other}");
        }
    }
}
