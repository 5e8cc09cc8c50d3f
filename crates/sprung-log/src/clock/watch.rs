//! Counts samples that repeat the values of the preceding one.

use super::timing::Timing;
use crate::error::Place;

/// A repeated sample counts as frozen only if a position moves at least this number of encoder
/// counts per step before and after it. At lower speeds the joint may be at rest.
const MIN_COUNTS_PER_STEP: f64 = 3.0;

/// Detects samples that repeat the preceding one.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    smooth: Vec<bool>,
    last: Vec<f64>,
    // Last step between different samples, and smallest nonzero step, of each channel.
    step: Vec<f64>,
    least: Vec<f64>,
    // Number of samples that repeat the last one, and place of the first of these.
    same: u64,
    place: Option<Place>,
}

impl Watch {
    /// - `smooth`: for each channel, whether it is a position.
    pub(crate) fn new(smooth: Vec<bool>) -> Self {
        let count = smooth.len();
        Self {
            smooth,
            last: Vec::new(),
            step: vec![0.0; count],
            least: vec![f64::INFINITY; count],
            same: 0,
            place: None,
        }
    }

    /// Returns whether these values equal those of the last sample.
    pub(crate) fn same(&self, values: impl Iterator<Item = f64>) -> bool {
        let same = |(a, b): (&f64, f64)| a.to_bits() == b.to_bits();
        self.last.iter().zip(values).all(same)
    }

    /// Takes the values of the next sample.
    pub(crate) fn take(
        &mut self,
        place: Place,
        values: impl Iterator<Item = f64> + Clone,
        timing: &mut Timing,
    ) {
        if self.last.is_empty() {
            self.last.extend(values);
            return;
        }
        if self.same(values.clone()) {
            self.same += 1;
            self.place.get_or_insert(place);
            return;
        }
        let mut moves = false;
        for (i, value) in values.enumerate() {
            let step = value - std::mem::replace(&mut self.last[i], value);
            if !self.smooth[i] {
                continue;
            }
            if step != 0.0 {
                self.least[i] = self.least[i].min(step.abs());
            }
            let before = std::mem::replace(&mut self.step[i], step);
            let slower = before.abs().min(step.abs());
            moves |= before * step > 0.0 && slower >= MIN_COUNTS_PER_STEP * self.least[i];
        }
        if let Some(place) = self.place.take()
            && moves
        {
            timing.frozen.add(self.same, place);
        }
        self.same = 0;
    }
}
