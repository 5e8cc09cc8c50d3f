//! Coupled transmissions: from positions and torques of the motors to those of the joints.

/// A linear change of coordinates, and back.
#[derive(Clone, Debug, PartialEq)]
pub struct Mix {
    /// From the log to the joints, \[n × n\], row by row.
    pub forward: Vec<Vec<f64>>,
    /// From the joints to the log.
    pub back: Vec<Vec<f64>>,
}

impl Mix {
    /// Returns a matrix times a vector.
    #[must_use]
    pub fn apply(matrix: &[Vec<f64>], values: &[f64]) -> Vec<f64> {
        let product = |row: &Vec<f64>| row.iter().zip(values).map(|(a, x)| a * x).sum();
        matrix.iter().map(product).collect()
    }
}
