//! Tables of parameters and of prediction errors.

use std::collections::BTreeMap;

use sprung::check::UnknownResult;
use sprung::estimate::{EstimateResult, Identification, ParameterEstimate};
use sprung::model::short;
use sprung::report::{ShownUnknown, significant};
use sprung::validate::JointProof;

use super::layout::Grid;

pub(crate) fn dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| significant(value, digits))
}

pub(super) fn parameter_table(
    identification: &Identification,
    truth: Option<&BTreeMap<String, f64>>,
) -> Grid {
    let reference = if truth.is_some() { "true" } else { "nominal" };
    // The shares, the reference and the units are the least important columns.
    let shares = (0..identification.results.len()).map(|i| 5 + 3 * i);
    let optional: Vec<usize> = shares.chain([2, 1]).collect();
    let mut header = vec![
        "parameter".to_owned(),
        "unit".to_owned(),
        reference.to_owned(),
    ];
    for result in &identification.results {
        header.push(result.estimator.clone());
        header.push("± s.e.".to_owned());
        header.push(
            if truth.is_some() {
                "error %"
            } else {
                "% of nominal"
            }
            .to_owned(),
        );
    }
    let mut table = Grid::new(header, 2).divided(3, 3).without(&optional);
    let of = |estimate: &ParameterEstimate, reference: Option<f64>| {
        let share = estimate.value.zip(reference).filter(|(_, r)| *r != 0.0);
        let share = share.map_or_else(
            || "-".to_owned(),
            |(value, reference)| match truth {
                Some(_) => format!("{:+.1}", 100.0 * (value / reference - 1.0)),
                None => format!("{:.1}", 100.0 * value / reference),
            },
        );
        let value = match (estimate.value, identification.bound(&estimate.name)) {
            (None, Some(bound)) => bound,
            (value, _) => dash(value, 5),
        };
        // An interval that ends at the bound of the parameter has no standard error.
        let (value, error) = match estimate.at_most() {
            Some(most) => (format!("< {}", significant(most, 2)), "-".to_owned()),
            None if estimate.fixed => (value, "given".to_owned()),
            None => (value, dash(estimate.standard_error, 2)),
        };
        [value, error, share]
    };
    let shown: Vec<Vec<ParameterEstimate>> = (identification.results.iter())
        .map(EstimateResult::shown_parameters)
        .collect();
    for (i, parameter) in shown.first().into_iter().flatten().enumerate() {
        let reference = match truth {
            Some(truth) => truth.get(&parameter.name).copied(),
            None => parameter.nominal,
        };
        let mut row = vec![
            short(&parameter.label()).into_owned(),
            parameter.unit.clone(),
            dash(reference, 5),
        ];
        for parameters in &shown {
            row.extend(of(&parameters[i], reference));
        }
        table.add_row(row);
    }
    table
}

/// Maximum number of joints that share a row.
const MAX_JOINTS_PER_ROW: usize = 3;

/// Returns a table with one row per parameter set and joint.
fn error_table_by_joint(run: &sprung::validate::RunResult) -> Grid {
    let names = ["parameters", "joint", "tau", "q", "phi", "fit %", "promise"];
    let shown = |i: &usize| run.simulated || !(2..5).contains(i);
    let columns = || (0..names.len()).filter(shown);
    let mut table = Grid::new(columns().map(|i| names[i]), 2).divided(2, 1);
    for set in &run.sets {
        for joint in run.joints() {
            let e = set.e_rms.as_ref();
            let error = |values: Option<&sprung::named::Named>| match values {
                Some(values) => dash(values.get(joint), 3),
                None => set.outcome.words().to_owned(),
            };
            let share = set.torque_relative_residual.get(joint);
            let cells = [
                set.parameters.clone(),
                joint.to_owned(),
                error(e.map(|e| &e.tau_nm)),
                error(e.map(|e| &e.q_rad)),
                error(e.map(|e| &e.phi_rad)),
                share.map_or_else(|| "-".to_owned(), |share| format!("{:.1}", 100.0 * share)),
                promise((set.predictions.iter()).filter(|prediction| prediction.joint == joint)),
            ];
            table.add_row(columns().map(|i| cells[i].clone()));
        }
    }
    table
}

