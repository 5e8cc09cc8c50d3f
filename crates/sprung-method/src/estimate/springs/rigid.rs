//! Joints that a log shows as rigid, by blocked hold-out.
//!
//! Without torque sensor the rows of links have no right-hand side, and an undetermined spring shrinks the link
//! parameters. The alternative is the joint without spring: one equation, the sum of link and motor.

use std::cell::LazyCell;

use sprung_core::friction::Law;
use sprung_core::parameters::JointParameter;

use super::compliance::Compliance;
use crate::description::{Experiment, Instrument};
use crate::estimate::result::{RigidByHoldOut, RigidJoint};
use crate::estimate::statistics::HELD_OUT_PARTS;
use crate::fit::{ColumnFit, HoldOut, Missed, groups_for, is_clearly_below};
use crate::log::{Signal, Summary};
use crate::model::Model;
use crate::prepare::{PrepareError, Prepared, deviation};
use crate::progress::Listener;
use crate::regression::{Reading, Reduction, System};

/// Largest deflection of a rigid joint over its motion, root mean squares. A larger deflection is a fault of a
/// position, which the check reports.
const LARGEST_DEFLECTION: f64 = 0.01;

/// Joints that are rigid by a log, and the bounds of their springs.
pub(in crate::estimate) struct RigidByLog {
    pub(in crate::estimate) prepared: Prepared,
    pub(in crate::estimate) joints: Vec<RigidJoint>,
}

/// Least share of the torque's variance that is no noise. Below it, the spring is masked by noise of the torque, not by
/// its stiffness.
const LEAST_RELIABILITY: f64 = 0.5;

/// A joint that may be rigid.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    joint: usize,
    compliance: Compliance,
    /// Share of the squared torque that inertia and friction of the motor do not explain.
    unexplained_share: f64,
}

impl Candidate {
    /// Returns whether the joint keeps its spring: a spring that the log does not show needs a clear gain.
    fn keeps_spring(&self, compared: &RigidByHoldOut) -> bool {
        if self.reliability(compared) < LEAST_RELIABILITY {
            return true;
        }
        match (compared.flexible, compared.rigid) {
            (Some(flexible), Some(rigid)) => is_clearly_below(flexible, rigid),
            (flexible, rigid) => flexible.is_some() && rigid.is_none(),
        }
    }

    /// Returns the share of the variance of the torque that is no noise: the rigid joint explains all but the noise.
    fn reliability(&self, compared: &RigidByHoldOut) -> f64 {
        1.0 - compared.rigid.unwrap_or(0.0).powi(2) / self.unexplained_share
    }
}

/// Makes the joints rigid whose springs the beginning of the first log does not show, unless a spring predicts held-out
/// parts of it clearly better.
///
/// # Errors
///
/// The errors of a preparation, but for those of reading.
pub(in crate::estimate) fn with_joints_rigid_by_log(
    prepared: Prepared,
    progress: &mut dyn Listener,
) -> Result<RigidByLog, PrepareError> {
    let mut open = candidates(&prepared);
    // A joint whose spring predicts better stays flexible; this changes the fit of the others.
    while !open.is_empty() {
        let joints: Vec<usize> = open.iter().map(|candidate| candidate.joint).collect();
        let experiment = with_rigid(prepared.experiment(), &joints);
        let Ok(model) = Model::new(&experiment) else {
            break;
        };
        let rigid = prepared.again(&experiment, &model, progress)?;
        let (before, after) = (held_out(&prepared), held_out(&rigid));
        let compared = |joint: usize| RigidByHoldOut {
            flexible: share(prepared.reading().model(), before.as_ref(), joint),
            rigid: share(rigid.reading().model(), after.as_ref(), joint),
        };
        let count = open.len();
        open.retain(|candidate| !candidate.keeps_spring(&compared(candidate.joint)));
        if open.len() == count {
            let names = prepared.reading().model().joints().to_vec();
            let described = |candidate: &Candidate| {
                let compared = compared(candidate.joint);
                (candidate
                    .compliance
                    .by_noisy_torque(candidate.reliability(&compared)))
                .described(&names[candidate.joint], Some(compared))
            };
            return Ok(RigidByLog {
                joints: open.iter().map(described).collect(),
                prepared: rigid,
            });
        }
    }
    Ok(RigidByLog {
        prepared,
        joints: Vec::new(),
    })
}

/// Returns an experiment whose joints are rigid according to a log.
#[must_use]
pub fn with_rigid_joints(experiment: &Experiment, found: &[RigidJoint]) -> Experiment {
    let joints = experiment.robot.joint.iter().enumerate();
    let is_rigid =
        |name: &str| (found.iter()).any(|joint| joint.joint == name && joint.hold_out.is_some());
    let rigid = joints.filter(|(_, joint)| joint.is_flexible() && is_rigid(&joint.name));
    let rigid: Vec<usize> = rigid.map(|(joint, _)| joint).collect();
    with_rigid(experiment, &rigid)
}

