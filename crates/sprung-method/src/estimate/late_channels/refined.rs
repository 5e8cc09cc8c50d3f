//! Delays of a refinement.

use crate::check::LikelyDelay;
use crate::estimate::result::{RefinedDelay, Refinement};
use crate::estimate::statistics::SIGNIFICANT_SIGMAS;
use crate::estimate::statistics::{MIN_DELAY_SAMPLES, is_significant};

/// Delays and likelihood of a refinement.
pub(super) struct Refined {
    delays: Vec<RefinedDelay>,
    /// Sampling period, s.
    period: f64,
    /// Whether the refinement is used.
    pub(super) used: bool,
    /// Place of its rung in the ladder.
    rung: usize,
    /// Minus the logarithm of the likelihood, per measurement.
    loss: f64,
}

impl Refined {
    /// Returns the delays of a refinement.
    ///
    /// - `period`: sampling period, s.
    pub(super) fn of(refinement: &Refinement, period: f64) -> Self {
        let mut rungs = refinement.rungs.iter();
        let rung = rungs.position(|rung| rung.name == refinement.rung);
        Self {
            delays: refinement.delays.clone(),
            period,
            used: refinement.used,
            rung: rung.unwrap_or(usize::MAX),
            loss: refinement.minus_log_likelihood / refinement.measurements.max(1) as f64,
        }
    }

    /// Returns the result where no filter follows the log.
    pub(super) fn failed() -> Self {
        Self {
            delays: Vec::new(),
            period: 0.0,
            used: false,
            rung: usize::MAX,
            loss: f64::INFINITY,
        }
    }

    /// Returns whether the first rung follows the log. A lower rung, like a failure, may mask a long delay.
    pub(super) fn is_sound(&self) -> bool {
        self.used && self.rung == 0
    }

    /// Returns whether the log is likelier than with another refinement. Likelihoods of different
    /// rungs cannot be compared; a wrong delay needs a lower rung.
    pub(super) fn is_likelier(&self, other: &Self) -> bool {
        (self.rung, self.loss) < (other.rung, other.loss)
    }

    /// Returns the number of rungs among which a rival may be likelier.
    pub(super) fn rungs(&self) -> usize {
        self.rung.saturating_add(1)
    }

    /// Returns the significant delays of some columns, except that of the column `but`.
    pub(super) fn significant(&self, columns: &[&str], but: &str) -> Vec<RefinedDelay> {
        (self.delays.iter())
            .filter(|delay| columns.contains(&delay.column.as_str()) && delay.column != but)
            .filter(|delay| {
                let beyond = delay.delay_s - delay.used_s;
                (delay.standard_error_s)
                    .is_some_and(|error| is_significant(beyond, error, self.period))
            })
            .cloned()
            .collect()
    }

    /// Returns the estimated delay of a column, if it is significant and the search for it has
    /// settled.
    pub(super) fn likely_delay(&self, column: &str) -> Option<LikelyDelay> {
        let delay = self.delays.iter().find(|delay| delay.column == column)?;
        let standard_error = delay.standard_error_s?;
        let rest = (delay.delay_s - delay.used_s).abs();
        if rest > SIGNIFICANT_SIGMAS * standard_error.max(MIN_DELAY_SAMPLES * self.period) {
            return None;
        }
        is_significant(delay.delay_s, standard_error, self.period).then(|| LikelyDelay {
            column: delay.column.clone(),
            delay: delay.delay_s,
            standard_error,
        })
    }

    /// Returns the delays of a joint's columns if they may explain the log: if one of them is
    /// significant, if the torque row shows one, or if the refinement failed, because a long delay
    /// can make it fail. A long delay of one channel may make another one of the joint more
    /// significant.
    ///
    /// - `by_row`: whether the torque row of the joint shows a delay.
    pub(super) fn suspects(&self, columns: &[&str], by_row: bool) -> Vec<RefinedDelay> {
        let follows = self.is_sound() || self.used && !by_row;
        if follows && self.significant(columns, "").is_empty() {
            return Vec::new();
        }
        (columns.iter())
            .map(|&column| {
                let known = self.delays.iter().find(|delay| delay.column == column);
                known.cloned().unwrap_or(RefinedDelay {
                    column: column.to_owned(),
                    delay_s: 0.0,
                    standard_error_s: None,
                    used_s: 0.0,
                })
            })
            .collect()
    }
}

/// Returns the difference of a delay from the assumed one, in standard errors.
pub(super) fn significance(delay: &RefinedDelay) -> f64 {
    (delay.standard_error_s).map_or(0.0, |error| (delay.delay_s - delay.used_s).abs() / error)
}
