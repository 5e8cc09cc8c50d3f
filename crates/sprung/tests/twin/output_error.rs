//! Output error on the paper's twin, whose controller is exactly known.
//!
//! `cargo bench -p sprung --bench accuracy -- --methods output --cases clean` prints a table of ten logs.

use sprung_base::finding::Severity;
use sprung_base::progress::Unheard;
use sprung_method::estimate::{EstimateResult, ParameterEstimate, Verdict, identify};
use sprung_robot::{Controller, Estimator, Simulate};
use sprung_testing::least_inside;

use crate::in_memory::with_source;
use crate::support::Twin;

/// Largest median error of one log, percent: those of ten logs and four standard errors of a median of 15 errors, each
/// 0.30 of it (refined.rs).
const MEDIAN_OF_16384: f64 = 0.017 * 2.2;
const MEDIAN_OF_4096: f64 = 0.100 * 2.2;

/// Four standard errors of the cost of a sample, a mean of squares over 10 000 samples of four positions: `4 √(2/n)`.
const COST_LIMIT: f64 = 4.0 * 0.007_1;

/// Identifies a log with a controller that differs from the one that ran.
fn run(settings: &Simulate, change: impl Fn(&mut Controller)) -> EstimateResult {
    let mut twin = Twin::new();
    let log = twin.log(settings);
    twin.experiment.identify.estimator = vec![Estimator::OutputError];
    change(twin.experiment.controller.as_mut().unwrap());
    with_source(&log, |source| {
        let found = identify(&twin.experiment, &twin.model, &mut [source], &mut Unheard);
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

fn median(values: Vec<f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().map(f64::abs).collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn inside(result: &EstimateResult) -> usize {
    let truth = Twin::new().truth;
    let within = |(p, t): &(&ParameterEstimate, &f64)| {
        let [low, high] = p.ci95.unwrap();
        (low..=high).contains(*t)
    };
    result.parameters.iter().zip(&truth).filter(within).count()
}

#[test]
fn exact_controller_reaches_the_noise_of_the_encoders() {
    for (counts, most) in [(16384, MEDIAN_OF_16384), (4096, MEDIAN_OF_4096)] {
        let result = run(&settings(0, counts), |_| ());
        let errors = errors(&result);
        let fit = result.simulation.as_ref().unwrap();
        println!(
            "{counts}: cost per sample {:.3}, {} iterations; {errors:.3?}",
            fit.cost_per_sample, fit.iterations
        );
        assert!((fit.cost_per_sample - 1.0).abs() < COST_LIMIT, "{fit:?}");
        let warnings = result
            .warnings
            .iter()
            .filter(|f| f.severity > Severity::Info);
        let codes: Vec<&str> = warnings.map(|f| f.code.as_str()).collect();
        assert!(
            codes.iter().all(|code| *code == "weakly-excited"),
            "{codes:?}"
        );
        let inside = inside(&result);
        let found = median(errors);
        println!("{counts}: median {found:.4} %, {inside} of 15 intervals hold the truth");
        assert!(found <= most, "{counts}: {found}");
        assert!(inside >= least_inside(15, 0.95), "{counts}: {inside}");
    }
}

fn severity(result: &EstimateResult, code: &str) -> Option<Severity> {
    let found = result.warnings.iter().find(|finding| finding.code == code);
    found.map(|finding| finding.severity)
}

/// Prints a result and its findings, and returns the median error, percent.
fn show(what: &str, result: &EstimateResult) -> f64 {
    let error = median(errors(result));
    let cost = result.simulation.as_ref().unwrap().cost_per_sample;
    println!("{what}: median {error:.3} %, cost per sample {cost:.2}");
    for finding in &result.warnings {
        println!(
            "  {:?} {}: {}",
            finding.severity, finding.code, finding.text
        );
    }
    error
}

#[test]
fn a_wrong_scale_of_the_gains_makes_all_wrong_and_is_said() {
    let result = run(&settings(3, 16384), |c| {
        c.kp_nm_per_rad.iter_mut().for_each(|k| *k *= 1.02);
    });
    let error = show("position gains 2 % wrong", &result);
    // All parameters scale with the gains, so the error is 2 %, but for that of the right controller.
    assert!((error - 2.0).abs() < MEDIAN_OF_16384, "{error}");
    // The simulated motion fits the log although all parameters are wrong.
    let cost = result.simulation.as_ref().unwrap().cost_per_sample;
    assert!((cost - 1.0).abs() < COST_LIMIT, "{cost}");
    assert_eq!(severity(&result, "simulated-loop-differs"), None);
    // The logged torque reveals the wrong scale.
    let severity = severity(&result, "controller-torque-scale");
    assert_eq!(severity, Some(Severity::Warning));
}

#[test]
fn another_controller_is_said() {
    let result = run(&settings(3, 16384), |c| c.kp_nm_per_rad[0] *= 0.5);
    let found = severity(&result, "controller-does-not-match");
    assert_eq!(found, Some(Severity::Serious));
    let text = &result.warnings[0].text;
    assert!(
        text.starts_with("joint1: ") && text.contains("50 %"),
        "{text}"
    );
    assert_eq!(result.verdict, Verdict::Unusable);
    assert_eq!(result.simulation, None);
}

#[test]
fn a_disturbance_shows_in_the_cost() {
    let mut disturbed = settings(3, 16384);
    disturbed.torque_disturbance_nm = vec![0.05, 0.01];
    let result = run(&disturbed, |_| ());
    let error = show("disturbed motors", &result);
    // The finding says that the intervals do not contain the truth: at most 13 of 15 do.
    // The disturbance is 2 % of the torque of 50 N·m/rad at 3°, so the errors have this size, up to a factor of five.
    assert!((0.4..10.0).contains(&error), "{error}");
    assert!(inside(&result) <= 13, "{}", inside(&result));
    assert_eq!(severity(&result, "controller-does-not-match"), None);
    let found = severity(&result, "simulated-loop-differs");
    assert_eq!(found, Some(Severity::Serious));
}
