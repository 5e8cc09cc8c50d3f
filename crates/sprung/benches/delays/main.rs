//! Measures the accuracy of estimated delays on logs of the demo's twin.
//!
//! `cargo bench -p sprung --bench delays -- --seeds 2` runs `identify` with `delay_s = { column = "estimate" }` for every
//! channel and for delays from 0 to 20 ms.
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]
#![expect(clippy::expect_used, reason = "a benchmark may panic")]

#[path = "../../tests/twin/in_memory.rs"]
mod in_memory;
#[path = "../faults/twin.rs"]
#[expect(dead_code, reason = "the logs of another benchmark")]
mod twin;

use in_memory::with_source;
use rayon::prelude::*;
use sprung_base::progress::Unheard;
use sprung_method::estimate::identify;
use sprung_model::Model;
use sprung_robot::{Delay, Estimator};
use sprung_testing::Figure;
use twin::{Demo, Table};

const COLUMNS: [&str; 6] = [
    "q1_rad", "q2_rad", "phi1_rad", "phi2_rad", "tau1_nm", "tau2_nm",
];

/// Delays in ms, which equal samples of the demo.
const SIZES: [usize; 6] = [0, 1, 2, 5, 10, 20];

struct Arguments {
    seeds: u64,
    columns: Vec<usize>,
    sizes: Vec<usize>,
}

impl Arguments {
    /// Reads the command line. Returns `None` if `cargo bench` did not start the program.
    fn new() -> Option<Self> {
        let mut found = Self {
            seeds: 2,
            columns: (0..COLUMNS.len()).collect(),
            sizes: SIZES.to_vec(),
        };
        let mut bench = false;
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().expect("an argument lacks its value");
            match word.as_str() {
                "--bench" => bench = true,
                "--seeds" => found.seeds = value().parse().expect("--seeds is a number"),
                "--columns" => found.columns = numbers(&value()),
                "--sizes" => found.sizes = numbers(&value()),
                other => panic!("no argument {other}"),
            }
        }
        bench.then_some(found)
    }
}

fn numbers(list: &str) -> Vec<usize> {
    let parts = list.split(',').map(str::parse);
    parts
        .collect::<Result<_, _>>()
        .expect("numbers with commas between them")
}

fn main() {
    let Some(arguments) = Arguments::new() else {
        return;
    };
    let demo = Demo::new();
    table("identify, told which channel", &arguments, |log, column| {
        told(&demo, log, column)
    });
}

/// Prints the largest error for each channel and delay, in ms.
fn table(
    name: &str,
    arguments: &Arguments,
    find: impl Fn(&Table, usize) -> Result<f64, String> + Sync,
) {
    println!("{name}: largest error in ms of {} logs", arguments.seeds);
    let head: Vec<String> = (arguments.sizes.iter())
        .map(|size| format!("{size:>9} ms"))
        .collect();
    println!("  {:8} {}", "channel", head.join(" "));
    let demo = Demo::new();
    for &column in &arguments.columns {
        let cells: Vec<(String, Vec<String>)> = (arguments.sizes.par_iter())
            .map(|&samples| {
                let found: Vec<Result<f64, String>> = (0..arguments.seeds)
                    .into_par_iter()
                    .map(|seed| {
                        let log = demo.table(2000 + seed, 1.0).delayed(column, samples);
                        find(&log, column).map(|delay| (1e3 * delay - samples as f64).abs())
                    })
                    .collect();
                let wrong: Vec<String> = found.iter().filter_map(|f| f.clone().err()).collect();
                let largest = found.into_iter().filter_map(Result::ok).fold(0.0, f64::max);
                let cell = if wrong.is_empty() {
                    format!("{largest:.4}")
                } else {
                    format!("{} wrong", wrong.len())
                };
                (cell, wrong)
            })
            .collect();
        let largest = (cells.iter())
            .map(|(cell, _)| cell.parse().unwrap_or(f64::INFINITY))
            .fold(0.0, f64::max);
        if largest < f64::INFINITY {
            let text = format!("{name}, `{}`: largest error", COLUMNS[column]);
            let key = format!("{name}, {}", COLUMNS[column]);
            Figure::lower(&key, &text, largest, "ms")
                .scatter(0.02)
                .note();
        }
        let row: Vec<String> = cells
            .iter()
            .map(|(cell, _)| format!("{cell:>12}"))
            .collect();
        println!("  {:8} {}", COLUMNS[column], row.join(" "));
        for why in cells.iter().flat_map(|(_, wrong)| wrong) {
            println!("      {why}");
        }
    }
}

/// Returns the delay that an identification finds for a channel declared as late, s.
fn told(demo: &Demo, log: &Table, column: usize) -> Result<f64, String> {
    let mut experiment = demo.experiment.clone();
    experiment.identify.estimator = vec![Estimator::PredictionError];
    let name = COLUMNS[column];
    let described = experiment.log.as_mut().expect("the demo has a log");
    described.delay_s.insert(name.to_owned(), Delay::Estimate);
    let model = Model::new(&experiment).expect("the twin has a model");
    let found = with_source(&log.csv(), |source| {
        identify(&experiment, &model, &mut [source], &mut Unheard)
    })
    .map_err(|error| error.to_string())?
    .identification;
    let result = &found.results[0];
    let codes: Vec<&str> = (found.findings.iter().chain(&result.warnings))
        .filter(|finding| finding.code.contains("delay") || finding.code.contains("failed"))
        .map(|finding| finding.text.as_str())
        .collect();
    let refined = result.refined().ok_or_else(|| format!("{codes:?}"))?;
    let found = refined.delays.iter().find(|delay| delay.column == name);
    found
        .map(|delay| delay.delay_s)
        .ok_or_else(|| format!("{codes:?}"))
}
