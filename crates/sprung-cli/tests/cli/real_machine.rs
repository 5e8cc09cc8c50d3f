//! The example of a real machine, on the log that its maker's users recorded.

use std::path::PathBuf;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{sprung, stderr};

/// The log, or nothing where it is not on this machine.
fn log() -> Option<PathBuf> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");
    let log = PathBuf::from(root).join("shared/data/quanser_2dsfl/quanser_2dsfl_psf.csv");
    if log.exists() {
        return Some(log.canonicalize().unwrap());
    }
    eprintln!("skipped: no log of the real machine at {}", log.display());
    None
}

fn identify(more: &[&str]) -> Option<(i32, Value)> {
    let set_log = format!("log.file={}", log()?.display());
    let out = TempDir::new().unwrap();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/quanser-2dsfl");
    let out = out.path().to_str().unwrap();
    let mut args = vec![
        "identify", example, "--json", "--out", out, "--set", &set_log,
    ];
    args.extend(more);
    let output = sprung(&args);
    let json = serde_json::from_slice(&output.stdout);
    Some((
        output.status.code().unwrap(),
        json.unwrap_or_else(|_| panic!("{}", stderr(&output))),
    ))
}

fn stiffness(json: &Value) -> (f64, f64) {
    let result = &json["results"][0];
    let stacked = result["parameters"][9]["value"].as_f64().unwrap();
    let alone = result["motor_rows"][0]["parameters"][2]["value"]
        .as_f64()
        .unwrap();
    (stacked, alone)
}

fn finding<'a>(json: &'a Value, code: &str) -> Option<&'a str> {
    json["results"][0]["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .find(|warning| warning["code"] == code)
        .map(|warning| warning["text"].as_str().unwrap())
}

#[test]
fn known_delay_gives_both_estimates_and_says_why_they_differ() {
    let Some((code, json)) = identify(&[]) else {
        return;
    };
    let (stacked, alone) = stiffness(&json);
    println!("stiffness of stage 1: stacked {stacked:.2}, motor row alone {alone:.2} N·m/rad");
    assert_eq!(code, 0);
    assert!((30.0..31.0).contains(&stacked), "{stacked}");
    assert!((37.5..39.0).contains(&alone), "{alone}");
    let text = finding(&json, "stacked-below-motor-rows").unwrap();
    assert!(
        text.contains("The link rows have no right-hand side"),
        "{text}"
    );
    // The fit is poor, and the verdict says so.
    assert_eq!(json["results"][0]["verdict"], "doubtful");
    assert!(finding(&json, "poor-fit").is_some());
}

#[test]
fn ignored_delay_gives_a_negative_stiffness_and_its_cause() {
    let zero = ["--set", "log.delay_s={defl1=0,defl2=0}"];
    let Some((code, json)) = identify(&zero) else {
        return;
    };
    let (stacked, _) = stiffness(&json);
    println!("stiffness of stage 1 without the delay: {stacked:.2} N·m/rad");
    assert!((-7.0..-3.0).contains(&stacked), "{stacked}");
    assert_eq!(code, 1);
    assert_eq!(json["results"][0]["verdict"], "unusable");
    let text = finding(&json, "negative-stiffness").unwrap();
    assert!(
        text.contains("a channel is delayed against the others, or a sign is wrong"),
        "{text}"
    );
}

#[test]
fn delay_is_found() {
    let estimate = [
        "--set",
        "log.delay_s={defl1=\"estimate\",defl2=\"estimate\"}",
    ];
    let Some((_, json)) = identify(&estimate) else {
        return;
    };
    let delay = &json["log"]["delay_s"]["defl1"];
    let (value, error) = (
        delay["value"].as_f64().unwrap(),
        delay["standard_error"].as_f64().unwrap(),
    );
    println!("delay of defl1: {value:.4} ± {error:.4} s");
    assert!((value - 0.150).abs() < 0.02, "{value}");
    assert!(error < 0.02, "{error}");
    assert!((29.0..32.0).contains(&stiffness(&json).0));
}
