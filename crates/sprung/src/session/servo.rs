//! Checks, identifies and simulates a position servo.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::error::SessionError;
use super::load::Session;
use super::parameters::Parameters;
use sprung_base::finding::Finding;
use sprung_base::progress::Listener;
use sprung_export::Format;
use sprung_log::{Channels, LogSource};
use sprung_method::simulate::Trajectory;
use sprung_robot::{FilePart, OwnCall, Simulate, Task, refuse_task};
use sprung_servo::{
    Bench, Records, ServoExpectation, ServoIdentification, ServoTwin, expect, identify, named,
    read, record_servo, truth,
};

/// Logs of a servo that are ready to be simulated, one for each file of the log.
#[derive(Debug)]
pub struct ServoRecording<'a> {
    session: &'a Session,
    bench: Bench,
    channels: Channels,
    settings: Simulate,
    values: [f64; sprung_core::servo::ServoParameter::COUNT],
    files: Vec<PathBuf>,
}

impl Session {
    /// Returns whether the experiment describes a position servo, whose log has targets and no
    /// torque.
    #[must_use]
    pub fn is_servo(&self) -> bool {
        self.servo_joint().is_some()
    }

    /// Returns the name of the joint of the servo.
    pub(super) fn servo_joint(&self) -> Option<String> {
        let mut joints = self.experiment().robot.joint.iter();
        let servo = joints.find(|joint| joint.servo.is_some());
        servo.map(|joint| joint.name.clone())
    }

    /// Refuses a task that does not work with the robot or its log.
    pub(super) fn allow(&self, task: Task) -> Result<(), SessionError> {
        let experiment = self.experiment();
        Ok(refuse_task(
            &experiment.robot,
            experiment.log.as_ref(),
            task,
        )?)
    }

    /// Refuses a validation that does not work, before its parameters are read.
    ///
    /// # Errors
    ///
    /// [`SessionError::NotSupported`].
    pub fn allow_validation(&self) -> Result<(), SessionError> {
        self.allow(Task::Validate)
    }

    /// Refuses an export that does not work, before its parameters are read.
    ///
    /// # Errors
    ///
    /// [`SessionError::NotSupported`].
    pub fn allow_export(&self, format: Format) -> Result<(), SessionError> {
        self.allow(if format.is_code() {
            Task::ExportCode
        } else {
            Task::ExportRobot
        })
    }

    /// Refuses a call whose result has another type for servos.
    pub(super) fn no_servo(&self, task: Task) -> Result<(), SessionError> {
        match self.servo_joint() {
            None => Ok(()),
            Some(joint) => Err(OwnCall::new(joint, task).into()),
        }
    }

    /// Returns the bench and the channels of the servo.
    fn bench(&self, files: &[FilePart]) -> Result<(Bench, Channels), SessionError> {
        let log = self.log(None)?;
        let bench = Bench::new(self.experiment(), files).ok_or(SessionError::NoServo)?;
        Ok((bench, Channels::of_servo(&self.experiment().robot, &log)?))
    }

    /// Identifies the parameters of a position servo from the logs that the experiment names.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the experiment describes no servo, or if the description or a log is
    /// wrong.
    pub fn identify_servo(
        &self,
        progress: &mut dyn Listener,
    ) -> Result<ServoIdentification, SessionError> {
        let mut logs = self.logs(None)?;
        self.identify_servo_with(&mut logs.sources(), progress)
    }

