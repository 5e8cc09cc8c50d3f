//! Checks, identifies and simulates a position servo.

use std::path::PathBuf;

use super::error::SessionError;
use super::load::Session;
use super::parameters::Parameters;
use crate::description::Simulate;
use crate::finding::Finding;
use crate::log::Channels;
use crate::progress::Listener;
use crate::servo::{
    Bench, ServoExpectation, ServoIdentification, ServoTwin, expect, identify, read, record_servo,
    truth,
};
use crate::simulate::Trajectory;

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
        self.experiment()
            .robot
            .joint
            .iter()
            .any(|joint| joint.servo.is_some())
    }

    /// Refuses a verb that does not work on servos.
    ///
    /// - `verb`: its name, for the message.
    ///
    /// # Errors
    ///
    /// [`SessionError::NotForServos`] if the experiment describes a servo.
    pub fn no_servo(&self, verb: &'static str) -> Result<(), SessionError> {
        let servo = (self.experiment().robot.joint.iter()).find(|joint| joint.servo.is_some());
        match servo {
            None => Ok(()),
            Some(joint) => Err(SessionError::NotForServos {
                joint: joint.name.clone(),
                verb,
            }),
        }
    }

    /// Returns the bench and the channels of the servo.
    fn bench(&self) -> Result<(Bench, Channels), SessionError> {
        let log = self.log(None)?;
        let files = self.log_files(None)?;
        let bench = Bench::new(self.experiment(), &files).ok_or(SessionError::NoLog)?;
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
        let (bench, channels) = self.bench()?;
        let mut logs = self.logs(None)?;
        let records = read(&bench, &channels, &mut logs.sources(), progress)?;
        Ok(identify(&bench, &records, progress)?)
    }

    /// Returns what the logs of a position servo can tell, before any fit: first values with their
    /// smallest possible errors, and findings.
    ///
    /// # Errors
    ///
    /// The errors of [`identify_servo`](Self::identify_servo).
    pub fn check_servo(
        &self,
        progress: &mut dyn Listener,
    ) -> Result<(Vec<ServoExpectation>, Vec<Finding>), SessionError> {
        let (bench, channels) = self.bench()?;
        let mut logs = self.logs(None)?;
        let records = read(&bench, &channels, &mut logs.sources(), progress)?;
        Ok(expect(&bench, &records)?)
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
        let (bench, channels) = self.bench()?;
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
        let files = self.log_files(None)?.into_iter();
        Ok(ServoRecording {
            session: self,
            bench,
            channels,
            settings,
            values,
            files: files.map(|file| file.path).collect(),
        })
    }
}

impl ServoRecording<'_> {
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
