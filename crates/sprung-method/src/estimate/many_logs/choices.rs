//! Choices of an identification by the first log, valid for all logs of the robot.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::description::{Estimator, Experiment, Side};
use crate::estimate::errors::FactorsError;
use crate::estimate::result::{GENERATOR, RigidJoint};
use crate::estimate::springs::with_rigid_joints;
use crate::estimate::steps::Ready;
use crate::log::Channels;
use crate::model::Model;
use crate::prepare::PrepareError;
use crate::regression::{Packed, Reading, TransitionWeights, VelocityNoise};
use crate::sha256::sha256;
use crate::unknowns::{UnknownResult, with_added_laws};

/// Version of the stored choices and factors.
pub(super) const FORMAT: u64 = 1;

/// Choices from the beginning of the first log of a robot: laws, signs, gains, the cut-off of the
/// positions, delays, velocities of friction laws, stiffnesses that place links without encoder,
/// mountings of sensors on links and weights of samples.
///
/// All logs of the robot are reduced with the same choices. They are small, and `serde` stores them
/// without loss.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choices {
    format: u64,
    generator: String,
    robot: String,
    /// Hash of the parts of the experiment on which factors depend.
    experiment: String,
    /// Unknowns with laws that the model has.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    laws: Vec<UnknownResult>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    rigid_joints: Vec<RigidJoint>,
    sign: BTreeMap<String, f64>,
    gain: BTreeMap<String, f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    torque_constant_side: Option<Side>,
    position_cutoff_hz: f64,
    /// Delay of each column, in the order of the columns.
    delay_s: Vec<f64>,
    /// Of each joint.
    stribeck_velocity: Vec<f64>,
    /// Zero for a joint without this friction.
    presliding_width: Vec<f64>,
    /// Parameters about which the regression is linear in the stiffnesses without link encoder.
    springs: Option<Packed>,
    /// Mounting and bias of each sensor on a link.
    mountings: Vec<Packed>,
    weights: Option<StoredWeights>,
}

/// The numbers from which the weights of the samples are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct StoredWeights {
    link: Packed,
    motor: Packed,
    theta: Packed,
    slip: Packed,
}

impl Choices {
    /// Returns the choices of a preparation.
    ///
    /// - `experiment`: as the file gives it.
    pub(super) fn new(experiment: &Experiment, ready: &Ready) -> Self {
        let prepared = &ready.prepared;
        let reading = prepared.reading();
        let (model, factors) = (reading.model(), prepared.factors());
        let sensors = reading.channels().inertial.iter();
        let weights = reading.weights().map(TransitionWeights::made_of);
        let joints = 0..model.joint_count();
        Self {
            format: FORMAT,
            generator: GENERATOR.to_owned(),
            robot: experiment.robot.name.clone(),
            experiment: fingerprint(experiment),
            laws: (ready.unknowns.iter())
                .filter(|unknown| unknown.used_law().is_some())
                .cloned()
                .collect(),
            rigid_joints: ready.rigid.clone(),
            sign: (factors.signs.iter())
                .map(|sign| (sign.column.clone(), sign.value))
                .collect(),
            gain: (factors.gains.iter())
                .map(|gain| (gain.column.clone(), gain.value))
                .collect(),
            torque_constant_side: factors.side.as_ref().map(|found| found.side),
            position_cutoff_hz: reading.position_cutoff_hz(),
            delay_s: reading.delays().to_vec(),
            stribeck_velocity: (joints.clone())
                .map(|i| model.stribeck_velocity(i))
                .collect(),
            presliding_width: joints
                .map(|i| model.presliding_width(i).unwrap_or_default())
                .collect(),
            springs: model.springs().map(|theta| Packed(theta.to_vec())),
            mountings: (sensors.flat_map(|inertial| &inertial.all))
                .map(|sensor| Packed(sensor.found()))
                .collect(),
            weights: weights.map(|weights| StoredWeights {
                link: Packed(weights.noise.link.clone()),
                motor: Packed(weights.noise.motor.clone()),
                theta: Packed(weights.theta.clone()),
                slip: Packed(weights.slip.clone()),
            }),
        }
    }

    /// Returns the settings with which each log of the robot is read.
    ///
    /// # Errors
    ///
    /// [`FactorsError`] if the choices are those of another version or another experiment.
    pub(super) fn reading(&self, experiment: &Experiment) -> Result<Reading, FactorsError> {
        let what = || "the choices".to_owned();
        self.check(experiment, &what)?;
        let not_readable = |why: String| FactorsError::NotReadable {
            what: "the choices",
            why,
        };
        let mut described = with_rigid_joints(&for_factors(experiment), &self.rigid_joints);
        described = with_added_laws(&described, &self.laws);
        if let Some(side) = self.torque_constant_side {
            described.robot.settle_torque_side(side);
        }
        let log = described.log.as_mut();
        let log = log.ok_or_else(|| not_readable(PrepareError::NoLog.to_string()))?;
        log.settle(&self.sign, &self.gain);
        let channels = Channels::new(&described.robot, log)
            .map_err(|error| not_readable(error.to_string()))?;
        let model = Model::new(&described).map_err(|error| not_readable(error.to_string()))?;
        if !self.fits(&model, &channels) {
            return Err(not_readable(
                "they have another number of values".to_owned(),
            ));
        }
        let shapes = self.stribeck_velocity.iter().zip(&self.presliding_width);
        let model = (shapes.enumerate()).fold(model, |model, (joint, (stribeck, width))| {
            (model.with_stribeck(joint, *stribeck)).with_presliding_width(joint, *width)
        });
        let channels = self.mounted(channels);
        let mut reading = Reading::new(
            &model,
            &described.identify,
            &channels,
            self.position_cutoff_hz,
        )
        .with_delays(&self.delay_s);
        if let Some(springs) = &self.springs {
            reading = reading.with_springs(&springs.0);
        }
        if let Some(stored) = &self.weights {
            let noise = VelocityNoise {
                link: stored.link.0.clone(),
                motor: stored.motor.0.clone(),
            };
            let slip = stored.slip.0.clone();
            let weights = TransitionWeights::new(reading.model(), &noise, &stored.theta.0, slip);
            reading = reading.with_weights(weights);
        }
        Ok(reading)
    }

