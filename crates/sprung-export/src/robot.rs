//! A robot with the inertial parameters of every link and the parameters of every drive, as simulators
//! need them.

use sprung_core::chain::ChainJoint;
use sprung_core::spatial::BODY;

/// Suffix of the name of a motor's joint.
pub(super) const MOTOR: &str = "_motor";

/// Suffix of the name of a rotor's link.
pub(super) const ROTOR: &str = "_rotor";

/// Suffix of the name of a spring.
pub(super) const SPRING: &str = "_spring";

/// How a flexible joint is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Motor and link with a spring between them.
    Flexible,
    /// One joint without a spring; motor and link move together.
    Rigid,
}

/// A robot of single links.
#[derive(Clone, Debug)]
pub(super) struct StandardRobot {
    pub(super) name: String,
    /// Acceleration of free fall in the base frame, m/s².
    pub(super) gravity: [f64; 3],
    /// Parents come before their children.
    pub(super) joints: Vec<StandardJoint>,
}

/// A joint, its link and its drive.
#[derive(Clone, Debug)]
pub(super) struct StandardJoint {
    pub(super) name: String,
    pub(super) link: String,
    pub(super) place: ChainJoint,
    /// Inertial parameters about the origin of the joint's frame.
    pub(super) body: [f64; BODY],
    pub(super) drive: DriveValues,
    pub(super) limits: JointLimits,
}

/// Limits of a joint; `None` if unknown.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct JointLimits {
    /// Position, rad (m).
    pub(super) lower: Option<f64>,
    pub(super) upper: Option<f64>,
    /// Torque after the gear, N·m (N).
    pub(super) effort: Option<f64>,
    /// Velocity, rad/s (m/s).
    pub(super) velocity: Option<f64>,
}

/// Parameters of a drive after the gear.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DriveValues {
    pub(super) is_flexible: bool,
    pub(super) gear_ratio: f64,
    pub(super) rotor_inertia: f64,
    /// Stiffness and damping of the spring; zero in a rigid joint.
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    pub(super) link: Friction,
    pub(super) motor: Friction,
}

/// Friction that all formats can represent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Friction {
    pub(super) viscous: f64,
    pub(super) coulomb: f64,
}

impl StandardJoint {
    /// Returns whether the joint is written with a spring.
    pub(super) fn has_spring(&self, form: Form) -> bool {
        self.drive.is_flexible && form == Form::Flexible
    }

    /// Returns the friction of the joint that moves the link: that of the bearing, and that of the
    /// motor if it has no separate joint.
    pub(super) fn friction(&self, form: Form) -> Friction {
        let DriveValues { link, motor, .. } = self.drive;
        if self.has_spring(form) {
            return link;
        }
        Friction {
            viscous: link.viscous + motor.viscous,
            coulomb: link.coulomb + motor.coulomb,
        }
    }

    /// Returns the body in the form of files.
    pub(super) fn inertial(&self) -> Inertial {
        Inertial::of(&self.body)
    }
}

/// Mass, centre of mass, and inertia about it, in the axes of the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Inertial {
    /// kg.
    pub(super) mass: f64,
    /// m.
    pub(super) centre: [f64; 3],
    /// ixx, ixy, iyy, ixz, iyz, izz, kg·m².
    pub(super) inertia: [f64; 6],
}

impl Inertial {
    /// Converts parameters about the origin, by the parallel axis theorem.
    pub(super) fn of(body: &[f64; BODY]) -> Self {
        let mass = body[0];
        let [x, y, z] = [body[1] / mass, body[2] / mass, body[3] / mass];
        Self {
            mass,
            centre: [x, y, z],
            inertia: [
                body[4] - mass * (y * y + z * z),
                body[5] + mass * x * y,
                body[6] - mass * (x * x + z * z),
                body[7] + mass * x * z,
                body[8] + mass * y * z,
                body[9] - mass * (x * x + y * y),
            ],
        }
    }
}

