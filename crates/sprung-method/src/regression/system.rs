//! The reduced logs: a bounded number of factors.

use std::ops::Range;
use std::sync::OnceLock;

use super::triangle::Triangle;

/// Limit of the samples of the filtered regression that are kept for plots.
pub(super) const KEPT_SAMPLES: usize = 2048;

/// Joins neighbours in pairs.
pub(super) fn joined_in_pairs<T: Clone>(all: &[T], join: impl Fn(&T, &T) -> T) -> Vec<T> {
    all.chunks(2)
        .map(|pair| match pair {
            [a, b] => join(a, b),
            _ => pair[0].clone(),
        })
        .collect()
}

/// Evenly spaced samples of the filtered regression.
#[derive(Clone, Debug)]
pub struct Kept {
    /// Distance of the samples in the logs.
    pub stride: u64,
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

impl Kept {
    /// Appends samples of the same rows. The samples of both are thinned to the rate of the rarer one, and further
    /// while they are too many.
    fn append(&mut self, mut next: Self, later: f64) {
        while self.stride < next.stride {
            self.thin();
        }
        while next.stride < self.stride {
            next.thin();
        }
        self.time.extend(next.time.iter().map(|time| time + later));
        for (row, next) in self.rows.iter_mut().zip(next.rows) {
            row.extend(next);
        }
        for (variance, next) in (self.variance.iter_mut().zip(next.variance))
            .chain(self.bound.iter_mut().zip(next.bound))
        {
            variance.extend(next);
        }
        while self.time.len() > KEPT_SAMPLES {
            self.thin();
        }
    }

    /// Keeps every second sample.
    fn thin(&mut self) {
        fn every_second<T>(all: &mut Vec<T>) {
            let mut index = 0;
            all.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
        every_second(&mut self.time);
        self.rows.iter_mut().for_each(every_second);
        self.variance.iter_mut().for_each(every_second);
        self.bound.iter_mut().for_each(every_second);
        self.stride *= 2;
    }
}

/// The reduced system: the stacked filtered regression of all logs.
#[derive(Clone, Debug)]
pub struct System {
    /// Factors of each row, segment by segment.
    pub(super) rows: Vec<Vec<Triangle>>,
    /// Sum of the squared weights of each row.
    pub(super) weights: Vec<f64>,
    /// Time at the end of each segment, s.
    pub(super) ends: Vec<f64>,
    /// Number of segments of each log and of all logs before it.
    pub(super) logs: Vec<usize>,
    /// Samples of a segment; the last segment of a log may be shorter.
    pub(super) segment_samples: u64,
    /// Number of segments up to which neighbours of one log are not merged.
    pub(super) max_segments: usize,
    pub(super) kept: Kept,
    /// Samples at rest of each row.
    pub(super) at_rest: Vec<u64>,
    pub(super) samples: u64,
    // The factors of all samples, after their first request.
    pub(super) all: OnceLock<Option<Vec<Triangle>>>,
}

/// Returns the number of segments in each of at most `count` consecutive parts.
fn part_size(segments: usize, count: usize) -> usize {
    segments.div_ceil(count.max(1)).max(1)
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

    /// Returns the time from the end of the first segment to the last sample, s.
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

    /// Returns the system of one log without some columns, in at most `count` consecutive parts and without
    /// samples for plots.
    ///
    /// - `left_out`: of each row and column.
    #[must_use]
    pub(crate) fn without(&self, left_out: &[Vec<bool>], count: usize) -> Self {
        let absent: Vec<Vec<Option<f64>>> = (left_out.iter())
            .map(|row| row.iter().map(|&absent| absent.then_some(0.0)).collect())
            .collect();
        let parts = self.groups(count);
        let of_row = |row: usize| {
            let factors = parts.iter().map(|part| part[row].with_known(&absent[row]));
            factors.collect()
        };
        let size = part_size(self.ends.len(), count);
        let ends: Vec<f64> = (self.ends.chunks(size))
            .filter_map(|part| part.last().copied())
            .collect();
        Self {
            rows: (0..self.rows.len()).map(of_row).collect(),
            weights: self.weights.clone(),
            logs: vec![ends.len()],
            ends,
            segment_samples: self.segment_samples * size as u64,
            max_segments: self.max_segments,
            kept: Kept {
                stride: 1,
                time: Vec::new(),
                rows: vec![Vec::new(); self.rows.len()],
                variance: vec![Vec::new(); self.rows.len()],
                bound: vec![Vec::new(); self.rows.len()],
            },
            at_rest: self.at_rest.clone(),
            samples: self.samples,
            all: OnceLock::new(),
        }
    }

    /// Returns the factors of at most `count` consecutive parts of one log.
    #[must_use]
    pub fn groups_of_log(&self, log: usize, count: usize) -> Vec<Vec<Triangle>> {
        let first = log.checked_sub(1).map_or(0, |before| self.logs[before]);
        self.groups_of(first..self.logs[log], count)
    }

    /// Appends the logs of another system of the same rows.
    ///
    /// Segments of all logs have one length. It doubles, and neighbours within a log are merged, while there are more
    /// segments than one system keeps.
    ///
    /// - `later`: is added to the times of the other system, s.
    pub(super) fn append(&mut self, mut next: Self, later: f64) {
        while self.segment_samples < next.segment_samples {
            self.coarsen();
        }
        while next.segment_samples < self.segment_samples {
            next.coarsen();
        }
        let before = self.ends.len();
        for (row, next) in self.rows.iter_mut().zip(next.rows) {
            row.extend(next);
        }
        self.ends.extend(next.ends.iter().map(|end| end + later));
        self.logs.extend(next.logs.iter().map(|end| before + end));
        while self.ends.len() > self.max_segments.max(self.logs.len()) {
            self.coarsen();
        }
        for (weight, next) in self.weights.iter_mut().zip(next.weights) {
            *weight += next;
        }
        for (count, next) in self.at_rest.iter_mut().zip(next.at_rest) {
            *count += next;
        }
        self.samples += next.samples;
        self.kept.append(next.kept, later);
        self.all = OnceLock::new();
    }

    /// Doubles the length of the segments: merges neighbours within each log.
    fn coarsen(&mut self) {
        let mut first = 0;
        let logs: Vec<Range<usize>> = (self.logs.iter())
            .map(|&end| std::mem::replace(&mut first, end)..end)
            .collect();
        for row in &mut self.rows {
            *row = (logs.iter())
                .flat_map(|log| joined_in_pairs(&row[log.clone()], Triangle::sum))
                .collect();
        }
        self.ends = (logs.iter())
            .flat_map(|log| joined_in_pairs(&self.ends[log.clone()], |_, end| *end))
            .collect();
        let mut count = 0;
        for (entry, log) in self.logs.iter_mut().zip(&logs) {
            count += log.len().div_ceil(2);
            *entry = count;
        }
        self.segment_samples *= 2;
    }

    fn groups_of(&self, segments: Range<usize>, count: usize) -> Vec<Vec<Triangle>> {
        let size = part_size(segments.len(), count);
        segments
            .clone()
            .step_by(size)
            .map(|first| {
                let part = first..segments.end.min(first + size);
                (self.rows.iter())
                    .filter_map(|row| Triangle::merge(&row[part.clone()]))
                    .collect()
            })
            .collect()
    }

    /// Returns the factors of growing parts of the logs, with the end of each part in s, at most
    /// `count` of them.
    pub fn growing(&self, count: usize) -> impl Iterator<Item = (f64, Vec<Triangle>)> {
        let size = part_size(self.ends.len(), count);
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
