//! The log, the robot and the catalogue of a search for unknowns, and the steps of one regression.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use sprung_core::friction::Scale;
use sprung_core::parameters::JointParameter;

use super::evidence::{Evidence, PARTS, Prior, Sign};
use super::kinds::{Catalogued, catalogue};
use super::rows::{Row, RowOf, Rows, Wanted};
use super::state::State;
use super::unknown::{Effect, Kind, Place, Samples, ShownBy, Unknown};
use crate::description::{Delay, Experiment};
use crate::log::{Channels, LogBlock, Signal};
use crate::model::Model;
use crate::prepare::{Excerpt, Smoothed};
use crate::preprocess::{Butterworth, SignalBlock};
use crate::regression::Reading;

/// Rate of the filtered signals, Hz.
const RATE_HZ: f64 = 200.0;

/// The log as it is.
pub(super) struct Logged {
    smoothed: Smoothed,
    /// Without columns of unknowns.
    pub(super) rows: Vec<Row>,
}

/// A log whose unknowns are sought.
pub(super) struct Search<'a> {
    pub(super) reading: Reading,
    pub(super) channels: &'a Channels,
    pub(super) model: &'a Model,
    pub(super) excerpt: &'a Excerpt,
    pub(super) span: [f64; 2],
    pub(super) unknowns: Vec<Unknown>,
    pub(super) rows: Vec<RowOf>,
    pub(super) free: Vec<usize>,
    pub(super) places: BTreeMap<usize, usize>,
    pub(super) signs: Vec<Sign>,
    pub(super) catalogued: Catalogued<'a>,
    /// Signals of a log whose channels are all zero.
    pub(super) zero: OnceLock<Option<Smoothed>>,
    /// The log as it is.
    logged: OnceLock<Option<Logged>>,
    /// What the best other meaning of the columns of hardly unexplained joints leaves of the squares.
    pub(super) any_meaning: OnceLock<Option<f64>>,
    /// Unknowns that the description asks for.
    pub(super) asked: Vec<usize>,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        (experiment, reading): (&'a Experiment, &Reading),
        channels: &'a Channels,
        model: &'a Model,
        excerpt: &'a Excerpt,
    ) -> Self {
        let free: Vec<usize> = (0..model.parameters().len())
            .filter(|&i| model.known(i).is_none())
            .collect();
        let sign = |&i: &usize| match model.parameters()[i].joint {
            Some((JointParameter::Stiffness, _)) => Sign::Stiffness,
            Some((kind, _)) if kind.is_vital() || kind.is_friction() => Sign::NotNegative,
            _ => Sign::Any,
        };
        let signs = free.iter().map(sign).collect();
        let catalogued = Catalogued::new((experiment, reading), channels, model, excerpt);
        let mut unknowns = catalogue(&catalogued);
        unknowns.retain(|unknown| unknown.shown_by != ShownBy::Innovations);
        let is_asked = |unknown: &Unknown| {
            let [channel] = unknown.channels() else {
                return false;
            };
            let channel = &channels.all[*channel];
            let wanted = match unknown.kind {
                Kind::Delay => channel.delay == Some(Delay::Estimate),
                Kind::Gain => channel.open_gain,
                _ => false,
            };
            wanted && !catalogued.is_known
        };
        Self {
            span: catalogued.span,
            asked: (0..unknowns.len())
                .filter(|&k| is_asked(&unknowns[k]))
                .collect(),
            unknowns,
            rows: RowOf::all(model),
            places: free
                .iter()
                .enumerate()
                .map(|(place, &column)| (column, place))
                .collect(),
            free,
            signs,
            reading: reading.clone(),
            channels,
            model,
            catalogued,
            excerpt,
            zero: OnceLock::new(),
            logged: OnceLock::new(),
            any_meaning: OnceLock::new(),
        }
    }

    /// Returns the log as it is; `None` if it is too short for the filters.
    pub(super) fn logged(&self) -> Option<&Logged> {
        let logged = || {
            let smoothed = self.signals(self.excerpt)?;
            let rows = self.plain_rows(&smoothed, &self.known())?;
            Some(Logged { smoothed, rows })
        };
        self.logged.get_or_init(logged).as_ref()
    }

    /// Returns whether some sizes leave the log as it is.
    pub(super) fn leave_log(&self, sizes: &[f64]) -> bool {
        let mut all = self.unknowns.iter().zip(sizes);
        all.all(|(unknown, size)| *size == 0.0 || !matches!(unknown.effect, Effect::Channels(..)))
    }

    /// Returns the sizes that the samples or the model already contain.
    pub(super) fn applied_sizes(&self, state: &State) -> Vec<f64> {
        (self.unknowns.iter().zip(&state.sizes))
            .map(
                |(unknown, size)| {
                    if unknown.is_applied() { *size } else { 0.0 }
                },
            )
            .collect()
    }

    pub(super) fn evidence(
        &self,
        rows: &[Row],
        (state, scales): (&State, &[f64]),
        weights: Option<Vec<f64>>,
        repeats: f64,
    ) -> Evidence {
        let applied = self.applied_sizes(state);
        let priors: Vec<Prior> = (self.unknowns.iter().zip(scales).zip(&applied))
            .map(|((unknown, &scale), &applied)| Prior {
                scale,
                applied,
                is_positive: unknown.is_positive,
            })
            .collect();
        Evidence::new(rows, &self.signs, &priors, weights, repeats)
    }

    /// Returns the excerpt with the corrections of some sizes.
    pub(super) fn corrected(&self, sizes: &[f64]) -> Excerpt {
        if self.leave_log(sizes) {
            return self.excerpt.clone();
        }
        let mut blocks = self.excerpt.blocks().to_vec();
        for (unknown, &size) in self.unknowns.iter().zip(sizes) {
            if size == 0.0 {
                continue;
            }
            let Effect::Channels(channels, effect) = &unknown.effect else {
                continue;
            };
            for block in &mut blocks {
                for &channel in channels {
                    let samples = self.samples(block, channel);
                    block.values[channel] = effect.perturb(&samples, size);
                }
            }
        }
        self.excerpt.replaced(blocks)
    }

    pub(super) fn samples<'s>(&self, block: &'s LogBlock, channel: usize) -> Samples<'s> {
        Samples {
            time: &block.time,
            values: &block.values[channel],
            period: self.excerpt.period(),
            span: self.span,
        }
    }

    /// Returns positions, velocities and torques after the same filter without phase shift, with as few samples as it allows.
    pub(super) fn signals(&self, excerpt: &Excerpt) -> Option<Smoothed> {
        let order = self.reading.settings().position_filter_order;
        let filter =
            Butterworth::new(order, self.reading.position_cutoff_hz(), excerpt.period()).ok()?;
        // A period that is a whole fraction up to rounding counts as one.
        let every = ((1.0 / (RATE_HZ * excerpt.period()) + 1e-6) as usize).max(1);
        excerpt.smoothed(&self.reading)?.continuous(&filter, every)
    }

    /// Returns the signals of the excerpt with the corrections of some sizes.
    pub(super) fn signals_of(&self, corrected: &Excerpt, sizes: &[f64]) -> Option<Smoothed> {
        if self.leave_log(sizes) {
            Some(self.logged()?.smoothed.clone())
        } else {
            self.signals(corrected)
        }
    }

    /// Returns the model with the sharpness of some sizes.
    pub(super) fn sharpened(&self, sizes: &[f64]) -> Model {
        let mut model = self.model.clone();
        for (unknown, size) in self.unknowns.iter().zip(sizes) {
            if let Effect::Sharpness(joint) = unknown.effect {
                let sharpness = self.model.sharpness(joint) * size.exp();
                model.set_scale(joint, Scale::Sharpness, sharpness);
            }
        }
        model
    }

    pub(super) fn former<'r>(&'r self, model: &'r Model, period: f64) -> Rows<'r> {
        Rows {
            model,
            reading: &self.reading,
            period,
            span: self.span,
            wanted: Wanted::All,
            all: &self.rows,
            places: &self.places,
            edge: (2.0 / self.reading.position_cutoff_hz() / period).ceil() as usize,
        }
    }

    /// Returns the rows without columns of unknowns.
    pub(super) fn plain_rows(&self, smoothed: &Smoothed, theta: &[f64]) -> Option<Vec<Row>> {
        let former = self.former(self.model, smoothed.period());
        let former = Rows {
            wanted: Wanted::These(&[]),
            ..former
        };
        former.form(smoothed.segments(), theta, &self.unknowns, &[])
    }

    /// Returns the parameters whose values are known, and zero for the others.
    pub(super) fn known(&self) -> Vec<f64> {
        (0..self.model.parameters().len())
            .map(|i| self.model.known(i).unwrap_or_default())
            .collect()
    }

    /// Returns the parameters that rows without columns of unknowns give.
    pub(super) fn first_theta(&self, rows: &[Row], repeats: f64) -> Vec<f64> {
        let mut theta = self.known();
        let evidence = Evidence::new(rows, &self.signs, &[], None, repeats);
        let chosen: Vec<usize> = (0..self.free.len()).collect();
        for (&column, value) in self.free.iter().zip(evidence.fit(&chosen)) {
            theta[column] = value;
        }
        theta
    }

    /// Returns the parameters with stiffnesses of at least the torque over the deflection: a fault that drives a stiffness to zero
    /// must not hide its own column.
    pub(super) fn floored(&self, theta: &[f64], segments: &[SignalBlock], period: f64) -> Vec<f64> {
        let mut floored = theta.to_vec();
        let scales = self.former(self.model, period).scales(segments);
        for (joint, scales) in scales.iter().enumerate() {
            if let Some(at) = self.model.index(JointParameter::Stiffness, joint)
                && self.model.known(at).is_none()
            {
                floored[at] = floored[at].max(scales.torque / scales.deflection);
            }
        }
        floored
    }

    /// Returns the factor by which a size is wrong because its column used another stiffness than the fit gives.
    pub(super) fn rescale(&self, unknown: usize, theta: &[f64], x: &[f64]) -> f64 {
        let Place::Channel(channel) = self.unknowns[unknown].place else {
            return 1.0;
        };
        let of = &self.channels.all[channel];
        if !matches!(of.quantity.signal(), Signal::Link | Signal::Motor) {
            return 1.0;
        }
        let stiffness = self.model.index(JointParameter::Stiffness, of.joint);
        let place = stiffness.and_then(|at| Some((at, *self.places.get(&at)?)));
        place.map_or(1.0, |(at, place)| {
            (theta[at] / x[place].max(1e-9)).clamp(0.2, 3.0)
        })
    }

    /// Returns the usual size of each unknown; of a law the coefficient that makes its torque as large as the row's.
    pub(super) fn scales(&self, rows: &[Row]) -> Vec<f64> {
        (self.unknowns.iter().enumerate())
            .map(|(k, unknown)| {
                if unknown.scale.is_finite() {
                    return unknown.scale;
                }
                let of_row = |row: &Row| {
                    let at = row
                        .columns
                        .iter()
                        .position(|column| *column == self.free.len() + k)?;
                    let last = row.values.ncols() - 1;
                    let rms = |column: usize| -> f64 {
                        (0..row.values.nrows())
                            .map(|i| row.values[(i, column)].powi(2))
                            .sum::<f64>()
                            .sqrt()
                    };
                    let length = rms(at);
                    (length > 0.0).then(|| rms(last) / length)
                };
                rows.iter().find_map(of_row).unwrap_or(1.0)
            })
            .collect()
    }

    pub(super) fn begins(&self, unknown: usize) -> Option<usize> {
        let at = self.unknowns[unknown].begins()?;
        let share = (at - self.span[0]) / self.span[1].max(f64::MIN_POSITIVE);
        Some(((share * PARTS as f64) as usize).min(PARTS - 1))
    }
}
