//! Units of the readings in a log.

use schemars::JsonSchema;
use serde::Deserialize;

use super::known_words::choose;

/// The physical dimension of a unit, with its SI unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// rad.
    Angle,
    /// m.
    Length,
    /// N·m.
    Torque,
    /// N.
    Force,
    /// A.
    Current,
    /// V.
    Voltage,
    /// s.
    Time,
}

/// A unit by its name.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(with = "String")]
pub struct Unit(usize);

use Dimension::{Angle, Current, Force, Length, Time, Torque, Voltage};

/// Names, dimensions and sizes in SI units.
const UNITS: [(&str, Dimension, f64); 27] = [
    ("rad", Angle, 1.0),
    ("mrad", Angle, 1e-3),
    ("deg", Angle, std::f64::consts::PI / 180.0),
    ("turns", Angle, std::f64::consts::TAU),
    // The size of one turn; counts_per_turn gives the size of a count.
    ("counts", Angle, std::f64::consts::TAU),
    ("m", Length, 1.0),
    ("mm", Length, 1e-3),
    ("um", Length, 1e-6),
    ("µm", Length, 1e-6),
    ("N·m", Torque, 1.0),
    ("Nm", Torque, 1.0),
    ("mN·m", Torque, 1e-3),
    ("mNm", Torque, 1e-3),
    ("N", Force, 1.0),
    ("mN", Force, 1e-3),
    ("kN", Force, 1e3),
    ("A", Current, 1.0),
    ("mA", Current, 1e-3),
    ("V", Voltage, 1.0),
    ("mV", Voltage, 1e-3),
    ("s", Time, 1.0),
    ("ms", Time, 1e-3),
    ("us", Time, 1e-6),
    ("µs", Time, 1e-6),
    ("ns", Time, 1e-9),
    ("min", Time, 60.0),
    ("date", Time, 1e-9),
];

impl Unit {
    /// Returns its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        UNITS[self.0].0
    }

    /// Returns its dimension.
    #[must_use]
    pub fn dimension(self) -> Dimension {
        UNITS[self.0].1
    }

    /// Returns its size in SI units; for counts, the size of a turn.
    #[must_use]
    pub fn size(self) -> f64 {
        UNITS[self.0].2
    }

    /// Returns whether it is encoder counts.
    #[must_use]
    pub fn is_counts(self) -> bool {
        self.name() == "counts"
    }

    /// Returns whether it is a date and time as text; its size is 1 ns.
    #[must_use]
    pub fn is_date(self) -> bool {
        self.name() == "date"
    }

    /// Returns the names of the units of a dimension.
    pub(super) fn names_of(wanted: Dimension) -> Vec<&'static str> {
        (UNITS.iter())
            .filter(|(_, dimension, _)| *dimension == wanted)
            .map(|(name, ..)| *name)
            .collect()
    }
}

impl TryFrom<String> for Unit {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        // Unicode has two characters for µ; the table has U+00B5.
        let word = word.replace('\u{3bc}', "\u{b5}");
        choose("unit", &word, &UNITS.map(|(name, ..)| name)).map(Self)
    }
}
