//! Errors of a session, and their kinds.

use std::path::PathBuf;

use super::control_error::ControlError;
use super::excite_error::ExciteError;
use sprung_base::finding::Finding;
use sprung_base::progress::Stopped;
use sprung_export::ExportError;
use sprung_log::{ArraysError, ChannelError, ChooseError, LogError};
use sprung_method::compare::CompareError;
use sprung_method::estimate::{IdentifyError, PosteriorError};
use sprung_method::prepare::PrepareError;
use sprung_method::regression::PassError;
use sprung_method::simulate::RecordError;
use sprung_method::validate::ValidateError;
use sprung_model::ModelError;
use sprung_robot::{DescriptionError, NotSupported, OwnCall, StartError, UrdfError};
use sprung_servo::ServoError;

/// Cause of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The experiment file or the request is wrong.
    Usage,
    /// A log is wrong.
    Log,
    /// A file cannot be read or written.
    File,
    /// The caller stopped the run.
    Stopped,
}

/// An error of a session.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SessionError {
    /// Another file was given instead of an experiment file.
    #[error("{file} is {what}, not an experiment file; {remedy}")]
    NotAnExperiment {
        /// Name of the file.
        file: String,
        /// Kind of the file.
        what: &'static str,
        /// Remedy.
        remedy: String,
    },
    /// There is no experiment file.
    #[error("there is no experiment file {file}; {remedy}")]
    NoExperiment {
        /// Name of the file.
        file: String,
        /// Remedy.
        remedy: String,
    },
    /// Several folders of results belong to one folder of experiments.
    #[error(
        "{} has several folders of results; give one of them: {}",
        .folder.display(),
        .found.join(", ")
    )]
    SeveralResults {
        /// The folder.
        folder: PathBuf,
        /// Folders of results.
        found: Vec<String>,
    },
    /// A text file cannot be read.
    #[error("cannot read {file}: {source}")]
    Unreadable {
        /// Name of the file.
        file: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The experiment file is wrong.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// No equations can be formed for the robot.
    #[error("{file}: {error}")]
    Robot {
        /// Name of the experiment file.
        file: String,
        /// Error of the model.
        error: ModelError,
    },
    /// The experiment has no log.
    #[error("the experiment has no [log]; add it and name the columns of the log")]
    NoLog,
    /// The log has no file.
    #[error(
        "the experiment does not name the file of the log; give file in [log], or --set log.file=FILE"
    )]
    NoLogFile,
    /// The log cannot be checked.
    #[error(transparent)]
    Check(#[from] PrepareError),
    /// The parameters cannot be identified.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// Parameters cannot be validated.
    #[error(transparent)]
    Validate(#[from] ValidateError),
    /// A file contains no parameters.
    #[error(
        "{file} is not a file of parameters: {why}; give an identification.json, or a TOML file with lines such \
         as \"joint1.stiffness\" = 9.4"
    )]
    NotParameters {
        /// Name of the file.
        file: String,
        /// Fault of the file.
        why: String,
    },
    /// A file contains no identification.
    #[error("{file} is not an identification: {why}")]
    NotAnIdentification {
        /// Name of the file.
        file: String,
        /// Fault of the file, and the remedy.
        why: String,
    },
    /// A file was written by a newer version of sprung.
    #[error(
        "{file} has format {format}, written by {generator}; this is sprung {}, which reads format \
         {known}: use a newer version of sprung",
        env!("CARGO_PKG_VERSION")
    )]
    NewerFormat {
        /// Name of the file.
        file: String,
        /// Format of the file.
        format: u64,
        /// Program that wrote the file.
        generator: String,
        /// Newest format that this version reads.
        known: u64,
    },
    /// A folder contains no identification.
    #[error(
        "there is no identification.json in the folder {}, nor in its sprung-out; run sprung identify \
         first",
        .folder.display()
    )]
    NoIdentification {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder contains no identification to validate.
    #[error(
        "there is no identification.json in {}; run sprung identify first, or give --parameters FILE",
        .folder.display()
    )]
    NothingIdentified {
        /// The folder that was searched first.
        folder: PathBuf,
    },
    /// A file would be compared with itself.
    #[error("{} is given twice; give each file once", .file.display())]
    GivenTwice {
        /// The file.
        file: PathBuf,
    },
    /// The name of arrays is no quantity.
    #[error(
        "\"{name}\" is neither a column of [log] nor a quantity; the quantities are t, q, phi, tau, \
         tau_joint and the keys of [log], such as motor_current_a"
    )]
    NotAQuantity {
        /// The name.
        name: String,
    },
    /// A quantity has a wrong number of columns.
    #[error(
        "\"{name}\" has {found} columns; give one for each of these: {}", .joints.join(", ")
    )]
    QuantityColumns {
        /// The quantity.
        name: String,
        /// Number of its columns.
        found: usize,
        /// Names of its joints.
        joints: Vec<String>,
    },
    /// Arrays cannot form a log.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// Results cannot be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// The experiment describes no digital twin.
    #[error("the experiment has no [simulate] block; add one")]
    NoTwin,
    /// The twin measures without errors, so its standard errors are zero.
    #[error(
        "the twin measures exactly, so its log has no standard errors; add {missing} to [simulate]"
    )]
    ExactTwin {
        /// The missing key.
        missing: &'static str,
    },
    /// A log is too short for standard errors.
    #[error("the simulated log is too short for standard errors; raise duration_s in [simulate]")]
    NoBound,
    /// No experiment can be designed.
    #[error(transparent)]
    Excite(#[from] ExciteError),
    /// No controller can be designed.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The experiment has no validation run of this name.
    #[error("no [[validate]] block is called \"{name}\"; the blocks are: {}", .known.join(", "))]
    NoRun {
        /// The requested name.
        name: String,
        /// Names of the existing runs.
        known: Vec<String>,
    },
    /// The experiment has no controller that moves the twin.
    #[error("the experiment has no [controller]; a twin needs one to move")]
    NoController,
    /// The description of the twin's log is incomplete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// The parameters do not match the robot.
    #[error(transparent)]
    Parameters(#[from] ModelError),
    /// The log of the twin cannot be simulated or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Parameters come from no identification, so they have no errors.
    #[error(
        "these parameters have no covariance, so no robots can be drawn from them; give the identification.json of sprung \
         identify"
    )]
    NoPosterior,
    /// A file is no watch.
    #[error("{file} is no watch.json of sprung watch: {why}")]
    NoWatch {
        /// The file.
        file: String,
        /// Reason.
        why: String,
    },
    /// An identification has fewer results.
    #[error("the identification has {count} result{}, so there is no result {set}; the first one is result 0",
        if *count == 1 { "" } else { "s" }
    )]
    NoResult {
        /// The requested result, from 0.
        set: usize,
        /// Number of results.
        count: usize,
    },
    /// The verdict on a result is *unusable*.
    #[error(
        "the verdict on the result of {estimator} is unusable{}; follow the remedies of its findings and identify again, or \
         accept unusable results",
        if .because.is_empty() { String::new() } else { format!(", because {because}") }
    )]
    UnusableResult {
        /// Name of the estimator.
        estimator: String,
        /// The reasons, as clauses; may be empty.
        because: String,
    },
    /// No robots can be drawn.
    #[error(transparent)]
    Posterior(#[from] PosteriorError),
    /// The robot cannot be exported.
    #[error(transparent)]
    Export(Box<ExportError>),
    /// The parameters of a servo cannot be identified.
    #[error(transparent)]
    Servo(#[from] ServoError),
    /// A task does not work with the robot or its logs.
    #[error(transparent)]
    NotSupported(#[from] NotSupported),
    /// A servo has separate calls.
    #[error(transparent)]
    IsServo(#[from] OwnCall),
    /// The experiment describes no servo.
    #[error("the experiment describes no servo; add [robot.joint.servo] to its joint")]
    NoServo,
    /// Logs are given in place of files that carry payloads, and their number differs.
    #[error(
        "{given} logs are given, and the experiment names {named} files with payloads; give a log for each \
         file, in their order"
    )]
    PayloadLogs {
        /// Number of given logs.
        given: usize,
        /// Number of files that the experiment names.
        named: usize,
    },
    /// The experiment describes no target that moves the twin of a servo.
    #[error(
        "the experiment has no target in [simulate]; a servo needs one to move, as a sum of sines"
    )]
    NoTarget,
    /// Parameters of a servo are missing.
    #[error("the parameters of the servo's twin lack {}; add them to the file of parameters", .names.join(", "))]
    LacksServoParameters {
        /// Names of the parameters.
        names: Vec<String>,
    },
    /// A URDF file is wrong.
    #[error(transparent)]
    Urdf(#[from] UrdfError),
    /// The folder of a file cannot be found.
    #[error("cannot find the folder of {}: {source}", .file.display())]
    NoFolder {
        /// The file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// An experiment file cannot contain a path, because the path is not Unicode.
    #[error(
        "the path {} is not Unicode, so experiment.toml cannot contain it; rename it",
        .path.display()
    )]
    NotUnicode {
        /// The path.
        path: PathBuf,
    },
    /// The columns of a log cannot be assigned to joints.
    #[error(transparent)]
    Choose(#[from] ChooseError),
    /// A log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Two logs of one experiment have different columns.
    #[error(
        "{file} has no \"{column}\", which {first} has; the logs of one experiment must have the same columns, and the files of \
         one recording must run at the same times and differ in all columns but the time"
    )]
    OtherColumns {
        /// Name of the log.
        file: String,
        /// Name of the column.
        column: String,
        /// Name of the first log.
        first: String,
    },
    /// No experiment file can be made for a robot.
    #[error(transparent)]
    Start(#[from] StartError),
    /// An interrupted run left results partly in place, and they cannot be completed.
    #[error(
        "cannot {what} in {}: {source}; this folder may contain files of two runs until a later \
         command completes this step",
        .folder.display()
    )]
    Unfinished {
        /// The step that failed.
        what: String,
        /// The folder of the results.
        folder: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The list of pending renames is damaged.
    #[error(
        "{} is not a valid list of files; remove it, and repeat the command that wrote the results \
         in its folder",
        .list.display()
    )]
    NoSwitch {
        /// Path of the list.
        list: PathBuf,
    },
    /// The caller stopped the run.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<ExportError> for SessionError {
    fn from(error: ExportError) -> Self {
        Self::Export(Box::new(error))
    }
}

