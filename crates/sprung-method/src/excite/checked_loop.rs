//! Limits of the motion of the closed loop.

use serde::Serialize;

use super::bounds::{Bounds, Interval, JointBounds, Limited, height_used};
use super::kept::{Broken, Kept, Peaks, broken};
use super::kinematics::Kinematics;
use crate::description::Controller;
use crate::model::{Model, Theta};
use crate::simulate::ClosedLoop;

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
    let mut plant =
        ClosedLoop::new(model, theta, controller, period, None).map_err(|_| none(0.0))?;
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
        for (joint, joint_bounds) in bounds.joints.iter().enumerate() {
            let [position, velocity, ..] = joint_bounds.orders;
            // Between samples a position moves by at most half a period of its velocity beyond its neighbours.
            let beyond = 0.125 * period * period * accelerations(joint_bounds);
            let mut see = |what, interval, value: f64| seen.push((what, joint, interval, value));
            for value in [state.q[joint], state.phi[joint]] {
                see(
                    Limited::Position,
                    position,
                    value + beyond.copysign(value - position.middle),
                );
            }
            for value in [state.dq[joint], state.dphi[joint]] {
                see(Limited::Velocity, velocity, value);
            }
            see(Limited::Torque, joint_bounds.torque, tau[joint]);
            see(
                Limited::Deflection,
                joint_bounds.deflection,
                state.phi[joint] - state.q[joint],
            );
            if let Some(before) = &before {
                see(
                    Limited::TorqueRate,
                    joint_bounds.torque_rate,
                    (tau[joint] - before[joint]) / period,
                );
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
            for (joint, tau) in tau.iter().enumerate() {
                record.link[joint].push(state.q[joint]);
                record.motor[joint].push(state.phi[joint]);
                record.torque[joint].push(*tau);
            }
        }
        plant
            .advance(&tau)
            .map_err(|diverged| none(diverged.time))?;
        before = Some(tau);
    }
    Ok((peaks.0, record))
}

fn accelerations(joint_bounds: &JointBounds) -> f64 {
    let limit = joint_bounds.orders[2];
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
        for (point, joint) in kinematics.moving() {
            let height = kinematics.height(&places.points[point]);
            let part = height_used(height, floor);
            if part > 1.0 {
                return Err(broken(Limited::Height, joint, time, height, part));
            }
            peaks.note(Limited::Height, joint, part, time);
        }
    }
    Ok(())
}
