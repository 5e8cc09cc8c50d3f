//! Many logs of one robot.

use std::sync::OnceLock;

use sprung::session::Session;
use sprung_base::progress::Unheard;
use sprung_method::compare::{Compared, compare};
use sprung_method::estimate::{Identification, Identified};

use crate::support::{Memory, files, in_memory, messages};

const NAMES: [&str; 5] = ["run0.csv", "run1.csv", "run2.csv", "run3.csv", "run4.csv"];

/// Duration and seed of each log.
const LOGS: [(&str, u64); 5] = [("6.0", 1), ("3.0", 2), ("4.0", 3), ("5.0", 4), ("3.5", 5)];

const LINEAR: &str = "identify.estimator=[\"least-squares\"]";
const ALL: &str = "log.file=[\"run0.csv\", \"run1.csv\", \"run2.csv\", \"run3.csv\", \"run4.csv\"]";

fn memory() -> &'static Memory {
    static LOGS_OF_ALL: OnceLock<Memory> = OnceLock::new();
    LOGS_OF_ALL.get_or_init(|| {
        let mut all = files().clone();
        for (name, (duration, seed)) in NAMES.into_iter().zip(LOGS) {
            let duration = format!("simulate.duration_s={duration}");
            let session = in_memory(all.clone(), &[&duration]);
            let twin = session.twin(None, None).unwrap().with_seed(seed);
            let mut log = Vec::new();
            twin.write(&mut log, &mut Unheard).unwrap();
            all.insert(name, log);
        }
        all
    })
}

fn session(overrides: &[&str]) -> Session {
    in_memory(memory().clone(), overrides)
}

fn estimates(found: &Identified) -> Vec<(f64, f64)> {
    let parameters = found.identification.results[0].parameters.iter();
    parameters
        .map(|parameter| (parameter.value.unwrap(), parameter.standard_error.unwrap()))
        .collect()
}

#[test]
fn a_log_that_cannot_be_read_is_named() {
    let mut files = memory().clone();
    files.remove("run3.csv");
    files.insert("run2.csv", b"t_s,angle\n0.0,1.0\n0.001,1.0\n".to_vec());
    let mut messages = messages("a_log_that_cannot_be_read_is_named");
    for (name, logs) in [
        ("no file", "log.file=[\"run0.csv\", \"run3.csv\"]"),
        ("no such column", "log.file=[\"run0.csv\", \"run2.csv\"]"),
        ("all logs", ALL),
    ] {
        let session = in_memory(files.clone(), &[LINEAR, logs]);
        let error = session.identify(&mut Unheard).unwrap_err();
        messages.note(name, &error.to_string());
    }
    messages.compare();
}

#[test]
fn combined_results_of_single_logs_are_near_one_pass() {
    let fixed = "identify.position_cutoff_hz=25.0";
    let single: Vec<Identification> = (NAMES.iter())
        .map(|name| {
            let file = format!("log.file=\"{name}\"");
            let session = session(&[LINEAR, &file, fixed]);
            session.identify(&mut Unheard).unwrap().identification
        })
        .collect();
    let compared: Vec<Compared<'_>> = (NAMES.iter().zip(&single))
        .map(|(file, identification)| Compared {
            file,
            identification,
        })
        .collect();
    let comparison = compare(&compared, &[]).unwrap();
    let [combined] = &comparison.combined[..] else {
        panic!("one estimator");
    };
    assert_eq!(combined.results.len(), NAMES.len());
    let all = session(&[LINEAR, ALL, fixed]).identify(&mut Unheard);
    let all = estimates(&all.unwrap());
    assert_eq!(combined.parameters.len(), all.len());
    for (parameter, one_pass) in combined.parameters.iter().zip(all) {
        let apart = (parameter.value - one_pass.0).abs() / one_pass.1;
        let ratio = parameter.standard_error / one_pass.1;
        assert!(
            apart < 1.0 && (0.4..2.5).contains(&ratio),
            "{parameter:?} {one_pass:?}"
        );
    }
    let twice = compare(&[compared[0], compared[0]], &[]).unwrap();
    assert!(twice.combined.is_empty());
}
