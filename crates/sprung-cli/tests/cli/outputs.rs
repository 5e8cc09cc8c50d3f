//! Files, exit codes and streams, on which scripts rely.

use crate::arm::recorded;
use crate::common::{
    COUNT, Case, Ran, assert_true, contains, demo, f64_of, list_of, sprung, str_of,
};

const RESULTS: [&str; 5] = [
    "identification.json",
    "parameters.csv",
    "trace.csv",
    "fit.csv",
    "report.html",
];

#[test]
fn identify_writes_its_files_and_prints_where() {
    let case = Case::new();
    let output = case.identify(&[]);
    output.ends(0);
    for file in RESULTS {
        assert!(case.path("sprung-out").join(file).exists(), "{file}");
    }
    let text = &output.out;
    contains(text, &["joint1.stiffness", "report.html"]);
    let left: Vec<_> = std::fs::read_dir(case.path("sprung-out"))
        .unwrap()
        .collect();
    assert_eq!(left.len(), RESULTS.len());
}

#[test]
fn json_is_all_that_is_printed() {
    let case = Case::new();
    let printed = case.identify(&["--json"]).json();
    let written = case.json("sprung-out/identification.json");
    assert_eq!(printed, written);
    assert_eq!(printed["format"], 3);
    let first = &printed["results"][0];
    assert_eq!(first["estimator"], "least-squares");
    assert_eq!(first["rank"], 15);
    // The log is right, and there is no finding.
    assert_eq!(first["verdict"], "good");
    assert_eq!(list_of(&printed["findings"]).len(), 0);
    let warnings = list_of(&first["warnings"]);
    assert!(
        warnings.iter().all(|warning| warning["severity"] == "info"),
        "{warnings:?}"
    );
    let stiffness = &first["parameters"][9];
    assert_eq!(stiffness["name"], "joint1.stiffness");
    assert_eq!(stiffness["symbol"], "theta10");
    assert_eq!(stiffness["unit"], "N·m/rad");
    assert_eq!(stiffness["nominal"], 9.0);
    assert_true(&printed, &[("joint1.stiffness", 9.358_73)]);
    // The check calls a fifth unexplained.
    let residual = first["relative_residual"]["joint1.motor_nm"].as_f64();
    assert!(residual.unwrap() < 0.2);
    // Motor friction dominates its row; the viscous friction of link 2 is negligible.
    let share = |i: usize| f64_of(&first["parameters"][i]["torque_share"]);
    // A hundredth.
    assert!(share(7).max(share(13)) > 0.99 && share(6) < 0.01);
}

#[test]
fn same_input_same_numbers() {
    let run = || {
        let case = Case::new();
        case.identify(&["--quiet"]);
        let read = |file: &str| case.read(&format!("sprung-out/{file}"));
        (read("parameters.csv"), read("trace.csv"), read("fit.csv"))
    };
    assert_eq!(run(), run());
}

#[test]
fn same_seed_same_log() {
    let record = |seed: &str| {
        let case = Case::new();
        let out = case.path("out");
        case.run(
            "simulate",
            &[
                "--set",
                &format!("simulate.seed={seed}"),
                "--out",
                out.to_str().unwrap(),
                "--quiet",
            ],
        )
        .ends(0);
        std::fs::read_to_string(out.join("identification.csv")).unwrap()
    };
    let one = record("1");
    assert_eq!(
        one,
        std::fs::read_to_string(demo().join("identification.csv")).unwrap()
    );
    assert_eq!(one, record("1"));
    assert_ne!(one, record("2"));
}

#[test]
fn a_log_of_currents_gives_the_parameters_of_one_of_torques() {
    let case = Case::new().replace(
        "motor_torque_nm    = [\"tau1_nm\", \"tau2_nm\"]",
        "motor_current_a = [\"i1_a\", \"i2_a\"]",
    );
    let out = case.path("twin");
    case.run("simulate", &["--quiet", "--out", out.to_str().unwrap()])
        .ends(0);
    let log = out.join("identification.csv");
    let header = std::fs::read_to_string(&log).unwrap();
    assert!(header.starts_with("t_s,q1_rad,q2_rad,phi1_rad,phi2_rad,i1_a,i2_a\n"));
    let value = |case: &Case, more: &[&str]| {
        let (_, json) = case.results(more);
        let parameter = &json["results"][0]["parameters"][3];
        f64_of(&parameter["value"])
    };
    let currents = value(&case, &["--set", &format!("log.file={}", log.display())]);
    let torques = value(&Case::new(), &[]);
    assert!(
        (currents / torques - 1.0).abs() < 1e-9,
        "{currents} {torques}"
    );
}

