//! An unknown of a log: what may differ from the description by an unknown size.

use std::fmt::Debug;
use std::sync::Arc;

use sprung_core::drives::Term;
use sprung_core::friction::Shape;

use super::result::AddedLaw;
use crate::log::{Channels, Signal};

/// Both phases of a wave, the last words of the ids of its unknowns, and whether it is the cosine.
pub(super) const PHASES: [(&str, bool); 2] = [("sine", false), ("cosine", true)];

/// Returns the name of the wave of which an unknown is one phase: both phases of a wave are one fault.
pub(super) fn wave(kind: Kind, id: &str) -> Option<&str> {
    let is_wave = matches!(
        kind,
        Kind::Eccentricity | Kind::Ripple | Kind::TransmissionError
    );
    let mut phases = PHASES.iter().map(|(phase, _)| phase).filter(|_| is_wave);
    phases.find_map(|phase| id.strip_suffix(phase)?.strip_suffix(' '))
}

/// Least relative change of gravity by a clock: one that runs at twice its speed has -0.75.
const LEAST_GRAVITY: f64 = -0.8;

/// Kind of an unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A channel, or one signal of all joints, is recorded late.
    Delay,
    /// All torques act at another time than their stamps.
    Timing,
    /// A channel reads a constant factor too much or too little.
    Gain,
    /// The zero of a link encoder is not that of the motor's.
    Offset,
    /// The zero of a position moves evenly.
    Drift,
    /// A position jumps once.
    LostCounts,
    /// The error of an encoder repeats with each turn.
    Eccentricity,
    /// The acting torque grows less or more than the logged one.
    Saturation,
    /// The torque of a motor repeats with its angle.
    Ripple,
    /// The error of a gear repeats with the angle of its motor.
    TransmissionError,
    /// Viscous friction changes during the log.
    WarmUp,
    /// Coulomb friction changes its direction over other velocities than assumed.
    Sharpness,
    /// A second of the log lasts more or less than a second.
    TimeScale,
    /// The description lacks a law.
    Law,
    /// Friction is not as it was.
    Friction,
    /// The stiffness of a joint is not as it was.
    Stiffness,
    /// A spring has a play that it had not.
    Play,
    /// The links carry another load.
    Load,
}

impl Kind {
    /// Returns the name in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::Timing => "timing",
            Self::Gain => "gain",
            Self::Offset => "offset",
            Self::Drift => "drift",
            Self::LostCounts => "lost-counts",
            Self::Eccentricity => "eccentricity",
            Self::Saturation => "saturation",
            Self::Ripple => "torque-ripple",
            Self::TransmissionError => "transmission-error",
            Self::WarmUp => "warm-up",
            Self::Sharpness => "sharpness",
            Self::TimeScale => "time-scale",
            Self::Law => "law",
            Self::Friction => "friction",
            Self::Stiffness => "stiffness",
            Self::Play => "play",
            Self::Load => "load",
        }
    }

    /// Returns whether sprung corrects it without being asked.
    pub(crate) fn is_applied(self) -> bool {
        match self {
            Self::Delay | Self::Timing | Self::Offset | Self::Sharpness => true,
            Self::Gain
            | Self::Drift
            | Self::LostCounts
            | Self::Eccentricity
            | Self::Saturation
            | Self::Ripple
            | Self::TransmissionError
            | Self::WarmUp
            | Self::TimeScale
            | Self::Law
            | Self::Friction
            | Self::Stiffness
            | Self::Play
            | Self::Load => false,
        }
    }
}

/// Where an unknown acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A channel, by its index in [`Channels::all`](crate::log::Channels::all).
    Channel(usize),
    /// The channels of one signal of all joints.
    All(Signal),
    /// A joint.
    Joint(usize),
    /// All links.
    Robot,
}

impl Place {
    /// Returns whether it contains a channel.
    pub(crate) fn contains(self, channel: usize, channels: &Channels) -> bool {
        match self {
            Self::Channel(at) => at == channel,
            Self::All(signal) => channels.all[channel].quantity.signal() == signal,
            Self::Joint(_) | Self::Robot => false,
        }
    }
}

