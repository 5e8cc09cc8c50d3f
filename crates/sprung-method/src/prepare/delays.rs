//! Delays that the description gives or that sprung estimates.

use super::delay::{DelayEstimate, estimate_delays};
use super::excerpt::Excerpt;
use super::held_out::{DelayGain, held_out_at};
use crate::description::{Delay, Estimator};
use crate::finding::{Finding, Severity};
use crate::log::{Channels, Signal};
use crate::regression::Reading;

/// Two estimates of a delay are reported as different beyond this number of standard errors.
const SAME_DELAY_SIGMAS: f64 = 3.0;

/// A delay cannot be estimated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DelayError(String);

/// A delay that the likelihood of a log gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DelayByLikelihood {
    /// Index of the channel in [`Channels::all`].
    pub channel: usize,
    /// Delay of the channel relative to the other channels, s.
    pub delay: f64,
    /// Standard error, s.
    pub standard_error: f64,
}

/// A Stribeck velocity that the likelihood of a log gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VelocityByLikelihood {
    /// Index of the joint.
    pub joint: usize,
    /// Velocity, rad/s (m/s).
    pub velocity: f64,
    /// Standard error, rad/s (m/s).
    pub standard_error: f64,
}

/// Delays and Stribeck velocities that the likelihood of a log gives; empty lists if it gives none.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Likely {
    /// Delays of the channels whose delays are to be estimated.
    pub delays: Vec<DelayByLikelihood>,
    /// Velocities of the joints that the description leaves open.
    pub velocities: Vec<VelocityByLikelihood>,
}

/// Delays in use, with their estimates.
#[derive(Clone, Debug)]
pub struct Delays {
    /// Delay of each channel, s.
    pub values: Vec<f64>,
    estimates: Vec<Estimated>,
    // Whether the refinement has estimated delays or will do so.
    by_likelihood: bool,
}

/// Origin of an estimated delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// No delay is used.
    None,
    /// The search by least squares.
    Search,
    /// The likelihood of the log.
    Likelihood,
}

/// A channel whose delay is to be estimated: the estimates, and the one in use.
#[derive(Clone, Debug)]
struct Estimated {
    search: DelayEstimate,
    likelihood: Option<DelayByLikelihood>,
    used: Origin,
    // Held-out errors without a delay, with the delay of the search and with that of the
    // likelihood; `None` if there is no such estimate or the excerpt is too short.
    held_out: [Option<f64>; 3],
}

impl Estimated {
    /// Returns an estimate of the delay and its standard error, s.
    fn estimate(&self, origin: Origin) -> Option<(f64, f64)> {
        match origin {
            Origin::None => None,
            Origin::Search => {
                (self.search.found).then_some((self.search.delay, self.search.standard_error))
            }
            Origin::Likelihood => {
                let likelihood = self.likelihood?;
                Some((likelihood.delay, likelihood.standard_error))
            }
        }
    }

    /// Chooses the estimate of the likelihood unless it raises the held-out error over that without a
    /// delay, then that of the search if it lowers this error. Without held-out errors the estimate
    /// is used.
    fn choose(&mut self) {
        let accepts = |origin: Origin| {
            let gain = self.held_out[0].zip(self.held_out[origin as usize]);
            let gain = gain.map(|(without, with)| DelayGain { without, with });
            gain.is_none_or(|gain| match origin {
                // Least squares may not show a short delay.
                Origin::Likelihood => !gain.is_higher(),
                Origin::None | Origin::Search => gain.is_lower(),
            })
        };
        let origins = [Origin::Likelihood, Origin::Search];
        let accepted = (origins.into_iter())
            .find(|&origin| self.estimate(origin).is_some() && accepts(origin));
        self.used = accepted.unwrap_or(Origin::None);
    }

    /// Returns the effect of the delay in use on the held-out error, as a clause; empty if the
    /// excerpt is too short.
    fn gain(&self) -> String {
        match self.held_out[..] {
            [Some(without), ..] => {
                let with = self.held_out[self.used as usize];
                with.map_or_else(String::new, |with| {
                    let gain = DelayGain { without, with };
                    format!(
                        "; the delay changes the held-out error of the motor torques {}",
                        gain.words()
                    )
                })
            }
            _ => String::new(),
        }
    }

    /// Returns the estimates that are not used, each with the reason, as clauses.
    fn others(&self) -> String {
        let other = |(origin, words): (Origin, &str)| {
            let (delay, error) = self.estimate(origin).filter(|_| origin != self.used)?;
            let held_out = self.held_out[origin as usize]?;
            let used = self.estimate(self.used).map_or(0.0, |(delay, _)| delay);
            let differs = (delay - used).abs() > SAME_DELAY_SIGMAS * error;
            (differs || self.used == Origin::None).then(|| {
                format!(
                    "; {words} gives {delay:.4} s (standard error {error:.4} s), and with it the \
                     held-out error is {:.2} %",
                    100.0 * held_out
                )
            })
        };
        let all = [
            (Origin::Likelihood, "the likelihood"),
            (Origin::Search, "the search by least squares"),
        ];
        all.into_iter().filter_map(other).collect()
    }

