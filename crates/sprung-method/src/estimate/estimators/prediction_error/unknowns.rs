//! Unknowns of the refinement: parameters, offsets between encoders, effects.

use super::dynamics::{ScaleOfJoint, ScalePlace};
use super::effects::Effect;
use super::measurements::{Measurement, Measurements, Segment, Sensor};
use super::presliding_levels::PreslidingLevel;
use crate::estimate::estimators::prediction_error::state_layout::state_count;
use crate::log::{Channels, Signal};
use crate::model::{Model, Theta};
use sprung_core::friction::Scale;
use sprung_core::parameters::JointParameter;

/// A constant offset of one sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offset {
    pub(super) joint: usize,
    pub(super) sensor: usize,
    /// Coordinate whose start value comes from this sensor.
    coordinate: usize,
    /// Standard deviation of the prior, rad (m).
    pub(super) deviation: f64,
}

/// A value in which friction laws are not linear, estimated by its logarithm: a Stribeck velocity or
/// the sharpness of Coulomb friction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bend {
    pub(super) joint: usize,
    pub(super) scale: Scale,
    /// Logarithm at the start.
    start: f64,
}

/// Standard deviations of the priors, as logarithms. They keep the Stribeck velocity of a joint without
/// Stribeck friction, and the sharpness of a joint that hardly reverses, near their starts. The values
/// never leave twice these deviations.
const LOG_VELOCITY_DEVIATION: f64 = 1.5;
const LOG_SHARPNESS_DEVIATION: f64 = 1.0;

impl Bend {
    fn deviation(&self) -> f64 {
        match self.scale {
            Scale::Sharpness => LOG_SHARPNESS_DEVIATION,
            Scale::Stribeck | Scale::Presliding => LOG_VELOCITY_DEVIATION,
        }
    }
}

/// A normal prior of an unknown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Index of the unknown.
    pub(super) at: usize,
    pub(super) mean: f64,
    pub(super) deviation: f64,
}

/// The unknowns: parameters that are not fixed, offsets, scales of friction laws, and effects of
/// channels.
///
/// Effects have columns but no values. That of a delay is linear only for small changes, so the
/// measurements are built again for every delay.
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    /// Parameter vector with the fixed values.
    known: Theta,
    /// Index in theta of each unknown parameter.
    pub(super) free: Vec<usize>,
    pub(super) offsets: Vec<Offset>,
    pub(super) bends: Vec<Bend>,
    /// Prior levels of presliding friction.
    pub(super) presliding: Vec<PreslidingLevel>,
    effects: Vec<Effect>,
}

