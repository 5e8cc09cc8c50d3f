//! Logs whose description gives the timing of their torques.

use serde_json::Value;

use crate::common::{Case, finding, value};

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
    for fragment in [
        "act on average 0.000 ms after their time stamps (torque = \"mean\")",
        "log-likelihood is",
        "as declared",
        "held-out error",
    ] {
        assert!(text.contains(fragment), "{text}");
    }
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
