//! Composes the table of what a log shows beyond its description.

use super::document::{Block, Section};
use super::numbers::{dash_if_none, significant};
use super::refined_delays::as_exact;
use super::rows::rows;
use super::section::section;
use sprung_method::unknowns::{UnknownResult, UnknownStatus};

/// An unknown in the form of tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownUnknown {
    /// What differs, as in `delay`.
    pub what: String,
    /// Column, or the signal of all joints.
    pub place: String,
    /// Size with its standard error and unit: ms, mrad, mm, or percent of a reading.
    pub size: String,
    /// What sprung did with it.
    pub used: &'static str,
    /// Fall of the squared error of the torques on held-out parts of the log, percent; a dash if it was not compared.
    pub falls_percent: String,
    /// Other unknowns that explain the log nearly as well, with their correlations.
    pub competing: String,
}

impl ShownUnknown {
    /// Heading of the table.
    pub const HEADING: &str = "What the log shows beyond its description";
}

impl From<&UnknownResult> for ShownUnknown {
    fn from(unknown: &UnknownResult) -> Self {
        let rivals = unknown.competing.iter();
        let rivals: Vec<String> = rivals
            .map(|rival| format!("{} ({:.2})", rival.id, rival.correlation))
            .collect();
        Self {
            what: what(unknown),
            place: place(unknown),
            size: size(unknown),
            used: unknown.status.word(),
            falls_percent: match unknown.effect {
                0.0 => "–".to_owned(),
                effect => format!("{:.0}", 100.0 * effect),
            },
            competing: rivals.join(", "),
        }
    }
}

/// Returns the kind in words, with what tells two of one place apart.
fn what(unknown: &UnknownResult) -> String {
    if let Some(law) = &unknown.law {
        return law.words();
    }
    let kind = unknown.kind.replace('-', " ");
    match unknown.begins_s {
        Some(begins) => format!("{kind} {} s", significant(begins, 3)),
        None => kind,
    }
}

/// Returns the column; for several columns the signal that they have in common.
fn place(unknown: &UnknownResult) -> String {
    if !unknown.place.contains(", ") {
        return unknown.place.clone();
    }
    let signal = unknown
        .id
        .split_once(" all ")
        .or(unknown.id.split_once(" of the "));
    signal.map_or_else(
        || unknown.place.clone(),
        |(_, signal)| format!("all {signal}"),
    )
}

fn size(unknown: &UnknownResult) -> String {
    let (factor, unit) = match unknown.unit.as_str() {
        "s" => (1e3, "ms"),
        "rad" => (1e3, "mrad"),
        "m" => (1e3, "mm"),
        "" => (1e2, "%"),
        unit => (1.0, unit),
    };
    let error = factor * unknown.standard_error;
    format!(
        "{} ± {} {unit}",
        as_exact(factor * unknown.value, error),
        significant(error, 2)
    )
}

/// Composes the section; `None` if nothing was found.
pub(super) fn unknowns(found: &[UnknownResult]) -> Option<Section> {
    let shown: Vec<(&UnknownResult, ShownUnknown)> = (found.iter())
        .map(|unknown| (unknown, ShownUnknown::from(unknown)))
        .collect();
    let table = rows(&shown)
        .text("Unknown", |(_, shown)| &shown.what)
        .text("Place", |(_, shown)| &shown.place)
        .number("Size ± s.e.", |(_, shown)| &shown.size)
        .text("Used", |(_, shown)| shown.used)
        .number("Error falls by [%]", |(_, shown)| &shown.falls_percent)
        .text("The log does not tell it from", |(_, shown)| {
            dash_if_none(Some(shown.competing.clone()).filter(|names| !names.is_empty()))
        })
        .marked(|(unknown, _)| unknown.status == UnknownStatus::Found)
        .table_if_any(
            "Sizes with their standard errors: the time by which a column is late; otherwise what a correction adds to the \
             column, for a gain relative to it. The error is the square of the torques' error on parts of the log that \
             the fit has not seen. Others explain the log nearly as well; the number is the correlation of both effects. \
             Marked rows are not corrected.",
        );
    table.map(|table| {
        section(
            "unknowns",
            ShownUnknown::HEADING,
            "These causes explain the log better than its description alone. \"Given\" and \"estimated\" come from the \
             experiment file. \"Applied\" means that all results use it. \"Found\" means that the results do not use it: mend \
             the cause, or set it in the experiment file.",
            vec![Block::Table(table)],
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use sprung_method::unknowns::{AddedLaw, CompetingUnknown};

    fn unknown(id: &str, kind: &str, place: &str, unit: &str) -> UnknownResult {
        UnknownResult {
            id: id.to_owned(),
            kind: kind.to_owned(),
            place: place.to_owned(),
            value: 0.005_012,
            standard_error: 0.000_023,
            unit: unit.to_owned(),
            begins_s: None,
            law: None,
            status: UnknownStatus::Applied,
            competing: Vec::new(),
            effect: 0.417,
        }
    }

    #[test]
    fn units_and_places_are_those_of_readers() {
        let shown = |unknown: &UnknownResult| {
            let shown = ShownUnknown::from(unknown);
            [shown.what, shown.place, shown.size]
        };
        let delay = unknown("delay q1_rad", "delay", "q1_rad", "s");
        assert_eq!(shown(&delay), ["delay", "q1_rad", "5.012 ± 0.023 ms"]);
        let all = unknown("delay all link positions", "delay", "q1_rad, q2_rad", "s");
        assert_eq!(shown(&all)[1], "all link positions");
        let timing = unknown("timing of the torques", "timing", "tau1, tau2", "s");
        assert_eq!(shown(&timing)[1], "all torques");
        let gain = unknown("gain q1_rad", "gain", "q1_rad", "");
        assert_eq!(shown(&gain)[2], "0.5012 ± 0.0023 %");
        let jump = UnknownResult {
            begins_s: Some(3.0),
            ..unknown("lost counts q1_rad 4", "lost-counts", "q1_rad", "rad")
        };
        assert_eq!(shown(&jump)[0], "lost counts 3.00 s");
        let law = UnknownResult {
            law: Some(AddedLaw {
                of: "motor_friction".to_owned(),
                law: "stribeck".to_owned(),
                stribeck_velocity: Some(0.04),
                ..AddedLaw::default()
            }),
            ..unknown("law a1.motor_friction.stribeck", "law", "a1", "N·m")
        };
        assert_eq!(shown(&law)[..2], ["motor_friction \"stribeck\"", "a1"]);
    }

    #[test]
    fn a_section_names_rivals() {
        assert_eq!(unknowns(&[]), None);
        let rival = CompetingUnknown {
            id: "delay tau1".to_owned(),
            correlation: -0.91,
        };
        let delay = UnknownResult {
            competing: vec![rival],
            ..unknown("delay q1_rad", "delay", "q1_rad", "s")
        };
        let section = unknowns(&[delay]).unwrap();
        let table = section.blocks[0].table().unwrap();
        assert_eq!(table.rows[0].cells[4..], ["42", "delay tau1 (-0.91)"]);
    }
}