impl Unknowns {
    /// - `theta`: the fixed values; the other entries are ignored.
    /// - `free`: indices of the unknown parameters.
    ///
    /// A flexible joint without a preload parameter gets an offset, because its encoders may be
    /// zeroed anywhere within a count.
    pub(super) fn new(
        model: &Model,
        channels: &Channels,
        measurements: &Measurements,
        theta: &[f64],
        free: Vec<usize>,
    ) -> Self {
        let deviation = |joint: usize| -> f64 {
            let is_of_joint = |channel: usize| channels.all[channel].joint == joint;
            let sensors = measurements
                .sensors
                .iter()
                .filter(|s| is_of_joint(s.channel));
            let variance: f64 = sensors.map(|s| s.noise.variance()).sum();
            variance.sqrt()
        };
        let motors = |joint: usize| model.robot().motor_coordinate(joint);
        let offsets = (0..model.joint_count())
            .filter(|&joint| model.is_flexible(joint))
            .filter(|&joint| model.index(JointParameter::Preload, joint).is_none())
            .filter_map(|joint| {
                // The motion shows only the difference of the two encoders, so one sensor gets the
                // offset.
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
        let has_friction = |joint: usize| {
            let mut laws = model.parameters_of(Scale::Stribeck, joint);
            laws.any(|index| free.contains(&index))
        };
        let jumps = |joint: usize| model.jumps(joint).any(|index| free.contains(&index));
        let velocities = (model.open_stribeck().iter().copied())
            .filter(|&joint| has_friction(joint))
            .map(|joint| (joint, Scale::Stribeck));
        let sharpness = (model.open_sharpness().iter().copied())
            .filter(|&joint| jumps(joint))
            .map(|joint| (joint, Scale::Sharpness));
        let bends = velocities.chain(sharpness).map(|(joint, scale)| Bend {
            joint,
            scale,
            start: model.shape(joint).get(scale).ln(),
        });
        Self {
            bends: bends.collect(),
            presliding: PreslidingLevel::all(model, &free, theta),
            known: theta.to_vec(),
            free,
            offsets,
            effects: Vec::new(),
        }
    }

    /// Returns the same unknowns with columns for effects. The columns of the delays to be estimated come first.
    pub(super) fn with_effects(self, effects: Vec<Effect>) -> Self {
        Self { effects, ..self }
    }

    /// Returns the effects that have columns.
    pub(super) fn effects(&self) -> impl Iterator<Item = &Effect> {
        self.effects.iter()
    }

    /// Returns the number of unknowns with values.
    pub(super) fn values(&self) -> usize {
        self.first_bend() + self.bends.len()
    }

    fn first_bend(&self) -> usize {
        self.free.len() + self.offsets.len()
    }

    /// Returns whether the delay of all torques has a column.
    pub(super) fn has_torques_delay(&self) -> bool {
        self.effects.iter().any(Effect::is_of_torques)
    }

    /// Returns the number of columns.
    pub(super) fn columns(&self) -> usize {
        self.values() + self.effects.len()
    }

    /// Returns the values of the unknowns for a parameter vector, with zero offsets and the scales of
    /// the start.
    pub(super) fn point(&self, theta: &[f64]) -> Vec<f64> {
        let free = self.free.iter().map(|&i| theta[i]);
        free.chain(self.offsets.iter().map(|_| 0.0))
            .chain(self.bends.iter().map(|bend| bend.start))
            .collect()
    }

    /// Returns the same unknowns with other prior levels of presliding friction.
    pub(super) fn with_presliding_levels(mut self, levels: Vec<PreslidingLevel>) -> Self {
        self.presliding = levels;
        self
    }

    /// Returns the same unknowns with some of the scales alone.
    pub(super) fn with_bends_of(mut self, kept: &[ScaleOfJoint]) -> Self {
        self.bends.retain(|bend| {
            kept.iter()
                .any(|of| (of.joint, of.scale) == (bend.joint, bend.scale))
        });
        self
    }

    /// Returns the priors of presliding friction, offsets and scales of friction laws.
    pub(super) fn priors(&self) -> impl Iterator<Item = Prior> {
        let offsets = (self.offsets.iter()).map(|offset| (0.0, offset.deviation));
        let bends = (self.bends.iter()).map(|bend| (bend.start, bend.deviation()));
        let presliding = self.presliding.iter().flat_map(|level| {
            level.places.iter().map(|&at| Prior {
                at,
                mean: 0.0,
                deviation: level.level,
            })
        });
        presliding.chain(
            (offsets.chain(bends).enumerate()).map(|(i, (mean, deviation))| Prior {
                at: self.free.len() + i,
                mean,
                deviation,
            }),
        )
    }

    /// Returns the scales of friction laws that are estimated.
    pub(super) fn scales(&self, z: &[f64]) -> impl Iterator<Item = ScaleOfJoint> {
        (self.bends.iter().zip(&z[self.first_bend()..])).map(|(bend, log)| ScaleOfJoint {
            joint: bend.joint,
            scale: bend.scale,
            value: log.exp(),
        })
    }

    /// Returns whether the scales of friction laws are near their start.
    pub(super) fn has_near_scales(&self, z: &[f64]) -> bool {
        (self.bends.iter().zip(&z[self.first_bend()..]))
            .all(|(bend, log)| (log - bend.start).abs() <= 2.0 * bend.deviation())
    }

    /// Returns the place of each scale of friction laws, after `before` other columns.
    pub(super) fn scale_places(&self, before: usize) -> Vec<ScalePlace> {
        (self.bends.iter().enumerate())
            .map(|(i, bend)| ScalePlace {
                joint: bend.joint,
                scale: bend.scale,
                place: before + self.first_bend() + i,
            })
            .collect()
    }

    /// Returns the parameter vector, \[p\].
    pub(super) fn theta(&self, z: &[f64]) -> Theta {
        let mut theta = self.known.clone();
        for (&index, value) in self.free.iter().zip(z) {
            theta[index] = *value;
        }
        theta
    }

    /// Returns the column of each parameter of theta, after `before` other columns.
    pub(super) fn places(&self, before: usize) -> Vec<Option<usize>> {
        let mut places = vec![None; self.known.len()];
        for (place, &index) in self.free.iter().enumerate() {
            places[index] = Some(before + place);
        }
        places
    }

    /// Returns the value of a parameter by its index in theta.
    fn value(&self, z: &[f64], index: usize) -> f64 {
        let place = self.free.iter().position(|free| *free == index);
        place.map_or(self.known[index], |place| z[place])
    }

    /// Returns the expectation of a measurement at a state minus `H x`, rad (m): the offset of the
    /// sensor, and for a torque sensor the rest of the spring's torque.
    ///
    /// - `x`: state; `rows`: number of coordinates.
    pub(super) fn beyond_observation(
        &self,
        z: &[f64],
        (sensor, measurement): (&Sensor, &Measurement),
        (x, rows): (&[f64], usize),
    ) -> f64 {
        let spring = sensor.spring.as_ref().map_or(0.0, |spring| {
            spring.beyond(&measurement.at(x, rows), |index| self.value(z, index))
        });
        self.offset(z, measurement.sensor) + spring
    }

    /// Adds the derivatives of a torque sensor's innovation by the parameters, and returns further
    /// entries of the derivative of its expectation by the state; `None` for a position.
    pub(super) fn spring_innovation(
        &self,
        gradient: &mut [f64],
        z: &[f64],
        (sensor, measurement): (&Sensor, &Measurement),
        (x, rows): (&[f64], usize),
    ) -> Option<[(usize, f64); 4]> {
        let spring = sensor.spring.as_ref()?;
        let value = |index| self.value(z, index);
        Some(
            spring.slopes(&measurement.at(x, rows), value, |index, slope| {
                if let Some(place) = self.free.iter().position(|free| *free == index) {
                    gradient[place] -= slope;
                }
            }),
        )
    }

    /// Returns the offset of a sensor, rad (m).
    pub(super) fn offset(&self, z: &[f64], sensor: usize) -> f64 {
        let index = self.offsets.iter().position(|o| o.sensor == sensor);
        index.map_or(0.0, |i| z[self.free.len() + i])
    }

    /// Corrects a start state by the offsets of its sensors.
    pub(super) fn shift_start(&self, z: &[f64], x: &mut [f64]) {
        for (offset, value) in self.offsets.iter().zip(&z[self.free.len()..]) {
            x[offset.coordinate] -= value;
        }
    }

    /// Returns the derivatives of the start state, \[3 rows × columns\].
    pub(super) fn start(&self, rows: usize) -> Vec<f64> {
        let count = self.columns();
        let mut derivatives = vec![0.0; state_count(rows) * count];
        for (i, offset) in self.offsets.iter().enumerate() {
            derivatives[offset.coordinate * count + self.free.len() + i] = -1.0;
        }
        derivatives
    }

    /// Adds the derivatives of an innovation by the offset of its sensor and by the effects.
    ///
    /// - `coordinates`: coordinates that the sensor measures; `x`: positions and velocities of all
    ///   rows.
    pub(super) fn innovation(
        &self,
        row: &mut [f64],
        sensor: usize,
        coordinates: &[(usize, f64)],
        x: &[f64],
    ) {
        if let Some(i) = self.offsets.iter().position(|o| o.sensor == sensor) {
            row[self.free.len() + i] -= 1.0;
        }
        for (i, effect) in self.effects.iter().enumerate() {
            row[self.values() + i] += effect.of_innovation(sensor, coordinates, x);
        }
    }

    /// Adds the derivatives of the torque on a row by the effects.
    ///
    /// - `x`: positions and velocities of all rows at the sample.
    pub(super) fn torque(
        &self,
        columns: &mut [f64],
        (segment, sample): (&Segment, usize),
        row: usize,
        x: &[f64],
    ) {
        for (i, effect) in self.effects.iter().enumerate() {
            columns[self.values() + i] += effect.of_torque((segment, sample), row, x);
        }
    }
}
