//! Chooses the writer and the reader of a format.

use std::collections::BTreeMap;

use super::controller::{ControlCode, ObserverCode};
use super::error::ExportError;
use super::evidence::JointEvidence;
use super::exactness::{How, Said, row, said};
use super::format::Format;
use super::mechanism::Mechanism;
use super::provenance::{Origin, sealed};
use super::reload::{Proof, Reference, STATES, STATES_OF_DRAW};
use super::robot::{Form, MOTOR, StandardRobot};
use super::standard::{Standard, standard};
use super::{code, json, mjcf, names, read_json, read_mjcf, read_sdf, read_urdf, sdf, urdf};
use crate::description::{Experiment, Urdf};
use crate::model::Model;

/// A robot to export.
pub struct Request<'a> {
    /// Format of the file.
    pub format: Format,
    /// Form of the robot.
    pub form: Form,
    /// Description of the robot.
    pub experiment: &'a Experiment,
    /// Equations of the robot.
    pub model: &'a Model,
    /// Values of standard parameters of links and of parameters of joints, by name.
    pub values: &'a BTreeMap<String, f64>,
    /// Name and text of the robot's URDF.
    pub urdf: Option<(&'a str, &'a str)>,
    /// Returns whether a file of a mesh exists, by its path in the URDF.
    pub is_there: &'a dyn Fn(&str) -> bool,
    /// Evidence about each joint, \[n\].
    pub evidence: &'a [JointEvidence],
    /// Provenance of the values.
    pub origin: Origin,
    /// Controller that code contains; other formats have none.
    pub control: Option<ControlCode>,
    /// Observer that code contains; other formats have none.
    pub observer: Option<ObserverCode>,
}

impl Request<'_> {
    /// Returns what code contains beside the robot.
    fn of_code(&self) -> (Option<&ControlCode>, Option<&ObserverCode>) {
        (self.control.as_ref(), self.observer.as_ref())
    }

    /// Returns the form of flexible joints. JSON and code always have springs; JSON has the attributes of
    /// rigid joints beside them.
    fn form(&self) -> Form {
        match self.format {
            Format::Json | Format::C | Format::Rust => Form::Flexible,
            Format::Urdf | Format::Mjcf | Format::Sdf => self.form,
        }
    }
}

/// An exported robot.
#[derive(Clone, Debug)]
pub struct Exported {
    /// Format.
    pub format: Format,
    /// Contents of the files, in the order of [`Format::files`].
    pub texts: Vec<String>,
    /// Exact, approximated and dropped properties of the file.
    pub said: Vec<Said>,
    /// The comparison with the identified model.
    pub proof: Proof,
}

