//! Slope between two positions of a joint: the gear ratio, a unit, or counts per turn.

use std::ops::Range;

use sprung_core::linear;

use super::families::Place;
use super::read::Survey;

/// Samples that are averaged before a difference is formed, on each side.
const SMOOTHED: usize = 5;

/// Velocity of a reversal, as a part of the root mean square of the velocity.
const SLOW: f64 = 0.15;

/// Smallest number of samples of a slope.
const MIN_SAMPLES: usize = 100;

/// Regressors: position, velocity, its sign, acceleration, torque, constant.
const TERMS: usize = 6;

/// Smallest part of the variance that the slope must explain.
const MIN_EXPLAINED: f64 = 0.9;

/// Minimum part of the squares of the readings that the position explains.
const MIN_BY_POSITION: f64 = 0.3;

/// Slope of one position over another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slope {
    /// Reading of the first over that of the second.
    pub(super) value: f64,
    /// Its error, from the slopes of four parts of the log.
    pub(super) error: f64,
}

/// Returns the slope of `motor` over `link`; `None` if the two do not move together.
///
/// The spring lies between them: their difference follows torque, friction and inertia. These are regressors as well,
/// so the deflection does not bias the slope. All signals pass the same filter, and samples near a reversal are left
/// out, because the friction law is not known there.
pub(super) fn slope(
    survey: &Survey,
    motor: Place,
    link: Place,
    torque: Option<Place>,
) -> Option<Slope> {
    let x = values(survey, link);
    let y = at_times_of(survey, motor, link.0);
    let torque = torque.map(|torque| at_times_of(survey, torque, link.0));
    let count = x.len().min(y.len());
    let count = torque
        .as_ref()
        .map_or(count, |torque| count.min(torque.len()));
    let torque = torque.unwrap_or_else(|| vec![0.0; count]);
    let parts = survey.sources[link.0].parts(count);
    let samples = samples(&x[..count], &y[..count], &torque[..count], &parts);
    if samples.len() < MIN_SAMPLES {
        return None;
    }
    let value = fit(&samples)?;
    let parts: Vec<f64> = (samples.chunks(samples.len().div_ceil(4)))
        .filter_map(fit)
        .collect();
    let spread: f64 = parts.iter().map(|part| (part - value).powi(2)).sum();
    let error = (spread / parts.len().max(1) as f64).sqrt() / 2.0;
    Some(Slope { value, error })
}

fn values(survey: &Survey, (source, column): Place) -> &[f64] {
    &survey.sources[source].columns[column].values
}

/// Returns the values of a column at the times of another source.
fn at_times_of(survey: &Survey, place: Place, source: usize) -> Vec<f64> {
    let values = values(survey, place);
    if place.0 == source {
        return values.to_vec();
    }
    let (from, to) = (&survey.sources[place.0], &survey.sources[source]);
    let shift = 1e-9 * to.begin.saturating_sub(from.begin) as f64;
    let at = |time: &f64| {
        let time = time + shift;
        let next = from.times.partition_point(|known| *known < time);
        let (Some(&after), Some(before)) = (from.times.get(next), next.checked_sub(1)) else {
            return f64::NAN;
        };
        if from.joins.contains(&next) {
            return f64::NAN;
        }
        let part = (time - from.times[before]) / (after - from.times[before]);
        values[before] + part * (values[next] - values[before])
    };
    to.times.iter().map(at).collect()
}

/// Regressors of a sample, and the reading that they explain.
type Sample = ([f64; TERMS], f64);

