//! Gyroscopes on links: joint rates from angular velocities.
//!
//! A gyroscope with mounting R measures the absolute angular velocity of its link in its own axes. The
//! rate of a joint is the difference along the joint's axis to the link below, whose direction z' in the
//! frame of that link is constant:
//!
//! ```text
//! y = R^T omega + bias        dq = z^T R y - z'^T R' y'
//! ```

use sprung_core::chain::JointKind;
use sprung_core::spatial::{Vector, product, rotation};

use super::channel::Channel;
use super::channel::ChannelError;
use crate::description::{Axis, Joint, Quantity, Robot};

/// A gyroscope on the link of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Gyroscope {
    /// Joint of the link.
    pub joint: usize,
    /// Index of the channel of each axis; a gyroscope with one axis has one.
    pub channels: [Option<usize>; 3],
    /// Rotation matrix from the axes of the sensor to the frame of the link, row by row. The only axis of a
    /// gyroscope with one axis is that of the joint.
    pub mounting: [Vector; 3],
    /// Whether the description gives the mounting, or the gyroscope has one axis.
    pub is_mounted: bool,
    /// Reading of each axis without motion, rad/s.
    pub bias: Vector,
}

/// The gyroscopes of a robot, and the joints that carry them.
#[derive(Clone, Debug, PartialEq)]
pub struct Gyroscopes {
    /// One for each flexible joint that turns, base first.
    pub all: Vec<Gyroscope>,
    /// Corner of the high-pass filter of deflections, rad/s.
    pub corner: f64,
    joints: Vec<Place>,
}

/// Place of a joint on the link below it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    parent: Option<usize>,
    /// From the frame of the joint to that of the parent at position zero.
    rotation: [Vector; 3],
    axis: Vector,
    turns: bool,
}

const IDENTITY: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn times(matrix: &[Vector; 3], v: &Vector) -> Vector {
    matrix.map(|row| dot(&row, v))
}

fn transposed(a: &[Vector; 3]) -> [Vector; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
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
                axis: joint.axis,
                turns: joint.kind == JointKind::Revolute,
            })
            .collect(),
        // The arm of the paper: both axes are vertical.
        None => (0..robot.joint.len())
            .map(|joint| Place {
                parent: joint.checked_sub(1),
                rotation: IDENTITY,
                axis: [0.0, 0.0, 1.0],
                turns: true,
            })
            .collect(),
    }
}

impl Gyroscopes {
    /// Returns the gyroscopes of a robot by its channels; `None` without gyroscopes.
    ///
    /// - `corner`: of the high-pass filter of deflections, rad/s.
    #[must_use]
    pub(crate) fn new(robot: &Robot, channels: &[Channel], corner: f64) -> Option<Self> {
        let joints = places(robot);
        let all: Vec<Gyroscope> = (0..joints.len())
            .filter_map(|joint| {
                let own = Axis::ALL.map(|axis| {
                    let quantity = Quantity::Gyroscope(axis);
                    (channels.iter()).position(|c| c.joint == joint && c.quantity == quantity)
                });
                let axes = own.iter().flatten().count();
                let given = robot.joint[joint].gyroscope_rpy_deg;
                (axes > 0).then(|| Gyroscope {
                    joint,
                    mounting: match (axes, given) {
                        (1, _) => transposed(&[joints[joint].axis; 3]),
                        (_, Some(rpy)) => of_rpy(rpy),
                        (_, None) => IDENTITY,
                    },
                    is_mounted: axes == 1 || given.is_some(),
                    channels: own,
                    bias: [0.0; 3],
                })
            })
            .collect();
        (!all.is_empty()).then_some(Self {
            all,
            corner,
            joints,
        })
    }

    /// Returns the gyroscope on the link of a joint.
    #[must_use]
    pub fn of(&self, joint: usize) -> Option<&Gyroscope> {
        self.all.iter().find(|own| own.joint == joint)
    }

