//! Stiffnesses in link rows.

/// The entry of a stiffness in a link row, which is there only without link encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DeflectionEntry {
    /// Row.
    pub(crate) row: usize,
    /// Index among the entries of the regressor.
    pub(crate) entry: usize,
    /// Joint of the spring.
    pub(crate) joint: usize,
    /// Index of the stiffness in theta.
    pub(crate) column: usize,
}
