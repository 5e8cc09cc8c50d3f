//! The refinement on the digital twin: errors, coverage, disturbances.
//!
//! `cargo test --release --package sprung --test twin -- refined --nocapture`
//! prints the numbers.

use sprung::description::Estimator;
use sprung::estimate::{EstimateResult, identify};

use crate::support::{Twin, with_source};

/// Results of both stages for some seeds.
fn runs(
    counts: u32,
    motor: f64,
    link: f64,
    seeds: std::ops::Range<u64>,
) -> Vec<Vec<EstimateResult>> {
    let mut twin = Twin::new();
    twin.experiment.identify.estimator = vec![Estimator::LeastSquares, Estimator::PredictionError];
    let run = |seed| {
        let mut settings = twin.experiment.simulate.clone().unwrap();
        settings.seed = seed;
        settings.link_encoder_counts_per_turn = vec![counts; 2];
        settings.motor_encoder_counts_per_turn = vec![counts; 2];
        settings.torque_disturbance_nm = vec![motor, motor / 5.0];
        settings.link_torque_disturbance_nm = vec![link; 2];
        with_source(&twin.log(&settings), |source| {
            identify(&twin.experiment, &twin.model, &mut [source], &mut |_| ())
                .unwrap()
                .identification
                .results
        })
    };
    seeds.map(run).collect()
}

struct Summary {
    median: f64,
    worst: f64,
    coverage: f64,
}

fn summary(runs: &[Vec<EstimateResult>], estimator: usize) -> Summary {
    let truth = Twin::new().truth;
    let (mut errors, mut inside, mut worst) = (Vec::new(), 0, 0.0_f64);
    for (i, t) in truth.iter().enumerate() {
        let mut squares = 0.0;
        let (mut mean, mut own) = (0.0, 0);
        let mut error = 0.0;
        for run in runs {
            let p = &run[estimator].parameters[i];
            let relative = 100.0 * (p.value.unwrap() / t - 1.0);
            errors.push(relative.abs());
            squares += relative * relative;
            mean += relative;
            error += 100.0 * p.standard_error.unwrap() / t;
            let [low, high] = p.ci95.unwrap();
            own += usize::from(low <= *t && *t <= high);
        }
        let count = runs.len() as f64;
        let rms = (squares / count).sqrt();
        println!(
            "  {:22} mean {:8.3} rms {:8.3} s.e. {:8.3} ratio {:5.2} inside {own}",
            runs[0][estimator].parameters[i].name,
            mean / count,
            rms,
            error / count,
            rms / (error / count)
        );
        inside += own;
        worst = worst.max(rms);
    }
    errors.sort_by(f64::total_cmp);
    Summary {
        median: errors[errors.len() / 2],
        worst,
        coverage: 100.0 * inside as f64 / errors.len() as f64,
    }
}

fn env(name: &str, default: f64) -> f64 {
    std::env::var(name)
        .ok()
        .and_then(|x| x.parse().ok())
        .unwrap_or(default)
}

#[test]
fn refined_twin() {
    let seeds = env("SEEDS", 4.0) as u64;
    for counts in [16384, 4096] {
        for (motor, link) in [(0.0, 0.0), (0.05, 0.0), (0.0, 0.01)] {
            if env("COUNTS", f64::from(counts)) != f64::from(counts)
                || env("MOTOR", motor) != motor
                || env("LINK", link) != link
            {
                continue;
            }
            let start = std::time::Instant::now();
            let runs = runs(counts, motor, link, 0..seeds);
            let elapsed = start.elapsed().as_secs_f64() / seeds as f64;
            for estimator in 1..2 {
                let s = summary(&runs, estimator);
                println!(
                    "{counts} counts, motor {motor} link {link} N·m, {}: median {:.3} %, worst {:.1} %, inside {:.0} %, {elapsed:.2} s, took {:.2}",
                    runs[0][estimator].estimator,
                    s.median,
                    s.worst,
                    s.coverage,
                    runs[0][estimator].elapsed_s
                );
            }
        }
    }
}