    /// Identifies the parameters of a position servo from other logs with the same columns. The payload
    /// of each log is that of the file at its place in the experiment.
    ///
    /// # Errors
    ///
    /// The errors of [`identify_servo`](Self::identify_servo), and [`SessionError::PayloadLogs`] if the
    /// experiment names payloads and another number of logs.
    pub fn identify_servo_with(
        &self,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<ServoIdentification, SessionError> {
        let (bench, records) = self.records(sources, progress)?;
        Ok(identify(&bench, &records, progress)?)
    }

    /// Returns the parameters that the logs of a position servo determine, before any fit: first
    /// values with their smallest possible errors, and findings.
    ///
    /// # Errors
    ///
    /// The errors of [`identify_servo`](Self::identify_servo).
    pub fn check_servo(
        &self,
        progress: &mut dyn Listener,
    ) -> Result<(Vec<ServoExpectation>, Vec<Finding>), SessionError> {
        let mut logs = self.logs(None)?;
        self.check_servo_with(&mut logs.sources(), progress)
    }

    /// Returns the parameters that other logs with the same columns determine.
    ///
    /// # Errors
    ///
    /// The errors of [`identify_servo_with`](Self::identify_servo_with).
    pub fn check_servo_with(
        &self,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<(Vec<ServoExpectation>, Vec<Finding>), SessionError> {
        let (bench, records) = self.records(sources, progress)?;
        Ok(expect(&bench, &records)?)
    }

    fn records(
        &self,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<(Bench, Records), SessionError> {
        let log = self.log(None)?;
        let files: Vec<FilePart> = log.file.iter().flatten().cloned().collect();
        self.payloads(sources.len())?;
        let (bench, channels) = self.bench(&files)?;
        let records = read(&bench, &channels, sources, progress)?;
        Ok((bench, records))
    }

    /// Prepares the twin of a position servo: one log for each file of the experiment, with the
    /// payload of that file.
    ///
    /// - `parameters`: parameters of the twin; those of the `[simulate]` block if absent.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the experiment lacks the twin, its target, its parameters or the
    /// description of its log.
    pub fn servo_twin(
        &self,
        parameters: Option<&Parameters>,
    ) -> Result<ServoRecording<'_>, SessionError> {
        let experiment = self.experiment();
        let settings = experiment.simulate.clone().ok_or(SessionError::NoTwin)?;
        let files = self.log_files(None)?;
        let (bench, channels) = self.bench(&files)?;
        if settings.target.is_none() {
            return Err(SessionError::NoTarget);
        }
        let of_block = match (parameters, &settings.parameters) {
            (None, Some(file)) => Some(Parameters::from_file(
                &*self.files,
                &self.folder.join(file),
            )?),
            _ => None,
        };
        let set = parameters
            .or(of_block.as_ref())
            .and_then(|all| all.sets.first());
        let values = set.map(|set| set.values.clone()).unwrap_or_default();
        let values =
            truth(&bench, &values).map_err(|names| SessionError::LacksServoParameters { names })?;
        Ok(ServoRecording {
            session: self,
            bench,
            channels,
            settings,
            values,
            files: files.into_iter().map(|file| file.path).collect(),
        })
    }
}

impl ServoRecording<'_> {
    /// Returns the twin with another random seed for its sensor and its disturbance.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.settings.seed = seed;
        self
    }

    /// Returns the parameters of the twin by name.
    #[must_use]
    pub fn truth(&self) -> BTreeMap<String, f64> {
        named(&self.bench, &self.values)
    }

    /// Returns the paths at which the experiment names the logs.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Simulates one log and writes it as CSV with the columns of the experiment. Returns the number
    /// of samples.
    ///
    /// - `index`: index in [`files`](Self::files).
    ///
    /// # Errors
    ///
    /// [`SessionError::Record`] if the log cannot be written or the caller stops the run.
    pub fn write(
        &self,
        index: usize,
        write: impl std::io::Write,
        progress: &mut dyn Listener,
    ) -> Result<u64, SessionError> {
        let reference = self.settings.target.clone().unwrap_or_default();
        let twin = ServoTwin {
            bench: &self.bench,
            load: self.bench.loads.get(index).copied().unwrap_or_default(),
            values: self.values,
            settings: &self.settings,
            target: Trajectory::new(&reference, self.session.model()),
            channels: &self.channels,
            seed: self
                .settings
                .seed
                .wrapping_mul(1000)
                .wrapping_add(index as u64),
        };
        Ok(record_servo(&twin, write, progress)?)
    }
}
