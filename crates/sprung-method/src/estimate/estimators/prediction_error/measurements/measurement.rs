//! One measurement.

use super::spring::StateAt;

/// One measurement of a position.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Measurement {
    /// Index of the sensor.
    pub(in super::super) sensor: usize,
    /// y, rad (m).
    pub(in super::super) value: f64,
    /// Part of R that the samples show, rad² (m²).
    pub(in super::super) variance: f64,
    /// Time from the measurement to its sample, s.
    pub(in super::super) age: f64,
}

impl Measurement {
    /// Returns a state at the time of the measurement.
    ///
    /// - `x`: at the sample; `rows`: number of coordinates.
    pub(in super::super) fn at<'s>(&self, x: &'s [f64], rows: usize) -> StateAt<'s> {
        StateAt {
            x,
            rows,
            age: self.age,
        }
    }
}
