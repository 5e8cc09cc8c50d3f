//! Least squares on ever longer parts of a log.

use super::free::Free;
use crate::model::{Model, Theta};
use crate::regression::{System, solve_quickly};

/// Numbers of a trace, at most: it has fewer points for more parameters.
const TRACE_NUMBERS: usize = 8000;

/// Returns the estimate over time: that of the log up to then, \[p\], or
/// nothing while the data do not determine all parameters.
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

/// Returns the parameter vectors of the samples up to ever later times, in s, at
/// most `count` of them; nothing where they are not determined.
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