#[test]
fn validate_reads_what_identify_wrote() {
    let case = Case::new();
    std::fs::copy(demo().join("validation.csv"), case.path("validation.csv")).unwrap();
    case.identify(&["--quiet"]).ends(0);
    let output = case.run("validate", &["--json"]);
    output.ends(0);
    let json = output.json();
    let runs = list_of(&json["runs"]);
    assert_eq!(runs.len(), 2);
    for run in runs {
        let e = &run["sets"][0]["e_rms"];
        // The positions are rounded to counts, and the controllers multiply them by up to 350 N·m/rad.
        assert!(f64_of(&e["q_rad"]["joint1"]) < COUNT, "{e}");
        let torque = f64_of(&e["tau_nm"]["joint1"]);
        assert!(torque < 350.0 * COUNT, "{e}");
    }
    // LSFF estimates negative friction, so the simulated loop diverges. The report gives this reason instead of
    // meaningless numbers.
    let prediction = list_of(&runs[1]["sets"]);
    assert_eq!(prediction[1]["parameters"], "lsff");
    assert!(prediction[1]["e_rms"].is_null());
    let finding = &prediction[1]["findings"][0];
    assert_eq!(finding["code"], "loop-runs-away");
    contains(
        str_of(&finding["text"]),
        &["negative friction feeds energy into the loop"],
    );
    contains(str_of(&prediction[2]["modified"]), &["set to 0"]);
    // The loop follows the reference: the error is below a tenth of its two amplitudes of 10°.
    let error = f64_of(&prediction[2]["e_rms"]["q_rad"]["joint1"]);
    assert!(error < 0.1 * 20_f64.to_radians());
    assert!(!output.out.contains("NaN"));
    contains(
        &case.read("sprung-out/report.html"),
        &["Parameters over time", "Validation"],
    );
}

#[test]
fn validate_takes_the_cutoff_of_the_identification() {
    let case = Case::new();
    let cutoff = "identify.position_cutoff_hz=7.5";
    let estimator = "identify.estimator=\"least-squares\"";
    case.identify(&["--quiet", "--set", cutoff, "--set", estimator])
        .ends(0);
    let cutoff = |more: &[&str]| {
        let experiment = case.at("experiment.toml");
        let direct = "validate=[{name=\"direct\"}]";
        let given = ["validate", &experiment, "--set", direct];
        let json = sprung(&[&given[..], &["--json"], more].concat()).json();
        f64_of(&json["runs"][0]["position_cutoff_hz"])
    };
    assert!((cutoff(&[]) - 7.5).abs() < 1e-12);
    let given = "identify.position_cutoff_hz=9";
    assert!((cutoff(&["--set", given]) - 9.0).abs() < 1e-12);
}

#[test]
fn validate_takes_the_signs_and_gains_that_were_found() {
    // The encoder of the rigid elbow counts in the other direction, and the torque of the shoulder has the unit 2.5
    // N·m.
    let case = recorded()
        .replace(
            "[identify]",
            "sign = { phi2 = \"estimate\" }\ngain = { tau1 = \"estimate\" }\n[identify]",
        )
        .replace(
            "gravity_m_per_s2",
            "fixed = { \"shoulder.rotor_inertia\" = 0.3 }\ngravity_m_per_s2",
        )
        .column_of("run.csv", 3, |phi| -phi)
        .column_of("run.csv", 4, |tau| tau / 2.5);
    let (code, found) = case.results(&[]);
    assert_eq!(
        (code, &found["log"]["sign"]["phi2"]["value"]),
        (0, &(-1.0).into())
    );
    let gain = &found["log"]["gain"]["tau1"];
    let [gain, error] = ["value", "standard_error"].map(|key| f64_of(&gain[key]));
    assert!((gain - 2.5).abs() < 4.0 * error, "{gain} ± {error}");
    let experiment = case.path("experiment.toml");
    let direct = "validate=[{name=\"direct\"}]";
    let experiment = experiment.to_str().unwrap();
    let json = sprung(&["validate", experiment, "--set", direct, "--json"]).json();
    let left = &json["runs"][0]["sets"][0]["torque_relative_residual"];
    for joint in ["shoulder", "elbow"] {
        // Without the gain more than half of the torque would be left. The check calls a fifth unexplained.
        assert!(f64_of(&left[joint]) < 0.2, "{left}");
    }
}

#[test]
fn references_run_on_the_time_of_the_log() {
    // All sines of the demo repeat after 10 s. So a clock that starts at 100 s has no effect, and a clock that starts
    // at 2.5 s shifts the reference.
    let error = |start: f64| {
        let case = Case::new().column(0, |time| time + start);
        let json = case
            .run(
                "validate",
                &[
                    "--parameters",
                    &case.at("truth.toml"),
                    "--set",
                    "validate=[{name=\"direct\"}]",
                    "--json",
                ],
            )
            .json();
        let e = &json["runs"][0]["sets"][0]["e_rms"];
        f64_of(&e["q_rad"]["joint1"])
    };
    // The positions are rounded to counts, and each sine has an amplitude of 3°.
    assert!(error(100.0) < COUNT && error(2.5) > 3_f64.to_radians());
}

