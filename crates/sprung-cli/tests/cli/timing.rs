//! Logs whose description gives the timing of their torques.

use serde_json::Value;

use crate::arm::recorded;
use crate::common::{Case, contains, demo, f64_of, finding, sprung, value};

/// The demo with further lines in `[log]`; every `keeps`-th sample of its log.
fn case(case: Case, keeps: usize, lines: &str) -> Case {
    let time = "time_s             = \"t_s\"";
    (case.replace(time, &format!("{time}\n{lines}"))).log(|row, cells| {
        if row > 0 && (row - 1) % keeps > 0 {
            cells.clear();
        }
    })
}

const HELD: &str = "torque = \"held\"\ncontroller_period_s = 0.001";

const CODE: &str = "torque-timing-contradicted";

#[test]
fn a_log_that_keeps_every_fourth_torque_says_how_long_each_was_held() {
    let rotor = |keeps: usize, lines: &str| {
        let (code, json) = case(Case::new(), keeps, lines).results(&["--quiet"]);
        assert_eq!(code, 0);
        value(&json, "joint1.rotor_inertia")
    };
    let all = rotor(1, "");
    assert!((rotor(1, HELD) - all).abs() < 1e-9 * all);
    let away = |lines: &str| (rotor(4, lines) / all - 1.0).abs();
    let (unsaid, said) = (away(""), away(HELD));
    // Four torques were applied and one is known: what stays is the noise of the other three. The key takes away more.
    assert!(said < 0.5 * unsaid, "{said} {unsaid}");
}

#[test]
fn a_hold_that_the_log_contradicts_is_a_warning_with_both_likelihoods() {
    let refined = |lines: &str| -> Value {
        let case = case(Case::as_shipped(), 1, lines);
        case.results(&[
            "--quiet",
            "--set",
            "identify.estimator=[\"prediction-error\"]",
        ])
        .1
    };
    assert!(finding(&refined(HELD), CODE).is_none());
    let json = refined("torque = \"mean\"");
    let text = finding(&json, CODE).unwrap();
    println!("{text}");
    contains(
        text,
        &[
            "act on average 0.000 ms after their time stamps (torque = \"mean\")",
            "log-likelihood is",
            "as declared",
            "held-out error",
        ],
    );
}

/// The demo, whose two logs have each torque one sample late.
fn late() -> Case {
    let case = Case::as_shipped();
    let second = "validation.csv";
    std::fs::copy(demo().join(second), case.path(second)).unwrap();
    ["identification.csv", second]
        .into_iter()
        .fold(case, |case, file| {
            let mut before: Option<Vec<String>> = None;
            case.cells(file, |row, cells| {
                let torques = cells[5..].to_vec();
                if let Some(before) = before.take() {
                    cells[5..].clone_from_slice(&before);
                }
                before = (row > 0).then_some(torques);
            })
        })
}

#[test]
fn a_second_log_has_the_timing_of_the_torques_that_the_first_one_showed() {
    let case = late();
    let refined = "identify.estimator=[\"prediction-error\"]";
    let (code, json) = case.results(&["--quiet", "--set", refined]);
    assert_eq!(code, 0);
    let delay = f64_of(&json["log"]["torques_delay_s"]["value"]);
    assert!((delay / 0.001 - 1.0).abs() < 0.2, "{delay}");
    let experiment = case.at("experiment.toml");
    let errors = |setting: &str| -> Vec<f64> {
        let args = ["validate", &experiment, "--quiet", "--set"];
        sprung(&[&args[..], &[setting]].concat()).ends(0);
        let json = case.json("sprung-out/validation.json");
        let joints = json["runs"][0]["sets"][0]["predictions"].as_array();
        (joints.unwrap().iter())
            .map(|joint| f64_of(&joint["torque_error_nm"]))
            .collect()
    };
    let found = errors(refined);
    let given = |delay: f64| errors(&format!("log.delay_s={{tau1_nm={delay},tau2_nm={delay}}}"));
    let (same, without) = (given(delay), given(0.0));
    for joint in 0..2 {
        let away = (found[joint] / same[joint] - 1.0).abs();
        assert!(away < 1e-9, "joint {joint}: {found:?} {same:?}");
    }
    assert!(
        (found[0] / without[0] - 1.0).abs() > 1e-4,
        "{found:?} {without:?}"
    );
}

#[test]
fn all_delays_are_opened_by_one_word_and_none_without_a_reference() {
    let (code, json) = case(Case::new(), 1, "delay_s = \"estimate\"").results(&["--quiet"]);
    assert_eq!(code, 0);
    let opened: Vec<&String> = json["log"]["delay_s"].as_object().unwrap().keys().collect();
    assert_eq!(opened, ["q1_rad", "q2_rad", "tau1_nm", "tau2_nm"]);
    case(
        Case::new(),
        1,
        "delay_s = { q1_rad = \"estimate\", phi1_rad = \"estimate\", tau1_nm = \"estimate\" }",
    )
    .fails(
        2,
        &[
            "delay_s asks to estimate all channels of joint1",
            "leave one of them out",
        ],
    );
    case(Case::new(), 1, "delay_s = \"guess\"").fails(2, &["line", "unknown delay \"guess\""]);
}

#[test]
fn a_wrong_clock_shows_in_gravity_against_inertia() {
    for by in [1.0, 0.8, 1.25] {
        let case = recorded().column_of("run.csv", 0, |time| by * time);
        let (_, json) = case.results(&[]);
        let verdict = &json["results"][0]["verdict"];
        let unknowns = json["unknowns"].as_array();
        let mut unknowns = unknowns.into_iter().flatten();
        let Some(found) = unknowns.find(|one| one["kind"] == "time-scale") else {
            assert_eq!((by, verdict.as_str()), (1.0, Some("good")), "{json}");
            continue;
        };
        let value = f64_of(&found["value"]);
        assert!((value + 1.0 - 1.0 / by).abs() < 0.02, "{by}: {found}");
        assert!(finding(&json, "time-scale").is_some(), "{by}");
        assert_eq!(verdict, "doubtful", "{by}");
    }
}
