//! Least squares on growing parts of a log.

use super::unknowns::Free;
use crate::model::{Model, Theta};
use crate::regression::{System, solve_quickly};

/// Limit of points times unknowns in a trace, so more parameters give fewer points.
const TRACE_NUMBERS: usize = 8000;

/// Returns the estimate from the samples up to each time in s, \[p\]; `None` while the samples do
/// not determine all parameters.
///
/// # Source
///
/// Eq. (28) and Fig. 4.
pub fn trace<'a>(
    model: &'a Model,
    system: &'a System,
) -> impl Iterator<Item = (f64, Option<Theta>)> + 'a {
    let unknowns = Free::new(model).unknowns.len();
    fits_of_growing(model, system, (TRACE_NUMBERS / unknowns.max(1)).max(48))
}

/// Returns parameter vectors from growing parts of the log, with the end of each part in s, at most
/// `count` of them. A vector is `None` if its part does not determine all parameters.
pub(crate) fn fits_of_growing<'a>(
    model: &'a Model,
    system: &'a System,
    count: usize,
) -> impl Iterator<Item = (f64, Option<Theta>)> + 'a {
    let free = Free::new(model);
    system.growing(count).map(move |(time, factors)| {
        let factors = free.factors(factors);
        let x = solve_quickly(&free.parts(&factors), free.unknowns.len());
        (time, x.map(|x| free.whole(&x, |value| value)))
    })
}
