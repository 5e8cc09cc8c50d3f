//! Converts the texts of a document to the values that the template expects.

use minijinja::{Value, context};

use super::super::document::{
    BarRow, Block, Document, Finding, IntervalRow, Layout, Row, Section, Table, Tone,
};

/// Returns the template values of all sections; the data of figures are separate.
pub(super) fn sections(document: &Document) -> Value {
    let mut figures = 0;
    document
        .sections
        .iter()
        .map(|section| section_view(section, &mut figures))
        .collect()
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

fn section_view(section: &Section, figures: &mut usize) -> Value {
    let blocks: Value = section
        .blocks
        .iter()
        .map(|block| block_view(block, figures))
        .collect();
    context! { id => section.id.as_str(), heading => section.heading.as_str(), lead => section.lead.as_str(), blocks }
}

fn block_view(block: &Block, figures: &mut usize) -> Value {
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
            let index = *figures;
            *figures += 1;
            let layout = match figure.layout {
                Layout::Stack => "stack",
                Layout::Grid => "grid",
            };
            context! { kind => "figure", id => figure.id.as_str(), caption => figure.caption.as_str(), layout, index }
        }
        Block::Intervals(shown) => {
            let rows: Value = shown.rows.iter().map(interval_row_view).collect();
            context! { kind => "intervals", caption => shown.caption.as_str(), names => &shown.names, rows }
        }
        Block::Bars(shown) => {
            let rows: Value = shown.rows.iter().map(bar_row_view).collect();
            let ticks: Value = (shown.ticks.iter())
                .map(|(at, text)| context! { at => part(*at), text })
                .collect();
            context! { kind => "bars", caption => shown.caption.as_str(), names => &shown.names, ticks, rows }
        }
        Block::Findings(findings) => {
            let findings: Value = findings.iter().map(finding_view).collect();
            context! { kind => "findings", findings }
        }
    }
}

/// Returns a row of intervals, with positions in percent of the row's width.
fn interval_row_view(row: &IntervalRow) -> Value {
    let percent = |x: f64| format!("{:.2}", 50.0 + 50.0 * x.clamp(-1.0, 1.0));
    let marks: Value = (row.marks.iter().enumerate())
        .map(|(lane, mark)| {
            let at = mark.map(|mark| percent(mark.at));
            let ends = mark.and_then(|mark| mark.interval);
            context! {
                color => lane % COLORS,
                shape => lane % SHAPES,
                at,
                low => ends.map(|ends| percent(ends[0])),
                high => ends.map(|ends| percent(-ends[1])),
            }
        })
        .collect();
    context! { label => row.label.as_str(), scale => row.scale.as_str(), marks }
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

/// Numbers of colours and of shapes of marks in the style sheet.
const COLORS: usize = 7;
const SHAPES: usize = 3;

fn finding_view(finding: &Finding) -> Value {
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
    let rows: Value = table
        .rows
        .iter()
        .map(|row| row_view(row, table, &places))
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
            let own = decimals(text);
            let pad = most.zip(own).map_or(0, |(most, own)| most - own);
            // A number without decimal point also needs space for the point.
            let whole = pad > 0 && own == Some(0);
            context! { text => text, numeric, pad, whole }
        })
        .collect();
    context! { tone => tone(row.tone), cells }
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
    fn only_plain_numbers_have_decimals() {
        assert_eq!(decimals("12.345"), Some(3));
        assert_eq!(decimals("\u{2212}7"), Some(0));
        for other in ["", "-", "1e-3", "3 %", "fixed", "1.2 ± 0.1"] {
            assert_eq!(decimals(other), None, "{other}");
        }
    }
}
