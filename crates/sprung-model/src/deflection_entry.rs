//! Stiffnesses in link rows.

/// The entry of a stiffness in a link row, which is there only without link encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeflectionEntry {
    /// Row.
    pub row: usize,
    /// Index among the entries of the regressor.
    pub entry: usize,
    /// Joint of the spring.
    pub joint: usize,
    /// Index of the stiffness in theta.
    pub(crate) column: usize,
}
