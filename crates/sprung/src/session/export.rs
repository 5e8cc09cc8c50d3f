//! Exports identified robots for simulators and controllers.

use std::collections::BTreeMap;
use std::path::Path;

use super::control_code::control_code;
use super::control_error::ControlError;
use super::error::SessionError;
use super::files::read_text;
use super::load::Session;
use super::parameters::Parameters;
use sprung_base::sha256::sha256;
use sprung_export::{
    ControlCode, ExportError, Exported, Form, Format, JointEvidence, Known, LogOrigin,
    ObserverCode, Origin, Request, ValueOrigin, export,
};
use sprung_log::Channels;
use sprung_method::control::ControlDesign;
use sprung_method::estimate::{EstimateResult, Identification, ModelDependence};
use sprung_method::watch::{ObserverSettings, Watch};
use sprung_model::Model;
use sprung_robot::{Experiment, Signal};

/// What is exported.
#[derive(Clone, Copy, Debug)]
pub struct ExportRequest<'a> {
    /// The file of the parameters, for the origin.
    pub file: &'a Path,
    /// Format of the file.
    pub format: Format,
    /// Form of flexible joints.
    pub form: Form,
    /// Index of the parameter set, one for each estimator of an identification.
    pub set: usize,
    /// A designed controller, which code then contains.
    pub control: Option<&'a ControlDesign>,
    /// A watch, whose observer code then contains.
    pub watch: Option<&'a Watch>,
}

/// A robot before its values are chosen.
pub(super) struct Exporter<'a> {
    session: &'a Session,
    request: ExportRequest<'a>,
    identification: Option<&'a Identification>,
    /// The result that the set names; absent for given values.
    pub(super) result: Option<&'a EstimateResult>,
    experiment: Experiment,
    model: Model,
    /// Name and text.
    urdf: Option<(String, String)>,
    evidence: Vec<JointEvidence>,
    /// Without values.
    origin: Origin,
}

impl Session {
    /// Exports the robot with identified parameters.
    ///
    /// The values are those of possible bodies and drives.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if there is no such set, if the parameters belong to another robot, are not physical or are not
    /// those of single links, or if a file cannot be read.
    pub fn export(
        &self,
        parameters: &Parameters,
        request: &ExportRequest<'_>,
    ) -> Result<Exported, SessionError> {
        let exporter = Exporter::new(self, parameters, request)?;
        let values = if let Some(result) = exporter.result {
            exporter.completed(result, values_of(result), |moved| moved.projected)
        } else {
            let given = parameters.sets.get(request.set);
            let values = given.map_or_else(BTreeMap::new, |set| set.values.clone());
            exporter.model.check_names(&values)?;
            values
        };
        let mut origin = exporter.origin.clone();
        let identified = exporter.result;
        origin.values = identified.map_or_else(Vec::new, |result| origins(result, &values));
        exporter.export(&values, origin)
    }

    /// Returns a designed controller of this robot in the form of the export.
    fn code_of(
        &self,
        control: &ControlDesign,
        format: Format,
    ) -> Result<ControlCode, ControlError> {
        if !format.is_code() {
            return Err(ControlError::NoCode {
                format: format.name(),
            });
        }
        let experiment = self.experiment();
        let joints = experiment.robot.joint.iter().map(|joint| &joint.name);
        if control.robot != experiment.robot.name || !joints.eq(&control.joints) {
            return Err(ControlError::OtherRobot {
                found: format!("\"{}\"", control.robot),
                expected: format!("\"{}\"", experiment.robot.name),
            });
        }
        control_code(control)
    }

    /// Returns the observer of a watch of this robot in the form of the export.
    fn observer_of(&self, watch: &Watch, format: Format) -> Result<ObserverCode, ExportError> {
        let refused = |what: String| Err(ExportError::Observer { what });
        if !format.is_code() {
            return refused(format!("{} is no code; export c or rust", format.name()));
        }
        let experiment = self.experiment();
        let joints = experiment.robot.joint.iter().map(|joint| &joint.name);
        if watch.robot != experiment.robot.name
            || !joints.eq(watch.joints.iter().map(|of| &of.joint))
        {
            return refused(format!(
                "the watch is of \"{}\", and the experiment of \"{}\" with other joints or another name",
                watch.robot, experiment.robot.name
            ));
        }
        let Some(settings) = ObserverSettings::of(watch) else {
            return refused("the healthy logs were too short for the threshold of each joint; learn from longer ones".to_owned());
        };
        let mut header = vec![format!(
            "Thresholds: {} false alarms per hour, learned from {:.0} s of healthy motion, with the values of {}.",
            watch.false_alarms_per_h, watch.learned_s, watch.parameters
        )];
        if watch.accepted_unusable {
            header.push(
                "WARNING: the verdict on the identified values is unusable; they were accepted nevertheless.".to_owned(),
            );
        }
        Ok(ObserverCode { settings, header })
    }

