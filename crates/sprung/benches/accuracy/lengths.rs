//! Coverage of the intervals of least squares for short and long logs.

use rayon::prelude::*;
use sprung_method::estimate::{EstimateResult, Verdict};
use sprung_robot::Estimator;
use sprung_testing::Figure;

use crate::figures::median;
use crate::logs::Demo;
use crate::{Arguments, CASES, result_of, truth};

/// Logs of at least this length, s, take much memory, so few of them are made, one after another.
const LONG_S: f64 = 300.0;
const SEEDS_OF_LONG: u64 = 3;

/// Prints, for each case and length: the coverage of the confidence intervals and of the sampling errors alone, the
/// ratio of the half width of an interval to the actual error, and the verdicts.
pub(crate) fn lengths(demo: &Demo, arguments: &Arguments) {
    let mut experiment = demo.experiment.clone();
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    println!(
        "\nleast squares, logs of several lengths, 16384 counts\n{:8} {:>7} {:>5} {:>9} {:>11} {:>14} {:>14} {:>5}",
        "", "s", "logs", "inside %", "sampling %", "width/error", "sampling only", "good"
    );
    for &length in &arguments.lengths {
        for (case, motor, link) in CASES.iter().filter(|case| arguments.wants(case.0)) {
            let run = |seed: u64| {
                let mut settings = demo.settings(seed);
                settings.duration_s = length;
                settings.link_encoder_counts_per_turn = vec![16384; 2];
                settings.motor_encoder_counts_per_turn = vec![16384; 2];
                settings.torque_disturbance_nm = motor.to_vec();
                settings.link_torque_disturbance_nm = link.to_vec();
                result_of(&experiment, &demo.log(&settings))
            };
            let seeds = arguments.seeds.clone();
            let results: Vec<EstimateResult> = if length < LONG_S {
                seeds.into_par_iter().map(run).collect()
            } else {
                let end = seeds.end.min(seeds.start + SEEDS_OF_LONG);
                (seeds.start..end).map(run).collect()
            };
            row(case, length, demo, &results);
        }
    }
}

fn row(case: &str, length: f64, demo: &Demo, results: &[EstimateResult]) {
    let truth = truth(demo);
    // Error and half widths of the interval, with all errors and with the sampling error alone.
    let figures: Vec<[f64; 3]> = (results.iter())
        .flat_map(|result| result.parameters.iter().zip(&truth))
        .filter_map(|(p, (_, truth))| {
            let [low, high] = p.ci95?;
            let half = 0.5 * (high - low);
            let sampling = half * p.error_parts?.sampling / p.standard_error?;
            Some([(p.value? - truth).abs(), half, sampling])
        })
        .collect();
    let count = figures.len() as f64;
    let share = |which: usize| {
        let inside = figures.iter().filter(|f| f[0] <= f[which]).count();
        100.0 * inside as f64 / count
    };
    let ratio = |which: usize| median(figures.iter().map(|f| f[which] / f[0]).collect());
    let good = (results.iter()).filter(|result| result.verdict == Verdict::Good);
    println!(
        "{case:8} {length:7} {:5} {:9.1} {:11.1} {:14.2} {:14.2} {:5}",
        results.len(),
        share(1),
        share(2),
        ratio(1),
        ratio(2),
        good.count()
    );
    let text = format!(
        "{case}, {length} s, {} logs: 95 % intervals with the truth",
        results.len()
    );
    Figure::neutral(&format!("{case}, {length} s"), &text, share(1), "%").note();
}
