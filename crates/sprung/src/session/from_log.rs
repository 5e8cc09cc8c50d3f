//! Starts a new experiment from a log: chooses its columns, and checks the choice.

use std::io::Result as IoResult;
use std::path::{Component, Path, PathBuf};

use super::error::SessionError;
use super::files::{Disk, Files};
use super::load::Session;
use super::start::{reference, resolved};
use sprung_base::finding::{Finding, Severity};
use sprung_base::progress::Listener;
use sprung_log::{
    Input, LOOKS_LIKE_DEGREES, LOOKS_LIKE_RADIANS, Survey, TIME_UNIT, choose, joint_count,
    joint_names,
};
use sprung_robot::{Chosen, ChosenLine, FILL_IN, Start, template};

/// Most corrections of the choice by the check.
const MAX_CORRECTIONS: usize = 4;

/// Lines of `[log]` that the check may add to a choice. The check proposes them for other mistakes as
/// well, but these do not depend on the names of columns.
const ADDED: [&str; 2] = ["motor_torque_side", "sign"];

/// A new experiment.
#[derive(Clone, Debug, Default)]
pub struct NewExperiment {
    /// Text of its file.
    pub text: String,
    /// Places that the user must fill in: line, from 1, and key.
    pub open: Vec<(usize, String)>,
    /// Errors and serious findings of the check, if the check could run.
    pub findings: Vec<Finding>,
    /// Why the check could not run, if it could not.
    pub unchecked: Option<String>,
    /// Names of the joints of the log.
    pub joints: Vec<String>,
    /// Number of the robot's joints that are not in the log.
    pub left_out: usize,
    /// Sentences about the file of the robot, joints of grippers and joints that follow others, without their last full stops.
    pub about_joints: Vec<String>,
    /// Choices by names of columns that the equations of the robot or the clock of the log contradict, each with the
    /// corrected lines.
    pub corrected: Vec<String>,
    /// Lines of `[log]` that were chosen.
    pub lines: Vec<String>,
}

impl NewExperiment {
    /// Returns the experiment of a robot without a log.
    #[must_use]
    pub fn without_log(start: &Start) -> Self {
        Self {
            about_joints: start.remarks(),
            ..Self::of(start)
        }
    }

    fn of(start: &Start) -> Self {
        let text = template(start);
        Self {
            open: open_places(&text),
            text,
            ..Self::default()
        }
    }

    /// Returns the experiment of a robot and its logs: chooses the columns by their names and contents, then checks the
    /// choice.
    ///
    /// - `logs`: the logs, at least one, or the files of one recording; `topics`: beginning of the topics of a bag that belong to the robot, or none for
    ///   all; `folder`: future folder of the experiment, which need not exist.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if a log cannot be read or has no columns of the robot's joints, if the logs
    /// have different columns, or if the caller stops the check.
    pub fn from_logs(
        start: &Start,
        (logs, topics): (&[PathBuf], Option<&str>),
        folder: &Path,
        progress: &mut dyn Listener,
    ) -> Result<Self, SessionError> {
        let mut paths = Vec::new();
        let mut first: Option<Survey> = None;
        for log in logs {
            let path = reference(log, folder).map_err(|source| SessionError::NoFolder {
                file: log.clone(),
                source,
            })?;
            let Some(path) = path.to_str() else {
                return Err(SessionError::NotUnicode { path });
            };
            let name = log.display().to_string();
            match &mut first {
                None => first = Some(Survey::read(&name, &mut |_| Disk.open(log))?),
                Some(first) => {
                    let mut open = |_: Option<&Path>| Disk.open(log);
                    let beginning = Survey::read_beginning(&name, &mut open)?;
                    let lacks = beginning.lacks_of(first);
                    if (lacks.is_some() || beginning.says_in_its_name())
                        && paths.len() == 1
                        && first.join(&Survey::read(&name, &mut open)?, path)
                    {
                        continue;
                    }
                    if let Some(column) = lacks {
                        return Err(SessionError::OtherColumns {
                            file: name,
                            column,
                            first: logs[0].display().to_string(),
                        });
                    }
                }
            }
            paths.push(path.to_owned());
        }
        let mut survey = first.unwrap_or_default();
        if let Some(topics) = topics {
            survey = survey.with_topics(topics)?;
        }
        let (robot, mimics) = (start.joints(), start.mimics());
        let mut chosen = choose(&survey, (&robot, &mimics), &paths)?;
        if !start.has_bodies() && has_open_torque_side(&chosen) {
            let why = "FILL IN \"motor\" or \"output\", the side of the gearbox of the torques: without the \
                       masses of the links the log does not tell";
            let line = ChosenLine::open("motor_torque_side", why);
            chosen.lines.push(line);
        }
        let mut about = start.with(chosen.clone()).remarks();
        let grippers = (chosen.grippers.iter())
            .map(|(joint, why)| format!("{joint} is left out as a joint of a gripper, {why}"));
        about.splice(0..0, survey.joined().iter().cloned().chain(grippers));
        let left_out = chosen.left_out.len();
        let new = checked(start, chosen, folder, progress)?;
        Ok(Self {
            left_out,
            about_joints: about,
            ..new
        })
    }
}

