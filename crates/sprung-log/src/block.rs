//! Consecutive samples of a log.

/// Maximum number of samples in a block.
pub(crate) const BLOCK: usize = 2048;

/// Consecutive samples of a log; channels in the order of [`Channels::all`](super::Channels::all).
#[derive(Clone, Debug, Default)]
pub struct LogBlock {
    /// Time, s.
    pub time: Vec<f64>,
    /// One vector per channel, in rad (m) or N·m (N) after the channel's factor is applied.
    pub values: Vec<Vec<f64>>,
    /// Indices of the samples that follow a gap.
    pub gaps: Vec<usize>,
}

impl LogBlock {
    /// Returns an empty block for `channels` channels.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            time: Vec::with_capacity(BLOCK),
            values: (0..channels).map(|_| Vec::with_capacity(BLOCK)).collect(),
            gaps: Vec::new(),
        }
    }

    /// Returns a block of the same times with other values.
    #[must_use]
    pub fn with_values(&self, values: Vec<Vec<f64>>) -> Self {
        Self {
            time: self.time.clone(),
            gaps: self.gaps.clone(),
            values,
        }
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Returns whether the block has no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Appends a range of samples of another block, without the gaps of that block.
    pub fn extend(&mut self, other: &Self, part: std::ops::Range<usize>) {
        self.time.extend_from_slice(&other.time[part.clone()]);
        for (column, values) in self.values.iter_mut().zip(&other.values) {
            column.extend_from_slice(&values[part.clone()]);
        }
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.time.clear();
        self.values.iter_mut().for_each(Vec::clear);
        self.gaps.clear();
    }
}
