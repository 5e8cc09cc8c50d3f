//! The reduced system of one log as a value that programs can store and send.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::householder::place;
use super::packed::Packed;
use super::row_factors::max_segments;
use super::system::{Kept, System};
use super::triangle::Triangle;
use crate::model::Model;

/// Limits of the segments of one log and of its samples for plots. More of them hardly improve errors, and they take
/// space.
const SEGMENTS: usize = 32;
const SAMPLES: usize = 128;

/// The reduced system of one log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StoredSystem {
    /// Samples of a segment.
    #[serde(rename = "stretch")]
    segment_samples: u64,
    samples: u64,
    /// End of each segment on the time axis of the log, s.
    ends: Packed,
    /// Sum of the squared weights of each row.
    weights: Packed,
    /// Samples at rest of each row.
    at_rest: Vec<u64>,
    /// Factors of each row, segment by segment.
    rows: Vec<Packed>,
    kept: StoredSamples,
}

/// Evenly spaced samples of the filtered regression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct StoredSamples {
    stride: u64,
    time: Packed,
    /// Entries and right-hand side of each row, sample by sample.
    rows: Vec<Packed>,
    variance: Vec<Packed>,
    bound: Vec<Packed>,
}

impl StoredSystem {
    /// Returns a system of one log with fewer segments and samples.
    pub(crate) fn new(mut system: System) -> Self {
        system.reduce_to(SEGMENTS, SAMPLES);
        let packed = |all: Vec<Vec<f64>>| all.into_iter().map(Packed).collect();
        let kept = system.kept;
        Self {
            segment_samples: system.segment_samples,
            samples: system.samples,
            ends: Packed(system.ends),
            weights: Packed(system.weights),
            at_rest: system.at_rest,
            rows: (system.rows.iter())
                .map(|row| {
                    let entries = row
                        .iter()
                        .flat_map(|factor| factor.entries().iter().copied());
                    Packed(entries.collect())
                })
                .collect(),
            kept: StoredSamples {
                stride: kept.stride,
                time: Packed(kept.time),
                rows: (kept.rows.into_iter())
                    .map(|row| Packed(row.into_iter().flatten().collect()))
                    .collect(),
                variance: packed(kept.variance),
                bound: packed(kept.bound),
            },
        }
    }

    /// Returns the system; `None` if it is not one of this model.
    pub(crate) fn restored(&self, model: &Model) -> Option<System> {
        let widths: Vec<usize> = (0..model.rows())
            .map(|row| model.row_columns(row).len() + 1)
            .collect();
        let (count, samples) = (self.ends.0.len(), self.kept.time.0.len());
        let of_rows = |all: &[Packed], length: &dyn Fn(usize) -> usize| {
            all.len() == widths.len()
                && (all.iter().zip(&widths)).all(|(packed, width)| packed.0.len() == length(*width))
        };
        let lists = |all: &[Packed]| of_rows(all, &|_| samples) || of_rows(all, &|_| 0);
        let fits = of_rows(&self.rows, &|width| count * place(0, width))
            && of_rows(&self.kept.rows, &|width| samples * width)
            && lists(&self.kept.variance)
            && lists(&self.kept.bound)
            && self.weights.0.len() == widths.len()
            && self.at_rest.len() == widths.len()
            && self.segment_samples.is_power_of_two()
            && self.kept.stride.is_power_of_two()
            && count > 0;
        let lines = |all: &[Packed]| all.iter().map(|packed| packed.0.clone()).collect();
        fits.then(|| System {
            rows: (self.rows.iter().zip(&widths))
                .map(|(row, &width)| {
                    let factors = row.0.chunks(place(0, width));
                    factors
                        .map(|columns| Triangle::of_columns(width, columns))
                        .collect()
                })
                .collect(),
            weights: self.weights.0.clone(),
            ends: self.ends.0.clone(),
            logs: vec![count],
            segment_samples: self.segment_samples,
            max_segments: max_segments(model),
            kept: Kept {
                stride: self.kept.stride,
                time: self.kept.time.0.clone(),
                rows: (self.kept.rows.iter().zip(&widths))
                    .map(|(row, &width)| row.0.chunks(width).map(<[f64]>::to_vec).collect())
                    .collect(),
                variance: lines(&self.kept.variance),
                bound: lines(&self.kept.bound),
            },
            at_rest: self.at_rest.clone(),
            samples: self.samples,
            all: OnceLock::new(),
        })
    }
}
