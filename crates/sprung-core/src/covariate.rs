//! Known quantities on which friction depends linearly: temperature, time, wear.

/// A quantity on which friction parameters depend linearly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Covariate {
    /// Temperature of the joint, °C.
    Temperature,
    /// Time since the first sample of the log, s.
    Time,
    /// Hours of operation of the joint, h.
    Operation,
    /// Time since a date, days.
    Age,
    /// Number of cycles.
    Cycles,
    /// Any other number.
    Other,
}

/// Appends the suffixes of all covariates to a name, in the order of [`Covariate::ALL`].
macro_rules! names_of_changes {
    ($($part:literal),*) => {
        [
            concat!($($part,)* "_per_k"),
            concat!($($part,)* "_per_s"),
            concat!($($part,)* "_per_h"),
            concat!($($part,)* "_per_d"),
            concat!($($part,)* "_per_cycle"),
            concat!($($part,)* "_per_covariate"),
        ]
    };
}
pub(crate) use names_of_changes;

/// Divides a unit by the units of all covariates.
macro_rules! units_of_changes {
    ($unit:literal) => {
        [
            concat!($unit, "/K"),
            concat!($unit, "/s"),
            concat!($unit, "/h"),
            concat!($unit, "/d"),
            concat!($unit, "/cycle"),
            concat!($unit, "/unit"),
        ]
    };
}
pub(crate) use units_of_changes;

impl Covariate {
    /// Number of covariates.
    pub const COUNT: usize = Self::ALL.len();

    /// All covariates.
    pub const ALL: [Self; 6] = [
        Self::Temperature,
        Self::Time,
        Self::Operation,
        Self::Age,
        Self::Cycles,
        Self::Other,
    ];

    /// Returns its name.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Temperature => "temperature",
            Self::Time => "time",
            Self::Operation => "operation",
            Self::Age => "age",
            Self::Cycles => "cycles",
            Self::Other => "covariate",
        }
    }

    /// Returns the unit of its values.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Temperature => "°C",
            _ => self.unit_of_changes(),
        }
    }

    /// Returns the unit of differences between its values.
    #[must_use]
    pub const fn unit_of_changes(self) -> &'static str {
        match self {
            Self::Temperature => "K",
            Self::Time => "s",
            Self::Operation => "h",
            Self::Age => "d",
            Self::Cycles => "cycles",
            Self::Other => "units",
        }
    }

    /// Returns a description of the change of a friction parameter with it: a noun phrase with a full
    /// stop.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::Temperature => "Change of a friction parameter with the temperature.",
            Self::Time => "Change of a friction parameter with the time in the log.",
            Self::Operation => "Change of a friction parameter with the hours of operation.",
            Self::Age => "Change of a friction parameter with the days since a date.",
            Self::Cycles => "Change of a friction parameter with the number of cycles.",
            Self::Other => "Change of a friction parameter with the covariate.",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariates_stand_at_their_index() {
        for (i, one) in Covariate::ALL.into_iter().enumerate() {
            assert_eq!(one as usize, i);
        }
    }
}
