//! The file of all figures, and the notes of one run.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::{Map, Value, json};

/// All figures, part by part.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Figures {
    pub(super) parts: BTreeMap<String, Measured>,
}

/// One measurement of a part.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measured {
    pub(super) command: String,
    pub(super) commit: String,
    /// Year, month and day.
    pub(super) date: String,
    pub(super) machine: String,
    /// Fingerprint of the measured code.
    pub(super) code: String,
    pub(super) minutes: f64,
    /// In the order of the table.
    pub(super) figures: Vec<Figure>,
}

/// One figure, as a benchmark noted it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Figure {
    pub(super) name: String,
    /// The case, in Markdown; empty for a figure that is compared with later ones and not shown in a table.
    pub(super) text: String,
    pub(super) value: f64,
    pub(super) unit: String,
    /// `lower`, `higher`, or `none` if neither is better.
    pub(super) better: String,
    /// Scatter between runs, as a part of the value.
    pub(super) scatter: f64,
    /// Another program, and its value in the same unit.
    pub(super) peer: Option<(String, f64)>,
}

impl Figure {
    /// Returns the value with its unit.
    pub(super) fn shown(&self) -> String {
        with_unit(self.value, &self.unit)
    }

    /// Returns the value of the other program, with its unit and name.
    pub(super) fn peer_shown(&self) -> Option<String> {
        let (name, value) = self.peer.as_ref()?;
        Some(format!("{name}: {}", with_unit(*value, &self.unit)))
    }

    fn read(value: &Value) -> Option<Self> {
        let word = |key: &str| value[key].as_str().map(str::to_owned);
        let peer = || Some((word("peer")?, value["peer_value"].as_f64()?));
        Some(Self {
            name: word("name")?,
            text: word("text")?,
            value: value["value"].as_f64()?,
            unit: word("unit")?,
            better: word("better")?,
            scatter: value["scatter"].as_f64()?,
            peer: peer(),
        })
    }

    fn line(&self) -> String {
        let mut line = json!({
            "name": self.name, "text": self.text, "value": self.value, "unit": self.unit,
            "better": self.better, "scatter": self.scatter,
        });
        if let Some((name, value)) = &self.peer {
            line["peer"] = json!(name);
            line["peer_value"] = json!(value);
        }
        line.to_string()
    }

    /// Returns why this figure is worse than an earlier one by more than the scatter, if it is.
    fn worse_than(&self, earlier: &Self) -> Option<String> {
        let margin = self.scatter.max(earlier.scatter) * earlier.value.abs();
        let is_worse = match self.better.as_str() {
            "lower" => self.value > earlier.value + margin,
            "higher" => self.value < earlier.value - margin,
            _ => false,
        };
        is_worse.then(|| {
            format!(
                "{} is worse: {} after {}",
                self.name,
                self.shown(),
                earlier.shown()
            )
        })
    }
}

/// Returns a number with three digits and its unit; counts are whole.
fn with_unit(value: f64, unit: &str) -> String {
    let digits = if value == 0.0 || !value.is_finite() {
        0
    } else {
        // At most six places: smaller values have an exponent.
        (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize
    };
    let number = if value != 0.0 && value.abs() < 1e-4 {
        format!("{value:.1e}")
    } else if value.fract() == 0.0 {
        format!("{value:.0}")
    } else {
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    };
    match unit {
        "" => number,
        "times" => format!("{number} times"),
        unit => format!("{number} {unit}"),
    }
}

/// Reads the notes of a run, one object a line; a figure that is noted twice counts once, the last time.
pub(super) fn notes(text: &str) -> Option<Vec<Figure>> {
    let mut all: Vec<Figure> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let value: Option<Value> = serde_json::from_str(line).ok();
        let Some(figure) = value.as_ref().and_then(Figure::read) else {
            eprintln!("── line {} of the notes is no figure: {line}", index + 1);
            return None;
        };
        match all.iter_mut().find(|known| known.name == figure.name) {
            Some(known) => *known = figure,
            None => all.push(figure),
        }
    }
    Some(all)
}

impl Figures {
    /// Reads the file; an absent file has no figures.
    pub(super) fn read(path: &Path) -> Option<Self> {
        if !path.exists() {
            return Some(Self::default());
        }
        let text = fs::read_to_string(path)
            .inspect_err(|error| eprintln!("── cannot read {}: {error}", path.display()))
            .ok()?;
        let read = Self::of(&text);
        if read.is_none() {
            eprintln!("── {} is no file of figures", path.display());
        }
        read
    }

    fn of(text: &str) -> Option<Self> {
        let all: Value = serde_json::from_str(text).ok()?;
        let mut parts = BTreeMap::new();
        for (name, part) in all.as_object()? {
            let word = |key: &str| part[key].as_str().map(str::to_owned);
            let figures: Option<Vec<Figure>> = part["figures"]
                .as_array()?
                .iter()
                .map(Figure::read)
                .collect();
            let measured = Measured {
                command: word("command")?,
                commit: word("commit")?,
                date: word("date")?,
                machine: word("machine")?,
                code: word("code")?,
                minutes: part["minutes"].as_f64()?,
                figures: figures?,
            };
            parts.insert(name.clone(), measured);
        }
        Some(Self { parts })
    }

