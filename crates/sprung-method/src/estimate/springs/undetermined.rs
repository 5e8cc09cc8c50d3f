//! Springs of joints with torque sensor that the logs do not determine.
//!
//! The measured torque is on the right-hand side of the rows of link and motor, so these rows do not need the spring.
//! Only the deflection shows it, and noise of the deflection biases a stiffness but no compliance.

use sprung_core::parameters::JointParameter;

use super::compliance::Compliance;
use crate::description::{Estimator, Instrument, Row};
use crate::estimate::estimators::Found;
use crate::estimate::result::{EstimateResult, RigidJoint};
use crate::fit::{ColumnFit, fit, groups_for};
use crate::model::Model;
use crate::regression::{Reading, System};

/// Stiffness by least squares over that by the compliance, which is the squared correlation of deflection and torque.
/// Below it noise of the deflection biases the stiffness.
const LEAST_CORRELATION: f64 = 0.98;

/// A joint whose spring follows from its compliance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spring {
    pub(super) joint: usize,
    pub(super) compliance: Compliance,
    /// Stiffness about which the equations of the links are linear; `None` if they do not contain it.
    about: Option<f64>,
}

/// Springs of joints with torque sensor whose stiffness least squares do not give.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::estimate) struct Undetermined {
    /// Springs that the logs leave open.
    open: Vec<Spring>,
    /// Springs whose deflection is noisy, so that the compliance determines them.
    noisy: Vec<Spring>,
}

impl Undetermined {
    /// Returns the springs that the equations of all logs leave undetermined or noisy.
    ///
    /// A refinement knows the noise of the deflection, and it determines springs without link encoder better. So it
    /// models noisy springs, and [`Undetermined::with_refined`] uses it for joints without link encoder.
    pub(in crate::estimate) fn new(reading: &Reading, system: &System) -> Self {
        let (model, memory) = (reading.model(), reading.memory());
        let is_refined = reading.is_refined();
        let (open, mut noisy): (Vec<_>, Vec<_>) = (joints(reading, Instrument::TorqueAndLink))
            .filter_map(|joint| by_deflection(model, system, memory, joint))
            .partition(|(spring, _)| spring.compliance.is_open());
        noisy.retain(|(spring, correlation)| {
            let is_linear = model
                .index(JointParameter::CubicStiffness, spring.joint)
                .is_none();
            spring.compliance.value > 0.0
                && *correlation < LEAST_CORRELATION
                && is_linear
                && !is_refined
        });
        let mut all = Self {
            open: open.into_iter().map(|(spring, _)| spring).collect(),
            noisy: noisy.into_iter().map(|(spring, _)| spring).collect(),
        };
        if !is_refined && joints(reading, Instrument::Torque).next().is_some() {
            all.open.extend(without_link(reading, system));
        }
        all
    }

    /// Adds the springs of joints without link encoder that a refinement leaves open.
    pub(in crate::estimate) fn with_refined(
        &self,
        reading: &Reading,
        estimates: &[(Estimator, Found)],
    ) -> Self {
        let mut both = self.clone();
        let refined = (estimates.iter())
            .map(|(_, found)| &found.numbers)
            .find(|numbers| {
                (numbers.criterion.refinement()).is_some_and(|refinement| refinement.used)
            });
        let Some(numbers) = refined else {
            return both;
        };
        let found = joints(reading, Instrument::Torque).filter_map(|joint| {
            let index = free_stiffness(reading.model(), joint)?;
            let known = numbers.identifiable[index];
            let stiffness = known.then_some((numbers.theta[index], numbers.errors[index]))?;
            Some(Spring {
                joint,
                compliance: Compliance::of_stiffness(stiffness)?,
                about: None,
            })
        });
        (both.open).extend(found.filter(|spring| spring.compliance.is_open()));
        both
    }

    /// Returns the model in which noisy springs have the stiffness by their compliance, and open ones the least stiffness
    /// that the logs allow; `None` if there are no such springs.
    pub(in crate::estimate) fn settled(&self, model: &Model) -> Option<Model> {
        let open = self.open.iter().flat_map(|spring| {
            let stiffness = spring.about.unwrap_or(spring.compliance.stiffness_above());
            [
                (spring.joint, JointParameter::Stiffness, stiffness),
                (spring.joint, JointParameter::CubicStiffness, 0.0),
                (spring.joint, JointParameter::Damping, 0.0),
            ]
        });
        let noisy = (self.noisy.iter()).map(|spring| {
            (
                spring.joint,
                JointParameter::Stiffness,
                spring.compliance.stiffness().0,
            )
        });
        let values: Vec<(usize, f64)> = (open.chain(noisy))
            .filter_map(|(joint, kind, value)| Some((model.index(kind, joint)?, value)))
            .collect();
        (!values.is_empty()).then(|| model.with_fixed(&values))
    }

