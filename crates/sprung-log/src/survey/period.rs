//! The sampling period that velocities tell where no column holds a time.

use super::families::{Family, Place};
use super::positions::side;
use super::read::Survey;
use super::words::Sort;

/// Smallest squared correlation of the change of a position with its velocity.
const FOLLOWS: f64 = 0.9;

/// Largest difference of the periods of two joints, and of a period from a usual one.
const SAME_PERIOD: f64 = 0.02;

/// Periods of usual rates, s.
const USUAL: [f64; 18] = [
    1e-4, 1.25e-4, 2e-4, 2.5e-4, 4e-4, 5e-4, 8e-4, 1e-3, 2e-3, 4e-3, 5e-3, 8e-3, 1e-2, 2e-2,
    2.5e-2, 4e-2, 5e-2, 1e-1,
];

/// Returns the sampling period by velocities, s, and the reason: that by which the changes of the positions equal the
/// velocities, if it is a usual one for all joints.
pub(super) fn period(survey: &Survey, families: &[Family]) -> Option<(f64, String)> {
    let of = |sort: Sort| {
        (families.iter()).filter(move |family| {
            family.meaning.sort == Some(sort)
                && family.problem.is_none()
                && !family.meaning.is_reference
        })
    };
    for velocity in of(Sort::Velocity) {
        let mut positions: Vec<&Family> = of(Sort::Position).collect();
        positions.sort_by_key(|position| (side(position) - side(velocity)).abs());
        for position in positions {
            let pairs = position.of.iter().zip(&velocity.of);
            let pairs = pairs.filter_map(|(position, velocity)| Some(((*position)?, (*velocity)?)));
            let periods: Option<Vec<f64>> = pairs
                .map(|(position, velocity)| ratio(survey, position, velocity))
                .collect();
            let Some(periods) = periods.filter(|periods| !periods.is_empty()) else {
                continue;
            };
            let is_of_all = |usual: &&f64| {
                (periods.iter()).all(|period| (period / **usual - 1.0).abs() < SAME_PERIOD)
            };
            let usual = USUAL.iter().find(is_of_all);
            if let Some(&usual) = usual {
                let mean = periods.iter().sum::<f64>() / periods.len() as f64;
                let why = format!(
                    "By the velocities: the changes of \"{}\" equal \"{}\" for a period of {:.4} s",
                    position.name,
                    velocity.name,
                    super::write::Short(mean)
                );
                return Some((usual, why));
            }
        }
    }
    None
}

/// Samples over which the change of a position is compared with the sum of the velocities.
const SPAN: usize = 10;

/// Returns the change of a position per sample over a velocity; `None` unless one follows the other.
pub(super) fn ratio(survey: &Survey, position: Place, velocity: Place) -> Option<f64> {
    if position.0 != velocity.0 {
        return None;
    }
    let source = &survey.sources[position.0];
    let (x, v) = (
        &source.columns[position.1].values,
        &source.columns[velocity.1].values,
    );
    let (mut both, mut square_x, mut square_v) = (0.0, 0.0, 0.0);
    for part in source.parts(x.len().min(v.len())) {
        for k in part.start..part.end.saturating_sub(SPAN) {
            let inner: f64 = v[k + 1..k + SPAN].iter().sum();
            let (change, velocity) = (x[k + SPAN] - x[k], inner + f64::midpoint(v[k], v[k + SPAN]));
            if change.is_finite() && velocity.is_finite() {
                both += change * velocity;
                square_x += change * change;
                square_v += velocity * velocity;
            }
        }
    }
    (both > 0.0 && both * both > FOLLOWS * square_x * square_v).then(|| both / square_v)
}
