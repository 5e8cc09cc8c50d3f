//! Contradiction between the refinement and least squares.

use sprung_core::parameters::JointParameter;

use super::parameters::listed;
use crate::estimate::result::EstimateResult;
use crate::estimate::statistics::{SIGNIFICANT_SIGMAS, SMALL_SHARE};
use crate::finding::{Finding, Severity};
use crate::fit::Fitted;
use crate::model::Model;

/// Reports parameters whose refined value contradicts least squares. The methods weight the samples
/// differently, so a missing effect makes them differ.
///
/// - `fitted`: result of least squares.
pub(super) fn routes_disagree(
    model: &Model,
    result: &EstimateResult,
    fitted: &Fitted,
) -> Option<Finding> {
    result.refined()?;
    let mut apart: Vec<(usize, f64)> = (result.parameters.iter().enumerate())
        .filter(|(i, parameter)| !parameter.fixed && fitted.identifiable[*i])
        // Neighbours of a curve share its torque.
        .filter(|(i, _)| {
            let kind = model.parameters()[*i].joint.map(|(kind, _)| kind);
            !kind.is_some_and(JointParameter::is_of_curve)
        })
        .filter_map(|(i, parameter)| {
            let error = parameter.standard_error?.hypot(fitted.standard_error[i]);
            let difference = (parameter.value? - fitted.theta[i]).abs();
            Some((i, difference / error)).filter(|(_, size)| *size > SIGNIFICANT_SIGMAS)
        })
        .collect();
    if apart.is_empty() {
        return None;
    }
    apart.sort_by(|a, b| b.1.total_cmp(&a.1));
    // Least squares have a bias by smearing that their errors do not contain.
    let matters = |&(i, _): &(usize, f64)| {
        let parameter = &result.parameters[i];
        let difference = (parameter.value.unwrap_or_default() - fitted.theta[i]).abs();
        difference > SMALL_SHARE * fitted.theta[i].abs()
    };
    let severity = if apart.iter().any(matters) {
        Severity::Warning
    } else {
        Severity::Info
    };
    let list = apart.iter().map(|&(i, size)| {
        let parameter = &result.parameters[i];
        format!(
            "{} ({:.4} and {:.4} {}, {size:.1} standard errors of the difference)",
            model.parameters()[i].short(),
            parameter.value.unwrap_or_default(),
            fitted.theta[i],
            parameter.unit
        )
    });
    Some(
        Finding::new(
            severity,
            "routes-disagree",
            format!(
                "refinement and least squares contradict each other: {}. The model lacks an effect, \
                 or a position is noisier than its counts",
                listed(list)
            ),
            "try laws = \"auto\"; look for delays, play and uneven encoders; until then use neither \
             value alone",
        )
        .about(apart.iter().map(|&(i, _)| result.parameters[i].name.clone())),
    )
}
