//! Compares the standard errors of an identification with those that the design of its experiment promised.

use std::path::Path;

use serde::Deserialize;
use sprung_base::finding::{Finding, Severity};
use sprung_method::estimate::{EstimateResult, Identified};

use crate::session::error::SessionError;
use crate::session::files::read_text;
use crate::session::load::Session;

/// Factor of standard errors over the promise from which they count as larger.
const LARGER: f64 = 1.5;

/// Code of the finding.
const DESIGN_PROMISE: &str = "design-promise";

/// The part of `excitation.json` that a comparison needs.
#[derive(Deserialize)]
struct Design {
    promise: Vec<Promise>,
}

#[derive(Deserialize)]
struct Promise {
    name: String,
    standard_error: f64,
}

impl Session {
    /// Adds a note about the promise of the design of this experiment, if the experiment names one.
    pub(in crate::session) fn with_design(
        &self,
        mut found: Identified,
    ) -> Result<Identified, SessionError> {
        let Some(file) = &self.experiment().excite.promise else {
            return Ok(found);
        };
        let design = self.design(&self.folder.join(file))?;
        for result in &mut found.identification.results {
            if let Some(finding) = compared(result, &design) {
                result.warnings.push(finding);
            }
        }
        Ok(found)
    }

    fn design(&self, file: &Path) -> Result<Design, SessionError> {
        let text = read_text(&*self.files, file)?;
        serde_json::from_str(&text).map_err(|error| SessionError::NotParameters {
            file: file.display().to_string(),
            why: format!("it is not the excitation.json of sprung excite: {error}"),
        })
    }
}

/// Returns the note about a result; `None` if it has no parameter with a promise.
fn compared(result: &EstimateResult, design: &Design) -> Option<Finding> {
    let mut ratios: Vec<(f64, &str)> = (design.promise.iter())
        .filter_map(|own| {
            let found = result.parameter(&own.name)?.standard_error?;
            let ratio = found / own.standard_error;
            (ratio.is_finite() && ratio > 0.0).then_some((ratio, own.name.as_str()))
        })
        .collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (worst, name) = *ratios.last()?;
    let logs: f64 = ratios.iter().map(|own| own.0.ln()).sum();
    let mean = (logs / ratios.len() as f64).exp();
    let (kept, remedy) = if mean <= LARGER {
        ("the log keeps the promise of its design", "no action")
    } else {
        (
            "the log tells less than its design promised",
            "compare noise, rate and motion of the log with [simulate] and the trajectory, or look for an effect that the model \
             lacks; sprung excite --parameters identification.json --from-log LOG designs the next motion",
        )
    };
    let text = format!(
        "{kept}: standard errors are {mean:.2} times the promised ones in the geometric mean, {worst:.1} times for {name}"
    );
    let finding = Finding::new(Severity::Info, DESIGN_PROMISE, text, remedy);
    let missed = ratios.iter().filter(|own| own.0 > 2.0 * LARGER);
    Some(finding.about(missed.map(|own| own.1.to_owned())))
}
