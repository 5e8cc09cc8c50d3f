//! Estimates from parts of the logs.

use super::jackknife::{influences, scatter};
use super::least_squares::{Fitted, weighted};
use super::unknowns::Free;
use crate::model::Model;
use crate::regression::{System, Triangle, solve};

/// Number of segments of one part, which are left out in turn for its standard errors.
const SEGMENTS_OF_PART: usize = 8;

/// Minimum number of segments of a part.
const MIN_SEGMENTS: usize = 4;

/// Estimate from one part of the logs.
#[derive(Clone, Debug)]
pub(crate) struct PartFit {
    /// Value and standard error of each parameter, \[p\]; `None` for known parameters and for those
    /// that the part does not determine.
    pub(crate) values: Vec<Option<(f64, f64)>>,
    /// Number of segments that were left out in turn.
    segments: usize,
}

impl PartFit {
    /// - `segments`: factors of each row without the known parameters, segment by segment.
    fn new(model: &Model, free: &Free, segments: &[Vec<Triangle>]) -> Option<Self> {
        let rows = segments.first()?.len();
        let whole = (0..rows)
            .map(|row| Triangle::merge(segments.iter().map(|segment| &segment[row])))
            .collect::<Option<Vec<Triangle>>>()?;
        let solution = solve(&free.parts(&whole), free.unknowns.len())?;
        let errors = scatter(&influences(&solution, &free.columns, segments));
        let mut values = vec![None; model.parameters().len()];
        for (at, &index) in free.unknowns.iter().enumerate() {
            let error = errors[at];
            let known = solution.identifiable[at] && error.is_finite() && error > 0.0;
            values[index] = known.then_some((solution.x[at], error));
        }
        Some(Self {
            values,
            segments: segments.len(),
        })
    }

    /// Returns the deviation of Student's t with the freedom of the segments, by which errors from
    /// few segments count more.
    pub(crate) fn error_factor(&self) -> f64 {
        let freedom = self.segments.saturating_sub(1).max(3) as f64;
        (freedom / (freedom - 2.0)).sqrt()
    }

    /// Returns whether the part determines all parameters that the whole log determines.
    fn determines(&self, model: &Model, fitted: &Fitted) -> bool {
        (model
            .parameters()
            .iter()
            .zip(&fitted.identifiable)
            .zip(&self.values))
        .all(|((parameter, known), value)| parameter.fixed.is_some() || !known || value.is_some())
    }
}

/// Returns the estimates from the quarters of the logs, or from the halves if a quarter does not
/// determine all parameters; empty if the logs are too short.
pub(crate) fn fits_of_quarters(model: &Model, fitted: &Fitted) -> Vec<PartFit> {
    let free = Free::new(model);
    let groups = &fitted.groups;
    for count in [4, 2] {
        if groups.len() < count * MIN_SEGMENTS {
            continue;
        }
        let fits: Option<Vec<PartFit>> = (0..count)
            .map(|i| {
                let part = i * groups.len() / count..(i + 1) * groups.len() / count;
                let fit = PartFit::new(model, &free, &groups[part])?;
                fit.determines(model, fitted).then_some(fit)
            })
            .collect();
        if let Some(fits) = fits {
            return fits;
        }
    }
    Vec::new()
}

/// Returns the estimate from one log with the weights of a fit; `None` if it has too few segments.
pub(crate) fn fit_of_log(
    model: &Model,
    system: &System,
    log: usize,
    fitted: &Fitted,
) -> Option<PartFit> {
    let free = Free::new(model);
    let segments: Vec<Vec<Triangle>> = (system.groups_of_log(log, SEGMENTS_OF_PART).into_iter())
        .map(|factors| weighted(free.factors(factors), &fitted.weights))
        .collect();
    (segments.len() >= MIN_SEGMENTS)
        .then(|| PartFit::new(model, &free, &segments))
        .flatten()
}
