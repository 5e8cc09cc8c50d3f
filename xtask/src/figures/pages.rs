//! Figures in pages: tables and single values between marks that Markdown does not show.
//!
//! - `<!-- figures PART -->` … `<!-- end -->`: the table of a part; with `PART/BEGINNING` of the figures whose names
//!   begin so.
//! - `<!-- figure PART/NAME -->` … `<!-- end -->`: one value.
//!
//! A part that has not been measured yet keeps the text of the page.

use std::fs;

use super::file::{Figure, Figures, Measured};
use super::parts::PARTS;
use super::{FILE, fingerprint};
use crate::files::files;
use crate::root;

const END: &str = "<!-- end -->";

/// Writes the figures into all pages that request them.
pub(super) fn fill_all(figures: &Figures) -> Option<()> {
    let mut is_right = true;
    for page in files(&root(), "md") {
        let text = fs::read_to_string(&page).ok()?;
        match filled(&text, figures, &is_old) {
            Ok(new) if new == text => {}
            Ok(new) => fs::write(&page, new)
                .inspect_err(|error| eprintln!("── cannot write {}: {error}", page.display()))
                .ok()?,
            Err(fault) => {
                eprintln!("── {}: {fault}", page.display());
                is_right = false;
            }
        }
    }
    is_right.then_some(())
}

/// Returns whether the code has changed since a measurement.
pub(super) fn is_old(name: &str, measured: &Measured) -> bool {
    let part = PARTS.iter().find(|part| part.name == name);
    part.and_then(fingerprint) != Some(measured.code.clone())
}

/// Returns a page with the figures between its marks.
///
/// # Errors
///
/// If a mark has no end, or names an absent figure.
pub(super) fn filled(
    text: &str,
    figures: &Figures,
    is_old: &dyn Fn(&str, &Measured) -> bool,
) -> Result<String, String> {
    let mut page = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once("<!-- figure") {
        let (mark, behind) = (behind.split_once(" -->"))
            .ok_or_else(|| "a mark `<!-- figure` has no `-->`".to_owned())?;
        let (present, after) = (behind.split_once(END))
            .ok_or_else(|| format!("the mark `<!-- figure{mark} -->` lacks its `{END}`"))?;
        let value = if is_unmeasured(mark, figures) {
            present.to_owned()
        } else if let Some(part) = mark.strip_prefix("s ") {
            table(part, figures, is_old)?
        } else {
            let name = mark.trim();
            let figure = figures.get(name);
            figure
                .ok_or_else(|| format!("{FILE} has no figure {name}"))?
                .shown()
        };
        page.extend([before, "<!-- figure", mark, " -->", &value, END]);
        rest = after;
    }
    page.push_str(rest);
    Ok(page)
}

/// Returns whether a mark names a part that has not been measured yet; the page keeps its text.
fn is_unmeasured(mark: &str, figures: &Figures) -> bool {
    let name = mark.trim_start_matches("s ").trim();
    let part = name.split_once('/').map_or(name, |(part, _)| part);
    !figures.parts.contains_key(part) && PARTS.iter().any(|known| known.name == part)
}

/// Returns the table of a part or of some of its figures, and one line about the measurement.
fn table(
    mark: &str,
    figures: &Figures,
    is_old: &dyn Fn(&str, &Measured) -> bool,
) -> Result<String, String> {
    let (name, beginning) = mark.split_once('/').unwrap_or((mark, ""));
    let part = (figures.parts.get(name)).ok_or_else(|| format!("{FILE} has no part {name}"))?;
    let is_shown = |figure: &&Figure| !figure.text.is_empty() && figure.name.starts_with(beginning);
    let shown = || part.figures.iter().filter(is_shown);
    if shown().next().is_none() {
        return Err(format!("{FILE} has no figures {mark}"));
    }
    let has_peer = shown().any(|figure| figure.peer.is_some());
    let mut lines = vec![String::new(), String::new()];
    if has_peer {
        lines.push("| case | sprung | compared with | ratio |\n|---|---|---|---|".into());
    } else {
        lines.push("| case | figure |\n|---|---|".into());
    }
    lines.extend(shown().map(|figure| row(figure, has_peer)));
    let age = if is_old(name, part) {
        " **The code has changed since.**"
    } else {
        ""
    };
    lines.push(format!(
        "\nMeasured on {} at `{}` by `{}` ({} minutes; {}).{age}\n",
        part.date, part.commit, part.command, part.minutes, part.machine
    ));
    Ok(lines.join("\n"))
}