    fn check_robot(&self, found: &str) -> Result<(), ExportError> {
        let expected = &self.experiment().robot.name;
        if found == expected {
            return Ok(());
        }
        Err(ExportError::OtherRobot {
            found: format!("the robot \"{found}\""),
            expected: format!("\"{expected}\""),
        })
    }

    fn origin(
        &self,
        file: &Path,
        identification: Option<&Identification>,
        result: Option<&EstimateResult>,
    ) -> Origin {
        let logs = identification.into_iter().flat_map(Identification::logs);
        let hash = |name: &str| {
            let input = self.files.open(&self.folder.join(name)).ok()?;
            sha256(input).ok()
        };
        Origin {
            experiment: self.name(),
            parameters: file.display().to_string(),
            estimator: result.map(|result| result.estimator.clone()),
            verdict: result.map(|result| match result.decision.sentence.as_str() {
                "" => result.verdict.word().to_owned(),
                sentence => sentence.to_owned(),
            }),
            logs: logs
                .map(|log| LogOrigin {
                    sha256: hash(&log.file),
                    file: log.name(),
                })
                .collect(),
            draw: None,
            values: Vec::new(),
        }
    }
}

impl<'a> Exporter<'a> {
    pub(super) fn new(
        session: &'a Session,
        parameters: &'a Parameters,
        request: &ExportRequest<'a>,
    ) -> Result<Self, SessionError> {
        session.allow_export(request.format)?;
        let identification = parameters.identification.as_ref();
        if let Some(identification) = identification {
            session.check_robot(&identification.robot)?;
        }
        let result = identification
            .map(|identification| result_of(identification, request.set))
            .transpose()?;
        let (experiment, model) = session.described_by(parameters)?;
        if let Some(result) = result {
            check_parameters(&model, result)?;
        }
        let urdf = match &experiment.robot.urdf {
            Some(path) => {
                let path = session.folder.join(path);
                let text = read_text(&*session.files, &path)?;
                Some((path.display().to_string(), text))
            }
            None => None,
        };
        Ok(Self {
            evidence: evidence(&experiment, &model, identification, result),
            origin: session.origin(request.file, identification, result),
            request: *request,
            session,
            identification,
            result,
            experiment,
            model,
            urdf,
        })
    }

    /// Returns the values of a robot as the format needs them.
    ///
    /// - `values`: of parameters, of inertial parameters of single links, and constants of friction laws, by name.
    /// - `projected`: friction without the laws that a format lacks.
    pub(super) fn completed(
        &self,
        result: &EstimateResult,
        mut values: BTreeMap<String, f64>,
        projected: impl Fn(&ModelDependence) -> f64,
    ) -> BTreeMap<String, f64> {
        if self.request.format.has_few_laws() {
            let moved = result.dependence.iter();
            values.extend(moved.map(|moved| (moved.name.clone(), projected(moved))));
        }
        for joint in self
            .identification
            .iter()
            .flat_map(|identification| &identification.rigid_joints)
        {
            joint.complete(|name| result.lacks(name), &mut values);
        }
        values
    }

    /// Returns the origin without values.
    pub(super) fn origin(&self) -> &Origin {
        &self.origin
    }

    /// Returns the file of a robot with these values.
    pub(super) fn export(
        &self,
        values: &BTreeMap<String, f64>,
        origin: Origin,
    ) -> Result<Exported, SessionError> {
        self.with(values, origin, export)
    }

