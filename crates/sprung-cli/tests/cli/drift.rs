//! `sprung compare` over time: drift of one robot.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::{Case, Ran, contains, list_of, sprung, str_of};

/// First second of the first log, since 1970: 2026-01-05 08:00.
const FROM_S: f64 = 1_767_600_000.0;

const SECONDS_PER_WEEK: f64 = 604_800.0;

/// Runs a week apart, identified from logs of equal names. The stiffness of joint 1 falls by `fall` over all runs.
fn runs(count: usize, fall: f64, dated: bool) -> Vec<Case> {
    let run = |k: usize| {
        let stiffness = 9.358_730 * (1.0 - fall * k as f64 / (count - 1) as f64);
        let case = Case::new().replace_in("truth.toml", "9.358730", &stiffness.to_string());
        let seed = format!("simulate.seed={}", 20 + k);
        case.record("identification.csv", &["--set", &seed]);
        let case = case.log(|row, cells| {
            if row > 0 && dated {
                let time: f64 = cells[0].parse().unwrap();
                cells[0] = format!("{:.3}", FROM_S + SECONDS_PER_WEEK * k as f64 + time);
            }
        });
        case.identify(&["-q", "--set", "identify.estimator=least-squares"])
            .ends(0);
        case
    };
    (0..count).map(run).collect()
}

/// Compares runs in the given order.
fn compare<'a>(runs: impl Iterator<Item = &'a Case>, out: &Path, more: &[&str]) -> Ran {
    let folders: Vec<PathBuf> = runs.map(|run| run.path("")).collect();
    let mut args = vec!["compare", "--out", out.to_str().unwrap()];
    args.extend(folders.iter().map(|folder| folder.to_str().unwrap()));
    args.extend(more);
    let output = sprung(&args);
    output.ends(0);
    output
}

fn read(out: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("comparison.json")).unwrap()).unwrap()
}

/// The codes of the findings, with their parameters.
fn drifting(json: &Value) -> Vec<String> {
    let all = list_of(&json["findings"]).iter();
    all.filter(|finding| finding["code"] == "parameter-drifts")
        .flat_map(|finding| list_of(&finding["parameters"]))
        .map(|name| name.as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn a_stiffness_that_falls_is_found_in_the_order_of_the_dates() {
    let runs = runs(6, 0.05, true);
    let out = runs[0].path("compared");
    let output = compare(runs.iter().rev(), &out, &[]);
    let json = read(&out);
    assert_eq!(drifting(&json), ["joint1.stiffness"]);
    let drift = &json["drift"][0];
    assert_eq!(drift["time_unit"], "d");
    assert_eq!(drift["from_date_s"], FROM_S);
    let times: Vec<f64> = serde_json::from_value(drift["times"].clone()).unwrap();
    assert_eq!(times, [0.0, 7.0, 14.0, 21.0, 28.0, 35.0]);
    // The first result is the oldest, though it was given last.
    let oldest = str_of(&json["compared"][0]["file"]);
    assert!(
        oldest.starts_with(runs[0].path("").to_str().unwrap()),
        "{oldest}"
    );
    let all = list_of(&drift["parameters"]);
    let of = all
        .iter()
        .find(|parameter| parameter["name"] == "joint1.stiffness");
    let percent = of.unwrap()["change_percent"].as_f64().unwrap();
    // Half of the change tells it from none and from twice.
    assert!((-7.5..-2.5).contains(&percent), "{percent}");
    let (text, message) = (output.out, output.err);
    contains(
        &text,
        &[
            "drift over 6 runs",
            "1 of 15 parameters of least-squares drifts",
            "2026-02-09",
        ],
    );
    contains(&message, &["joint1.stiffness drifts by -"]);
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    contains(&report, &["id=\"drift\"", "parameters drift"]);
}

#[test]
fn robots_that_do_not_change_do_not_drift_and_runs_without_dates_keep_their_order() {
    let runs = runs(4, 0.0, false);
    let out = runs[0].path("compared");
    let output = compare(runs.iter(), &out, &[]);
    let json = read(&out);
    assert_eq!(drifting(&json), [""; 0]);
    let drift = &json["drift"][0];
    assert_eq!(drift["time_unit"], "run");
    assert!(drift["parameters"][0]["change_per_day"].is_null());
    let text = &output.out;
    let start = "None of 15 parameters of least-squares drifts over 4 runs in the order given, because the logs of ";
    contains(text, &[start, "have no dates"]);

    // Three runs are too few, and results of one log are of one time.
    compare(runs.iter().take(3), &out, &[]);
    assert!(read(&out)["drift"].is_null());
    let log = "identification.csv";
    for run in &runs[1..] {
        std::fs::copy(runs[0].path(log), run.path(log)).unwrap();
        let cutoff = "identify.position_cutoff_hz=20";
        run.identify(&[
            "-q",
            "--set",
            "identify.estimator=least-squares",
            "--set",
            cutoff,
        ]);
    }
    compare(runs.iter(), &out, &[]);
    assert!(read(&out)["drift"].is_null());
}
