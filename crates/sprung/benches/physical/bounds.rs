//! Values near their bounds: wrists with little friction.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sprung_base::progress::Unheard;
use sprung_method::estimate::identify;
use sprung_model::Model;
use sprung_robot::{self as description, Estimator, no_files};
use sprung_testing::Figure;

use super::in_memory::with_source;
use super::{DURATION_S, EXPERIMENT, TRUTH, Twin, known};

/// Noise of the torques, N·m.
const NOISE: f64 = 2.0;

/// Friction of the links beyond this joint is this part of that of the example.
const WRISTS: [&str; 3] = ["joint5", "joint6", "joint7"];
const LIGHT: f64 = 0.02;

/// Ends of the groups: distance of the truth from zero, in standard errors without constraints.
const GROUPS: [(&str, f64, f64); 3] = [
    ("at most 0.5", 0.0, 0.5),
    ("0.5 to 2", 0.5, 2.0),
    ("above 2", 2.0, f64::INFINITY),
];

/// A value that must not be negative, in standard errors without constraints.
struct Value {
    truth: f64,
    /// Errors with and without constraints.
    errors: [f64; 2],
    /// Whether each interval contains the truth.
    holds: [bool; 2],
}

/// Prints errors and intervals of friction, stiffnesses and rotor inertias beside those without constraints.
pub(super) fn bounds(seeds: u32) {
    println!(
        "\nTwin with seven joints, {DURATION_S} s, torque noise {NOISE} N·m, a fiftieth of the friction in the wrists, {seeds} \
         logs. Distances and errors in standard errors without constraints.\n"
    );
    println!(
        "| truth from zero | values | root mean square error without constraints | with | ratio | intervals that hold |"
    );
    println!("|---|---|---|---|---|---|");
    let all: Vec<Value> = (1..=seeds).into_par_iter().flat_map(draw).collect();
    for (name, from, to) in GROUPS {
        let within = || all.iter().filter(|value| (from..to).contains(&value.truth));
        let count = within().count() as f64;
        let [with, without] = [0, 1]
            .map(|i| (within().map(|value| value.errors[i].powi(2)).sum::<f64>() / count).sqrt());
        let holds =
            [0, 1].map(|i| 100.0 * within().filter(|value| value.holds[i]).count() as f64 / count);
        println!(
            "| {name} | {count} | {without:.2} | {with:.2} | {:.2} | {:.0} % ({:.0} %) |",
            with / without,
            holds[0],
            holds[1]
        );
        let of = format!("true values {name} standard errors from their bounds, {count} values");
        let ratio = format!("{of}: root mean square error over that without constraints");
        Figure::lower(
            &format!("bounds, {name}, error"),
            &ratio,
            with / without,
            "",
        )
        .note();
        let inside = format!("{of}: 95 % intervals that contain the truth");
        Figure::neutral(&format!("bounds, {name}, inside"), &inside, holds[0], "%").note();
    }
}

fn draw(seed: u32) -> Vec<Value> {
    let mut values: BTreeMap<String, f64> =
        toml::from_str(TRUTH).expect("the example has true values");
    for (name, value) in &mut values {
        let is_light = WRISTS.iter().any(|joint| name.starts_with(joint));
        if is_light && (name.ends_with("viscous") || name.ends_with("coulomb")) {
            *value *= LIGHT;
        }
    }
    let mut experiment = description::read("arm", EXPERIMENT, &[], &mut no_files)
        .expect("the example is an experiment");
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    let twin = Twin {
        experiment: &experiment,
        model: &Model::new(&experiment).expect("the example is a robot"),
        values: &values,
    };
    let log = twin.log((NOISE, seed), DURATION_S);
    experiment.robot.nominal.clear();
    let model = Model::new(&experiment).expect("the example is a robot");
    let found = with_source(&log, |source| {
        identify(&experiment, &model, &mut [source], &mut Unheard)
            .expect("the twin's log can be identified")
    });
    let truth = (model.theta(&known(&model, &values))).expect("all values are known");
    let result = &found.identification.results[0];
    (result.parameters.iter().zip(&truth).zip(model.parameters()))
        .filter(|(_, parameter)| {
            (parameter.joint).is_some_and(|(kind, _)| kind.is_vital() || kind.is_friction())
        })
        .filter_map(|((parameter, truth), _)| {
            let error = parameter.error_by_equations()?;
            let (value, plain, [low, high]) =
                (parameter.value?, parameter.unconstrained?, parameter.ci95?);
            Some(Value {
                truth: truth / error,
                errors: [value, plain].map(|value| (value - truth) / error),
                holds: [
                    low <= *truth && *truth <= high,
                    (plain - truth).abs() < 2.04 * error,
                ],
            })
        })
        .collect()
}
