//! The density of robots, as the two methods of drawing need it.

use faer::Mat;

use crate::model::{Block, Theta};

/// A normal density of the unknowns over the robots that can exist.
#[derive(Clone, Debug)]
pub(super) struct Density {
    /// Mean without the set, \[unknowns\].
    pub(super) mean: Vec<f64>,
    /// Inverse of the covariance without the set, \[unknowns × unknowns\].
    pub(super) precision: Mat<f64>,
    /// Matrices that must be positive definite, without the prior.
    pub(super) blocks: Vec<Block>,
    /// The robot in the middle of the posterior: the minimum of minus the logarithm of the density with the barrier,
    /// \[unknowns\].
    pub(super) centre: Vec<f64>,
    /// Change of theta by each unknown, \[unknowns\]\[p\], and theta without the unknowns, \[p\].
    pub(super) columns: Vec<Theta>,
    pub(super) constant: Theta,
}

impl Density {
    /// Returns the parameters of a robot, \[p\].
    pub(super) fn theta(&self, x: &[f64]) -> Theta {
        let mut theta = self.constant.clone();
        for (column, x) in self.columns.iter().zip(x) {
            for (value, by) in theta.iter_mut().zip(column) {
                *value += x * by;
            }
        }
        theta
    }
}
