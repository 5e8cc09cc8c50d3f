//! Limits of a motion, as numbers that must stay between -1 and 1.

use serde::Serialize;

use crate::description::{Experiment, Limits};

/// A limited quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limited {
    /// Position of link or motor.
    Position,
    /// Velocity of link or motor.
    Velocity,
    /// Acceleration of the reference.
    Acceleration,
    /// Jerk of the reference.
    Jerk,
    /// Motor torque.
    Torque,
    /// Rate of the motor torque.
    TorqueRate,
    /// Deflection of the spring.
    Deflection,
    /// Speed of the tool.
    ToolSpeed,
    /// Height of a link or of the tool above the floor.
    Height,
}

impl Limited {
    /// All limited quantities.
    pub const ALL: [Self; 9] = [
        Self::Position,
        Self::Velocity,
        Self::Acceleration,
        Self::Jerk,
        Self::Torque,
        Self::TorqueRate,
        Self::Deflection,
        Self::ToolSpeed,
        Self::Height,
    ];

    /// Returns its name for people.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
            Self::Torque => "motor torque",
            Self::TorqueRate => "rate of the motor torque",
            Self::Deflection => "deflection",
            Self::ToolSpeed => "speed of the tool",
            Self::Height => "height above the floor",
        }
    }

    /// Returns its unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Position | Self::Deflection => "rad",
            Self::Velocity => "rad/s",
            Self::Acceleration => "rad/s²",
            Self::Jerk => "rad/s³",
            Self::Torque => "N·m",
            Self::TorqueRate => "N·m/s",
            Self::ToolSpeed => "m/s",
            Self::Height => "m",
        }
    }

    /// Returns the key of the experiment file that gives the limit.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Position => "position_rad",
            Self::Velocity => "velocity_rad_per_s",
            Self::Acceleration => "acceleration_rad_per_s2",
            Self::Jerk => "jerk_rad_per_s3",
            Self::Torque => "torque_nm",
            Self::TorqueRate => "torque_rate_nm_per_s",
            Self::Deflection => "deflection_rad",
            Self::ToolSpeed => "tool_speed_m_per_s",
            Self::Height => "floor_m",
        }
    }
}

/// The middle and half the width of an allowed interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Middle.
    pub middle: f64,
    /// Half the width; infinite without limit.
    pub half: f64,
}

impl Interval {
    /// No limit.
    pub const FREE: Self = Self {
        middle: 0.0,
        half: f64::INFINITY,
    };

    fn about_zero(limit: Option<f64>) -> Self {
        limit.map_or(Self::FREE, |half| Self { middle: 0.0, half })
    }

    /// Returns the place of a value, between -1 and 1 inside the interval.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        (value - self.middle) / self.half
    }

    /// Returns the interval with a part of its half width.
    #[must_use]
    pub fn narrowed(&self, part: f64) -> Self {
        Self {
            half: self.half * part,
            ..*self
        }
    }

    /// Returns whether there is a limit.
    #[must_use]
    pub fn is_limited(&self) -> bool {
        self.half.is_finite()
    }
}

/// Limits of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointBounds {
    /// Positions, velocities, accelerations and jerks.
    pub orders: [Interval; 4],
    /// Motor torque.
    pub torque: Interval,
    /// Rate of the motor torque.
    pub torque_rate: Interval,
    /// Deflection of the spring.
    pub deflection: Interval,
}

impl JointBounds {
    /// Returns the limits of a description.
    #[must_use]
    pub fn new(limits: &Limits) -> Self {
        let position = limits
            .position_rad
            .map_or(Interval::FREE, |[low, high]| Interval {
                middle: 0.5 * (low + high),
                half: 0.5 * (high - low),
            });
        Self {
            orders: [
                position,
                Interval::about_zero(limits.velocity_rad_per_s),
                Interval::about_zero(limits.acceleration_rad_per_s2),
                Interval::about_zero(limits.jerk_rad_per_s3),
            ],
            torque: Interval::about_zero(limits.torque_nm),
            torque_rate: Interval::about_zero(limits.torque_rate_nm_per_s),
            deflection: Interval::about_zero(limits.deflection_rad),
        }
    }

    /// Returns the interval of a quantity of the joint; no limit for those of the whole robot.
    #[must_use]
    pub fn of(&self, what: Limited) -> Interval {
        match what {
            Limited::Position => self.orders[0],
            Limited::Velocity => self.orders[1],
            Limited::Acceleration => self.orders[2],
            Limited::Jerk => self.orders[3],
            Limited::Torque => self.torque,
            Limited::TorqueRate => self.torque_rate,
            Limited::Deflection => self.deflection,
            Limited::ToolSpeed | Limited::Height => Interval::FREE,
        }
    }

    fn map(&self, change: impl Fn(Limited, Interval) -> Interval) -> Self {
        let of = |what| change(what, self.of(what));
        Self {
            orders: [
                of(Limited::Position),
                of(Limited::Velocity),
                of(Limited::Acceleration),
                of(Limited::Jerk),
            ],
            torque: of(Limited::Torque),
            torque_rate: of(Limited::TorqueRate),
            deflection: of(Limited::Deflection),
        }
    }
}

/// Height above the floor from which a point is free, m.
pub(super) const FREE_HEIGHT: f64 = 0.5;

/// Returns the used part of the limit of a height: 1 on the floor, 0 where the point is free.
pub(super) fn height_used(height: f64, floor: f64) -> f64 {
    (1.0 - (height - floor) / FREE_HEIGHT).max(0.0)
}

/// Distance from the floor that stays free for a margin of the whole limit, m.
const FLOOR_MARGIN: f64 = 1.0;

/// Limits of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Limits of each joint, \[n\].
    pub joints: Vec<JointBounds>,
    /// Speed of the tool, m/s.
    pub tool_speed: Interval,
    /// Lowest height, m.
    pub floor: Option<f64>,
}

impl Bounds {
    /// Returns the limits of an experiment.
    #[must_use]
    pub fn new(experiment: &Experiment) -> Self {
        let robot = &experiment.robot;
        Self {
            joints: (0..robot.joint.len())
                .map(|joint| JointBounds::new(&robot.limits(joint)))
                .collect(),
            tool_speed: Interval::about_zero(experiment.excite.tool_speed_m_per_s),
            floor: experiment.excite.floor_m,
        }
    }

    /// Returns the limits with a part of their widths, in the order of [`Limited::ALL`].
    #[must_use]
    pub fn narrowed(&self, parts: &[f64; Limited::ALL.len()]) -> Self {
        let part = |what: Limited| parts[what as usize];
        Self {
            joints: (self.joints.iter())
                .map(|joint_bounds| {
                    joint_bounds.map(|what, interval| interval.narrowed(part(what)))
                })
                .collect(),
            tool_speed: self.tool_speed.narrowed(part(Limited::ToolSpeed)),
            floor: (self.floor).map(|floor| floor + (1.0 - part(Limited::Height)) * FLOOR_MARGIN),
        }
    }
}
