//! Figures in pages: tables and single values between marks that Markdown does not show.
//!
//! - `<!-- figures PART -->` … `<!-- end -->`: the table of a part; with `PART/BEGINNING` of the figures whose names
//!   begin so.
//! - `<!-- figures chart/NAME -->` … `<!-- end -->`: the table of a chart of `plots/catalogue.rs`.
//! - `<!-- figure PART/NAME -->` … `<!-- end -->`: one value.

use std::fs;

use super::FILE;
use super::file::{Figure, Figures, with_unit};
use super::plots;
use crate::files::{files, write};
use crate::root;

const END: &str = "<!-- end -->";

/// Columns of a table, at most.
const MAX_QUANTITIES: usize = 6;

/// Writes the figures into all pages that request them.
pub(super) fn fill_all(figures: &Figures) -> Option<()> {
    let mut is_right = true;
    for page in files(&root(), "md") {
        let text = fs::read_to_string(&page).ok()?;
        match filled(&text, figures) {
            Ok(new) if new == text => {}
            Ok(new) => write(&page, &new)?,
            Err(fault) => {
                eprintln!("── {}: {fault}", page.display());
                is_right = false;
            }
        }
    }
    is_right.then_some(())
}

/// Returns a page with the figures between its marks.
///
/// # Errors
///
/// If a mark has no end, or names an absent figure.
fn filled(text: &str, figures: &Figures) -> Result<String, String> {
    let mut page = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once("<!-- figure") {
        let (mark, behind) = (behind.split_once(" -->"))
            .ok_or_else(|| "a mark `<!-- figure` has no `-->`".to_owned())?;
        let (_, after) = (behind.split_once(END))
            .ok_or_else(|| format!("the mark `<!-- figure{mark} -->` lacks its `{END}`"))?;
        let value = match (mark.strip_prefix("s chart/"), mark.strip_prefix("s ")) {
            (Some(chart), _) => Some(plots::table(chart, figures)?),
            (None, Some(part)) => table(part, figures),
            (None, None) => figures.get(mark.trim()).map(Figure::shown),
        };
        let value = value.ok_or_else(|| format!("{FILE} has no figure {}", mark.trim()))?;
        page.extend([before, "<!-- figure", mark, " -->", &value, END]);
        rest = after;
    }
    page.push_str(rest);
    Ok(page)
}

/// Returns the table of a part or of some of its figures, and one line about the measurement.
fn table(mark: &str, figures: &Figures) -> Option<String> {
    let (name, beginning) = mark.split_once('/').unwrap_or((mark, ""));
    let part = figures.0.get(name)?;
    let is_shown = |figure: &&Figure| !figure.text.is_empty() && figure.name.starts_with(beginning);
    let shown: Vec<&Figure> = part.figures.iter().filter(is_shown).collect();
    shown.first()?;
    let rows = if shown.iter().any(|figure| figure.peer.is_some()) {
        let peers = || shown.iter().filter_map(|figure| figure.peer.as_deref());
        let peer = peers().next();
        beside(
            &shown,
            peer.filter(|peer| peers().all(|other| other == *peer)),
        )
    } else {
        by_quantity(&shown)
    };
    let mut lines: Vec<String> = rows
        .iter()
        .map(|row| format!("| {} |", row.join(" | ")))
        .collect();
    lines.insert(1, "|---".repeat(rows[0].len()) + "|");
    let measured = part.measured(name);
    Some(format!("\n\n{}\n\n{measured}\n", lines.join("\n")))
}

/// Returns a table with a row for each case and a column for each quantity, the part of a text after its last colon;
/// if no case has several quantities, the rows have the whole texts.
fn by_quantity(figures: &[&Figure]) -> Vec<Vec<String>> {
    let parts = |figure: &Figure| -> (String, String) {
        let (case, quantity) = figure
            .text
            .rsplit_once(": ")
            .unwrap_or((&figure.text, "figure"));
        (case.to_owned(), quantity.to_owned())
    };
    let (mut cases, mut quantities): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    for (case, quantity) in figures.iter().map(|figure| parts(figure)) {
        if !cases.contains(&case) {
            cases.push(case);
        }
        if !quantities.contains(&quantity) {
            quantities.push(quantity);
        }
    }
    if cases.len() == figures.len() && quantities.len() > 1 || quantities.len() > MAX_QUANTITIES {
        let rows = figures
            .iter()
            .map(|figure| vec![figure.text.clone(), figure.shown()]);
        return [vec!["case".to_owned(), "figure".to_owned()]]
            .into_iter()
            .chain(rows)
            .collect();
    }
    let rows = cases.iter().map(|case| {
        let cell = |quantity: &String| {
            let is_here = |figure: &&&Figure| parts(figure) == (case.clone(), quantity.clone());
            figures
                .iter()
                .find(is_here)
                .map_or_else(String::new, |figure| figure.shown())
        };
        [case.clone()]
            .into_iter()
            .chain(quantities.iter().map(cell))
            .collect()
    });
    let head = [vec!["case".to_owned()], quantities.clone()].concat();
    [head].into_iter().chain(rows).collect()
}

