//! High-pass filter of the rows of joints whose instrument does not show constant deflections.

use crate::description::RowFilter;
use crate::preprocess::{HighPass, Stage};

/// The filter of one row. Entries of the deflection have passed it already.
#[derive(Clone, Debug)]
pub(super) struct RowHighPass {
    kind: RowFilter,
    /// Places of the entries that pass it, with their states.
    stages: Vec<(usize, Vec<Stage>)>,
    filter: Option<HighPass>,
    /// Samples since the start.
    taken: u64,
}

impl RowHighPass {
    /// - `passed`: places of the entries that have passed the filter already.
    /// - `width`: number of entries, with the right-hand side.
    pub(super) fn new((kind, passed): (RowFilter, Vec<usize>), width: usize) -> Self {
        let places = (0..width).filter(|place| !passed.contains(place));
        let stages = vec![Stage::default(); kind.order];
        Self {
            stages: places.map(|place| (place, stages.clone())).collect(),
            kind,
            filter: None,
            taken: 0,
        }
    }

    pub(super) fn restart(&mut self) {
        self.taken = 0;
        for (_, stages) in &mut self.stages {
            stages.fill(Stage::default());
        }
    }

    /// Filters the entries of a sample. While the filter settles, it sets all of them to zero and returns
    /// false.
    ///
    /// - `period`: T, s.
    pub(super) fn process(&mut self, row: &mut [f64], period: f64) -> bool {
        let filter = *(self
            .filter
            .get_or_insert_with(|| HighPass::new(&self.kind, period)));
        for (place, stages) in &mut self.stages {
            row[*place] = filter.process(stages, row[*place]);
        }
        self.taken += 1;
        let has_settled = self.taken > filter.settling();
        if !has_settled {
            row.fill(0.0);
        }
        has_settled
    }
}
