//! From the text of `experiment.toml` to a checked [`Experiment`].

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::check::kinematics;
use super::check::{Fault, check, check_format, check_log_over};
use super::control::Control;
use super::defaults::spread;
use super::excite::Excite;
use super::identify::Identify;
use super::keys::{self, Misfit};
use super::log::Log;
use super::named_files::NamedFiles;
use super::quantities::{Key, Quantity, Signal};
use super::robot::{Joint, Robot, Seen};
use super::run::{Controller, Simulate, Validate};
use super::tree::{TreeError, tree};
use super::types::ExperimentFile;
use super::unfilled;
use crate::input_limits::{EXPERIMENT_BYTES, size};

/// An experiment: the robot, the log, and the settings of identification and validation.
///
/// Its lengths and signs are checked: lists have one entry per joint; names of joints exist and
/// are unique.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The robot.
    pub robot: Robot,
    /// The log to identify from, if any.
    pub log: Option<Log>,
    /// Settings of the identification.
    pub identify: Identify,
    /// The controller that ran during the log, if known.
    pub controller: Option<Controller>,
    /// Experiments to validate on.
    pub validate: Vec<Validate>,
    /// The digital twin, if any.
    pub simulate: Option<Simulate>,
    /// The experiment that is to be designed.
    pub excite: Excite,
    /// The controller that is to be designed.
    pub control: Control,
}

impl Experiment {
    /// Returns the experiment with columns of another log in place of its own, for its validation
    /// runs as well.
    ///
    /// - `name`: name of the experiment for messages.
    ///
    /// # Errors
    ///
    /// [`DescriptionError::File`] if the columns do not fit the robot or the rest of `[log]`.
    pub fn with_log(&self, name: &str, over: &Log) -> Result<Self, DescriptionError> {
        let log = check_log_over(self.log.as_ref(), over, &self.robot, &self.identify);
        let log = log.map_err(|fault| DescriptionError::File {
            file: name.to_owned(),
            message: fault.message,
            code: fault.code,
        })?;
        let mut experiment = Self {
            log: Some(log),
            ..self.clone()
        };
        for run in &mut experiment.validate {
            run.log = None;
        }
        Ok(experiment.settled())
    }

    /// Returns whether the log has the torques of the springs and not those of the motors.
    #[must_use]
    pub fn is_on_link_side(&self) -> bool {
        self.robot.joint.iter().any(Joint::is_on_link_side)
    }

    /// Returns the experiment with springs, for a log on the links alone. The torques of the springs stand in for those of
    /// the motors, so the equations of the motors mean nothing.
    #[must_use]
    pub fn with_motors(&self) -> Self {
        let mut with = self.clone();
        for joint in &mut with.robot.joint {
            joint.seen = Seen::AsDescribed;
        }
        if let Some(log) = &mut with.log {
            log.motor_torque_nm.clone_from(&log.joint_torque_nm);
            log.motor_force_n.clone_from(&log.joint_force_n);
            log.motor_torque.clone_from(&log.joint_torque);
        }
        with
    }

    /// Returns the experiment with the joints of which the log shows the link alone.
    fn settled(mut self) -> Self {
        let Some(log) = &self.log else {
            return self;
        };
        let gives = |signal, joint| Key::gives(signal, joint, log, &self.robot);
        let has_motor = Key::of(Signal::Torque).any(|key| key.is_given(log));
        let has_positions = (log.given()).any(|(key, _)| key.quantity == Quantity::LinkPosition);
        let shows_link = |joint: usize| gives(Signal::Spring, joint) && gives(Signal::Link, joint);
        let mut all = 0..self.robot.joint.len();
        if !has_motor && has_positions && all.all(shows_link) {
            for joint in &mut self.robot.joint {
                *joint = joint.made_of_link();
            }
        }
        self
    }
}

impl DescriptionError {
    /// Returns the code of a combination that does not work; `None` for other errors.
    #[must_use]
    pub fn code(&self) -> Option<&'static str> {
        match self {
            Self::Line { code, .. } | Self::File { code, .. } | Self::Override { code, .. } => {
                *code
            }
            Self::Unreadable { .. } | Self::Urdf { .. } => None,
        }
    }
}

