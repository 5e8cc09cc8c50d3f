//! The way from the pose of the robot to the first position of a motion.

use super::bounds::{Bounds, Limited};
use super::certify::{Path, certify_followed};
use super::fourier::{ORDERS, Series};
use super::kept::Broken;
use super::kinematics::Kinematics;
use crate::model::Model;

/// A polynomial of degree seven from rest to rest, with velocities, accelerations and jerks of zero at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Approach {
    /// First and last position of each joint, rad (m).
    pub ends: Vec<[f64; 2]>,
    /// Length, s.
    pub duration: f64,
}

/// Coefficients of the powers 4 to 7 of the time over the length.
const COEFFICIENTS: [f64; 4] = [35.0, -84.0, 70.0, -20.0];

/// Largest absolute derivatives of the polynomial from 0 to 1, orders 0 to 4.
const LARGEST: [f64; ORDERS] = [1.0, 2.1875, 7.5132, 52.5, 840.0];

/// Times by which the approach is made longer.
const LONGER: [f64; 6] = [1.0, 1.5, 2.0, 3.0, 5.0, 10.0];

impl Approach {
    /// Returns an approach within the limits; `None` if the robot is there already.
    ///
    /// # Errors
    ///
    /// [`Broken`] if also a slow motion breaks a limit.
    pub fn new(
        from: &[f64],
        series: &Series,
        robot: (&Model, &[f64]),
        bounds: &Bounds,
        kinematics: Option<&Kinematics>,
    ) -> Result<Option<Self>, Broken> {
        let n = series.joints.len();
        let ends: Vec<[f64; 2]> = (0..n)
            .map(|joint| [from[joint], series.at(joint, 0.0)[0]])
            .collect();
        if ends.iter().all(|[from, to]| (from - to).abs() < 1e-9) {
            return Ok(None);
        }
        for (joint, joint_bounds) in bounds.joints.iter().enumerate() {
            for value in ends[joint] {
                let part = joint_bounds.orders[0].place(value).abs();
                if joint_bounds.orders[0].is_limited() && part > 1.0 {
                    return Err(Broken {
                        what: Limited::Position,
                        joint,
                        time_s: 0.0,
                        value,
                        part,
                        runs_away: false,
                    });
                }
            }
        }
        let mut shortest: f64 = 1.0;
        for (joint_bounds, [from, to]) in bounds.joints.iter().zip(&ends) {
            for (order, largest) in LARGEST.iter().enumerate().take(4).skip(1) {
                let interval = joint_bounds.orders[order];
                if interval.is_limited() {
                    let size = largest * (to - from).abs() / interval.half;
                    shortest = shortest.max(size.powf(1.0 / order as f64));
                }
            }
        }
        let mut last = None;
        for longer in LONGER {
            let approach = Self {
                ends: ends.clone(),
                duration: (shortest * longer * 1e3).ceil() / 1e3,
            };
            match certify_followed(&approach, robot, bounds, kinematics) {
                Ok(_) => return Ok(Some(approach)),
                Err(broken) => last = Some(broken),
            }
        }
        last.map_or(Ok(None), Err)
    }

    /// Returns position, velocity and acceleration of a joint.
    #[must_use]
    pub fn at(&self, joint: usize, time: f64) -> [f64; ORDERS] {
        let [from, to] = self.ends[joint];
        let s = (time / self.duration).clamp(0.0, 1.0);
        let mut all = [0.0; ORDERS];
        for (k, coefficient) in COEFFICIENTS.into_iter().enumerate() {
            let mut power = k as i32 + 4;
            let mut factor = coefficient;
            for value in &mut all {
                *value += factor * s.powi(power.max(0));
                factor *= f64::from(power);
                power -= 1;
            }
        }
        let mut scale = to - from;
        for value in &mut all {
            *value *= scale;
            scale /= self.duration;
        }
        all[0] += from;
        all
    }
}

impl Path for Approach {
    fn at(&self, joint: usize, time: f64) -> [f64; ORDERS] {
        self.at(joint, time)
    }

    fn bound(&self, joint: usize, order: i32) -> f64 {
        let [from, to] = self.ends[joint];
        LARGEST[order as usize] * (to - from).abs() / self.duration.powi(order)
    }

    fn pieces(&self) -> (f64, usize) {
        (self.duration, 32)
    }
}
