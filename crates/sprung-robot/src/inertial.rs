//! Sensors of motion on links: their words, settings and errors.

use crate::log::Log;
use crate::robot::Joint;
use crate::run::Simulate;

/// An axis of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first axis.
    X,
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}

impl Axis {
    /// All axes.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];
}

/// A sensor on the link of a flexible joint, with one axis or three, that measures its motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inertial {
    /// It measures the angular velocity of the link.
    Gyroscope,
    /// It measures the acceleration of its place on the link, minus that of free fall.
    Accelerometer,
}

/// A finding about a sensor on a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InertialFinding {
    /// An axis has the wrong sign.
    Sign,
    /// The scale differs from that of the motors.
    Scale,
    /// Axes are exchanged or reversed, or the mounting is wrong.
    Axes,
    /// The reading stays at its extreme.
    Saturated,
    /// The reading without motion is not zero.
    Bias,
    /// The file gives no mounting.
    Mounting,
    /// What the sensors determine.
    Link,
}

/// A unit that readings may have by mistake.
#[derive(Clone, Debug)]
pub struct OtherUnit {
    /// Its name.
    pub name: &'static str,
    /// Keys of columns in this unit.
    pub keys: &'static str,
    /// Limits of the scale of readings in this unit that are declared in SI units.
    pub scales: std::ops::Range<f64>,
    /// Its size in SI units.
    pub size: f64,
    /// The conversion of a reading in words.
    pub conversion: &'static str,
}

/// Errors of a simulated sensor, in the unit of its reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorErrors {
    /// Standard deviation of the noise.
    pub noise: f64,
    /// Reading of each axis without motion.
    pub bias: f64,
    /// Largest reading.
    pub limit: f64,
}

impl Inertial {
    /// All sensors.
    pub const ALL: [Self; 2] = [Self::Gyroscope, Self::Accelerometer];

