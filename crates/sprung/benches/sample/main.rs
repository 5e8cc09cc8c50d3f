//! Times 1000 draws of robots with seven joints: of the twin with flexible joints, and of the recorded Panda, with many
//! parameters at their bounds.
//!
//! `cargo bench -p sprung --bench sample`
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

use std::io::{Cursor, Error, ErrorKind, Result as IoResult};
use std::path::Path;
use std::time::Instant;

use sprung::session::{Parameters, SampleRequest, Session};
use sprung_base::progress::Unheard;
use sprung_log::Input;
use sprung_method::estimate::{DrawMethod, Identification};

const EXPERIMENT: &str = include_str!("../../../../examples/seven-joint-twin/experiment.toml");
const TRUTH: &str = include_str!("../../../../examples/seven-joint-twin/truth.toml");

const OVERRIDES: [&str; 2] = [
    "simulate.duration_s=15.0",
    "identify.estimator=[\"least-squares\"]",
];

const SEEDS: u64 = 5;

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("cargo bench -p sprung --bench sample prints the table");
        return;
    }
    println!("robot    new+draw s  effective  accepted share, or chains and sweeps between robots");
    let session = twin(Vec::new());
    let mut log = Vec::new();
    let recording = session.twin(None, None).expect("the twin is described");
    recording
        .write(&mut log, &mut Unheard)
        .expect("the twin is stable");
    print("twin", &twin(log));
    if let Some(path) = sprung_testing::data("franka_panda/experiment.toml") {
        let overrides = OVERRIDES[1..].iter().map(|line| (*line).to_owned());
        let session = Session::open(&path, &overrides.collect::<Vec<_>>());
        print("Panda", &session.expect("the experiment is right"));
    }
}

/// Returns a session of the twin whose log is in memory.
fn twin(log: Vec<u8>) -> Session {
    let open = move |path: &Path| -> IoResult<Box<dyn Input>> {
        let is = |end: &str| path.extension().is_some_and(|extension| extension == end);
        if is("toml") {
            Ok(Box::new(Cursor::new(TRUTH.as_bytes().to_vec())))
        } else if log.is_empty() {
            Err(Error::from(ErrorKind::NotFound))
        } else {
            Ok(Box::new(Cursor::new(log.clone())))
        }
    };
    let overrides: Vec<String> = OVERRIDES.iter().map(|line| (*line).to_owned()).collect();
    Session::read("experiment.toml", EXPERIMENT, &overrides, open).expect("the twin is right")
}

/// Prints times and independence of draws.
fn print(robot: &str, session: &Session) {
    let identified = session.identify(&mut Unheard).expect("the log is right");
    let found: Identification = identified.identification;
    let result = &found.results[0];
    println!(
        "{robot}: {} parameters, verdict {}",
        result.parameters.len(),
        result.verdict.word()
    );
    let parameters = Parameters::from(found);
    for seed in 0..SEEDS {
        let request = SampleRequest {
            seed,
            accept_unusable: true,
            ..SampleRequest::default()
        };
        let start = Instant::now();
        let samples = session
            .sample(&parameters, &request)
            .expect("the result has a covariance");
        let elapsed = start.elapsed().as_secs_f64();
        let how = match samples.method {
            DrawMethod::Rejection { accepted } => format!("{:.0} %", 100.0 * accepted),
            DrawMethod::Gibbs { chains, sweeps } => format!("{chains} chains, {sweeps} sweeps"),
        };
        println!("{robot:8} {elapsed:10.3}  {:9.0}  {how}", samples.effective);
    }
}
