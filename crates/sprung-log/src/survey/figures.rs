//! Figures of a column without a description.

use super::parts::parts_between;

/// Smallest number of different values of a column of counts.
const MIN_COUNTS: f64 = 50.0;

/// Largest deviation of an even clock from its median step, as a part of the step.
const EVEN: f64 = 0.5;

/// Part of the steps of a counter of rows that are one; a recorder that lost rows skips numbers.
const COUNTS_ROWS: f64 = 0.99;

/// Figures of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Figures {
    /// Number of finite samples.
    pub(super) count: usize,
    pub(super) min: f64,
    pub(super) max: f64,
    /// Whether all samples are integers.
    pub(super) integers: bool,
    /// Whether each sample is above the one before it.
    pub(super) rises: bool,
    /// Median of the steps between neighbouring samples.
    pub(super) step: f64,
    /// Whether most steps equal the median step.
    pub(super) even: bool,
    /// Part of the steps that are one.
    pub(super) ones: f64,
}

impl Figures {
    /// Returns the figures of samples.
    ///
    /// - `joins`: samples before which rows are left out, so no step leads to them.
    pub(super) fn of(values: &[f64], joins: &[usize]) -> Self {
        let is_finite = |x: &f64| x.is_finite();
        let finite: Vec<f64> = values.iter().copied().filter(is_finite).collect();
        let mut steps: Vec<f64> = Vec::new();
        for part in parts_between(joins, values.len()) {
            let finite: Vec<f64> = values[part].iter().copied().filter(is_finite).collect();
            steps.extend(finite.windows(2).map(|pair| pair[1] - pair[0]));
        }
        steps.sort_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        let near = |x: &&f64| (*x - step).abs() <= EVEN * step.abs();
        let even = 10 * steps.iter().filter(near).count() > 9 * steps.len();
        Self {
            count: finite.len(),
            min: finite.iter().copied().fold(f64::INFINITY, f64::min),
            max: finite.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            integers: !finite.is_empty() && finite.iter().all(|x| x.fract().abs() < 1e-9),
            rises: finite.len() == values.len()
                && values.len() > 1
                && values.windows(2).all(|pair| pair[1] > pair[0]),
            step,
            even,
            ones: steps
                .iter()
                .filter(|step| (**step - 1.0).abs() < 1e-9)
                .count() as f64
                / steps.len().max(1) as f64,
        }
    }

    /// Returns whether the column counts rows: it holds integers that rise by one.
    pub(super) fn counts_rows(&self) -> bool {
        self.integers && self.rises && self.ones >= COUNTS_ROWS
    }

    /// Returns these figures with the range of samples that are left out.
    pub(super) fn with_range(self, (min, max): (f64, f64)) -> Self {
        Self {
            min: self.min.min(min),
            max: self.max.max(max),
            ..self
        }
    }

    /// Returns the distance from the smallest to the largest sample.
    pub(super) fn range(&self) -> f64 {
        if self.count == 0 {
            0.0
        } else {
            self.max - self.min
        }
    }

    /// Returns whether the column never changes.
    pub(super) fn is_constant(&self) -> bool {
        self.range() <= 1e-12 * self.max.abs().max(self.min.abs()) || self.count == 0
    }

    /// Returns whether the samples look like counts of an encoder.
    pub(super) fn are_counts(&self) -> bool {
        self.integers && self.range() >= MIN_COUNTS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_clocks_and_constants_differ() {
        let counts: Vec<f64> = (0..100)
            .map(|k| (300.0 * f64::from(k).sin()).round())
            .collect();
        assert!(Figures::of(&counts, &[]).are_counts());
        let clock: Vec<f64> = (0..100).map(|k| 0.001 * f64::from(k)).collect();
        let figures = Figures::of(&clock, &[]);
        assert!(figures.rises && figures.even && !figures.are_counts());
        assert!(Figures::of(&[2.0; 9], &[]).is_constant());
        assert!(Figures::of(&[], &[]).is_constant());
        let gap = Figures::of(&[0.0, f64::NAN, 1.0], &[]);
        assert!(!gap.rises && gap.count == 2);
        let joined = Figures::of(&[0.0, 1.0, 90.0, 91.0], &[2]);
        assert!(joined.rises && joined.even && (joined.step - 1.0).abs() < 1e-9);
    }

    #[test]
    fn integers_that_rise_by_one_count_rows() {
        let every =
            |step: f64| -> Vec<f64> { (0..300).map(|k| 7.0 + step * f64::from(k)).collect() };
        let without = |lost: &dyn Fn(usize) -> bool| -> Vec<f64> {
            let kept = every(1.0)
                .into_iter()
                .enumerate()
                .filter(|(k, _)| !lost(*k));
            kept.map(|(_, x)| x).collect()
        };
        for (values, counts) in [
            (every(1.0), true),
            (without(&|k| k == 100), true),
            (without(&|k| k % 20 == 3), false),
            (every(0.5), false),
            (every(8.0), false),
        ] {
            assert_eq!(
                Figures::of(&values, &[]).counts_rows(),
                counts,
                "{:?}",
                &values[..30]
            );
        }
    }
}