    /// Returns its name in messages, findings and keys.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Gyroscope => "gyroscope",
            Self::Accelerometer => "accelerometer",
        }
    }

    /// Returns its name with its article.
    pub(crate) const fn a(self) -> &'static str {
        match self {
            Self::Gyroscope => "a gyroscope",
            Self::Accelerometer => "an accelerometer",
        }
    }

    /// Returns the code of a finding. Sensors share a code if its cause and its remedy are the same.
    #[must_use]
    pub const fn code(self, finding: InertialFinding) -> &'static str {
        match (self, finding) {
            (_, InertialFinding::Sign) => "inertial-sensor-sign",
            (_, InertialFinding::Saturated) => "inertial-sensor-saturated",
            (_, InertialFinding::Bias) => "inertial-sensor-bias",
            (_, InertialFinding::Link) => "link-by-inertial-sensor",
            (Self::Gyroscope, InertialFinding::Scale) => "gyroscope-scale",
            (Self::Gyroscope, InertialFinding::Axes) => "gyroscope-axes",
            (Self::Gyroscope, InertialFinding::Mounting) => "gyroscope-mounting",
            (Self::Accelerometer, InertialFinding::Scale) => "accelerometer-scale",
            (Self::Accelerometer, InertialFinding::Axes) => "accelerometer-axes",
            (Self::Accelerometer, InertialFinding::Mounting) => "accelerometer-mounting",
        }
    }

    /// Returns the code of the error that the corner of its filter is too low; `None` for a sensor that needs no
    /// least corner.
    #[must_use]
    pub const fn corner_code(self) -> Option<&'static str> {
        match self {
            Self::Gyroscope => None,
            Self::Accelerometer => Some("accelerometer-corner"),
        }
    }

    /// Returns the unit that readings have most often by mistake.
    #[must_use]
    pub const fn other_unit(self) -> OtherUnit {
        match self {
            Self::Gyroscope => OtherUnit {
                name: "degrees per second",
                keys: "gyroscope_deg_per_s",
                scales: 40.0..80.0,
                size: std::f64::consts::PI / 180.0,
                conversion: "divided by 57.3",
            },
            Self::Accelerometer => OtherUnit {
                name: "multiples of the acceleration of free fall",
                keys: "accelerometer_g",
                scales: 0.08..0.13,
                size: 9.806_65,
                conversion: "times 9.81",
            },
        }
    }

    /// Returns the motion of the link that it measures.
    #[must_use]
    pub const fn motion(self) -> &'static str {
        match self {
            Self::Gyroscope => "velocity",
            Self::Accelerometer => "acceleration",
        }
    }

    /// Returns the keys of its mounting.
    #[must_use]
    pub const fn mounting_keys(self) -> &'static str {
        match self {
            Self::Gyroscope => "gyroscope_rpy_deg",
            Self::Accelerometer => "accelerometer_rpy_deg and accelerometer_xyz_m",
        }
    }

    /// Returns the key of its place on the link; `None` if the place does not matter.
    #[must_use]
    pub const fn place_key(self) -> Option<&'static str> {
        match self {
            Self::Gyroscope => None,
            Self::Accelerometer => Some("accelerometer_xyz_m"),
        }
    }

    /// Returns the part of the squared motion that may remain unexplained if the links follow their motors.
    #[must_use]
    pub const fn clear(self) -> f64 {
        match self {
            Self::Gyroscope => 0.5,
            // Vibrations have large accelerations.
            Self::Accelerometer => 0.02,
        }
    }

    /// Returns what it measures, about or along an axis.
    pub(crate) const fn reading(self, axis: Axis) -> &'static str {
        match (self, axis) {
            (Self::Gyroscope, Axis::X) => "the angular velocities about x",
            (Self::Gyroscope, Axis::Y) => "the angular velocities about y",
            (Self::Gyroscope, Axis::Z) => "the angular velocities about z",
            (Self::Accelerometer, Axis::X) => "the accelerations along x",
            (Self::Accelerometer, Axis::Y) => "the accelerations along y",
            (Self::Accelerometer, Axis::Z) => "the accelerations along z",
        }
    }

    /// Returns the key of the columns of an axis, without unit.
    pub(crate) const fn key(self, axis: Axis) -> &'static str {
        match (self, axis) {
            (Self::Gyroscope, Axis::X) => "gyroscope_x",
            (Self::Gyroscope, Axis::Y) => "gyroscope_y",
            (Self::Gyroscope, Axis::Z) => "gyroscope_z",
            (Self::Accelerometer, Axis::X) => "accelerometer_x",
            (Self::Accelerometer, Axis::Y) => "accelerometer_y",
            (Self::Accelerometer, Axis::Z) => "accelerometer_z",
        }
    }

    /// Returns the key of the columns of an axis, in SI units.
    pub(crate) const fn key_in_si(self, axis: Axis) -> &'static str {
        match (self, axis) {
            (Self::Gyroscope, Axis::X) => "gyroscope_rad_per_s.x",
            (Self::Gyroscope, Axis::Y) => "gyroscope_rad_per_s.y",
            (Self::Gyroscope, Axis::Z) => "gyroscope_rad_per_s.z",
            (Self::Accelerometer, Axis::X) => "accelerometer_m_per_s2.x",
            (Self::Accelerometer, Axis::Y) => "accelerometer_m_per_s2.y",
            (Self::Accelerometer, Axis::Z) => "accelerometer_m_per_s2.z",
        }
    }

    /// Returns the likely cause if a reading never changes, as the beginning of a question.
    pub(crate) const fn suspicion(self) -> &'static str {
        match self {
            Self::Gyroscope => "is the gyroscope connected",
            Self::Accelerometer => "is the accelerometer connected",
        }
    }

    /// Returns the unit of its reading.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Gyroscope => "rad/s",
            Self::Accelerometer => "m/s²",
        }
    }

    /// Returns the key of the corner of its high-pass filter.
    #[must_use]
    pub const fn corner_key(self) -> &'static str {
        match self {
            Self::Gyroscope => "gyroscope_corner_hz",
            Self::Accelerometer => "accelerometer_corner_hz",
        }
    }

    /// Returns the corner that a log gives, Hz.
    pub(crate) const fn given_corner_hz(self, log: &Log) -> Option<f64> {
        match self {
            Self::Gyroscope => log.gyroscope_corner_hz,
            Self::Accelerometer => log.accelerometer_corner_hz,
        }
    }

    /// Returns the corner if a log gives none, Hz.
    pub(crate) const fn usual_corner_hz(self) -> f64 {
        match self {
            Self::Gyroscope => 0.2,
            // The third order settles more slowly: the same 4.8 s.
            Self::Accelerometer => 0.3,
        }
    }

    /// Returns the largest held-out error of the equations with which another unit counts as the right one. Noise of an
    /// accelerometer on a soft joint halves the error with a unit that is wrong by 9.81.
    #[must_use]
    pub const fn largest_error_of_unit(self) -> f64 {
        match self {
            Self::Gyroscope => f64::INFINITY,
            Self::Accelerometer => 0.2,
        }
    }

    /// Returns whether it gives the acceleration of its joint; otherwise it gives the rate.
    #[must_use]
    pub const fn gives_acceleration(self) -> bool {
        match self {
            Self::Gyroscope => false,
            Self::Accelerometer => true,
        }
    }

    /// Returns the order of the high-pass filter that removes the drift of the link position and its constant
    /// part: one more than the number of integrations, at least two.
    pub(crate) const fn order(self) -> usize {
        match self {
            Self::Gyroscope => 2,
            Self::Accelerometer => 3,
        }
    }

    /// Returns the time in which the filter settles after a start, in time constants: the rest of a constant
    /// reading is below 2 %.
    pub(crate) const fn settling_time_constants(self) -> f64 {
        match self {
            Self::Gyroscope => 6.0,
            Self::Accelerometer => 9.0,
        }
    }

    /// Returns the mounting that the description of a joint gives: roll, pitch and yaw, degrees.
    #[must_use]
    pub const fn rpy_deg(self, joint: &Joint) -> Option<[f64; 3]> {
        match self {
            Self::Gyroscope => joint.gyroscope_rpy_deg,
            Self::Accelerometer => joint.accelerometer_rpy_deg,
        }
    }

    /// Returns the place that the description of a joint gives, in the frame of the link, m; `None` also for a
    /// sensor whose place does not matter.
    #[must_use]
    pub const fn xyz_m(self, joint: &Joint) -> Option<[f64; 3]> {
        match self {
            Self::Gyroscope => None,
            Self::Accelerometer => joint.accelerometer_xyz_m,
        }
    }

    /// Returns the errors of the sensor of a twin's joint.
    #[must_use]
    pub fn errors(self, twin: &Simulate, joint: usize) -> SensorErrors {
        let [noise, bias, limit] = match self {
            Self::Gyroscope => [
                &twin.gyroscope_noise_rad_per_s,
                &twin.gyroscope_bias_rad_per_s,
                &twin.gyroscope_limit_rad_per_s,
            ],
            Self::Accelerometer => [
                &twin.accelerometer_noise_m_per_s2,
                &twin.accelerometer_bias_m_per_s2,
                &twin.accelerometer_limit_m_per_s2,
            ],
        };
        let of = |list: &[f64], other: f64| list.get(joint).copied().unwrap_or(other);
        SensorErrors {
            noise: of(noise, 0.0),
            bias: of(bias, 0.0),
            limit: of(limit, f64::INFINITY),
        }
    }

    /// Returns a part of the seed of its noise.
    #[must_use]
    pub const fn seed(self) -> u64 {
        match self {
            Self::Gyroscope => 0x9e37_79b9_7f4a_7c15,
            Self::Accelerometer => 0xbf58_476d_1ce4_e5b9,
        }
    }
}
