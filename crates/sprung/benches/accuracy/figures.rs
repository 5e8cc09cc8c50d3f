//! Computes the figures of a row from the results of the runs.

use sprung_method::estimate::EstimateResult;
use sprung_testing::Figure;

/// Results of one method on one case.
pub(crate) struct Runs<'a> {
    /// Names and true values of the compared parameters, \[p\].
    pub(crate) truth: Vec<(String, f64)>,
    pub(crate) results: Vec<&'a EstimateResult>,
    /// The cross-check whose values are compared; those of the result itself if `None`.
    pub(crate) cross_check: Option<&'a str>,
    /// Cramér-Rao bounds of each run, \[p\]; `None` if they are unknown.
    pub(crate) bounds: Vec<Option<&'a [f64]>>,
}

/// Figures of one parameter over all runs, relative to its true value.
pub(crate) struct OfParameter {
    pub(crate) name: String,
    pub(crate) mean: f64,
    pub(crate) rms: f64,
    pub(crate) standard_error: f64,
    /// Root mean square of the Cramér-Rao bounds.
    pub(crate) bound: Option<f64>,
    /// Fraction of the 95 % intervals that contain the true value.
    pub(crate) inside: f64,
}

/// Returns the median; NaN for an empty list.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

impl Runs<'_> {
    fn value(&self, result: &EstimateResult, name: &str) -> Option<f64> {
        let Some(method) = self.cross_check else {
            return result.parameter(name)?.value;
        };
        let check = result
            .cross_checks
            .iter()
            .find(|check| check.method == method)?;
        check.values.get(name)
    }

    /// Returns the relative error of each parameter in a run; infinite if the parameter has no
    /// value.
    fn errors(&self, result: &EstimateResult) -> Vec<f64> {
        (self.truth.iter())
            .map(|(name, truth)| {
                self.value(result, name)
                    .map_or(f64::INFINITY, |value| value / truth - 1.0)
            })
            .collect()
    }

    /// Returns the median of the absolute relative errors of all parameters and runs.
    pub(crate) fn median_error(&self) -> f64 {
        let all = self.results.iter().flat_map(|result| self.errors(result));
        median(all.map(f64::abs).collect())
    }

    pub(crate) fn parameters(&self) -> Vec<OfParameter> {
        let count = self.results.len() as f64;
        (self.truth.iter().enumerate())
            .map(|(index, (name, truth))| {
                let errors = self.results.iter().map(|result| self.errors(result)[index]);
                let estimates = self
                    .results
                    .iter()
                    .filter_map(|result| result.parameter(name));
                let inside = (estimates.clone()).filter(|p| {
                    p.ci95
                        .is_some_and(|[low, high]| low <= *truth && *truth <= high)
                });
                // Cross-checks have no intervals.
                let count_inside = match self.cross_check {
                    Some(_) => f64::NAN,
                    None => inside.count() as f64,
                };
                let standard = estimates.filter_map(|p| p.standard_error);
                let bounds: Option<Vec<f64>> = self
                    .bounds
                    .iter()
                    .map(|bound| Some(bound.as_ref()?[index]))
                    .collect();
                OfParameter {
                    name: name.clone(),
                    mean: errors.clone().sum::<f64>() / count,
                    rms: (errors.map(|e| e * e).sum::<f64>() / count).sqrt(),
                    standard_error: standard.sum::<f64>() / count / truth.abs(),
                    bound: bounds.map(|bounds| {
                        (bounds.iter().map(|b| b * b).sum::<f64>() / count).sqrt() / truth.abs()
                    }),
                    inside: count_inside / count,
                }
            })
            .collect()
    }

    /// Notes the figures of one method for the documentation.
    ///
    /// - `ratio`: median of error over Cramér-Rao bound; NaN if the bound is unknown.
    pub(crate) fn note(&self, case: &str, method: &str, ratio: f64) {
        let all = self.parameters();
        let key = |what: &str| format!("{case}, {method}, {what}");
        // The table of the page has disturbances at one resolution.
        let is_shown = case.starts_with("clean") || !case.ends_with("4096 counts");
        let text = |what: &str| {
            let logs = self.results.len();
            if is_shown {
                format!("{case}, {method}, {logs} logs: {what}")
            } else {
                String::new()
            }
        };
        let percent = 100.0 * self.median_error();
        if percent.is_finite() {
            let name = key("error");
            Figure::lower(&name, &text("median error"), percent, "%").note();
            // The charts show the scatter between logs.
            for (word, value) in [
                ("least", f64::min as fn(f64, f64) -> f64),
                ("most", f64::max),
            ] {
                let of_logs = self
                    .results
                    .iter()
                    .map(|result| median(self.errors(result).into_iter().map(f64::abs).collect()));
                if let Some(end) = of_logs.reduce(value).filter(|end| end.is_finite()) {
                    let name = format!("{name}, {word}");
                    Figure::neutral(&name, "", 100.0 * end, "%").note();
                }
            }
        }
        let inside = all.iter().map(|p| p.inside).sum::<f64>() / all.len() as f64;
        if inside.is_finite() {
            let what = text("95 % intervals with the truth");
            Figure::neutral(&key("inside"), &what, 100.0 * inside, "%").note();
        }
        // Noise shrinks stiffnesses most with coarse encoders.
        let stiffnesses = all.iter().filter(|p| p.name.ends_with(".stiffness"));
        for p in stiffnesses.filter(|_| case.starts_with("clean, 4096")) {
            Figure::neutral(&key(&p.name), "", 100.0 * p.mean, "%").note();
        }
        if ratio.is_finite() {
            let what = text("error over Cramér-Rao bound");
            Figure::lower(&key("bound"), &what, ratio, "").note();
        }
    }

    pub(crate) fn seconds(&self) -> f64 {
        median(self.results.iter().map(|result| result.elapsed_s).collect())
    }

    /// Returns the number of runs whose refinement is not used.
    pub(crate) fn failed(&self) -> usize {
        let failed = |result: &&&EstimateResult| {
            (result.warnings.iter()).any(|finding| finding.code == "refinement-failed")
        };
        self.results.iter().filter(failed).count()
    }
}
