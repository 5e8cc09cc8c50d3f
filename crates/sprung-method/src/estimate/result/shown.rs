//! Parameters as tables show them: the elements of a curve in one row.

use sprung_core::friction::Family;
use sprung_core::presliding::SPRING_WIDTHS;

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
    /// Returns the parameters as tables show them. The stiffness of a spring with hysteresis just after a reversal stands behind its
    /// stiffness. A row with the sum replaces the elements of presliding friction, its torque
    /// in steady motion, and those of hysteresis.
    #[must_use]
    pub fn shown_parameters(&self) -> Vec<ParameterEstimate> {
        let mut shown: Vec<ParameterEstimate> = Vec::new();
        for parameter in &self.parameters {
            match curve_of(&parameter.name) {
                None => {
                    shown.push(parameter.clone());
                    shown.extend(self.stiffness_after_reversal(parameter));
                }
                Some(curve) if shown.iter().any(|other| other.name == curve) => (),
                Some(curve) => shown.push(self.row_of_curve(curve, parameter)),
            }
        }
        shown
    }

    /// Returns sum and standard error of the elements of a curve, N·m (N); `None` without covariance.
    pub(in crate::estimate) fn sum_of_curve(&self, curve: &str) -> Option<(f64, f64)> {
        self.weighted_sum(|name| (curve_of(name) == Some(curve)).then_some(1.0))
    }

    /// Returns a weighted sum of the parameters that have a weight, and its standard error; `None` without covariance.
    fn weighted_sum(&self, weight: impl Fn(&str) -> Option<f64>) -> Option<(f64, f64)> {
        let weighted = (self.parameters.iter())
            .filter_map(|one| Some(weight(&one.name)? * one.value.unwrap_or_default()));
        let sum: f64 = weighted.sum();
        let variance = self.covariance.as_ref()?.of_sum(weight);
        (variance > 0.0).then(|| (sum, variance.sqrt()))
    }

    /// Returns the row of the stiffness just after a reversal, where no element of hysteresis slides: K + Σ h/w.
    fn stiffness_after_reversal(&self, stiffness: &ParameterEstimate) -> Option<ParameterEstimate> {
        let joint = stiffness.name.strip_suffix(".stiffness")?;
        let width = self.hysteresis_width.get(joint)?;
        let curve = format!("{joint}.spring_{}", SpringTerm::Hysteresis.word());
        let weight = |name: &str| {
            if name == stiffness.name {
                return Some(1.0);
            }
            let (of, element) = name.rsplit_once('_')?;
            let share = SPRING_WIDTHS.get(element.parse::<usize>().ok()?.checked_sub(1)?)?;
            (of == curve).then(|| 1.0 / (share * width))
        };
        let found = self.weighted_sum(weight);
        let name = format!("{}_after_reversal", stiffness.name);
        Some(Self::derived(name, found, stiffness))
    }

    /// - `first`: first element of the curve.
    fn row_of_curve(&self, curve: &str, first: &ParameterEstimate) -> ParameterEstimate {
        Self::derived(curve.to_owned(), self.sum_of_curve(curve), first)
    }

    /// Returns a row with another value, which is not negative.
    ///
    /// - `like`: a parameter of the same unit.
    fn derived(
        name: String,
        sum: Option<(f64, f64)>,
        like: &ParameterEstimate,
    ) -> ParameterEstimate {
        ParameterEstimate {
            name,
            value: sum.map(|(sum, _)| sum),
            standard_error: sum.map(|(_, error)| error),
            ci95: sum
                .map(|(sum, error)| [(sum - NORMAL_95 * error).max(0.0), sum + NORMAL_95 * error]),
            error_parts: None,
            one_sided: false,
            unconstrained: None,
            physical: None,
            sum_with: None,
            nominal: None,
            torque_rms_nm: None,
            torque_share: None,
            torque_over_residual: None,
            ..like.clone()
        }
    }
}
