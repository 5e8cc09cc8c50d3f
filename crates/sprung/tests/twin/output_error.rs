//! Output error on the paper's twin, whose controller is exactly known.
//!
//! `cargo test --release --package sprung --test twin -- output_error --nocapture`
//! prints a table; `SPRUNG_SEEDS=10` makes it longer.

use sprung::description::{Controller, Estimator, Simulate};
use sprung::estimate::{EstimateResult, identify};

use crate::support::{Twin, with_source};

/// A seed and what the controller of the file has wrong.
fn run(settings: &Simulate, change: impl Fn(&mut Controller)) -> EstimateResult {
    let mut twin = Twin::new();
    let log = twin.log(settings);
    twin.experiment.identify.estimator = vec![Estimator::OutputError];
    change(twin.experiment.controller.as_mut().unwrap());
    with_source(&log, |source| {
        let found = identify(&twin.experiment, &twin.model, &mut [source], &mut |_| ());
        found.unwrap().identification.results.remove(0)
    })
}

fn settings(seed: u64, counts: u32) -> Simulate {
    let mut settings = Twin::new().experiment.simulate.unwrap();
    settings.seed = seed;
    settings.link_encoder_counts_per_turn = vec![counts; 2];
    settings.motor_encoder_counts_per_turn = vec![counts; 2];
    settings
}

/// Errors of all parameters, percent.
fn errors(result: &EstimateResult) -> Vec<f64> {
    let truth = Twin::new().truth;
    (result.parameters.iter().zip(&truth))
        .map(|(p, t)| 100.0 * (p.value.unwrap() / t - 1.0))
        .collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.iter_mut().for_each(|v| *v = v.abs());
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn inside(result: &EstimateResult) -> usize {
    let truth = Twin::new().truth;
    let within = |(p, t): &(&sprung::estimate::ParameterEstimate, &f64)| {
        let [low, high] = p.ci95.unwrap();
        (low..=high).contains(*t)
    };
    result.parameters.iter().zip(&truth).filter(within).count()
}

fn seeds() -> u64 {
    let seeds = std::env::var("SPRUNG_SEEDS").ok();
    seeds.and_then(|seeds| seeds.parse().ok()).unwrap_or(2)
}

fn has(result: &EstimateResult, code: &str) -> bool {
    result.warnings.iter().any(|finding| finding.code == code)
}

#[test]
fn exact_controller_reaches_the_noise_of_the_encoders() {
    for (counts, most) in [(16384, 0.03), (4096, 0.1)] {
        let (mut all, mut covered) = (Vec::new(), 0);
        for seed in 0..seeds() {
            let result = run(&settings(seed, counts), |_| ());
            let errors = errors(&result);
            let fit = result.simulation.as_ref().unwrap();
            println!(
                "{counts} seed {seed}: median {:.4} %, cost per sample {:.3}, {} iterations, {:.2} s; \
                 {errors:.3?}",
                median(errors.clone()),
                fit.cost_per_sample,
                fit.iterations,
                result.elapsed_s
            );
            assert!((0.9..1.1).contains(&fit.cost_per_sample), "{fit:?}");
            assert!(!has(&result, "controller-does-not-match"));
            covered += inside(&result);
            all.extend(errors);
        }
        let share = 100.0 * covered as f64 / all.len() as f64;
        let found = median(all);
        println!("{counts}: median {found:.4} %, {share:.0} % of the intervals hold the truth");
        assert!(found <= most, "{counts}: {found}");
        assert!(share >= 75.0, "{counts}: {share}");
    }
}

#[test]
fn what_is_wrong_with_the_loop_is_said() {
    let show = |what: &str, result: &EstimateResult| {
        println!(
            "{what}: median {:.3} %, {:?}",
            median(errors(result)),
            result.simulation
        );
        for finding in &result.warnings {
            println!(
                "  {:?} {}: {}",
                finding.severity, finding.code, finding.text
            );
        }
    };
    let exact = settings(3, 16384);
    let gain = run(&exact, |c| {
        c.kp_nm_per_rad.iter_mut().for_each(|k| *k *= 1.02)
    });
    show("position gains 2 % wrong", &gain);
    let damping = run(&exact, |c| {
        c.kd_nms_per_rad.iter_mut().for_each(|k| *k *= 1.1)
    });
    show("velocity gains 10 % wrong", &damping);
    let half = run(&exact, |c| c.kp_nm_per_rad[0] *= 0.5);
    show("first position gain halved", &half);
    let mut disturbed = exact.clone();
    disturbed.torque_disturbance_nm = vec![0.05, 0.01];
    let disturbed = run(&disturbed, |_| ());
    show("disturbed motors", &disturbed);
}
