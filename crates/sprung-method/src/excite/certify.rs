//! Certificates that a motion keeps its limits, between samples too.
//!
//! A bound of the second derivative, or an enclosure of all values on a time interval, decides over the interval. An
//! interval that neither keeps nor breaks a limit is halved.

use std::f64::consts::TAU;

use serde::Serialize;
use sprung_core::drives::Drive;
use sprung_core::links::Step;
use sprung_core::robot::Values;
use sprung_core::scalar::Scalar;

use super::bounds::{Bounds, Interval, Limited};
use super::enclosure::Enclosure;
use super::fourier::{ORDERS, Series};
use super::kinematics::Kinematics;
use crate::description::Controller;
use crate::model::{Model, Theta};
use crate::simulate::ClosedLoop;

/// How near to its limit a quantity comes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// The quantity.
    pub what: Limited,
    /// Joint; for a height that of the link, for the tool the last one.
    pub joint: usize,
    /// Largest part of the limit that the motion uses, at most 1.
    pub part: f64,
    /// Time of its largest value, s.
    pub time_s: f64,
}

/// A limit that a motion breaks.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The quantity.
    pub what: Limited,
    /// Joint, as in [`Kept`].
    pub joint: usize,
    /// Time, s.
    pub time_s: f64,
    /// Value; for a height the height.
    pub value: f64,
    /// Part of the limit that the value uses, above 1.
    pub part: f64,
    /// Whether the loop runs away instead.
    pub runs_away: bool,
}

/// Shortest interval, s.
const SHORTEST: f64 = 1e-7;

/// Difference between the certified bound of a peak and its value that is small enough.
const FINE: f64 = 5e-3;

/// The peaks of a motion that keeps its limits.
#[derive(Clone, Debug, Default)]
struct Peaks(Vec<Kept>);

impl Peaks {
    fn note(&mut self, what: Limited, joint: usize, part: f64, time_s: f64) {
        match (self.0.iter_mut()).find(|own| own.what == what && own.joint == joint) {
            Some(own) if own.part >= part => {}
            Some(own) => (own.part, own.time_s) = (part, time_s),
            None => self.0.push(Kept { what, joint, part, time_s }),
        }
    }

    fn part(&self, what: Limited, joint: usize) -> f64 {
        let own = self.0.iter().find(|own| own.what == what && own.joint == joint);
        own.map_or(0.0, |own| own.part)
    }
}

