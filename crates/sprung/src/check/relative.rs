//! Delays between the channels of a joint, tested where nobody asked.

use sprung_core::parameters::JointParameter;

use super::delay::{DelayEstimate, estimate_delays};
use super::excerpt::Excerpt;
use super::row::fit_rows;
use crate::description::Delay;
use crate::log::Quantity;
use crate::regression::{Reading, SystemPart, solve};

/// Distance at which the curvature of the residual is taken, s, at least: below
/// it the samples at the ends count more than the delay.
const STEP: f64 = 3e-3;

/// Steps of Newton's method, and how far one may go, in those distances.
const STEPS: usize = 10;
const FARTHEST: f64 = 3.0;

/// How far from where it starts a search may end, s: farther off the parabola is
/// not that of the delay.
const REACH: f64 = 0.03;

/// Evidence that one channel alone may leave, as squared standard errors, and as
/// a part of all: more is a second delay.
const LEFT: f64 = 25.0;
const LEFT_PART: f64 = 0.05;

/// What a joint says about delays between its channels.
#[derive(Clone, Debug, PartialEq)]
pub struct RelativeDelays {
    /// Joint, from 0.
    pub joint: usize,
    /// The delay of one channel alone that explains the log best.
    pub likely: ChannelDelay,
    /// Delay of the torque against the motor position.
    pub torque: ChannelDelay,
    /// Delay of the link against the motor position, if it has a channel.
    pub link: Option<ChannelDelay>,
    /// Whether no channel alone explains the log: both of these do.
    pub both: bool,
    /// How far from none the delays are, as a sum of squares in standard errors.
    pub evidence: f64,
    /// Residual of the torque's row as a part of the torque, root mean squares,
    /// without and with the delays.
    pub torque_residual: [f64; 2],
    /// Residual of the link's row as a part of the spring's torque, likewise;
    /// none without a link position.
    pub link_residual: Option<[f64; 2]>,
}

/// A delay of a channel, with its standard error, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelDelay {
    /// Index of the channel in [`Channels::all`](crate::log::Channels::all).
    pub channel: usize,
    /// How much later than the others it was recorded.
    pub delay: f64,
    /// Standard error.
    pub standard_error: f64,
}

/// One joint while its delays are searched.
#[derive(Clone, Copy, Debug)]
struct Joint {
    joint: usize,
    torque: usize,
    motor: usize,
    // Nothing if the link has no channel of its own.
    link: Option<usize>,
    of_torque: Minimum,
    of_link: Minimum,
}

/// Where the residual of a row is least.
#[derive(Clone, Copy, Debug)]
struct Minimum {
    // A whole number of samples, s.
    at: f64,
    delay: f64,
    // Half the second derivative of the squared residual.
    curvature: f64,
    // Squared residuals as parts of the right-hand side.
    cost: f64,
    without: f64,
    // Right-hand side without delays, squared.
    scale: f64,
    active: bool,
}

impl Default for Minimum {
    fn default() -> Self {
        Self {
            at: 0.0,
            delay: 0.0,
            curvature: f64::NAN,
            cost: f64::NAN,
            without: f64::NAN,
            scale: 1.0,
            active: true,
        }
    }
}

impl Minimum {
    /// Returns the standard error, s.
    ///
    /// - `independent`: residuals that do not depend on each other.
    fn error(&self, independent: f64) -> f64 {
        // Of a fit without residual nothing is uncertain; never below rounding.
        (self.cost.max(1e-12) / (independent * self.curvature)).sqrt()
    }

    /// Moves to the minimum of the parabola through costs before, at and behind
    /// the place.
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
            -FARTHEST * h * slope.signum()
        };
        let by = by.clamp(-FARTHEST * h, FARTHEST * h);
        self.delay = self.at + by;
        self.cost = centre + slope * by + self.curvature * by * by;
        let whole = (by / period).round() * period;
        self.active = whole.abs() > 0.5 * period;
        self.at += whole;
    }
}

/// Which row is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Torque,
    Link,
}

