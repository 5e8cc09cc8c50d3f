//! Removes the initial momentum of the filter, a nuisance parameter, by projection.

/// Time constants of the filter after which the effect of its start is negligible.
pub(super) const FORGOTTEN_TIME_CONSTANTS: f64 = 10.0;

/// Holds back the first rows after a start until the effect of the initial momentum is removed.
///
/// An error of the initial momentum decays with the filter's pole p, so it adds one column, `p^k`,
/// and one unknown per row of the regressor and start. The released rows are orthogonal to this
/// column, which is equivalent to least squares with the additional unknown.
///
/// # Source
///
/// Eq. (10) with a free initial condition; eq. (23) sets it to zero.
#[derive(Clone, Debug, Default)]
pub(super) struct NuisanceMomentum {
    rows: Vec<Vec<f64>>,
    decay: Vec<f64>,
    over: bool,
}

impl NuisanceMomentum {
    /// Holds a row back; returns false after the effect of the start has decayed.
    ///
    /// - `pole`: p; `weight`: weight of the row.
    pub(super) fn hold(&mut self, row: &[f64], pole: f64, weight: f64) -> bool {
        let at = self.rows.len() as f64;
        if self.over || -at * pole.ln() >= FORGOTTEN_TIME_CONSTANTS {
            return false;
        }
        self.rows.push(row.to_vec());
        self.decay.push(weight * (at * pole.ln()).exp());
        true
    }

    /// Returns the rows that were held back, without the effect of the initial momentum.
    pub(super) fn release(&mut self) -> Vec<Vec<f64>> {
        self.over = true;
        let mut rows = std::mem::take(&mut self.rows);
        let decay = std::mem::take(&mut self.decay);
        let squares: f64 = decay.iter().map(|d| d * d).sum();
        let width = rows.first().map_or(0, Vec::len);
        for column in 0..width {
            let along: f64 = rows
                .iter()
                .zip(&decay)
                .map(|(row, d)| row[column] * d)
                .sum();
            for (row, d) in rows.iter_mut().zip(&decay) {
                row[column] -= d * along / squares;
            }
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decaying_initial_momentum_is_removed() {
        let pole: f64 = 0.97;
        let [mut plain, mut disturbed] = [NuisanceMomentum::default(), NuisanceMomentum::default()];
        for k in 0..1000 {
            let row = [f64::from(k).sin(), f64::from(k).cos()];
            let start = 3.0 * pole.powi(k);
            let held = plain.hold(&row, pole, 0.5);
            let added = [row[0], row[1] + 0.5 * start];
            assert_eq!(held, disturbed.hold(&added, pole, 0.5));
            assert_eq!(held, k < 329, "{k}");
        }
        let [plain, disturbed] = [plain.release(), disturbed.release()];
        assert_eq!(plain.len(), 329);
        for (a, b) in plain.iter().zip(&disturbed) {
            assert!((a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12);
        }
        assert!(plain.iter().any(|row| (row[0]).abs() > 0.5));
    }

    #[test]
    fn a_log_that_ends_early_releases_its_rows() {
        let mut start = NuisanceMomentum::default();
        assert!(start.hold(&[2.0], 0.9, 1.0));
        // The unknown absorbs a single row completely.
        assert!(start.release()[0][0].abs() < 1e-15);
        assert!(start.release().is_empty());
        assert!(!start.hold(&[1.0], 0.9, 1.0));
    }
}
