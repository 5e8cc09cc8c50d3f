//! The reduced logs: a bounded number of factors.

use std::ops::Range;
use std::sync::OnceLock;

use super::triangle::Triangle;

/// Evenly spaced samples of the filtered regression.
#[derive(Clone, Debug)]
pub struct Kept {
    /// Time, s.
    pub time: Vec<f64>,
    /// Entries of each row followed by its right-hand side, one vector per sample.
    pub rows: Vec<Vec<Vec<f64>>>,
    /// Variance that Coulomb transitions add to each row, (N·m)²; empty without weights.
    pub variance: Vec<Vec<f64>>,
    /// Largest friction of each row at rest, filtered, N·m (N); zero in motion, empty without
    /// weights.
    pub bound: Vec<Vec<f64>>,
}

impl Kept {
    /// Returns the root mean square of the velocity noise that Coulomb transitions pass into a row,
    /// over that of the row's right-hand side. `None` without weights or without a right-hand side.
    #[must_use]
    pub fn transition_share(&self, row: usize) -> Option<f64> {
        let variance = self.variance.get(row).filter(|v| !v.is_empty())?;
        let torque: f64 = (self.rows[row].iter())
            .filter_map(|sample| sample.last())
            .map(|rhs| rhs * rhs)
            .sum();
        // The filter can undershoot slightly below zero.
        let noise: f64 = variance.iter().map(|variance| variance.max(0.0)).sum();
        (torque > 0.0).then(|| (noise / torque).sqrt())
    }
}

/// The reduced system: the stacked filtered regression of all logs.
#[derive(Clone, Debug)]
pub struct System {
    /// Factors of each row, stretch by stretch.
    pub(super) rows: Vec<Vec<Triangle>>,
    /// Sum of the squared weights of each row.
    pub(super) weights: Vec<f64>,
    /// Time at the end of each stretch, s.
    pub(super) ends: Vec<f64>,
    pub(super) kept: Kept,
    /// Samples at rest of each row.
    pub(super) at_rest: Vec<u64>,
    pub(super) samples: u64,
    // The factors of all samples, once they were asked for.
    pub(super) all: OnceLock<Option<Vec<Triangle>>>,
}

impl System {
    /// Returns the fraction of the samples at which the friction of a row is at rest; zero without
    /// weights.
    #[must_use]
    pub fn share_at_rest(&self, row: usize) -> f64 {
        self.at_rest[row] as f64 / self.samples.max(1) as f64
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns the time from the end of the first stretch to the last sample, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        let ends = self.ends.first().zip(self.ends.last());
        ends.map_or(0.0, |(first, last)| last - first)
    }

    /// Returns the sum of the squared weights of a row, which is its effective number of samples.
    #[must_use]
    pub fn weight(&self, row: usize) -> f64 {
        self.weights[row]
    }

    /// Returns whether some samples of a row count less than others.
    #[must_use]
    pub fn is_weighted(&self, row: usize) -> bool {
        self.weights[row] < (1.0 - 1e-9) * self.samples as f64
    }

    /// Returns the samples that are kept for plots.
    #[must_use]
    pub fn kept(&self) -> &Kept {
        &self.kept
    }

    /// Returns one factor of all samples for each reduced row; `None` if there are no samples.
    #[must_use]
    pub fn whole(&self) -> Option<Vec<Triangle>> {
        self.all.get_or_init(|| self.groups(1).pop()).clone()
    }

    /// Returns the factors of at most `count` consecutive parts of about equal length.
    #[must_use]
    pub fn groups(&self, count: usize) -> Vec<Vec<Triangle>> {
        self.groups_of(0..self.ends.len(), count)
    }

    /// Returns the factors of at most `count` consecutive parts of the stretches that begin at or
    /// after one time and end at or before another, s.
    ///
    /// - `from`: the end of the previous part, or minus infinity.
    #[must_use]
    pub fn between(&self, from: f64, to: f64, count: usize) -> Vec<Vec<Triangle>> {
        // The first stretch that ends at or after `from` does not begin after it.
        let first = self.ends.partition_point(|end| *end < from) + usize::from(from.is_finite());
        let end = self.ends.partition_point(|end| *end <= to);
        self.groups_of(first.min(end)..end, count)
    }

    fn groups_of(&self, stretches: Range<usize>, count: usize) -> Vec<Vec<Triangle>> {
        let size = stretches.len().div_ceil(count.max(1)).max(1);
        stretches
            .clone()
            .step_by(size)
            .map(|first| {
                let part = first..stretches.end.min(first + size);
                (self.rows.iter())
                    .filter_map(|row| Triangle::merge(&row[part.clone()]))
                    .collect()
            })
            .collect()
    }

    /// Returns the factors of growing parts of the logs, with the end of each part in s, at most
    /// `count` of them.
    pub fn growing(&self, count: usize) -> impl Iterator<Item = (f64, Vec<Triangle>)> {
        let size = self.ends.len().div_ceil(count.max(1)).max(1);
        let mut so_far: Option<Vec<Triangle>> = None;
        (0..self.ends.len()).step_by(size).map(move |first| {
            let part = first..self.ends.len().min(first + size);
            let end = self.ends[part.end - 1];
            let joined: Vec<Triangle> = (self.rows.iter().enumerate())
                .filter_map(|(i, row)| {
                    let before = so_far.as_ref().map(|all| &all[i]);
                    Triangle::merge(before.into_iter().chain(&row[part.clone()]))
                })
                .collect();
            so_far = Some(joined.clone());
            (end, joined)
        })
    }
}
