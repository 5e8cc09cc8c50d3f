//! Derivatives that are integrated together with the state.

/// Derivatives that are integrated together with the state: those of the state \[2 rows × columns\]
/// and those of the torques \[rows × columns\], row by row.
///
/// `theta` assigns columns to the parameters, `velocities` to Stribeck velocities.
#[derive(Clone, Debug)]
pub(in crate::estimate::prediction_error) struct Tangent {
    pub(in crate::estimate::prediction_error) columns: usize,
    pub(in crate::estimate::prediction_error) state: Vec<f64>,
    pub(in crate::estimate::prediction_error) torque: Vec<f64>,
    /// Column of each parameter of theta; `None` for a parameter without derivatives.
    pub(in crate::estimate::prediction_error) theta: Vec<Option<usize>>,
    /// Joint and column of each Stribeck velocity with a derivative.
    pub(super) velocities: Vec<(usize, usize)>,
    pub(super) stage: Vec<f64>,
    pub(super) sum: Vec<f64>,
    pub(super) force: Vec<f64>,
    pub(super) rate: Vec<f64>,
}

impl Tangent {
    /// Returns derivatives that are zero.
    pub(in crate::estimate::prediction_error) fn new(
        rows: usize,
        columns: usize,
        theta: Vec<Option<usize>>,
        velocities: Vec<(usize, usize)>,
    ) -> Self {
        let zeros = |count: usize| vec![0.0; count * columns];
        Self {
            columns,
            state: zeros(2 * rows),
            torque: zeros(rows),
            theta,
            velocities,
            stage: zeros(2 * rows),
            sum: zeros(2 * rows),
            force: zeros(rows),
            rate: zeros(rows),
        }
    }
}