impl Joint {
    fn minimum(&mut self, side: Side) -> &mut Minimum {
        match side {
            Side::Torque => &mut self.of_torque,
            Side::Link => &mut self.of_link,
        }
    }
}

/// Finds the delays between torque, motor position and link position of every
/// joint.
///
/// - `weak`: joints whose delay may be long, as a negative stiffness or a torque
///   that is not explained show; from them the whole range of
///   [`estimate_delays`] is searched first.
///
/// Only delays between channels show. That of the link against the motor is the one
/// that leaves the least of the spring's torque unexplained by the link's motion,
/// that of the torque the one that leaves the least of it unexplained by the
/// motor's: in the torque's row a late link is hardly different from more viscous
/// friction. Which channel it is that comes late is told by which alone would do.
/// Joints with a delay in the description are passed over, and rigid joints have
/// one delay, said of the torque.
///
/// Returns nothing of joints whose excerpt is too short.
#[must_use]
pub fn relative_delays(
    excerpt: &Excerpt,
    reading: &Reading<'_>,
    weak: &[usize],
) -> Vec<RelativeDelays> {
    let mut joints = candidates(reading);
    let search = Search { excerpt, reading };
    search.without(&mut joints);
    search.begin_far_away(&mut joints, weak);
    for side in [Side::Link, Side::Torque] {
        let begun: Vec<f64> = joints.iter_mut().map(|j| j.minimum(side).at).collect();
        for _ in 0..STEPS + joints.len() {
            if !joints.iter_mut().any(|joint| joint.minimum(side).active) {
                break;
            }
            search.step(&mut joints, side);
        }
        for (joint, begun) in joints.iter_mut().zip(begun) {
            let minimum = joint.minimum(side);
            if minimum.active || (minimum.delay - begun).abs() > REACH {
                minimum.curvature = f64::NAN;
                minimum.at = begun;
            }
        }
    }
    let independent = independent(excerpt, reading);
    (joints.iter())
        .filter_map(|joint| told(joint, independent))
        .collect()
}

/// Returns how many filtered residuals of an excerpt do not depend on each
/// other: they agree over about 2/λ.
pub(super) fn independent(excerpt: &Excerpt, reading: &Reading<'_>) -> f64 {
    (excerpt.duration() * reading.settings.filter_cutoff_rad_per_s / 2.0).max(1.0)
}

fn candidates(reading: &Reading<'_>) -> Vec<Joint> {
    let channels = reading.channels;
    let given = |joint: usize| {
        (channels.all.iter()).any(|channel| {
            let zero = matches!(channel.delay, Some(Delay::Known(delay)) if delay == 0.0);
            channel.joint == joint && channel.delay.is_some() && !zero
        })
    };
    (0..reading.model.joint_count())
        .filter(|&joint| !given(joint))
        .filter_map(|joint| {
            let link = [Quantity::LinkPosition, Quantity::LinkDeflection];
            let link = (link.into_iter()).find_map(|quantity| channels.index(quantity, joint));
            Some(Joint {
                joint,
                torque: channels.index(Quantity::MotorTorque, joint)?,
                motor: channels.index(Quantity::MotorPosition, joint)?,
                link,
                of_torque: Minimum::default(),
                of_link: Minimum {
                    active: link.is_some(),
                    ..Minimum::default()
                },
            })
        })
        .collect()
}

/// What delays are searched in.
struct Search<'a> {
    excerpt: &'a Excerpt,
    reading: &'a Reading<'a>,
}