    /// Returns the joints for the results.
    pub(in crate::estimate) fn described(&self, model: &Model) -> Vec<RigidJoint> {
        (self.open.iter())
            .map(|spring| {
                spring
                    .compliance
                    .described(&model.joints()[spring.joint], None)
            })
            .collect()
    }

    /// Writes the standard errors of noisy springs into a result, before the judgement.
    pub(in crate::estimate) fn complete(&self, model: &Model, result: &mut EstimateResult) {
        for spring in &self.noisy {
            let Some(index) = model.index(JointParameter::Stiffness, spring.joint) else {
                continue;
            };
            let (_, error) = spring.compliance.stiffness();
            let parameter = &mut result.parameters[index];
            parameter.fixed = false;
            parameter.error_parts = None;
            parameter.standard_error = Some(error);
            parameter.ci95 = Some(spring.compliance.interval());
        }
    }

    /// Removes the values of open springs from a result, after the judgement.
    pub(in crate::estimate) fn hide(&self, model: &Model, result: &mut EstimateResult) {
        let kinds = [
            JointParameter::Stiffness,
            JointParameter::CubicStiffness,
            JointParameter::Damping,
        ];
        for spring in &self.open {
            for index in kinds
                .iter()
                .filter_map(|kind| model.index(*kind, spring.joint))
            {
                result.parameters[index].forget();
                let name = &model.parameters()[index].name;
                for route in &mut result.cross_checks {
                    let kept = (route.values.iter()).filter(|(other, _)| other != name);
                    route.values = kept
                        .map(|(parameter, value)| (parameter.to_owned(), value))
                        .collect();
                }
            }
        }
    }
}

/// Returns the joints with an instrument.
fn joints(reading: &Reading, wanted: Instrument) -> impl Iterator<Item = usize> {
    let instruments = &reading.channels().instruments;
    (0..instruments.joint_count()).filter(move |&joint| instruments.at(joint) == wanted)
}

/// Returns the springs of all joints by deflections and measured torques, each with the squared correlation of both.
pub(super) fn by_deflections(reading: &Reading, system: &System) -> Vec<(Spring, f64)> {
    let (model, memory) = (reading.model(), reading.memory());
    joints(reading, Instrument::TorqueAndLink)
        .filter_map(|joint| by_deflection(model, system, memory, joint))
        .collect()
}

/// Returns the open springs of joints without link encoder, by the rows of the links.
fn without_link(reading: &Reading, system: &System) -> Vec<Spring> {
    let model = reading.model();
    let Some(fitted) = fit(model, system, reading.memory()) else {
        return Vec::new();
    };
    let found = joints(reading, Instrument::Torque).filter_map(|joint| {
        let (about, index) = (model.known_stiffness(joint)?, free_stiffness(model, joint)?);
        let stiffness = (fitted.theta[index], fitted.standard_error[index]);
        Some(Spring {
            joint,
            compliance: Compliance::linearised(about, stiffness)?,
            about: Some(about),
        })
    });
    found.filter(|spring| spring.compliance.is_open()).collect()
}

/// Returns the index of a stiffness that the description does not give.
fn free_stiffness(model: &Model, joint: usize) -> Option<usize> {
    let index = model.index(JointParameter::Stiffness, joint)?;
    (model.parameters()[index].fixed.is_none()).then_some(index)
}

/// Returns the compliance of a joint with link position by its spring row, deflection by measured torque, and the squared
/// correlation of both.
fn by_deflection(
    model: &Model,
    system: &System,
    memory: f64,
    joint: usize,
) -> Option<(Spring, f64)> {
    let stiffness = free_stiffness(model, joint)?;
    let row = (0..model.rows())
        .find(|&row| model.joint_of(row) == joint && model.row_of_joint(row) == Row::Spring)?;
    let columns = model.row_columns(row);
    let of = columns.iter().position(|&column| column == stiffness)?;
    let is_constant = |column: usize| {
        let kind = model.parameters()[column].joint.map(|(kind, _)| kind);
        matches!(
            kind,
            Some(JointParameter::Preload | JointParameter::TorqueOffset)
        )
    };
    let constants = (0..columns.len()).filter(|&at| is_constant(columns[at]));
    let constants: Vec<usize> = constants.collect();
    let by = |first: usize| -> Vec<usize> {
        std::iter::once(first)
            .chain(constants.iter().copied())
            .collect()
    };
    let groups = groups_for(system, memory);
    let segments: Vec<_> = groups.iter().filter_map(|group| group.get(row)).collect();
    let torque = columns.len();
    let rows = (&segments[..], memory / system.duration());
    let compliance = ColumnFit::new(rows, of, &by(torque))?;
    let stiffness = ColumnFit::new(rows, torque, &by(of))?;
    let spring = Spring {
        joint,
        compliance: compliance.into(),
        about: None,
    };
    Some((spring, compliance.value * stiffness.value))
}