/// Error of an experiment file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// An error in a line of the file.
    #[error("line {line} of {file}: {message}")]
    Line {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// The fault and the remedy.
        message: String,
        /// Code of a combination that does not work.
        code: Option<&'static str>,
    },
    /// An error of the file without a line.
    #[error("{file}: {message}")]
    File {
        /// Name of the file.
        file: String,
        /// The fault and the remedy.
        message: String,
        /// Code of a combination that does not work.
        code: Option<&'static str>,
    },
    /// A file that the experiment names cannot be read.
    #[error("{message}")]
    Unreadable {
        /// The file and the error of the operating system.
        message: String,
    },
    /// An error in the robot's URDF file.
    #[error("{message}")]
    Urdf {
        /// The line, the fault and the remedy.
        message: String,
    },
    /// An error in an override of the command line.
    #[error("--set {assignment}: {message}")]
    Override {
        /// The override, unchanged.
        assignment: String,
        /// The fault and the remedy.
        message: String,
        /// Code of a combination that does not work.
        code: Option<&'static str>,
    },
}

/// Reads an experiment file.
///
/// - `file`: name for messages.
/// - `text`: contents of `experiment.toml`.
/// - `overrides`: assignments `key.path=value`, applied in order. The path selects an element of a
///   list by its `name` or index, as in `robot.joint.joint1.gear_ratio=100`. A value that is not
///   TOML becomes a string.
/// - `files`: opens the files that the experiment names, such as a URDF and its meshes.
///
/// # Errors
///
/// [`DescriptionError`] with the line or the override, the fault and the remedy.
pub fn read(
    file: &str,
    text: &str,
    overrides: &[String],
    files: &mut dyn NamedFiles,
) -> Result<Experiment, DescriptionError> {
    if text.len() > EXPERIMENT_BYTES {
        return Err(DescriptionError::File {
            file: file.to_owned(),
            message: format!(
                "the file has {} bytes, and an experiment file has at most {}",
                text.len(),
                size(EXPERIMENT_BYTES)
            ),
            code: None,
        });
    }
    let mut table = DeTable::parse(text).map_err(|error| at(file, text, &error))?;
    let assignments = overrides
        .iter()
        .map(|assignment| fragment(assignment))
        .collect::<Result<Vec<_>, _>>()?;
    let parsed = assignments
        .iter()
        .zip(overrides)
        .map(|(fragment, assignment)| {
            let table = DeTable::parse(fragment).map_err(|error| DescriptionError::Override {
                assignment: assignment.clone(),
                message: error.message().to_owned(),
                code: None,
            })?;
            keys::check(table.get_ref()).map_err(|misfit| DescriptionError::Override {
                assignment: assignment.clone(),
                message: misfit.message,
                code: misfit.code,
            })?;
            Ok(table)
        })
        .collect::<Result<Vec<_>, DescriptionError>>()?;
    keys::check(table.get_ref()).map_err(|misfit| locate(file, text, misfit))?;
    let mut written = table.clone();
    for (fragment, assignment) in parsed.into_iter().zip(overrides) {
        merge(table.get_mut(), fragment.into_inner()).map_err(|message| {
            DescriptionError::Override {
                assignment: assignment.clone(),
                message,
                code: None,
            }
        })?;
    }
    unfilled::check(table.get_ref()).map_err(|misfit| locate(file, text, misfit))?;
    spread(table.get_mut());
    spread(written.get_mut());
    interpret(file, text, table.clone(), files).map_err(|error| {
        let elsewhere = matches!(
            error,
            DescriptionError::Unreadable { .. } | DescriptionError::Urdf { .. }
        );
        if overrides.is_empty() || elsewhere {
            return error;
        }
        // Spans of overrides are no positions in the file. If the file alone has no error, the
        // overrides caused it.
        if let Err(of_file) = interpret(file, text, written, files) {
            of_file
        } else {
            let (message, code) = match error {
                DescriptionError::Line { message, code, .. }
                | DescriptionError::File { message, code, .. }
                | DescriptionError::Override { message, code, .. } => (message, code),
                DescriptionError::Unreadable { message } | DescriptionError::Urdf { message } => {
                    (message, None)
                }
            };
            DescriptionError::Override {
                assignment: overrides.join(" --set "),
                message,
                code,
            }
        }
    })
}

/// Returns the JSON schema of `experiment.toml`.
#[must_use]
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(ExperimentFile).to_value()
}

