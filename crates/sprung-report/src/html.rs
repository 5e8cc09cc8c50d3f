//! Renders a document as one self-contained HTML file.

mod base64;
pub(super) mod error;
mod figures;
mod view;

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, UndefinedBehavior, Value, context};

use sprung_base::sha256::sha256;

use self::error::ReportError;
use super::document::{Block, Document};

const TEMPLATE: &str = include_str!("assets/report.html.jinja");
const STYLE: &str = include_str!("assets/report.css");
const SCRIPTS: [&str; 3] = [
    include_str!("assets/plots.js"),
    include_str!("assets/downloads.js"),
    include_str!("assets/report.js"),
];
const SKELETON_SCRIPT: &str = include_str!("assets/skeleton.js");
const PLOT_STYLE: &str = include_str!("assets/uplot/uPlot.min.css");
const PLOT_SCRIPT: &str = include_str!("assets/uplot/uPlot.iife.min.js");
const PLOT_LICENSE: &str = include_str!("assets/uplot/LICENSE");

/// Renders a document as one HTML file without references to other files.
///
/// # Errors
///
/// [`ReportError`] if a curve and its horizontal axis differ in length, or if the axis contains a
/// value that is not finite or decreases.
pub fn render(document: &Document) -> Result<String, ReportError> {
    let figures = figures::to_json(document)?;
    let verdict = document.verdict.as_ref().map_or_else(
        || Value::from(()),
        |badge| context! { tone => view::tone(badge.tone), text => badge.text.as_str() },
    );
    let script = script(document);
    let plot_script = plot_script();
    let hashes = script_hashes(&[&plot_script, &script])?;
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let syntax = SyntaxConfig::builder()
        .trim_blocks(true)
        .lstrip_blocks(true)
        .build()?;
    environment.set_syntax(syntax);
    // The name ends in `.html`, so the template engine escapes all texts.
    let page = environment.render_named_str(
        "report.html",
        TEMPLATE,
        context! {
            title => document.title.as_str(),
            subtitle => document.subtitle.as_str(),
            generator => document.generator.as_str(),
            verdict,
            summary => document.summary.as_str(),
            reason => document.reason.as_str(),
            avoid => &document.avoid,
            what_to_do => document.what_to_do.as_str(),
            sections => view::sections(document),
            figures => Value::from_safe_string(figures),
            style => Value::from_safe_string(STYLE.to_owned()),
            script_hashes => hashes,
            script => Value::from_safe_string(script),
            plot_style => Value::from_safe_string(PLOT_STYLE.to_owned()),
            plot_script => Value::from_safe_string(plot_script),
        },
    )?;
    Ok(page)
}

/// Returns the scripts that the blocks of a document need.
fn script(document: &Document) -> String {
    let mut blocks = document.sections.iter().flat_map(|section| &section.blocks);
    let moves = blocks.any(|block| matches!(block, Block::Skeleton(_)));
    let mut scripts = SCRIPTS.to_vec();
    scripts.extend(moves.then_some(SKELETON_SCRIPT));
    let all = scripts.join("\n");
    format!("\n\"use strict\";\n(() => {{\n{all}\n}})();\n")
}

/// Returns the script of the plots with its license.
fn plot_script() -> String {
    format!(
        "\n/*\nuPlot draws the plots of this page. Its license:\n\n{PLOT_LICENSE}\n*/\n{PLOT_SCRIPT}\n"
    )
}

