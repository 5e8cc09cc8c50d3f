//! Least squares on logs that one set of parameters or one cut-off does not describe.

use sprung_base::progress::Unheard;
use sprung_method::estimate::{Identification, identify};
use sprung_robot::Estimator;
use sprung_testing::contains;

use crate::support::{Twin, with_sources};

fn identified(twin: &Twin, log: &[u8]) -> Identification {
    let mut experiment = twin.experiment.clone();
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    with_sources(&[log], |sources| {
        let found = identify(&experiment, &twin.model, sources, &mut Unheard);
        found.unwrap().identification
    })
}

fn log(twin: &Twin, seed: u64, duration_s: f64, counts: u32) -> Vec<u8> {
    let mut settings = twin.experiment.simulate.clone().unwrap();
    settings.seed = seed;
    settings.duration_s = duration_s;
    settings.link_encoder_counts_per_turn = vec![counts; 2];
    settings.motor_encoder_counts_per_turn = vec![counts; 2];
    twin.log(&settings)
}

fn lines(log: &[u8]) -> Vec<String> {
    let text = std::str::from_utf8(log).unwrap();
    text.lines().map(str::to_owned).collect()
}

#[test]
fn a_log_whose_halves_are_two_robots_is_named() {
    let (empty, mut loaded) = (Twin::new(), Twin::new());
    for (name, factor) in [
        ("link1.inertia_total", 1.2),
        ("link2.coupling", 1.5),
        ("link2.inertia", 1.5),
    ] {
        let index = loaded.model.index_of(name).unwrap();
        loaded.truth[index] *= factor;
    }
    let (first, second) = (
        lines(&log(&empty, 1, 24.0, 16384)),
        lines(&log(&loaded, 1, 24.0, 16384)),
    );
    let half = first.len() / 2;
    let both = [&first[..half], &second[half..]].concat().join("\n");
    let changed = identified(&empty, both.as_bytes());
    let warnings = &changed.results[0].warnings;
    let named = warnings.iter().find(|f| f.code == "parts-disagree");
    let named = named.expect("the change is named");
    assert!(named.parameters.contains(&"link2.inertia".to_owned()));
    // The interval contains both robots.
    let inertia = changed.results[0].parameter("link2.inertia").unwrap();
    let [low, high] = inertia.ci95.unwrap();
    let index = empty.model.index_of("link2.inertia").unwrap();
    assert!(low < empty.truth[index] && loaded.truth[index] < high);
    assert!(inertia.error_parts.unwrap().between_parts > inertia.error_parts.unwrap().sampling);

    let one = identified(&empty, first.join("\n").as_bytes());
    let codes = || one.results[0].warnings.iter().map(|f| f.code.as_str());
    assert!(
        !codes().any(|code| code == "parts-disagree"),
        "{:?}",
        codes().collect::<Vec<_>>()
    );
    assert_eq!(one.results[0].parts.len(), 4);
}

#[test]
fn errors_of_the_positions_in_the_band_of_the_noise_lower_the_cutoff() {
    let twin = Twin::new();
    let fine = log(&twin, 1, 10.0, 1 << 22);
    let clean = identified(&twin, &fine).settings;
    assert!((clean.position_cutoff_hz - 40.0).abs() < 1e-9);
    let choice = clean.position_cutoff_choice.unwrap();
    let held_out = |hz: f64| {
        let near = |point: &&sprung_method::estimate::CutoffPoint| {
            (point.cutoff_hz / hz - 1.0).abs() < 0.01
        };
        choice
            .sweep
            .iter()
            .find(near)
            .unwrap()
            .held_out_residual
            .unwrap()
    };
    assert!(held_out(40.0) < held_out(10.0));

    // A ripple of 24 Hz on the motor positions, which no torque causes.
    let rippled: Vec<String> = (lines(&fine).into_iter().enumerate())
        .map(|(k, line)| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if k > 0 {
                for (cell, size) in [(3, 1.5e-3), (4, 1.5e-3)] {
                    let value: f64 = cells[cell].parse().unwrap();
                    let ripple = size * (std::f64::consts::TAU * 24.0 * 1e-3 * k as f64).sin();
                    cells[cell] = format!("{}", value + ripple);
                }
            }
            cells.join(",")
        })
        .collect();
    let found = identified(&twin, rippled.join("\n").as_bytes());
    assert!(found.settings.position_cutoff_hz < 24.0);
    let choice = found.settings.position_cutoff_choice.unwrap();
    contains(&choice.reason, &["held-out"]);
    let residuals = || {
        choice
            .sweep
            .iter()
            .filter_map(|point| point.held_out_residual)
    };
    let least = residuals().fold(f64::INFINITY, f64::min);
    let chosen = (choice.sweep.iter())
        .find(|point| (point.cutoff_hz / found.settings.position_cutoff_hz - 1.0).abs() < 1e-9);
    // Cut-offs of the same error within its scatter are alike, and the highest of them is taken.
    assert!(chosen.unwrap().held_out_residual.unwrap() < 1.1 * least);
}
