//! Unknowns as the filter sees them: the derivatives of innovations and of torques by their sizes.

use std::sync::Arc;

use super::measurements::{Measurements, Segment};
use crate::log::{Channels, Quantity, Signal};
use crate::model::Model;
use crate::unknowns::{
    ChannelEffect, Effect as OfUnknown, JointScales, LawColumn, MotorSample, OfMotor, Place,
    Samples, Unknown, late,
};
use sprung_core::parameters::JointParameter;

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

/// Step of a size for its derivative, relative to its usual size.
const STEP: f64 = 1e-4;

/// Samples around one, and their period, s, in which a channel is extrapolated. A step of a delay is far shorter.
const AROUND: usize = 5;
const PERIOD: f64 = 1e-3;

/// The filter's view of a robot and its logs.
#[derive(Clone, Copy)]
pub(super) struct Filtered<'a> {
    pub(super) model: &'a Model,
    pub(super) channels: &'a Channels,
    pub(super) measurements: &'a Measurements,
    /// Parameters, \[p\].
    pub(super) theta: &'a [f64],
    /// Figures of each joint.
    pub(super) joints: &'a [JointScales],
}

/// An unknown that the filter does not model, only its derivative.
#[derive(Clone, Debug)]
pub(super) struct Effect {
    pub(super) place: Place,
    acts: Acts,
}

#[derive(Clone, Debug)]
enum Acts {
    /// On the readings of sensors and on the torques of rows.
    Channels {
        sensors: Vec<usize>,
        rows: Vec<usize>,
        effect: Arc<dyn ChannelEffect>,
        step: f64,
    },
    /// Against the torque on a row.
    Motor {
        row: usize,
        of_motor: OfMotor,
        scales: JointScales,
    },
    /// As a deflection of a spring between two rows.
    Gear {
        link: usize,
        motor: usize,
        /// N·m/rad.
        stiffness: f64,
        of_motor: OfMotor,
        scales: JointScales,
    },
}

impl<'a> Filtered<'a> {
    /// Returns the view without parameters, for unknowns of channels.
    pub(super) fn of_channels(
        model: &'a Model,
        channels: &'a Channels,
        measurements: &'a Measurements,
    ) -> Self {
        Self {
            model,
            channels,
            measurements,
            theta: &[],
            joints: &[],
        }
    }
}

impl Effect {
    /// Returns an unknown as the filter sees it; `None` if it does not see it.
    pub(super) fn of(unknown: &Unknown, filtered: &Filtered<'_>) -> Option<Self> {
        let Filtered {
            model,
            channels,
            measurements,
            ..
        } = *filtered;
        let acts = match (&unknown.effect, unknown.place) {
            (OfUnknown::Channels(of, effect), _) => {
                let is_torque = |i: &&usize| channels.all[**i].quantity == Quantity::MotorTorque;
                let (torques, positions): (Vec<&usize>, Vec<&usize>) =
                    of.iter().partition(is_torque);
                let sensors = measurements.sensors.iter().enumerate();
                Acts::Channels {
                    sensors: sensors
                        .filter(|(_, sensor)| positions.contains(&&sensor.channel))
                        .map(|(i, _)| i)
                        .collect(),
                    rows: (torques.iter())
                        .map(|&&i| model.torque_row(channels.all[i].joint))
                        .collect(),
                    effect: effect.clone(),
                    step: STEP * unknown.scale,
                }
            }
            (OfUnknown::Law { column, .. }, Place::Joint(joint)) => {
                let row = model.torque_row(joint);
                // A ripple is relative to the deviation of the torque from its mean.
                let scales = JointScales {
                    torque: measurements.torque_scale[row],
                    ..*filtered.joints.get(joint)?
                };
                match column {
                    LawColumn::Terms(_) => return None,
                    LawColumn::Motor(of_motor) => Acts::Motor {
                        row,
                        of_motor: of_motor.clone(),
                        scales,
                    },
                    LawColumn::Gear(of_motor) => Acts::Gear {
                        link: joint,
                        motor: row,
                        stiffness: filtered.theta[model.index(JointParameter::Stiffness, joint)?],
                        of_motor: of_motor.clone(),
                        scales,
                    },
                }
            }
            _ => return None,
        };
        let is_seen = match &acts {
            Acts::Channels { sensors, rows, .. } => !(sensors.is_empty() && rows.is_empty()),
            Acts::Motor { .. } => true,
            Acts::Gear { link, motor, .. } => link != motor,
        };
        is_seen.then_some(Self {
            place: unknown.place,
            acts,
        })
    }