#[test]
fn joints_keep_their_order() {
    let case = Case::new()
        .replace("\"joint1\"", "\"shoulder\"")
        .replace("\"joint2\"", "\"elbow\"");
    let text = case.identify(&["--json"]).out;
    let at = |name: &str| text.find(name).unwrap();
    assert!(at("shoulder.motor_nm") < at("elbow.motor_nm"));
}

#[test]
fn delay_to_be_estimated_needs_an_identification() {
    let case = Case::new();
    let validate = |parameters: &str| {
        case.run(
            "validate",
            &[
                "--parameters",
                &case.at(parameters),
                "--set",
                "log.delay_s.q1_rad=\"estimate\"",
                "--set",
                "validate=[{name=\"direct\"}]",
            ],
        )
    };
    validate("truth.toml")
        .ends(2)
        .tells(&["the delay of \"q1_rad\" is to be estimated"]);
    case.identify(&["--quiet", "--set", "log.delay_s.q1_rad=\"estimate\""]);
    validate("sprung-out/identification.json").ends(0);
}

#[test]
fn identify_lets_go_of_a_validation_of_earlier_parameters() {
    let case = Case::new();
    let out = case.path("sprung-out");
    let copy = |names: &[&str]| {
        std::fs::create_dir_all(&out).unwrap();
        for name in names {
            std::fs::copy(demo().join("sprung-out").join(name), out.join(name)).unwrap();
        }
    };
    copy(&["validation.json", "signals.csv"]);
    case.identify(&[])
        .ends(0)
        .prints(&["was removed; run sprung validate again"]);
    let files = || std::fs::read_dir(&out).unwrap().count();
    assert_eq!(files(), RESULTS.len());

    // Files of other programs with these names stay.
    std::fs::write(out.join("validation.json"), "{}").unwrap();
    copy(&["signals.csv"]);
    let output = case.identify(&[]);
    assert!(!output.out.contains("was removed"), "{}", output.out);
    assert_eq!(files(), RESULTS.len() + 2);
    copy(&["validation.json"]);
    std::fs::write(out.join("signals.csv"), "t,u\n0,1\n").unwrap();
    case.identify(&[]);
    assert_eq!(files(), RESULTS.len() + 1);
}

#[test]
fn parameters_can_be_given_as_toml() {
    let case = Case::new();
    std::fs::copy(demo().join("validation.csv"), case.path("validation.csv")).unwrap();
    let truth = case.path("truth.toml");
    let validate = |parameters: &std::path::Path| {
        case.run(
            "validate",
            &["--parameters", parameters.to_str().unwrap(), "--json"],
        )
    };
    let json = validate(&truth).ends(0).json();
    assert_eq!(json["runs"][0]["sets"][0]["parameters"], "truth");
    std::fs::write(&truth, "\"joint1.stifness\" = 9.0\n").unwrap();
    validate(&truth)
        .ends(2)
        .tells(&["did you mean \\\"joint1.stiffness\\\"?"]);
}

#[test]
fn folder_that_cannot_be_written() {
    let case = Case::new();
    let file = case.path("a-file");
    std::fs::write(&file, "").unwrap();
    case.identify(&["--out", file.join("results").to_str().unwrap()])
        .ends(4)
        .tells(&["cannot create the folder", "choose another folder"]);
}

#[test]
#[cfg(unix)]
fn full_disk_leaves_earlier_results_whole() {
    let case = Case::new();
    case.identify(&["--quiet"]).ends(0);
    let read = || RESULTS.map(|file| std::fs::read(case.path("sprung-out").join(file)).unwrap());
    let before = read();
    // Writes beyond 100 blocks fail as on a full disk.
    let output = Ran::of(std::process::Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 100; exec \"$0\" identify \"$1\" --set identify.position_cutoff_hz=12"])
        .arg(env!("CARGO_BIN_EXE_sprung"))
        .arg(case.path("experiment.toml")));
    output.ends(4).tells(&["cannot write"]);
    assert!(before == read());
    let left = std::fs::read_dir(case.path("sprung-out")).unwrap().count();
    assert_eq!(left, RESULTS.len(), "a half-written file was left");
}

#[test]
fn help_shows_an_example_and_the_exit_codes() {
    let text = sprung(&["help", "identify"]).out;
    assert!(
        text.starts_with("Example: sprung identify experiment.toml"),
        "{text}"
    );
    sprung(&["--help"]).prints(&["3  a log is wrong"]);
    sprung(&["identfy"]).ends(2);
}

#[test]
fn schema_knows_the_keys() {
    let schema = sprung(&["schema"]).json();
    assert!(schema["$defs"]["Identify"]["properties"]["position_cutoff_hz"].is_object());
}
