//! Instrumental variables on the twin.
//!
//! `cargo bench -p sprung --bench accuracy -- --methods linear --cross-checks --parameters` prints a table.

use sprung::description::{Instruments, Weights};
use sprung::estimate::identify;
use sprung::finding::{Finding, Severity};
use sprung::progress::Unheard;
use sprung::simulate::{Measured, subsystems};

use crate::in_memory::with_source;
use crate::linear::{COUNTS, error, error_of, runs, twin};
use crate::support::{Twin, step};

const METHOD: &str = "instrumental-variables";

/// Mean error in percent of one parameter over all runs.
fn bias(twin: &Twin, name: &str, values: impl Iterator<Item = f64>) -> f64 {
    let truth = twin.truth[twin.model.index_of(name).unwrap()];
    let errors: Vec<f64> = values.map(|value| 100.0 * (value / truth - 1.0)).collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[test]
fn instruments_are_no_better_than_weights_but_shrink_less() {
    let mut twin = twin(Weights::Transition);
    twin.experiment.identify.instruments = Instruments::Simulated;
    // Limits in percent: 1.25 times the median errors of ten logs without disturbances, 0.47 and 1.01 %.
    for (counts, limit) in COUNTS.into_iter().zip([1.25 * 0.47, 1.25 * 1.01]) {
        let found = runs(&twin, counts, 1..=10);
        let linear = error(&twin, &found);
        let instruments = error_of(&twin, &found, METHOD);
        let name = "joint1.stiffness";
        let own = found
            .iter()
            .map(|r| r.parameter(name).unwrap().value.unwrap());
        let checks = found.iter().flat_map(|r| &r.cross_checks);
        let others = checks.filter(|c| c.method == METHOD);
        let stiffness = [
            bias(&twin, name, own),
            bias(&twin, name, others.map(|c| c.values.get(name).unwrap())),
        ];
        println!(
            "{counts}: least squares {linear:.2} %, instruments {instruments:.2} %; \
             {name} {:+.2} and {:+.2} %",
            stiffness[0], stiffness[1]
        );
        assert!(instruments < limit, "{instruments}");
        let ratio = instruments / linear;
        assert!((0.8..1.5).contains(&ratio), "{ratio}");
        // Quantisation noise in the link rows makes the stacked stiffness too small.
        if counts == 4096 {
            assert!(stiffness[0] < -0.3, "{stiffness:?}");
            assert!(
                stiffness[1].abs() < 0.5 * stiffness[0].abs(),
                "{stiffness:?}"
            );
        }
    }
}

#[test]
fn halves_driven_by_each_other_are_the_whole() {
    let twin = Twin::new();
    let mut plant = twin.closed_loop();
    let mut columns: [Vec<Vec<f64>>; 5] = std::array::from_fn(|_| vec![Vec::new(); 2]);
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
    let [q, dq, phi, dphi, tau] = &columns;
    let measured = Measured {
        q,
        dq,
        phi,
        dphi,
        tau,
    };
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

    // With a negative stiffness the simulated motion diverges.
    wrong[twin.model.index_of("joint1.stiffness").unwrap()] = -1e4;
    assert!(subsystems(&twin.model, &wrong, &measured, 1e-3).is_err());
}

#[test]
fn a_log_without_usable_instruments_says_so() {
    let twin = twin(Weights::Transition);
    let found = |instruments, weights, counts: u32| {
        let mut settings = twin.experiment.simulate.clone().unwrap();
        settings.link_encoder_counts_per_turn = vec![counts; 2];
        settings.motor_encoder_counts_per_turn = vec![counts; 2];
        let mut experiment = twin.experiment.clone();
        experiment.identify.instruments = instruments;
        experiment.identify.weights = weights;
        let result = with_source(&twin.log(&settings), |source| {
            let found = identify(&experiment, &twin.model, &mut [source], &mut Unheard);
            found.unwrap().identification.results.remove(0)
        });
        let methods = result.cross_checks.iter().map(|c| c.method.clone());
        let refusals = result
            .warnings
            .iter()
            .filter(|w| w.code == "no-instruments");
        (
            methods.collect::<Vec<String>>(),
            refusals.cloned().collect::<Vec<Finding>>(),
        )
    };
    let (methods, refusals) = found(Instruments::Simulated, Weights::Transition, 16384);
    assert_eq!(methods, ["two-stage", "scale-invariant", METHOD]);
    assert!(refusals.is_empty(), "{refusals:?}");
    // A count is as large as the deflection of the springs.
    let (methods, refusals) = found(Instruments::Simulated, Weights::Transition, 200);
    assert!(!methods.contains(&METHOD.to_owned()), "{methods:?}");
    assert_eq!(refusals.len(), 1);
    assert_eq!(refusals[0].severity, Severity::Info);
    // Without weights, instruments bring no gain.
    let (methods, refusals) = found(Instruments::Simulated, Weights::None, 16384);
    assert_eq!(methods, ["two-stage", "scale-invariant"]);
    assert_eq!(refusals.len(), 1);
    assert!(refusals[0].text.contains("weights"), "{refusals:?}");
    // Without the setting there are no instruments and no finding about them.
    let (methods, refusals) = found(Instruments::None, Weights::Transition, 200);
    assert_eq!(methods, ["two-stage", "scale-invariant"]);
    assert!(refusals.is_empty(), "{refusals:?}");
}