/// Returns a robot with the joints of a log, whose table is to be filled in. Numbers or names of columns tell the joints.
///
/// - `joints`: their number if the user gives it; `otherwise`: if nothing tells it.
///
/// # Errors
///
/// [`SessionError`] if the log cannot be read or the number is out of range.
pub fn start_from_logs(
    logs: &[PathBuf],
    joints: Option<usize>,
    otherwise: usize,
) -> Result<Start, SessionError> {
    let mut found = joints;
    for log in logs {
        let name = log.display().to_string();
        let survey = Survey::read_beginning(&name, &mut |_| Disk.open(log))?;
        let counted = joint_count(&survey);
        let names = joint_names(&survey).filter(|names| {
            counted.is_none_or(|count| count <= names.len())
                && found.is_none_or(|count| count == names.len())
        });
        if let Some(start) = names.and_then(|names| Start::named(names).ok()) {
            return Ok(start);
        }
        found = found.or(counted);
    }
    Ok(Start::table(found.unwrap_or(otherwise))?)
}

/// Returns whether torques may have been taken before the gearbox: the positions were.
fn has_open_torque_side(chosen: &Chosen) -> bool {
    let torques = ["motor_torque_nm", "motor_force_n", "motor_torque"];
    let is_geared = chosen.line("motor_position_side").is_some();
    is_geared && torques.iter().any(|key| chosen.line(key).is_some())
}

/// Checks a choice and corrects it by the findings of the check.
fn checked(
    start: &Start,
    mut chosen: Chosen,
    folder: &Path,
    progress: &mut dyn Listener,
) -> Result<NewExperiment, SessionError> {
    let written = |chosen: &Chosen| {
        let robot = start.joints();
        NewExperiment {
            joints: (chosen.joints.iter())
                .map(|joint| robot[joint.joint].name.clone())
                .collect(),
            lines: (chosen.lines.iter())
                .map(|line| format!("{} = {}", line.key, line.value))
                .collect(),
            ..NewExperiment::of(&start.with(chosen.clone()))
        }
    };
    let mut new = written(&chosen);
    if !new.open.is_empty() {
        return Ok(new);
    }
    let mut look = |new: &mut NewExperiment| check(new, folder, progress);
    look(&mut new)?;
    let mut corrected = Vec::new();
    for _ in 0..MAX_CORRECTIONS {
        let better = (new.findings.iter())
            .filter_map(|finding| Some((finding.text.clone(), mended(&chosen, finding)?)))
            .find_map(|(text, other)| {
                let mut now = written(&other);
                match look(&mut now) {
                    Ok(()) if now.badness() < new.badness() => Some(Ok((text, other, now))),
                    Ok(()) => None,
                    Err(error) => Some(Err(error)),
                }
            });
        match better {
            Some(Ok((text, other, now))) => {
                corrected.push(correction(&text, &chosen, &other));
                (chosen, new) = (other, now);
            }
            Some(Err(error)) => return Err(error),
            None => break,
        }
    }
    Ok(NewExperiment { corrected, ..new })
}

/// Returns a sentence about a corrected choice, with the lines that it changed.
fn correction(text: &str, before: &Chosen, after: &Chosen) -> String {
    let is_new = |line: &&ChosenLine| {
        !(before.lines.iter()).any(|other| (&other.key, &other.value) == (&line.key, &line.value))
    };
    let lines: Vec<String> = (after.lines.iter().filter(is_new))
        .map(|line| format!("{} = {}", line.key, line.value))
        .collect();
    format!("{text}; so the file says {}", lines.join("; "))
}

/// How bad the findings of a check are; earlier fields decide.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Badness {
    /// Whether the check could not run.
    is_unchecked: bool,
    errors: usize,
    serious: usize,
    /// Warnings about the unit of time.
    warnings: usize,
}

