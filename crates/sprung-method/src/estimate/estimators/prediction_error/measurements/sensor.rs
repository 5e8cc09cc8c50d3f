//! Position channels and torque sensors: their coordinates, offsets and noise.

use super::measurement::Measurement;
use super::read::RawSegment;
use super::spring::SpringReading;
use crate::log::{Channels, Measures, Mix, Quantity};
use crate::model::Model;
use crate::prepare::deviation;

/// Noise of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Noise {
    /// Quantisation with counts of this size, rad (m).
    Counts(f64),
    /// White noise with this standard deviation, rad (m).
    White(f64),
}

impl Noise {
    /// Returns the variance of a sample, rad² (m²).
    pub(in super::super) fn variance(self) -> f64 {
        match self {
            Self::Counts(step) => uniform_variance(step),
            Self::White(deviation) => deviation * deviation,
        }
    }
}

/// A position channel or a torque sensor. It measures a weighted sum of coordinates.
#[derive(Clone, Debug)]
pub(in super::super) struct Sensor {
    /// Index in [`Channels::all`].
    pub(in super::super) channel: usize,
    /// Coordinates and their weights: the row of H for a measurement taken at a sample.
    pub(in super::super) coordinates: Vec<(usize, f64)>,
    /// Constant that is added to a logged value to get the weighted sum of coordinates, rad (m).
    pub(in super::super) offset: f64,
    pub(in super::super) noise: Noise,
    /// Standard deviation of the logged values, rad (m).
    pub(in super::super) scale: f64,
    /// The torque of a spring; `None` for a position.
    pub(in super::super) spring: Option<SpringReading>,
}

impl Sensor {
    /// Returns the factor of logged values.
    pub(super) fn factor(&self) -> f64 {
        self.spring
            .as_ref()
            .map_or(1.0, |spring| spring.stiffness.recip())
    }

    /// Returns the entries of H for one measurement that are not zero: states and their weights.
    /// The states are the sensor's coordinates and, if the measurement is older than its sample,
    /// their velocities.
    pub(in super::super) fn observation(
        &self,
        measurement: &Measurement,
        rows: usize,
    ) -> impl Iterator<Item = (usize, f64)> + Clone {
        let age = measurement.age;
        let moved = move |&(coordinate, weight): &(usize, f64)| (rows + coordinate, -weight * age);
        let velocities = self
            .coordinates
            .iter()
            .filter(move |_| age > 0.0)
            .map(moved);
        self.coordinates.iter().copied().chain(velocities)
    }
}

/// Returns `H x`.
pub(in super::super) fn observe(x: &[f64], observation: impl Iterator<Item = (usize, f64)>) -> f64 {
    observation.map(|(state, weight)| weight * x[state]).sum()
}

/// Returns the sensors of all position channels.
///
/// - `raw`: samples, from which the scales are computed; `noise`: noise of each channel.
/// - `compliances`: of the joints with torque sensors, \[n\]; a sensor without is left out.
pub(super) fn sensors(
    model: &Model,
    channels: &Channels,
    compliances: &[f64],
    raw: &[RawSegment],
    noise: impl Fn(usize) -> Noise,
) -> Vec<Sensor> {
    let robot = model.robot();
    let motor = |joint: usize| robot.motor_coordinate(joint);
    (channels.all.iter().enumerate())
        .filter_map(|(i, channel)| {
            let joint = channel.joint;
            let values = raw.iter().flat_map(|raw| raw.values[i].iter().copied());
            if channel.quantity == Quantity::JointTorque && compliances[joint] > 0.0 {
                let compliance = compliances[joint];
                let spring = SpringReading::new(model, joint, compliance.recip());
                return Some(Sensor {
                    channel: i,
                    coordinates: spring.coordinates(),
                    offset: 0.0,
                    noise: Noise::White(compliance * noise(i).variance().sqrt()),
                    scale: compliance * deviation(values),
                    spring: Some(spring),
                });
            }
            let Measures::Position {
                link,
                motor: of_motor,
            } = channel.quantity.measures()
            else {
                return None;
            };
            let (coordinates, offset) = match &channels.position_mix {
                Some(mix) if link == 0.0 => {
                    let row = &mix.back[joint];
                    let parts = row.iter().enumerate().filter(|(_, ratio)| **ratio != 0.0);
                    let offset = Mix::apply(std::slice::from_ref(row), &channels.offsets)[0];
                    (parts.map(|(j, ratio)| (motor(j), *ratio)).collect(), offset)
                }
                _ => {
                    let parts = [(joint, link), (motor(joint), of_motor)];
                    let parts = parts.into_iter().filter(|(_, factor)| *factor != 0.0);
                    let offset = channels.offsets[joint] * (link + of_motor);
                    (parts.collect(), offset)
                }
            };
            Some(Sensor {
                channel: i,
                coordinates,
                offset,
                noise: noise(i),
                scale: deviation(values),
                spring: None,
            })
        })
        .collect()
}

/// Returns the variance of a value that is anywhere in an interval with the same probability.
pub(super) fn uniform_variance(width: f64) -> f64 {
    width * width / 12.0
}
