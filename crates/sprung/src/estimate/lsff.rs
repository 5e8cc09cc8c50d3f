//! Recursive least squares with forgetting, as the paper runs it: on-line,
//! sample by sample, without preprocessing.

use sprung_core::filter::FilterError;
use sprung_core::recursive::{
    ForgettingLeastSquares, RecursiveError, Settings as GainSettings, memory_len,
};
use sprung_core::regressor::JointState;
use sprung_core::velocity::{AveragedVelocity, VelocityError};

use crate::description::{DiscretizationName, Identify};
use crate::model::{JOINT_COUNT, Model, Theta};
use crate::preprocess::{Decimator, RawSample};
use crate::regression::FilteredRegression;

/// Points of the trace, at most.
const TRACE: usize = 512;

/// Largest entry of the gain matrix's diagonal factor. The paper's 10 s with
/// δ = 1 and P(0) = 10 stay below 3e5; it is reached after 16 s without
/// excitation.
const GAIN_LIMIT: f64 = 1e8;

/// What keeps the recursion from starting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LsffError {
    /// The filter pair cannot be built.
    #[error("{0}")]
    Filter(FilterError),
    /// The velocity estimator cannot be built.
    #[error("{0}")]
    Velocity(VelocityError),
    /// The recursion cannot be built.
    #[error("{0}")]
    Recursive(RecursiveError),
}

/// The on-line estimator, fed with raw samples.
#[derive(Clone, Debug)]
pub struct Lsff {
    regression: FilteredRegression,
    velocity: [AveragedVelocity; 2 * JOINT_COUNT],
    recursion: ForgettingLeastSquares<Vec<f64>>,
    row: Vec<f64>,
    trace: Decimator<(f64, Theta)>,
    mean: Theta,
    variance: Theta,
    averaging: f64,
    samples: u64,
}

impl Lsff {
    /// Returns an estimator that has seen nothing.
    ///
    /// - `period`: T, s.
    ///
    /// # Errors
    ///
    /// [`LsffError`] if a setting is of no use.
    ///
    /// # Source
    ///
    /// Eq. (30); regressor by eqs. (19) and (20), velocities by (25) and (26).
    pub fn new(model: &Model, settings: &Identify, period: f64) -> Result<Self, LsffError> {
        let regression = FilteredRegression::new(
            model.arm(),
            settings.filter_cutoff_rad_per_s,
            period,
            DiscretizationName::Paper,
        )
        .map_err(LsffError::Filter)?;
        let [p1, p2] = settings.lsff_velocity_window;
        let velocity = AveragedVelocity::new(p1, p2, period).map_err(LsffError::Velocity)?;
        let gains = GainSettings {
            forgetting: settings.lsff_forgetting_per_s,
            initial_gain: settings.lsff_initial_gain,
            gain_limit: GAIN_LIMIT,
            period,
        };
        let p = model.parameters().len();
        let recursion = ForgettingLeastSquares::new(&gains, p, vec![0.0; memory_len(p)])
            .map_err(LsffError::Recursive)?;
        Ok(Self {
            regression,
            velocity: [velocity; 2 * JOINT_COUNT],
            recursion,
            row: vec![0.0; p],
            trace: Decimator::new(TRACE),
            mean: Theta::default(),
            variance: Theta::default(),
            averaging: 1.0 - (-settings.lsff_forgetting_per_s * period).exp(),
            samples: 0,
        })
    }

    /// Takes the next sample.
    pub fn process(&mut self, sample: &RawSample) {
        let mut state = JointState {
            q: sample.q,
            phi: sample.phi,
            ..JointState::default()
        };
        for joint in 0..JOINT_COUNT {
            state.dq[joint] = self.velocity[joint].process(sample.q[joint]);
            state.dphi[joint] = self.velocity[JOINT_COUNT + joint].process(sample.phi[joint]);
        }
        let filtered = self.regression.process(sample.time, &state, &sample.tau);
        self.recursion.forget();
        for (columns, entries, rhs) in filtered.rows() {
            self.row.fill(0.0);
            for (&column, entry) in columns.iter().zip(entries) {
                self.row[column] = *entry;
            }
            self.recursion.update(&self.row, rhs);
        }
        let theta = self.theta();
        for ((value, mean), variance) in theta.iter().zip(&mut self.mean).zip(&mut self.variance) {
            let difference = value - *mean;
            *mean += self.averaging * difference;
            *variance += self.averaging * (difference * difference - *variance);
        }
        self.trace.push(|| (sample.time, theta));
        self.samples += 1;
    }

    /// Returns the estimate now.
    #[must_use]
    pub fn theta(&self) -> Theta {
        let mut theta = Theta::default();
        theta.copy_from_slice(self.recursion.theta());
        theta
    }

    /// Returns how far each estimate wandered lately: its standard deviation
    /// over about the last 1/δ seconds.
    #[must_use]
    pub fn wandering(&self) -> Theta {
        self.variance.map(f64::sqrt)
    }

    /// Returns the part of the samples in which forgetting was paused because
    /// directions without excitation wound up.
    #[must_use]
    pub fn paused(&self) -> f64 {
        self.recursion.paused() as f64 / self.samples.max(1) as f64
    }

    /// Returns the estimate over time.
    #[must_use]
    pub fn trace(&self) -> &[(f64, Theta)] {
        self.trace.items()
    }
}
