//! Reads experiments from their files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::error::SessionError;
use super::experiment_path::{EXPERIMENT_FILE, experiment_file};
use super::files::{Disk, Files, InFolder, read_text};
use super::results::{RESULTS_FOLDER, ReadIdentification};
use sprung_method::unknowns::{UnknownResult, UnknownStatus, with_added_laws};
use sprung_model::Model;
use sprung_robot::{Experiment, Laws, Log, Validate};

/// An experiment, its robot's equations, and access to its files.
#[derive(Clone)]
pub struct Session {
    experiment: Experiment,
    model: Model,
    text: String,
    // The experiment file, if the experiment was read from one.
    file: Option<PathBuf>,
    // Folder to which the paths in the experiment are relative.
    pub(super) folder: PathBuf,
    pub(super) files: Arc<dyn Files>,
    // Laws of earlier identifications in the model.
    pub(super) earlier_laws: Vec<UnknownResult>,
}

impl Session {
    /// Reads an experiment from disk.
    ///
    /// - `path`: the experiment file, or the folder that holds `experiment.toml`.
    /// - `overrides`: assignments `key.path=value`, as `--set` of the command line takes them.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the experiment file or a file that it names is wrong or cannot be read.
    pub fn open(path: &Path, overrides: &[String]) -> Result<Self, SessionError> {
        let file = experiment_file(path)?;
        let name = file.display().to_string();
        let text = read_text(&Disk, &file)?;
        let folder = file.parent().map_or_else(PathBuf::new, Path::to_owned);
        let session = Self::with_folder(&name, &text, overrides, folder, Arc::new(Disk))?;
        Ok(Self {
            file: Some(file),
            ..session
        })
    }

    /// Reads an experiment from text.
    ///
    /// - `name`: name of the experiment for messages.
    /// - `files`: opens the files that the experiment names, by the paths given there.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the text or a file that it names is wrong.
    pub fn read(
        name: &str,
        text: &str,
        overrides: &[String],
        files: impl Files + 'static,
    ) -> Result<Self, SessionError> {
        Self::with_folder(name, text, overrides, PathBuf::new(), Arc::new(files))
    }

    /// Reads an experiment from text, and the files that it names from a folder.
    ///
    /// # Errors
    ///
    /// The errors of [`read`](Self::read).
    pub fn read_in(
        name: &str,
        text: &str,
        overrides: &[String],
        folder: PathBuf,
    ) -> Result<Self, SessionError> {
        Self::with_folder(name, text, overrides, folder, Arc::new(Disk))
    }

    fn with_folder(
        name: &str,
        text: &str,
        overrides: &[String],
        folder: PathBuf,
        files: Arc<dyn Files>,
    ) -> Result<Self, SessionError> {
        let mut named = InFolder(&*files, &folder);
        let experiment = sprung_robot::read(name, text, overrides, &mut named)?;
        Ok(Self {
            model: model(name, &experiment)?,
            experiment,
            text: text.to_owned(),
            file: None,
            folder,
            files,
            earlier_laws: Vec::new(),
        })
    }

    /// Returns this session with columns of another log in place of those of `[log]`.
    pub(super) fn with_log(&self, over: &Log) -> Result<Self, SessionError> {
        self.with_experiment(self.experiment.with_log(&self.name(), over)?)
    }

    /// Returns this session with another experiment.
    pub(super) fn with_experiment(&self, experiment: Experiment) -> Result<Self, SessionError> {
        Ok(Self {
            model: model(&self.name(), &experiment)?,
            experiment,
            ..self.clone()
        })
    }

    /// Returns this session with the laws of earlier identifications, the union of all of them, and with no search for
    /// others. So results of several runs have one model.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if an identification is that of another robot.
    pub fn with_laws_from(&self, earlier: &[ReadIdentification]) -> Result<Self, SessionError> {
        let mut experiment = self.experiment.clone();
        let mut earlier_laws: Vec<UnknownResult> = Vec::new();
        for ReadIdentification {
            path,
            identification,
        } in earlier
        {
            let expected = &experiment.robot.name;
            if identification.robot != *expected {
                return Err(SessionError::NotParameters {
                    file: path.display().to_string(),
                    why: format!(
                        "its robot is \"{}\", and that of the experiment is \"{expected}\"; give identifications of \
                         one robot",
                        identification.robot
                    ),
                });
            }
            experiment = with_added_laws(&experiment, &identification.unknowns);
            let laws = identification.unknowns.iter();
            for law in laws.filter(|unknown| unknown.used_law().is_some()) {
                if !earlier_laws.iter().any(|other| other.id == law.id) {
                    earlier_laws.push(UnknownResult {
                        status: UnknownStatus::Given,
                        ..law.clone()
                    });
                }
            }
        }
        for joint in &mut experiment.robot.joint {
            joint.laws = Some(Laws::Declared);
        }
        Ok(Self {
            earlier_laws,
            ..self.with_experiment(experiment)?
        })
    }

