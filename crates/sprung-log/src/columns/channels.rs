//! Assigns columns to quantities, and converts them to SI units on the output side.

use sprung_core::chain::JointKind;
use sprung_core::covariate::Covariate;

use super::channel::{Channel, ChannelError};
use super::from_keys::channels;
use super::inertial::{InertialSensors, check_sensors};
use super::mix::Mix;
use super::origin::TimeOrigin;
use super::time::{TimeSource, are_dates, sampling, time};
use crate::description::{
    CsvForm, Delay, Instrumentation, Joint, Key, Log, MissingValues, Quantity, Robot, Scaling,
    Side, Signal, TorqueHold, WrongSamples,
};

/// The channels of a log: link positions, motor positions and motor torques, joint by joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Source of the time.
    pub time: TimeSource,
    /// Form of CSV files, as far as the description declares it.
    pub csv: CsvForm,
    /// Treatment of samples without a value.
    pub nan: MissingValues,
    /// Treatment of samples that contradict their neighbours.
    pub wrong_samples: WrongSamples,
    /// Link, motor and torque channels.
    pub all: Vec<Channel>,
    /// Whether the torques acted exactly as logged, for example commands without noise.
    pub exact_torque: bool,
    /// The time for which the torques act, if the description gives it.
    pub torque_hold: Option<TorqueHold>,
    /// The instruments of the joints.
    pub instruments: Instrumentation,
    /// The sensors of motion on the links, if the log has any.
    pub inertial: Option<InertialSensors>,
    /// Whether each joint is revolute; otherwise it is prismatic.
    pub turns: Vec<bool>,
    /// Offsets that are added to the positions of links and motors, rad, \[n\].
    pub offsets: Vec<f64>,
    /// The covariates on which the friction of joints depends.
    pub covariates: Vec<CovariateOfJoint>,
    /// Conversion of motor positions to joint positions, if they are recorded before a coupled
    /// transmission.
    pub position_mix: Option<Mix>,
    /// Conversion of motor torques to joint torques, if they are recorded before a coupled
    /// transmission.
    pub torque_mix: Option<Mix>,
}

/// A covariate on which the friction of a joint depends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CovariateOfJoint {
    /// Index of the joint, from 0.
    pub joint: usize,
    /// The covariate.
    pub covariate: Covariate,
    /// Its value at which friction has its parameters.
    pub reference: f64,
}

/// Returns the covariates of the joints of a robot, joint by joint.
fn covariates(robot: &Robot) -> Vec<CovariateOfJoint> {
    let mut all = Vec::new();
    for (joint, robot_joint) in robot.joint.iter().enumerate() {
        for (covariate, reference) in Covariate::ALL.into_iter().zip(robot_joint.references()) {
            if robot_joint.depends_on(covariate) {
                all.push(CovariateOfJoint {
                    joint,
                    covariate,
                    reference,
                });
            }
        }
    }
    all
}

impl Channels {
    /// Returns the channels that a description names.
    ///
    /// # Errors
    ///
    /// [`ChannelError`] if a quantity has no column or cannot be converted.
    pub fn new(robot: &Robot, log: &Log) -> Result<Self, ChannelError> {
        Self::of(&Signal::all().collect::<Vec<Signal>>(), robot, log)
    }

    /// Returns the channels that the description of a position servo names.
    ///
    /// # Errors
    ///
    /// [`ChannelError`] if a quantity has no column or cannot be converted.
    pub fn of_servo(robot: &Robot, log: &Log) -> Result<Self, ChannelError> {
        Self::of(&Signal::OF_SERVO, robot, log)
    }