/// Returns the sources of scripts that a browser runs: the hashes of the contents of their elements, so a script that
/// came from an input does not run.
fn script_hashes(scripts: &[&str]) -> Result<String, ReportError> {
    let mut sources = Vec::new();
    for script in scripts {
        let hash = sha256(script.as_bytes()).map_err(serde_json::Error::io)?;
        let digits: Vec<u32> = hash.chars().filter_map(|c| c.to_digit(16)).collect();
        let bytes: Vec<u8> = (digits.chunks(2))
            .map(|two| (two[0] << 4 | two[1]) as u8)
            .collect();
        sources.push(format!("'sha256-{}'", base64::encode(&bytes)));
    }
    Ok(sources.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{
        Badge, Block, Column, Figure, Finding, Fold, IntervalRow, Intervals, Line, Mark, Panel,
        Row, Section, Series, Style, Table, Tone,
    };
    use crate::rows::rows;

    const HOSTILE: &str = "<b>x</b></script><script>alert(1)</script>";

    /// Returns a document in which every text contains markup.
    fn hostile() -> Document {
        let text = || HOSTILE.to_owned();
        let table = Table {
            caption: text(),
            columns: vec![Column {
                heading: text(),
                numeric: true,
            }],
            rows: vec![Row {
                cells: vec![text()],
                tone: Tone::Bad,
            }],
            ..Table::default()
        };
        let figure = Figure {
            id: text(),
            caption: text(),
            x_label: text(),
            panels: vec![Panel {
                y_label: text(),
                x: vec![0.0, 1.0],
                series: vec![Series {
                    name: text(),
                    values: vec![Some(1.0), None],
                    style: Style::Measured,
                    clipped: false,
                }],
                errors: Some(text()),
                note: text(),
                marks: vec![Line {
                    at: 0.5,
                    text: text(),
                }],
            }],
            ..Figure::default()
        };
        let intervals = Intervals {
            caption: text(),
            names: vec![text()],
            ticks: vec![(0.0, text())],
            rows: vec![IntervalRow {
                group: text(),
                label: text(),
                scale: text(),
                marks: vec![None],
                tone: Tone::Doubtful,
            }],
            folded: true,
        };
        let finding = Finding {
            severity: Tone::Doubtful,
            code: text(),
            title: text(),
            text: text(),
            remedy: text(),
            cause: text(),
            condition: text(),
            ignore: text(),
        };
        Document {
            title: text(),
            subtitle: text(),
            generator: text(),
            verdict: Some(Badge {
                tone: Tone::Good,
                text: text(),
            }),
            summary: text(),
            reason: text(),
            avoid: vec![text()],
            what_to_do: text(),
            sections: vec![Section {
                id: text(),
                heading: text(),
                lead: text(),
                fold: Fold::Detail,
                blocks: vec![
                    Block::Paragraph(text()),
                    Block::Code(text()),
                    Block::KeyValues(vec![(text(), text())]),
                    Block::Table(table),
                    Block::Figure(figure),
                    Block::Intervals(intervals),
                    Block::Findings(vec![finding]),
                ],
            }],
        }
    }

    /// Returns the page of a document with one block.
    fn page_of(block: Block) -> String {
        let section = Section {
            blocks: vec![block],
            ..Section::default()
        };
        let document = Document {
            sections: vec![section],
            ..Document::default()
        };
        render(&document).unwrap()
    }

    #[test]
    fn no_text_becomes_markup() {
        let page = render(&hostile()).unwrap();
        let plain = render(&Document::default()).unwrap();
        assert!(!page.contains("<b>x"));
        assert!(!page.contains("alert(1)</"));
        assert!(page.contains("&lt;b&gt;x"));
        for tag in ["<script", "</script"] {
            assert_eq!(page.matches(tag).count(), plain.matches(tag).count());
        }
        assert_eq!(plain.matches("<script").count(), 3);
    }

    #[test]
    fn the_page_refers_to_nothing_outside() {
        let page = render(&hostile()).unwrap();
        // The first line of the plotting library contains its home page.
        let page = page.replacen("/*! https://github.com/leeoniya/uPlot", "", 1);
        for reference in ["http://", "https://", "src=", "@import", "url(", "<link"] {
            assert!(!page.contains(reference), "{reference}");
        }
        assert!(
            page.split("href=\"")
                .skip(1)
                .all(|rest| rest.starts_with('#'))
        );
    }

    #[test]
    fn marks_stand_where_their_values_do() {
        let mark = Mark {
            at: 0.5,
            interval: Some([0.25, 0.75]),
        };
        let intervals = Intervals {
            names: vec!["a".into(), "b".into()],
            rows: vec![IntervalRow {
                marks: vec![Some(mark), None],
                ..IntervalRow::default()
            }],
            ..Intervals::default()
        };
        let page = page_of(Block::Intervals(intervals));
        // CSS measures the left end from the left side and the right end from the right side.
        assert!(page.contains("class=\"bar c0\" style=\"left:62.50%;right:12.50%\""));
        assert!(page.contains("class=\"mark c0 m0\" style=\"left:75.00%\""));
        assert!(!page.contains("class=\"bar c1\""));
    }

    #[test]
    fn an_empty_document_is_a_page() {
        let page = render(&Document::default()).unwrap();
        assert!(page.starts_with("<!DOCTYPE html>"));
        assert!(page.contains("\"figures\":[]}</script>"));
        assert!(!page.contains("class=\"toc\""));
    }

    #[test]
    fn decimals_line_up_in_numeric_columns() {
        let table = rows(["1.25", "3", "fixed"]).number("value", str::to_owned);
        let page = page_of(Block::Table(table.table("")));
        assert!(page.contains("<td class=\"num\">1.25</td>"));
        assert!(page.contains("<td class=\"num whole\" style=\"--pad:2\">3</td>"));
        assert!(page.contains("<td class=\"num\">fixed</td>"));
    }

    #[test]
    fn the_meaning_of_a_finding_is_told_once() {
        let finding = |code: &str, cause: &str| Finding {
            code: code.into(),
            cause: cause.into(),
            ..Finding::default()
        };
        let section = |findings: Vec<Finding>| Section {
            blocks: vec![Block::Findings(findings)],
            ..Section::default()
        };
        let lost = "The recorder lost samples.";
        let document = Document {
            sections: vec![
                section(vec![finding("gaps", lost), finding("jitter", "Other.")]),
                section(vec![finding("gaps", lost), finding("unknown", "")]),
            ],
            ..Document::default()
        };
        let page = render(&document).unwrap();
        assert_eq!(page.matches(lost).count(), 1);
        assert_eq!(page.matches("id=\"meaning-").count(), 2);
        assert_eq!(page.matches("href=\"#meaning-gaps\"").count(), 1);
    }
}
