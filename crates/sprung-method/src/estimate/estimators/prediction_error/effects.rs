//! Effects that the filter does not model, only their derivatives: of channels, of motors and of gears.

use super::measurements::{Measurements, Segment};
use crate::description::Experiment;
use crate::log::{Channels, Quantity, Signal};
use crate::model::Model;
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

/// Periods of a torque ripple per turn of the motor: poles and slots of the motor, teeth of the gear.
const RIPPLES: [u8; 5] = [1, 2, 4, 6, 12];

/// Periods of a transmission error per turn of the motor: that of the shaft, and that of a strain wave gear.
const TRANSMISSION_ERRORS: [u8; 2] = [1, 2];

/// The treatment of the common delay of all torques.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TorquesTiming {
    /// The description gives delays of torques.
    Given,
    /// It is tested.
    Tested,
    /// It is estimated.
    Estimated,
}

/// An effect that the filter does not model, only its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Effect {
    /// Delay of a position sensor.
    SensorDelay(usize),
    /// Delay of the torque on a row.
    TorqueDelay(usize),
    /// Common delay of all torques.
    TorquesDelay,
    /// Saturation of the torque on a row: `τ − s τ (τ/scale)²` acts instead of τ. The scale is the
    /// standard deviation of the torque, N·m (N).
    Saturation { row: usize, scale: f64 },
    /// Eccentricity of the encoder of a revolute link: it reads `q + a sin q` or `q + a cos q`.
    Eccentricity { sensor: usize, is_cosine: bool },
    /// Ripple of the motor torque on a row, relative to the standard deviation of the torque.
    Ripple { row: usize, scale: f64, wave: Wave },
    /// Transmission error of the gear between two rows, rad: the spring is deflected by it, too.
    TransmissionError {
        link: usize,
        motor: usize,
        /// N·m/rad.
        stiffness: f64,
        wave: Wave,
    },
    /// Change of the viscous friction of a motor over the logs, relative to its mean.
    Drift {
        row: usize,
        /// N·m·s/rad (N·s/m).
        viscous: f64,
        /// Index of the viscous friction in theta.
        parameter: usize,
    },
}

/// A sine or cosine of the position of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wave {
    pub(super) coordinate: usize,
    pub(super) per_turn: u8,
    /// Periods per turn of the joint.
    order: f64,
    pub(super) is_cosine: bool,
}

impl Wave {
    /// Returns the mean over a period that begins with a state.
    fn mean(self, period: f64, x: &[f64]) -> f64 {
        let (position, velocity) = x.split_at(x.len() / 2);
        let half = 0.5 * self.order * velocity[self.coordinate] * period;
        let angle = self.order * position[self.coordinate] + half;
        let sinc = if half.abs() > 1e-6 {
            half.sin() / half
        } else {
            1.0
        };
        let (sine, cosine) = angle.sin_cos();
        sinc * if self.is_cosine { cosine } else { sine }
    }
}

impl Effect {
    pub(super) fn is_delay(self) -> bool {
        matches!(
            self,
            Self::SensorDelay(_) | Self::TorqueDelay(_) | Self::TorquesDelay
        )
    }

    /// Returns the unit of its value; empty for ratios.
    pub(super) fn unit(self) -> &'static str {
        match self {
            Self::SensorDelay(_) | Self::TorqueDelay(_) | Self::TorquesDelay => "s",
            Self::Eccentricity { .. } | Self::TransmissionError { .. } => "rad",
            Self::Saturation { .. } | Self::Ripple { .. } | Self::Drift { .. } => "",
        }
    }

    /// Returns whether the effect is the second phase of a wave.
    pub(super) fn is_cosine(self) -> bool {
        match self {
            Self::Eccentricity { is_cosine, .. } => is_cosine,
            Self::Ripple { wave, .. } | Self::TransmissionError { wave, .. } => wave.is_cosine,
            Self::SensorDelay(_)
            | Self::TorqueDelay(_)
            | Self::TorquesDelay
            | Self::Saturation { .. }
            | Self::Drift { .. } => false,
        }
    }

    /// Returns the derivative of the innovation of a sensor.
    ///
    /// - `coordinates`: coordinates that the sensor measures; `x`: positions and velocities of all
    ///   rows.
    pub(super) fn of_innovation(
        self,
        sensor: usize,
        coordinates: &[(usize, f64)],
        x: &[f64],
    ) -> f64 {
        let (position, velocity) = x.split_at(x.len() / 2);
        let sum =
            |of: &[f64]| -> f64 { coordinates.iter().map(|&(c, weight)| weight * of[c]).sum() };
        match self {
            Self::SensorDelay(affected) if affected == sensor => sum(velocity),
            Self::Eccentricity {
                sensor: affected,
                is_cosine,
            } if affected == sensor => {
                let (sine, cosine) = sum(position).sin_cos();
                -if is_cosine { cosine } else { sine }
            }
            _ => 0.0,
        }
    }

    /// Returns the derivative of the torque on a row over the period after a sample.
    ///
    /// - `x`: positions and velocities of all rows at the sample.
    pub(super) fn of_torque(
        self,
        (segment, sample): (&Segment, usize),
        row: usize,
        x: &[f64],
    ) -> f64 {
        let at = sample * (segment.torque.len() / segment.samples()) + row;
        match self {
            // The torque of a late channel is logged later, so its derivative by the delay is
            // its rate.
            Self::TorqueDelay(affected) if affected == row => segment.torque_rate[at],
            Self::TorquesDelay => segment.torque_rate[at],
            Self::Saturation {
                row: affected,
                scale,
            } if affected == row => {
                let torque = segment.torque[at];
                -torque * (torque / scale).powi(2)
            }
            Self::Ripple {
                row: affected,
                scale,
                wave,
            } if affected == row => scale * wave.mean(segment.period, x),
            Self::TransmissionError {
                link,
                motor,
                stiffness,
                wave,
            } if row == link || row == motor => {
                let torque = stiffness * wave.mean(segment.period, x);
                if row == link { torque } else { -torque }
            }
            Self::Drift {
                row: affected,
                viscous,
                ..
            } if affected == row => -viscous * x[x.len() / 2 + row] * (segment.share(sample) - 0.5),
            _ => 0.0,
        }
    }
}