    fn finding(&self, column: &str, by_likelihood: bool) -> Finding {
        let (gain, others) = (self.gain(), self.others());
        let fixed = "give the delay as a number to keep it fixed";
        match (self.used, self.estimate(self.used)) {
            (Origin::Likelihood, Some((delay, error))) => Finding::new(
                Severity::Info,
                "delay-estimated",
                format!(
                    "\"{column}\" was recorded {delay:.6} s late (standard error {error:.6} s), by the \
                     likelihood of the log{gain}{others}"
                ),
                fixed,
            ),
            (_, Some((delay, error))) => Finding::new(
                Severity::Info,
                "delay-estimated",
                format!(
                    "\"{column}\" was recorded {delay:.4} s late (standard error {error:.4} s): with \
                     this delay the motor row leaves {:.1} % of its torque unexplained, without it \
                     {:.1} % (root mean squares){gain}{others}",
                    100.0 * self.search.with.relative_residual,
                    100.0 * self.search.without.relative_residual
                ),
                fixed,
            ),
            (_, None) if by_likelihood => Finding::new(
                Severity::Info,
                "delay-left-to-likelihood",
                format!(
                    "no delay of \"{column}\" explains the motor torque better than zero delay, so \
                     the delay is short or zero; identify estimates it from the likelihood of the \
                     whole robot{others}"
                ),
                "run sprung identify",
            ),
            (_, None) if !others.is_empty() => Finding::new(
                Severity::Info,
                "delay-rejected",
                format!(
                    "sprung uses no delay of \"{column}\"; without it the held-out error of the motor \
                     torques is {:.2} %{others}: the delay would fit an error of the model",
                    100.0 * self.held_out[0].unwrap_or(f64::NAN)
                ),
                "remove the column from delay_s, or give the delay as a number",
            ),
            (_, None) => Finding::new(
                Severity::Serious,
                "delay-not-found",
                format!(
                    "no delay of \"{column}\" between -0.05 s and 0.5 s explains the motor torque \
                     better than its neighbours and than zero delay, and the likelihood of the log \
                     does not determine the delay either; it was set to 0"
                ),
                "give the delay as a number of seconds; check that the log begins with motion \
                 and that all signs are right",
            ),
        }
    }
}

impl Delays {
    /// Takes the delays that the description gives, and estimates those with `Delay::Estimate`.
    ///
    /// - `reading`: contains the given delays.
    ///
    /// # Errors
    ///
    /// [`DelayError`] if the log is too short, or if all channels of one joint are to be estimated.
    pub fn new(reading: &Reading, excerpt: &Excerpt, file: &str) -> Result<Self, DelayError> {
        let (channels, model) = (reading.channels(), reading.model());
        let wanted: Vec<usize> = (0..channels.all.len())
            .filter(|&i| channels.all[i].delay == Some(Delay::Estimate))
            .collect();
        let mut found = Vec::new();
        if !wanted.is_empty() {
            if let Some(joint) = joint_without_reference(channels, model.joints().len()) {
                return Err(DelayError(format!(
                    "delay_s asks to estimate all channels of {}; only delays between channels show in a log, so leave \
                     one of them out, or write delay_s = \"estimate\", which keeps the motor positions",
                    model.joints()[joint]
                )));
            }
            let search = estimate_delays(excerpt, reading, &wanted);
            found = search.ok_or_else(|| {
                DelayError(format!(
                    "{file} is too short to estimate a delay from; give the delay as a number of \
                     seconds"
                ))
            })?;
        }
        let estimated = |search: DelayEstimate| Estimated {
            used: if search.found {
                Origin::Search
            } else {
                Origin::None
            },
            search,
            likelihood: None,
            held_out: [None; 3],
        };
        let mut delays = Self {
            values: reading.delays().to_vec(),
            estimates: found.into_iter().map(estimated).collect(),
            by_likelihood: (reading.settings().estimator).contains(&Estimator::PredictionError),
        };
        delays.accept(reading, excerpt);
        Ok(delays)
    }

    /// Takes the delays that the description gives and estimates no others.
    pub(super) fn given(reading: &Reading) -> Self {
        Self {
            values: reading.delays().to_vec(),
            estimates: Vec::new(),
            by_likelihood: false,
        }
    }

    /// Adds the estimates of the likelihood to those of the search.
    ///
    /// - `refined`: empty if the likelihood gave no estimate.
    pub(super) fn refine(
        &mut self,
        refined: &[DelayByLikelihood],
        reading: &Reading,
        excerpt: &Excerpt,
    ) {
        for estimate in &mut self.estimates {
            let is_of_channel =
                |delay: &&DelayByLikelihood| delay.channel == estimate.search.channel;
            estimate.likelihood = refined.iter().find(is_of_channel).copied();
            if estimate.likelihood.is_some() {
                estimate.used = Origin::Likelihood;
            }
        }
        self.by_likelihood = false;
        if !refined.is_empty() {
            self.accept(reading, excerpt);
        }
    }

