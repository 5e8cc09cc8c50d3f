//! Reports as self-contained HTML files.
//!
//! [`compose`] creates the contents of a report, and [`render`] writes it as HTML.
//!
//! This crate is internal to `sprung`. Its items may change in any version; use the crate `sprung`, which re-exports the
//! public names.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod check;
mod comparison;
mod compose;
mod contents;
mod control;
mod document;
mod drift;
mod excitation;
mod glossary;
mod groups;
mod html;
mod intervals;
mod joint_figures;
mod joints;
mod laws;
mod motion;
mod numbers;
mod overview;
mod payload;
mod plots;
mod promise;
mod refined_delays;
mod refinement;
mod robot_tables;
mod rows;
mod section;
mod servo;
mod settings;
mod spectrum;
mod springs;
mod stability;
mod tables;
mod unknowns;
mod validation_tables;
mod verdict;
mod watch_report;

use sprung_base::{curves, finding, named};
use sprung_method::{compare, estimate, validate, watch};
use sprung_model as model;

pub use check::compose_check;
pub use comparison::compose_comparison;
pub use compose::compose;
pub use contents::Contents;
pub use control::compose_control;
pub use document::*;
pub use excitation::compose_excitation;
pub use html::error::ReportError;
pub use html::render;
pub use intervals::relative_scale;
pub use joint_figures::JointFigures;
pub use numbers::significant;
pub use servo::compose_servo;
pub use unknowns::ShownUnknown;
pub use watch_report::compose_watch;
