//! Certificates that a motion keeps its limits, between samples too.
//!
//! A bound of the second derivative, or an enclosure of all values on a time interval, decides over the interval. An
//! interval that neither keeps nor breaks a limit is halved.

use std::f64::consts::TAU;

use sprung_core::drives::Drive;
use sprung_core::links::Step;
use sprung_core::robot::Values;
use sprung_core::scalar::Scalar;

use super::bounds::{Bounds, FREE_HEIGHT, Interval, Limited, height_used};
use super::enclosure::Enclosure;
use super::fourier::{ORDERS, Series};
use super::kept::{Broken, Kept, Peaks, broken};
use super::kinematics::Kinematics;
use super::problem::ORDERS as ORDERS_LIMITED;
use crate::model::{Model, Theta};

/// Shortest interval, s.
const SHORTEST: f64 = 1e-7;

/// Tolerated difference between the certified bound of a peak and its value.
const FINE: f64 = 5e-3;

/// Certifies the reference of each joint: positions, velocities, accelerations, jerks.
///
/// # Errors
///
/// [`Broken`] with the first limit that the series breaks.
pub(super) fn certify_reference(series: &Series, bounds: &Bounds) -> Result<Vec<Kept>, Broken> {
    let mut peaks = Peaks::default();
    let most = series.harmonics.last().copied().unwrap_or(1);
    let pieces = 16 * most;
    for (joint, joint_bounds) in bounds.joints.iter().enumerate() {
        for (order, what) in ORDERS_LIMITED.into_iter().enumerate() {
            let interval = joint_bounds.orders[order];
            if !interval.is_limited() {
                continue;
            }
            let bend = series.bound(joint, order as i32 + 2);
            let place = |time: f64| interval.place(series.at(joint, time)[order]).abs();
            let mut known: f64 = 0.0;
            let length = series.period() / pieces as f64;
            let mut open: Vec<[f64; 2]> = (0..pieces)
                .rev()
                .map(|k| [length * k as f64, length])
                .collect();
            let mut peak = (0.0, 0.0);
            while let Some([from, length]) = open.pop() {
                let ends = [from, from + length].map(place);
                let least = ends[0].max(ends[1]);
                known = known.max(least);
                let bound = least + length * length / 8.0 * bend / interval.half;
                if least > 1.0 {
                    let time_s = if ends[0] >= ends[1] {
                        from
                    } else {
                        from + length
                    };
                    let value = series.at(joint, time_s)[order];
                    return Err(broken(what, joint, time_s, value, least));
                }
                if bound <= 1.0 && bound <= known + FINE || length < SHORTEST {
                    if bound > peak.0 {
                        peak = (bound, from + 0.5 * length);
                    }
                } else {
                    let half = 0.5 * length;
                    open.push([from + half, half]);
                    open.push([from, half]);
                }
            }
            peaks.note(what, joint, peak.0.min(1.0), peak.1);
        }
    }
    Ok(peaks.0)
}

/// A motion of which all derivatives are bounded.
pub(super) trait Path {
    /// Returns a position and its first four derivatives.
    fn at(&self, joint: usize, time: f64) -> [f64; ORDERS];
    /// Returns a bound of a derivative, up to the fourth.
    fn bound(&self, joint: usize, order: i32) -> f64;
    /// Returns the length of the motion, s, and the number of first intervals.
    fn pieces(&self) -> (f64, usize);
}

impl Path for Series {
    fn at(&self, joint: usize, time: f64) -> [f64; ORDERS] {
        self.at(joint, time)
    }

    fn bound(&self, joint: usize, order: i32) -> f64 {
        self.bound(joint, order)
    }

    fn pieces(&self) -> (f64, usize) {
        let most = self.harmonics.last().copied().unwrap_or(1);
        (TAU / self.rate, 16 * most)
    }
}

/// Certifies the motion of a robot whose links follow a path; of the springs only the torque counts.
///
/// # Errors
///
/// [`Broken`] with the first limit that the motion breaks.
pub(super) fn certify_followed(
    path: &dyn Path,
    (model, theta): (&Model, &[f64]),
    bounds: &Bounds,
    kinematics: Option<&Kinematics>,
) -> Result<Vec<Kept>, Broken> {
    let n = model.joint_count();
    let mut torques = Torques::new(model, theta);
    let mut peaks = Peaks::default();
    let (duration, pieces) = path.pieces();
    let length = duration / pieces as f64;
    let mut open: Vec<[f64; 2]> = (0..pieces)
        .rev()
        .map(|k| [length * k as f64, length])
        .collect();
    while let Some([from, length]) = open.pop() {
        let half = 0.5 * length;
        let middle = from + half;
        let mut motion = [0, 1, 2].map(|_| vec![Enclosure::ZERO; n]);
        for joint in 0..n {
            let orders = path.at(joint, middle);
            for (order, motion) in motion.iter_mut().enumerate() {
                let slack = half * path.bound(joint, order as i32 + 2);
                let rate = orders[order + 1];
                motion[joint] = Enclosure::new(orders[order], [rate - slack, rate + slack], half);
            }
        }
        let found = torques.places(&motion, bounds, kinematics);
        let mut is_decided = true;
        for &LimitedInterval {
            what,
            joint,
            bound,
            now,
            value,
        } in &found
        {
            if now > 1.0 || bound > 1.0 && length < SHORTEST {
                let value = if what == Limited::Height {
                    bounds.floor.unwrap_or_default() + FREE_HEIGHT * (1.0 - value)
                } else {
                    value
                };
                return Err(broken(what, joint, middle, value, now.max(bound)));
            }
            let known = peaks.part(what, joint).max(now);
            is_decided &= bound <= 1.0 && bound <= known.max(0.5) + FINE;
        }
        if is_decided || length < SHORTEST {
            for place in &found {
                peaks.note(place.what, place.joint, place.bound, middle);
            }
        } else {
            for place in &found {
                peaks.note(place.what, place.joint, place.now, middle);
            }
            open.push([middle, half]);
            open.push([from, half]);
        }
    }
    Ok(peaks.0)
}

