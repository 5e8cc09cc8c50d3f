//! What the refinement found about the timing of the torques and the sharpness of Coulomb friction, and applied.

use crate::estimate::estimators::prediction_error::Retiming;
use crate::estimate::result::Refinement;
use crate::finding::{Finding, Severity};
use crate::model::Model;
use crate::numbers::in_ms;

/// Returns the findings about a timing that all estimators use.
///
/// - `refined`: the refinement with it; `period`: sampling period, s.
pub(in crate::estimate) fn retimed(
    model: &Model,
    own: &Retiming,
    refined: Option<&Refinement>,
    period: f64,
) -> Vec<Finding> {
    [
        torque_timing(own, refined, period),
        sharpness(model, own, refined),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The model holds a torque over the sampling period, so a torque without delay acts half a period after its stamp.
fn torque_timing(own: &Retiming, refined: Option<&Refinement>, period: f64) -> Option<Finding> {
    let torques = own.torques?;
    let found = (torques.delay, torques.standard_error);
    let (delay, error) = refined.and_then(|own| own.torques_delay_s).unwrap_or(found);
    let acts = 0.5 * period - delay;
    let when = if acts < 0.0 { "before" } else { "after" };
    let text = format!(
        "by likelihood, the motor torques act on average {:.3} ms {when} their time stamps (standard error {:.3} ms), and not \
         {:.3} ms after them as torques that are held until the next stamp: applied to all estimators. The held-out error of \
         the filtered torque goes {}",
        in_ms(acts.abs()),
        in_ms(error),
        in_ms(0.5 * period),
        torques.gain.words()
    );
    let remedy = format!(
        "nothing; to keep a timing, give the delay of each torque in [log], for example {delay:.6} for this one or 0 for \
         torques that are held"
    );
    Some(Finding::new(Severity::Info, "torque-timing", text, &remedy))
}

fn sharpness(model: &Model, own: &Retiming, refined: Option<&Refinement>) -> Option<Finding> {
    if own.sharpness.is_empty() {
        return None;
    }
    let values = refined.map_or(&[][..], |own| &own.sharpnesses);
    let each: Vec<String> = (own.sharpness.iter())
        .map(|&(joint, value)| {
            let name = &model.joints()[joint];
            match values.iter().find(|own| own.joint == *name) {
                Some(own) => format!("{name} {:.1} ± {:.1}", own.sharpness, own.standard_error),
                None => format!("{name} {value:.1}"),
            }
        })
        .collect();
    Some(Finding::new(
        Severity::Info,
        "coulomb-sharpness",
        format!(
            "the sharpness of Coulomb friction, for which the description gives no value, was estimated and applied to all \
             estimators: {} s/rad (s/m)",
            each.join(", ")
        ),
        "nothing; to keep a value, give coulomb_sharpness_s_per_rad of the joint",
    ))
}
