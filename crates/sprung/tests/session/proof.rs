//! Promises on validation logs of the twin: kept without a change, and broken by a change that is named.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use sprung::session::{Parameters, Session, Usability};
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_method::estimate::Identification;
use sprung_method::validate::{ParameterSet, SetResult, Validation};
use sprung_testing::contains;

use crate::support::{Memory, in_memory};

/// Least squares alone, with the logs of the demo.
const LINEAR: [&str; 1] = ["identify.estimator=[\"least-squares\"]"];

fn session(files: Memory, more: &[&str]) -> Session {
    in_memory(files, &[&LINEAR[..], more].concat())
}

fn truth() -> BTreeMap<String, f64> {
    toml::from_str(demo::TRUTH).unwrap()
}

/// Records the log of a run with other parameters.
fn log(run: Option<&str>, values: BTreeMap<String, f64>, seed: u64) -> Vec<u8> {
    let files = Memory::from([("truth.toml", demo::TRUTH.as_bytes().to_vec())]);
    let parameters = Parameters {
        sets: vec![ParameterSet {
            label: "changed".to_owned(),
            values,
            promise: Vec::new(),
        }],
        identification: None,
    };
    let session = session(files, &[]);
    let twin = session
        .twin(run, Some(&parameters))
        .unwrap()
        .with_seed(seed);
    let mut log = Vec::new();
    twin.write(&mut log, &mut Unheard).unwrap();
    log
}

fn files(validation: Vec<u8>) -> Memory {
    static LOG: OnceLock<Vec<u8>> = OnceLock::new();
    let log = LOG.get_or_init(|| log(None, truth(), 1));
    Memory::from([
        ("truth.toml", demo::TRUTH.as_bytes().to_vec()),
        ("identification.csv", log.clone()),
        ("validation.csv", validation),
    ])
}

fn identification() -> Identification {
    static FOUND: OnceLock<Identification> = OnceLock::new();
    let identify = || {
        let session = session(files(Vec::new()), &[]);
        session.identify(&mut Unheard).unwrap().identification
    };
    FOUND.get_or_init(identify).clone()
}

fn validated(validation: Vec<u8>) -> Validation {
    validated_with(validation, &[])
}

fn validated_with(validation: Vec<u8>, overrides: &[&str]) -> Validation {
    let session = session(files(validation), overrides);
    let parameters = Parameters::from(identification());
    session
        .validate(&parameters, &mut Unheard)
        .unwrap()
        .validation
}

/// The truth with some values changed.
fn changed(change: impl Fn(&str, f64) -> f64) -> BTreeMap<String, f64> {
    let values = truth().into_iter();
    values
        .map(|(name, value)| {
            let changed = change(&name, value);
            (name, changed)
        })
        .collect()
}

/// The truth with more friction in some parameters.
fn with_friction(of: impl Fn(&str) -> bool) -> BTreeMap<String, f64> {
    let is_friction = |name: &str| name.contains("viscous") || name.contains("coulomb");
    changed(|name, value| {
        let factor = if of(name) && is_friction(name) {
            1.4
        } else {
            1.0
        };
        value * factor
    })
}

fn codes(set: &SetResult) -> Vec<&str> {
    set.findings.iter().map(|f| f.code.as_str()).collect()
}

/// Checks that a validation names a change, and returns the text of its finding and the line.
fn names(validation: &Validation, code: &str) -> (String, Option<String>) {
    assert_eq!(Usability::from(validation), Usability::Usable);
    let set = &validation.runs[1].sets[0];
    assert_eq!(codes(set), ["promise-broken", code], "{:#?}", set.findings);
    assert_eq!(set.promise_kept, Some(false));
    let sentence = validation.sentence();
    assert!(
        sentence.starts_with("The promise is broken: in prediction the "),
        "{sentence}"
    );
    let finding = set.findings[1].clone();
    let evidence = finding.evidence.unwrap();
    assert!(
        evidence.file == "validation.csv" && evidence.value > 1.5,
        "{evidence:?}"
    );
    (finding.text, finding.setting)
}

#[test]
fn without_a_change_promises_are_kept() {
    let promise = &identification().results[0].promise;
    assert_eq!(promise.len(), 2);
    for seed in 11..14 {
        let validation = validated(log(Some("prediction"), truth(), seed));
        let [direct, prediction] = &validation.runs[..] else {
            panic!("{:?}", validation.runs);
        };
        assert!(direct.same_log && !prediction.same_log);
        let set = &prediction.sets[0];
        assert_eq!(
            set.promise_kept,
            Some(true),
            "seed {seed}: {:#?}",
            set.predictions
        );
        assert_eq!(codes(set), [""; 0], "seed {seed}");
        let sentence = validation.sentence();
        assert!(
            sentence.starts_with("The promise is kept: in prediction "),
            "{sentence}"
        );
    }
}

#[test]
fn a_log_of_the_identification_proves_nothing() {
    let mut validation = validated(log(Some("prediction"), truth(), 2));
    validation.runs.truncate(1);
    let sentence = validation.sentence();
    contains(&sentence, &["is not proved"]);
    for set in &mut validation.runs[0].sets {
        for joint in &mut set.predictions {
            (joint.torque_ratio, joint.deflection_ratio) = (None, None);
        }
    }
    let sentence = validation.sentence();
    contains(&sentence, &["no promise to prove"]);
}

