//! Tests for delays between the channels of a joint that the description does not mention.

use crate::description::Delay;
use crate::log::Signal;
use crate::prepare::{Excerpt, estimate_delays, fit_rows, independent};
use crate::regression::Reading;

/// Smallest distance for the curvature of the residual, s. At smaller distances, samples that enter
/// or leave at the ends change the residual more than the delay does.
const CURVATURE_STEP_S: f64 = 3e-3;

/// Newton steps, and the longest step in distances of the curvature.
const NEWTON_STEPS: usize = 10;
const LONGEST_NEWTON_STEP: f64 = 3.0;

/// Longest delay that Newton's method may find, s; farther away the parabola does not describe the
/// delay.
const MAX_SHORT_DELAY_S: f64 = 0.03;

/// A long delay is accepted if it reduces the residual below this fraction.
const LONG_DELAY_RESIDUAL_SHARE: f64 = 0.9;

/// Delays between the channels of a joint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RelativeDelays {
    /// Joint, from 0.
    pub joint: usize,
    /// The delay of a single channel that explains the torque best.
    pub likely: ChannelDelay,
    /// Residual of the torque row over the torque, root mean squares, without and with the delay.
    pub residual: [f64; 2],
}

/// A delay of a channel, with its standard error, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChannelDelay {
    /// Index of the channel in [`Channels::all`](crate::log::Channels::all).
    pub channel: usize,
    /// Delay of the channel relative to the others.
    pub delay: f64,
    /// Standard error.
    pub standard_error: f64,
}

/// State of the search for the torque delay of one joint.
#[derive(Clone, Copy, Debug)]
struct Joint {
    number: usize,
    torque: usize,
    motor: usize,
    // `None` if the link has no channel.
    link: Option<usize>,
    // Current delay for the next step, a whole number of samples, s.
    at: f64,
    delay: f64,
    // Half the second derivative of the squared residual.
    curvature: f64,
    // Squared residuals over the squared torque, with and without the delay.
    cost: f64,
    without: f64,
    active: bool,
}

impl Joint {
    /// Moves to the minimum of the parabola through the costs before, at and after the current
    /// delay.
    fn step(&mut self, costs: [f64; 3], h: f64, period: f64) {
        let [left, centre, right] = costs;
        let slope = (right - left) / (2.0 * h);
        self.curvature = (right - 2.0 * centre + left) / (2.0 * h * h);
        if !(slope.is_finite() && self.curvature.is_finite()) {
            self.active = false;
            self.curvature = f64::NAN;
            return;
        }
        let by = if self.curvature > 0.0 {
            -slope / (2.0 * self.curvature)
        } else {
            -LONGEST_NEWTON_STEP * h * slope.signum()
        };
        let by = by.clamp(-LONGEST_NEWTON_STEP * h, LONGEST_NEWTON_STEP * h);
        self.delay = self.at + by;
        self.cost = centre + slope * by + self.curvature * by * by;
        // Truncation avoids endless steps between two samples.
        let whole = (by / period).trunc() * period;
        self.active = whole.abs() > 0.5 * period;
        self.at += whole;
    }

    /// Returns the late channel: the torque, or the motor if the torque's delay is negative. `None`
    /// if the search has not converged.
    ///
    /// - `independent`: number of independent residuals.
    fn converged(&self, independent: f64) -> Option<RelativeDelays> {
        // The residual of an exact fit is at least at the level of rounding errors.
        let variance = self.cost.max(1e-12) / (independent * self.curvature);
        let settled = !self.active && self.delay.abs() < MAX_SHORT_DELAY_S;
        (settled && variance > 0.0 && variance.is_finite()).then(|| RelativeDelays {
            joint: self.number,
            likely: ChannelDelay {
                channel: if self.delay < 0.0 {
                    self.motor
                } else {
                    self.torque
                },
                delay: self.delay.abs(),
                standard_error: variance.sqrt(),
            },
            residual: [self.without.sqrt(), self.cost.max(0.0).sqrt()],
        })
    }
}

/// Finds the delay between torque and motor position of every joint, by Newton's method on the
/// residual of the torque row.
///
/// - `weak`: joints with a negative stiffness or an unexplained torque. Their delay may be long, so
///   all their channels are searched in the whole range of [`estimate_delays`].
///
/// Only delays between channels can be determined. A slightly late link resembles more viscous
/// friction of the motor and less of the link: such delays need the likelihood of the whole robot.
/// Joints with a delay in the description are skipped.
///
/// Joints are missing in the result if the excerpt is too short.
#[must_use]
pub(crate) fn relative_delays(
    excerpt: &Excerpt,
    reading: &Reading,
    weak: &[usize],
) -> Vec<RelativeDelays> {
    let mut joints = candidates(reading);
    let search = Search { excerpt, reading };
    let costs = search.costs(&joints, 0.0);
    for (joint, cost) in joints.iter_mut().zip(costs) {
        joint.without = cost;
    }
    let long = search.long_delays(&joints, weak);
    for _ in 0..NEWTON_STEPS {
        if !joints.iter().any(|joint| joint.active) {
            break;
        }
        search.step(&mut joints);
    }
    let independent = independent(excerpt, reading);
    (joints.iter())
        .filter_map(|joint| {
            let long = long.iter().find(|long| long.joint == joint.number);
            long.cloned().or_else(|| joint.converged(independent))
        })
        .collect()
}

