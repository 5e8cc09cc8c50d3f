//! Samples of the log with aligned channels.

use sprung_core::covariate::Covariate;

/// Samples of the log with aligned channels, not filtered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawBlock {
    /// Time, s.
    pub time: Vec<f64>,
    /// Offset that is added to the time when several logs follow one another, s.
    pub later: f64,
    /// Time of the first sample of the log, s.
    pub begin: f64,
    /// Link positions, rad (m), \[n\] vectors; the motor position for a rigid joint.
    pub q: Vec<Vec<f64>>,
    /// Motor positions after gear and coupling, rad (m), \[n\] vectors.
    pub phi: Vec<Vec<f64>>,
    /// Motor torques after gear and coupling, N·m (N), \[n\] vectors.
    pub tau: Vec<Vec<f64>>,
    /// Measured torques of the springs, N·m (N), \[n\] vectors; empty for a joint without torque
    /// sensor.
    pub spring: Vec<Vec<f64>>,
    /// Readings of sensors on links, in their unit, \[3 n\] vectors; empty for axes without reading.
    pub inertial: Vec<Vec<f64>>,
    /// Velocities of links by gyroscopes, rad/s, \[n\] vectors; empty for joints without gyroscope.
    pub rate: Vec<Vec<f64>>,
    /// Accelerations of joints by accelerometers, rad/s² (m/s²), \[n\] vectors; empty for joints without
    /// accelerometer.
    pub acceleration: Vec<Vec<f64>>,
    /// Covariates minus their references, \[n × [`Covariate::COUNT`]\] vectors; empty for covariates
    /// on which the friction of a joint does not depend.
    pub excess: Vec<Vec<f64>>,
}

impl RawBlock {
    /// Returns an empty block for `joints` joints.
    #[must_use]
    pub fn new(joints: usize) -> Self {
        Self {
            time: Vec::new(),
            later: 0.0,
            begin: 0.0,
            q: vec![Vec::new(); joints],
            phi: vec![Vec::new(); joints],
            tau: vec![Vec::new(); joints],
            spring: vec![Vec::new(); joints],
            inertial: Vec::new(),
            rate: vec![Vec::new(); joints],
            acceleration: vec![Vec::new(); joints],
            excess: vec![Vec::new(); joints * Covariate::COUNT],
        }
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Returns whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.time.clear();
        for column in (self.q.iter_mut())
            .chain(&mut self.phi)
            .chain(&mut self.tau)
            .chain(&mut self.spring)
            .chain(&mut self.inertial)
            .chain(&mut self.rate)
            .chain(&mut self.acceleration)
            .chain(&mut self.excess)
        {
            column.clear();
        }
    }

    /// Returns the covariates of the joints minus their references, \[n × [`Covariate::COUNT`]\]; zero for
    /// those on which no friction depends.
    #[must_use]
    pub fn excess_at(&self, k: usize) -> Vec<f64> {
        Self::at(&self.excess, k)
    }

    /// Returns one sample of a group of columns; zero for an empty column.
    #[must_use]
    pub fn at(columns: &[Vec<f64>], k: usize) -> Vec<f64> {
        (columns.iter())
            .map(|column| column.get(k).copied().unwrap_or_default())
            .collect()
    }
}