/// Returns the samples that lie away from reversals and from samples that are no numbers. Velocities
/// and accelerations are per sample.
///
/// - `parts`: samples that follow each other without a gap.
fn samples(x: &[f64], y: &[f64], torque: &[f64], parts: &[Range<usize>]) -> Vec<Sample> {
    let count = x.len();
    let mut bad = vec![0_usize; count + 1];
    for k in 0..count {
        let is_bad = !(x[k].is_finite() && y[k].is_finite() && torque[k].is_finite());
        bad[k + 1] = bad[k] + usize::from(is_bad);
    }
    let each = |of: fn(&[f64]) -> Vec<f64>, values: &[f64]| -> Vec<f64> {
        (parts.iter())
            .flat_map(|part| of(&values[part.clone()]))
            .collect()
    };
    let (position, reading, torque) = (each(smooth, x), each(smooth, y), each(smooth, torque));
    let velocity = each(rate, &reading);
    let acceleration = each(rate, &velocity);
    let squares: f64 = velocity.iter().map(|v| v * v).sum();
    let slow = SLOW * (squares / count.max(1) as f64).sqrt();
    let direction: Vec<f64> = velocity.iter().map(|v| v.signum()).collect();
    let direction = each(smooth, &direction);
    let reach = 2 * SMOOTHED + 2;
    (parts.iter())
        .flat_map(|part| part.start + reach..part.end.saturating_sub(reach))
        .filter(|&k| velocity[k].abs() > slow && bad[k + reach + 1] == bad[k - reach])
        .map(|k| {
            let terms = [
                position[k],
                velocity[k],
                direction[k],
                acceleration[k],
                torque[k],
                1.0,
            ];
            (terms, reading[k])
        })
        .collect()
}

/// Returns the values averaged twice over `2 * SMOOTHED + 1` neighbours.
fn smooth(values: &[f64]) -> Vec<f64> {
    averaged(&averaged(values))
}

fn averaged(values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; values.len() + 1];
    for (k, value) in values.iter().enumerate() {
        sums[k + 1] = sums[k] + if value.is_finite() { *value } else { 0.0 };
    }
    (0..values.len())
        .map(|k| {
            let (from, to) = (
                k.saturating_sub(SMOOTHED),
                (k + SMOOTHED + 1).min(values.len()),
            );
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// Returns the change per sample.
fn rate(values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(1), (k + 1).min(last));
            (values[to] - values[from]) / (to - from).max(1) as f64
        })
        .collect()
}

/// Returns the squared correlation of two positions while they change.
pub(super) fn similarity(survey: &Survey, one: Place, two: Place) -> f64 {
    let (x, y) = (values(survey, two), at_times_of(survey, one, two.0));
    let pairs: Vec<(f64, f64)> = (x.iter().copied().zip(y))
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    let count = pairs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        pairs.iter().map(|pair| of(pair.0 - x, pair.1 - y)).sum()
    };
    let both = sum(&|x, _| x * x) * sum(&|_, y| y * y);
    if both > 0.0 {
        sum(&|x, y| x * y).powi(2) / both
    } else {
        0.0
    }
}

/// Returns the part of a torque (squares) that position, velocity, direction and acceleration of one joint explain.
pub(super) fn explained_torque(survey: &Survey, torque: Place, position: Place) -> f64 {
    let x = values(survey, position);
    let torque = at_times_of(survey, torque, position.0);
    let count = x.len().min(torque.len());
    let parts = survey.sources[position.0].parts(count);
    let of_torque: Vec<Sample> = samples(&x[..count], &x[..count], &torque[..count], &parts)
        .into_iter()
        .map(
            |([position, velocity, direction, acceleration, torque, one], _)| {
                let terms = [position, velocity, direction, acceleration, 0.0, one];
                (terms, torque)
            },
        )
        .collect();
    if of_torque.len() < MIN_SAMPLES {
        return 0.0;
    }
    regress(&of_torque).map_or(0.0, |found| found.explained)
}

/// A regression of samples.
struct Regression {
    /// Factor of the position.
    slope: f64,
    /// Parts of the squares of the readings that all regressors and the position alone explain.
    explained: f64,
    by_position: f64,
}

/// Fits the samples by least squares; returns the factor of the position, `None` if the regressors, or
/// the position among them, explain little.
fn fit(samples: &[Sample]) -> Option<f64> {
    let found = regress(samples)?;
    (found.explained > MIN_EXPLAINED && found.by_position > MIN_BY_POSITION).then_some(found.slope)
}