fn interpret(
    file: &str,
    text: &str,
    table: Spanned<DeTable<'_>>,
    files: &mut dyn NamedFiles,
) -> Result<Experiment, DescriptionError> {
    let spans = table.get_ref().clone();
    let mut read = ExperimentFile::deserialize(toml::Deserializer::from(table))
        .map_err(|error| at(file, text, &error))?;
    let located = |fault: Fault| {
        let path: Vec<&str> = fault.path.iter().map(String::as_str).collect();
        let misfit = Misfit {
            span: keys::span_of(&spans, &path),
            message: fault.message,
            code: fault.code,
        };
        locate(file, text, misfit)
    };
    check_format(&read)
        .and_then(|()| kinematics(&read.robot))
        .map_err(located)?;
    read.robot.tree = tree(file, &read.robot, files).map_err(|error| match error {
        TreeError::Fault(fault) => located(fault),
        TreeError::Unreadable(message) => DescriptionError::Unreadable { message },
        TreeError::Urdf(message) => DescriptionError::Urdf { message },
    })?;
    check(&read).map_err(located)?;
    let experiment = Experiment {
        robot: read.robot,
        log: read.log,
        identify: read.identify,
        controller: read.controller,
        validate: read.validate,
        simulate: read.simulate,
        excite: read.excite,
        control: read.control,
    };
    Ok(experiment.settled())
}

/// Turns `key.path=value` into a line of TOML; a value that is not TOML becomes a string.
fn fragment(assignment: &str) -> Result<String, DescriptionError> {
    let Some((key, value)) = assignment.split_once('=') else {
        return Err(DescriptionError::Override {
            assignment: assignment.to_owned(),
            message: "write it as key.path=value".to_owned(),
            code: None,
        });
    };
    let line = format!("{key} = {value}");
    if DeTable::parse(&line).is_ok() {
        return Ok(line);
    }
    let string = serde_json::Value::String(value.trim().to_owned());
    Ok(format!("{key} = {string}"))
}

fn merge<'i>(into: &mut DeTable<'i>, from: DeTable<'i>) -> Result<(), String> {
    for (key, value) in from {
        match into.get_mut(&key) {
            Some(old) => merge_value(old.get_mut(), value.into_inner())?,
            None => {
                into.insert(key, value);
            }
        }
    }
    Ok(())
}

fn merge_value<'i>(old: &mut DeValue<'i>, new: DeValue<'i>) -> Result<(), String> {
    match (old, new) {
        (DeValue::Table(old), DeValue::Table(new)) => merge(old, new),
        (DeValue::Array(old), DeValue::Table(new)) => {
            for (key, value) in new {
                let index = element(old, key.get_ref())?;
                if let Some(item) = old.get_mut(index) {
                    merge_value(item.get_mut(), value.into_inner())?;
                }
            }
            Ok(())
        }
        (old, new) => {
            *old = new;
            Ok(())
        }
    }
}

/// Returns the index of an array element by its `name`, or by its index from 0.
fn element(array: &DeArray<'_>, key: &str) -> Result<usize, String> {
    let names: Vec<Option<&str>> = (array.iter())
        .map(|item| item.get_ref().get("name")?.get_ref().as_str())
        .collect();
    let index = (names.iter())
        .position(|name| *name == Some(key))
        .or_else(|| key.parse().ok().filter(|index| *index < array.len()));
    index.ok_or_else(|| {
        let known: Vec<&str> = names.iter().flatten().copied().collect();
        format!(
            "there is no element \"{key}\"; there are {} ({})",
            array.len(),
            known.join(", ")
        )
    })
}

/// Words of the TOML reader, and words for people.
const WORDS: [(&str, &str); 5] = [
    ("expected f64", "expected a number"),
    ("expected usize", "expected a whole number from 0"),
    ("expected u64", "expected a whole number from 0"),
    ("expected u32", "expected a whole number from 0"),
    (
        "missing field `format`",
        "missing field `format`; an experiment file begins with format = 1, and sprung new FOLDER writes one",
    ),
];

fn at(file: &str, text: &str, error: &toml::de::Error) -> DescriptionError {
    let message = error.message().trim().replace('\n', ", ");
    let misfit = Misfit {
        span: error.span(),
        message: (WORDS.iter()).fold(message, |message, (from, to)| message.replace(from, to)),
        code: None,
    };
    locate(file, text, misfit)
}

fn locate(file: &str, text: &str, misfit: Misfit) -> DescriptionError {
    let file = file.to_owned();
    match misfit.span {
        Some(span) if span.start <= text.len() && span.end > 0 => DescriptionError::Line {
            file,
            line: 1 + text
                .get(..span.start)
                .map_or(0, |before| before.matches('\n').count()),
            message: misfit.message,
            code: misfit.code,
        },
        _ => DescriptionError::File {
            file,
            message: misfit.message,
            code: misfit.code,
        },
    }
}
