//! The factors of one row of the regression, one per segment of the log.

use super::householder::RowBlock;
use super::system::joined_in_pairs;
use super::triangle::Triangle;
use crate::model::Model;

/// Limits of the segments of a log: each row keeps one factor per segment. When the largest number
/// of factors is reached, neighbours are merged and the segments double in length. Models with many
/// parameters have large factors, so they keep fewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentLimits {
    pub(super) max_factors: usize,
    pub(super) initial_samples: u64,
}

impl SegmentLimits {
    pub(super) fn of(model: &Model) -> Self {
        if model.parameters().len() <= 40 {
            Self {
                max_factors: 512,
                initial_samples: 16,
            }
        } else {
            Self {
                max_factors: 128,
                initial_samples: 64,
            }
        }
    }
}

impl SegmentLimits {
    /// Returns the limits of one of several logs, whose factors are joined later. Longer first segments save small
    /// factors that would be merged.
    pub(super) fn among(self, logs: usize) -> Self {
        let levels = logs.clamp(1, self.max_factors).ilog2();
        Self {
            initial_samples: self.initial_samples << levels,
            ..self
        }
    }
}

/// Rows that are transposed into columns together.
const TILE_ROWS: usize = 16;

/// The factors of one row, and the samples that are not yet factored.
#[derive(Clone, Debug)]
pub(super) struct RowFactors {
    /// Number of columns with that of the right-hand side.
    width: usize,
    tile: Vec<f64>,
    in_tile: usize,
    gathered: RowBlock,
    rows: usize,
    in_current: u64,
    limits: SegmentLimits,
    /// Samples of a segment.
    segment_samples: u64,
    current: Option<Triangle>,
    pub(super) done: Vec<Triangle>,
}

impl RowFactors {
    /// - `width`: number of columns with that of the right-hand side.
    pub(super) fn new(model: &Model, width: usize) -> Self {
        let limits = SegmentLimits::of(model);
        Self {
            width,
            tile: vec![0.0; TILE_ROWS * width],
            in_tile: 0,
            gathered: RowBlock::of_width(width),
            rows: 0,
            in_current: 0,
            segment_samples: limits.initial_samples,
            limits,
            current: None,
            done: Vec::new(),
        }
    }

    /// Replaces the limits before the first sample.
    pub(super) fn limit(&mut self, limits: SegmentLimits, segment_samples: u64) {
        self.limits = limits;
        self.segment_samples = segment_samples;
    }

    /// Returns the place of the next row with its right-hand side.
    pub(super) fn next_row(&mut self) -> &mut [f64] {
        &mut self.tile[self.in_tile * self.width..][..self.width]
    }

    /// Counts the row that was written into the tile, and factors or closes a segment when it is
    /// full.
    pub(super) fn advance(&mut self) {
        self.in_tile += 1;
        self.in_current += 1;
        let full = self.rows + self.in_tile == self.gathered.capacity();
        let ended = self.in_current == self.segment_samples;
        if self.in_tile == TILE_ROWS || full || ended {
            self.untile();
        }
        if ended {
            self.close();
        } else if full {
            self.factor();
        }
    }

    /// Transposes the tile's rows into the columns of the gathered rows.
    pub(super) fn untile(&mut self) {
        let count = std::mem::take(&mut self.in_tile);
        let width = self.width;
        for column in 0..width {
            let gathered = self.gathered.column_mut(column);
            let rows = self.tile.chunks(width).take(count);
            for (entry, row) in gathered[self.rows..].iter_mut().zip(rows) {
                *entry = row[column];
            }
        }
        self.rows += count;
    }

    fn factor(&mut self) {
        let rows = std::mem::take(&mut self.rows);
        if rows == 0 {
            return;
        }
        let width = self.width;
        let current = self.current.get_or_insert_with(|| Triangle::zero(width));
        current.fold(&mut self.gathered, rows);
    }

    pub(super) fn close(&mut self) {
        self.factor();
        self.in_current = 0;
        self.done.extend(self.current.take());
        if self.done.len() == self.limits.max_factors {
            self.done = joined_in_pairs(&self.done, Triangle::sum);
            self.segment_samples *= 2;
        }
    }
}
