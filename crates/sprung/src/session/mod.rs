//! Works on an experiment and its logs, from files to results, without a terminal.
//!
//! A [`Session`] reads an experiment, opens the files that it names, and checks, identifies,
//! validates and simulates. [`compare_files`] reads and compares results. Only this module of the
//! library opens files: with [`Disk`], or with any other [`Files`] of the caller, for example bytes
//! in memory. Methods that end in `_with` take logs without files, as
//! [`LogSource`](crate::log::LogSource)s.
//!
//! Every method reports its progress to a [`Listener`](crate::progress::Listener), which may stop
//! it. No method changes its session or writes a file. A stopped run returns no result and leaves
//! earlier results unchanged.

mod arrays;
mod bag;
mod check;
mod compare;
mod control;
mod control_code;
mod control_error;
mod described;
mod earlier_formats;
mod error;
mod excite;
mod excite_error;
mod expected;
mod experiment_path;
mod export;
mod export_samples;
mod files;
mod from_log;
mod identify;
mod load;
mod logs;
mod parameters;
mod results;
mod results_schema;
mod sample;
mod servo;
mod simulate;
mod start;
mod stream;
mod switch;
mod usability;
mod validate;
mod watch;

pub use arrays::QuantityArrays;
pub use compare::{ComparedFiles, compare_files};
pub use control::controller_toml;
pub use control_code::{read_control, read_watch};
pub use described::{Described, split_remedy};
pub use error::{ErrorKind, SessionError};
pub use excite::{ExciteMethod, ExciteRequest, excitation_files};
pub use expected::ExpectedError;
pub use experiment_path::EXPERIMENT_FILE;
pub use export::ExportRequest;
pub use export_samples::SampledRobots;
pub use files::{Disk, Files};
pub use from_log::{NewExperiment, start_from_logs};
pub use load::Session;
pub use parameters::Parameters;
pub use results::{
    IDENTIFICATION_FILE, ReadIdentification, ReadValidation, find_identification,
    read_identification, read_results,
};
pub use results_schema::results_schema;
pub use sample::SampleRequest;
pub use servo::ServoRecording;
pub use simulate::Recording;
pub use start::start_from_urdf;
pub use switch::{SWITCH_FILE, Switch, TEMPORARY_NAME, finish};
pub use usability::Usability;
pub use watch::WatchRequest;
