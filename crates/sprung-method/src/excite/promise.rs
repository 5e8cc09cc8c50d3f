//! The standard errors of a motion, and the changes that reduce them.

use std::collections::BTreeMap;

use super::bounds::Bounds;
use super::design::information;
use super::fourier::Series;
use super::information_matrix::Information;
use super::result::{More, Promised};
use super::task::{Frequencies, Task, scales};
use crate::description::Experiment;
use crate::model::Model;

/// Factor of a standard error from which a remedy is reported.
const WORTH: f64 = 1.3;

/// Amplitudes of a larger motion.
const LARGER: f64 = 1.5;

/// Tilt of the base, rad.
const TILT: f64 = 0.5;

/// Returns the promise of an information matrix.
#[must_use]
pub fn promise(
    (model, theta): (&Model, &[f64]),
    bounds: &Bounds,
    information: &Information,
) -> Vec<Promised> {
    let errors = information.standard_errors();
    let least = scales(model, theta, bounds);
    let parameters = model.parameters().iter().zip(theta);
    (parameters.filter(|(parameter, _)| parameter.fixed.is_none()))
        .zip(errors.iter().zip(least))
        .map(|((parameter, &value), (&standard_error, scale))| Promised {
            name: parameter.name.clone(),
            unit: parameter.unit.to_owned(),
            value,
            standard_error,
            relative_percent: (value != 0.0).then(|| 100.0 * standard_error / value.abs()),
            is_determined: standard_error < scale,
            cure: None,
        })
        .collect()
}

/// A change of an experiment, and the standard errors of the free parameters with it.
struct Change {
    words: String,
    errors: Vec<Option<f64>>,
}

/// Writes the change that determines each undetermined parameter best, by the surrogate of the search.
///
/// - `experiment`, `values`: the robot and its values by name, for another tilt of its base.
pub fn add_cures(
    promise: &mut [Promised],
    task: &Task<'_>,
    (frequencies, series): (&Frequencies, &Series),
    experiment: &Experiment,
    values: &BTreeMap<String, f64>,
) {
    if promise.iter().all(|promised| promised.is_determined) {
        return;
    }
    let Some(now) = information(task, frequencies, series) else {
        return;
    };
    let now = now.standard_errors();
    let mut changes = Vec::new();
    let mut add = |words: String, matrix: Option<Information>| {
        if let Some(matrix) = matrix {
            let errors = matrix.standard_errors().into_iter().map(Some).collect();
            changes.push(Change { words, errors });
        }
    };
    add(
        format!("amplitudes {LARGER} times as large"),
        information(task, frequencies, &series.scaled(LARGER)),
    );
    let of_rate = |factor: f64| {
        let frequencies = Frequencies {
            rate: frequencies.rate * factor,
            ..frequencies.clone()
        };
        let series = Series {
            rate: series.rate * factor,
            ..series.clone()
        };
        information(task, &frequencies, &series)
    };
    add("the same motion at half the speed".to_owned(), of_rate(0.5));
    add("the same motion 1.5 times as fast".to_owned(), of_rate(1.5));
    if let Some(change) = tilted(task, (frequencies, series), experiment, values) {
        changes.push(change);
    }
    for (place, promised) in promise
        .iter_mut()
        .enumerate()
        .filter(|(_, promised)| !promised.is_determined)
    {
        let gain = |change: &Change| {
            let error = change.errors.get(place).copied().flatten();
            error.map_or(0.0, |error| now[place] / error)
        };
        let best = (changes.iter()).max_by(|a, b| gain(a).total_cmp(&gain(b)));
        promised.cure = Some(match best {
            Some(change) if gain(change) > WORTH => format!(
                "with {} its standard error falls by a factor of {:.1}",
                change.words,
                gain(change)
            ),
            _ => "neither amplitude nor speed nor a tilt of the base determines it; a longer experiment, a payload, or \
                  sensors with less noise may"
                .to_owned(),
        });
    }
}

/// Returns the errors with another tilt of the base.
fn tilted(
    task: &Task<'_>,
    (frequencies, series): (&Frequencies, &Series),
    experiment: &Experiment,
    values: &BTreeMap<String, f64>,
) -> Option<Change> {
    let mut experiment = experiment.clone();
    experiment.robot.tree.as_ref()?;
    let [x, y, z] = experiment.robot.gravity();
    let (sin, cos) = TILT.sin_cos();
    experiment.robot.gravity_m_per_s2 = Some([x, cos * y - sin * z, sin * y + cos * z]);
    let model = Model::new(&experiment).ok()?;
    let theta = model.theta(values).or_else(|_| model.nominal()).ok()?;
    let tilted_task = Task {
        model: &model,
        theta: &theta,
        known: None,
        chosen: &[],
        ..task.clone()
    };
    let errors = information(&tilted_task, frequencies, series)?.standard_errors();
    let free: Vec<&str> = (model.parameters().iter())
        .filter(|parameter| parameter.fixed.is_none())
        .map(|parameter| parameter.name.as_str())
        .collect();
    let of = |name: &str| {
        free.iter()
            .position(|other| *other == name)
            .map(|place| errors[place])
    };
    Some(Change {
        words: format!("a base tilted by {:.0}°", TILT.to_degrees()),
        errors: (task.model.parameters().iter())
            .filter(|parameter| parameter.fixed.is_none())
            .map(|parameter| of(&parameter.name))
            .collect(),
    })
}

/// Returns the standard errors with more experiments: the motion again, and further motions.
#[must_use]
pub fn more(
    (model, theta): (&Model, &[f64]),
    bounds: &Bounds,
    information: &Information,
    others: &[(&str, &Information)],
) -> Vec<More> {
    let now = information.standard_errors();
    let of = |what: &str, information: &Information| {
        let errors = information.standard_errors();
        let logs = errors.iter().zip(&now).map(|(then, now)| (then / now).ln());
        let mean = logs.sum::<f64>() / now.len().max(1) as f64;
        More {
            what: what.to_owned(),
            factor: mean.exp(),
            undetermined: (errors.iter().zip(scales(model, theta, bounds)))
                .filter(|(error, scale)| **error >= *scale)
                .count(),
        }
    };
    let mut all = vec![
        of("the motion twice", &information.times(2.0)),
        of("the motion four times", &information.times(4.0)),
    ];
    all.extend((others.iter()).map(|(what, added)| of(what, &information.with(added))));
    all
}