    /// Uses the estimate of each channel that cross-validation accepts, the other channels having
    /// their present delays.
    fn accept(&mut self, reading: &Reading, excerpt: &Excerpt) {
        self.set_values();
        let present = reading.with_delays(&self.values);
        for estimate in &mut self.estimates {
            let channel = estimate.search.channel;
            for origin in [Origin::None, Origin::Search, Origin::Likelihood] {
                let delay = match (origin, estimate.estimate(origin)) {
                    (Origin::None, _) => 0.0,
                    (_, Some((delay, _))) => delay,
                    (_, None) => continue,
                };
                estimate.held_out[origin as usize] = held_out_at(excerpt, &present, channel, delay);
            }
            estimate.choose();
        }
        self.set_values();
    }

    fn set_values(&mut self) {
        for estimate in &self.estimates {
            let delay = estimate.estimate(estimate.used);
            self.values[estimate.search.channel] = delay.map_or(0.0, |(delay, _)| delay);
        }
    }

    /// Returns the channels whose estimated delay cross-validation rejected, so that no later stage
    /// estimates it.
    pub(super) fn rejected(&self) -> impl Iterator<Item = usize> {
        (self.estimates.iter())
            .filter(|estimate| estimate.likelihood.is_some() && estimate.used != Origin::Likelihood)
            .map(|estimate| estimate.search.channel)
    }

    /// Returns the delay of a channel, s, and its standard error if sprung estimated it, s.
    #[must_use]
    pub fn used(&self, channel: usize) -> (f64, Option<f64>) {
        let estimate = (self.estimates.iter()).find(|estimate| estimate.search.channel == channel);
        let error = estimate.and_then(|estimate| Some(estimate.estimate(estimate.used)?.1));
        (self.values[channel], error)
    }

    /// Returns findings about the estimated delays.
    #[must_use]
    pub fn findings(&self, channels: &Channels) -> Vec<Finding> {
        let finding = |estimate: &Estimated| {
            let column = &channels.all[estimate.search.channel].column;
            estimate.finding(column, self.by_likelihood)
        };
        self.estimates.iter().map(finding).collect()
    }
}

/// Returns a joint of which all channels are to be estimated.
fn joint_without_reference(channels: &Channels, joints: usize) -> Option<usize> {
    let is_covariate = |signal: Signal| matches!(signal, Signal::Covariate(_));
    (0..joints).find(|&joint| {
        let of_joint = (channels.all.iter())
            .filter(|channel| channel.joint == joint && !is_covariate(channel.quantity.signal()));
        let is_open: Vec<bool> = of_joint
            .map(|channel| channel.delay == Some(Delay::Estimate))
            .collect();
        !is_open.is_empty() && is_open.iter().all(|open| *open)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::MotorRowFit;

    const FIT: MotorRowFit = MotorRowFit {
        stiffness: Some(9.0),
        plausible: true,
        relative_residual: 0.1,
    };

    /// A search that gives 24 ms and a likelihood that gives 1.6 ms.
    fn chosen(held_out: [f64; 3]) -> Estimated {
        let mut estimated = Estimated {
            search: DelayEstimate {
                channel: 0,
                delay: 0.024,
                standard_error: 0.0012,
                found: true,
                without: FIT,
                with: FIT,
            },
            likelihood: Some(DelayByLikelihood {
                channel: 0,
                delay: 0.0016,
                standard_error: 0.0006,
            }),
            used: Origin::Search,
            held_out: held_out.map(Some),
        };
        estimated.choose();
        estimated
    }

    #[test]
    fn the_likelihood_is_used_unless_hold_out_refuses_it() {
        let used = |held_out| chosen(held_out).used;
        assert_eq!(used([0.2, 0.19, 0.2]), Origin::Likelihood);
        assert_eq!(used([0.2, 0.19, 0.21]), Origin::Search);
        assert_eq!(used([0.2, 0.201, 0.21]), Origin::None);
    }

    #[test]
    fn findings_name_the_gain_and_the_other_estimate() {
        let used = chosen([0.2, 0.19, 0.198]).finding("defl1", false);
        assert_eq!(used.code, "delay-estimated");
        assert!(
            used.text.contains("from 20.00 % to 19.80 %"),
            "{}",
            used.text
        );
        assert!(
            used.text.contains("least squares gives 0.0240 s"),
            "{}",
            used.text
        );
        let refused = chosen([0.2, 0.201, 0.21]).finding("defl1", false);
        assert_eq!(refused.code, "delay-rejected");
        assert!(
            refused.text.contains("the likelihood gives 0.0016 s"),
            "{}",
            refused.text
        );
    }
}
