//! Times one sample of recursive least squares with forgetting, for 15 parameters.

use divan::{Bencher, black_box};
use sprung_base::demo;
use sprung_core::recursive::{ForgettingLeastSquares, Settings, memory_len};
use sprung_method::estimate::Lsff;
use sprung_method::preprocess::RawBlock;
use sprung_model::Model;
use sprung_robot::{self as description, no_files};

/// Number of parameters of the paper's arm, and the columns with entries in each row.
const PARAMETERS: usize = 15;
const ROW_COLUMNS: [&[usize]; 4] = [
    &[0, 1, 2, 5, 9, 11],
    &[1, 2, 6, 10, 12],
    &[3, 7, 9, 13],
    &[4, 8, 10, 14],
];

fn main() {
    divan::main();
}

/// The work of a controller per sample: forgetting and four rows.
#[divan::bench(sample_size = 1000)]
fn core_step(bencher: Bencher) {
    let settings = Settings {
        forgetting: 1.0,
        initial_gain: 10.0,
        gain_limit: 1e8,
        period: 1e-3,
    };
    let memory = [0.0; memory_len(PARAMETERS)];
    let mut lsff = ForgettingLeastSquares::new(&settings, PARAMETERS, memory).expect("settings");
    // Rows that vary keep the gain bounded.
    let rows: Vec<[[f64; PARAMETERS]; 4]> = (0..64)
        .map(|k| {
            ROW_COLUMNS.map(|columns| {
                let mut row = [0.0; PARAMETERS];
                for (at, &column) in columns.iter().enumerate() {
                    row[column] = (0.1 * f64::from(k) * (1 + at) as f64).sin();
                }
                row
            })
        })
        .collect();
    let mut samples = rows.iter().cycle();
    bencher.bench_local(move || {
        lsff.forget();
        for row in samples.next().into_iter().flatten() {
            lsff.update(black_box(row), 0.5);
        }
        lsff.theta()[0]
    });
}

/// The complete work of `sprung identify` per sample: velocities, filters, recursion, trace.
#[divan::bench(sample_size = 1000)]
fn whole_step(bencher: Bencher) {
    let experiment =
        description::read("demo", demo::EXPERIMENT, &[], &mut no_files).expect("the demo is right");
    let model = Model::new(&experiment).expect("the demo is right");
    let mut lsff = Lsff::new(&model, &experiment.identify, 1e-3).expect("settings");
    let mut time = 0.0_f64;
    bencher.bench_local(move || {
        time += 1e-3;
        let position = vec![vec![(7.0 * time).sin()], vec![(3.0 * time).cos()]];
        lsff.process(black_box(&RawBlock {
            time: vec![time],
            later: 0.0,
            q: position.clone(),
            phi: position.clone(),
            tau: position,
            spring: Vec::new(),
            begin: 0.0,
            inertial: Vec::new(),
            rate: Vec::new(),
            acceleration: Vec::new(),
            excess: vec![Vec::new(); 2],
        }));
    });
}
