//! The list of applied changes that the log requires.

use crate::description::Joint;
use crate::estimate::estimators::prediction_error::Retiming;
use crate::estimate::result::{Applied, Refinement};
use crate::finding::{Finding, Severity};
use crate::log::{SPIKES, STUCK_SAMPLES};
use crate::model::Model;
use crate::numbers::{in_ms, in_percent};
use crate::unknowns::UnknownResult;

/// Setting that keeps to the description.
const DECLARED: &str = "laws = \"declared\"";

/// Returns the changes beyond the description that all estimators use.
///
/// - `about_logs`: findings about the logs, including the corrected samples.
/// - `retiming`: timing and sharpness that a first refinement found; `refined`: the refinement with them.
/// - `unknowns`: what the log shows beyond the description; `period`: sampling period, s.
pub(in crate::estimate) fn applied(
    model: &Model,
    about_logs: &[Finding],
    (retiming, refined): (Option<&Retiming>, Option<&Refinement>),
    unknowns: &[UnknownResult],
    period: f64,
) -> Vec<Applied> {
    let timing = retiming.and_then(|retiming| torque_timing(retiming, refined, period));
    let sharpness = retiming.and_then(|retiming| sharpness(model, retiming, refined));
    let laws = unknowns.iter().filter_map(of_law);
    (about_logs.iter())
        .filter_map(mended)
        .chain(timing)
        .chain(sharpness)
        .chain(laws)
        .collect()
}

/// Corrected samples are a note; otherwise they are a warning.
fn mended(finding: &Finding) -> Option<Applied> {
    let is_mended = finding.severity == Severity::Info
        && [SPIKES, STUCK_SAMPLES].contains(&finding.code.as_str());
    is_mended.then(|| Applied {
        kind: "samples".to_owned(),
        what: finding.text.clone(),
        held_out: None,
        forbidden_by: "wrong_samples = \"keep\" in [log]".to_owned(),
    })
}

/// The model holds a torque over the sampling period, so a torque without delay acts half a period after its stamp.
fn torque_timing(
    retiming: &Retiming,
    refined: Option<&Refinement>,
    period: f64,
) -> Option<Applied> {
    let torques = retiming.torques?;
    let (delay, error) = retiming.torques_delay(refined)?;
    let acts = 0.5 * period - delay;
    let when = if acts < 0.0 { "before" } else { "after" };
    Some(Applied {
        kind: "timing".to_owned(),
        what: format!(
            "the motor torques act {:.3} ± {:.3} ms {when} their time stamps on average, not {:.3} ms after them as \
             torques that are held until the next stamp",
            in_ms(acts.abs()),
            in_ms(error),
            in_ms(0.5 * period),
        ),
        held_out: Some([torques.gain.without, torques.gain.with]),
        forbidden_by: format!("delay_s of the torques in [log], or {DECLARED}"),
    })
}

fn sharpness(model: &Model, retiming: &Retiming, refined: Option<&Refinement>) -> Option<Applied> {
    if retiming.sharpness.is_empty() {
        return None;
    }
    let values = refined.map_or(&[][..], |refinement| &refinement.sharpnesses);
    let each: Vec<String> = (retiming.sharpness.iter())
        .map(|&(joint, value)| {
            let name = &model.joints()[joint];
            let refined = values.iter().find(|sharpness| sharpness.joint == *name);
            let value = refined.map_or(value, |refined| refined.sharpness);
            format!("{value:.0} in {name}")
        })
        .collect();
    Some(Applied {
        kind: "sharpness".to_owned(),
        what: format!(
            "the sharpness of Coulomb friction is not {:.0} s/rad (s/m) but {}",
            Joint::USUAL_SHARPNESS,
            each.join(", ")
        ),
        held_out: None,
        forbidden_by: format!("coulomb_sharpness_s_per_rad of the joint, or {DECLARED}"),
    })
}

fn of_law(unknown: &UnknownResult) -> Option<Applied> {
    let law = unknown.used_law()?;
    Some(Applied {
        kind: "law".to_owned(),
        what: format!(
            "{}: {}, with which the squared error of its torques on held-out parts of the log falls by {:.0} %",
            unknown.place,
            law.words(),
            in_percent(unknown.effect)
        ),
        held_out: None,
        forbidden_by: DECLARED.to_owned(),
    })
}
