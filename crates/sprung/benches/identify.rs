//! Least squares from CSV in memory to parameters, for 10 s and for 1000 s.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
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

/// The demo with least squares alone, its model, and a log of it.
fn demo_of(seconds: u32) -> (Experiment, Model, Shared) {
    let mut experiment =
        description::read("demo", demo::EXPERIMENT, &[], &mut no_files).expect("the demo is right");
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    let model = Model::new(&experiment).expect("the demo is right");
    let truth: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).expect("the demo is right");
    let mut settings = experiment.simulate.clone().expect("the demo has one");
    settings.duration_s = f64::from(seconds);
    let log = experiment.log.as_ref().expect("the demo has one");
    let channels = Channels::new(&experiment.robot, log).expect("the demo is right");
    let setup = TwinSetup {
        model: &model,
        theta: &model.theta(&truth).expect("the demo is right"),
        controller: experiment.controller.as_ref().expect("the demo has one"),
        settings: &settings,
    };
    let mut csv = Vec::new();
    record(&setup, &channels, &mut csv, &mut |_| {}).expect("the demo is stable");
    (experiment, model, Shared(Arc::new(csv)))
}

fn bench_identify(bencher: Bencher, seconds: u32) {
    let (experiment, model, csv) = demo_of(seconds);
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