/// Returns the table of springs by deflections and joint torques.
pub(super) fn spring_table(identification: &Identification) -> Grid {
    let header = ["joint", "stiffness", "± s.e.", "95 % from", "to"];
    let mut table = Grid::new(header, 1).divided(1, 4);
    for spring in &identification.sensed_springs {
        let [from, to] = spring.ci95_nm_per_rad;
        table.add_row([
            spring.joint.clone(),
            significant(spring.stiffness_nm_per_rad, 5),
            significant(spring.standard_error_nm_per_rad, 2),
            significant(from, 5),
            significant(to, 5),
        ]);
    }
    table
}

/// Most characters of a column in the table of unknowns, so that the table has at most 80.
const LONGEST_PLACE: usize = 18;

/// Returns the table of what a log shows beyond its description.
pub(super) fn unknown_table(found: &[UnknownResult]) -> Grid {
    let header = ["unknown", "place", "size ± s.e.", "used", "falls %"];
    let mut table = Grid::new(header, 2).divided(2, 3);
    for unknown in found {
        let shown = ShownUnknown::from(unknown);
        table.add_row([
            shown.what,
            if unknown.place.contains(", ") {
                shown.place
            } else {
                shortened(&shown.place)
            },
            shown.size,
            shown.used.to_owned(),
            shown.falls_percent,
        ]);
    }
    table
}

/// Returns the name of a column, with its middle left out if it is too long: names differ at their ends.
fn shortened(place: &str) -> String {
    let letters: Vec<char> = place.chars().collect();
    if letters.len() <= LONGEST_PLACE {
        return place.to_owned();
    }
    let first = LONGEST_PLACE / 2;
    let last = letters.len() - (LONGEST_PLACE - first - 1);
    letters[..first]
        .iter()
        .chain(&['…'])
        .chain(&letters[last..])
        .collect()
}

pub(super) fn error_table(run: &sprung::validate::RunResult) -> Grid {
    let joints = run.joints();
    if joints.len() > MAX_JOINTS_PER_ROW {
        return error_table_by_joint(run);
    }
    let simulated: &[&str] = if run.simulated {
        &["tau", "q", "phi"]
    } else {
        &[]
    };
    let mut header = vec!["parameters".to_owned()];
    for symbol in simulated {
        header.extend(joints.iter().map(|joint| format!("{symbol} {joint}")));
    }
    header.extend(joints.iter().map(|joint| format!("{joint} fit %")));
    header.push("promise".to_owned());
    let mut table = Grid::new(header, 1).divided(1, joints.len());
    for set in &run.sets {
        let mut row = vec![set.parameters.clone()];
        for group in 0..simulated.len() {
            row.extend(joints.iter().map(|joint| match &set.e_rms {
                Some(e) => {
                    let values = [&e.tau_nm, &e.q_rad, &e.phi_rad][group];
                    dash(values.get(joint), 3)
                }
                None => set.outcome.words().to_owned(),
            }));
        }
        row.extend(joints.iter().map(|joint| {
            let share = set.torque_relative_residual.get(joint);
            share.map_or_else(|| "-".to_owned(), |share| format!("{:.1}", 100.0 * share))
        }));
        row.push(promise(set.predictions.iter()));
        table.add_row(row);
    }
    table
}

/// Returns whether errors keep their promise, with the largest ratio of error to promised error.
fn promise<'a>(proofs: impl Iterator<Item = &'a JointProof>) -> String {
    let largest = (proofs.flat_map(JointProof::quantities))
        .filter_map(|quantity| Some((quantity.ratio?, quantity.is_broken())))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match largest {
        None => "-".to_owned(),
        Some((ratio, true)) => format!("broken, {ratio:.1} times"),
        Some((ratio, false)) => format!("kept, {ratio:.1} times"),
    }
}
