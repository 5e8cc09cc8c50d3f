//! Code of an identified robot, in C99 and in Rust, from the kernels of the model themselves.
//!
//! The kernels run once with symbols in place of numbers ([`graph`]) and leave the operations of each
//! function ([`trace`]). The writers print these operations.

mod c;
mod control;
mod emit;
mod feedforward;
mod graph;
mod memory;
mod observer;
mod proof;
mod rust;
mod trace;

use std::collections::BTreeMap;

use self::c::Program;
use self::control::Control;
use self::memory::Memory;
use self::observer::Observed;
use self::trace::{Source, Traced};
use super::controller::{ControlCode, ObserverCode};
use super::error::ExportError;
use super::exactness::{How, Said, row};
use super::format::Format;
use super::provenance::sealed;
use super::reload::Proof;
use super::standard::Extra;
use crate::description::ControllerKind;
use crate::model::{Model, ModelError, Theta};
use sprung_core::friction::Scale;
use sprung_core::links::LengthError;
use sprung_core::parameters::JointParameter;

/// Largest number of joints.
const JOINTS: usize = 32;

/// Largest number of operations.
const OPERATIONS: usize = 200_000;

/// Largest relative differences of torques and of accelerations from the identified model.
const TORQUE_TOLERANCE: f64 = 1e-12;
const ACCELERATION_TOLERANCE: f64 = 1e-9;

/// Returns the files of a robot in the order of [`Format::files`], and the comparison with the
/// identified model.
///
/// - `origin`: lines about the origin, of which one holds the place of the hash.
///
/// # Errors
///
/// [`ExportError::TooLarge`], [`ExportError::Controller`] if the controller does not fit the robot, and
/// [`ExportError::Differs`] if the code is not the identified model.
pub(super) fn write(
    format: Format,
    name: &str,
    model: &Model,
    values: &BTreeMap<String, f64>,
    origin: &[String],
    (control, observer): (Option<&ControlCode>, Option<&ObserverCode>),
) -> Result<(Vec<String>, Proof), ExportError> {
    let differs = |what: String| ExportError::Differs {
        format: format.name(),
        what,
    };
    let n = model.joint_count();
    if n > JOINTS {
        return Err(ExportError::TooLarge {
            format: format.name(),
            what: format!("{n} joints, and code has at most {JOINTS}"),
        });
    }
    if let Some(control) = control {
        control.check(format, n)?;
    }
    let theta = theta(model, values)?;
    let bodies = model.bodies(&theta);
    let source = Source {
        model,
        robot: model.robot(),
        theta: &theta,
        bodies: &bodies,
    };
    let failed = |error: LengthError| differs(error.to_string());
    let mut traced = source.trace().map_err(failed)?;
    let mut of_feedforward = 0.0;
    let mut motions = Vec::new();
    if let Some(control) = control
        && control.controller.kind == ControllerKind::StateFeedback
    {
        model.check_stiffness(&theta)?;
        let speed = control.controller.friction_compensation_speed_rad_per_s;
        let feedforward = source.feedforward(speed).map_err(failed)?;
        (of_feedforward, motions) = source
            .prove_feedforward(speed, &feedforward)
            .map_err(failed)?;
        traced.push(feedforward);
    }
    let memory = Memory::new(&source).map_err(failed)?;
    let of_memory = match &memory {
        Some(_) => {
            traced.push(source.with_memory().map_err(failed)?);
            memory::prove(&source, &traced[traced.len() - 1]).map_err(failed)?
        }
        None => 0.0,
    };
    let mut of_observer = 0.0;
    if let Some(observer) = observer {
        if let Some(what) = observer::refused(&source, &observer.settings) {
            return Err(ExportError::Observer { what });
        }
        if let Some(observed) = source.beside_sensors().map_err(failed)? {
            of_observer = observer::prove(&source, &observed).map_err(failed)?;
            traced.push(observed);
        }
    }
    check_size(format, &traced)?;
    let (proof, vectors) = proof::prove(&source, &traced).map_err(failed)?;
    for (what, difference, limit) in [
        ("the feedforward", of_feedforward, TORQUE_TOLERANCE),
        ("the dynamics with memory", of_memory, TORQUE_TOLERANCE),
        ("the observer's dynamics", of_observer, TORQUE_TOLERANCE),
        ("inverse dynamics", proof.inverse_dynamics, TORQUE_TOLERANCE),
        ("the mass matrix", proof.mass_matrix, TORQUE_TOLERANCE),
        ("accelerations", proof.accelerations, ACCELERATION_TOLERANCE),
    ] {
        if difference.is_nan() || difference > limit {
            return Err(differs(format!("{what} by {difference:.1e}")));
        }
    }
    let control = control
        .map(|code| Control::new(&source, code, motions))
        .transpose()
        .map_err(|error| differs(error.to_string()))?;
    let observer = observer
        .map(|observer| Observed::new(&source, &observer.settings, &observer.header))
        .transpose()
        .map_err(|what| ExportError::Observer { what })?;
    let program = Program {
        name,
        origin,
        joints: model.joints(),
        parameters: model.parameters(),
        theta: &theta,
        rows: model.coordinates(),
        traced: &traced,
        inverse_rotors: &source.inverse_rotors(),
        vectors: &vectors,
        memory: memory.as_ref(),
        control: control.as_ref(),
        observer: observer.as_ref(),
    };
    let files = match format {
        Format::Rust => vec![rust::write(&program)],
        Format::Urdf | Format::Mjcf | Format::Sdf | Format::Json | Format::C => {
            c::write(&program).into()
        }
    };
    Ok((files.iter().map(|text| sealed(text)).collect(), proof))
}

