//! Least squares of many logs by map and reduce.

use std::sync::OnceLock;

use sprung::session::{Choices, LogFactors, Session};
use sprung_base::progress::Unheard;
use sprung_method::compare::{Compared, compare};
use sprung_method::estimate::{Identification, Identified};

use crate::support::{Memory, files, in_memory, messages};

const NAMES: [&str; 5] = ["run0.csv", "run1.csv", "run2.csv", "run3.csv", "run4.csv"];

/// Duration and seed of each log.
const LOGS: [(&str, u64); 5] = [("6.0", 1), ("3.0", 2), ("4.0", 3), ("5.0", 4), ("3.5", 5)];

/// Settings with as many choices as possible.
const CHOSEN: [&str; 5] = [
    "identify.estimator=[\"least-squares\"]",
    "log.file=[\"run0.csv\", \"run1.csv\", \"run2.csv\", \"run3.csv\", \"run4.csv\"]",
    "log.sign={ tau1_nm = \"estimate\" }",
    "log.delay_s={ q1_rad = \"estimate\" }",
    "identify.position_cutoff_hz=\"auto\"",
];

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

fn factors(session: &Session, choices: &Choices) -> Vec<LogFactors> {
    let of_log = |index| session.factors(choices, index, &mut Unheard).unwrap();
    (0..NAMES.len()).map(of_log).collect()
}

fn merged<'a>(all: impl IntoIterator<Item = &'a LogFactors>) -> LogFactors {
    let mut all = all.into_iter().cloned();
    let first = all.next().unwrap();
    all.fold(first, |all, next| all.merge(next).unwrap())
}

fn estimates(found: &Identified) -> Vec<(f64, f64)> {
    let parameters = found.identification.results[0].parameters.iter();
    parameters
        .map(|parameter| (parameter.value.unwrap(), parameter.standard_error.unwrap()))
        .collect()
}

/// The choices pass through JSON, as between machines.
#[test]
fn factors_give_the_parameters_of_one_pass() {
    let session = session(&CHOSEN);
    let choices = session.choices(&mut Unheard).unwrap();
    let stored = serde_json::to_string(&choices).unwrap();
    let choices: Choices = serde_json::from_str(&stored).unwrap();
    let all = factors(&session, &choices);
    let found = session
        .identify_factors(&merged(&all), &mut Unheard)
        .unwrap();
    let expected = session.identify(&mut Unheard).unwrap();
    for (found, expected) in estimates(&found).iter().zip(estimates(&expected)) {
        assert!(
            (found.0 / expected.0 - 1.0).abs() < 1e-10,
            "{found:?} {expected:?}"
        );
        // Segments have other borders.
        assert!(
            (0.7..1.4).contains(&(found.1 / expected.1)),
            "{found:?} {expected:?}"
        );
    }
    let (by_factors, one_pass) = (&found.identification, &expected.identification);
    assert_eq!(by_factors.log, one_pass.log);
    assert_eq!(by_factors.further_logs, one_pass.further_logs);
    assert_eq!(by_factors.settings, one_pass.settings);
    let (by_factors, one_pass) = (&by_factors.results[0], &one_pass.results[0]);
    assert_eq!(by_factors.parts.len(), one_pass.parts.len());
    assert_eq!(by_factors.verdict, one_pass.verdict);
    for (part, one_pass) in by_factors.parts.iter().zip(&one_pass.parts) {
        assert!((part.from_s - one_pass.from_s).abs() < 1e-9);
        for (value, one_pass) in part.values.iter().zip(&one_pass.values) {
            assert_eq!(value.is_some(), one_pass.is_some());
            let ratio = value
                .zip(*one_pass)
                .map_or(1.0, |(value, other)| value.0 / other.0);
            assert!((ratio - 1.0).abs() < 1e-8, "{ratio}");
        }
    }
}

/// All choices are made again when a law is added.
#[test]
fn estimated_signs_stay_when_a_law_is_added() {
    let session = session(&[
        CHOSEN[0],
        CHOSEN[1],
        CHOSEN[2],
        "identify.laws=\"auto\"",
        "robot.joint.joint1.motor_friction=[\"viscous\"]",
    ]);
    let expected = session.identify(&mut Unheard).unwrap().identification;
    let unknowns = &expected.unknowns;
    let laws = || unknowns.iter().filter_map(|unknown| unknown.used_law());
    assert!(laws().any(|law| law.law == "coulomb"), "{unknowns:?}");
    assert!(expected.log.signs()["tau1_nm"] > 0.0);
    let mut codes = expected
        .findings
        .iter()
        .map(|finding| finding.code.as_str());
    assert!(codes.any(|code| code == "sign-estimated"));
    let choices = session.choices(&mut Unheard).unwrap();
    let all = merged(&factors(&session, &choices));
    let found = session.identify_factors(&all, &mut Unheard).unwrap();
    assert_eq!(found.identification.log, expected.log);
    assert_eq!(found.identification.unknowns, expected.unknowns);
}

