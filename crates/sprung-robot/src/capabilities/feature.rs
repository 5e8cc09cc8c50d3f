//! Features of robots and logs that decide what works.

use crate::inertial::Inertial;

/// What a joint is measured with, or a property of the robot or a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// A flexible joint with a link encoder.
    LinkEncoder,
    /// A flexible joint with a sensor of its deflection.
    DeflectionSensor,
    /// A flexible joint with a torque sensor and a link position.
    TorqueSensor,
    /// A flexible joint with a torque sensor and no link position.
    TorqueSensorAlone,
    /// A flexible joint with a gyroscope on its link.
    Gyroscope,
    /// A flexible joint with an accelerometer on its link.
    Accelerometer,
    /// A joint without spring: its motor tells its position.
    MotorOnly,
    /// A position servo, whose log has targets and no torque.
    Servo,
    /// Friction that depends on covariates.
    Covariates,
    /// A log that was recorded with a known payload.
    KnownPayload,
    /// A log with a payload that is to be estimated.
    UnknownPayload,
    /// A coupled transmission.
    CoupledTransmission,
    /// A robot in closed form.
    ClosedForm,
    /// The search for springs that only the motors see.
    SpringsFromMotor,
    /// Several joints.
    SeveralJoints,
    /// A joint that is flexible.
    FlexibleJoint,
    /// A joint that slides.
    SlidingJoint,
    /// Delays, signs or gains that are to be estimated.
    OpenColumns,
    /// A spring with a cubic term.
    CubicSpring,
    /// Friction that depends on the load.
    LoadFriction,
}

impl Feature {
    /// Returns the feature of a sensor on links.
    pub(crate) const fn of_sensor(sensor: Inertial) -> Self {
        match sensor {
            Inertial::Gyroscope => Self::Gyroscope,
            Inertial::Accelerometer => Self::Accelerometer,
        }
    }

    /// All features, in the order of the page.
    pub(crate) const ALL: [Self; 20] = [
        Self::LinkEncoder,
        Self::DeflectionSensor,
        Self::TorqueSensor,
        Self::TorqueSensorAlone,
        Self::Gyroscope,
        Self::Accelerometer,
        Self::MotorOnly,
        Self::Servo,
        Self::Covariates,
        Self::KnownPayload,
        Self::UnknownPayload,
        Self::CoupledTransmission,
        Self::ClosedForm,
        Self::SpringsFromMotor,
        Self::SeveralJoints,
        Self::FlexibleJoint,
        Self::SlidingJoint,
        Self::OpenColumns,
        Self::CubicSpring,
        Self::LoadFriction,
    ];

    /// Returns its name on the page.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::LinkEncoder => "link encoder",
            Self::DeflectionSensor => "deflection sensor",
            Self::TorqueSensor => "joint torque sensor and link position",
            Self::TorqueSensorAlone => "joint torque sensor alone",
            Self::Gyroscope => "gyroscope on the link",
            Self::Accelerometer => "accelerometer on the link",
            Self::MotorOnly => "motor encoder alone (rigid joint)",
            Self::Servo => "position servo",
            Self::Covariates => "friction with covariates",
            Self::KnownPayload => "known payload",
            Self::UnknownPayload => "payload to be estimated",
            Self::CoupledTransmission => "coupled transmission",
            Self::ClosedForm => "robot in closed form",
            Self::SpringsFromMotor => "springs from the motors",
            Self::SeveralJoints => "several joints",
            Self::FlexibleJoint => "flexible joint",
            Self::SlidingJoint => "sliding joint",
            Self::OpenColumns => "delays, signs or gains to be estimated",
            Self::CubicSpring => "cubic spring",
            Self::LoadFriction => "load-dependent friction",
        }
    }

    /// Returns it as the object of a sentence.
    pub(crate) const fn noun(self) -> &'static str {
        match self {
            Self::LinkEncoder => "a link encoder",
            Self::DeflectionSensor => "a deflection sensor",
            Self::TorqueSensor | Self::TorqueSensorAlone => "a joint torque sensor",
            Self::Gyroscope => "a gyroscope on the link",
            Self::Accelerometer => "an accelerometer on the link",
            Self::MotorOnly => "a motor encoder alone",
            Self::Servo => "a position servo",
            Self::Covariates => "friction_covariates",
            Self::KnownPayload => "a known payload",
            Self::UnknownPayload => "a payload to be estimated",
            Self::CoupledTransmission => "a coupled transmission",
            Self::ClosedForm => "a robot in closed form",
            Self::SpringsFromMotor => "springs_from_motor",
            Self::SeveralJoints => "several joints",
            Self::FlexibleJoint => "a flexible joint",
            Self::SlidingJoint => "a sliding joint",
            Self::OpenColumns => "delays, signs or gains to be estimated",
            Self::CubicSpring => "\"cubic\" in spring",
            Self::LoadFriction => "the friction law \"load\"",
        }
    }

    /// Returns the property of a joint, a log or the robot: a verb and its object, after their
    /// name.
    pub(crate) const fn has(self) -> &'static str {
        match self {
            Self::LinkEncoder => "has a link encoder",
            Self::DeflectionSensor => "has a deflection sensor",
            Self::TorqueSensor => "has a torque sensor and a link position",
            Self::TorqueSensorAlone => "has a torque sensor and no link position",
            Self::Gyroscope => "has a gyroscope on its link",
            Self::Accelerometer => "has an accelerometer on its link",
            Self::MotorOnly => "is measured by its motor alone",
            Self::Servo => "is a position servo",
            Self::Covariates => "has friction_covariates",
            Self::KnownPayload => "was recorded with a known payload",
            Self::UnknownPayload => "was recorded with a payload that is to be estimated",
            Self::CoupledTransmission => "has a coupled transmission",
            Self::ClosedForm => "is described in closed form",
            Self::SpringsFromMotor => "is to have springs_from_motor",
            Self::SeveralJoints => "has several joints",
            Self::FlexibleJoint => "is flexible",
            Self::SlidingJoint => "slides",
            Self::OpenColumns => "has delays, signs or gains that are to be estimated",
            Self::CubicSpring => "has a cubic spring",
            Self::LoadFriction => "has the friction law \"load\"",
        }
    }
}
