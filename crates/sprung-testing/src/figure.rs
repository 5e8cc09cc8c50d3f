//! Figures that a benchmark notes for the documentation.

use std::io::Write;

/// A measured number for the documentation.
///
/// [`Figure::note`] appends it to the file that `SPRUNG_FIGURES` names, as a line of JSON.
/// `cargo xtask figures` reads these lines.
#[derive(Clone, Debug)]
pub struct Figure {
    name: String,
    text: String,
    value: f64,
    unit: String,
    better: &'static str,
    scatter: f64,
    peer: Option<(String, f64)>,
}

/// Numbers that depend on no clock repeat to the last digit on one machine; another version of a
/// library may move them a little.
const SCATTER: f64 = 0.02;

/// Scatter of processor times of one machine.
const SCATTER_OF_TIMES: f64 = 0.25;

impl Figure {
    /// Returns a figure for which smaller is better.
    ///
    /// - `name`: key of the figure in its part.
    /// - `text`: the case, in Markdown.
    /// - `unit`: unit of `value`; empty for a count.
    #[must_use]
    pub fn lower(name: &str, text: &str, value: f64, unit: &str) -> Self {
        Self::new("lower", name, text, value, unit)
    }

    /// Returns a figure for which larger is better; the arguments are those of [`Figure::lower`].
    #[must_use]
    pub fn higher(name: &str, text: &str, value: f64, unit: &str) -> Self {
        Self::new("higher", name, text, value, unit)
    }

    /// Returns a figure that is neither better nor worse; the arguments are those of [`Figure::lower`].
    #[must_use]
    pub fn neutral(name: &str, text: &str, value: f64, unit: &str) -> Self {
        Self::new("none", name, text, value, unit)
    }

    fn new(better: &'static str, name: &str, text: &str, value: f64, unit: &str) -> Self {
        Self {
            name: name.to_owned(),
            text: text.to_owned(),
            value,
            unit: unit.to_owned(),
            better,
            scatter: if ["s", "ms", "µs"].contains(&unit) {
                SCATTER_OF_TIMES
            } else {
                SCATTER
            },
            peer: None,
        }
    }

    /// Returns the figure with another scatter between runs, as a part of the value.
    #[must_use]
    pub fn scatter(mut self, scatter: f64) -> Self {
        self.scatter = scatter;
        self
    }

    /// Returns the figure with that of another program, in the same unit.
    #[must_use]
    pub fn beside(mut self, peer: &str, value: f64) -> Self {
        self.peer = Some((peer.to_owned(), value));
        self
    }

    /// Appends the figure to the file that `SPRUNG_FIGURES` names; does nothing without this variable.
    ///
    /// # Panics
    ///
    /// If the file cannot be written, or the value is no number.
    pub fn note(&self) {
        let Some(path) = std::env::var_os("SPRUNG_FIGURES") else {
            return;
        };
        assert!(self.value.is_finite(), "{} is {}", self.name, self.value);
        let mut line = serde_json::json!({
            "name": self.name,
            "text": self.text,
            "value": rounded(self.value),
            "unit": self.unit,
            "better": self.better,
            "scatter": self.scatter,
        });
        if let Some((peer, value)) = &self.peer {
            line["peer"] = peer.as_str().into();
            line["peer_value"] = rounded(*value).into();
        }
        let file = std::fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path);
        let written = file.and_then(|mut file| writeln!(file, "{line}"));
        written.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
}

/// Returns a number with four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_four_digits() {
        for (value, expected) in [(0.391_449, 0.3914), (1_234_567.0, 1_235_000.0), (0.0, 0.0)] {
            assert!(
                (rounded(value) - expected).abs() <= 1e-12 * expected,
                "{value}"
            );
        }
    }
}