/// A limited quantity on a time interval.
struct LimitedInterval {
    what: Limited,
    joint: usize,
    /// Bound of the used part of the limit on the interval.
    bound: f64,
    /// Used part in the middle of the interval.
    now: f64,
    /// Value in the middle.
    value: f64,
}

/// Torques of a motion in which each motor moves with its link.
struct Torques {
    model: Model,
    theta: Theta,
    bodies: Vec<[f64; sprung_core::spatial::BODY]>,
    stiffness: Vec<Option<f64>>,
    steps: Vec<Step<Enclosure>>,
    link: Vec<Enclosure>,
}

impl Torques {
    fn new(model: &Model, theta: &[f64]) -> Self {
        let n = model.joint_count();
        Self {
            bodies: model.bodies(theta),
            theta: theta.to_vec(),
            stiffness: super::physics::Physics::new(model, theta).stiffness,
            steps: vec![Step::default(); n],
            link: vec![Enclosure::ZERO; n],
            model: model.clone(),
        }
    }

    /// Returns the places of all limited quantities on a time interval.
    fn places(
        &mut self,
        motion: &[Vec<Enclosure>; 3],
        bounds: &Bounds,
        kinematics: Option<&Kinematics>,
    ) -> Vec<LimitedInterval> {
        let n = motion[0].len();
        let mut found = Vec::new();
        let mut decide = |what, joint, interval: Interval, range: [f64; 2], value: f64| {
            if interval.is_limited() {
                found.push(LimitedInterval {
                    what,
                    joint,
                    bound: range
                        .map(|x| interval.place(x).abs())
                        .into_iter()
                        .fold(0.0, f64::max),
                    now: interval.place(value).abs(),
                    value,
                });
            }
        };
        let (motor, link) = self.of(motion);
        for (joint, joint_bounds) in bounds.joints.iter().enumerate() {
            let torque = motor[joint];
            decide(
                Limited::Torque,
                joint,
                joint_bounds.torque,
                torque.range(),
                torque.middle(),
            );
            let fastest = torque.fastest();
            decide(
                Limited::TorqueRate,
                joint,
                joint_bounds.torque_rate,
                [fastest; 2],
                fastest,
            );
            if let Some(stiffness) = self.stiffness[joint] {
                let deflection = link[joint] * (1.0 / stiffness);
                let (range, middle) = (deflection.range(), deflection.middle());
                decide(
                    Limited::Deflection,
                    joint,
                    joint_bounds.deflection,
                    range,
                    middle,
                );
            }
        }
        let Some(kinematics) = kinematics else {
            return found;
        };
        let places = kinematics.places(&motion[0], &motion[1]);
        let [x, y, z] = places.velocity;
        let square = x * x + y * y + z * z;
        let speed = |square: f64| square.max(0.0).sqrt();
        let (range, middle) = (square.range().map(speed), speed(square.middle()));
        decide(Limited::ToolSpeed, n - 1, bounds.tool_speed, range, middle);
        if let Some(floor) = bounds.floor {
            let used = |height: f64| height_used(height, floor);
            let interval = Interval {
                middle: 0.0,
                half: 1.0,
            };
            for (point, joint) in kinematics.moving() {
                let height = kinematics.height(&places.points[point]);
                let (range, middle) = (height.range().map(used), used(height.middle()));
                decide(Limited::Height, joint, interval, range, middle);
            }
        }
        found
    }

    /// Returns the torques of motors and links.
    fn of(&mut self, [q, dq, ddq]: &[Vec<Enclosure>; 3]) -> (Vec<Enclosure>, Vec<Enclosure>) {
        let robot = self.model.robot();
        let n = q.len();
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let computed = robot.link_torque(&values, q, dq, ddq, &mut self.steps, &mut self.link);
        if computed.is_err() {
            self.link.fill(Enclosure::constant(f64::NAN));
        }
        let mut motor = vec![Enclosure::ZERO; n];
        let rates = |rates: &[Enclosure], joint: usize| {
            (rates.iter().enumerate())
                .map(|(k, rate)| *rate * robot.ratio(joint, k))
                .fold(Enclosure::ZERO, |sum, rate| sum + rate)
        };
        let mut carried = self.link.clone();
        for term in robot.terms {
            let joint = term.joint;
            let drive = Drive {
                deflection: Enclosure::ZERO,
                deflection_rate: Enclosure::ZERO,
                link_velocity: dq[joint],
                motor_velocity: rates(dq, joint),
                excess: [0.0; sprung_core::covariate::Covariate::COUNT],
                elements: None,
            };
            let inertia = term.momentum(1.0);
            let torque = term.rest(&drive, &robot.shapes[joint]) + rates(ddq, joint) * inertia;
            let contribution = torque * self.theta[term.column];
            let at = robot.joint_of(term.row);
            motor[at] = motor[at] + contribution;
            if term.row < n && self.stiffness[at].is_some() {
                carried[at] = carried[at] + contribution;
            }
        }
        for (motor, link) in motor.iter_mut().zip(&self.link) {
            *motor = *motor + *link;
        }
        (motor, carried)
    }
}