/// Refuses functions with too many operations.
fn check_size(format: Format, traced: &[Traced]) -> Result<(), ExportError> {
    let operations: usize = (traced.iter())
        .map(|function| function.operations.len())
        .sum();
    if operations <= OPERATIONS {
        return Ok(());
    }
    Err(ExportError::TooLarge {
        format: format.name(),
        what: format!("{operations} operations, and code has at most {OPERATIONS}"),
    })
}

/// Returns the parameter vector; friction and springs without a value are zero.
fn theta(model: &Model, values: &BTreeMap<String, f64>) -> Result<Theta, ModelError> {
    let mut known = values.clone();
    for parameter in model.parameters() {
        let is_inertia = matches!(
            parameter.joint,
            None | Some((JointParameter::RotorInertia, _))
        );
        if !is_inertia && parameter.fixed.is_none() {
            known.entry(parameter.name.clone()).or_insert(0.0);
        }
    }
    model.theta(&known)
}

/// Returns the comment of the code about the robot.
pub(super) fn said(
    model: &Model,
    extras: &[Extra],
    (control, observer): (Option<&ControlCode>, Option<&ObserverCode>),
) -> Vec<Said> {
    let dynamics =
        "inverse and forward dynamics, mass matrix, Coriolis torques, gravity and regressor";
    let mut rows = vec![
        row("links", How::Exact, dynamics),
        row(
            "rotor inertias",
            How::Exact,
            "without gyroscopic coupling, as identified",
        ),
        row(
            "friction",
            How::Exact,
            "all identified laws, tanh(beta v) included",
        ),
    ];
    let has_memory = model.robot().coupling.is_none();
    let of_memory = |what: &str| {
        if has_memory {
            let note = "inverse_dynamics_with_memory has it exactly; the other functions have no memory, so their elements slide";
            row(what, How::Exact, note)
        } else {
            let note = "the code has no memory of the motion: its elements slide";
            row(what, How::Approximated, note)
        }
    };
    if (0..model.joint_count()).any(|joint| model.has_law(Scale::Presliding, joint)) {
        rows.push(of_memory("presliding friction"));
    }
    if model.has_springs() {
        let note = "stiffness, play, damping, cubic stiffness and preload, as identified";
        rows.push(row("springs", How::Exact, note));
    }
    if (0..model.joint_count()).any(|joint| model.hysteresis_width(joint).is_some()) {
        rows.push(of_memory("hysteresis"));
    }
    if let Some(control) = control {
        let controller = &control.controller;
        let law = match (
            controller.kind,
            controller.friction_compensation_speed_rad_per_s,
        ) {
            (ControllerKind::Pd, _) => "PD on the motors",
            (ControllerKind::StateFeedback, None) => "state feedback, feedforward without friction",
            (ControllerKind::StateFeedback, Some(_)) => {
                "state feedback, feedforward with friction at the desired velocities"
            }
        };
        let note = format!("{law}; for samples {:?} s apart", control.period_s);
        rows.push(row("controller", How::Exact, &note));
    }
    if let Some(observer) = observer {
        let note = format!(
            "torques from outside with their thresholds, presliding friction and hysteresis with their memory; for samples {:?} s \
             apart",
            observer.settings.period_s
        );
        rows.push(row("observer", How::Exact, &note));
    }
    let is_change = |extra: &&Extra| matches!(extra.kind, JointParameter::Change(..));
    let changes: Vec<&str> = (extras.iter().filter(is_change))
        .map(|extra| extra.name.as_str())
        .collect();
    if !changes.is_empty() {
        let names = changes.join(", ");
        let note =
            format!("{names}: the code has the friction at the references of the covariates");
        rows.push(row("friction with covariates", How::Dropped, note));
    }
    rows
}
