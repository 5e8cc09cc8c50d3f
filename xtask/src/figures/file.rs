//! The file of all figures, and the notes of one run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::steps::said;

/// All figures, part by part.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(super) struct Figures(pub(super) BTreeMap<String, Measured>);

/// One measurement of a part.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(super) struct Measured {
    pub(super) commit: String,
    /// Year, month and day.
    pub(super) date: String,
    pub(super) machine: String,
    /// In the order of the table.
    pub(super) figures: Vec<Figure>,
}

/// One figure, as a benchmark noted it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(super) struct Figure {
    pub(super) name: String,
    /// The case, in Markdown; empty for a figure that is compared with later ones and not shown in a table.
    pub(super) text: String,
    pub(super) value: f64,
    pub(super) unit: String,
    pub(super) better: Better,
    /// Scatter between runs, as a part of the value.
    pub(super) scatter: f64,
    /// Another program, and its value in the same unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) peer: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) peer_value: Option<f64>,
}

impl Measured {
    /// Returns a sentence about the measurement.
    pub(super) fn measured(&self, part: &str) -> String {
        format!(
            "Measured on {} at `{}` by `cargo xtask figures {part}` ({}).",
            self.date, self.commit, self.machine
        )
    }
}

/// Which values of a figure are better.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Better {
    Lower,
    Higher,
    None,
}

impl Figure {
    /// Returns the value with its unit.
    pub(super) fn shown(&self) -> String {
        with_unit(self.value, &self.unit)
    }

    /// Returns why this figure is worse than an earlier one by more than the scatter, if it is.
    fn worse_than(&self, earlier: &Self) -> Option<String> {
        let margin = self.scatter.max(earlier.scatter) * earlier.value.abs();
        let is_worse = match self.better {
            Better::Lower => self.value > earlier.value + margin,
            Better::Higher => self.value < earlier.value - margin,
            Better::None => false,
        };
        let (name, now, then) = (&self.name, self.shown(), earlier.shown());
        is_worse.then(|| format!("{name} is worse: {now} after {then}"))
    }
}

/// Returns a number with three digits and its unit; counts are whole.
pub(super) fn with_unit(value: f64, unit: &str) -> String {
    let number = if value != 0.0 && value.abs() < 1e-4 {
        format!("{value:.1e}")
    } else if value.fract() == 0.0 {
        format!("{value:.0}")
    } else {
        // At most six places: smaller values have an exponent.
        let digits = (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    };
    format!("{number} {unit}").trim_end().to_owned()
}

/// Reads the notes of a run, one object a line; a figure that is noted twice counts once, the last time.
pub(super) fn notes(text: &str) -> Option<Vec<Figure>> {
    let mut all: Vec<Figure> = Vec::new();
    for line in text.lines() {
        let figure: Figure = said(line, serde_json::from_str(line))?;
        match all.iter_mut().find(|known| known.name == figure.name) {
            Some(known) => *known = figure,
            None => all.push(figure),
        }
    }
    Some(all)
}

impl Figures {
    /// Returns the text of the file, each figure on one line, so that a difference shows the figures that changed.
    pub(super) fn text(&self) -> String {
        let parts: Vec<String> = (self.0.iter())
            .map(|(name, part)| {
                let lines: Vec<String> = (part.figures.iter())
                    // Keys of a `Value` are sorted.
                    .map(|figure| format!("      {}", json!(figure)))
                    .collect();
                let head = [
                    ("commit", &part.commit),
                    ("date", &part.date),
                    ("machine", &part.machine),
                ]
                .map(|(key, value)| format!("    \"{key}\": {},\n", Value::from(value.as_str())));
                let (name, head, lines) = (json!(name), head.concat(), lines.join(",\n"));
                format!("  {name}: {{\n{head}    \"figures\": [\n{lines}\n    ]\n  }}")
            })
            .collect();
        format!("{{\n{}\n}}\n", parts.join(",\n"))
    }

    /// Returns a figure by its name, `part/figure`.
    pub(super) fn get(&self, name: &str) -> Option<&Figure> {
        let (part, figure) = name.split_once('/')?;
        let figures = &self.0.get(part)?.figures;
        figures.iter().find(|known| known.name == figure)
    }

    /// Returns the figures that are worse than the stored ones; those of another machine are not compared.
    pub(super) fn worse(&self, part: &str, measured: &Measured) -> Vec<String> {
        let earlier = (self.0.get(part)).filter(|earlier| earlier.machine == measured.machine);
        let figures = earlier.iter().flat_map(|earlier| &earlier.figures);
        figures
            .filter_map(|earlier| {
                let same = |figure: &&Figure| figure.name == earlier.name;
                match measured.figures.iter().find(same) {
                    Some(figure) => figure.worse_than(earlier),
                    None => Some(format!("{} is no longer measured", earlier.name)),
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(value: f64, machine: &str) -> Measured {
        let line = format!(
            r#"{{"name": "clean", "text": "", "value": {value}, "unit": "%", "better": "lower", "scatter": 0.1,
                "peer": "NumPy", "peer_value": 2.0}}"#
        );
        Measured {
            commit: "0123abcd".into(),
            date: "2026-11-26".into(),
            machine: machine.into(),
            figures: notes(&line.replace('\n', "")).unwrap(),
        }
    }

    #[test]
    fn a_file_is_read_as_it_was_written() {
        let all = Figures([("twins".to_owned(), measured(0.39, "here"))].into());
        let read: Figures = serde_json::from_str(&all.text()).unwrap();
        assert_eq!(read, all);
        assert_eq!(all.get("twins/clean").unwrap().shown(), "0.39 %");
        assert_eq!(all.get("twins/other"), None);
    }

    #[test]
    fn a_figure_may_be_worse_by_its_scatter() {
        let all = Figures([("twins".to_owned(), measured(1.0, "here"))].into());
        let worse = |value, machine| all.worse("twins", &measured(value, machine));
        assert_eq!(worse(1.09, "here"), [""; 0]);
        assert_eq!(worse(1.11, "here"), ["clean is worse: 1.11 % after 1 %"]);
        assert_eq!(worse(1.11, "elsewhere"), [""; 0]);
        let mut without = measured(1.0, "here");
        without.figures.clear();
        let gone = all.worse("twins", &without);
        assert_eq!(gone, ["clean is no longer measured"]);
        assert_eq!(notes("{\"name\": \"clean\"}"), None);
    }

    #[test]
    fn numbers_have_three_digits() {
        for (value, unit, shown) in [
            (0.3914, "%", "0.391 %"),
            (1234.6, "MiB", "1235 MiB"),
            (12.0, "", "12"),
            (2.0e-9, "rad", "2.0e-9 rad"),
            (100.4, "%", "100 %"),
            (0.02104, "s", "0.021 s"),
        ] {
            assert_eq!(with_unit(value, unit), shown);
        }
    }
}