    /// Writes the file, each figure on one line, so that a difference shows the figures that changed.
    pub(super) fn write(&self, path: &Path) -> Option<()> {
        let temporary = path.with_extension("json.tmp");
        let written =
            fs::write(&temporary, self.text()).and_then(|()| fs::rename(&temporary, path));
        written
            .inspect_err(|error| eprintln!("── cannot write {}: {error}", path.display()))
            .ok()
    }

    fn text(&self) -> String {
        let parts: Vec<String> = (self.parts.iter())
            .map(|(name, part)| {
                let mut head = Map::new();
                head.insert("command".into(), json!(part.command));
                head.insert("commit".into(), json!(part.commit));
                head.insert("date".into(), json!(part.date));
                head.insert("machine".into(), json!(part.machine));
                head.insert("code".into(), json!(part.code));
                head.insert("minutes".into(), json!(part.minutes));
                let head: Vec<String> = (head.iter())
                    .map(|(key, value)| format!("    {}: {value}", json!(key)))
                    .collect();
                let lines: Vec<String> = (part.figures.iter())
                    .map(|figure| format!("      {}", figure.line()))
                    .collect();
                format!(
                    "  {}: {{\n{},\n    \"figures\": [\n{}\n    ]\n  }}",
                    json!(name),
                    head.join(",\n"),
                    lines.join(",\n")
                )
            })
            .collect();
        format!("{{\n{}\n}}\n", parts.join(",\n"))
    }

    /// Returns a figure by its name, `part/figure`.
    pub(super) fn get(&self, name: &str) -> Option<&Figure> {
        let (part, figure) = name.split_once('/')?;
        let figures = &self.parts.get(part)?.figures;
        figures.iter().find(|known| known.name == figure)
    }

    /// Returns the figures that are worse than the stored ones; those of another machine are not compared.
    pub(super) fn worse(&self, part: &str, measured: &Measured) -> Vec<String> {
        let earlier = (self.parts.get(part)).filter(|earlier| earlier.machine == measured.machine);
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

    fn figure(value: f64) -> Figure {
        Figure {
            name: "clean".into(),
            text: "least squares, `weights`".into(),
            value,
            unit: "%".into(),
            better: "lower".into(),
            scatter: 0.1,
            peer: Some(("NumPy".into(), 2.0)),
        }
    }

    fn figures(value: f64, machine: &str) -> Figures {
        let measured = Measured {
            command: "cargo xtask figures twins".into(),
            commit: "0123abcd".into(),
            date: "2026-11-26".into(),
            machine: machine.into(),
            code: "00ff".into(),
            minutes: 5.0,
            figures: vec![figure(value)],
        };
        Figures {
            parts: [("twins".to_owned(), measured)].into(),
        }
    }

    #[test]
    fn a_file_is_read_as_it_was_written() {
        let all = figures(0.39, "here");
        assert_eq!(Figures::of(&all.text()), Some(all.clone()));
        assert_eq!(
            all.get("twins/clean").map(Figure::shown).as_deref(),
            Some("0.39 %")
        );
        assert_eq!(all.get("twins/other"), None);
        assert_eq!(Figures::of("{\"twins\": {}}"), None);
    }

    #[test]
    fn a_figure_may_be_worse_by_its_scatter() {
        let all = figures(1.0, "here");
        let worse = |value, machine| all.worse("twins", &figures(value, machine).parts["twins"]);
        assert_eq!(worse(1.09, "here"), [""; 0]);
        assert_eq!(worse(1.11, "here"), ["clean is worse: 1.11 % after 1 %"]);
        assert_eq!(worse(1.11, "elsewhere"), [""; 0]);
        let mut without = figures(1.0, "here").parts["twins"].clone();
        without.figures.clear();
        assert_eq!(
            all.worse("twins", &without),
            ["clean is no longer measured"]
        );
    }

    #[test]
    fn numbers_have_three_digits() {
        for (value, unit, shown) in [
            (0.3914, "%", "0.391 %"),
            (1234.6, "MiB", "1235 MiB"),
            (12.0, "", "12"),
            (2.0e-9, "rad", "2.0e-9 rad"),
            (0.0, "%", "0 %"),
            (2.5, "times", "2.5 times"),
            (100.4, "%", "100 %"),
            (0.02104, "s", "0.021 s"),
        ] {
            assert_eq!(with_unit(value, unit), shown);
        }
    }

    #[test]
    fn a_wrong_note_is_refused() {
        let line = figure(1.0).line();
        assert_eq!(notes(&format!("{line}\n{line}\n")), Some(vec![figure(1.0)]));
        assert_eq!(notes("{\"name\": \"clean\"}"), None);
    }
}
