//! Reports that open anywhere: one HTML file with everything in it.

mod document;
mod html;

pub use document::*;
pub use html::{ReportError, render};