    /// Returns whether it is the delay of all torques.
    pub(super) fn is_of_torques(&self) -> bool {
        self.place == Place::All(Signal::Torque)
    }

    /// Returns the derivative of the innovation of a sensor.
    ///
    /// - `coordinates`: coordinates that the sensor measures; `x`: positions and velocities of all
    ///   rows.
    pub(super) fn of_innovation(
        &self,
        sensor: usize,
        coordinates: &[(usize, f64)],
        x: &[f64],
    ) -> f64 {
        match &self.acts {
            Acts::Channels {
                sensors,
                effect,
                step,
                ..
            } if sensors.contains(&sensor) => {
                let (position, velocity) = x.split_at(x.len() / 2);
                let [value, rate] = [position, velocity]
                    .map(|of| coordinates.iter().map(|&(c, weight)| weight * of[c]).sum());
                by_size(&**effect, *step, [value, rate])
            }
            _ => 0.0,
        }
    }

    /// Returns the derivative of the torque on a row over the period after a sample.
    ///
    /// - `x`: positions and velocities of all rows at the sample.
    pub(super) fn of_torque(
        &self,
        (segment, sample): (&Segment, usize),
        row: usize,
        x: &[f64],
    ) -> f64 {
        let at = sample * (segment.torque.len() / segment.samples());
        let motor = |of: usize, scales| MotorSample {
            share: segment.share(sample),
            period: segment.period,
            position: x[of],
            velocity: x[x.len() / 2 + of],
            torque: segment.torque[at + of],
            scales,
        };
        match &self.acts {
            Acts::Channels {
                rows, effect, step, ..
            } if rows.contains(&row) => {
                let rate = segment.torque_rate[at + row];
                by_size(&**effect, *step, [segment.torque[at + row], rate])
            }
            Acts::Motor {
                row: of,
                of_motor,
                scales,
            } if *of == row => -of_motor.at(&motor(row, scales)),
            Acts::Gear {
                link,
                motor: of,
                stiffness,
                of_motor,
                scales,
            } if row == *link || row == *of => {
                let torque = stiffness * of_motor.at(&motor(*of, scales));
                if row == *link { torque } else { -torque }
            }
            _ => 0.0,
        }
    }
}

/// Returns the derivative of a reading by the size of an unknown.
fn by_size(effect: &dyn ChannelEffect, step: f64, [value, rate]: [f64; 2]) -> f64 {
    let time: [f64; AROUND] = std::array::from_fn(|k| PERIOD * (k as f64 - (AROUND / 2) as f64));
    let values = time.map(|time| value + rate * time);
    let samples = Samples {
        time: &time,
        values: &values,
        period: PERIOD,
        span: [time[0], time[AROUND - 1]],
    };
    let at = |size: f64| effect.perturb(&samples, size)[AROUND / 2];
    (at(step) - at(-step)) / (2.0 * step)
}

/// Returns the delay of each channel and that of all torques. The delays to be estimated come first.
pub(super) fn of_delays(
    filtered: &Filtered<'_>,
    (estimated, torques): (&[usize], TorquesTiming),
) -> Vec<Effect> {
    let channels = filtered.channels;
    let is_torque = |i: &usize| channels.all[*i].quantity == Quantity::MotorTorque;
    let of_torques: Vec<usize> = (0..channels.all.len()).filter(is_torque).collect();
    let delay =
        |place: Place, of: Vec<usize>| Effect::of(&late(String::new(), place, of), filtered);
    let of_channel = |i: usize| delay(Place::Channel(i), vec![i]);
    let of_all = (torques != TorquesTiming::Given)
        .then(|| delay(Place::All(Signal::Torque), of_torques.clone()))
        .flatten();
    // The delay of the only torque is that of all torques.
    let is_alone = |i: usize| of_all.is_some() && of_torques == [i];
    let others = (0..channels.all.len()).filter(|&i| !(estimated.contains(&i) || is_alone(i)));
    let others: Vec<Effect> = others.filter_map(of_channel).collect();
    (estimated.iter().copied().filter_map(of_channel))
        .chain(of_all)
        .chain(others)
        .collect()
}
