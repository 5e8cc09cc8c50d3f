//! Least squares from CSV in memory to parameters: the demo's arm for 10 s and
//! for 1000 s, an arm with seven flexible joints for a minute and for an hour.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write as _};
use std::sync::Arc;

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use sprung::demo;
use sprung::description::{self, Estimator, Experiment, no_files};
use sprung::estimate::identify;
use sprung::log::{Channels, LogSource};
use sprung::model::Model;
use sprung::simulate::{TwinSetup, record};

/// Bytes that every opened reader shares.
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

/// A twin with least squares alone, its model, and a log of it.
fn log_of(experiment: &str, truth: &str, seconds: u32) -> (Experiment, Model, Shared) {
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
    record(&setup, &channels, &mut csv, &mut |_| {}).expect("the twin is stable");
    (experiment, model, Shared(Arc::new(csv)))
}

/// A log whose rows come again and again, each at its own time.
struct Again {
    rows: Shared,
    // Where each row begins behind its time, and where it ends.
    bodies: Vec<(usize, usize)>,
    next: usize,
    total: usize,
    line: Vec<u8>,
    read: usize,
}

impl Again {
    fn new(rows: &Shared, total: usize) -> Self {
        let text = rows.as_ref();
        let mut lines = text.split_inclusive(|&b| b == b'\n');
        let header = lines.next().expect("a header").to_vec();
        let mut at = header.len();
        let bodies = lines.map(|line| {
            let comma = line.iter().position(|&b| b == b',').expect("columns");
            at += line.len();
            (at - line.len() + comma, at)
        });
        Self {
            bodies: bodies.collect(),
            rows: rows.clone(),
            next: 0,
            total,
            line: header,
            read: 0,
        }
    }
}

impl Read for Again {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if self.read == self.line.len() {
            if self.next == self.total {
                return Ok(0);
            }
            let (from, until) = self.bodies[self.next % self.bodies.len()];
            self.line.clear();
            let (seconds, rest) = (self.next / 1000, self.next % 1000);
            write!(self.line, "{seconds}.{rest:03}")?;
            self.line
                .extend_from_slice(&self.rows.as_ref()[from..until]);
            self.next += 1;
            self.read = 0;
        }
        let count = out.len().min(self.line.len() - self.read);
        out[..count].copy_from_slice(&self.line[self.read..self.read + count]);
        self.read += count;
        Ok(count)
    }
}

fn bench_seven(bencher: Bencher, minutes: usize, threads: usize) {
    let (experiment, model, csv) = log_of(SEVEN, SEVEN_TRUTH, 15);
    let samples = 60_000 * minutes;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads");
    bencher.counter(ItemsCount::new(samples)).bench_local(|| {
        let mut reader = || {
            let log = Again::new(&csv, samples);
            Ok(Box::new(std::io::BufReader::with_capacity(1 << 18, log)) as Box<dyn Read + Send>)
        };
        let source = LogSource {
            name: "seven.csv".to_owned(),
            reader: &mut reader,
        };
        let mut sources = [source];
        pool.install(|| {
            identify(&experiment, &model, &mut sources, &mut |_| {}).expect("the twin is right")
        })
    });
}

#[divan::bench(sample_count = 3, sample_size = 1, args = [1, 2])]
fn a_minute_of_seven_joints(bencher: Bencher, threads: usize) {
    bench_seven(bencher, 1, threads);
}

#[divan::bench(sample_count = 1, sample_size = 1, args = [1, 2])]
fn an_hour_of_seven_joints(bencher: Bencher, threads: usize) {
    bench_seven(bencher, 60, threads);
}

fn bench_identify(bencher: Bencher, seconds: u32) {
    let (experiment, model, csv) = log_of(demo::EXPERIMENT, demo::TRUTH, seconds);
    bencher
        .counter(BytesCount::of_slice(csv.as_ref()))
        .counter(ItemsCount::new(1000 * seconds))
        .bench_local(|| {
            let mut reader = || Ok(Box::new(Cursor::new(csv.clone())) as Box<dyn Read + Send>);
            let source = LogSource {
                name: "demo.csv".to_owned(),
                reader: &mut reader,
            };
            identify(&experiment, &model, &mut [source], &mut |_| {}).expect("the demo is right")
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
