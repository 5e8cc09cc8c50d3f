//! Sensors of motion on links, and their readings.
//!
//! A gyroscope with mounting R measures the absolute angular velocity of its link in its own axes. The
//! rate of a joint is the difference along the joint's axis to the link below, whose direction z' in the
//! frame of that link is constant:
//!
//! ```text
//! y = R^T omega + bias        dq = z^T R y - z'^T R' y'
//! ```
//!
//! An accelerometer at r measures the acceleration of its place minus that of free fall. Link by link from the
//! base, the reading gives the acceleration of each joint, because it is linear in it:
//!
//! ```text
//! y = R^T (a - g + alpha x r + omega x (omega x r)) + bias
//! ddq = d^T (y - y(ddq = 0))/d^T d        d = R^T (z x r), or R^T z of a joint that slides
//! ```

use sprung_core::chain::JointKind;
use sprung_core::spatial::{Vector, cross, dot, product, rotation, times, transposed};

use super::channel::Channel;
use super::channel::ChannelError;
use crate::description::{Axis, Inertial, Joint, Quantity, Robot};

/// A sensor on the link of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct InertialSensor {
    /// Joint of the link.
    pub joint: usize,
    /// Index of the channel of each axis; a sensor with one axis has one.
    pub channels: [Option<usize>; 3],
    /// Rotation matrix from the axes of the sensor to the frame of the link, row by row. The only axis of a
    /// gyroscope with one axis is that of the joint.
    pub mounting: [Vector; 3],
    /// Whether the description gives the mounting, or the axis is that of the joint.
    pub is_mounted: bool,
    /// Place in the frame of the link, m; that of a gyroscope does not matter.
    pub position: Vector,
    /// Reading of each axis without motion, in the unit of the reading.
    pub bias: Vector,
}

impl InertialSensor {
    /// Returns whether it is an accelerometer without a given mounting: the motors tell its place too badly.
    #[must_use]
    pub fn needs_mounting(&self, kind: Inertial) -> bool {
        kind.place_key().is_some() && !self.is_mounted
    }
}

/// The sensors on the links of a robot, and the joints that carry them.
#[derive(Clone, Debug, PartialEq)]
pub struct InertialSensors {
    /// What they measure.
    pub kind: Inertial,
    /// One for each flexible joint that has it, base first.
    pub all: Vec<InertialSensor>,
    /// Acceleration of free fall in the frame of the base, m/s².
    gravity: Vector,
    /// Its largest part across the axes of the joints, m/s².
    gravity_across: f64,
    joints: Vec<Place>,
}

/// Motion of a link, in its own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkMotion {
    /// Angular velocity, rad/s.
    pub(crate) velocity: Vector,
    /// Angular acceleration, rad/s².
    acceleration: Vector,
    /// Acceleration of the origin minus that of free fall, m/s².
    force: Vector,
}

/// Place of a joint on the link below it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    parent: Option<usize>,
    /// From the frame of the joint to that of the parent at position zero.
    rotation: [Vector; 3],
    /// Of the joint in the frame of the parent at position zero, m.
    origin: Vector,
    axis: Vector,
    turns: bool,
}

