//! Parameters as tables show them: the elements of a curve in one row.

use sprung_core::friction::Family;

use super::identification::{EstimateResult, ParameterEstimate};
use crate::description::SpringTerm;
use crate::estimate::statistics::NORMAL_95;

/// Returns the name of the curve of which a parameter is an element.
fn curve_of(name: &str) -> Option<&str> {
    let (curve, element) = name.rsplit_once('_')?;
    let words = [Family::Presliding.word(), SpringTerm::Hysteresis.word()];
    let is_of_curve = words.iter().any(|word| curve.ends_with(word));
    (is_of_curve && element.parse::<usize>().is_ok()).then_some(curve)
}

impl EstimateResult {
    /// Returns the parameters as tables show them. A row with the sum replaces the elements of presliding friction, its torque
    /// in steady motion, and those of hysteresis.
    #[must_use]
    pub fn shown_parameters(&self) -> Vec<ParameterEstimate> {
        let mut shown: Vec<ParameterEstimate> = Vec::new();
        for parameter in &self.parameters {
            match curve_of(&parameter.name) {
                None => shown.push(parameter.clone()),
                Some(curve) if shown.iter().any(|other| other.name == curve) => (),
                Some(curve) => shown.push(self.row_of_curve(curve, parameter)),
            }
        }
        shown
    }

    /// Returns sum and standard error of the elements of a curve, N·m (N); `None` without covariance.
    pub(in crate::estimate) fn sum_of_curve(&self, curve: &str) -> Option<(f64, f64)> {
        let of_curve = |name: &str| curve_of(name) == Some(curve);
        let elements = (self.parameters.iter()).filter(|one| of_curve(&one.name));
        let sum: f64 = elements.filter_map(|one| one.value).sum();
        let variance = self.covariance.as_ref()?.of_sum(of_curve);
        (variance > 0.0).then(|| (sum, variance.sqrt()))
    }

    /// - `first`: first element of the curve.
    fn row_of_curve(&self, curve: &str, first: &ParameterEstimate) -> ParameterEstimate {
        let sum = self.sum_of_curve(curve);
        ParameterEstimate {
            name: curve.to_owned(),
            value: sum.map(|(sum, _)| sum),
            standard_error: sum.map(|(_, error)| error),
            ci95: sum
                .map(|(sum, error)| [(sum - NORMAL_95 * error).max(0.0), sum + NORMAL_95 * error]),
            error_parts: None,
            one_sided: false,
            unconstrained: None,
            physical: None,
            nominal: None,
            torque_rms_nm: None,
            torque_share: None,
            torque_over_residual: None,
            ..first.clone()
        }
    }
}
