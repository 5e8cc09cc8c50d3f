//! Products of the measured regression with the regression of another motion (the instruments).

use faer::Mat;
use sprung_core::drives::State;
use sprung_core::filter::{FilterError, FilterState};

use super::filtered::{FilteredRegression, Pairs};
use super::nuisance_momentum::FORGOTTEN_TIME_CONSTANTS;
use super::reading::Reading;
use crate::description::InitialMomentum;
use crate::preprocess::{RawBlock, SignalBlock};

/// Products of one row of the measured filtered regression `Y θ = b` with the same row of the
/// instruments `Z`, summed over all samples.
#[derive(Clone, Debug)]
pub(crate) struct CrossProducts {
    /// `Z^T Y`, and `Z^T b` in the last column, \[width × width + 1\].
    pub products: Mat<f64>,
    /// Squared lengths of the columns of Y.
    pub measured: Vec<f64>,
    /// Squared lengths of the columns of Z.
    pub instrument: Vec<f64>,
}

/// Forms, filters and weights the regressors of pairs of motions and multiplies them; returns one
/// result per row.
///
/// The products contain only samples at times that both motions share. Both motions have the weights
/// of the measured motion. The filters restart with each pair; if the initial momentum is to be
/// estimated, samples that it affects are left out.
///
/// - `pairs`: measured motion and instrument motion of each stretch; `period`: T, s.
///
/// # Errors
///
/// [`FilterError`] if the filter pair does not fit the period.
///
/// # Source
///
/// The normal equations of instrumental variables, `Z^T Y θ = Z^T b`.
pub(crate) fn cross_products(
    reading: &Reading,
    pairs: &[(&SignalBlock, &SignalBlock)],
    period: f64,
) -> Result<Vec<CrossProducts>, FilterError> {
    let (model, settings) = (reading.model(), reading.settings());
    let cutoff = settings.filter_cutoff_rad_per_s;
    let mut measured = FilteredRegression::new(model, cutoff, period, settings.discretization)?;
    let mut instrument = measured.clone();
    let filters = Pairs::new(cutoff, period, settings.discretization)?;
    let skipped = match settings.initial_momentum {
        InitialMomentum::Measured => 0,
        InitialMomentum::Estimate => (FORGOTTEN_TIME_CONSTANTS / (cutoff * period)).ceil() as usize,
    };
    let mut sums: Vec<CrossProducts> = (0..model.rows())
        .map(|row| {
            let width = model.row_entries(row).len();
            CrossProducts {
                products: Mat::zeros(width, width + 1),
                measured: vec![0.0; width],
                instrument: vec![0.0; width],
            }
        })
        .collect();
    let mut variance = vec![0.0; model.rows()];
    for (of, with) in pairs {
        measured.restart();
        instrument.restart();
        let mut memory = vec![FilterState::default(); model.rows()];
        let (first, first_with, count) = shared(of, with, period);
        for k in 0..count {
            let sample = Sample::of(of, first + k);
            let (y, [motor, spring]) =
                measured.process(&sample.state(), &sample.tau, &sample.spring);
            let other = Sample::of(with, first_with + k);
            let (z, _) = instrument.process(&other.state(), &other.tau, &other.spring);
            if let Some(weights) = reading.weights() {
                weights.variances(model, &sample.state(), &mut variance);
            }
            for (row, sum) in sums.iter_mut().enumerate() {
                let weight = reading.weights().map_or(1.0, |weights| {
                    let variance = filters
                        .entries
                        .process(&mut memory[row], 0.0, variance[row]);
                    weights.weight(row, variance)
                });
                if k < skipped {
                    continue;
                }
                let own = model.row_entries(row);
                let rhs = model.right_hand_side(row).of(motor, spring)
                    + shift(&model.known_deflections(row), &y[own.clone()]);
                sum.add(&y[own.clone()], rhs, &z[own], weight * weight);
            }
        }
    }
    Ok(sums)
}

impl CrossProducts {
    fn add(&mut self, y: &[f64], rhs: f64, z: &[f64], weight: f64) {
        for (sum, y) in self.measured.iter_mut().zip(y) {
            *sum += weight * y * y;
        }
        for (sum, z) in self.instrument.iter_mut().zip(z) {
            *sum += weight * z * z;
        }
        for (j, y) in y.iter().chain([&rhs]).enumerate() {
            let column = self.products.col_as_slice_mut(j);
            for (sum, z) in column.iter_mut().zip(z) {
                *sum += weight * z * y;
            }
        }
    }
}

/// Returns the torque of known stiffnesses in a row.
///
/// - `known`: places in the row, and values.
pub(crate) fn shift(known: &[(usize, f64)], row: &[f64]) -> f64 {
    known.iter().map(|&(place, value)| row[place] * value).sum()
}

/// Returns the index of the first shared sample in each motion and the number of shared samples.
fn shared(of: &SignalBlock, with: &SignalBlock, period: f64) -> (usize, usize, usize) {
    let (Some(begin), Some(begin_with)) = (of.time.first(), with.time.first()) else {
        return (0, 0, 0);
    };
    let later = ((begin_with - begin) / period).round();
    let (first, first_with) = (later.max(0.0) as usize, (-later).max(0.0) as usize);
    let left = of.len().saturating_sub(first);
    (
        first,
        first_with,
        left.min(with.len().saturating_sub(first_with)),
    )
}

/// One sample of a motion.
struct Sample {
    // q, dq, phi, dphi, covariates minus references.
    joints: [Vec<f64>; 5],
    tau: Vec<f64>,
    spring: Vec<f64>,
}

impl Sample {
    fn of(signals: &SignalBlock, k: usize) -> Self {
        let at = |columns: &[Vec<f64>]| RawBlock::at(columns, k);
        Self {
            joints: [
                at(&signals.q),
                at(&signals.dq),
                at(&signals.phi),
                at(&signals.dphi),
                (signals.excess.iter())
                    .map(|column| column.get(k).copied().unwrap_or(0.0))
                    .collect(),
            ],
            tau: at(&signals.tau),
            spring: at(&signals.spring),
        }
    }

    fn state(&self) -> State<'_> {
        let [q, dq, phi, dphi, excess] = &self.joints;
        State {
            q,
            dq,
            phi,
            dphi,
            excess,
        }
    }
}
