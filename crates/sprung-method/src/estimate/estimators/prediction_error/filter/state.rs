//! State and covariance of the filter.

use crate::estimate::estimators::prediction_error::covariance::{
    Correction, Propagation, start_covariance,
};
use crate::estimate::estimators::prediction_error::dynamics::{Dynamics, Tangent};
use crate::estimate::estimators::prediction_error::levels::Levels;
use crate::estimate::estimators::prediction_error::measurements::Segment;
use crate::estimate::estimators::prediction_error::reversals::Reversals;
use crate::estimate::estimators::prediction_error::state_layout::state_count;
use crate::estimate::estimators::prediction_error::unknowns::Unknowns;

/// The filter at one instant, with its work memory.
pub(super) struct Filter<'a> {
    pub(super) dynamics: &'a mut Dynamics,
    pub(super) unknowns: &'a Unknowns,
    /// Values of the unknowns, z.
    pub(super) z: &'a [f64],
    pub(super) levels: &'a Levels,
    /// x, \[3 rows\].
    pub(super) x: Vec<f64>,
    /// P, \[3 rows × 3 rows\], symmetric.
    pub(super) covariance: Vec<f64>,
    /// Measurements of the present sample that have not yet changed P and ∂x/∂z.
    pub(super) correction: Correction,
    pub(super) taken: Taken,
    pub(super) propagation: Propagation,
    /// Nearness of each row's friction to a reversal in the last period, \[rows\].
    pub(super) reversals: Vec<f64>,
    pub(super) friction: &'a Reversals,
    /// Velocities at the beginning of a period, \[rows\].
    pub(super) velocities: Vec<f64>,
    pub(super) torque: Vec<f64>,
    /// ∂x/∂z with the gains held, and F of the last period.
    pub(super) tangent: Tangent,
}

/// The measurements of a sample whose gains have not yet moved ∂x/∂z.
#[derive(Clone, Debug, Default)]
pub(super) struct Taken {
    /// K of each measurement, \[measurements × 3 rows\].
    pub(super) gains: Vec<f64>,
    /// ∂e/∂z of each measurement, \[measurements × unknowns\].
    pub(super) gradients: Vec<f64>,
}

impl<'a> Filter<'a> {
    /// - `dynamics`: with the parameters of `z`.
    pub(super) fn new(
        dynamics: &'a mut Dynamics,
        unknowns: &'a Unknowns,
        z: &'a [f64],
        levels: &'a Levels,
        friction: &'a Reversals,
    ) -> Self {
        let rows = dynamics.rows();
        let (states, count) = (state_count(rows), unknowns.columns());
        Self {
            dynamics,
            unknowns,
            z,
            levels,
            x: vec![0.0; states],
            covariance: vec![0.0; states * states],
            correction: Correction::default(),
            taken: Taken::default(),
            propagation: Propagation::new(rows),
            reversals: vec![0.0; rows],
            friction,
            velocities: vec![0.0; rows],
            torque: vec![0.0; rows],
            tangent: Tangent::new(rows, count, unknowns.places(0), unknowns.scale_places(0)),
        }
    }

    /// Sets the filter to the first sample of a segment.
    pub(super) fn start(&mut self, segment: &Segment) {
        let rows = self.dynamics.rows();
        self.x = start_state(rows, segment, self.unknowns, self.z);
        self.covariance = start_covariance(rows, segment, self.levels);
        self.tangent.sensitivity = self.unknowns.start(rows);
    }

    pub(super) fn is_finite(&self) -> bool {
        self.x.iter().all(|x| x.is_finite())
    }
}

/// Returns the state at the start of a segment, \[3 rows\].
pub(super) fn start_state(
    rows: usize,
    segment: &Segment,
    unknowns: &Unknowns,
    z: &[f64],
) -> Vec<f64> {
    let mut x = segment.start.clone();
    unknowns.shift_start(z, &mut x);
    x.resize(state_count(rows), 0.0);
    x
}
