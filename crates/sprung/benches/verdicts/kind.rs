//! The kinds of cases: the fault of the log or of its description.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A kind of case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// The model has all effects of the robot; good excitation.
    Matched,
    /// The robot has an effect that the model lacks.
    Misfit,
    /// A unit, a side, a sign or a column is wrong.
    WrongUnit,
    /// The motion hardly excites some parameters.
    Weak,
}

impl Kind {
    pub(crate) const ALL: [Self; 4] = [Self::Matched, Self::Misfit, Self::WrongUnit, Self::Weak];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Matched => "matched",
            Self::Misfit => "misfit",
            Self::WrongUnit => "wrong unit",
            Self::Weak => "weak excitation",
        }
    }
}

/// An effect that the model lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Misfit {
    /// Stribeck friction of the motors, relative to their Coulomb friction.
    Stribeck(f64),
    /// Stiffening of the springs at the usual torque.
    Cubic(f64),
    /// The torque acts later than its record, samples.
    TorqueDelay(usize),
    /// Torque ripple relative to the usual torque, and its periods per output turn.
    Ripple(f64, f64),
    /// Change of the Coulomb friction of the motors over the log, relative.
    Warming(f64),
    /// Friction relative to the torque of the spring.
    LoadFriction(f64),
    /// Relative change of the torque constant at the usual torque.
    Saturation(f64),
    /// Eccentric link encoders, rad.
    Eccentric(f64),
    /// The link positions are recorded late, samples.
    LateLinks(usize),
}

impl Misfit {
    pub(crate) fn random(rng: &mut ChaCha8Rng) -> Self {
        match rng.random_range(0..9) {
            0 => Self::Stribeck(rng.random_range(0.15..0.8)),
            1 => Self::Cubic(rng.random_range(0.05..0.5)),
            2 => Self::TorqueDelay(rng.random_range(1..4)),
            3 => Self::Ripple(rng.random_range(0.005..0.05), rng.random_range(20.0..200.0)),
            4 => Self::Warming(rng.random_range(-0.4..-0.1)),
            5 => Self::LoadFriction(rng.random_range(0.01..0.1)),
            6 => Self::Saturation(rng.random_range(-0.2..-0.03)),
            7 => Self::Eccentric(rng.random_range(1e-4..2e-3)),
            _ => Self::LateLinks(rng.random_range(1..4)),
        }
    }
}

/// A wrong description of the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum WrongUnit {
    /// The torque is that of the motor before the gearbox.
    MotorSide { one: bool },
    /// The torque is in mN·m.
    Millinewton,
    /// The torque is a current, N·m/A.
    Current(f64),
    /// Motor positions are in degrees; `all`: link positions, too.
    Degrees { all: bool },
    /// The link positions of one joint are in degrees.
    LinkDegrees,
    /// The motor positions are those before the gearbox.
    MotorTurns,
    /// The motor position of one joint is wrong by a factor.
    Gear(f64),
    /// One column has the wrong sign: torque, motor or link.
    Sign(usize),
    /// The columns of two joints are swapped: torque, motor or link.
    Swapped(usize),
    /// Link and motor position of one joint are exchanged.
    Exchanged,
    /// The description is that of another robot.
    Foreign,
    /// The time is in ms.
    Milliseconds,
}

impl WrongUnit {
    pub(crate) fn random(joints: usize, rng: &mut ChaCha8Rng) -> Self {
        match rng.random_range(0..14) {
            0 => Self::MotorSide { one: false },
            1 => Self::MotorSide { one: true },
            2 => Self::Millinewton,
            3 => Self::Current(rng.random_range(3.0..15.0)),
            4 => Self::Degrees { all: false },
            5 | 6 => Self::Degrees { all: true },
            7 => Self::LinkDegrees,
            8 => Self::MotorTurns,
            9 => Self::Gear(if rng.random::<bool>() { 2.0 } else { 0.5 }),
            10 => Self::Sign(rng.random_range(0..3)),
            11 if joints > 1 => Self::Swapped(rng.random_range(0..3)),
            12 => Self::Foreign,
            13 => Self::Milliseconds,
            _ => Self::Exchanged,
        }
    }
}

/// A motion or a sensor that leaves some parameters uncertain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Weak {
    /// Factor of all amplitudes.
    Small(f64),
    /// Factor of all frequencies.
    Slow(f64),
    /// Duration, s.
    Short(f64),
    /// One joint moves through this fraction of its range.
    OneStill(f64),
    /// One frequency and its double for all joints.
    OneFrequency,
    /// All joints move in phase with the same frequencies.
    InPhase,
    /// Counts per turn of all encoders.
    Coarse(u32),
}

impl Weak {
    pub(crate) fn random(rng: &mut ChaCha8Rng) -> Self {
        match rng.random_range(0..7) {
            0 => Self::Small(rng.random_range(0.03..0.3)),
            1 => Self::Slow(rng.random_range(0.05..0.3)),
            2 => Self::Short(rng.random_range(1.5..4.0)),
            3 => Self::OneStill(if rng.random::<bool>() { 0.0 } else { 0.05 }),
            4 => Self::OneFrequency,
            5 => Self::InPhase,
            _ => Self::Coarse(1 << rng.random_range(11..14)),
        }
    }
}

/// The fault of a case, if it has one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    None,
    Misfit(Misfit),
    WrongUnit(WrongUnit),
    Weak(Weak),
}

impl Fault {
    pub(crate) fn random(kind: Kind, joints: usize, rng: &mut ChaCha8Rng) -> Self {
        match kind {
            Kind::Matched => Self::None,
            Kind::Misfit => Self::Misfit(Misfit::random(rng)),
            Kind::WrongUnit => Self::WrongUnit(WrongUnit::random(joints, rng)),
            Kind::Weak => Self::Weak(Weak::random(rng)),
        }
    }
}
