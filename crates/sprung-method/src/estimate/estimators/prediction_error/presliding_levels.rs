//! Prior levels of presliding friction and hysteresis, by the evidence of the log.
//!
//! # Source
//!
//! `MacKay`, Neural Computation 1992: "Bayesian interpolation"; the fixed point of the evidence.

use sprung_core::friction::Family;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::presliding::ELEMENTS;

use crate::model::Model;

/// Least number of coefficients that the log determines; it bounds the fixed point.
const MIN_DETERMINED: f64 = 0.2;

/// Largest prior level over the sum of the coefficients.
const LARGEST_SHARE: f64 = 0.5;

/// Least prior level, N·m (N).
const MIN_LEVEL: f64 = 1e-6;

/// The coefficients of the presliding friction of one side of a joint, or of the hysteresis of its spring. Their prior has one standard
/// deviation, because all of their columns have the size of Coulomb friction's.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PreslidingLevel {
    pub(super) joint: usize,
    /// `link`, `motor` or `spring`.
    pub(super) side: &'static str,
    /// Places of the coefficients among the refined parameters.
    pub(super) places: Vec<usize>,
    /// Standard deviation of the prior, N·m (N).
    pub(super) level: f64,
}

impl PreslidingLevel {
    /// Returns the levels of all sides with presliding friction and of all springs with hysteresis, at a parameter vector.
    ///
    /// - `free`: indices of the refined parameters.
    pub(super) fn all(model: &Model, free: &[usize], theta: &[f64]) -> Vec<Self> {
        let curves = (0..model.joint_count()).flat_map(|joint| {
            let friction = [Side::Link, Side::Motor].map(|side| {
                let laws = Family::Presliding.laws().iter();
                let kinds = laws.map(|&law| JointParameter::Friction(side, law));
                (joint, side.name(), kinds.collect::<Vec<_>>())
            });
            let elements = 0..ELEMENTS as u8;
            let spring = elements.map(JointParameter::Hysteresis).collect();
            friction.into_iter().chain([(joint, "spring", spring)])
        });
        curves
            .filter_map(|(joint, side, kinds)| {
                let indices = kinds
                    .into_iter()
                    .filter_map(|kind| model.index(kind, joint));
                let places: Vec<usize> = indices
                    .filter_map(|index| free.iter().position(|other| *other == index))
                    .collect();
                let values: Vec<f64> = places.iter().map(|&place| theta[free[place]]).collect();
                (!places.is_empty()).then(|| Self {
                    joint,
                    side,
                    level: root_mean_square(&values, values.len() as f64),
                    places,
                })
            })
            .collect()
    }

    /// Returns the level with the greatest evidence.
    ///
    /// ```text
    /// s² ← cᵀc/(n − tr C/s²)
    /// ```
    ///
    /// - `values`: refined parameters; `covariance`: their covariance, \[width × width\].
    pub(super) fn evidence(&self, values: &[f64], covariance: &[f64], width: usize) -> f64 {
        let coefficients: Vec<f64> = self.places.iter().map(|&place| values[place]).collect();
        let trace: f64 = (self.places.iter())
            .map(|&place| covariance[place * (width + 1)])
            .sum();
        let determined = coefficients.len() as f64 - trace / (self.level * self.level);
        let level = root_mean_square(&coefficients, determined.max(MIN_DETERMINED));
        // Of collinear coefficients the log determines little more than the sum.
        let sum: f64 = coefficients.iter().map(|value| value.abs()).sum();
        level.min(LARGEST_SHARE * sum).max(MIN_LEVEL)
    }
}

fn root_mean_square(values: &[f64], count: f64) -> f64 {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (squares / count).sqrt().max(MIN_LEVEL)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(level: f64, places: Vec<usize>) -> PreslidingLevel {
        PreslidingLevel {
            joint: 0,
            side: Side::Motor.name(),
            places,
            level,
        }
    }

    #[test]
    fn the_level_is_that_of_coefficients_that_the_log_determines() {
        // Two coefficients of 3 and 4 N·m, known exactly, among three parameters: at most half their sum.
        let of_two = |start: f64| level(start, vec![1, 2]);
        let known = of_two(1.0).evidence(&[100.0, 3.0, 4.0], &[0.0; 9], 3);
        assert!((known - 3.5).abs() < 1e-12);
        // A fixed point: c_i² = s² − C_ii.
        let mut covariance = [0.0; 36];
        (0..6).for_each(|i| covariance[7 * i] = 0.25);
        let fixed = 1.25_f64.sqrt();
        let same = level(fixed, (0..6).collect()).evidence(&[1.0; 6], &covariance, 6);
        assert!((same - fixed).abs() < 1e-12);
        // Undetermined coefficients: the level falls to the limit of the determined ones.
        let none =
            of_two(1.0).evidence(&[0.0; 3], &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], 3);
        assert!((none - MIN_LEVEL).abs() < 1e-12);
    }
}
