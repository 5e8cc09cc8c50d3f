//! Counts the verdicts that held-out data refute, on generated cases.
//!
//! `cargo bench -p sprung --bench verdicts` prints the table. Each case is a random arm of 1 to 7
//! joints with logs of one kind of experiment. A case is one of four kinds: the model matches the
//! robot, the model lacks an effect, the description of the log is wrong, or the excitation is
//! weak. sprung identifies the parameters from the first log and predicts another log. Arguments
//! after `--` change the extent:
//!
//! - `--cases 100`: number of cases of each kind.
//! - `--first 3100`: seed of the first case. The rules were tuned on seeds below 3100 only.
//! - `--estimators prediction-error,least-squares`: estimators; all identify the same logs.
//! - `--kinds matched,misfit`: only kinds whose names contain one of these words.
//! - `--faults Saturation`: only cases whose fault contains one of these words.
//! - `--each`: one line per case.
//! - `--parameters`: besides, the errors of each parameter in its standard errors, one per log.
//! - `--keep FOLDER`: writes the identification and the true parameters of each case into this folder.
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

mod arm;
mod case;
mod columns;
mod faults;
#[path = "../../tests/twin/in_memory.rs"]
mod in_memory;
mod kind;
mod motion;
mod outcome;
mod sensors;
mod table;
mod truth;

use std::path::PathBuf;

use rayon::prelude::*;
use sprung_robot::Estimator;

use crate::case::Case;
use crate::kind::Kind;
use crate::outcome::{Outcome, outcomes};

struct Arguments {
    cases: u64,
    first: u64,
    estimators: Vec<Estimator>,
    kinds: Vec<String>,
    faults: Vec<String>,
    each: bool,
    parameters: bool,
    keep: Option<PathBuf>,
}

impl Arguments {
    /// Reads the command line. Returns `None` if `cargo bench` did not start the program.
    ///
    /// # Panics
    ///
    /// If an argument is unknown or has no valid value.
    fn new() -> Option<Self> {
        let mut found = Self {
            cases: 100,
            first: 3100,
            estimators: vec![Estimator::PredictionError, Estimator::LeastSquares],
            kinds: vec![String::new()],
            faults: vec![String::new()],
            each: false,
            parameters: false,
            keep: None,
        };
        let mut bench = false;
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().expect("an argument lacks its value");
            match word.as_str() {
                "--bench" => bench = true,
                "--cases" => found.cases = value().parse().expect("--cases is a number"),
                "--first" => found.first = value().parse().expect("--first is a number"),
                "--estimators" => {
                    found.estimators = (value().split(','))
                        .map(|word| Estimator::try_from(word.to_owned()).expect("an estimator"))
                        .collect();
                }
                "--kinds" => found.kinds = value().split(',').map(str::to_owned).collect(),
                "--faults" => found.faults = value().split(',').map(str::to_owned).collect(),
                "--each" => found.each = true,
                "--parameters" => found.parameters = true,
                "--keep" => found.keep = Some(value().into()),
                other => panic!("no argument {other}"),
            }
        }
        bench.then_some(found)
    }
}

fn main() {
    let Some(arguments) = Arguments::new() else {
        return;
    };
    let wanted =
        |kind: &Kind| (arguments.kinds.iter()).any(|word| kind.name().contains(word.as_str()));
    let cases: Vec<(Kind, u64)> = (Kind::ALL.into_iter().filter(wanted))
        .flat_map(|kind| {
            (arguments.first..arguments.first + arguments.cases).map(move |seed| (kind, seed))
        })
        .collect();
    let outcomes: Vec<Outcome> = (cases.into_par_iter())
        .with_max_len(1)
        .flat_map_iter(|(kind, seed)| {
            let case = Case::new(kind, seed);
            let fault = format!("{:?}", case.fault);
            if !(arguments.faults.iter()).any(|word| fault.contains(word.as_str())) {
                return Vec::new();
            }
            let found = outcomes(&case, &arguments.estimators, arguments.keep.as_deref());
            if arguments.each {
                for outcome in &found {
                    println!("{}", outcome.line());
                    if arguments.parameters {
                        println!("{}", outcome.parameters().join("\n"));
                    }
                }
            }
            found
        })
        .collect();
    for estimator in &arguments.estimators {
        table::print(estimator.name(), &outcomes);
    }
    println!(
        "seeds {} to {}",
        arguments.first,
        arguments.first + arguments.cases - 1
    );
}
