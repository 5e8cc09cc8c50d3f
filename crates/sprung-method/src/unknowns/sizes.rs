//! Sizes of what was chosen, with the covariance of the rows: both rows of a joint have the noise of its motor torque.
//!
//! The selection weighs each row alone, so that no fault can shrink the equations of a link, which have no torque. Their small noise
//! tells most of a delay.

use faer::Mat;

use super::evidence::Evidence;
use super::rows::Row;
use super::search::Search;
use super::select::SIGNIFICANT;
use super::settle::ChosenRows;
use super::state::State;
use super::unknown::{Kind, Place};
use crate::log::{Channel, Signal};
use crate::prepare::Doubt;

/// Most repetitions, and change in standard errors that ends them.
const MAX_REPETITIONS: usize = 20;
const SETTLED: f64 = 0.1;

/// Held-out squares, relative to those before, that show that the rows share an error of the model and not noise.
const CONTRADICTED: f64 = 1.02;

/// Error of the gain of a torque that all parts of a log share, relative: the accuracy of a filtered regression, whose filter smears
/// reversals.
const ACCURACY_OF_GAIN: f64 = 0.005;

/// Returns the error of the gain of a channel that all parts of a log share: none of a position, which another one confirms.
pub(super) fn accuracy_of_gain(of: &Channel, gain: f64) -> f64 {
    if of.quantity.signal() == Signal::Torque {
        ACCURACY_OF_GAIN * gain
    } else {
        0.0
    }
}

