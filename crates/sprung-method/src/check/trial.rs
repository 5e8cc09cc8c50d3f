//! Other meanings of the columns of a log, tried with the equations of the whole robot.

use crate::description::Quantity;
use crate::log::Channels;
use crate::prepare::{Excerpt, LinkRows};
use crate::regression::Reading;

/// An excerpt with another meaning of its columns.
#[derive(Clone)]
pub(super) struct Trial {
    pub(super) excerpt: Excerpt,
    pub(super) channels: Channels,
}

/// Groups of quantities whose columns may be in the order of other joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// All columns of a joint.
    All,
    /// The positions.
    Positions,
    /// The positions of the links.
    Links,
    /// The positions of the motors.
    Motors,
    /// The torques.
    Torques,
}

impl Group {
    pub(super) const ALL: [Self; 5] = [
        Self::All,
        Self::Positions,
        Self::Links,
        Self::Motors,
        Self::Torques,
    ];

    pub(super) fn contains(self, quantity: Quantity) -> bool {
        let is_motor = quantity == Quantity::MotorPosition;
        match self {
            Self::All => true,
            Self::Positions => quantity.is_position(),
            Self::Links => quantity.is_position() && !is_motor,
            Self::Motors => is_motor,
            Self::Torques => !quantity.is_position(),
        }
    }

    /// Returns the columns of the group in words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::All => "the columns",
            Self::Positions => "the positions",
            Self::Links => "the link positions",
            Self::Motors => "the motor positions",
            Self::Torques => "the torques",
        }
    }
}

impl Trial {
    /// Returns the trial with all positions of a joint multiplied by a factor.
    pub(super) fn with_positions(&self, joint: usize, by: f64) -> Self {
        self.scaled(joint, by, |quantity| Group::Positions.contains(quantity))
    }

    /// Returns the trial with the motor torque of a joint multiplied by a factor.
    pub(super) fn with_torque(&self, joint: usize, by: f64) -> Self {
        self.scaled(joint, by, |quantity| quantity == Quantity::MotorTorque)
    }

    /// Returns the trial with the joint torque of a joint multiplied by a factor.
    pub(super) fn with_sensor(&self, joint: usize, by: f64) -> Self {
        self.scaled(joint, by, |quantity| quantity == Quantity::JointTorque)
    }

    /// Returns the trial with the signs of all columns of a joint reversed.
    pub(super) fn reversed(&self, joint: usize) -> Self {
        self.scaled(joint, -1.0, |_| true)
    }

    fn scaled(&self, joint: usize, by: f64, is_meant: impl Fn(Quantity) -> bool) -> Self {
        let mut trial = self.clone();
        for (i, channel) in self.channels.all.iter().enumerate() {
            if channel.joint == joint && is_meant(channel.quantity) {
                trial.excerpt = trial.excerpt.scaled(i, by);
            }
        }
        trial
    }

    /// Returns the trial with columns of two joints swapped; each column takes the unit and the gear
    /// ratio of the other. A quantity that only one joint has keeps its column. `None` if no quantity
    /// can be swapped.
    pub(super) fn swapped(&self, group: Group, one: usize, two: usize) -> Option<Self> {
        let mut trial = self.clone();
        let mut is_changed = false;
        for quantity in Quantity::all() {
            let of = |joint| self.channels.index(quantity, joint);
            if let (Some(a), Some(b), true) = (of(one), of(two), group.contains(quantity)) {
                let ratio = self.channels.all[b].factor / self.channels.all[a].factor;
                trial.channels = trial.channels.swapped(quantity, one, two)?;
                trial.channels.all[a].factor *= ratio;
                trial.channels.all[b].factor /= ratio;
                trial.excerpt = trial.excerpt.scaled(a, ratio).scaled(b, 1.0 / ratio);
                is_changed = true;
            }
        }
        is_changed.then_some(trial)
    }

    /// Returns the part of each link's torque that the equations of the robot leave unexplained (root mean squares);
    /// `None` if a spring is negative or no fit is possible.
    pub(super) fn left(&self, reading: &Reading, joints: &[usize]) -> Option<Vec<f64>> {
        let reading = reading.with_channels(self.channels.clone());
        let rows = LinkRows::new(&self.excerpt, &reading, joints)?;
        let left = rows.together(reading.model())?;
        rows.plausible.then_some(left)
    }
}

/// Residuals below this part of a torque count as equal: sensors explain them.
const SENSOR_SHARE: f64 = 0.005;

/// Conditions for another meaning of the columns: sum of the logarithms by which residuals fall, and
/// largest ratio of the residuals in the joint that gains most.
const CERTAIN_GAIN: f64 = 1.0;
const CERTAIN_RATIO: f64 = 0.4;

/// Returns whether residuals fall so far that another scale of one joint is likely.
pub(super) fn is_likely(before: &[f64], after: &[f64]) -> bool {
    gain(before, after) >= CERTAIN_GAIN
}

/// Returns whether residuals fall so far that the other meaning of the columns is certain.
pub(super) fn is_certain(before: &[f64], after: &[f64]) -> bool {
    let ratios = (before.iter().zip(after))
        .map(|(before, after)| (after + SENSOR_SHARE) / (before + SENSOR_SHARE));
    gain(before, after) >= CERTAIN_GAIN && ratios.fold(f64::INFINITY, f64::min) <= CERTAIN_RATIO
}

/// Returns the sum over the joints of the logarithms by which residuals fall.
pub(super) fn gain(before: &[f64], after: &[f64]) -> f64 {
    (before.iter().zip(after))
        .map(|(before, after)| ((before + SENSOR_SHARE) / (after + SENSOR_SHARE)).ln())
        .sum()
}

/// Returns the root mean square of values; not a number without values.
pub(super) fn root_mean_square(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|value| value * value).sum();
    (sum / values.len() as f64).sqrt()
}