/// Samples of one channel without a gap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples<'s> {
    /// Time, s.
    pub(crate) time: &'s [f64],
    /// Values, rad (m) or N·m (N).
    pub(crate) values: &'s [f64],
    /// Sampling period, s.
    pub(crate) period: f64,
    /// First time of the log and the duration of what is examined, s.
    pub(crate) span: [f64; 2],
}

/// Effect of an unknown on the samples of one channel.
pub(crate) trait ChannelEffect: Debug + Send + Sync {
    /// Returns the samples as they would be without the unknown, if it has the given size. This is the only definition of the
    /// effect: its column is the derivative by the size, its correction is this function at the size that was found.
    fn perturb(&self, samples: &Samples<'_>, size: f64) -> Vec<f64>;

    /// Returns whether a derivative of the samples by time is known as well. An error that begins at a time which is only
    /// near has none.
    fn has_rate(&self) -> bool {
        true
    }

    /// Returns the time at which it begins, s; `None` for an effect on all samples.
    fn begins(&self) -> Option<f64> {
        None
    }

    /// Returns whether it is the factor of a torque.
    fn scales_torque(&self) -> bool {
        false
    }
}

/// Figures of a joint that give a law of its measured torque its scales.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointScales {
    /// Sharpness of Coulomb friction, s/rad (s/m).
    pub(crate) sharpness: f64,
    /// Root mean squares of the deflection and of the torque.
    pub(crate) deflection: f64,
    pub(crate) torque: f64,
}

/// What the motor of a joint does at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotorSample<'s> {
    /// Place in the log, from 0 at its beginning to 1.
    pub(crate) share: f64,
    /// Time over which the torque acts, s; zero for an instant.
    pub(crate) period: f64,
    /// Position, rad (m), and velocity.
    pub(crate) position: f64,
    pub(crate) velocity: f64,
    /// Measured torque, N·m (N).
    pub(crate) torque: f64,
    pub(crate) scales: &'s JointScales,
}

/// A quantity of a motor, per unit of the size of its unknown.
#[derive(Clone)]
pub(crate) struct OfMotor(Arc<dyn Fn(&MotorSample<'_>) -> f64 + Send + Sync>);

impl OfMotor {
    pub(crate) fn new(of: impl Fn(&MotorSample<'_>) -> f64 + Send + Sync + 'static) -> Self {
        Self(Arc::new(of))
    }

    pub(crate) fn at(&self, sample: &MotorSample<'_>) -> f64 {
        (self.0)(sample)
    }
}

impl Debug for OfMotor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("OfMotor")
    }
}

/// Torque of a law with a coefficient of 1.
#[derive(Clone, Debug)]
pub(crate) enum LawColumn {
    /// Terms of the equations, in all rows.
    Terms(Vec<(Term, Shape)>),
    /// A torque that opposes that of the motor.
    Motor(OfMotor),
    /// A deflection of the spring that the positions do not show.
    Gear(OfMotor),
}

/// What shows an unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShownBy {
    /// The rows of the regression.
    Rows,
    /// The innovations of the refinement.
    Innovations,
    Both,
}

/// How an unknown enters the equations.
#[derive(Clone, Debug)]
pub(crate) enum Effect {
    /// It changes the samples of channels.
    Channels(Vec<usize>, Arc<dyn ChannelEffect>),
    /// It is a torque of a joint, and perhaps a law that a description can have.
    Law {
        column: LawColumn,
        added: Option<AddedLaw>,
    },
    /// It multiplies the sharpness of Coulomb friction of a joint; its size is the logarithm of the factor.
    Sharpness(usize),
    /// It changes parameters, \[p\] for a size of one.
    Parameters(Vec<f64>),
    /// It changes the acceleration of free fall in the base frame, m/s² for a size of one.
    Gravity([f64; 3]),
}