impl Search<'_> {
    /// Repeats the fit of what is chosen, with whitened rows, until its sizes settle, if a delay is among it or an unknown that is
    /// asked for. Delays that the others may have hidden join them if they are significant: those that are expected, and those of a
    /// joint that has one.
    ///
    /// - `weights`: of the rows of the selection, which must not contradict.
    pub(super) fn sized(&self, state: &mut State, weights: &[f64]) -> Option<()> {
        let is_sized = |unknown: &usize| self.is_delay(*unknown) || self.asked.contains(unknown);
        if !state.chosen.iter().any(is_sized) {
            return Some(());
        }
        let mut sized = state.clone();
        self.settle_sizes(&mut sized)?;
        self.join_hidden(&mut sized)?;
        if self.left(&sized, weights)? <= CONTRADICTED * self.left(state, weights)? {
            *state = sized;
        }
        Some(())
    }

    /// Adds the delays that others may have hidden.
    fn join_hidden(&self, state: &mut State) -> Option<()> {
        for unknown in (0..self.unknowns.len()).filter(|&unknown| self.is_delay(unknown)) {
            let expected = self.unknowns[unknown].expected;
            let may_be_hidden = expected > 0.0 || self.has_fellow(unknown, &state.chosen);
            if !may_be_hidden || state.chosen.contains(&unknown) {
                continue;
            }
            let mut with = state.clone();
            with.chosen.push(unknown);
            self.settle_sizes(&mut with)?;
            let size = with.sizes[unknown].abs();
            let is_credible = expected == 0.0 || size <= expected;
            if size > SIGNIFICANT * with.errors[unknown] && is_credible {
                *state = with;
            }
        }
        Some(())
    }

    /// Returns whether an unknown concerns a channel of a joint of which another was chosen.
    fn has_fellow(&self, unknown: usize, chosen: &[usize]) -> bool {
        let joint = |unknown: usize| match self.unknowns[unknown].place {
            Place::Channel(channel) => Some(self.channels.all[channel].joint),
            Place::Joint(_) | Place::All(_) | Place::Robot => None,
        };
        let is_fellow = |&other: &usize| self.is_delay(other) && joint(other) == joint(unknown);
        joint(unknown).is_some() && chosen.iter().any(is_fellow)
    }

    fn is_delay(&self, unknown: usize) -> bool {
        self.unknowns[unknown].kind == Kind::Delay
    }

    fn settle_sizes(&self, state: &mut State) -> Option<()> {
        for _ in 0..MAX_REPETITIONS {
            if self.refit_whitened(state)? <= SETTLED {
                break;
            }
        }
        Some(())
    }

    /// Regresses once with whitened rows; returns the largest change in standard errors.
    fn refit_whitened(&self, state: &mut State) -> Option<f64> {
        let ChosenRows {
            rows,
            theta,
            repeats,
        } = self.rows_of_chosen(state, |_, theta, _, _| theta.to_vec())?;
        let scales = self.scales(&rows);
        let columns = self.columns_of(&state.chosen);
        let alone = self.evidence(&rows, (state, &scales), None, repeats);
        let (rows, weights) = whitened(&rows, &alone.fit(&columns));
        let evidence = self.evidence(&rows, (state, &scales), Some(weights), repeats);
        let moved = self.applied(state, (&evidence, &scales), &theta);
        // A parameter at its bound is not known.
        let errors = evidence.unsigned_errors(&columns, repeats);
        for &unknown in &state.chosen {
            let (of, size) = (&self.unknowns[unknown], state.sizes[unknown]);
            let error = of.after(size, errors[self.free.len() + unknown]) - size;
            state.errors[unknown] = state.errors[unknown].max(error);
        }
        state.doubt = self.doubt(state, &evidence, &errors, repeats);
        Some(moved)
    }

    /// Returns what the errors of delays, and of gains that are asked for, add to the error of each free parameter.
    ///
    /// - `errors`: of all columns.
    fn doubt(
        &self,
        state: &State,
        evidence: &Evidence,
        errors: &[f64],
        repeats: f64,
    ) -> Vec<Doubt> {
        // The estimators take the expected delay of all torques for unknown themselves.
        let is_late =
            |&unknown: &usize| self.is_delay(unknown) && self.unknowns[unknown].expected == 0.0;
        let others: Vec<usize> = (state.chosen.iter().copied())
            .filter(|unknown| !is_late(unknown) && !self.is_gain(*unknown))
            .collect();
        let known = evidence.unsigned_errors(&self.columns_of(&others), repeats);
        let columns = self.columns_of(&state.chosen);
        let mut by_gains = vec![0.0; self.free.len()];
        let mut by_accuracy = by_gains.clone();
        for &gain in (state.chosen.iter()).filter(|&&unknown| self.is_gain(unknown)) {
            let column = self.free.len() + gain;
            let accuracy = self.accuracy(gain, state.sizes[gain]);
            let slopes = evidence.slopes(&columns, column);
            for ((both, shared), slope) in by_gains.iter_mut().zip(&mut by_accuracy).zip(slopes) {
                *both += (errors[column].hypot(accuracy) * slope).powi(2);
                *shared += (accuracy * slope).powi(2);
            }
        }
        (by_gains
            .iter()
            .zip(by_accuracy)
            .zip(errors.iter().zip(&known)))
        .map(|((by_gains, by_accuracy), (error, known))| Doubt {
            by_all: ((error * error - known * known).max(0.0) + by_accuracy).sqrt(),
            by_gains: by_gains.sqrt(),
        })
        .collect()
    }

    /// Returns the error of a gain of this size that all parts of a log share.
    fn accuracy(&self, gain: usize, size: f64) -> f64 {
        match self.unknowns[gain].place {
            Place::Channel(of) => accuracy_of_gain(&self.channels.all[of], 1.0 + size),
            Place::Joint(_) | Place::All(_) | Place::Robot => 0.0,
        }
    }

    /// Returns whether an unknown is a gain that is asked for.
    fn is_gain(&self, unknown: usize) -> bool {
        self.unknowns[unknown].kind == Kind::Gain && self.asked.contains(&unknown)
    }
}