/// Returns a rotation matrix as a quaternion of unit length: w, x, y, z.
pub(super) fn quaternion(r: &[[f64; 3]; 3]) -> [f64; 4] {
    // The largest component is divided by, so that no precision is lost.
    let squares = [
        1.0 + r[0][0] + r[1][1] + r[2][2],
        1.0 + r[0][0] - r[1][1] - r[2][2],
        1.0 - r[0][0] + r[1][1] - r[2][2],
        1.0 - r[0][0] - r[1][1] + r[2][2],
    ];
    let largest = (0..4).fold(
        0,
        |best, k| {
            if squares[k] > squares[best] { k } else { best }
        },
    );
    let [wx, wy, wz] = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]];
    let [xy, xz, yz] = [r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]];
    let square = squares[largest];
    let raw = match largest {
        0 => [square, wx, wy, wz],
        1 => [wx, square, xy, xz],
        2 => [wy, xy, square, yz],
        _ => [wz, xz, yz, square],
    };
    let length = raw.iter().map(|x| x * x).sum::<f64>().sqrt();
    raw.map(|x| x / length)
}

/// Returns a rotation matrix as roll, pitch and yaw about the fixed axes x, y and z, rad.
pub(super) fn roll_pitch_yaw(r: &[[f64; 3]; 3]) -> [f64; 3] {
    let level = r[0][0].hypot(r[1][0]);
    let pitch = (-r[2][0]).atan2(level);
    if level > 1e-9 {
        return [r[2][1].atan2(r[2][2]), pitch, r[1][0].atan2(r[0][0])];
    }
    // Roll and yaw turn about the same axis, so one of them is free.
    [(-r[1][2]).atan2(r[1][1]), pitch, 0.0]
}

/// Returns a direction in which gravity does no work.
pub(super) fn level([x, y, z]: &[f64; 3]) -> [f64; 3] {
    let length = x.hypot(*y);
    if length > 1e-12 * z.abs() && length > 0.0 {
        [-y / length, x / length, 0.0]
    } else {
        [1.0, 0.0, 0.0]
    }
}

/// Returns numbers with a space between them, each with all its digits.
pub(super) fn numbers(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(|value| number(*value)).collect();
    words.join(" ")
}

/// Returns a number with all its digits.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-5..1e9).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotations about z, y and x in this order.
    fn rotation([roll, pitch, yaw]: [f64; 3]) -> [[f64; 3]; 3] {
        let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    }

    fn of_quaternion([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
        [
            [
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y - w * z),
                2.0 * (x * z + w * y),
            ],
            [
                2.0 * (x * y + w * z),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z - w * x),
            ],
            [
                2.0 * (x * z - w * y),
                2.0 * (y * z + w * x),
                1.0 - 2.0 * (x * x + y * y),
            ],
        ]
    }

    #[test]
    fn rotations_survive_both_forms() {
        let half = std::f64::consts::FRAC_PI_2;
        for angles in [
            [0.3, -0.7, 2.1],
            [half, 0.0, 0.0],
            [0.4, half, 0.9],
            [0.4, -half, 0.9],
            [std::f64::consts::PI, 0.0, 0.0],
            [-half, 0.0, half],
            [3.0, 0.1, -3.0],
        ] {
            let r = rotation(angles);
            for again in [of_quaternion(quaternion(&r)), rotation(roll_pitch_yaw(&r))] {
                for (a, b) in again.iter().flatten().zip(r.iter().flatten()) {
                    assert!((a - b).abs() < 1e-15, "{angles:?}: {again:?} and {r:?}");
                }
            }
        }
    }

    #[test]
    fn numbers_keep_their_digits() {
        for value in [0.1 + 0.2, 1e-300, -4.25e-7, 123_456_789.125, 1e17, 0.0] {
            let again: f64 = number(value).parse().unwrap();
            assert_eq!(again.to_bits(), value.to_bits());
        }
    }
}