#[test]
fn any_order_and_grouping_gives_the_same_bits() {
    let session = session(&CHOSEN[..2]);
    let choices = session.choices(&mut Unheard).unwrap();
    let all = factors(&session, &choices);
    let forward = merged(&all);
    let backward = merged(all.iter().rev());
    let [a, b, c, d, e] = &all[..] else {
        panic!("five logs");
    };
    let tree = merged(&[merged([d, b]), merged([&merged([e, a]), c])]);
    assert_eq!(forward, backward);
    assert_eq!(forward, tree);
    let stored = LogFactors::from_json(&forward.to_json()).unwrap();
    assert_eq!(forward, stored);
    let names: Vec<String> = stored.logs().map(|(_, name)| name).collect();
    assert_eq!(names, NAMES);
    let identified = |all: &LogFactors| {
        let found = session.identify_factors(all, &mut Unheard).unwrap();
        estimates(&found)
    };
    assert_eq!(identified(&stored), identified(&tree));
}

/// A log of 6 s with two joints.
#[test]
fn factors_are_small() {
    let session = session(&CHOSEN[..2]);
    let choices = session.choices(&mut Unheard).unwrap();
    let one = session.factors(&choices, 0, &mut Unheard).unwrap();
    assert!(one.to_json().len() < 130_000, "{}", one.to_json().len());
}

#[test]
fn factors_that_do_not_belong_together_are_refused_by_name() {
    let mut messages = messages("factors_that_do_not_belong_together");
    let session = session(&CHOSEN[..2]);
    let choices = session.choices(&mut Unheard).unwrap();
    let [one, two]: [LogFactors; 2] =
        [0, 1].map(|log| session.factors(&choices, log, &mut Unheard).unwrap());
    let merge = |other: LogFactors| one.clone().merge(other).unwrap_err().to_string();
    messages.note("a log twice", &merge(one.clone()));
    for more in [
        "robot.name=\"other arm\"",
        "identify.filter_cutoff_rad_per_s=20.0",
        "log.file=[\"run2.csv\", \"run1.csv\"]",
    ] {
        let other = in_memory(memory().clone(), &[&CHOSEN[..2], &[more]].concat());
        let choices = other.choices(&mut Unheard).unwrap();
        let factors = other.factors(&choices, 1, &mut Unheard).unwrap();
        messages.note(more, &merge(factors));
    }
    let text = two.to_json();
    let newer = text.replace("\"generator\":\"sprung 0", "\"generator\":\"sprung 99");
    let newer = LogFactors::from_json(&newer).unwrap();
    // The number of this version stays out of the file.
    assert!(merge(newer).contains("sprung 99"));
    let format = text.replacen("\"format\":1", "\"format\":2", 1);
    for (name, text) in [("another format", &*format), ("no JSON", "{")] {
        let error = LogFactors::from_json(text).unwrap_err();
        messages.note(name, &error.to_string());
    }
    let short = text.replacen("\"at_rest\":[", "\"at_rest\":[7,", 1);
    let short = LogFactors::from_json(&short).unwrap();
    let short = one.clone().merge(short).unwrap();
    let error = session.identify_factors(&short, &mut Unheard).unwrap_err();
    messages.note("one number too many", &error.to_string());
    let cutoff = ["identify.filter_cutoff_rad_per_s=20.0"];
    let slower = in_memory(memory().clone(), &[&CHOSEN[..2], &cutoff].concat());
    let error = slower.factors(&choices, 0, &mut Unheard).unwrap_err();
    messages.note("choices of another experiment", &error.to_string());
    let error = slower.identify_factors(&one, &mut Unheard).unwrap_err();
    messages.note("factors of another experiment", &error.to_string());
    messages.compare();
}

#[test]
fn a_log_that_cannot_be_read_is_named() {
    let mut files = memory().clone();
    files.remove("run3.csv");
    files.insert("run2.csv", b"t_s,angle\n0.0,1.0\n0.001,1.0\n".to_vec());
    let session = in_memory(files, &CHOSEN[..2]);
    let choices = session.choices(&mut Unheard).unwrap();
    let mut messages = messages("a_log_that_cannot_be_read_is_named");
    for (name, index) in [("no file", 3), ("no such column", 2), ("no such log", 5)] {
        let error = session.factors(&choices, index, &mut Unheard).unwrap_err();
        messages.note(name, &error.to_string());
    }
    let error = session.identify(&mut Unheard).unwrap_err();
    messages.note("all logs", &error.to_string());
    messages.compare();
}

#[test]
fn combined_results_of_single_logs_are_near_one_pass() {
    let fixed = "identify.position_cutoff_hz=25.0";
    let single: Vec<Identification> = (NAMES.iter())
        .map(|name| {
            let file = format!("log.file=\"{name}\"");
            let session = session(&[CHOSEN[0], &file, fixed]);
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
    let all = session(&[CHOSEN[0], CHOSEN[1], fixed]).identify(&mut Unheard);
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
