//! What of a log a simulation is compared with.

use crate::log::{LogBlock, Quantity};
use crate::prepare::Excerpt;
use crate::prepare::noise;
use crate::preprocess::{Aligner, RawBlock};
use crate::regression::Reading;

/// Samples that a fit needs, at least.
const FEWEST_SAMPLES: usize = 100;

/// Noise of a position that counts as none, rad (m): a hundred times the error
/// of the integration.
const FINEST_NOISE_RAD: f64 = 1e-8;

/// Noise over that of an encoder's steps above which it is more than them.
const BEYOND_STEPS: f64 = 2.0;

/// Returns the standard deviation of a position, rad (m), of the noise that a
/// search of the cut-off finds, and of its steps.
///
/// Differences of an encoder's steps look up to 1.2 times as noisy as they are.
fn resolution((noise, step): (f64, Option<f64>)) -> f64 {
    let of_steps = step.map(|step| step / 12_f64.sqrt());
    of_steps
        .filter(|of_steps| noise < BEYOND_STEPS * of_steps)
        .unwrap_or(noise)
}

/// A measured position.
#[derive(Clone, Debug)]
pub(super) struct Position {
    /// Its joint.
    pub(super) joint: usize,
    /// Which of the joint's positions it is.
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
    /// Whether a gap ended it.
    pub(super) at_gap: bool,
}

impl Record {
    /// Returns nothing if there are too few samples, or nothing moves.
    pub(super) fn new(reading: &Reading, excerpt: &Excerpt) -> Option<Self> {
        let channels = reading.channels();
        let period = excerpt.period();
        let mut aligner = Aligner::new(channels, reading.delays(), period);
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
                    noise: resolution(noise(excerpt, i)?).max(FINEST_NOISE_RAD),
                })
            })
            .collect();
        (samples.len() >= FEWEST_SAMPLES && !positions.is_empty()).then_some(Self {
            period,
            samples,
            positions,
            at_gap,
        })
    }

    pub(super) fn len(&self) -> usize {
        self.samples.len()
    }

    /// Returns where the joints were at the first sample: links, motors.
    pub(super) fn start(&self) -> (Vec<f64>, Vec<f64>) {
        let samples = &self.samples;
        (RawBlock::at(&samples.q, 0), RawBlock::at(&samples.phi, 0))
    }
}