/// Returns the half widths of the plays of springs in words; `None` without any.
fn plays(model: &Model) -> Option<String> {
    let of_joint = |(joint, name): (usize, &String)| {
        let [half_width, _] = model.play(joint)?;
        Some(format!("{name} ±{half_width:.3e} rad (m)"))
    };
    let all: Vec<String> = (model.joints().iter().enumerate())
        .filter_map(of_joint)
        .collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// Returns the file of a robot.
///
/// # Errors
///
/// [`ExportError`] if the values are not those of a possible robot, the format forbids a name, or the
/// file does not contain the identified robot.
pub fn export(request: &Request<'_>) -> Result<Exported, ExportError> {
    let (format, form) = (request.format, request.form());
    let mut identified = standard(request.experiment, request.model, request.values)?;
    if let Some((file, text)) = request.urdf {
        add_limits(&mut identified.robot, &Urdf::parse(file, text)?);
    }
    names::check(format, form, &identified.robot)?;
    let mut rows = if format.is_code() {
        code::said(request.model, &identified.extras, request.of_code())
    } else {
        said(format, form, &identified.robot, &identified.extras)
    };
    if !identified.unknown.is_empty() {
        let names = identified.unknown.join(", ");
        let note = format!("{names}: the parameters have no value for it, so the file has zero");
        rows.push(row("friction without a value", How::Dropped, note));
    }
    if let Some(plays) = plays(request.model).filter(|_| !format.is_code()) {
        let note = format!("{plays}: the format's springs have none");
        rows.push(row("play", How::Dropped, note));
    }
    let has_lengths = !matches!(format, Format::Json | Format::C | Format::Rust);
    if request.model.tree().is_none() && has_lengths {
        let note = "link1 is 1 m long: the log determines the dynamics and not the length";
        rows.push(row("kinematics", How::Approximated, note));
    }
    let text = match format {
        Format::Urdf => of_urdf(request, &identified, &mut rows)?,
        Format::Mjcf => {
            rows.extend(without_geometry(request));
            let comment = request.origin.comment(&identified.robot.name, &rows);
            mjcf::write(&identified.robot, form, &comment)
        }
        Format::Sdf => {
            rows.extend(without_geometry(request));
            let comment = request.origin.comment(&identified.robot.name, &rows);
            sdf::write(&identified.robot, form, &comment)
        }
        Format::Json => of_json(request, &identified, &rows)?,
        Format::C | Format::Rust => return of_code(request, &identified, rows),
    };
    let text = sealed(&text);
    let proof = prove(request, &identified, &text)?;
    Ok(Exported {
        format,
        texts: vec![text],
        said: rows,
        proof,
    })
}

fn of_code(
    request: &Request<'_>,
    identified: &Standard,
    rows: Vec<Said>,
) -> Result<Exported, ExportError> {
    let name = &identified.robot.name;
    let origin = request.origin.lines(name, &rows);
    let (texts, proof) = code::write(
        request.format,
        name,
        request.model,
        request.values,
        &origin,
        request.of_code(),
    )?;
    Ok(Exported {
        format: request.format,
        texts,
        said: rows,
        proof,
    })
}

/// Reads a file back and compares it with the identified model.
pub(super) fn prove(
    request: &Request<'_>,
    identified: &Standard,
    text: &str,
) -> Result<Proof, ExportError> {
    let mechanism = read(request, identified, text).map_err(|what| ExportError::Differs {
        format: request.format.name(),
        what,
    })?;
    Reference {
        model: request.model,
        theta: &identified.theta,
        robot: &identified.robot,
        format: request.format,
        form: request.form(),
        states: if request.origin.draw.is_some() {
            STATES_OF_DRAW
        } else {
            STATES
        },
    }
    .prove(&mechanism)
}

/// Takes the limits of joints from a URDF. Exporters write zero for an unknown effort or velocity.
fn add_limits(robot: &mut StandardRobot, urdf: &Urdf) {
    for joint in &mut robot.joints {
        let Some(movable) = (urdf.movable().iter()).find(|movable| movable.name == joint.name)
        else {
            continue;
        };
        let positive = |value: Option<f64>| value.filter(|value| *value > 0.0);
        joint.limits.lower = movable.lower;
        joint.limits.upper = movable.upper;
        joint.limits.effort = joint.limits.effort.or(positive(movable.effort));
        joint.limits.velocity = positive(movable.velocity);
    }
}

fn of_urdf(
    request: &Request<'_>,
    identified: &Standard,
    rows: &mut Vec<Said>,
) -> Result<String, ExportError> {
    let robot = &identified.robot;
    let small = urdf::minimal(robot);
    let (file, text) = request.urdf.unwrap_or(("the minimal URDF", &small));
    let changed = |comment: &str| urdf::write(file, text, robot, request.form(), comment);
    // The comment lists the reduced bodies, so the file is written twice.
    let first = changed("")?;
    for (link, factor) in first.reduced {
        let what = format!("fixed body {link}");
        let how = if factor > 0.0 {
            format!("its inertial is {factor} times that of the URDF")
        } else {
            "its inertial is removed".to_owned()
        };
        let note = format!("{how}, because the link that carries it is lighter than the URDF says");
        rows.push(row(&what, How::Approximated, note));
    }
    rows.extend(about_meshes(first.meshes, request.is_there));
    if request.urdf.is_none() {
        let note = "the robot has no URDF: this file has links and joints only";
        rows.push(row("geometry", How::Dropped, note));
    }
    Ok(changed(&request.origin.comment(&robot.name, rows))?.text)
}

/// Returns the treatment of the meshes of a URDF: they are kept unchanged.
fn about_meshes(mut meshes: Vec<String>, is_there: &dyn Fn(&str) -> bool) -> Vec<Said> {
    meshes.sort_unstable();
    meshes.dedup();
    let (of_packages, files): (Vec<String>, Vec<String>) =
        meshes.into_iter().partition(|mesh| mesh.contains("://"));
    let (found, missing): (Vec<String>, Vec<String>) =
        files.into_iter().partition(|mesh| is_there(mesh));
    let kinds = [
        (
            of_packages,
            "kept as written; files of packages are not checked",
        ),
        (
            found,
            "kept as written, relative to the folder of the given URDF",
        ),
        (
            missing,
            "kept as written; there is no such file beside the given URDF",
        ),
    ];
    (kinds.into_iter())
        .filter(|(files, _)| !files.is_empty())
        .map(|(files, note)| {
            let what = match files.len() {
                1 => format!("mesh {}", files[0]),
                count => format!("{count} meshes, as {}", files[0]),
            };
            row(&what, How::Exact, note)
        })
        .collect()
}

fn of_json(
    request: &Request<'_>,
    identified: &Standard,
    rows: &[Said],
) -> Result<String, ExportError> {
    let joints = 0..request.model.joint_count();
    let sharpness: Vec<f64> = joints.map(|joint| request.model.sharpness(joint)).collect();
    let contents = json::Contents {
        extras: &identified.extras,
        evidence: request.evidence,
        sharpness: &sharpness,
        origin: &request.origin,
        said: rows,
    };
    json::write(&identified.robot, &contents).map_err(|error| ExportError::Differs {
        format: request.format.name(),
        what: error.to_string(),
    })
}

/// Returns the treatment of the geometry and of other joints of a URDF in another format.
fn without_geometry(request: &Request<'_>) -> Vec<Said> {
    let (_, text) = request.urdf.unwrap_or_default();
    let mut rows = Vec::new();
    if text.contains("<geometry") {
        let note = "visuals, collisions and meshes of the URDF are kept by --format urdf only";
        rows.push(row("geometry", How::Dropped, note));
    }
    let joints = request.model.joint_count();
    let movable = (request.urdf)
        .and_then(|(file, text)| Urdf::parse(file, text).ok())
        .map_or(joints, |urdf| urdf.movable().len());
    if movable > joints {
        let note = "joints that the experiment does not list are fixed at zero, with their bodies";
        rows.push(row("other joints", How::Approximated, note));
    }
    rows
}

/// Reads an exported file back.
fn read(request: &Request<'_>, identified: &Standard, text: &str) -> Result<Mechanism, String> {
    let robot = &identified.robot;
    match request.format {
        Format::Urdf => {
            let links = robot.joints.iter().map(|joint| joint.name.clone());
            let with_motor = robot
                .joints
                .iter()
                .filter(|joint| joint.has_spring(request.form()));
            let motors = with_motor.map(|joint| format!("{}{MOTOR}", joint.name));
            read_urdf::read(text, &links.chain(motors).collect::<Vec<_>>())
        }
        Format::Mjcf => read_mjcf::read(text),
        Format::Sdf => read_sdf::read(text),
        Format::Json => read_json::read(text),
        Format::C | Format::Rust => Err("code is not read back".to_owned()),
    }
}
