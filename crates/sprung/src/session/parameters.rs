//! Reads parameters for validation and simulation from files.

use std::collections::BTreeMap;
use std::path::Path;

use super::earlier_formats::identification_from;
use super::error::SessionError;
use super::files::{Disk, Files, read_text};
use super::load::Session;
use sprung_base::limits::{EXPERIMENT_BYTES, size};
use sprung_method::estimate::{IDENTIFICATION_FORMAT, Identification, LogInfo, with_rigid_joints};
use sprung_method::unknowns::with_added_laws;
use sprung_method::validate::{ChosenFor, ParameterSet};
use sprung_model::Model;
use sprung_robot::Experiment;
use sprung_servo::ServoIdentification;

/// Parameters, and the identification that contains them.
#[derive(Clone, Debug)]
pub struct Parameters {
    /// One set per estimator for an identification, or a single set for a TOML file.
    pub sets: Vec<ParameterSet>,
    /// The identification, if the parameters come from one.
    pub identification: Option<Identification>,
}

impl Parameters {
    /// Reads parameters from `identification.json`, or from a TOML table of values by name.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the file cannot be read or has other contents.
    pub fn open(path: &Path) -> Result<Self, SessionError> {
        Self::from_file(&Disk, path)
    }

    /// Reads such a file with the session's access to files.
    pub(super) fn from_file(files: &dyn Files, path: &Path) -> Result<Self, SessionError> {
        if let Some(folder) = path.parent() {
            files.settle(folder)?;
        }
        let text = read_text(files, path)?;
        let wrong = |why: String| SessionError::NotParameters {
            file: path.display().to_string(),
            why,
        };
        if path
            .extension()
            .is_some_and(|extension| extension == "json")
        {
            return of_json(&text).map_err(wrong);
        }
        if text.len() > EXPERIMENT_BYTES {
            let most = size(EXPERIMENT_BYTES);
            return Err(wrong(format!(
                "it has {} bytes, and {most} are the most",
                text.len()
            )));
        }
        let values: BTreeMap<String, f64> =
            toml::from_str(&text).map_err(|error| wrong(error.message().to_owned()))?;
        let label = path
            .file_stem()
            .map_or_else(|| "given".to_owned(), |stem| stem.display().to_string());
        Ok(Self::named(&label, values))
    }
}

impl Session {
    /// Returns the experiment and its model with the laws that the identification of the parameters
    /// added and the joints that it took as rigid, if there is one.
    pub(super) fn described_by(
        &self,
        parameters: &Parameters,
    ) -> Result<(Experiment, Model), SessionError> {
        let found = parameters.identification.as_ref();
        let unknowns = found.map_or(&[][..], |identification| &identification.unknowns);
        let has_laws = unknowns.iter().any(|unknown| unknown.used_law().is_some());
        let rigid = found.map_or(&[][..], |identification| &identification.rigid_joints);
        if !has_laws && rigid.iter().all(|joint| joint.hold_out.is_none()) {
            return Ok((self.experiment().clone(), self.model().clone()));
        }
        let experiment = with_rigid_joints(self.experiment(), rigid);
        let experiment = with_added_laws(&experiment, unknowns);
        let model = Model::new(&experiment)?;
        Ok((experiment, model))
    }
}

impl Parameters {
    /// Returns the choices of the identification that hold for other logs too.
    pub(super) fn chosen(&self) -> ChosenFor {
        let found = self.identification.as_ref();
        ChosenFor {
            delays: (found.iter())
                .flat_map(|found| &found.log.delay_s)
                .map(|(column, delay)| (column.clone(), delay.value))
                .collect(),
            torques_delay: (found.and_then(|found| found.log.torques_delay_s))
                .map_or(0.0, |delay| delay.value),
            position_cutoff_hz: found.map(|found| found.settings.position_cutoff_hz),
            logs: (found.iter())
                .flat_map(|found| found.logs().map(LogInfo::name))
                .collect(),
        }
    }

    /// Returns one set of values by name, from no identification.
    #[must_use]
    pub fn named(label: &str, values: BTreeMap<String, f64>) -> Self {
        Self {
            sets: vec![ParameterSet {
                label: label.to_owned(),
                values,
                promise: Vec::new(),
            }],
            identification: None,
        }
    }
}

impl From<&ServoIdentification> for Parameters {
    fn from(found: &ServoIdentification) -> Self {
        let values = found.parameters.iter();
        let values = values.map(|parameter| (parameter.name.clone(), parameter.value));
        Self::named("servo", values.collect())
    }
}

impl From<Identification> for Parameters {
    fn from(identification: Identification) -> Self {
        Self {
            sets: ParameterSet::of(&identification),
            identification: Some(identification),
        }
    }
}

fn of_json(text: &str) -> Result<Parameters, String> {
    let identification = serde_json::from_str(text)
        .and_then(identification_from)
        .map_err(|error| error.to_string())?;
    if !(1..=IDENTIFICATION_FORMAT).contains(&identification.format) {
        return Err(format!(
            "format {} is not known; this version reads formats 1 to {IDENTIFICATION_FORMAT}: identify the robot again",
            identification.format
        ));
    }
    if identification.results.is_empty() {
        return Err("it holds no results".to_owned());
    }
    Ok(identification.into())
}
