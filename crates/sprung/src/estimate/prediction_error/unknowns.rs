//! What the refinement estimates: parameters, offsets between encoders, delays.

use super::measurements::{Measurements, Segment};
use crate::log::{Channels, Signal};
use crate::model::{Model, Theta};
use sprung_core::parameters::JointParameter;

/// A constant that one sensor reads too much.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offset {
    pub(super) joint: usize,
    pub(super) sensor: usize,
    /// Coordinate that starts where the sensor says.
    coordinate: usize,
    /// Standard deviation that is known before, rad (m).
    pub(super) deviation: f64,
}

/// A delay whose effect is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
enum DelayOf {
    /// Of a sensor of positions.
    Sensor(usize),
    /// Of the torque on a row.
    Torque(usize),
}

/// The unknowns: parameters that are not known, offsets, and delays.
///
/// Delays have columns but no values: what they do is linear only nearby, so that
/// measurements are made anew with every delay.
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    /// Parameter vector with the known values.
    known: Theta,
    /// Index in theta of each unknown parameter.
    pub(super) free: Vec<usize>,
    pub(super) offsets: Vec<Offset>,
    /// Channel of each delay, and what it does.
    delays: Vec<(usize, DelayOf)>,
}

impl Unknowns {
    /// - `theta`: known values, and any for the others.
    /// - `free`: indices of the others.
    ///
    /// A flexible joint without a preload of its own may have encoders that were
    /// switched on anywhere within a count.
    pub(super) fn new(
        model: &Model,
        channels: &Channels,
        measurements: &Measurements,
        theta: &[f64],
        free: Vec<usize>,
    ) -> Self {
        let deviation = |joint: usize| -> f64 {
            let own = |channel: usize| channels.all[channel].joint == joint;
            let sensors = measurements.sensors.iter().filter(|s| own(s.channel));
            let variance: f64 = sensors.map(|s| s.noise.variance()).sum();
            variance.sqrt()
        };
        let motors = |joint: usize| model.robot().motor_coordinate(joint);
        let offsets = (0..model.joint_count())
            .filter(|&joint| model.is_flexible(joint))
            .filter(|&joint| model.index(JointParameter::Preload, joint).is_none())
            .filter_map(|joint| {
                // The sensor that stands for the difference of the two.
                let sensor_of = |signal: Signal| {
                    let index = channels.telling(signal, joint)?;
                    measurements.sensors.iter().position(|s| s.channel == index)
                };
                let of_link = sensor_of(Signal::Link)?;
                let is_absolute = measurements.sensors[of_link].coordinates == [(joint, 1.0)];
                let (sensor, coordinate) = if is_absolute {
                    (sensor_of(Signal::Motor).unwrap_or(of_link), motors(joint))
                } else {
                    (of_link, joint)
                };
                Some(Offset {
                    joint,
                    sensor,
                    coordinate,
                    deviation: deviation(joint),
                })
            })
            .collect();
        Self {
            known: theta.to_vec(),
            free,
            offsets,
            delays: Vec::new(),
        }
    }

    /// Returns the same with a column for the delay of each channel, those that are
    /// to be estimated first.
    pub(super) fn with_delays(
        mut self,
        model: &Model,
        channels: &Channels,
        measurements: &Measurements,
        estimated: &[usize],
    ) -> Self {
        let others = (0..channels.all.len()).filter(|i| !estimated.contains(i));
        self.delays = (estimated.iter().copied().chain(others))
            .filter_map(|i| {
                let channel = &channels.all[i];
                if !channel.quantity.is_position() {
                    return Some((i, DelayOf::Torque(model.torque_row(channel.joint))));
                }
                let sensor = measurements.sensors.iter().position(|s| s.channel == i)?;
                Some((i, DelayOf::Sensor(sensor)))
            })
            .collect();
        self
    }

    /// Returns the channels whose delays have columns.
    pub(super) fn delayed(&self) -> impl Iterator<Item = usize> {
        self.delays.iter().map(|(channel, _)| *channel)
    }

    /// Returns the number of unknowns with values.
    pub(super) fn values(&self) -> usize {
        self.free.len() + self.offsets.len()
    }

    /// Returns the number of columns.
    pub(super) fn columns(&self) -> usize {
        self.values() + self.delays.len()
    }

    /// Returns the values that a parameter vector has, offsets zero.
    pub(super) fn point(&self, theta: &[f64]) -> Vec<f64> {
        let free = self.free.iter().map(|&i| theta[i]);
        free.chain(self.offsets.iter().map(|_| 0.0)).collect()
    }

    /// Returns the parameter vector, \[p\].
    pub(super) fn theta(&self, z: &[f64]) -> Theta {
        let mut theta = self.known.clone();
        for (&index, value) in self.free.iter().zip(z) {
            theta[index] = *value;
        }
        theta
    }

    /// Returns the column of each parameter of theta, behind `before` others.
    pub(super) fn places(&self, before: usize) -> Vec<Option<usize>> {
        let mut places = vec![None; self.known.len()];
        for (place, &index) in self.free.iter().enumerate() {
            places[index] = Some(before + place);
        }
        places
    }

    /// Returns what a sensor reads too much, rad (m).
    pub(super) fn offset(&self, z: &[f64], sensor: usize) -> f64 {
        let own = self.offsets.iter().position(|o| o.sensor == sensor);
        own.map_or(0.0, |i| z[self.free.len() + i])
    }

    /// Moves a start to where its sensors without their offsets say.
    pub(super) fn shift_start(&self, z: &[f64], x: &mut [f64]) {
        for (offset, value) in self.offsets.iter().zip(&z[self.free.len()..]) {
            x[offset.coordinate] -= value;
        }
    }

    /// Returns the derivatives of a start, \[3 rows × columns\].
    pub(super) fn start(&self, rows: usize) -> Vec<f64> {
        let count = self.columns();
        let mut derivatives = vec![0.0; 3 * rows * count];
        for (i, offset) in self.offsets.iter().enumerate() {
            derivatives[offset.coordinate * count + self.free.len() + i] = -1.0;
        }
        derivatives
    }

    /// Adds to the derivatives of an innovation what offset and delay of its sensor
    /// do.
    ///
    /// - `coordinates`: that the sensor measures; `velocity`: of all.
    pub(super) fn innovation(
        &self,
        row: &mut [f64],
        sensor: usize,
        coordinates: &[(usize, f64)],
        velocity: &[f64],
    ) {
        if let Some(i) = self.offsets.iter().position(|o| o.sensor == sensor) {
            row[self.free.len() + i] -= 1.0;
        }
        for (i, (_, delay_of)) in self.delays.iter().enumerate() {
            if *delay_of == DelayOf::Sensor(sensor) {
                let speed: f64 = coordinates
                    .iter()
                    .map(|&(c, weight)| weight * velocity[c])
                    .sum();
                row[self.values() + i] += speed;
            }
        }
    }

    /// Adds the derivatives of the torque on a row with respect to delays.
    pub(super) fn torque(&self, columns: &mut [f64], segment: &Segment, k: usize, row: usize) {
        for (i, (_, delay_of)) in self.delays.iter().enumerate() {
            if *delay_of == DelayOf::Torque(row) {
                // A torque that was recorded late is that of a later sample.
                let rows = segment.torque_rate.len() / segment.samples();
                let rate = segment.torque_rate[k * rows + row];
                columns[self.values() + i] += rate;
            }
        }
    }
}