/// Certifies the reference of each joint: positions, velocities, accelerations, jerks.
///
/// # Errors
///
/// [`Broken`] with the first limit that the series breaks.
pub(super) fn certify_reference(series: &Series, bounds: &Bounds) -> Result<Vec<Kept>, Broken> {
    let mut peaks = Peaks::default();
    let most = series.harmonics.last().copied().unwrap_or(1);
    let pieces = 16 * most;
    for (joint, own) in bounds.joints.iter().enumerate() {
        for (order, what) in
            [Limited::Position, Limited::Velocity, Limited::Acceleration, Limited::Jerk].into_iter().enumerate()
        {
            let interval = own.orders[order];
            if !interval.is_limited() {
                continue;
            }
            let bend = series.bound(joint, order as i32 + 2);
            let place = |time: f64| interval.place(series.at(joint, time)[order]).abs();
            let mut known: f64 = 0.0;
            let length = series.period() / pieces as f64;
            let mut open: Vec<[f64; 2]> = (0..pieces).rev().map(|k| [length * k as f64, length]).collect();
            let mut peak = (0.0, 0.0);
            while let Some([from, length]) = open.pop() {
                let ends = [from, from + length].map(place);
                let least = ends[0].max(ends[1]);
                known = known.max(least);
                let bound = least + length * length / 8.0 * bend / interval.half;
                if least > 1.0 {
                    let time_s = if ends[0] >= ends[1] { from } else { from + length };
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

fn broken(what: Limited, joint: usize, time_s: f64, value: f64, part: f64) -> Broken {
    Broken {
        what,
        joint,
        time_s,
        value,
        part,
        runs_away: false,
    }
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

/// Certifies the motion of a robot whose links follow a path, springs included only by the torque that they carry.
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
    let mut open: Vec<[f64; 2]> = (0..pieces).rev().map(|k| [length * k as f64, length]).collect();
    while let Some([from, length]) = open.pop() {
        let half = 0.5 * length;
        let middle = from + half;
        let mut motion = [0, 1, 2].map(|_| vec![Enclosure::ZERO; n]);
        for joint in 0..n {
            let own = path.at(joint, middle);
            for (order, motion) in motion.iter_mut().enumerate() {
                let slack = half * path.bound(joint, order as i32 + 2);
                let rate = own[order + 1];
                motion[joint] = Enclosure::new(own[order], [rate - slack, rate + slack], half);
            }
        }
        let mut is_decided = true;
        let mut found: Vec<(Limited, usize, f64, f64, f64)> = Vec::new();
        let mut decide = |what, joint, interval: Interval, [low, high]: [f64; 2], middle: f64| {
            if interval.is_limited() {
                let part = interval.place(low).abs().max(interval.place(high).abs());
                found.push((what, joint, part, interval.place(middle).abs(), middle));
            }
        };
        let (motor, link) = torques.of(&motion);
        for (joint, own) in bounds.joints.iter().enumerate() {
            let torque = motor[joint];
            decide(Limited::Torque, joint, own.torque, torque.range(), torque.middle());
            if own.torque_rate.is_limited() {
                let fastest = torque.fastest();
                decide(Limited::TorqueRate, joint, own.torque_rate, [fastest; 2], fastest);
            }
            if let Some(stiffness) = torques.stiffness[joint] {
                let own = own.deflection;
                let deflection = link[joint] * (1.0 / stiffness);
                decide(Limited::Deflection, joint, own, deflection.range(), deflection.middle());
            }
        }
        if let Some(kinematics) = kinematics {
            let places = kinematics.places(&motion[0], &motion[1]);
            let [x, y, z] = places.velocity;
            let square = x * x + y * y + z * z;
            let speed = square.range().map(|x| x.max(0.0).sqrt());
            let own = bounds.tool_speed;
            decide(Limited::ToolSpeed, n - 1, own, speed, square.middle().max(0.0).sqrt());
            if let Some(floor) = bounds.floor {
                let parents = kinematics.parents();
                for (point, place) in places.points.iter().enumerate() {
                    if parents.get(point).is_some_and(Option::is_none) {
                        continue;
                    }
                    let joint = parents.get(point).copied().flatten().unwrap_or(n - 1);
                    let height = kinematics.height(place);
                    let used = |height: f64| (1.0 - (height - floor)).max(0.0);
                    let [low, high] = height.range();
                    let interval = Interval { middle: 0.0, half: 1.0 };
                    decide(Limited::Height, joint, interval, [used(high), used(low)], used(height.middle()));
                }
            }
        }
        for &(what, joint, bound, now, value) in &found {
            if now > 1.0 || bound > 1.0 && length < SHORTEST {
                let value = if what == Limited::Height {
                    1.0 - value + bounds.floor.unwrap_or_default()
                } else {
                    value
                };
                return Err(broken(what, joint, middle, value, now.max(bound)));
            }
            let known = peaks.part(what, joint).max(now);
            is_decided &= bound <= 1.0 && bound <= known.max(0.5) + FINE;
        }
        if is_decided || length < SHORTEST {
            for &(what, joint, bound, _, _) in &found {
                peaks.note(what, joint, bound, middle);
            }
        } else {
            for &(what, joint, _, now, _) in &found {
                peaks.note(what, joint, now, middle);
            }
            open.push([middle, half]);
            open.push([from, half]);
        }
    }
    Ok(peaks.0)
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
                .map(|(k, own)| *own * robot.ratio(joint, k))
                .fold(Enclosure::ZERO, |sum, own| sum + own)
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
            };
            let inertia = term.momentum(1.0);
            let torque = term.rest(&drive, &robot.shapes[joint]) + rates(ddq, joint) * inertia;
            let own = torque * self.theta[term.column];
            let at = robot.joint_of(term.row);
            motor[at] = motor[at] + own;
            if term.row < n && self.stiffness[at].is_some() {
                carried[at] = carried[at] + own;
            }
        }
        for (motor, link) in motor.iter_mut().zip(&self.link) {
            *motor = *motor + *link;
        }
        (motor, carried)
    }
}

/// A motion of the closed loop, as it is recorded for reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Simulation {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Link positions, rad (m), one list per joint.
    pub link: Vec<Vec<f64>>,
    /// Motor positions, rad (m), one list per joint.
    pub motor: Vec<Vec<f64>>,
    /// Motor torques, N·m (N), one list per joint.
    pub torque: Vec<Vec<f64>>,
}

/// Points of a recorded simulation.
const POINTS: usize = 1500;

/// Simulates the closed loop with exact sensors, and checks the limits of its motion at every period of the controller.
///
/// # Errors
///
/// [`Broken`] with the first limit that the motion breaks.
pub(super) fn check_loop(
    (model, theta): (&Model, &Theta),
    controller: &Controller,
    (period, duration): (f64, f64),
    bounds: &Bounds,
    kinematics: Option<&Kinematics>,
) -> Result<(Vec<Kept>, Simulation), Broken> {
    let n = model.joint_count();
    let none = |time_s| Broken {
        what: Limited::Position,
        joint: 0,
        time_s,
        value: f64::NAN,
        part: f64::INFINITY,
        runs_away: true,
    };
    let mut plant = ClosedLoop::new(model, theta, controller, period, None).map_err(|_| none(0.0))?;
    let mut peaks = Peaks::default();
    let mut record = Simulation {
        link: vec![Vec::new(); n],
        motor: vec![Vec::new(); n],
        torque: vec![Vec::new(); n],
        ..Simulation::default()
    };
    let samples = (duration / period).round() as usize;
    let every = samples.div_ceil(POINTS).max(1);
    let mut before: Option<Vec<f64>> = None;
    for k in 0..=samples {
        let state = plant.state();
        let time = plant.time();
        let tau = plant.command(time, &state.q, &state.phi);
        let mut seen: Vec<(Limited, usize, Interval, f64)> = Vec::new();
        for (joint, own) in bounds.joints.iter().enumerate() {
            let [position, velocity, ..] = own.orders;
            // Between samples a position moves by at most half a period of its velocity beyond its neighbours.
            let beyond = 0.125 * period * period * accelerations(own);
            let mut see = |what, interval, value: f64| seen.push((what, joint, interval, value));
            for value in [state.q[joint], state.phi[joint]] {
                see(Limited::Position, position, value + beyond.copysign(value - position.middle));
            }
            for value in [state.dq[joint], state.dphi[joint]] {
                see(Limited::Velocity, velocity, value);
            }
            see(Limited::Torque, own.torque, tau[joint]);
            see(Limited::Deflection, own.deflection, state.phi[joint] - state.q[joint]);
            if let Some(before) = &before {
                see(Limited::TorqueRate, own.torque_rate, (tau[joint] - before[joint]) / period);
            }
        }
        for &(what, joint, interval, value) in &seen {
            if interval.is_limited() {
                let part = interval.place(value).abs();
                if part > 1.0 || part.is_nan() {
                    return Err(broken(what, joint, time, value, part));
                }
                peaks.note(what, joint, part, time);
            }
        }
        if let Some(kinematics) = kinematics
            && (bounds.tool_speed.is_limited() || bounds.floor.is_some())
        {
            places(&mut peaks, kinematics, bounds, (&state.q, &state.dq), time)?;
        }
        if k % every == 0 {
            record.time_s.push(time);
            for joint in 0..n {
                record.link[joint].push(state.q[joint]);
                record.motor[joint].push(state.phi[joint]);
                record.torque[joint].push(tau[joint]);
            }
        }
        plant.advance(&tau).map_err(|diverged| none(diverged.time))?;
        before = Some(tau);
    }
    Ok((peaks.0, record))
}

fn accelerations(own: &super::bounds::JointBounds) -> f64 {
    let limit = own.orders[2];
    if limit.is_limited() { limit.half } else { 0.0 }
}

/// Checks the tool's speed and all heights at one time.
fn places(
    peaks: &mut Peaks,
    kinematics: &Kinematics,
    bounds: &Bounds,
    (q, dq): (&[f64], &[f64]),
    time: f64,
) -> Result<(), Broken> {
    let last = q.len() - 1;
    let places = kinematics.places(q, dq);
    let speed = places.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
    if bounds.tool_speed.is_limited() {
        let part = bounds.tool_speed.place(speed);
        if part > 1.0 {
            return Err(broken(Limited::ToolSpeed, last, time, speed, part));
        }
        peaks.note(Limited::ToolSpeed, last, part, time);
    }
    if let Some(floor) = bounds.floor {
        let parents = kinematics.parents();
        for (point, place) in places.points.iter().enumerate() {
            if parents.get(point).is_some_and(Option::is_none) {
                continue;
            }
            let joint = parents.get(point).copied().flatten().unwrap_or(last);
            let height = kinematics.height(place);
            let part = (1.0 - (height - floor)).max(0.0);
            if part > 1.0 {
                return Err(broken(Limited::Height, joint, time, height, part));
            }
            peaks.note(Limited::Height, joint, part, time);
        }
    }
    Ok(())
}
