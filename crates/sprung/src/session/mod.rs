//! An experiment and its logs, from files to results, without a terminal.
//!
//! A [`Session`] reads an experiment, opens the files that it names, and checks, identifies,
//! validates and simulates; [`compare_files`] reads results and compares them. It is the one place
//! of the library that opens files: through [`Disk`], or through whatever [`Files`] the caller
//! gives, as bytes in memory. Logs that are no files are given as
//! [`LogSource`](crate::log::LogSource)s to the verbs that end in `_with`.
//!
//! Every verb takes a [`Listener`](crate::progress::Listener), which hears how far it is and may stop
//! it. A verb changes nothing in its session and writes no file: one that was stopped leaves no
//! result, and earlier ones are as they were.

mod bag;
mod check;
mod compare;
mod error;
mod files;
mod identify;
mod load;
mod logs;
mod parameters;
mod results;
mod simulate;
mod start;
mod switch;
mod usability;
mod validate;

pub use check::Depth;
pub use compare::{ComparedFiles, compare_files};
pub use error::{ErrorKind, SessionError};
pub use files::{Disk, Files};
pub use load::Session;
pub use parameters::Parameters;
pub use results::{
    IDENTIFICATION_FILE, ReadIdentification, find_identification, read_identification,
};
pub use simulate::Recording;
pub use start::start_from_urdf;
pub use switch::{SWITCH_FILE, Switch, finish};
pub use usability::Usability;
