//! One measurement.

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
