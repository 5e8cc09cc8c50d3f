//! Tasks, and their names in each language.

use crate::Estimator;

/// What sprung does with a robot and its logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The check of logs.
    Check,
    /// An identification with an estimator.
    Identify(Estimator),
    /// The validation on other logs.
    Validate,
    /// The digital twin.
    Simulate,
    /// The comparison of results.
    Compare,
    /// The export to URDF, MJCF, SDF and JSON.
    ExportRobot,
    /// The export of code.
    ExportCode,
    /// Torques, masses and accelerations of the identified robot.
    Dynamics,
}

/// A language in which sprung is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// The command line.
    CommandLine,
    /// The library in Rust.
    Library,
    /// The Python package.
    Python,
    /// The exported code in C.
    C,
    /// The exported code in Rust.
    Rust,
}

impl Language {
    /// All languages.
    pub const ALL: [Self; 5] = [
        Self::CommandLine,
        Self::Library,
        Self::Python,
        Self::C,
        Self::Rust,
    ];

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::CommandLine => "command line",
            Self::Library => "library",
            Self::Python => "Python",
            Self::C => "C code",
            Self::Rust => "Rust code",
        }
    }
}

/// A call for robots on a servo, whose results have another type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.text(Language::Library))]
pub struct OwnCall {
    joint: String,
    task: Task,
}

impl OwnCall {
    /// Returns the fault of a task that was asked for a robot with this joint on a servo.
    #[must_use]
    pub const fn new(joint: String, task: Task) -> Self {
        Self { joint, task }
    }

    /// Returns the fault and the call for servos in a language.
    #[must_use]
    pub fn text(&self, language: Language) -> String {
        let joint = &self.joint;
        let call = self.task.call_of_servo(language).unwrap_or("sprung");
        format!("{joint} is a position servo, whose results have another type; use {call}")
    }
}

impl Task {
    /// Number of tasks.
    pub(crate) const COUNT: usize = 10;

    /// All tasks, in the order of the page.
    pub(crate) const ALL: [Self; Self::COUNT] = [
        Self::Check,
        Self::Identify(Estimator::LeastSquares),
        Self::Identify(Estimator::Lsff),
        Self::Identify(Estimator::PredictionError),
        Self::Validate,
        Self::Simulate,
        Self::Compare,
        Self::ExportRobot,
        Self::ExportCode,
        Self::Dynamics,
    ];

    /// Returns its place in [`Task::ALL`].
    pub(crate) const fn place(self) -> usize {
        match self {
            Self::Check => 0,
            Self::Identify(Estimator::LeastSquares) => 1,
            Self::Identify(Estimator::Lsff) => 2,
            Self::Identify(Estimator::PredictionError) => 3,
            Self::Validate => 4,
            Self::Simulate => 5,
            Self::Compare => 6,
            Self::ExportRobot => 7,
            Self::ExportCode => 8,
            Self::Dynamics => 9,
        }
    }

    /// Returns its name in messages and on the page.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Identify(estimator) => format!("estimator \"{}\"", estimator.name()),
            Self::Check => "check".to_owned(),
            Self::Validate => "validate".to_owned(),
            Self::Simulate => "simulate".to_owned(),
            Self::Compare => "compare".to_owned(),
            Self::ExportRobot => "export to URDF, MJCF, SDF or JSON".to_owned(),
            Self::ExportCode => "export of code".to_owned(),
            Self::Dynamics => "the model's dynamics".to_owned(),
        }
    }

    /// Returns how the task is called for a position servo; `None` if the language or the servo does not
    /// have it.
    pub(crate) const fn call_of_servo(self, language: Language) -> Option<&'static str> {
        match (self, language) {
            (Self::Check, Language::CommandLine) => Some("sprung check"),
            (Self::Check, Language::Library) => Some("Session::check_servo"),
            (Self::Check, Language::Python) => Some("sprung.Servo.check"),
            (Self::Identify(_), Language::CommandLine) => Some("sprung identify"),
            (Self::Identify(_), Language::Library) => Some("Session::identify_servo"),
            (Self::Identify(_), Language::Python) => Some("sprung.Servo.identify"),
            (Self::Simulate, Language::CommandLine) => Some("sprung simulate"),
            (Self::Simulate, Language::Library) => Some("Session::servo_twin"),
            (Self::Simulate, Language::Python) => Some("sprung.Servo.simulate"),
            (Self::Check | Self::Identify(_) | Self::Simulate, Language::C | Language::Rust)
            | (
                Self::Validate
                | Self::Compare
                | Self::ExportRobot
                | Self::ExportCode
                | Self::Dynamics,
                _,
            ) => None,
        }
    }

    /// Returns how the task is called in a language; `None` if the language does not have it.
    pub(crate) const fn call(self, language: Language) -> Option<&'static str> {
        match language {
            Language::CommandLine => match self {
                Self::Check => Some("sprung check"),
                Self::Identify(_) => Some("sprung identify"),
                Self::Dynamics => None,
                Self::Validate => Some("sprung validate"),
                Self::Simulate => Some("sprung simulate"),
                Self::Compare => Some("sprung compare"),
                Self::ExportRobot | Self::ExportCode => Some("sprung export"),
            },
            Language::Library => Some(match self {
                Self::Check => "Session::check",
                Self::Identify(_) => "Session::identify",
                Self::Validate => "Session::validate",
                Self::Simulate => "Session::twin",
                Self::Compare => "compare::compare",
                Self::ExportRobot | Self::ExportCode => "Session::export",
                Self::Dynamics => "Session::dynamics",
            }),
            Language::Python => Some(match self {
                Self::Check => "Experiment.check",
                Self::Identify(_) => "Experiment.identify",
                Self::Validate => "Result.validate",
                Self::Simulate => "Experiment.simulate",
                Self::Compare => "sprung.compare",
                Self::ExportRobot | Self::ExportCode => "Result.export",
                Self::Dynamics => "Result.model",
            }),
            Language::C | Language::Rust => match self {
                Self::Dynamics => Some("functions of the exported file"),
                Self::Check
                | Self::Identify(_)
                | Self::Validate
                | Self::Simulate
                | Self::Compare
                | Self::ExportRobot
                | Self::ExportCode => None,
            },
        }
    }
}
