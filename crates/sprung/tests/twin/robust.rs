//! The refinement on other robots, from other starts, and on logs of different robots.
//!
//! `cargo bench -p sprung --bench accuracy -- --cases robots,starts --seeds 100` runs more of them.

use sprung_base::progress::Unheard;
use sprung_method::estimate::identify;
use sprung_robot::Estimator;

use crate::searches;
use crate::support::{Twin, with_sources};

/// Length of the logs, s. Distances are in standard errors, which grow as logs become shorter, so the limits hold for
/// any length.
const DURATION_S: f64 = 5.0;

/// A normal variable exceeds this number of standard errors once in 16 000.
const FAR: f64 = 4.0;

/// Standard errors between the ends of two searches. Several noise levels may explain a log about equally well, and
/// they weigh its samples differently.
const SAME: f64 = 1.0;

#[test]
fn random_robots_are_found() {
    for seed in 0..2 {
        let search = searches::random(seed, DURATION_S);
        let (name, away) = search.worst();
        println!(
            "robot {seed}: {} runs, {name} is {away:.1} standard errors away",
            search.runs
        );
        assert_eq!(search.failure, None, "robot {seed}");
        assert!(away < FAR, "robot {seed}: {name} {away}");
    }
}

#[test]
fn nominal_values_lead_where_least_squares_lead() {
    // Coarse encoders, and disturbed links.
    for index in [1, 3] {
        let search = searches::from_nominal_values(index, DURATION_S);
        let (name, away) = search.worst();
        println!(
            "log {index}: {} runs, {name} is {away:.2} standard errors away",
            search.runs
        );
        assert_eq!(search.failure, None, "log {index}");
        assert!(away < SAME, "log {index}: {name} {away}");
    }
}

#[test]
fn logs_of_two_robots_disagree() {
    let (one, mut other) = (Twin::new(), Twin::new());
    let softer = other.model.index_of("joint1.stiffness").unwrap();
    other.truth[softer] *= 0.9;
    let mut settings = one.experiment.simulate.clone().unwrap();
    settings.duration_s = DURATION_S;
    let mut experiment = one.experiment.clone();
    experiment.identify.estimator = vec![Estimator::PredictionError];
    let both = |first: &[u8], second: &[u8]| {
        with_sources(&[first, second], |sources| {
            let found = identify(&experiment, &one.model, sources, &mut Unheard).unwrap();
            let all = found.identification.results[0].warnings.clone();
            all.into_iter().find(|f| f.code == "logs-disagree")
        })
    };
    let first = one.log(&settings);
    settings.seed += 1;
    assert_eq!(both(&first, &one.log(&settings)), None);
    let finding = both(&first, &other.log(&settings)).unwrap();
    println!("{}", finding.text);
    assert!(finding.parameters.contains(&"joint1.stiffness".to_owned()));
}