fn with_rigid(experiment: &Experiment, joints: &[usize]) -> Experiment {
    let mut rigid = experiment.clone();
    for &joint in joints {
        rigid.robot.joint[joint] = rigid.robot.joint[joint].made_rigid();
    }
    rigid
}

/// Returns the joints without torque sensor whose springs the log leaves open.
fn candidates(prepared: &Prepared) -> Vec<Candidate> {
    let reading = prepared.reading().without_weights();
    let (model, channels) = (reading.model(), reading.channels());
    // Coupled joints would have to be rigid together.
    if prepared.experiment().robot.transmission_matrix.is_some() {
        return Vec::new();
    }
    let is_free = |joint: usize| {
        (model.index(JointParameter::Stiffness, joint))
            .is_some_and(|index| model.parameters()[index].fixed.is_none())
    };
    let summary = LazyCell::new(|| {
        let mut summary = Summary::new(channels);
        prepared
            .excerpt()
            .blocks()
            .iter()
            .for_each(|block| summary.take(block));
        summary
    });
    let joints: Vec<usize> = (0..model.joint_count())
        .filter(|&joint| {
            matches!(
                channels.instruments.at(joint),
                Instrument::Link | Instrument::Deflection
            )
        })
        .filter(|&joint| is_free(joint) && is_small(prepared, joint))
        // A position that jumps hides its spring.
        .filter(|&joint| !summary.loses_counts(joint))
        .collect();
    let rows: Vec<usize> = joints
        .iter()
        .map(|&joint| model.torque_row(joint))
        .collect();
    let reduced = (!rows.is_empty())
        .then(|| prepared.excerpt().smoothed(&reading))
        .flatten()
        .and_then(|signals| {
            let empty = Reduction::of_rows(model, &rows).without_samples();
            signals.thinned(&reading).reduce_by(empty, &reading)
        });
    let Some(system) = reduced else {
        return Vec::new();
    };
    let found = joints.iter().enumerate().filter_map(|(at, &joint)| {
        let fit = by_motor_row(&reading, &system, at, joint)?;
        let compliance = Compliance::from(fit);
        let candidate = Candidate {
            joint,
            compliance,
            unexplained_share: fit.unexplained_share,
        };
        compliance.is_open().then_some(candidate)
    });
    found.collect()
}

/// Returns the compliance of a joint by its motor row: deflection by motor torque minus inertia and friction of the
/// motor.
///
/// - `at`: index of the row in the system.
fn by_motor_row(reading: &Reading, system: &System, at: usize, joint: usize) -> Option<ColumnFit> {
    let model = reading.model();
    let columns = model.row_columns(model.torque_row(joint));
    let kind = |column: usize| model.parameters()[column].joint.map(|(kind, _)| kind);
    let of = columns
        .iter()
        .position(|&column| kind(column) == Some(JointParameter::Stiffness))?;
    let is_of_deflection = |column: usize| match kind(column) {
        Some(JointParameter::Preload) | None => false,
        Some(JointParameter::Friction(_, law)) => law == Law::Load,
        Some(kind) => kind.is_of_spring(),
    };
    let others = (0..columns.len()).filter(|&at| !is_of_deflection(columns[at]));
    let others: Vec<usize> = others.collect();
    let torque = std::iter::once(columns.len());
    let by: Vec<usize> = torque.chain(others.iter().copied()).collect();
    let groups = groups_for(system, reading.memory());
    let segments: Vec<_> = groups.iter().filter_map(|group| group.get(at)).collect();
    let rows = (&segments[..], reading.memory() / system.duration());
    ColumnFit::new(rows, of, &by)
}

/// Returns whether the deflection of a joint is small beside its motion.
fn is_small(prepared: &Prepared, joint: usize) -> bool {
    let (channels, excerpt) = (prepared.reading().channels(), prepared.excerpt());
    let values = |signal| {
        let channel = channels.telling(signal, joint)?;
        Some(excerpt.channel(channel))
    };
    let (Some(link), Some(motor)) = (values(Signal::Link), values(Signal::Motor)) else {
        return false;
    };
    let motion = values(Signal::Motor).map_or(0.0, deviation);
    let deflection = match channels.instruments.at(joint) {
        Instrument::Deflection => deviation(link),
        _ => deviation(link.zip(motor).map(|(link, motor)| link - motor)),
    };
    deflection < LARGEST_DEFLECTION * motion
}

/// Returns the residuals of parts of the beginning of the log with fits of the other parts; `None` if a fit has no
/// solution.
fn held_out(prepared: &Prepared) -> Option<Missed> {
    let reading = prepared.reading().without_weights();
    let system = prepared.excerpt().reduce_thinned(&reading)?;
    HoldOut::new(reading.model(), &system, HELD_OUT_PARTS).missed_by_fits()
}

/// Returns the residual of a joint's torque relative to the torque.
fn share(model: &Model, missed: Option<&Missed>, joint: usize) -> Option<f64> {
    let (missed, row) = (missed?, model.torque_row(joint));
    let share = (missed.residual[row] / missed.torque[row]).sqrt();
    Some(share).filter(|share| share.is_finite())
}
