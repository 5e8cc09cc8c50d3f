//! Simulates logs with the digital twin.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::SessionError;
use super::load::Session;
use super::parameters::Parameters;
use sprung_base::progress::Listener;
use sprung_log::Channels;
use sprung_method::simulate::{Dynamics, TwinSetup, record};
use sprung_model::{Model, Theta};
use sprung_robot::{Controller, Log, Quantity, Simulate, Task, Validate};

/// A digital twin that is ready to be simulated.
#[derive(Clone, Debug)]
pub struct Recording<'a> {
    pub(super) model: Model,
    controller: &'a Controller,
    // Columns that differ from those of the experiment.
    pub(super) overlay: Option<&'a Log>,
    pub(super) settings: Simulate,
    pub(super) theta: Theta,
    channels: Channels,
    named: PathBuf,
}

impl Session {
    /// Prepares the twin that the experiment describes.
    ///
    /// - `run`: name of a `[[validate]]` run whose controller and log replace those of the
    ///   experiment.
    /// - `parameters`: parameters of the twin. Without them, the parameters of the `[simulate]`
    ///   block are used, or else the nominal ones.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the experiment lacks the twin, its controller, its parameters or the
    /// description of its log.
    pub fn twin(
        &self,
        run: Option<&str>,
        parameters: Option<&Parameters>,
    ) -> Result<Recording<'_>, SessionError> {
        self.no_servo(Task::Simulate)?;
        let experiment = self.experiment();
        let settings = experiment.simulate.as_ref().ok_or(SessionError::NoTwin)?;
        let run = run.map(|name| self.run(name)).transpose()?;
        let controller = run.and_then(|run| run.controller.as_ref());
        let controller = controller.or(experiment.controller.as_ref());
        let controller = controller.ok_or(SessionError::NoController)?;
        let (model, theta) = self.truth(settings, parameters)?;
        let overlay = run.and_then(|run| run.log.as_ref());
        let channels = Channels::new(&experiment.robot, &self.log(overlay)?)?;
        channels.require_sides(&experiment.robot)?;
        Ok(Recording {
            model,
            controller,
            overlay,
            settings: settings.clone(),
            theta,
            named: self.named_log(overlay)?,
            channels,
        })
    }

    /// Returns the robot with parameters, to compute its torques, masses and accelerations.
    ///
    /// - `set`: index of the parameter set, one for each estimator of an identification.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if a parameter has no value or there is no such set.
    pub fn dynamics(&self, parameters: &Parameters, set: usize) -> Result<Dynamics, SessionError> {
        self.allow(Task::Dynamics)?;
        let (_, model) = self.described_by(parameters)?;
        let values = (parameters.sets.get(set)).map(|set| &set.values);
        let values = values.cloned().unwrap_or_default();
        let theta = model.theta(&values)?;
        Ok(Dynamics::new(model.shaped(&values), theta))
    }

    /// Returns the validation run of this name.
    fn run(&self, name: &str) -> Result<&Validate, SessionError> {
        let runs = &self.experiment().validate;
        (runs.iter().find(|run| run.name == name)).ok_or_else(|| SessionError::NoRun {
            name: name.to_owned(),
            known: runs.iter().map(|run| run.name.clone()).collect(),
        })
    }

    /// Returns the twin's model and its true parameters.
    fn truth(
        &self,
        settings: &Simulate,
        parameters: Option<&Parameters>,
    ) -> Result<(Model, Theta), SessionError> {
        let of_block;
        let parameters = match (parameters, &settings.parameters) {
            (None, Some(file)) => {
                of_block = Parameters::from_file(&*self.files, &self.folder.join(file))?;
                Some(&of_block)
            }
            (given, _) => given,
        };
        let set = parameters.and_then(|parameters| Some((parameters, parameters.sets.first()?)));
        Ok(match set {
            Some((parameters, set)) => {
                let (_, model) = self.described_by(parameters)?;
                let theta = model.theta(&set.values)?;
                (model.shaped(&set.values), theta)
            }
            None => (self.model().clone(), self.model().nominal()?),
        })
    }

    /// Returns the path of the first log.
    fn named_log(&self, overlay: Option<&Log>) -> Result<PathBuf, SessionError> {
        let mut files = self.log_files(overlay)?.into_iter();
        files
            .next()
            .map(|file| file.path)
            .ok_or(SessionError::NoLogFile)
    }
}

impl Recording<'_> {
    /// Returns the twin with another random seed for its sensors and its noise.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.settings.seed = seed;
        self
    }

    /// Returns the random seed of its sensors and its noise.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.settings.seed
    }

    /// Checks that the twin measures with the errors that a bound needs.
    pub(super) fn require_noise(&self, joints: usize) -> Result<(), SessionError> {
        let noise = &self.settings.torque_noise_nm;
        let has_noise = noise.len() == joints && noise.iter().all(|level| *level > 0.0);
        let mut channels = self.channels.all.iter();
        let has_links = channels.any(|channel| channel.quantity == Quantity::LinkPosition);
        let missing = if self.settings.motor_encoder_counts_per_turn.is_empty() {
            "motor_encoder_counts_per_turn"
        } else if has_links && self.settings.link_encoder_counts_per_turn.is_empty() {
            "link_encoder_counts_per_turn"
        } else if !has_noise {
            "torque_noise_nm, one positive number for each joint"
        } else {
            return Ok(());
        };
        Err(SessionError::ExactTwin { missing })
    }

    /// Returns the path at which the experiment names the log.
    #[must_use]
    pub fn named(&self) -> &Path {
        &self.named
    }

    /// Returns the file name of the simulated log, without folder: the name of the experiment's log with the extension
    /// `csv`.
    #[must_use]
    pub fn name(&self) -> PathBuf {
        let mut name = PathBuf::from(self.named.file_name().unwrap_or("simulated".as_ref()));
        if name
            .extension()
            .is_some_and(|end| end == "gz" || end == "zst")
        {
            name.set_extension("");
        }
        name.with_extension("csv")
    }

    /// Returns the true parameters by name.
    #[must_use]
    pub fn truth(&self) -> BTreeMap<String, f64> {
        (self.model.parameters().iter().zip(&self.theta))
            .map(|(parameter, value)| (parameter.name.clone(), *value))
            .collect()
    }

    /// Simulates the twin and writes its log with the columns of the experiment. Returns the number
    /// of samples.
    ///
    /// # Errors
    ///
    /// [`SessionError::Record`] if the loop cannot be simulated, the log cannot be written, or the
    /// caller stops the run.
    pub fn write(
        &self,
        write: impl Write,
        progress: &mut dyn Listener,
    ) -> Result<u64, SessionError> {
        let twin = TwinSetup {
            model: &self.model,
            theta: &self.theta,
            controller: self.controller,
            settings: &self.settings,
        };
        Ok(record(&twin, &self.channels, write, progress)?)
    }
}