impl Search<'_> {
    /// Finds the residuals without delays.
    fn without(&self, joints: &mut [Joint]) {
        for side in [Side::Torque, Side::Link] {
            let costs = self.costs(joints, side, 0.0);
            for (joint, (squares, scale)) in joints.iter_mut().zip(costs) {
                let minimum = joint.minimum(side);
                minimum.without = squares / scale;
                minimum.scale = scale;
            }
        }
    }

    /// Starts joints at a long delay of one of their channels, where that
    /// explains them best.
    fn begin_far_away(&self, joints: &mut [Joint], weak: &[usize]) {
        if !joints.iter().any(|joint| weak.contains(&joint.joint)) {
            return;
        }
        let mut best = vec![f64::INFINITY; joints.len()];
        let sides: [fn(&Joint) -> Option<usize>; 3] = [
            |joint| joint.link,
            |joint| Some(joint.motor),
            |joint| Some(joint.torque),
        ];
        for (side, channel) in sides.iter().enumerate() {
            let wanted: Vec<usize> = (joints.iter())
                .filter(|joint| weak.contains(&joint.joint))
                .filter_map(channel)
                .collect();
            if wanted.is_empty() {
                continue;
            }
            let found = estimate_delays(self.excerpt, self.reading, &wanted).unwrap_or_default();
            for (joint, best) in joints.iter_mut().zip(&mut best) {
                let own = channel(joint);
                let Some(found) = (found.iter()).find(|found| Some(found.channel) == own) else {
                    continue;
                };
                if usable(found) && found.with.relative_residual < *best {
                    *best = found.with.relative_residual;
                    (joint.of_torque.at, joint.of_link.at) = match side {
                        0 => (0.0, found.delay),
                        1 => (-found.delay, -found.delay),
                        _ => (found.delay, 0.0),
                    };
                }
            }
        }
    }

    /// Moves every active joint by one step of Newton's method.
    fn step(&self, joints: &mut [Joint], side: Side) {
        let period = self.excerpt.period();
        let h = period * (STEP / period).ceil().max(1.0);
        let [left, centre, right] = [-h, 0.0, h].map(|by| self.costs(joints, side, by));
        let before: Vec<f64> = joints.iter_mut().map(|j| j.minimum(side).at).collect();
        for (i, joint) in joints.iter_mut().enumerate() {
            let minimum = joint.minimum(side);
            if minimum.at.is_finite() && (joint.link.is_some() || side == Side::Torque) {
                let minimum = joint.minimum(side);
                // Over a right-hand side that is not the delay's: a late link makes the
                // spring's torque large, and any residual small beside it.
                let cost = |costs: &[(f64, f64)]| costs[i].0 / minimum.scale;
                minimum.step([cost(&left), cost(&centre), cost(&right)], h, period);
            }
        }
        if side == Side::Link {
            // Links move each other: the one that gains most goes first, and what
            // the others seemed to gain may be gone then.
            let gain = |joint: &mut Joint, i: usize| {
                let minimum = joint.minimum(side);
                let gain = 1.0 - minimum.cost * minimum.scale / centre[i].0;
                if minimum.active && gain.is_finite() {
                    gain
                } else {
                    f64::NEG_INFINITY
                }
            };
            let gains: Vec<f64> = (joints.iter_mut().enumerate())
                .map(|(i, joint)| gain(joint, i))
                .collect();
            let first = (0..gains.len()).max_by(|&a, &b| gains[a].total_cmp(&gains[b]));
            for (i, joint) in joints.iter_mut().enumerate() {
                if Some(i) != first {
                    joint.minimum(side).at = before[i];
                }
            }
        }
    }

    /// Squared residuals and right-hand sides of the rows of all joints, with the
    /// delays of one side moved; not a number where there is none.
    fn costs(&self, joints: &[Joint], side: Side, by: f64) -> Vec<(f64, f64)> {
        let mut delays = self.reading.delays.to_vec();
        for joint in joints {
            let more = |of: Side| if of == side { by } else { 0.0 };
            if side == Side::Torque {
                delays[joint.torque] += joint.of_torque.at + more(Side::Torque);
            }
            if let Some(link) = joint.link {
                delays[link] += joint.of_link.at + more(Side::Link);
            }
        }
        let reading = Reading {
            delays: &delays,
            ..*self.reading
        };
        let none = || vec![(f64::NAN, f64::NAN); joints.len()];
        if side == Side::Link {
            return self.link_costs(&reading, joints).unwrap_or_else(none);
        }
        let own: Vec<usize> = joints.iter().map(|joint| joint.joint).collect();
        fit_rows(self.excerpt, &reading, &own).map_or_else(none, |fits| {
            fits.iter().map(|fit| (fit.squares, fit.torque)).collect()
        })
    }

    /// The same of the links' rows, whose right-hand side is the torque of a
    /// spring of stiffness 1.
    fn link_costs(&self, reading: &Reading<'_>, joints: &[Joint]) -> Option<Vec<(f64, f64)>> {
        let model = reading.model;
        let rows: Vec<usize> = joints.iter().map(|joint| joint.joint).collect();
        let whole = self.excerpt.reduce_rows(reading, &rows)?.whole()?;
        let cost = |(&row, factor): (&usize, &crate::regression::Triangle)| {
            let stiffness = model.index(JointParameter::Stiffness, row)?;
            let columns = model.row_columns(row);
            let known: Vec<Option<f64>> = (columns.iter())
                .map(|&column| (column == stiffness).then_some(1.0))
                .collect();
            let factor = factor.with_known(&known);
            let local: Vec<usize> = (0..factor.unknowns()).collect();
            let part = SystemPart {
                columns: &local,
                factor: &factor,
            };
            let x = solve(&[part], local.len())?.x;
            let squares: f64 = factor.residual(&x).iter().map(|r| r * r).sum();
            Some((squares, factor.rhs_norm().powi(2)))
        };
        let costs = rows.iter().zip(&whole).map(cost);
        Some(
            costs
                .map(|cost| cost.unwrap_or((f64::NAN, f64::NAN)))
                .collect(),
        )
    }
}

