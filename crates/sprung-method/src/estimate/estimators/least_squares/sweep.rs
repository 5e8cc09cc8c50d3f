//! Estimates with other cut-offs of the position filter in the form of the results.

use crate::estimate::result::{CutoffChoice, CutoffPoint};
use crate::prepare::Prepared;

/// Returns the choice of the cut-off and the estimates with other cut-offs; `None` if there are
/// none.
#[must_use]
pub(crate) fn cutoff_choice(prepared: &Prepared) -> Option<CutoffChoice> {
    let points = (prepared.sweep().into_iter()).flat_map(|sweep| &sweep.points);
    let reason = prepared.cutoff_reason();
    if reason.is_none() && prepared.sweep().is_none() {
        return None;
    }
    Some(CutoffChoice {
        reason: reason.unwrap_or("the experiment gives it").to_owned(),
        sweep: points
            .map(|point| CutoffPoint {
                cutoff_hz: point.cutoff_hz,
                values: point.theta.clone(),
                held_out_residual: point.held_out,
            })
            .collect(),
    })
}
