//! Least squares of one column of a row by others, as a spring's deflection by its torque.

use super::jackknife::{influences, scatter};
use super::least_squares::student_95;
use crate::regression::{SystemPart, Triangle, solve};

/// The coefficient of the first of several columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColumnFit {
    pub(crate) value: f64,
    /// By the disagreement of segments of the log, and at least that of residuals which are correlated over the memory
    /// of the filters: few segments of a slow motion may agree by chance.
    pub(crate) standard_error: f64,
    /// Squared length of the part of the first column that the other columns do not explain, over the squared length of
    /// the column.
    pub(crate) unexplained_share: f64,
    /// Student's quantile for this number of segments over that of the normal distribution.
    pub(crate) few_segments: f64,
}

impl ColumnFit {
    /// Fits a column of a row by other columns; `None` if the segments do not determine the first coefficient. Noise of
    /// the fitted column does not bias the coefficients.
    ///
    /// - `(segments, memory)`: factors of the row, segment by segment, and the time over which the filters correlate
    ///   residuals, over the duration of the log.
    /// - `of`: the fitted column; `by`: columns that explain it. The right-hand side counts as the last column.
    pub(crate) fn new(
        (segments, memory): (&[&Triangle], f64),
        of: usize,
        by: &[usize],
    ) -> Option<Self> {
        let width = segments.first()?.unknowns() + 1;
        let unit = |column: usize, value: f64| -> Vec<f64> {
            let mut vector = vec![0.0; width];
            vector[column] = value;
            vector
        };
        let directions: Vec<Vec<f64>> = by.iter().map(|&column| unit(column, 1.0)).collect();
        let at = unit(of, -1.0);
        let triangles: Vec<Vec<Triangle>> = (segments.iter())
            .map(|factor| vec![factor.along(&at, &directions)])
            .collect();
        let whole = Triangle::merge(triangles.iter().flatten())?;
        let columns: Vec<usize> = (0..by.len()).collect();
        let part = SystemPart {
            columns: &columns,
            factor: &whole,
        };
        let solution = solve(&[part], by.len())?;
        let errors = scatter(&influences(
            &solution,
            std::slice::from_ref(&columns),
            &triangles,
        ));
        let squares: f64 = whole.residual(&solution.x).iter().map(|r| r * r).sum();
        let of_residuals = (squares * solution.inverse[(0, 0)] * memory).sqrt();
        let error = errors[0].max(of_residuals);
        let is_known = *solution.identifiable.first()? && error.is_finite() && error > 0.0;
        is_known.then(|| Self {
            value: solution.x[0],
            unexplained_share: (solution.inverse[(0, 0)] * whole.column_norm(0).powi(2)).recip(),
            standard_error: error,
            few_segments: student_95(triangles.len().saturating_sub(1)) / student_95(usize::MAX),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a spring: deflection, constant, constant again, torque.
    fn segment(g: u32, compliance: f64, noise: f64) -> Triangle {
        let rows: Vec<[f64; 4]> = (0..50)
            .map(|k| {
                let t = f64::from(50 * g + k) * 0.13;
                let torque = 20.0 * t.sin() + 7.0;
                let deflection = compliance * torque + 2e-4 + noise * (17.0 * t * t).sin();
                [deflection, -1.0, 1.0, torque]
            })
            .collect();
        Triangle::of(&rows)
    }

    fn fit(compliance: f64, noise: f64) -> Option<ColumnFit> {
        let all: Vec<Triangle> = (0..16).map(|g| segment(g, compliance, noise)).collect();
        let all: Vec<&Triangle> = all.iter().collect();
        ColumnFit::new((&all, 0.0), 0, &[3, 1, 2])
    }

    #[test]
    fn noise_of_the_deflection_does_not_bias_the_compliance() {
        let found = fit(1e-6, 1e-4).unwrap();
        let expected = 1e-4 / 2f64.sqrt() / 14.0 / 800f64.sqrt();
        assert!((found.value - 1e-6).abs() < 3.0 * found.standard_error);
        let ratio = found.standard_error / expected;
        assert!((0.5..2.0).contains(&ratio), "{ratio}");
        assert!((found.few_segments - 2.131 / 1.96).abs() < 0.01);
        // The constants explain the mean: 7² of 7² + 20²/2.
        assert!((found.unexplained_share - 200.0 / 249.0).abs() < 0.02);
    }

    #[test]
    fn segments_that_agree_by_chance_do_not_hide_the_residual() {
        // Every segment is the same, so they agree exactly.
        let same = segment(0, 1e-6, 1e-4);
        let error = |memory: f64| {
            let found = ColumnFit::new((&[&same; 16], memory), 0, &[3, 1]);
            found.map_or(0.0, |found| found.standard_error)
        };
        let agreement = error(0.0);
        // 50 of 800 samples are one independent residual.
        let expected = error(1.0 / 16.0);
        let longer = error(4.0 / 16.0);
        assert!(agreement < 0.01 * expected, "{agreement} {expected}");
        assert!((longer / expected - 2.0).abs() < 1e-6);
    }

    #[test]
    fn segments_without_motion_determine_nothing() {
        assert!(ColumnFit::new((&[], 0.0), 0, &[3]).is_none());
        let still = Triangle::of(&[[1.0, 1.0, 1.0, 0.0]; 9]);
        assert!(ColumnFit::new((&[&still; 8], 0.0), 0, &[3, 1]).is_none());
    }
}