/// Returns a table that compares figures with those of other programs.
///
/// - `peer`: the name of the program if it is the same for all figures.
fn beside(figures: &[&Figure], peer: Option<&str>) -> Vec<Vec<String>> {
    let head = ["case", "sprung", peer.unwrap_or("compared with"), "ratio"].map(str::to_owned);
    let rows = figures.iter().map(|figure| {
        let (other, ratio) = match (&figure.peer, figure.peer_value) {
            (Some(name), Some(value)) => {
                let name = if peer.is_some() {
                    String::new()
                } else {
                    format!("{name}: ")
                };
                let ratio = value / figure.value;
                let digits = if ratio >= 10.0 { 0 } else { 2 };
                (
                    name + &with_unit(value, &figure.unit),
                    format!("{ratio:.digits$}"),
                )
            }
            _ => (String::new(), String::new()),
        };
        vec![figure.text.clone(), figure.shown(), other, ratio]
    });
    [head.to_vec()].into_iter().chain(rows).collect()
}

#[cfg(test)]
mod tests {
    use super::super::file::{Measured, notes};
    use super::*;

    fn figures() -> Figures {
        let line = |name: &str, text: &str, peer: &str| {
            format!(
                r#"{{"name": "{name}", "text": "{text}", "value": 0.4, "unit": "%", "better": "lower", "scatter": 0.0{peer}}}"#
            )
        };
        let peer = r#", "peer": "NumPy", "peer_value": 2.0"#;
        let lines = [
            line("a", "clean: error", ""),
            line("a2", "clean: bias", ""),
            line("b", "the case `b`", peer),
            line("c", "", ""),
        ];
        let measured = Measured {
            commit: "0123abcd".into(),
            date: "2026-11-26".into(),
            machine: "here".into(),
            figures: notes(&lines.join("\n")).unwrap(),
        };
        Figures([("twins".to_owned(), measured)].into())
    }

    #[test]
    fn marks_are_filled_again_and_again() {
        let page = "Error <!-- figure twins/a --><!-- end -->.\n<!-- figures twins/a -->old<!-- end -->\n\
            <!-- figures twins/b --><!-- end -->";
        let new = filled(page, &figures()).unwrap();
        assert!(
            new.starts_with("Error <!-- figure twins/a -->0.4 %<!-- end -->.\n"),
            "{new}"
        );
        let table = "\n| case | error | bias |\n|---|---|---|\n| clean | 0.4 % | 0.4 % |\n";
        assert!(new.contains(table) && !new.contains("old"), "{new}");
        let table = "\n| case | sprung | NumPy | ratio |\n|---|---|---|---|\n| the case `b` | 0.4 % | 2 % | 5.00 |\n";
        assert!(new.contains(table), "{new}");
        assert_eq!(filled(&new, &figures()).unwrap(), new);
    }

    #[test]
    fn a_page_that_asks_for_an_absent_figure_is_wrong() {
        for (page, fault) in [
            ("<!-- figure twins/d --><!-- end -->", "no figure twins/d"),
            ("<!-- figures others --><!-- end -->", "no figure s others"),
            ("<!-- figure twins/a -->", "lacks its"),
            ("<!-- figure twins/a", "no `-->`"),
        ] {
            let found = filled(page, &figures()).unwrap_err();
            assert!(found.contains(fault), "{found}");
        }
    }

    #[test]
    fn no_mark_of_a_value_begins_a_line() {
        // A comment at the beginning of a line ends the paragraph on GitHub.
        for page in files(&root(), "md") {
            let text = fs::read_to_string(&page).unwrap();
            let wrong = (text.lines()).find(|line| line.trim_start().starts_with("<!-- figure "));
            assert_eq!(wrong, None, "{}", page.display());
        }
    }

    #[test]
    fn pages_have_the_figures_of_the_file() {
        let figures: Figures = crate::files::json(&root().join(FILE)).unwrap();
        if std::env::var_os("SPRUNG_WRITE_DOCS").is_some() {
            fill_all(&figures).unwrap();
        }
        for page in files(&root(), "md") {
            let text = fs::read_to_string(&page).unwrap();
            let new = filled(&text, &figures).unwrap_or_else(|fault| panic!("{fault}"));
            let page = page.display();
            assert!(
                new == text,
                "{page} has other figures than {FILE}: run cargo xtask docs"
            );
        }
    }
}
