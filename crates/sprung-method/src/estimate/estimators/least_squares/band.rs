//! The frequencies at which two estimates predict different torques.

use crate::estimate::possible::{Normal, squared_distance};
use crate::model::Theta;
use crate::prepare::Prepared;

/// Lowest frequency of the search, Hz, and ratio of successive frequencies.
const LOWEST_HZ: f64 = 0.25;
const STEP: f64 = std::f64::consts::SQRT_2;

/// Share of the squared difference of the torques at the reported frequencies.
const REPORTED_SHARE: f64 = 0.5;

/// Returns the frequency below which half of the squared difference of a torque lies, Hz; `None` if most of it lies above
/// the cut-off of the positions, or the beginning of the log is too short.
///
/// The difference depends only on the positions, so it is evaluated for other cut-offs of the position filter:
/// regressor times change of the parameters.
///
/// - `row`: of the torque; `thetas`: two estimates, \[p\].
pub(super) fn half_below(prepared: &Prepared, row: usize, thetas: [&Theta; 2]) -> Option<f64> {
    let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
    let model = reading.model();
    let highest = reading.position_cutoff_hz();
    let weights: Vec<f64> = (0..model.rows())
        .map(|other| f64::from(other == row))
        .collect();
    let power = |cutoff_hz: f64| {
        let reading = reading.with_position_cutoff(cutoff_hz);
        let system = excerpt.smoothed(&reading)?.reduce(&reading)?;
        let normal = Normal::new(model, &system, &weights)?;
        let [one, other] = thetas;
        Some(squared_distance(&normal.information, one, other))
    };
    let all = power(highest)?;
    std::iter::successors(Some(LOWEST_HZ), |cutoff| Some(cutoff * STEP))
        .take_while(|cutoff| *cutoff < highest)
        .find(|cutoff| power(*cutoff).is_some_and(|below| below >= REPORTED_SHARE * all))
}