    fn of(signals: &[Signal], robot: &Robot, log: &Log) -> Result<Self, ChannelError> {
        let all = channels(signals, robot, log)?;
        let timeless = |channel: &Channel| {
            let stream = &channel.origin.stream;
            stream.topic.is_none() && stream.time.is_none()
        };
        let source = match time(log) {
            Some(time) => time,
            None if !all.iter().any(timeless) => TimeSource {
                origin: TimeOrigin::Messages,
                stream: None,
                factor: 1.0,
                sampling: sampling(log),
                are_dates: are_dates(log),
            },
            None => {
                return Err(ChannelError::NotSaid {
                    what: "the time",
                    keys: "time_s, time_ms, time_us, time_ns or period_s",
                });
            }
        };
        let inertial = InertialSensors::new(robot, &all);
        check_sensors(robot, inertial.as_ref())?;
        Ok(Self {
            inertial,
            instruments: Instrumentation::new(robot, Some(log)),
            time: source,
            csv: log.csv.clone().unwrap_or_default(),
            nan: log.nan.unwrap_or_default(),
            wrong_samples: log.wrong_samples.unwrap_or_default(),
            all,
            exact_torque: log.motor_torque_exact,
            torque_hold: log.torque.map(|reading| TorqueHold {
                reading,
                controller_period: log.controller_period_s,
            }),
            turns: (0..robot.joint.len())
                .map(|i| robot.kind(i) == JointKind::Revolute)
                .collect(),
            offsets: (robot.joint.iter())
                .map(|joint| joint.position_offset_deg.to_radians())
                .collect(),
            covariates: covariates(robot),
            position_mix: mixed(robot, log.side(Scaling::PositionSide)).map(|(ratios, inverse)| {
                Mix {
                    forward: inverse,
                    back: ratios,
                }
            }),
            torque_mix: mixed(robot, torque_side(robot, log)).map(|(ratios, inverse)| Mix {
                forward: transposed(&ratios),
                back: transposed(&inverse),
            }),
        })
    }

    /// Returns the index in [`Channels::all`] of the channel with this quantity and joint.
    #[must_use]
    pub fn index(&self, quantity: Quantity, joint: usize) -> Option<usize> {
        self.all
            .iter()
            .position(|c| c.quantity == quantity && c.joint == joint)
    }

    /// Returns the index in [`Channels::all`] of the channel that gives a signal of a joint.
    #[must_use]
    pub fn telling(&self, signal: Signal, joint: usize) -> Option<usize> {
        (self.all.iter()).position(|c| c.quantity.signal() == signal && c.joint == joint)
    }

    /// Returns the index in [`Channels::all`] of the channel that gives a covariate of a joint: that of the joint, or
    /// that of all joints; `None` for the time.
    #[must_use]
    pub fn of_covariate(&self, covariate: Covariate, joint: usize) -> Option<usize> {
        let signal = Signal::Covariate(covariate);
        (self.telling(signal, joint))
            .or_else(|| (self.all.iter()).position(|c| c.quantity.signal() == signal))
    }

    /// Returns the delay of each channel relative to torques that are held from their time stamp to the next one, s.
    ///
    /// - `delays`: of the channels beyond the description, s; `period`: of the log, s.
    #[must_use]
    pub fn acting_delays(&self, delays: &[f64], period: f64) -> Vec<f64> {
        let of_torques = self
            .torque_hold
            .map_or(0.0, |torque_hold| torque_hold.delay(period));
        (self.all.iter().zip(delays))
            .map(|(channel, delay)| match channel.quantity.signal() {
                Signal::Torque => delay + of_torques,
                _ => *delay,
            })
            .collect()
    }

    /// Returns the time for which the values of each channel are held, in periods of the log: of torques by the description or by
    /// their delays, of other channels 1.
    ///
    /// - `delays`: of the channels beyond the description, s; `period`: of the log, s.
    #[must_use]
    pub fn holds(&self, delays: &[f64], period: f64) -> Vec<f64> {
        (self.all.iter().zip(delays))
            .map(|(channel, delay)| match channel.quantity.signal() {
                Signal::Torque => match self.torque_hold {
                    Some(torque_hold) => torque_hold.hold(period) / period,
                    None => TorqueHold::hold_by_delay(delay / period),
                },
                _ => 1.0,
            })
            .collect()
    }