    /// Checks that the choices are those of this version and this experiment.
    ///
    /// - `what`: returns the name of the value for messages.
    pub(super) fn check(
        &self,
        experiment: &Experiment,
        what: &dyn Fn() -> String,
    ) -> Result<(), FactorsError> {
        if self.format != FORMAT || self.generator != GENERATOR {
            return Err(FactorsError::OtherVersion {
                what: what(),
                generator: self.generator.clone(),
                format: self.format,
                known: FORMAT,
            });
        }
        if self.robot != experiment.robot.name {
            return Err(FactorsError::OtherRobot {
                what: what(),
                found: self.robot.clone(),
                robot: experiment.robot.name.clone(),
            });
        }
        if self.experiment != fingerprint(experiment) {
            return Err(FactorsError::OtherExperiment { what: what() });
        }
        Ok(())
    }

    /// Checks that other choices are the same.
    ///
    /// - `what`: returns the name of the value with the other choices for messages.
    pub(super) fn check_same(
        &self,
        other: &Self,
        what: &dyn Fn() -> String,
    ) -> Result<(), FactorsError> {
        if other.format != self.format || other.generator != self.generator {
            return Err(FactorsError::OtherVersion {
                what: what(),
                generator: other.generator.clone(),
                format: other.format,
                known: self.format,
            });
        }
        if other.robot != self.robot {
            return Err(FactorsError::OtherRobot {
                what: what(),
                found: other.robot.clone(),
                robot: self.robot.clone(),
            });
        }
        if other.experiment != self.experiment {
            return Err(FactorsError::OtherExperiment { what: what() });
        }
        let differing = self.differing(other);
        if differing.is_empty() {
            return Ok(());
        }
        Err(FactorsError::OtherChoices {
            what: what(),
            differing,
        })
    }

    /// Returns the names of the choices that differ.
    fn differing(&self, other: &Self) -> Vec<&'static str> {
        let same = |values: &[f64], other: &[f64]| values == other;
        [
            ("the laws", self.laws == other.laws),
            ("rigid joints", self.rigid_joints == other.rigid_joints),
            ("signs", self.sign == other.sign),
            ("gains", self.gain == other.gain),
            (
                "the cut-off of the positions",
                same(&[self.position_cutoff_hz], &[other.position_cutoff_hz]),
            ),
            ("delays", same(&self.delay_s, &other.delay_s)),
            (
                "Stribeck velocities",
                same(&self.stribeck_velocity, &other.stribeck_velocity),
            ),
            (
                "widths of presliding friction",
                same(&self.presliding_width, &other.presliding_width),
            ),
            ("stiffnesses", self.springs == other.springs),
            (
                "mountings of sensors on links",
                self.mountings == other.mountings,
            ),
            ("weights of samples", self.weights == other.weights),
        ]
        .into_iter()
        .filter_map(|(name, same)| (!same).then_some(name))
        .collect()
    }

    /// Returns whether all lists have the lengths of a model and its columns.
    fn fits(&self, model: &Model, channels: &Channels) -> bool {
        let (n, p) = (model.joint_count(), model.parameters().len());
        let sensors = (channels.inertial.as_ref()).map_or(&[][..], |inertial| &inertial.all);
        self.delay_s.len() == channels.all.len()
            && self.stribeck_velocity.len() == n
            && self.presliding_width.len() == n
            && self
                .springs
                .as_ref()
                .is_none_or(|springs| springs.0.len() == p)
            && self.mountings.len() == sensors.len()
            && (self.mountings.iter().zip(sensors))
                .all(|(mounting, sensor)| mounting.0.len() == sensor.found().len())
            && self.weights.as_ref().is_none_or(|weights| {
                weights.link.0.len() == n
                    && weights.motor.0.len() == n
                    && weights.theta.0.len() == p
                    && weights.slip.0.len() == model.rows()
            })
    }

    /// Returns the channels with the mountings and biases of the sensors on links.
    fn mounted(&self, mut channels: Channels) -> Channels {
        let sensors = (channels.inertial.iter_mut()).flat_map(|inertial| &mut inertial.all);
        for (sensor, mounting) in sensors.zip(&self.mountings) {
            sensor.take_found(&mounting.0);
        }
        channels
    }
}

/// Returns the experiment with least squares as its only estimator.
pub(super) fn for_factors(experiment: &Experiment) -> Experiment {
    let mut experiment = experiment.clone();
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    experiment
}

/// Returns a hash of the parts of an experiment on which factors depend.
fn fingerprint(experiment: &Experiment) -> String {
    let experiment = for_factors(experiment);
    let log = experiment.log.map(|mut log| {
        log.file = None;
        log
    });
    sha256(format!("{:?}", (experiment.robot, log, experiment.identify)).as_bytes())
        .unwrap_or_default()
}