impl SessionError {
    /// Returns the findings for which a log was refused; empty for other errors.
    #[must_use]
    pub fn findings(&self) -> &[Finding] {
        match self {
            Self::Identify(IdentifyError::Refused(refusal)) => &refusal.0,
            _ => &[],
        }
    }

    /// Returns the kind of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Check(error) => of_check(error),
            Self::Identify(error) => of_identify(error),
            Self::Validate(error) => match error {
                ValidateError::Pass(pass) => of_pass(pass),
                ValidateError::Stopped(_) => ErrorKind::Stopped,
                ValidateError::OtherRate { .. } => ErrorKind::Log,
                _ => ErrorKind::Usage,
            },
            Self::Record(error) => match error {
                RecordError::Write(_) => ErrorKind::File,
                RecordError::Stopped(_) => ErrorKind::Stopped,
                _ => ErrorKind::Usage,
            },
            Self::Description(DescriptionError::Unreadable { .. })
            | Self::Unreadable { .. }
            | Self::NoExperiment { .. }
            | Self::NoIdentification { .. }
            | Self::NothingIdentified { .. }
            | Self::NoFolder { .. }
            | Self::Unfinished { .. }
            | Self::NoSwitch { .. } => ErrorKind::File,
            Self::Stopped(_) => ErrorKind::Stopped,
            Self::Arrays(_) => ErrorKind::Log,
            Self::Log(error) => of_log(error),
            Self::Servo(error) => match error {
                ServoError::Log(log) => of_log(log),
                ServoError::Stopped(_) => ErrorKind::Stopped,
                _ => ErrorKind::Log,
            },
            // The experiment file or the request is wrong.
            _ => ErrorKind::Usage,
        }
    }
}

fn of_check(error: &PrepareError) -> ErrorKind {
    match error {
        PrepareError::Log(log) => of_log(log),
        PrepareError::Stopped(_) => ErrorKind::Stopped,
        _ => ErrorKind::Usage,
    }
}

fn of_identify(error: &IdentifyError) -> ErrorKind {
    match error {
        IdentifyError::Pass(pass) => of_pass(pass),
        IdentifyError::NotFinite { .. } | IdentifyError::Refused(_) => ErrorKind::Log,
        IdentifyError::Stopped(_) => ErrorKind::Stopped,
        _ => ErrorKind::Usage,
    }
}

fn of_pass(error: &PassError) -> ErrorKind {
    match error {
        PassError::Log(log) => of_log(log),
        PassError::Stopped(_) => ErrorKind::Stopped,
        _ => ErrorKind::Usage,
    }
}

fn of_log(error: &LogError) -> ErrorKind {
    match error {
        LogError::Io { .. } => ErrorKind::File,
        _ => ErrorKind::Log,
    }
}