/// Returns rows without the noise that they share with the row before of the same joint, and their weights.
///
/// - `x`: values of all columns.
fn whitened(rows: &[Row], x: &[f64]) -> (Vec<Row>, Vec<f64>) {
    let (mut all, mut weights): (Vec<Row>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut before: Option<(&Row, Vec<f64>)> = None;
    for row in rows {
        let left = residual(row, x);
        let white = match &before {
            Some((motor, noise)) if motor.joint == row.joint => {
                let squares = product(&row.reliable, noise, noise);
                let share = product(&row.reliable, &left, noise) / squares.max(f64::MIN_POSITIVE);
                row.less(motor, share)
            }
            _ => row.clone(),
        };
        let left_white = residual(&white, x);
        let ones = vec![1.0; left.len()];
        let squares = product(&row.reliable, &left_white, &left_white);
        let mean = squares / product(&row.reliable, &ones, &ones);
        weights.push(mean.max(f64::MIN_POSITIVE).sqrt().recip());
        all.push(white);
        before = Some((row, left));
    }
    (all, weights)
}

/// Returns the weighted product of two residuals.
fn product(weights: &[f64], a: &[f64], b: &[f64]) -> f64 {
    (weights.iter().zip(a).zip(b))
        .map(|((weight, a), b)| weight * weight * a * b)
        .sum()
}

/// Returns what the values of the columns leave of a row, \[samples\].
fn residual(row: &Row, x: &[f64]) -> Vec<f64> {
    (0..row.values.nrows())
        .map(|k| {
            let explained: f64 = (row.columns.iter().enumerate())
                .map(|(at, &column)| x[column] * row.values[(k, at)])
                .sum();
            row.values[(k, row.columns.len())] - explained
        })
        .collect()
}

impl Row {
    /// Returns the row less a share of another.
    fn less(&self, other: &Self, share: f64) -> Self {
        let mut columns: Vec<usize> =
            (self.columns.iter().chain(&other.columns).copied()).collect();
        columns.sort_unstable();
        columns.dedup();
        let place = |row: &Self, column: Option<&usize>| match column {
            Some(column) => row.columns.iter().position(|of| of == column),
            None => Some(row.columns.len()),
        };
        let values = Mat::from_fn(self.values.nrows(), columns.len() + 1, |k, at| {
            let of = |row: &Self| place(row, columns.get(at)).map_or(0.0, |at| row.values[(k, at)]);
            of(self) - share * of(other)
        });
        Self {
            joint: self.joint,
            columns,
            values,
            reliable: self.reliable.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    /// Two rows with the same noise of 1 N·m, the second with 0.01 N·m of its own.
    #[test]
    fn rows_lose_the_noise_that_they_share() {
        const SAMPLES: usize = 2000;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut normal = || -> f64 { rng.sample(StandardNormal) };
        let noise: Vec<[f64; 2]> = (0..SAMPLES)
            .map(|_| {
                let common = normal();
                [common, common + 0.01 * normal()]
            })
            .collect();
        // Column 1 is in both rows, 0 in the first and 2 in the second.
        let x = [2.0, 3.0, 4.0];
        let row = |which: usize| Row {
            joint: 3,
            columns: vec![which, which + 1],
            values: Mat::from_fn(SAMPLES, 3, |k, at| {
                let [one, two] = [(0.1 * k as f64).sin(), (0.17 * k as f64).cos()];
                [
                    one,
                    two,
                    x[which] * one + x[which + 1] * two + noise[k][which],
                ][at]
            }),
            reliable: vec![1.0; SAMPLES],
        };
        let (rows, weights) = whitened(&[row(0), row(1)], &x);
        assert_eq!(rows[0].columns, [0, 1]);
        assert_eq!(rows[1].columns, [0, 1, 2]);
        assert!((weights[0] - 1.0).abs() < 0.1, "{weights:?}");
        assert!((weights[1] - 100.0).abs() < 10.0, "{weights:?}");
        let left = residual(&rows[1], &x);
        let shared: f64 = left
            .iter()
            .zip(&noise)
            .map(|(left, noise)| left * noise[0])
            .sum();
        assert!(shared.abs() / (SAMPLES as f64) < 1e-6, "{shared}");
        // Another joint keeps its row.
        let alone = Row { joint: 4, ..row(1) };
        let (rows, _) = whitened(&[row(0), alone], &x);
        assert_eq!(rows[1].columns, [1, 2]);
    }
}