fn row(figure: &Figure, has_peer: bool) -> String {
    let Figure { text, value, .. } = figure;
    if !has_peer {
        return format!("| {text} | {} |", figure.shown());
    }
    let peer = figure.peer_shown().unwrap_or_default();
    let ratio = (figure.peer.as_ref()).map_or_else(String::new, |(_, peer)| {
        let ratio = peer / value;
        if ratio >= 10.0 {
            format!("{ratio:.0}")
        } else {
            format!("{ratio:.2}")
        }
    });
    format!("| {text} | {} | {peer} | {ratio} |", figure.shown())
}

#[cfg(test)]
mod tests {
    use super::super::git;
    use super::*;

    fn figures() -> Figures {
        let figure = |name: &str, peer| Figure {
            name: name.into(),
            text: format!("the case `{name}`"),
            value: 0.4,
            unit: "%".into(),
            better: "lower".into(),
            scatter: 0.0,
            peer,
        };
        let measured = Measured {
            command: "cargo xtask figures twins".into(),
            commit: "0123abcd".into(),
            date: "2026-11-26".into(),
            machine: "here".into(),
            code: "00ff".into(),
            minutes: 5.0,
            figures: vec![
                figure("a", None),
                figure("b", Some(("NumPy".to_owned(), 2.0))),
                Figure {
                    text: String::new(),
                    ..figure("c", None)
                },
            ],
        };
        Figures {
            parts: [("twins".to_owned(), measured)].into(),
        }
    }

    #[test]
    fn marks_are_filled_again_and_again() {
        let page =
            "Error <!-- figure twins/a --><!-- end -->.\n<!-- figures twins -->old<!-- end -->\n";
        let new = filled(page, &figures(), &|_, _| false).unwrap();
        assert!(
            new.starts_with("Error <!-- figure twins/a -->0.4 %<!-- end -->.\n"),
            "{new}"
        );
        assert!(
            new.contains("\n| the case `b` | 0.4 % | NumPy: 2 % | 5.00 |\n"),
            "{new}"
        );
        assert!(!new.contains("old") && !new.contains("changed"), "{new}");
        assert_eq!(new.matches("the case").count(), 2, "{new}");
        assert_eq!(filled(&new, &figures(), &|_, _| false).unwrap(), new);
        let some = filled(
            "<!-- figures twins/b --><!-- end -->",
            &figures(),
            &|_, _| false,
        );
        let some = some.unwrap();
        assert!(
            some.contains("case `b`") && !some.contains("case `a`"),
            "{some}"
        );
        let older = filled(&new, &figures(), &|_, _| true).unwrap();
        assert!(older.contains("**The code has changed since.**"), "{older}");
    }

    #[test]
    fn a_part_that_is_not_measured_keeps_its_text() {
        let page =
            "<!-- figures verdicts -->earlier<!-- end --> <!-- figure speed/a -->1 s<!-- end -->";
        assert_eq!(filled(page, &figures(), &|_, _| false).unwrap(), page);
    }

    #[test]
    fn a_page_that_asks_for_an_absent_figure_is_wrong() {
        for (page, fault) in [
            ("<!-- figure twins/d --><!-- end -->", "no figure twins/d"),
            ("<!-- figures others --><!-- end -->", "no part others"),
            ("<!-- figures twins/x --><!-- end -->", "no figures twins/x"),
            ("<!-- figure twins/a -->", "lacks its"),
            ("<!-- figure twins/a", "no `-->`"),
        ] {
            let found = filled(page, &figures(), &|_, _| false).unwrap_err();
            assert!(found.contains(fault), "{found}");
        }
    }

    #[test]
    fn pages_have_the_figures_of_the_file() {
        if git(&["rev-parse", "HEAD"]).is_none() {
            eprintln!("SKIPPED figures of the pages: this is no checkout of git");
            return;
        }
        let figures = Figures::read(&root().join(FILE)).unwrap();
        for page in files(&root(), "md") {
            let text = fs::read_to_string(&page).unwrap();
            match filled(&text, &figures, &is_old) {
                Ok(new) => assert!(
                    new == text,
                    "{} has other figures than {FILE}, or does not say that the code has changed: run cargo xtask docs",
                    page.display()
                ),
                Err(fault) => panic!("{}: {fault}", page.display()),
            }
        }
    }
}