const IDENTITY: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Returns `a + factor b`.
fn plus(a: &Vector, factor: f64, b: &Vector) -> Vector {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

/// Returns the rotation by roll, pitch and yaw about fixed axes, as in a URDF.
fn of_rpy(rpy_deg: [f64; 3]) -> [Vector; 3] {
    let [roll, pitch, yaw] = rpy_deg.map(f64::to_radians);
    let about = |axis: Vector, angle: f64| rotation(&axis, angle);
    let first = product(
        &about([0.0, 1.0, 0.0], pitch),
        &about([1.0, 0.0, 0.0], roll),
    );
    product(&about([0.0, 0.0, 1.0], yaw), &first)
}

fn places(robot: &Robot) -> Vec<Place> {
    match &robot.tree {
        Some(tree) => (tree.joints.iter())
            .map(|joint| Place {
                parent: joint.parent,
                rotation: joint.rotation,
                origin: joint.origin,
                axis: joint.axis,
                turns: joint.kind == JointKind::Revolute,
            })
            .collect(),
        // The arm of the paper: both axes are vertical.
        None => (0..robot.joint.len())
            .map(|joint| Place {
                parent: joint.checked_sub(1),
                rotation: IDENTITY,
                // Its lengths are not known; gyroscopes do not need them.
                origin: [0.0; 3],
                axis: [0.0, 0.0, 1.0],
                turns: true,
            })
            .collect(),
    }
}

impl InertialSensors {
    /// Returns the sensors of a robot by its channels; `None` without sensors.
    #[must_use]
    pub(crate) fn new(robot: &Robot, channels: &[Channel]) -> Option<Self> {
        (Inertial::ALL.into_iter()).find_map(|kind| Self::of_kind(kind, robot, channels))
    }

    fn of_kind(kind: Inertial, robot: &Robot, channels: &[Channel]) -> Option<Self> {
        let joints = places(robot);
        let all: Vec<InertialSensor> = (0..joints.len())
            .filter_map(|joint| {
                let channels = Axis::ALL.map(|axis| {
                    let quantity = Quantity::Inertial(kind, axis);
                    (channels.iter()).position(|c| c.joint == joint && c.quantity == quantity)
                });
                let axes = channels.iter().flatten().count();
                let given = kind.rpy_deg(&robot.joint[joint]);
                let place = kind.xyz_m(&robot.joint[joint]);
                let turns_alone = kind == Inertial::Gyroscope && axes == 1;
                (axes > 0).then(|| InertialSensor {
                    joint,
                    mounting: match given {
                        _ if turns_alone => transposed(&[joints[joint].axis; 3]),
                        Some(rpy) => of_rpy(rpy),
                        None => IDENTITY,
                    },
                    is_mounted: turns_alone || given.is_some(),
                    position: place.unwrap_or_default(),
                    channels,
                    bias: [0.0; 3],
                })
            })
            .collect();
        (!all.is_empty()).then_some(Self {
            kind,
            all,
            gravity: robot.gravity(),
            gravity_across: gravity_across(robot),
            joints,
        })
    }

    /// Returns the sensor on the link of a joint.
    #[must_use]
    pub fn of(&self, joint: usize) -> Option<&InertialSensor> {
        self.all.iter().find(|sensor| sensor.joint == joint)
    }

    /// Returns the readings of gyroscopes and weights whose sum is the rate of a joint, and the sum of their biases,
    /// rad/s. A reading has the place `3 joint + axis`.
    #[must_use]
    pub fn rate(&self, outer: &InertialSensor) -> (Vec<(usize, f64)>, f64) {
        let mut weights = Vec::new();
        let mut bias = 0.0;
        let mut add = |sensor: &InertialSensor, direction: &Vector, sign: f64| {
            let of_axes = times(&transposed(&sensor.mounting), direction);
            for axis in (0..3).filter(|&axis| sensor.channels[axis].is_some()) {
                weights.push((3 * sensor.joint + axis, sign * of_axes[axis]));
                bias += sign * of_axes[axis] * sensor.bias[axis];
            }
        };
        let joint = &self.joints[outer.joint];
        add(outer, &joint.axis, 1.0);
        // The joint turns about its axis, so the axis is constant in the frame of the link below.
        let mut direction = times(&joint.rotation, &joint.axis);
        let mut below = joint.parent;
        while let Some(link) = below {
            if self.joints[link].turns {
                if let Some(sensor) = self.of(link) {
                    add(sensor, &direction, -1.0);
                }
                break;
            }
            direction = times(&self.joints[link].rotation, &direction);
            below = self.joints[link].parent;
        }
        (weights, bias)
    }

    /// Returns the motion of the base.
    fn of_base(&self) -> LinkMotion {
        LinkMotion {
            force: self.gravity.map(|g| -g),
            ..LinkMotion::default()
        }
    }

    /// Returns the motion of a link.
    ///
    /// - `links`: motions of the links of all joints before.
    /// - `q`, `dq`, `ddq`: position, rate and acceleration of its joint, rad, rad/s, rad/s² (m, m/s, m/s²).
    #[must_use]
    pub fn next(&self, links: &[LinkMotion], [q, dq, ddq]: [f64; 3]) -> LinkMotion {
        let joint = &self.joints[links.len()];
        let below = joint.parent.map_or_else(|| self.of_base(), |i| links[i]);
        let mut origin = joint.origin;
        if !joint.turns {
            origin = plus(&origin, q, &times(&joint.rotation, &joint.axis));
        }
        let force = plus(&below.force, 1.0, &cross(&below.acceleration, &origin));
        let inward = cross(&below.velocity, &cross(&below.velocity, &origin));
        let force = plus(&force, 1.0, &inward);
        let turned = |v: &Vector| {
            let v = times(&transposed(&joint.rotation), v);
            if joint.turns {
                times(&transposed(&rotation(&joint.axis, q)), &v)
            } else {
                v
            }
        };
        let (velocity, acceleration) = (turned(&below.velocity), turned(&below.acceleration));
        let of_axis = plus(&[0.0; 3], dq, &joint.axis);
        let crossed = cross(&velocity, &of_axis);
        if joint.turns {
            LinkMotion {
                velocity: plus(&velocity, dq, &joint.axis),
                acceleration: plus(&plus(&acceleration, ddq, &joint.axis), 1.0, &crossed),
                force: turned(&force),
            }
        } else {
            LinkMotion {
                velocity,
                acceleration,
                force: plus(&plus(&turned(&force), ddq, &joint.axis), 2.0, &crossed),
            }
        }
    }

    /// Returns the motions of all links.
    ///
    /// - `q`, `dq`, `ddq`: positions, rates and accelerations of the joints, \[n\], rad, rad/s, rad/s² (m, m/s, m/s²).
    #[must_use]
    pub fn motions(&self, [q, dq, ddq]: [&[f64]; 3]) -> Vec<LinkMotion> {
        let mut all: Vec<LinkMotion> = Vec::with_capacity(self.joints.len());
        for joint in 0..self.joints.len() {
            all.push(self.next(&all, [q[joint], dq[joint], ddq[joint]]));
        }
        all
    }

    /// Returns the acceleration of the joint of an accelerometer, rad/s² (m/s²); zero if the sensor does not
    /// feel it.
    ///
    /// - `links`: motions of the links of all joints before; `q`, `dq`: of its joint, rad, rad/s (m, m/s).
    #[must_use]
    pub fn acceleration(
        &self,
        sensor: &InertialSensor,
        links: &[LinkMotion],
        [q, dq]: [f64; 2],
        reading: &Vector,
    ) -> f64 {
        let exact = self.reading(sensor, &self.next(links, [q, dq, 0.0]));
        let direction = self.direction(sensor);
        let rest: Vector = std::array::from_fn(|i| reading[i] - sensor.bias[i] - exact[i]);
        let square = dot(&direction, &direction);
        if square > 0.0 {
            dot(&direction, &rest) / square
        } else {
            0.0
        }
    }

    /// Returns the least corner of the filter of a sensor, rad/s.
    ///
    /// The reading of an accelerometer at distance r changes by r ddq + g q. Above the joint g is negative, and the
    /// position by its integral converges if `8 w² > 3 |g|/r`, by Routh for `(s + w)³ + g/r s`.
    #[must_use]
    pub fn least_corner(&self, sensor: &InertialSensor) -> f64 {
        match self.kind {
            Inertial::Gyroscope => 0.0,
            Inertial::Accelerometer => {
                let direction = self.direction(sensor);
                let lever = dot(&direction, &direction).sqrt();
                MARGIN * (0.375 * self.gravity_across / lever.max(MIN_LEVER)).sqrt()
            }
        }
    }

    /// Returns the change of an accelerometer's reading with the acceleration of its joint; zero for an axis
    /// that the sensor does not have.
    fn direction(&self, sensor: &InertialSensor) -> Vector {
        let joint = &self.joints[sensor.joint];
        let in_link = if joint.turns {
            cross(&joint.axis, &sensor.position)
        } else {
            joint.axis
        };
        let direction = times(&transposed(&sensor.mounting), &in_link);
        std::array::from_fn(|i| sensor.channels[i].map_or(0.0, |_| direction[i]))
    }

    /// Returns the reading of an exact sensor whose axes are those of its link, in its unit.
    ///
    /// - `motion`: of its link.
    #[must_use]
    pub fn in_link(&self, sensor: &InertialSensor, motion: &LinkMotion) -> Vector {
        match self.kind {
            Inertial::Gyroscope => motion.velocity,
            Inertial::Accelerometer => {
                let (velocity, place) = (&motion.velocity, &sensor.position);
                let outward = cross(velocity, &cross(velocity, place));
                let turning = cross(&motion.acceleration, place);
                plus(&plus(&motion.force, 1.0, &turning), 1.0, &outward)
            }
        }
    }

    /// Returns the reading of an exact sensor, in its unit.
    ///
    /// - `motion`: of its link.
    #[must_use]
    pub fn reading(&self, sensor: &InertialSensor, motion: &LinkMotion) -> Vector {
        times(&transposed(&sensor.mounting), &self.in_link(sensor, motion))
    }

    /// Returns the variance of the link position by white noise of the sensors, after the filter of its row, rad² (m²).
    ///
    /// - `levels`: standard deviations of the noise of each axis, in the unit of the sensor, \[n\].
    /// - `corner`: w of the filter, rad/s; `period`: T, s.
    ///
    /// White noise of variance s² and period T becomes `s² T / (4 w)` after `s/(s + w)²`, and `s² T
    /// / (16 w³)` after `s/(s + w)³`.
    #[must_use]
    pub fn position_variance(
        &self,
        sensor: &InertialSensor,
        levels: &[[f64; 3]],
        (corner, period): (f64, f64),
    ) -> f64 {
        match self.kind {
            Inertial::Gyroscope => {
                let variance: f64 = (self.rate(sensor).0.iter())
                    .map(|(place, weight)| (weight * levels[place / 3][place % 3]).powi(2))
                    .sum();
                variance * period / (4.0 * corner)
            }
            Inertial::Accelerometer => {
                let direction = self.direction(sensor);
                let squares = direction.map(|d| d * d);
                let all: f64 = squares.iter().sum();
                let levels = levels[sensor.joint].map(|level| level * level);
                let variance = dot(&squares, &levels) / (all * all).max(f64::MIN_POSITIVE);
                variance * period / (16.0 * corner.powi(3))
            }
        }
    }
}

/// Checks that the sensors determine the motion of their joints.
///
/// # Errors
///
/// [`ChannelError`] if a link below has no sensor, if gyroscopes have one axis and the axes of the
/// joints are not parallel, or if the place of an accelerometer is not known.
pub(super) fn check_sensors(
    robot: &Robot,
    sensors: Option<&InertialSensors>,
) -> Result<(), ChannelError> {
    let Some(sensors) = sensors else {
        return Ok(());
    };
    let has: Vec<bool> = (0..robot.joint.len())
        .map(|joint| sensors.of(joint).is_some())
        .collect();
    let name = |joint: usize| {
        robot
            .joint
            .get(joint)
            .map_or("", |joint: &Joint| &joint.name)
            .to_owned()
    };
    let sensor = sensors.kind.word();
    if let Some((joint, below)) = without_sensor(robot, &has, sensors.kind) {
        return Err(ChannelError::NoSensorBelow {
            sensor,
            joint: name(joint),
            below: name(below),
        });
    }
    let single = (sensors.all.iter()).find(|sensor| sensor.channels.iter().flatten().count() == 1);
    match (sensors.kind, single) {
        (Inertial::Gyroscope, Some(single)) if !axes_are_parallel(robot) => {
            Err(ChannelError::Unsuited {
                sensor,
                joint: name(single.joint),
                reason: "has one axis, but the axes of the joints are not parallel; name the \
                         columns of x, y and z in [log]",
            })
        }
        (Inertial::Gyroscope, _) => Ok(()),
        (Inertial::Accelerometer, _) => check_places(robot, sensors, name),
    }
}

/// Checks that the lengths of the links are known, and that a mounting is given whole.
fn check_places(
    robot: &Robot,
    sensors: &InertialSensors,
    name: impl Fn(usize) -> String,
) -> Result<(), ChannelError> {
    let unsuited = |joint, reason| {
        Err(ChannelError::Unsuited {
            sensor: sensors.kind.word(),
            joint: name(joint),
            reason,
        })
    };
    for sensor in &sensors.all {
        let joint = &robot.joint[sensor.joint];
        if robot.tree.is_none() {
            let reason = "needs the lengths of the links, which kinematics = \"planar-2r\" does not give; \
                          describe the robot by dh_modified or urdf";
            return unsuited(sensor.joint, reason);
        }
        if sensors.kind.rpy_deg(joint).is_some() != sensors.kind.xyz_m(joint).is_some() {
            let reason = "has only one of accelerometer_rpy_deg and accelerometer_xyz_m; give both, or none of them";
            return unsuited(sensor.joint, reason);
        }
        let direction = sensors.direction(sensor);
        if sensor.is_mounted && dot(&direction, &direction) < MIN_LEVER * MIN_LEVER {
            let reason = "does not feel the acceleration of the joint: it lies on the joint's axis, or its only \
                          axis is at right angles to the motion; mount it away from the axis";
            return unsuited(sensor.joint, reason);
        }
    }
    Ok(())
}

/// Corner of an accelerometer's filter over that at which the link position diverges.
const MARGIN: f64 = 1.5;

/// Least distance of an accelerometer from the axis of its joint, m.
const MIN_LEVER: f64 = 1e-3;

/// Returns the first joint between the base and the link of a sensor whose motion the sensor measures and which has
/// no sensor on its own link. Gyroscopes do not measure the motion of joints that slide.
///
/// - `has`: whether each joint has one, \[n\].
fn without_sensor(robot: &Robot, has: &[bool], kind: Inertial) -> Option<(usize, usize)> {
    let joints = places(robot);
    (0..joints.len())
        .filter(|&joint| has[joint])
        .find_map(|joint| {
            let mut below = joints[joint].parent;
            while let Some(link) = below {
                if joints[link].turns || kind == Inertial::Accelerometer {
                    return (!has[link]).then_some((joint, link));
                }
                below = joints[link].parent;
            }
            None
        })
}

/// Returns whether all joints that turn have parallel axes, at position zero and hence always.
fn axes_are_parallel(robot: &Robot) -> bool {
    common_axis(robot).is_some()
}

/// Returns the largest part of gravity across the axes of the joints, m/s²: that across their common axis, or all of it.
fn gravity_across(robot: &Robot) -> f64 {
    let gravity = robot.gravity();
    let across = match common_axis(robot) {
        Some(axis) => plus(&gravity, -dot(&gravity, &axis), &axis),
        None => gravity,
    };
    dot(&across, &across).sqrt()
}

/// Returns the axis of all joints that turn, in the frame of the base; `None` if they are not parallel.
fn common_axis(robot: &Robot) -> Option<Vector> {
    let joints = places(robot);
    let mut to_base: Vec<[Vector; 3]> = Vec::new();
    let mut first: Option<Vector> = None;
    for joint in &joints {
        let rotation = match joint.parent {
            Some(parent) => product(&to_base[parent], &joint.rotation),
            None => joint.rotation,
        };
        to_base.push(rotation);
        if joint.turns {
            let axis = times(&rotation, &joint.axis);
            let first = *first.get_or_insert(axis);
            if dot(&first, &axis).abs() < 1.0 - 1e-9 {
                return None;
            }
        }
    }
    Some(first.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensors(kind: Inertial) -> InertialSensors {
        let tilted = rotation(&[0.6, 0.0, 0.8], 0.7);
        let place = |parent, rotation| Place {
            parent,
            rotation,
            origin: [0.1, 0.2, 0.3],
            axis: [0.0, 0.0, 1.0],
            turns: true,
        };
        let quarter = rotation(&[1.0, 0.0, 0.0], 1.3);
        let sensor = |joint: usize, mounting| InertialSensor {
            joint,
            channels: [0, 1, 2].map(|axis| Some(3 * joint + axis)),
            mounting,
            is_mounted: true,
            position: [0.3, -0.1, 0.05],
            bias: [0.1, -0.2, 0.3],
        };
        InertialSensors {
            kind,
            gravity: [0.0, 0.0, -9.81],
            gravity_across: 9.81,
            all: vec![
                sensor(0, tilted),
                sensor(1, of_rpy([90.0, 0.0, 30.0])),
                sensor(2, IDENTITY),
            ],
            joints: vec![
                place(None, IDENTITY),
                place(Some(0), quarter),
                place(Some(1), tilted),
            ],
        }
    }

    #[test]
    fn accelerations_follow_from_exact_readings_in_any_mounting() {
        let accelerometers = sensors(Inertial::Accelerometer);
        let (q, dq, ddq) = ([0.4, -1.1, 2.0], [0.7, -0.3, 1.9], [3.0, -5.0, 0.6]);
        let mut links = Vec::new();
        for (joint, sensor) in accelerometers.all.iter().enumerate() {
            let motion = accelerometers.next(&links, [q[joint], dq[joint], ddq[joint]]);
            let exact = accelerometers.reading(sensor, &motion);
            let reading = [0, 1, 2].map(|axis| exact[axis] + sensor.bias[axis]);
            let found =
                accelerometers.acceleration(sensor, &links, [q[joint], dq[joint]], &reading);
            assert!((found - ddq[joint]).abs() < 1e-12);
            links.push(motion);
        }
    }

    /// The acceleration of a place is the second derivative of its position.
    #[test]
    fn readings_are_accelerations_of_the_place() {
        let accelerometers = sensors(Inertial::Accelerometer);
        let at = |t: f64| {
            [
                0.4 + 0.7 * t + 1.5 * t * t,
                -1.1 - 0.3 * t - 2.5 * t * t,
                2.0 + 1.9 * t + 0.3 * t * t,
            ]
        };
        let place = |t: f64| {
            let q = at(t);
            let mut to_base = IDENTITY;
            let mut place = [0.0; 3];
            for (joint, q) in accelerometers.joints.iter().zip(q) {
                place = plus(&place, 1.0, &times(&to_base, &joint.origin));
                to_base = product(
                    &product(&to_base, &joint.rotation),
                    &rotation(&joint.axis, q),
                );
            }
            (
                plus(
                    &place,
                    1.0,
                    &times(&to_base, &accelerometers.all[2].position),
                ),
                to_base,
            )
        };
        let step = 1e-4;
        let [before, (now, to_base), after] = [-step, 0.0, step].map(place);
        let acceleration: Vector =
            std::array::from_fn(|i| (before.0[i] - 2.0 * now[i] + after.0[i]) / (step * step));
        let felt = times(
            &transposed(&to_base),
            &plus(&acceleration, -1.0, &accelerometers.gravity),
        );
        let motions = accelerometers.motions([&at(0.0), &[0.7, -0.3, 1.9], &[3.0, -5.0, 0.6]]);
        let exact = accelerometers.in_link(&accelerometers.all[2], &motions[2]);
        // Four places of about 1 m with ten roundings each; the fourth derivative at ω = 2.9 rad/s and α = 8.6 rad/s²,
        // the sums over the joints, is ω⁴ + 6 ω² α + 3 α² = 700 m/s⁴ or less.
        let limit = 40.0 * f64::EPSILON / (step * step) + step * step / 12.0 * 700.0;
        assert!(
            (0..3).all(|i| (exact[i] - felt[i]).abs() < limit),
            "{exact:?} {felt:?}"
        );
    }

    #[test]
    fn rates_follow_from_exact_readings_in_any_mounting() {
        let gyroscopes = sensors(Inertial::Gyroscope);
        let (q, dq) = ([0.4, -1.1, 2.0], [0.7, -0.3, 1.9]);
        let motions = gyroscopes.motions([&q, &dq, &[0.0; 3]]);
        let readings: Vec<f64> = (gyroscopes.all.iter().zip(&motions))
            .flat_map(|(sensor, motion)| {
                let exact = gyroscopes.reading(sensor, motion);
                [0, 1, 2].map(|axis| exact[axis] + sensor.bias[axis])
            })
            .collect();
        for (sensor, rate) in gyroscopes.all.iter().zip(dq) {
            let (weights, bias) = gyroscopes.rate(sensor);
            let sum: f64 = weights.iter().map(|(c, w)| readings[*c] * w).sum();
            assert!((sum - bias - rate).abs() < 1e-12);
        }
    }
}