    /// Returns this session for logs in memory: its logs have the columns of the experiment, and separate names in
    /// place of those of files.
    #[must_use]
    pub fn without_files(&self) -> Self {
        let mut session = self.clone();
        let runs = session.experiment.validate.iter_mut();
        let of_runs = runs.filter_map(|run| run.log.as_mut());
        for log in session.experiment.log.iter_mut().chain(of_runs) {
            log.file = None;
        }
        session
    }

    /// Returns this session with a number of validation runs on logs with the columns of `[log]`. The
    /// first runs keep their names and controllers.
    #[must_use]
    pub fn with_runs(&self, count: usize) -> Self {
        let mut session = self.clone();
        let mut runs = std::mem::take(&mut session.experiment.validate).into_iter();
        let run = |number: usize| {
            let kept = runs.next();
            let (name, controller) = kept.map_or_else(
                || (format!("validation {number}"), None),
                |run| (run.name, run.controller),
            );
            Validate {
                name,
                log: None,
                controller,
            }
        };
        session.experiment.validate = (1..=count).map(run).collect();
        session
    }

    /// Returns this session with a validation run on each of some files. The first runs keep their names,
    /// controllers and columns.
    #[must_use]
    pub fn with_run_files(&self, files: Vec<PathBuf>) -> Self {
        let mut session = self.with_runs(files.len());
        for (place, (run, file)) in session
            .experiment
            .validate
            .iter_mut()
            .zip(files)
            .enumerate()
        {
            let kept = self.experiment.validate.get(place);
            let mut log = kept.and_then(|run| run.log.clone()).unwrap_or_default();
            log.file = Some(vec![file.into()]);
            run.log = Some(log);
        }
        session
    }

    /// Returns the experiment, including the overrides.
    #[must_use]
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Returns the robot's parameters and equations.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Returns the text of the experiment file, for reports.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the default folder for the results of this experiment: `sprung-out` beside
    /// `experiment.toml`, `sprung-out-NAME` beside `NAME.toml`.
    #[must_use]
    pub fn results_folder(&self) -> PathBuf {
        let stem = (self.file.as_ref())
            .filter(|file| !file.ends_with(EXPERIMENT_FILE))
            .and_then(|file| file.file_stem());
        let mut name = std::ffi::OsString::from(RESULTS_FOLDER);
        if let Some(stem) = stem {
            name.push("-");
            name.push(stem);
        }
        self.folder.join(name)
    }

    /// Returns the name of the experiment file; the name of the robot without a file.
    pub(super) fn name(&self) -> String {
        (self.file.as_ref()).map_or_else(
            || self.experiment.robot.name.clone(),
            |file| file.display().to_string(),
        )
    }

    /// Returns the folder to which the paths in the experiment are relative.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns all files that the experiment names, and the experiment file itself.
    #[must_use]
    pub fn inputs(&self) -> Vec<PathBuf> {
        let experiment = &self.experiment;
        let logs = (experiment.validate.iter())
            .filter_map(|run| run.log.as_ref())
            .chain(&experiment.log)
            .flat_map(Log::files);
        let robot = experiment.robot.urdf.iter();
        let twin = (experiment.simulate.iter()).filter_map(|twin| twin.parameters.as_ref());
        (logs.chain(robot).chain(twin))
            .map(|file| self.folder.join(file))
            .chain(self.file.clone())
            .collect()
    }
}

fn model(name: &str, experiment: &Experiment) -> Result<Model, SessionError> {
    Model::new(experiment).map_err(|error| SessionError::Robot {
        file: name.to_owned(),
        error,
    })
}

impl std::fmt::Debug for Session {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (f.debug_struct("Session"))
            .field("experiment", &self.experiment)
            .field("folder", &self.folder)
            .finish_non_exhaustive()
    }
}
