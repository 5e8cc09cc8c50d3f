//! Times least squares from CSV in memory to parameters: the demo's arm for 10 s and for 1000 s,
//! and an arm with seven flexible joints for a minute and for an hour.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_log::{Channels, Input, LogSource};
use sprung_method::estimate::identify;
use sprung_method::simulate::{TwinSetup, record};
use sprung_model::Model;
use sprung_robot::{self as description, Cutoff, Estimator, Experiment, no_files};

/// Bytes shared by all opened readers.
#[derive(Clone)]
struct Shared(Arc<Vec<u8>>);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

fn main() {
    divan::main();
}

const SEVEN: &str = include_str!("../../../examples/seven-joint-twin/experiment.toml");
const SEVEN_TRUTH: &str = include_str!("../../../examples/seven-joint-twin/truth.toml");

/// A twin's experiment with least squares only, its model, and a simulated log.
struct Recorded {
    experiment: Experiment,
    model: Model,
    csv: Shared,
}

fn log_of(experiment: &str, truth: &str, seconds: u32) -> Recorded {
    let mut experiment =
        description::read("twin", experiment, &[], &mut no_files).expect("the twin is right");
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    let model = Model::new(&experiment).expect("the twin is right");
    let truth: BTreeMap<String, f64> = toml::from_str(truth).expect("the twin is right");
    let mut settings = experiment.simulate.clone().expect("the twin has one");
    settings.duration_s = f64::from(seconds);
    let log = experiment.log.as_ref().expect("the twin has one");
    let channels = Channels::new(&experiment.robot, log).expect("the twin is right");
    let setup = TwinSetup {
        model: &model,
        theta: &model.theta(&truth).expect("the twin is right"),
        controller: experiment.controller.as_ref().expect("the twin has one"),
        settings: &settings,
    };
    let mut csv = Vec::new();
    record(&setup, &channels, &mut csv, &mut Unheard).expect("the twin is stable");
    Recorded {
        experiment,
        model,
        csv: Shared(Arc::new(csv)),
    }
}

/// Identifies from `logs` logs of 15 s. Each log is read, filtered and reduced separately.
fn bench_seven(bencher: Bencher, logs: usize, threads: usize) {
    let Recorded {
        mut experiment,
        model,
        csv,
    } = log_of(SEVEN, SEVEN_TRUTH, 15);
    experiment.identify.position_cutoff_hz = Cutoff::Fixed(40.0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads");
    // A test run needs only one log.
    let logs = if std::env::args().any(|word| word == "--bench") {
        logs
    } else {
        1
    };
    let samples = 15_000 * logs;
    bencher.counter(ItemsCount::new(samples)).bench_local(|| {
        let open = |_: Option<&Path>| Ok(Box::new(Cursor::new(csv.clone())) as Box<dyn Input>);
        let mut readers = vec![open; logs];
        let mut sources: Vec<LogSource<'_>> = (readers.iter_mut())
            .map(|reader| LogSource::files("seven.csv", reader))
            .collect();
        pool.install(|| {
            identify(&experiment, &model, &mut sources, &mut Unheard).expect("the twin is right")
        })
    });
}

#[divan::bench(sample_count = 3, sample_size = 1, args = [1, 2])]
fn a_minute_of_seven_joints(bencher: Bencher, threads: usize) {
    bench_seven(bencher, 4, threads);
}

#[divan::bench(sample_count = 1, sample_size = 1, args = [1, 2])]
fn an_hour_of_seven_joints(bencher: Bencher, threads: usize) {
    bench_seven(bencher, 240, threads);
}

fn bench_identify(bencher: Bencher, seconds: u32) {
    let Recorded {
        experiment,
        model,
        csv,
    } = log_of(demo::EXPERIMENT, demo::TRUTH, seconds);
    bencher
        .counter(BytesCount::of_slice(csv.as_ref()))
        .counter(ItemsCount::new(1000 * seconds))
        .bench_local(|| {
            let mut reader =
                |_: Option<&Path>| Ok(Box::new(Cursor::new(csv.clone())) as Box<dyn Input>);
            let source = LogSource::files("demo.csv", &mut reader);
            identify(&experiment, &model, &mut [source], &mut Unheard).expect("the demo is right")
        });
}

#[divan::bench(sample_count = 20)]
fn ten_seconds(bencher: Bencher) {
    bench_identify(bencher, 10);
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn a_million_samples(bencher: Bencher) {
    bench_identify(bencher, 1000);
}
