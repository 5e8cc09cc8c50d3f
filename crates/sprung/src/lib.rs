//! Identifies the dynamic parameters of flexible-joint robots from logs.
//!
//! A [`session::Session`] checks, identifies, validates and simulates an experiment, without a
//! terminal. It opens the files of the experiment; with [`session::Session::read`] the caller opens
//! them. Columns in memory can replace a log file ([`log::LogSource::arrays`] with
//! [`session::Session::identify_with`]). A closure in place of [`progress::Unheard`] receives the
//! progress of a verb and may stop it.
//!
//! ```
//! use std::{io::Cursor, path::Path};
//! use sprung::{demo, log::Input, progress::Unheard, session::Session};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // `Session::open(Path::new("my-arm"), &[])` reads the disk; here all files are in memory.
//! let in_memory = |bytes: Vec<u8>| move |_: &Path| Ok(Box::new(Cursor::new(bytes.clone())) as Box<dyn Input>);
//!
//! // A log to identify from: that of a simulated robot with known parameters.
//! let twin = Session::read("demo", demo::EXPERIMENT, &[], in_memory(demo::TRUTH.into()))?;
//! let mut csv = Vec::new();
//! twin.twin(None, None)?.write(&mut csv, &mut Unheard)?;
//!
//! // `--set` of the command line changes a key here too; without this line the refinement follows.
//! let set = ["identify.estimator=least-squares".to_owned()];
//! let session = Session::read("demo", demo::EXPERIMENT, &set, in_memory(csv))?;
//! let found = session.identify(&mut Unheard)?;
//! let result = &found.identification.results[0];
//! println!("{}", result.decision.sentence);
//! let stiffness = result.parameter("joint1.stiffness").unwrap().value.unwrap();
//! assert!((stiffness - 9.3587).abs() < 0.1);
//! # Ok(())
//! # }
//! ```
//!
//! The folder `docs` of the repository describes the experiment file, the results and the method. The
//! crate `sprung-core` contains the physics, the
//! filters and the on-line estimator. It uses neither the standard library nor allocation, so it can
//! run on a controller.
//!
//! # Structure
//!
//! Data flow in one direction: a module uses only the modules to its left.
//!
//! ```text
//! limits, foreign, finding, curves, named, explanation, numbers, progress, sha256, stopwatch |
//! description → model → log → simulate → preprocess → regression → fit → prepare → unknowns → frequency → check → estimate → validate → compare → excite → export → servo → session → report
//! ```
//!
//! Functions outside [`session`] take values and readers and return values or strings. The library
//! prints nothing. It uses SI units and radians internally.

pub mod session;

/// Texts of files in messages.
pub mod foreign {
    #[doc(inline)]
    pub use sprung_base::foreign::{escaped, shortened};
}

/// Checks a log before an identification.
pub mod check {
    #[doc(inline)]
    pub use sprung_method::check::{CheckReport, Checked, CheckedLog};
    #[doc(inline)]
    pub use sprung_method::unknowns::{AddedLaw, CompetingUnknown, UnknownResult, UnknownStatus};
}

/// Compares results of several estimators, settings or runs of one robot.
pub mod compare {
    #[doc(inline)]
    pub use sprung_method::compare::{
        CombinedResult, Compared, ComparedParameter, Comparison, Drift, compare,
    };
}

/// Designed controllers: gains, margins, vibrations, shapers and their proof.
pub mod control {
    #[doc(inline)]
    pub use sprung_method::control::{ControlDesign, Controlled, Motors, WithDraws};
}

/// Decimated time series for files and plots.
pub mod curves {
    #[doc(inline)]
    pub use sprung_base::curves::Curves;
}

/// The experiment of the founding paper, ready to run.
pub mod demo {
    #[doc(inline)]
    pub use sprung_base::demo::{EXPERIMENT, TRUTH};
}

/// The experiment file: the robot, the log, and the settings of identification and validation.
pub mod description {

    #[doc(inline)]
    pub use sprung_robot::{Experiment, Language, Start, refusals, schema, what_works};
}

/// Estimators: from the regression of the logs to parameters, standard errors, findings and a
/// verdict.
pub mod estimate {
    #[doc(inline)]
    pub use sprung_method::estimate::{
        EstimateResult, Identification, Identified, IdentifyError, ParameterEstimate, Refinement,
        Samples, Verdict, parameters_csv,
    };
}

/// Designed experiments: motions, limits and promises.
pub mod excite {
    #[doc(inline)]
    pub use sprung_method::excite::{Excitation, Excited, Trajectory};
}

/// Writes an identified robot for simulators and controllers, and proves the file by reading it
/// back.
pub mod export {
    #[doc(inline)]
    pub use sprung_export::{
        Earlier, Exported, Form, Format, MujocoFields, MujocoNames, Proof, Said, earlier,
    };
}

/// Findings: observations that the user must know, with evidence and remedy.
pub mod finding {
    #[doc(inline)]
    pub use sprung_base::explanation::Explanation;
    #[doc(inline)]
    pub use sprung_base::finding::{Finding, GENERATOR, Severity};
}

/// Measured logs, read and written block by block in SI units.
pub mod log {
    #[doc(inline)]
    pub use sprung_log::{Array, Arrays, Input, LogError, LogSource, panics_are_caught};
}

/// Turns the description of a robot into its parameters and equations.
pub mod model {
    #[doc(inline)]
    pub use sprung_model::{Model, Parameter, short};
}

/// Named values in a fixed order, base joint first.
pub mod named {
    #[doc(inline)]
    pub use sprung_base::named::Named;
}

/// Progress of a run, and the caller's answer to it.
pub mod progress {
    #[doc(inline)]
    pub use sprung_base::progress::{Answer, Listener, Phase, Progress, Stopped, Unheard};
}

/// Reports as self-contained HTML files.
pub mod report {
    #[doc(inline)]
    pub use sprung_report::{
        Contents, Document, Figure, JointFigures, ShownUnknown, Style, compose, compose_check,
        compose_comparison, compose_control, compose_excitation, compose_servo, compose_watch,
        relative_scale, render, significant,
    };
}

/// A position servo on a pendulum: its parameters from logs of targets and positions, without any
/// torque.
pub mod servo {
    #[doc(inline)]
    pub use sprung_servo::{ServoExpectation, ServoIdentification, servo_parameters_csv};
}

/// The digital twin: plant, controller, sensors, amplifier.
pub mod simulate {
    #[doc(inline)]
    pub use sprung_method::simulate::{
        Accelerations, BothTorques, Dynamics, JointState, RecordError,
    };
}

/// Validates a model on logs: on the identification log itself and on others.
pub mod validate {
    #[doc(inline)]
    pub use sprung_method::validate::{
        JointProof, QuantityProof, RunResult, Validated, Validation,
    };
}

/// Watches a running robot with its identified model.
pub mod watch {
    #[doc(inline)]
    pub use sprung_method::watch::{Watch, WatchEvent, Watched};
}
