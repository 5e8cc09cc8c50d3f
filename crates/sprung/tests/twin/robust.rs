//! The refinement on other robots, and from other starts.
//!
//! `cargo test --release --package sprung --test twin -- robust --nocapture` prints
//! what was found; `SPRUNG_ROBOTS=100` and `SPRUNG_STARTS=20` make it longer.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung::description::{Estimator, Simulate, StartName};
use sprung::estimate::{EstimateResult, identify};
use sprung::finding::Severity;
use sprung::progress::Unheard;

use crate::in_memory::with_source;
use crate::support::{Twin, env, with_sources};

/// Standard errors that a parameter may be off.
const FAR: f64 = 4.0;

/// Standard errors that two ends of one search may be apart: the noise may be
/// explained in several ways, and with it the weights of the samples differ.
const SAME: f64 = 1.0;

fn refined(twin: &Twin, log: &[u8]) -> EstimateResult {
    with_source(log, |source| {
        let found = identify(&twin.experiment, &twin.model, &mut [source], &mut Unheard);
        found.unwrap().identification.results.remove(0)
    })
}

fn failed(result: &EstimateResult) -> Option<&str> {
    let own = result
        .warnings
        .iter()
        .find(|f| f.code == "refinement-failed");
    own.map(|finding| finding.text.as_str())
}

/// The demo's robot with each parameter times 0.5 to 2, and gains that move it.
fn random_robot(seed: u64) -> Twin {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut twin = Twin::new();
    twin.experiment.identify.estimator = vec![Estimator::PredictionError];
    let usual = twin.truth.clone();
    loop {
        for (value, usual) in twin.truth.iter_mut().zip(&usual) {
            *value = usual * 2.0_f64.powf(rng.random_range(-1.0..1.0));
        }
        // Not all draws are inertias of a robot.
        if twin.model.check_inertias(&twin.truth).is_ok() {
            break;
        }
    }
    let controller = twin.experiment.controller.as_mut().unwrap();
    for joint in 0..2 {
        let name = &twin.model.joints()[joint];
        let times = |what: &str| {
            let index = twin.model.index_of(&format!("{name}.{what}")).unwrap();
            twin.truth[index] / usual[index]
        };
        let factor = (["stiffness", "motor_viscous", "motor_coulomb"].into_iter())
            .map(times)
            .fold(0.0, f64::max);
        controller.kp_nm_per_rad[joint] *= factor;
        controller.kd_nms_per_rad[joint] *= factor;
    }
    twin
}

#[test]
fn random_robots_are_found() {
    let robots = env("SPRUNG_ROBOTS", 3);
    let (mut all, mut far, mut lost) = (0, 0, 0);
    for seed in 0..robots {
        let twin = random_robot(seed);
        let mut settings = twin.experiment.simulate.clone().unwrap();
        settings.seed = seed;
        let result = refined(&twin, &twin.log(&settings));
        let mut worst = (0.0, "");
        for (p, truth) in result.parameters.iter().zip(&twin.truth) {
            let size = ((p.value.unwrap() - truth) / p.standard_error.unwrap()).abs();
            all += 1;
            far += usize::from(size > FAR);
            if size > worst.0 {
                worst = (size, &p.name);
            }
        }
        let refinement = result.refinement.as_ref();
        let runs = refinement.map_or(0, |r| r.runs);
        println!(
            "robot {seed}: {runs} runs, {} off by {:.1} standard errors; {}",
            worst.1,
            worst.0,
            failed(&result).unwrap_or("converged"),
        );
        lost += usize::from(failed(&result).is_some());
    }
    println!(
        "{lost} of {robots} did not converge, {far} of {all} parameters are off by more than {FAR}"
    );
    assert_eq!(lost, 0);
    assert!(far * 100 <= all, "{far} of {all}");
}

/// Settings of logs with and without disturbances, fine and coarse counts.
fn settings(index: u64) -> Simulate {
    let mut settings = Twin::new().experiment.simulate.unwrap();
    settings.seed = 1000 + index;
    if index % 4 == 1 {
        settings.link_encoder_counts_per_turn = vec![4096; 2];
        settings.motor_encoder_counts_per_turn = vec![4096; 2];
    } else if index % 4 == 2 {
        settings.torque_disturbance_nm = vec![0.05, 0.01];
    } else if index % 4 == 3 {
        settings.link_torque_disturbance_nm = vec![0.01; 2];
    }
    settings
}

#[test]
fn robust_start_from_nominal_values() {
    let starts = env("SPRUNG_STARTS", 4);
    let mut twin = Twin::new();
    twin.experiment.identify.estimator = vec![Estimator::PredictionError];
    let (mut reached, mut silent) = (0_u64, 0);
    for index in 0..starts {
        let log = twin.log(&settings(index));
        let mut from = |start| {
            twin.experiment.identify.start = start;
            refined(&twin, &log)
        };
        let (usual, nominal) = (from(StartName::LeastSquares), from(StartName::Nominal));
        assert_eq!(failed(&usual), None);
        let mut worst = (0.0, "");
        for (a, b) in usual.parameters.iter().zip(&nominal.parameters) {
            let apart = ((a.value.unwrap() - b.value.unwrap()) / a.standard_error.unwrap()).abs();
            if apart > worst.0 {
                worst = (apart, &a.name);
            }
        }
        let said = failed(&nominal).is_some();
        let same = !said && worst.0 < SAME;
        reached += u64::from(same);
        silent += usize::from(!same && !said);
        let runs = nominal.refinement.as_ref().map_or(0, |r| r.runs);
        let loss = |r: &EstimateResult| {
            let refinement = r.refinement.as_ref();
            refinement.map_or(f64::NAN, |r| r.minus_log_likelihood)
        };
        let warnings: Vec<&str> = (nominal.warnings.iter())
            .filter(|f| f.severity > Severity::Info)
            .map(|f| f.code.as_str())
            .collect();
        println!(
            "log {index}: {runs} runs, {} {:.2} standard errors apart, likelihood {:+.1}, {warnings:?}; {}",
            worst.1,
            worst.0,
            loss(&usual) - loss(&nominal),
            failed(&nominal).unwrap_or("converged")
        );
    }
    println!("{reached} of {starts} reach the optimum, {silent} end elsewhere without a word");
    assert_eq!(silent, 0);
    assert!(20 * reached >= 19 * starts, "{reached} of {starts}");
}

#[test]
fn logs_of_two_robots_disagree() {
    let (one, mut other) = (Twin::new(), Twin::new());
    let softer = other.model.index_of("joint1.stiffness").unwrap();
    other.truth[softer] *= 0.9;
    let mut settings = one.experiment.simulate.clone().unwrap();
    settings.duration_s = 5.0;
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