fn usable(found: &DelayEstimate) -> bool {
    found.found && found.with.stiffness.is_none_or(|stiffness| stiffness > 0.0)
}

/// Says which channel it is.
fn told(joint: &Joint, independent: f64) -> Option<RelativeDelays> {
    let (torque, link) = (&joint.of_torque, &joint.of_link);
    let errors = [torque.error(independent), link.error(independent)];
    let own = |minimum: &Minimum, channel: usize| ChannelDelay {
        channel,
        delay: minimum.delay,
        standard_error: minimum.error(independent),
    };
    let residual = |minimum: &Minimum| [minimum.without.sqrt(), minimum.cost.max(0.0).sqrt()];
    let alone = own(torque, joint.torque);
    if !(errors[0].is_finite() && errors[0] > 0.0) {
        return None;
    }
    let Some(channel) = joint
        .link
        .filter(|_| errors[1].is_finite() && errors[1] > 0.0)
    else {
        return Some(RelativeDelays {
            joint: joint.joint,
            likely: alone,
            torque: alone,
            link: None,
            both: false,
            evidence: (torque.delay / errors[0]).powi(2),
            torque_residual: residual(torque),
            link_residual: None,
        });
    };
    let v = [torque.delay, link.delay];
    let weights = errors.map(|error| 1.0 / (error * error));
    let product =
        |a: [f64; 2], b: [f64; 2]| -> f64 { (0..2).map(|i| weights[i] * a[i] * b[i]).sum() };
    let evidence = product(v, v);
    let candidates = [
        ([1.0, 0.0], joint.torque),
        ([0.0, 1.0], channel),
        ([-1.0, -1.0], joint.motor),
    ]
    .map(|(direction, channel)| {
        let size = product(direction, direction);
        let delay = product(direction, v) / size;
        let found = ChannelDelay {
            channel,
            delay,
            standard_error: (1.0 / size).sqrt(),
        };
        (evidence - delay * delay * size, found)
    });
    let (left, likely) = (candidates.into_iter()).min_by(|a, b| a.0.total_cmp(&b.0))?;
    // A share of the evidence that one channel leaves is the model's fault.
    let both = left > LEFT && left > LEFT_PART * evidence;
    Some(RelativeDelays {
        joint: joint.joint,
        likely,
        torque: alone,
        link: Some(own(link, channel)),
        both,
        evidence,
        torque_residual: residual(torque),
        link_residual: Some(residual(link)),
    })
}
