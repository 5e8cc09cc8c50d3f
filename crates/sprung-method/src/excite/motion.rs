//! A motion at even times, and the waves of a series.

use faer::Mat;

use super::physics::MotionAt;

/// A motion at even times.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    /// The motion at each time.
    pub(super) at: Vec<MotionAt>,
    /// Entries of the regressor, \[samples × entries\].
    pub(super) entries: Mat<f64>,
    /// Torque on each coordinate by these entries, \[samples × rows\]; the rows of motors have their torques.
    pub(super) torque: Mat<f64>,
    /// States of the simulation, for the way back.
    pub(super) trace: Vec<f64>,
    /// Coefficients of the reference, \[n × (1 + 2 harmonics)\].
    pub(super) coefficients: Vec<Vec<f64>>,
}

/// Derivatives of a function by a motion.
#[derive(Clone, Debug)]
pub(super) struct ByMotion {
    pub(super) at: Vec<MotionAt>,
    pub(super) entries: Mat<f64>,
}

/// Basis functions of a series: 1, then sine and cosine of each multiple, with their derivatives by time.
///
/// Returns one matrix for each order, \[times × functions\].
pub(super) fn waves(rate: f64, harmonics: &[usize], orders: usize, times: &[f64]) -> Vec<Mat<f64>> {
    let count = 1 + 2 * harmonics.len();
    (0..orders)
        .map(|order| {
            let mut wave = Mat::zeros(times.len(), count);
            for (t, &time) in times.iter().enumerate() {
                if order == 0 {
                    wave[(t, 0)] = 1.0;
                }
                for (k, &multiple) in harmonics.iter().enumerate() {
                    let rate = rate * multiple as f64;
                    let (sin, cos) = (rate * time).sin_cos();
                    let (a, b) = match order % 4 {
                        0 => (sin, cos),
                        1 => (cos, -sin),
                        2 => (-sin, -cos),
                        _ => (-cos, sin),
                    };
                    let scale = rate.powi(order as i32);
                    wave[(t, 1 + 2 * k)] = scale * a;
                    wave[(t, 2 + 2 * k)] = scale * b;
                }
            }
            wave
        })
        .collect()
}

/// Writes entries and torques of one time.
pub(super) fn fill_torque(
    physics: &super::physics::Physics,
    entries: &[f64],
    mut write: impl FnMut(usize, f64),
) {
    let model = &physics.model;
    for row in 0..model.coordinates() {
        let columns = model.equation_columns(row).iter();
        let row_entries = &entries[model.equation_entries(row)];
        let sum: f64 = (row_entries.iter().zip(columns))
            .map(|(entry, &column)| entry * physics.theta[column])
            .sum();
        write(row, sum);
    }
}