/// An unknown.
#[derive(Clone, Debug)]
pub(crate) struct Unknown {
    /// Stable name, as in `delay q1_rad`.
    pub(crate) id: String,
    pub(crate) kind: Kind,
    pub(crate) place: Place,
    /// Size that is usual, one standard deviation, in `unit`; infinite for the coefficient of a law and the change of a parameter.
    pub(crate) scale: f64,
    /// Size up to which any log may have it, so that significance alone decides; zero for a cause that must explain enough.
    pub(crate) expected: f64,
    /// Size below which it is no cause, because the resolution of the channel explains as much; of one without a usual size as part
    /// of the joint's torque.
    pub(crate) least: f64,
    /// Whether it is a rare fault, which must explain more.
    pub(crate) is_rare: bool,
    /// Whether only positive sizes exist.
    pub(crate) is_positive: bool,
    pub(crate) unit: &'static str,
    pub(crate) shown_by: ShownBy,
    pub(crate) effect: Effect,
}

impl Unknown {
    /// Returns an unknown of any size, that is no rare fault and that rows show.
    pub(crate) fn new(
        id: String,
        kind: Kind,
        place: Place,
        unit: &'static str,
        effect: Effect,
    ) -> Self {
        Self {
            id,
            kind,
            place,
            scale: f64::INFINITY,
            expected: 0.0,
            least: 0.0,
            is_rare: false,
            is_positive: false,
            unit,
            shown_by: ShownBy::Rows,
            effect,
        }
    }

    /// Returns the name of the wave of which it is one phase.
    pub(crate) fn wave(&self) -> Option<&str> {
        wave(self.kind, &self.id)
    }

    /// Returns whether what is applied of it changes the equations; the coefficient of a law and the change of a parameter or of
    /// gravity are estimated with them.
    pub(crate) fn is_applied(&self) -> bool {
        matches!(self.effect, Effect::Channels(..) | Effect::Sharpness(_))
    }

    /// Returns the channels that it changes.
    pub(crate) fn channels(&self) -> &[usize] {
        match &self.effect {
            Effect::Channels(channels, _) => channels,
            _ => &[],
        }
    }

    /// Returns the size below which it is no cause.
    ///
    /// - `scale`: its usual size; of a law the coefficient that makes its torque as large as that of the joint.
    pub(crate) fn least_size(&self, scale: f64) -> f64 {
        if self.scale.is_infinite() {
            self.least * scale
        } else {
            self.least
        }
    }

    /// Returns the size after a step that was found while a size was applied.
    pub(crate) fn after(&self, size: f64, step: f64) -> f64 {
        if self.kind == Kind::Gain {
            size + (1.0 + size) * step
        } else {
            size + step
        }
    }

    /// Returns whether a derivative by time of its effect is known.
    pub(crate) fn has_rate(&self) -> bool {
        match &self.effect {
            Effect::Channels(_, effect) => effect.has_rate(),
            _ => true,
        }
    }

    /// Returns the time at which it begins, s; `None` for an effect on all samples.
    pub(crate) fn begins(&self) -> Option<f64> {
        match &self.effect {
            Effect::Channels(_, effect) => effect.begins(),
            _ => None,
        }
    }

    /// Returns whether it is the factor of a torque.
    pub(crate) fn scales_torque(&self) -> bool {
        match &self.effect {
            Effect::Channels(_, effect) => effect.scales_torque(),
            _ => false,
        }
    }

    /// Returns whether it can have a size: gravity does not vanish by a clock.
    pub(crate) fn can_have(&self, size: f64) -> bool {
        !matches!(self.effect, Effect::Gravity(_)) || size > LEAST_GRAVITY
    }

    /// Returns whether it is a factor that parameters mimic but for those that rows share.
    pub(crate) fn is_factor(&self) -> bool {
        self.scales_torque() || matches!(self.effect, Effect::Gravity(_))
    }

    /// Returns the law that it adds to a description, if it does.
    pub(crate) fn added(&self) -> Option<&AddedLaw> {
        match &self.effect {
            Effect::Law { added, .. } => added.as_ref(),
            _ => None,
        }
    }

    /// Returns the same law with Stribeck friction of a velocity, rad/s (m/s).
    pub(crate) fn with_stribeck_velocity(mut self, velocity: f64) -> Self {
        if let Effect::Law {
            added: Some(added), ..
        } = &mut self.effect
        {
            added.stribeck_velocity = Some(velocity);
        }
        self
    }
}