    /// Returns the readings and weights whose sum is the rate of a joint, and the sum of their biases,
    /// rad/s. A reading has the place `3 joint + axis`.
    #[must_use]
    pub(crate) fn rate(&self, own: &Gyroscope) -> (Vec<(usize, f64)>, f64) {
        let mut weights = Vec::new();
        let mut bias = 0.0;
        let mut add = |sensor: &Gyroscope, direction: &Vector, sign: f64| {
            let of_axes = times(&transposed(&sensor.mounting), direction);
            for axis in (0..3).filter(|&axis| sensor.channels[axis].is_some()) {
                weights.push((3 * sensor.joint + axis, sign * of_axes[axis]));
                bias += sign * of_axes[axis] * sensor.bias[axis];
            }
        };
        let joint = &self.joints[own.joint];
        add(own, &joint.axis, 1.0);
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

    /// Returns the angular velocities of all links in their own frames, rad/s.
    ///
    /// - `q`, `dq`: positions and rates of the joints, \[n\], rad, rad/s (m, m/s).
    #[must_use]
    pub(crate) fn angular_velocities(&self, q: &[f64], dq: &[f64]) -> Vec<Vector> {
        let mut all: Vec<Vector> = Vec::with_capacity(self.joints.len());
        for (i, joint) in self.joints.iter().enumerate() {
            let below = joint.parent.map_or([0.0; 3], |parent| all[parent]);
            let mut own = times(&transposed(&joint.rotation), &below);
            if joint.turns {
                own = times(&transposed(&rotation(&joint.axis, q[i])), &own);
                for (own, axis) in own.iter_mut().zip(joint.axis) {
                    *own += axis * dq[i];
                }
            }
            all.push(own);
        }
        all
    }

    /// Returns the reading of an exact gyroscope, rad/s.
    ///
    /// - `velocity`: angular velocity of its link, in the frame of the link, rad/s.
    #[must_use]
    pub(crate) fn reading(own: &Gyroscope, velocity: &Vector) -> Vector {
        times(&transposed(&own.mounting), velocity)
    }
}

/// Checks that the gyroscopes determine the rates of their joints.
///
/// # Errors
///
/// [`ChannelError`] if a link below has no gyroscope, or if gyroscopes have one axis and the axes of the
/// joints are not parallel.
pub(super) fn check_gyroscopes(
    robot: &Robot,
    gyroscopes: Option<&Gyroscopes>,
) -> Result<(), ChannelError> {
    let Some(own) = gyroscopes else {
        return Ok(());
    };
    let has: Vec<bool> = (0..robot.joint.len())
        .map(|joint| own.of(joint).is_some())
        .collect();
    let name = |joint: usize| {
        robot
            .joint
            .get(joint)
            .map_or("", |own: &Joint| &own.name)
            .to_owned()
    };
    if let Some((joint, below)) = without_gyroscope(robot, &has) {
        return Err(ChannelError::NoGyroscopeBelow {
            joint: name(joint),
            below: name(below),
        });
    }
    let single = (own.all.iter()).find(|own| own.channels.iter().flatten().count() == 1);
    match single {
        Some(single) if !axes_are_parallel(robot) => Err(ChannelError::OneAxis {
            joint: name(single.joint),
        }),
        _ => Ok(()),
    }
}

/// Returns the first joint that turns between the base and the link of a gyroscope and has no gyroscope
/// on its own link.
///
/// - `has`: whether each joint has one, \[n\].
fn without_gyroscope(robot: &Robot, has: &[bool]) -> Option<(usize, usize)> {
    let joints = places(robot);
    (0..joints.len())
        .filter(|&joint| has[joint])
        .find_map(|joint| {
            let mut below = joints[joint].parent;
            while let Some(link) = below {
                if joints[link].turns {
                    return (!has[link]).then_some((joint, link));
                }
                below = joints[link].parent;
            }
            None
        })
}

/// Returns whether all joints that turn have parallel axes, at position zero and hence always.
fn axes_are_parallel(robot: &Robot) -> bool {
    let joints = places(robot);
    let mut to_base: Vec<[Vector; 3]> = Vec::new();
    let mut first: Option<Vector> = None;
    for joint in &joints {
        let own = match joint.parent {
            Some(parent) => product(&to_base[parent], &joint.rotation),
            None => joint.rotation,
        };
        to_base.push(own);
        if joint.turns {
            let axis = times(&own, &joint.axis);
            let first = *first.get_or_insert(axis);
            if dot(&first, &axis).abs() < 1.0 - 1e-9 {
                return false;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_follow_from_exact_readings_in_any_mounting() {
        let tilted = rotation(&[0.6, 0.0, 0.8], 0.7);
        let place = |parent, rotation| Place {
            parent,
            rotation,
            axis: [0.0, 0.0, 1.0],
            turns: true,
        };
        let quarter = rotation(&[1.0, 0.0, 0.0], 1.3);
        let sensor = |joint: usize, mounting| Gyroscope {
            joint,
            channels: [0, 1, 2].map(|axis| Some(3 * joint + axis)),
            mounting,
            is_mounted: true,
            bias: [0.1, -0.2, 0.3],
        };
        let gyroscopes = Gyroscopes {
            all: vec![
                sensor(0, tilted),
                sensor(1, of_rpy([90.0, 0.0, 30.0])),
                sensor(2, IDENTITY),
            ],
            corner: 1.0,
            joints: vec![
                place(None, IDENTITY),
                place(Some(0), quarter),
                place(Some(1), tilted),
            ],
        };
        let (q, dq) = ([0.4, -1.1, 2.0], [0.7, -0.3, 1.9]);
        let velocities = gyroscopes.angular_velocities(&q, &dq);
        let readings: Vec<f64> = (gyroscopes.all.iter().zip(&velocities))
            .flat_map(|(own, velocity)| {
                let exact = Gyroscopes::reading(own, velocity);
                [0, 1, 2].map(|axis| exact[axis] + own.bias[axis])
            })
            .collect();
        for (own, rate) in gyroscopes.all.iter().zip(dq) {
            let (weights, bias) = gyroscopes.rate(own);
            let sum: f64 = weights.iter().map(|(c, w)| readings[*c] * w).sum();
            assert!((sum - bias - rate).abs() < 1e-12);
        }
    }
}