/// Fits the samples by least squares; `None` if the position or the reading does not change.
fn regress(samples: &[Sample]) -> Option<Regression> {
    let count = samples.len() as f64;
    let mean = |k: usize| samples.iter().map(|(row, _)| row[k]).sum::<f64>() / count;
    let mean_y = samples.iter().map(|(_, y)| y).sum::<f64>() / count;
    let means: [f64; TERMS] = std::array::from_fn(mean);
    // All regressors but the constant, without their means and of unit size.
    let sizes: [f64; TERMS] = std::array::from_fn(|k| {
        let square = |(row, _): &Sample| (row[k] - means[k]).powi(2);
        (samples.iter().map(square).sum::<f64>() / count).sqrt()
    });
    let used: Vec<usize> = (0..TERMS - 1).filter(|&k| sizes[k] > 0.0).collect();
    if used.first() != Some(&0) {
        return None;
    }
    let n = used.len();
    let (mut matrix, mut right, mut total) = (vec![0.0; n * n], vec![0.0; n], 0.0);
    for (row, y) in samples {
        let scaled: Vec<f64> = used
            .iter()
            .map(|&k| (row[k] - means[k]) / sizes[k])
            .collect();
        for i in 0..n {
            for j in 0..=i {
                matrix[i * n + j] += scaled[i] * scaled[j];
            }
            right[i] += scaled[i] * (y - mean_y);
        }
        total += (y - mean_y).powi(2);
    }
    for i in 0..n {
        matrix[i * n + i] *= 1.0 + 1e-12;
    }
    let normal = right.clone();
    if total <= 0.0 || !linear::factor(&mut matrix, n) {
        return None;
    }
    linear::solve(&matrix, &mut right);
    let explained: f64 = normal.iter().zip(&right).map(|(b, x)| b * x).sum();
    // A sine explains itself by its acceleration.
    let by_position = count * right[0].powi(2);
    Some(Regression {
        slope: right[0] / sizes[0],
        explained: explained / total,
        by_position: by_position / total,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::table::ElementPlace;
    use crate::survey::figures::Figures;
    use crate::survey::read::{Column, Source};

    fn survey(columns: Vec<Vec<f64>>) -> Survey {
        let column = |(k, values): (usize, Vec<f64>)| Column {
            name: format!("c{k}"),
            number: k + 1,
            unit: String::new(),
            place: ElementPlace::Alone,
            time_unit: None,
            figures: Figures::of(&values, &[]),
            values,
        };
        let source = Source {
            columns: columns.into_iter().enumerate().map(column).collect(),
            ..Source::default()
        };
        Survey {
            sources: vec![source],
            ..Survey::default()
        }
    }

    /// A soft joint that carries a weight: motor before a gearbox of 60.5, link, torque.
    fn soft_joint() -> Vec<Vec<f64>> {
        let link = |t: f64| 0.6 * t.sin() + 0.1 * (3.3 * t).sin();
        let row = |k: i32| {
            let t = 0.002 * f64::from(k);
            let weight = 20.0 * link(t).sin();
            let friction = 3.0 * (link(t + 0.001) - link(t - 0.001)).signum();
            [
                60.5 * (link(t) + weight / 200.0),
                link(t),
                weight + friction,
            ]
        };
        let rows: Vec<[f64; 3]> = (0..6000).map(row).collect();
        (0..3)
            .map(|k| rows.iter().map(|row| row[k]).collect())
            .collect()
    }

    #[test]
    fn the_deflection_of_the_spring_does_not_bias_a_gear_ratio() {
        let survey = survey(soft_joint());
        let found = slope(&survey, (0, 0), (0, 1), Some((0, 2))).unwrap();
        assert!((found.value / 60.5 - 1.0).abs() < 1e-3, "{found:?}");
        // Without the torque the weight makes the slope a tenth too large.
        let without = slope(&survey, (0, 0), (0, 1), None).unwrap();
        assert!(without.value / 60.5 > 1.03, "{without:?}");
    }

    #[test]
    fn a_gap_between_parts_is_no_motion() {
        let mut columns = soft_joint();
        for column in &mut columns {
            column.drain(1000..3500);
        }
        let mut survey = survey(columns);
        survey.sources[0].joins = vec![1000];
        let found = slope(&survey, (0, 0), (0, 1), Some((0, 2))).unwrap();
        assert!((found.value / 60.5 - 1.0).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn columns_that_do_not_move_together_have_no_slope() {
        let mut columns = soft_joint();
        columns[0] = (0..6000).map(|k| (0.02 * f64::from(k)).cos()).collect();
        assert_eq!(slope(&survey(columns), (0, 0), (0, 1), None), None);
        let still = survey(vec![vec![1.0; 500], vec![2.0; 500]]);
        assert_eq!(slope(&still, (0, 0), (0, 1), None), None);
    }
}
