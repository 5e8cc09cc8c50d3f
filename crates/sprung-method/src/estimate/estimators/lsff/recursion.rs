//! Recursive least squares with forgetting as in the paper: on-line, sample by sample, without
//! preprocessing.

use sprung_core::drives::State;
use sprung_core::recursive::{ForgettingLeastSquares, Settings as GainSettings, memory_len};
use sprung_core::velocity::AveragedVelocity;

use crate::description::{DiscretizationName, Identify};
use crate::estimate::errors::LsffError;
use crate::estimate::statistics::NEGLIGIBLE_SHARE;
use crate::model::{Elements, Model, Theta};
use crate::preprocess::{Decimator, RawBlock};
use crate::regression::FilteredRegression;

/// Maximum number of points of the trace.
const TRACE_POINTS: usize = 512;

/// Upper limit of the diagonal factor D of the gain P. In the paper's experiment (10 s, δ = 1, P(0)
/// = 10) D stays below 3e5. It reaches the limit after 16 s without excitation.
const GAIN_LIMIT: f64 = 1e8;

/// Forgetting rate δ, 1/s, diagonal of P(0), and windows of the velocity estimator, samples: those of the paper.
const FORGETTING_PER_S: f64 = 1.0;
const INITIAL_GAIN: f64 = 10.0;
const VELOCITY_WINDOW: [usize; 2] = [4, 4];

/// The on-line estimator. It takes raw samples.
#[derive(Clone, Debug)]
pub struct Lsff {
    regression: FilteredRegression,
    elements: Elements,
    velocity: Vec<AveragedVelocity>,
    fresh: AveragedVelocity,
    model: Model,
    recursion: ForgettingLeastSquares<Vec<f64>>,
    row: Vec<f64>,
    trace: Decimator<(f64, Theta)>,
    mean: Theta,
    variance: Theta,
    averaging: f64,
    period: f64,
    samples: u64,
}

impl Lsff {
    /// Returns an estimator before its first sample.
    ///
    /// - `period`: T, s.
    ///
    /// # Errors
    ///
    /// [`LsffError`] if a setting is out of range.
    ///
    /// # Source
    ///
    /// Eq. (30); regressor by eqs. (19) and (20), velocities by (25) and (26).
    pub fn new(model: &Model, settings: &Identify, period: f64) -> Result<Self, LsffError> {
        let regression = FilteredRegression::new(
            model,
            settings.filter_cutoff(period),
            period,
            DiscretizationName::Paper,
        )
        .map_err(LsffError::Filter)?;
        let [p1, p2] = VELOCITY_WINDOW;
        let velocity = AveragedVelocity::new(p1, p2, period).map_err(LsffError::Velocity)?;
        let gains = GainSettings {
            forgetting: FORGETTING_PER_S,
            initial_gain: INITIAL_GAIN,
            gain_limit: GAIN_LIMIT,
            period,
        };
        let p = model.parameters().len();
        let recursion = ForgettingLeastSquares::new(&gains, p, vec![0.0; memory_len(p)])
            .map_err(LsffError::Recursive)?;
        Ok(Self {
            regression,
            elements: model.elements(),
            velocity: vec![velocity; 2 * model.joint_count()],
            fresh: velocity,
            model: model.clone(),
            recursion,
            row: vec![0.0; p],
            trace: Decimator::new(TRACE_POINTS),
            mean: vec![0.0; p],
            variance: vec![0.0; p],
            averaging: 1.0 - (-FORGETTING_PER_S * period).exp(),
            period,
            samples: 0,
        })
    }

    /// Checks the sampling period of further samples. The filters are made for one period.
    ///
    /// - `period`: T, s.
    ///
    /// # Errors
    ///
    /// [`LsffError::Periods`] if it differs by more than 1 %.
    pub fn check_period(&self, period: f64) -> Result<(), LsffError> {
        if (period / self.period - 1.0).abs() < NEGLIGIBLE_SHARE {
            return Ok(());
        }
        Err(LsffError::Periods {
            first: self.period,
            other: period,
        })
    }

    /// Restarts velocities and filters at the start of another log or after a gap. The estimate is
    /// kept.
    pub fn restart(&mut self) {
        self.velocity.fill(self.fresh);
        self.regression.restart();
        self.elements.restart();
    }

    /// Processes the next samples.
    pub fn process(&mut self, samples: &RawBlock) {
        let n = self.model.joint_count();
        for (k, &time) in samples.time.iter().enumerate() {
            let q = RawBlock::at(&samples.q, k);
            let phi = RawBlock::at(&samples.phi, k);
            let tau = RawBlock::at(&samples.tau, k);
            let excess = samples.excess_at(k);
            let velocities: Vec<f64> = (self.velocity.iter_mut().zip(q.iter().chain(&phi)))
                .map(|(velocity, position)| velocity.process(*position))
                .collect();
            let (dq, dphi) = velocities.split_at(n);
            let state = State {
                q: &q,
                dq,
                phi: &phi,
                dphi,
                excess: &excess,
                elements: self.elements.advance(&q, &phi),
            };
            let spring = RawBlock::at(&samples.spring, k);
            let (entries, [motor, of_spring]) = self.regression.process(&state, &tau, &spring);
            self.recursion.forget();
            for row in 0..self.model.rows() {
                self.row.fill(0.0);
                let row_entries = &entries[self.model.row_entries(row)];
                for (&column, entry) in self.model.row_columns(row).iter().zip(row_entries) {
                    self.row[column] = *entry;
                }
                let mut rhs = self.model.right_hand_side(row).of(motor, of_spring)
                    + shift(&self.model.known_deflections(row), row_entries);
                for (entry, parameter) in self.row.iter_mut().zip(self.model.parameters()) {
                    if let Some(known) = parameter.fixed {
                        rhs -= *entry * known;
                        *entry = 0.0;
                    }
                }
                self.recursion.update(&self.row, rhs);
            }
            self.record(time + samples.later);
        }
    }

    fn record(&mut self, time: f64) {
        let theta = self.theta();
        for ((value, mean), variance) in theta.iter().zip(&mut self.mean).zip(&mut self.variance) {
            let difference = value - *mean;
            *mean += self.averaging * difference;
            *variance += self.averaging * (difference * difference - *variance);
        }
        self.trace.push(|| (time, theta));
        self.samples += 1;
    }

    /// Returns the present estimate, \[p\].
    #[must_use]
    pub fn theta(&self) -> Theta {
        (self.recursion.theta().iter().zip(self.model.parameters()))
            .map(|(value, parameter)| parameter.fixed.unwrap_or(*value))
            .collect()
    }

    /// Returns the standard deviation of each estimate over about the last 1/δ seconds, \[p\].
    #[must_use]
    pub fn wandering(&self) -> Theta {
        self.variance.iter().map(|v| v.sqrt()).collect()
    }

    /// Returns the fraction of the samples in which forgetting was paused, because the gain grew in
    /// directions without excitation.
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

/// Returns the torque of known stiffnesses in a row.
///
/// - `known`: places in the row, and values.
fn shift(known: &[(usize, f64)], row: &[f64]) -> f64 {
    known.iter().map(|&(place, value)| row[place] * value).sum()
}