impl NewExperiment {
    /// Returns whether an identification would refuse the log: the check found an error, or could not run.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        let is_error = |finding: &Finding| finding.severity == Severity::Error;
        self.unchecked.is_some() || self.findings.iter().any(is_error)
    }

    fn badness(&self) -> Badness {
        let of = |severity: Severity| {
            let same = |finding: &&Finding| finding.severity == severity;
            self.findings.iter().filter(same).count()
        };
        Badness {
            is_unchecked: self.unchecked.is_some(),
            errors: of(Severity::Error),
            serious: of(Severity::Serious),
            warnings: of(Severity::Warning),
        }
    }
}

/// Checks an experiment, and adds errors and serious findings to it.
///
/// # Errors
///
/// [`SessionError::Stopped`] if the caller stops the check. Another error is a result.
fn check(
    new: &mut NewExperiment,
    folder: &Path,
    progress: &mut dyn Listener,
) -> Result<(), SessionError> {
    let folder = resolved(folder).unwrap_or_else(|| folder.to_owned());
    let open = move |path: &Path| -> IoResult<Box<dyn Input>> {
        Disk.open(&without_parents(&folder.join(path)))
    };
    let session = Session::read("experiment.toml", &new.text, &[], open);
    match session.and_then(|session| session.check(progress)) {
        Ok(checked) => {
            new.findings = (checked.report.findings.into_iter())
                .filter(|finding| {
                    finding.severity >= Severity::Serious || finding.code == TIME_UNIT
                })
                .collect();
            Ok(())
        }
        Err(error) if error.kind() == super::error::ErrorKind::Stopped => Err(error),
        Err(error) => {
            new.unchecked = Some(error.to_string());
            Ok(())
        }
    }
}

/// Resolves `..` in a path by its words: its folder need not exist.
fn without_parents(path: &Path) -> PathBuf {
    let mut resolved = PathBuf::new();
    for part in path.components() {
        if part == Component::ParentDir {
            resolved.pop();
        } else {
            resolved.push(part);
        }
    }
    resolved
}

/// Returns the choice without the mistake that a finding names; `None` if the finding contains no
/// correction.
fn mended(chosen: &Chosen, finding: &Finding) -> Option<Chosen> {
    let mut other = chosen.clone();
    let why = format!("By the equations of the robot: {}", finding.text);
    if finding.code == TIME_UNIT {
        let (key, value) = finding
            .setting
            .as_ref()?
            .strip_prefix("[log] ")?
            .split("  #")
            .next()?
            .split_once(" = ")?;
        let line = other
            .lines
            .iter_mut()
            .find(|line| line.key.starts_with("time_"))?;
        *line = ChosenLine::new(key, value, finding.text.clone());
        return (other != *chosen).then_some(other);
    }
    if let Some((from, to)) = other_unit(finding) {
        let mut why = Some(why);
        for line in &mut other.lines {
            if !(line.key.starts_with("motor_position") || line.key.starts_with("link_position")) {
                continue;
            }
            if line.key.ends_with(&format!("_{from}")) {
                line.key = line.key.replace(&format!("_{from}"), &format!("_{to}"));
            } else {
                let [from, to] = [from, to].map(|unit| format!("unit = \"{unit}\""));
                line.value = line.value.replace(&from, &to);
            }
            line.why = why.take().unwrap_or_default();
        }
        return (other != *chosen).then_some(other);
    }
    let (key, value) = finding
        .setting
        .as_ref()?
        .strip_prefix("[log] ")?
        .split_once(" = ")?;
    if !ADDED.contains(&key) || chosen.line(key).is_some() || value.contains('…') {
        return None;
    }
    other.lines.push(ChosenLine::new(key, value, why));
    Some(other)
}

/// Returns the unit of the positions that a finding contradicts, and the right one.
fn other_unit(finding: &Finding) -> Option<(&'static str, &'static str)> {
    if finding.code == LOOKS_LIKE_DEGREES {
        Some(("rad", "deg"))
    } else {
        (finding.code == LOOKS_LIKE_RADIANS).then_some(("deg", "rad"))
    }
}

/// Returns lines and keys of the places that are not filled in.
fn open_places(text: &str) -> Vec<(usize, String)> {
    (text.lines().zip(1..))
        .filter(|(line, _)| !line.starts_with('#') && line.contains(&format!("\"{FILL_IN}\"")))
        .map(|(line, number)| {
            let key = line.split(" =").next().unwrap_or(line);
            (number, key.trim().to_owned())
        })
        .collect()
}