    /// Returns the file of a writer for a robot with these values.
    pub(super) fn with<T>(
        &self,
        values: &BTreeMap<String, f64>,
        origin: Origin,
        write: impl Fn(&Request<'_>) -> Result<T, ExportError>,
    ) -> Result<T, SessionError> {
        let Self {
            session, request, ..
        } = self;
        let format = request.format;
        let control = request
            .control
            .map(|control| session.code_of(control, format));
        let observer = request
            .watch
            .map(|watch| session.observer_of(watch, format));
        let folder = (self.experiment.robot.urdf.as_ref())
            .and_then(|path| session.folder.join(path).parent().map(Path::to_owned))
            .unwrap_or_default();
        Ok(write(&Request {
            format,
            form: request.form,
            experiment: &self.experiment,
            model: &self.model.shaped(values),
            values,
            urdf: (self.urdf.as_ref()).map(|(name, text)| (name.as_str(), text.as_str())),
            is_there: &|mesh| session.files.open(&folder.join(mesh)).is_ok(),
            evidence: &self.evidence,
            origin,
            control: control.transpose()?,
            observer: observer.transpose()?,
        })?)
    }
}

/// Returns a result of an identification.
pub(super) fn result_of(
    found: &Identification,
    set: usize,
) -> Result<&EstimateResult, SessionError> {
    let results = &found.results;
    results.get(set).ok_or(SessionError::NoResult {
        set,
        count: results.len(),
    })
}

/// Checks that the parameters of a result are those of the model.
fn check_parameters(model: &Model, result: &EstimateResult) -> Result<(), ExportError> {
    let known = result.parameters.iter().map(|parameter| &parameter.name);
    let other = known
        .clone()
        .find(|name| model.index_of(name).is_err())
        .map(|name| {
            (
                format!("a robot with {name}"),
                "a robot without it".to_owned(),
            )
        })
        .or_else(|| {
            let mut parameters = model.parameters().iter();
            let lacking =
                parameters.find(|parameter| known.clone().all(|name| *name != parameter.name))?;
            Some((
                format!("a robot without {}", lacking.name),
                "a robot with it".to_owned(),
            ))
        });
    match other {
        Some((found, expected)) => Err(ExportError::OtherRobot { found, expected }),
        None => Ok(()),
    }
}

/// Returns the values of possible bodies and drives; values of the estimate where there are none.
pub(super) fn values_of(result: &EstimateResult) -> BTreeMap<String, f64> {
    let parameters = (result.parameters.iter()).filter_map(|parameter| {
        Some((
            parameter.name.clone(),
            parameter.physical.or(parameter.value)?,
        ))
    });
    let standard = (result.standard_parameters.iter())
        .map(|parameter| (parameter.name.clone(), parameter.value));
    // The scales of friction laws have separate names.
    let mut values = result.values();
    values.extend(parameters.chain(standard));
    values
}

/// Returns the determined parameters with the values that the file holds.
pub(super) fn origins(result: &EstimateResult, values: &BTreeMap<String, f64>) -> Vec<ValueOrigin> {
    let parameters = (result.parameters.iter()).filter_map(|parameter| {
        parameter.physical.or(parameter.value)?;
        let value = *values.get(&parameter.name)?;
        let projected = (result.dependence.iter()).find(|moved| {
            moved.name == parameter.name && moved.projected.to_bits() == value.to_bits()
        });
        Some(ValueOrigin {
            name: parameter.name.clone(),
            unit: parameter.unit.clone(),
            value,
            beside_laws: projected.map(|moved| moved.raw),
            standard_error: parameter.standard_error,
        })
    });
    let standard = (result.standard_parameters.iter())
        .filter(|parameter| result.parameter(&parameter.name).is_none())
        .filter_map(|parameter| {
            Some(ValueOrigin {
                name: parameter.name.clone(),
                unit: parameter.unit.clone(),
                value: *values.get(&parameter.name)?,
                beside_laws: None,
                standard_error: parameter.standard_error,
            })
        });
    parameters.chain(standard).collect()
}

/// Returns the delay and the noise of each joint's torque.
fn evidence(
    experiment: &Experiment,
    model: &Model,
    identification: Option<&Identification>,
    result: Option<&EstimateResult>,
) -> Vec<JointEvidence> {
    let channels = (experiment.log.as_ref())
        .and_then(|log| Channels::new(&experiment.robot, log).ok())
        .map_or_else(Vec::new, |channels| channels.all);
    let refinement = result.and_then(|result| result.refinement.as_ref());
    let of = |joint: usize| {
        let column = (channels.iter())
            .find(|channel| channel.joint == joint && channel.quantity.signal() == Signal::Torque)
            .map(|channel| channel.column.as_str());
        let refined = || {
            let delays = &refinement?.delays;
            let delay = delays
                .iter()
                .find(|delay| Some(delay.column.as_str()) == column)?;
            Some(Known {
                value: delay.delay_s,
                standard_error: delay.standard_error_s,
            })
        };
        let used = || {
            let delay = identification?.log.delay_s.get(column?)?;
            Some(Known {
                value: delay.value,
                standard_error: delay.standard_error,
            })
        };
        let row = model.row_name(model.torque_row(joint));
        let white = || {
            let refinement = refinement.filter(|refinement| refinement.used)?;
            let row = refinement
                .disturbances
                .iter()
                .find(|disturbance| disturbance.row == row)?;
            Some(row.torque_noise_nm)
        };
        JointEvidence {
            delay: refined().or_else(used),
            torque_noise: white().or_else(|| result?.residual_rms.get(&row)),
        }
    };
    (0..model.joint_count()).map(of).collect()
}
