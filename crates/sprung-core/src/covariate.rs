//! Known quantities on which friction depends linearly: temperature, time, wear.

/// Where a log has a covariate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// The clock of the log.
    Clock,
    /// Columns of the log.
    Columns,
}

/// A row of the table of covariates.
struct Row {
    word: &'static str,
    unit: &'static str,
    unit_of_changes: &'static str,
    key: &'static str,
    key_of_reference: &'static str,
    source: Source,
    of: &'static str,
    values: &'static str,
}

/// Declares the covariates, one row each. The table drives names and units of parameters, the keys of
/// the experiment file, the columns of logs, the checks and the messages.
macro_rules! covariates {
    ($d:tt $(
        #[doc = $doc:literal]
        $name:ident {
            $word:literal, $unit:literal, change: $unit_of_changes:literal, per: $per:literal,
            per_unit: $per_unit:literal, key: $key:literal, reference: $reference:literal,
            from: $source:ident, of: $of:literal, values: $values:literal,
        }
    )*) => {
        /// A quantity on which friction parameters depend linearly.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Covariate {
            $(#[doc = $doc] $name,)*
        }

        impl Covariate {
            /// Number of covariates.
            pub const COUNT: usize = Self::ALL.len();

            /// All covariates.
            pub const ALL: [Self; [$($word),*].len()] = [$(Self::$name),*];

            /// Returns the covariate's row of the table.
            const fn row(self) -> Row {
                match self {
                    $(Self::$name => Row {
                        word: $word,
                        unit: $unit,
                        unit_of_changes: $unit_of_changes,
                        key: $key,
                        key_of_reference: $reference,
                        source: Source::$source,
                        of: $of,
                        values: $values,
                    },)*
                }
            }

            /// Returns a description of the change of a friction parameter with it: a noun phrase with a
            /// full stop.
            #[must_use]
            pub const fn about(self) -> &'static str {
                match self {
                    $(Self::$name => concat!("Change of a friction parameter with the ", $of, "."),)*
                }
            }
        }

        /// Appends the suffixes of all covariates to a name, in the order of [`Covariate::ALL`].
        macro_rules! names_of_changes {
            ($d($d part:literal),*) => { [$(concat!($d($d part,)* "_per_", $per)),*] };
        }

        /// Divides a unit by the units of all covariates.
        macro_rules! units_of_changes {
            ($d quantity:literal) => { [$(concat!($d quantity, "/", $per_unit)),*] };
        }
    };
}

covariates! { $
    /// Temperature of the joint, °C.
    Temperature {
        "temperature", "°C", change: "K", per: "k", per_unit: "K",
        key: "temperature_c", reference: "reference_c", from: Columns,
        of: "temperature", values: "the temperatures",
    }
    /// Time since the first sample of the log, s.
    Time {
        "time", "s", change: "s", per: "s", per_unit: "s",
        key: "time_s", reference: "reference_s", from: Clock,
        of: "time in the log", values: "the time",
    }
    /// Hours of operation of the joint, h.
    Operation {
        "operation", "h", change: "h", per: "h", per_unit: "h",
        key: "operation_h", reference: "reference_h", from: Columns,
        of: "hours of operation", values: "the hours of operation",
    }
    /// Time since a date, days.
    Age {
        "age", "d", change: "d", per: "d", per_unit: "d",
        key: "age_d", reference: "reference_d", from: Columns,
        of: "days since a date", values: "the days",
    }
    /// Number of cycles.
    Cycles {
        "cycles", "cycles", change: "cycles", per: "cycle", per_unit: "cycle",
        key: "cycles", reference: "reference_cycles", from: Columns,
        of: "number of cycles", values: "the numbers of cycles",
    }
    /// Any other number.
    Other {
        "covariate", "units", change: "units", per: "covariate", per_unit: "unit",
        key: "covariate", reference: "reference_covariate", from: Columns,
        of: "covariate", values: "the covariate",
    }
}
pub(crate) use {names_of_changes, units_of_changes};

impl Covariate {
    /// Returns its name.
    #[must_use]
    pub const fn word(self) -> &'static str {
        self.row().word
    }

    /// Returns the unit of its values.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        self.row().unit
    }

    /// Returns the unit of differences between its values.
    #[must_use]
    pub const fn unit_of_changes(self) -> &'static str {
        self.row().unit_of_changes
    }

    /// Returns the key of its values in an experiment file; that of its columns ends in the unit.
    #[must_use]
    pub const fn key(self) -> &'static str {
        self.row().key
    }

    /// Returns the key of the value at which friction has its parameters.
    #[must_use]
    pub const fn key_of_reference(self) -> &'static str {
        self.row().key_of_reference
    }

    /// Returns where a log has it.
    #[must_use]
    pub const fn source(self) -> Source {
        self.row().source
    }

    /// Returns its name in words, without article.
    #[must_use]
    pub const fn of(self) -> &'static str {
        self.row().of
    }

    /// Returns its values in words, for messages.
    #[must_use]
    pub const fn values(self) -> &'static str {
        self.row().values
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

    #[test]
    fn words_and_keys_are_unique() {
        for (i, one) in Covariate::ALL.into_iter().enumerate() {
            for other in &Covariate::ALL[..i] {
                assert_ne!(one.word(), other.word());
                assert_ne!(one.key(), other.key());
                assert_ne!(one.key_of_reference(), other.key_of_reference());
            }
        }
    }
}