#[test]
fn more_friction_is_named() {
    for joint in ["joint1", "joint2"] {
        let values = with_friction(|name| name.contains(joint));
        let validation = validated(log(Some("prediction"), values, 5));
        let (text, line) = names(&validation, "friction-changed");
        contains(&text, &[&format!("the friction of {joint} differs")]);
        let both = "[log] file = [\"identification.csv\", \"validation.csv\"]";
        assert_eq!(line.as_deref(), Some(both));
    }
    let validation = validated(log(Some("prediction"), with_friction(|_| true), 5));
    let (text, _) = names(&validation, "friction-changed");
    contains(&text, &["the friction of several joints differs"]);
}

#[test]
fn a_payload_is_named() {
    // A mass of 50 g at 0.25 m on link 2, whose joint is 0.3 m from the base.
    let (mass, link, tip) = (0.05, 0.3, 0.25);
    let values = changed(|name, value| {
        value
            + match name {
                "link1.inertia_total" => mass * (link * link + tip * tip),
                "link2.coupling" => mass * link * tip,
                "link2.inertia" => mass * tip * tip,
                _ => 0.0,
            }
    });
    let validation = validated(log(Some("prediction"), values, 5));
    let (text, _) = names(&validation, "payload-changed");
    contains(&text, &["link2.inertia 0.013"]);
}

#[test]
fn another_stiffness_is_named() {
    let values = changed(|name, value| value * if name == "joint1.stiffness" { 1.3 } else { 1.0 });
    let validation = validated(log(Some("prediction"), values, 5));
    let (text, _) = names(&validation, "stiffness-changed");
    contains(&text, &[", +30 %"]);
}

/// The log of the prediction with another column, from its values.
fn with_column(column: usize, other: impl Fn(&[f64], usize) -> f64) -> Vec<u8> {
    let original = log(Some("prediction"), truth(), 5);
    let text = std::str::from_utf8(&original).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let mut rows: Vec<Vec<String>> = (rows.lines())
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect();
    let values: Vec<f64> = rows
        .iter()
        .map(|row| row[column].parse().unwrap())
        .collect();
    for (k, row) in rows.iter_mut().enumerate() {
        row[column] = other(&values, k).to_string();
    }
    let lines = rows.iter().map(|row| row.join(",") + "\n");
    format!("{header}\n{}", lines.collect::<String>()).into_bytes()
}

/// The log of the prediction with one column multiplied by a factor.
fn scaled(column: usize, factor: f64) -> Vec<u8> {
    with_column(column, |values, k| factor * values[k])
}

#[test]
fn a_channel_that_is_late_only_in_this_log_is_named_with_its_line() {
    let late = 20;
    let log = with_column(1, |values, k| values[k.saturating_sub(late)]);
    let (text, line) = names(&validated(log.clone()), "delayed-channel");
    contains(&text, &["unlike in the identification"]);
    let line = line.unwrap();
    let start = "[[validate]] log = { file = \"validation.csv\", delay_s = { \"q1_rad\" = ";
    let delay = line.strip_prefix(start).unwrap_or_else(|| panic!("{line}"));
    let delay: f64 = delay.trim_end_matches([' ', '}']).parse().unwrap();
    // The identification has errors, too.
    assert!((delay - 1e-3 * late as f64).abs() < 1e-3, "{line}");
    // With this delay the promise is kept.
    let over = format!("validate.prediction.log.delay_s.q1_rad={delay}");
    let validation = validated_with(log, &[&over]);
    let set = &validation.runs[1].sets[0];
    assert_eq!(set.promise_kept, Some(true), "{:#?}", set.findings);
}

#[test]
fn an_encoder_that_loses_counts_in_this_log_is_named() {
    let log = with_column(2, |values, k| {
        values[k] + if k > values.len() / 2 { 0.03 } else { 0.0 }
    });
    let (text, _) = names(&validated(log), "position-jumps");
    contains(&text, &["q2_rad"]);
}

#[test]
fn another_scale_of_a_torque_is_named_with_its_line() {
    for (joint, column) in [("joint1", 5), ("joint2", 6)] {
        let log = scaled(column, 0.8);
        let (text, line) = names(&validated(log.clone()), "torque-scale-changed");
        contains(&text, &[&format!("the torque of {joint} is logged")]);
        let line = line.unwrap();
        assert!(
            line.starts_with("[[validate]] log = { file = \"validation.csv\", gain = "),
            "{line}"
        );
        let (_, gain) = line.split_once("_nm\" = ").unwrap();
        let gain: f64 = gain.split(' ').next().unwrap().parse().unwrap();
        // Within a percent, which the promise of the next lines does not notice.
        assert!((gain - 1.25).abs() < 0.0125, "{line}");
        // With this gain the promise is kept.
        let over = format!(
            "validate.prediction.log.gain.{}={gain}",
            ["tau1_nm", "tau2_nm"][column - 5]
        );
        let validation = validated_with(log, &[&over]);
        assert_eq!(
            validation.runs[1].sets[0].promise_kept,
            Some(true),
            "{over}"
        );
    }
}

#[test]
fn logs_that_disagree_only_in_friction_say_so() {
    let values = with_friction(|_| true);
    let both = "log.file=[\"identification.csv\", \"validation.csv\"]";
    let session = session(files(log(None, values, 7)), &[both]);
    let found = session.identify(&mut Unheard).unwrap().identification;
    let warnings = &found.results[0].warnings;
    let finding = warnings.iter().find(|f| f.code == "logs-disagree").unwrap();
    contains(&finding.text, &["Only friction disagrees"]);
}
