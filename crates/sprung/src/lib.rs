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
//! finding, curves, named, numbers, progress, sha256, stopwatch |
//! description → model → log → simulate → preprocess → regression → fit → prepare → frequency → check → estimate → validate → compare → export → servo → session → report
//! ```
//!
//! Functions outside [`session`] take values and readers and return values or strings. The library
//! prints nothing. It uses SI units and radians internally.

pub mod check;
pub mod compare;
pub mod curves;
pub mod demo;
pub mod description;
pub mod estimate;
pub mod export;
pub mod finding;
mod fit;
mod frequency;
pub mod log;
pub mod model;
pub mod named;
mod numbers;
#[doc(hidden)]
pub mod prepare;
#[doc(hidden)]
pub mod preprocess;
pub mod progress;
#[doc(hidden)]
pub mod regression;
pub mod report;
pub mod servo;
pub mod session;
mod sha256;
pub mod simulate;
mod stopwatch;
pub mod validate;