    /// Returns the channels with link and motor columns of a joint exchanged, to test whether they
    /// are exchanged in the description; `None` if one of the two positions has no column. The
    /// order of the values in blocks stays.
    #[must_use]
    pub fn exchanged(&self, joint: usize) -> Option<Self> {
        let link = self.index(Quantity::LinkPosition, joint)?;
        let motor = self.index(Quantity::MotorPosition, joint)?;
        let mut exchanged = self.clone();
        exchanged.all[link].quantity = Quantity::MotorPosition;
        exchanged.all[motor].quantity = Quantity::LinkPosition;
        Some(exchanged)
    }

    /// Checks that each joint has a channel against which the delays of the others show.
    ///
    /// # Errors
    ///
    /// [`ChannelError::NoReference`] if the delays of all channels of a joint are to be estimated.
    pub fn require_references(&self, robot: &Robot) -> Result<(), ChannelError> {
        match (0..robot.joint.len()).find(|&joint| !self.has_reference(joint)) {
            None => Ok(()),
            Some(joint) => Err(ChannelError::NoReference {
                joint: robot.joint[joint].name.clone(),
            }),
        }
    }

    /// Returns whether a joint has a channel against which the delays of the others show, or no channel.
    fn has_reference(&self, joint: usize) -> bool {
        let is_covariate =
            |channel: &Channel| matches!(channel.quantity.signal(), Signal::Covariate(_));
        let mut of_joint = (self.all.iter())
            .filter(|channel| channel.joint == joint && !is_covariate(channel))
            .map(|channel| channel.delay != Some(Delay::Estimate))
            .peekable();
        of_joint.peek().is_none() || of_joint.any(|is_reference| is_reference)
    }

    /// Checks that the sides of all torque constants are known.
    ///
    /// # Errors
    ///
    /// [`ChannelError::OpenSide`] if one is open.
    pub fn require_sides(&self, robot: &Robot) -> Result<(), ChannelError> {
        match self.all.iter().find(|channel| channel.open_side) {
            None => Ok(()),
            Some(open) => Err(ChannelError::OpenSide {
                joint: robot.joint[open.joint].name.clone(),
            }),
        }
    }

    /// Returns the channels with the columns of a quantity exchanged between two joints, for the
    /// same test; `None` if one joint lacks the quantity.
    #[must_use]
    pub fn swapped(&self, quantity: Quantity, one: usize, two: usize) -> Option<Self> {
        let (a, b) = (self.index(quantity, one)?, self.index(quantity, two)?);
        let mut swapped = self.clone();
        swapped.all[a].joint = two;
        swapped.all[b].joint = one;
        Some(swapped)
    }
}

/// Returns the side on which torques were recorded, or for currents the side of the torque
/// constants.
fn torque_side(robot: &Robot, log: &Log) -> Option<Side> {
    let as_torque = |(key, _): (&Key, _)| key.scaling == Scaling::TorqueSide;
    if log.given().any(as_torque) {
        log.side(Scaling::TorqueSide)
    } else {
        robot.joint.first().map(Joint::side_of_constant)
    }
}

/// Returns the ratios of a coupled transmission and their inverse, if a quantity was recorded
/// before the transmission.
#[expect(clippy::type_complexity, reason = "a matrix and its inverse")]
fn mixed(robot: &Robot, side: Option<Side>) -> Option<(Vec<Vec<f64>>, Vec<Vec<f64>>)> {
    let ratios = robot.transmission_matrix.as_ref()?;
    if side.unwrap_or_default() == Side::Output {
        return None;
    }
    let n = ratios.len();
    let matrix = faer::Mat::from_fn(n, n, |i, j| ratios[i][j]);
    let inverse = {
        use faer::linalg::solvers::DenseSolveCore;
        matrix.partial_piv_lu().inverse()
    };
    let rows = (0..n).map(|i| (0..n).map(|j| inverse[(i, j)]).collect());
    Some((ratios.clone(), rows.collect()))
}

fn transposed(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..matrix.len())
        .map(|j| matrix.iter().map(|row| row[j]).collect())
        .collect()
}