fn candidates(reading: &Reading) -> Vec<Joint> {
    let channels = reading.channels();
    let given = |joint: usize| {
        (channels.all.iter()).any(|channel| {
            let zero = matches!(channel.delay, Some(Delay::Known(delay)) if delay == 0.0);
            channel.joint == joint && channel.delay.is_some() && !zero
        })
    };
    (0..reading.model().joint_count())
        .filter(|&joint| !given(joint))
        .filter_map(|joint| {
            Some(Joint {
                number: joint,
                torque: channels.telling(Signal::Torque, joint)?,
                motor: channels.telling(Signal::Motor, joint)?,
                link: channels.telling(Signal::Link, joint),
                at: 0.0,
                delay: 0.0,
                curvature: f64::NAN,
                cost: f64::NAN,
                without: f64::NAN,
                active: true,
            })
        })
        .collect()
}

/// Data of the search for delays.
struct Search<'a> {
    excerpt: &'a Excerpt,
    reading: &'a Reading,
}

impl Search<'_> {
    /// Finds a long delay of a single channel for each weak joint: the one that explains the torque
    /// best.
    fn long_delays(&self, joints: &[Joint], weak: &[usize]) -> Vec<RelativeDelays> {
        let mut all: Vec<RelativeDelays> = Vec::new();
        let sides: [fn(&Joint) -> Option<usize>; 3] = [
            |joint| joint.link,
            |joint| Some(joint.motor),
            |joint| Some(joint.torque),
        ];
        for channel in sides {
            let weak: Vec<(usize, usize)> = (joints.iter())
                .filter(|joint| weak.contains(&joint.number))
                .filter_map(|joint| Some((joint.number, channel(joint)?)))
                .collect();
            let wanted: Vec<usize> = weak.iter().map(|&(_, channel)| channel).collect();
            if wanted.is_empty() {
                continue;
            }
            let found = estimate_delays(self.excerpt, self.reading, &wanted).unwrap_or_default();
            for ((joint, _), found) in weak.iter().zip(&found) {
                let [without, with] = [found.without, found.with].map(|fit| fit.relative_residual);
                let plausible = found.with.stiffness.is_none_or(|stiffness| stiffness > 0.0);
                if !(found.found && plausible && with < LONG_DELAY_RESIDUAL_SHARE * without) {
                    continue;
                }
                let before = all.iter().position(|other| other.joint == *joint);
                if let Some(before) = before {
                    if all[before].residual[1] <= with {
                        continue;
                    }
                    all.remove(before);
                }
                all.push(RelativeDelays {
                    joint: *joint,
                    likely: ChannelDelay {
                        channel: found.channel,
                        delay: found.delay,
                        standard_error: found.standard_error,
                    },
                    residual: [without, with],
                });
            }
        }
        all
    }

    /// Moves every active joint by one Newton step.
    fn step(&self, joints: &mut [Joint]) {
        let period = self.excerpt.period();
        let h = period * (CURVATURE_STEP_S / period).ceil().max(1.0);
        let [left, centre, right] = [-h, 0.0, h].map(|by| self.costs(joints, by));
        for (i, joint) in joints.iter_mut().enumerate() {
            if joint.active {
                joint.step([left[i], centre[i], right[i]], h, period);
            }
        }
    }

    /// Returns squared residuals of the torque rows over the squared torque, with all torques
    /// shifted by `by`, s; not a number if the rows cannot be fitted.
    fn costs(&self, joints: &[Joint], by: f64) -> Vec<f64> {
        let mut delays = self.reading.delays().to_vec();
        for joint in joints {
            delays[joint.torque] += joint.at + by;
        }
        let reading = self.reading.with_delays(&delays);
        let numbers: Vec<usize> = joints.iter().map(|joint| joint.number).collect();
        let fits = fit_rows(self.excerpt, &reading, &numbers);
        fits.map_or_else(
            || vec![f64::NAN; joints.len()],
            |fits| {
                (fits.iter())
                    .map(|fit| fit.relative_residual().powi(2))
                    .collect()
            },
        )
    }
}