/// Returns the delay of each channel and that of all torques, each with its channel. The delays to be estimated come
/// first.
pub(super) fn of_delays(
    model: &Model,
    channels: &Channels,
    measurements: &Measurements,
    (estimated, torques): (&[usize], TorquesTiming),
) -> Vec<(usize, Effect)> {
    let delay = |i: usize| {
        let channel = &channels.all[i];
        if channel.quantity == Quantity::MotorTorque {
            return Some((i, Effect::TorqueDelay(model.torque_row(channel.joint))));
        }
        let sensor = measurements.sensors.iter().position(|s| s.channel == i)?;
        Some((i, Effect::SensorDelay(sensor)))
    };
    let first_torque = (channels.all.iter())
        .position(|channel| channel.quantity == Quantity::MotorTorque)
        .filter(|_| torques != TorquesTiming::Given);
    let of_all = first_torque.map(|i| (i, Effect::TorquesDelay));
    // The delay of the only torque is that of all torques.
    let is_torque = |i: usize| channels.all[i].quantity == Quantity::MotorTorque;
    let is_alone =
        first_torque.is_some() && (0..channels.all.len()).filter(|&i| is_torque(i)).count() == 1;
    let others =
        (0..channels.all.len()).filter(|&i| !(estimated.contains(&i) || is_alone && is_torque(i)));
    (estimated.iter().copied().filter_map(delay))
        .chain(of_all)
        .chain(others.filter_map(delay))
        .collect()
}

/// Returns the saturation of each torque and the eccentricity of each link encoder, each with its channel.
pub(super) fn of_sensors(
    model: &Model,
    channels: &Channels,
    measurements: &Measurements,
) -> Vec<(usize, Effect)> {
    let torques = (channels.all.iter().enumerate())
        .filter(|(_, channel)| channel.quantity == Quantity::MotorTorque)
        .map(|(i, channel)| {
            let row = model.torque_row(channel.joint);
            let scale = measurements.torque_scale[row];
            (i, Effect::Saturation { row, scale })
        });
    let encoders = (measurements.sensors.iter().enumerate())
        .filter(|(_, sensor)| {
            let channel = &channels.all[sensor.channel];
            let turns = channels.turns[channel.joint];
            let is_link = channel.quantity.signal() == Signal::Link;
            is_link && turns && sensor.coordinates == [(channel.joint, 1.0)]
        })
        .flat_map(|(i, sensor)| {
            [false, true].map(|is_cosine| {
                let sensor_effect = Effect::Eccentricity {
                    sensor: i,
                    is_cosine,
                };
                (sensor.channel, sensor_effect)
            })
        });
    torques.chain(encoders).collect()
}

/// Returns the ripple of each motor torque, the transmission error of each gear and the drift of each motor's friction,
/// each with the channel of the torque. The two phases of a wave follow each other.
///
/// - `theta`: parameters, \[p\].
pub(super) fn of_drives(
    experiment: &Experiment,
    model: &Model,
    (channels, measurements): (&Channels, &Measurements),
    theta: &[f64],
) -> Vec<(usize, Effect)> {
    let mut all = Vec::new();
    if experiment.robot.transmission_matrix.is_some() {
        return all;
    }
    for (i, channel) in channels.all.iter().enumerate() {
        if channel.quantity != Quantity::MotorTorque {
            continue;
        }
        let joint = channel.joint;
        let row = model.torque_row(joint);
        let scale = measurements.torque_scale[row];
        let viscous = JointParameter::Friction(Side::Motor, Law::Viscous);
        if let Some(parameter) = model.index(viscous, joint) {
            let drift = Effect::Drift {
                row,
                viscous: theta[parameter],
                parameter,
            };
            all.push((i, drift));
        }
        let gear_ratio = experiment.robot.joint[joint].gear_ratio;
        let Some(turns) = gear_ratio.filter(|_| channels.turns[joint]) else {
            continue;
        };
        let waves = |per_turn: u8| {
            let order = f64::from(per_turn) * turns.abs();
            [false, true].map(|is_cosine| Wave {
                coordinate: row,
                per_turn,
                order,
                is_cosine,
            })
        };
        let ripples = RIPPLES.into_iter().flat_map(waves);
        all.extend(ripples.map(|wave| (i, Effect::Ripple { row, scale, wave })));
        if let Some(index) = model.index(JointParameter::Stiffness, joint)
            && row != joint
        {
            let stiffness = theta[index];
            let errors = TRANSMISSION_ERRORS.into_iter().flat_map(waves);
            let of_wave = |wave| Effect::TransmissionError {
                link: joint,
                motor: row,
                stiffness,
                wave,
            };
            all.extend(errors.map(|wave| (i, of_wave(wave))));
        }
    }
    all
}
