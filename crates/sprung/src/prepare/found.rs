//! Signs and gains that were found.

/// A sign that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundSign {
    /// The column.
    pub column: String,
    /// 1 or -1.
    pub value: f64,
    /// By how much the logarithm of the likelihood is greater than with the other sign.
    pub log_likelihood: f64,
    /// Why, in words.
    pub because: String,
}

/// A gain that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundGain {
    /// The column.
    pub column: String,
    /// What its readings are multiplied with.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
    /// What pins it, in words.
    pub because: String,
}
