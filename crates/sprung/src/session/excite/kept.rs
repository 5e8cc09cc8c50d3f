//! Compares the standard errors of a log with the promise of the design of its experiment.

use std::collections::BTreeMap;

use serde::Deserialize;
use sprung_base::finding::{Finding, Severity};
use sprung_log::LogSource;
use sprung_method::check::Checked;
use sprung_method::estimate::Identified;

use super::task::Setup;
use crate::session::error::SessionError;
use crate::session::excite_error::ExciteError;
use crate::session::files::read_text;
use crate::session::load::Session;
use crate::session::parameters::Parameters;

/// Factor of standard errors over the promise from which they count as larger.
const LARGER: f64 = 1.5;

/// Code of the finding.
const DESIGN_PROMISE: &str = "design-promise";

/// The part of `excitation.json` that a comparison needs.
#[derive(Deserialize)]
struct Design {
    #[serde(skip)]
    file: String,
    promise: Vec<Promise>,
}

#[derive(Deserialize)]
struct Promise {
    name: String,
    value: f64,
    /// Absent for one that is infinite.
    standard_error: Option<f64>,
}

impl Session {
    /// Adds a note about the promise of the design of this experiment, if the experiment names one.
    pub(in crate::session) fn with_design(
        &self,
        mut found: Identified,
    ) -> Result<Identified, SessionError> {
        let Some(design) = self.design()? else {
            return Ok(found);
        };
        for result in &mut found.identification.results {
            let error = |name: &str| result.parameter(name)?.standard_error;
            if let Some(finding) = compared(&design, error, &ESTIMATE) {
                result.warnings.push(finding);
            }
        }
        Ok(found)
    }

    /// Adds a finding about the promise of the design to a check: the standard errors of the recorded motion with the
    /// values and sensors of the design.
    pub(in crate::session) fn check_design(
        &self,
        sources: &mut [LogSource<'_>],
        checked: &mut Checked,
    ) -> Result<(), SessionError> {
        let Some(design) = self.design()?.filter(|_| !checked.report.refused) else {
            return Ok(());
        };
        let (experiment, model) = (self.experiment().clone(), self.model().clone());
        // The design may know laws that an identification added.
        let known = |promise: &&Promise| {
            model
                .parameters()
                .iter()
                .any(|one| one.name == promise.name)
        };
        let values = (design.promise.iter().filter(known))
            .map(|promise| (promise.name.clone(), promise.value))
            .collect();
        model
            .theta(&values)
            .map_err(|error| ExciteError::NoDesign {
                file: design.file.clone(),
                why: format!("its values are not those of this robot: {error}"),
            })?;
        let parameters = Parameters::named("design", values);
        let setup = Setup::new(experiment, model, Some(&parameters), Vec::new(), false)?;
        let Some(information) = setup.information_of(sources)? else {
            return Ok(());
        };
        let errors: BTreeMap<&str, f64> = (setup.free())
            .map(|parameter| parameter.name.as_str())
            .zip(information.standard_errors())
            .collect();
        let error = |name: &str| errors.get(name).copied();
        checked
            .report
            .findings
            .extend(compared(&design, error, &MOTION));
        Ok(())
    }

    /// Reads the design of this experiment.
    fn design(&self) -> Result<Option<Design>, SessionError> {
        let Some(file) = &self.experiment().excite.promise else {
            return Ok(None);
        };
        let path = self.folder.join(file);
        let text = read_text(&*self.files, &path)?;
        let file = path.display().to_string();
        match serde_json::from_str::<Design>(&text) {
            Ok(design) => Ok(Some(Design { file, ..design })),
            Err(error) => Err(ExciteError::NoDesign {
                file,
                why: error.to_string(),
            }
            .into()),
        }
    }
}

/// The words of a comparison.
struct Words {
    kept: &'static str,
    missed: &'static str,
    remedy: &'static str,
}

const ESTIMATE: Words = Words {
    kept: "the log keeps the promise of its design",
    missed: "the log tells less than its design promised",
    remedy: "compare noise, rate and motion of the log with [simulate] and the trajectory, or look for an effect that the model \
             lacks; sprung excite --parameters identification.json --from-log LOG designs the next motion",
};

const MOTION: Words = Words {
    kept: "the recorded motion tells as much as its design promised",
    missed: "the recorded motion tells less than its design promised",
    remedy: "compare length, amplitude and rate of the log with trajectory.csv: the robot did not follow it, or a part is \
             missing; sprung excite --from-log LOG designs a motion that adds to this one",
};

/// Returns the note about standard errors; `None` without a promise.
fn compared(
    design: &Design,
    error: impl Fn(&str) -> Option<f64>,
    words: &Words,
) -> Option<Finding> {
    let mut ratios: Vec<(f64, &str)> = (design.promise.iter())
        .filter_map(|promise| {
            let ratio = error(&promise.name)? / promise.standard_error?;
            (ratio.is_finite() && ratio > 0.0).then_some((ratio, promise.name.as_str()))
        })
        .collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (worst, name) = *ratios.last()?;
    let logs: f64 = ratios.iter().map(|ratio| ratio.0.ln()).sum();
    let mean = (logs / ratios.len() as f64).exp();
    let (kept, remedy) = if mean <= LARGER {
        (words.kept, "no action")
    } else {
        (words.missed, words.remedy)
    };
    let text = format!(
        "{kept}: standard errors are {mean:.2} times the promised ones in the geometric mean, {worst:.1} times for {name}"
    );
    let finding = Finding::new(Severity::Info, DESIGN_PROMISE, text, remedy);
    let missed = ratios.iter().filter(|ratio| ratio.0 > 2.0 * LARGER);
    Some(finding.about(missed.map(|ratio| ratio.1.to_owned())))
}
