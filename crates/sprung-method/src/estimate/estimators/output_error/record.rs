//! Part of a log that is compared with the simulation.

use crate::log::{LogBlock, Quantity};
use crate::prepare::Excerpt;
use crate::prepare::noise;
use crate::preprocess::{Aligner, RawBlock};
use crate::regression::Reading;

/// Minimum number of samples of a fit.
const MIN_SAMPLES: usize = 100;

/// Smallest noise of a position, and smallest tolerance of the integration, rad (m). It is a hundred times the error of
/// the integration.
pub(super) const MIN_NOISE_RAD: f64 = 1e-8;

/// Ratio of the measured noise to the quantisation noise above which the position has further
/// noise.
const MAX_QUANTISATION_RATIO: f64 = 2.0;

/// Returns the standard deviation of a position's noise, rad (m), from its measured noise and its
/// quantisation step.
///
/// Differences of quantised positions look up to 1.2 times as noisy as the positions are. So a
/// position without further noise gets the noise of its steps.
fn resolution((noise, step): (f64, Option<f64>)) -> f64 {
    let of_steps = step.map(|step| step / 12_f64.sqrt());
    of_steps
        .filter(|of_steps| noise < MAX_QUANTISATION_RATIO * of_steps)
        .unwrap_or(noise)
}

/// A measured position.
#[derive(Clone, Debug)]
pub(super) struct Position {
    /// Index of its joint.
    pub(super) joint: usize,
    /// The quantity that it measures.
    pub(super) quantity: Quantity,
    /// Name of its column.
    pub(super) column: String,
    /// Standard deviation of its noise, rad (m).
    pub(super) noise: f64,
}

/// The beginning of a log up to its first gap.
#[derive(Clone, Debug)]
pub(super) struct Record {
    /// T, s.
    pub(super) period: f64,
    /// Time, positions and torques.
    pub(super) samples: RawBlock,
    /// The positions that move.
    pub(super) positions: Vec<Position>,
    /// Whether the record ends at a gap.
    pub(super) at_gap: bool,
}

impl Record {
    /// Returns `None` if there are too few samples or nothing moves.
    pub(super) fn new(reading: &Reading, excerpt: &Excerpt) -> Option<Self> {
        let channels = reading.channels();
        let period = excerpt.period();
        let mut aligner = Aligner::new(channels, reading.delays(), reading.compliances(), period);
        let mut samples = RawBlock::new(reading.model().joint_count());
        let mut at_gap = false;
        for block in excerpt.blocks() {
            let until = block.gaps.first().copied();
            let mut part = LogBlock::new(channels.all.len());
            part.extend(block, 0..until.unwrap_or(block.len()));
            aligner.push(&part, &mut samples);
            if until.is_some() {
                at_gap = true;
                break;
            }
        }
        let positions: Vec<Position> = (channels.all.iter().enumerate())
            .filter(|(_, channel)| channel.quantity.is_position())
            .filter_map(|(i, channel)| {
                Some(Position {
                    joint: channel.joint,
                    quantity: channel.quantity,
                    column: channel.column.clone(),
                    noise: resolution(noise(excerpt, i)?).max(MIN_NOISE_RAD),
                })
            })
            .collect();
        (samples.len() >= MIN_SAMPLES && !positions.is_empty()).then_some(Self {
            period,
            samples,
            positions,
            at_gap,
        })
    }

    pub(super) fn len(&self) -> usize {
        self.samples.len()
    }

    /// Returns the positions of links and motors at the first sample.
    pub(super) fn start(&self) -> (Vec<f64>, Vec<f64>) {
        let samples = &self.samples;
        (RawBlock::at(&samples.q, 0), RawBlock::at(&samples.phi, 0))
    }
}
