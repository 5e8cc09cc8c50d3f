//! Instrumental variables on the twin.
//!
//! `cargo test --release --package sprung --test twin -- instruments --nocapture`
//! prints the table.

use sprung::description::{Cutoff, Weights};
use sprung::estimate::{EstimateResult, identify};
use sprung::simulate::{Measured, subsystems};

use crate::linear::{COUNTS, error, error_of, runs, twin};
use crate::support::{Twin, step, with_source};

const METHOD: &str = "instrumental-variables";

#[test]
fn instruments_do_not_gain_from_noise() {
    let twin = twin(Weights::Transition);
    for counts in COUNTS {
        for disturbed in 0..3 {
            let found = runs(&twin, counts, disturbed, 1..=10);
            println!(
                "{counts}, disturbance {disturbed}: least squares {:.2} %, instruments {:.2} %, \
                 two-stage {:.2} %",
                error(&twin, &found),
                error_of(&twin, &found, METHOD),
                error_of(&twin, &found, "two-stage"),
            );
            for index in 0..twin.truth.len() {
                let of = |value: &dyn Fn(&EstimateResult) -> f64| {
                    let all = found.iter().map(|r| 100.0 * (value(r) / twin.truth[index] - 1.0));
                    let all: Vec<f64> = all.collect();
                    let mean = all.iter().sum::<f64>() / all.len() as f64;
                    let var = all.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
                    (mean, (var / all.len() as f64).sqrt())
                };
                let ls = of(&|r| r.parameters[index].value.unwrap());
                let name = &twin.model.parameters()[index].name;
                let iv = of(&|r| {
                    let check = r.cross_checks.iter().find(|c| c.method == METHOD);
                    *check.unwrap().values.get(name).unwrap()
                });
                println!("  {name}: {:.2} ± {:.2}, {:.2} ± {:.2}", ls.0, ls.1, iv.0, iv.1);
            }
        }
    }
}

#[test]
fn halves_driven_by_each_other_are_the_whole() {
    let twin = Twin::new();
    let mut plant = twin.closed_loop();
    let mut columns = vec![vec![Vec::new(); 2]; 5];
    for _ in 0..3000 {
        let state = plant.state();
        let tau = step(&mut plant);
        let all = [state.q, state.dq, state.phi, state.dphi, tau];
        for (columns, values) in columns.iter_mut().zip(all) {
            for (column, value) in columns.iter_mut().zip(values) {
                column.push(value);
            }
        }
    }
    let [q, dq, phi, dphi, tau] = &columns[..] else {
        unreachable!()
    };
    let measured = Measured { q, dq, phi, dphi, tau };
    let found = subsystems(&twin.model, &twin.truth, &measured, 1e-3).unwrap();
    let distance = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (links, motors) = (distance(&found.q, q), distance(&found.phi, phi));
    println!("links {links:.1e} rad, motors {motors:.1e} rad");
    assert!(links < 1e-4 && motors < 1e-4, "{links} {motors}");

    let mut wrong = twin.truth.clone();
    wrong[twin.model.index_of("joint1.stiffness").unwrap()] *= 1.2;
    let other = subsystems(&twin.model, &wrong, &measured, 1e-3).unwrap();
    assert!(distance(&other.q, q) > 10.0 * links);

    // Springs that push make the motion explode.
    wrong[twin.model.index_of("joint1.stiffness").unwrap()] = -1e4;
    assert!(subsystems(&twin.model, &wrong, &measured, 1e-3).is_err());
}

#[test]
fn a_refusal_says_which_column_the_simulation_does_not_show() {
    // Links that stand still say nothing of their friction.
    let twin = twin(Weights::Transition);
    let settings = twin.experiment.simulate.clone().unwrap();
    let log = twin.log(&settings);
    let found = |weights, cutoff| {
        let mut experiment = twin.experiment.clone();
        experiment.identify.weights = weights;
        experiment.identify.position_cutoff_hz = cutoff;
        with_source(&log, |source| {
            let found = identify(&experiment, &twin.model, &mut [source], &mut |_| ());
            found.unwrap().identification.results.remove(0)
        })
    };
    let methods = |result: &EstimateResult| -> Vec<String> {
        result.cross_checks.iter().map(|c| c.method.clone()).collect()
    };
    let with = found(Weights::Transition, Cutoff::Auto);
    assert_eq!(methods(&with), ["two-stage", "scale-invariant", METHOD]);
    assert!(with.warnings.iter().all(|w| w.code != "no-instruments"));
    let without = found(Weights::None, Cutoff::Auto);
    assert_eq!(methods(&without), ["two-stage", "scale-invariant"]);
    assert!(without.warnings.iter().all(|w| w.code != "no-instruments"));
}
