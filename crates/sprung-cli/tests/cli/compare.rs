//! `sprung compare`: results side by side.

use std::path::Path;

use serde_json::Value;

use crate::common::{
    Case, Ran, contains, demo, f64_of, finding, list_of, messages, sprung, str_of,
};

/// Runs `sprung compare` on files, with results in `out`.
fn compare(files: &[&Path], out: &Path, more: &[&str]) -> Ran {
    let mut args = vec!["compare", "--out", out.to_str().unwrap()];
    args.extend(files.iter().map(|file| file.to_str().unwrap()));
    args.extend(more);
    sprung(&args)
}

/// An experiment that was identified with a separate log.
fn identified(simulate: &[&str], identify: &[&str]) -> Case {
    let case = Case::new();
    case.record("own.csv", simulate);
    let mut args = vec!["-q", "--set", "log.file=own.csv"];
    args.extend(identify);
    case.identify(&args).ends(0);
    case
}

#[test]
fn methods_of_one_file_stand_side_by_side() {
    let folder = tempfile::TempDir::new().unwrap();
    compare(&[demo()], folder.path(), &[]).ends(0).prints(&[
        "least-squares",
        "lsff",
        "joint1.stiffness",
        "in s.e.",
        "report.html",
    ]);
    let file = std::fs::read_to_string(folder.path().join("comparison.json")).unwrap();
    let json: Value = serde_json::from_str(&file).unwrap();
    assert_eq!(json["format"], 1);
    let stiffness = &json["parameters"][9];
    assert_eq!(stiffness["name"], "joint1.stiffness");
    let [first, second] = [0, 1].map(|i| &stiffness["values"][i]);
    let of = |value: &Value, key: &str| f64_of(&value[key]);
    let difference = of(second, "value") - of(first, "value");
    let percent = 100.0 * difference / of(first, "value");
    assert!((of(second, "difference_percent") - percent).abs() < 1e-9);
    let both = of(first, "standard_error").hypot(of(second, "standard_error"));
    assert!((of(second, "difference_standard_errors") - difference / both).abs() < 1e-9);
    assert!(first["difference_percent"].is_null());
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 2);
}

#[test]
fn json_is_all_that_is_printed() {
    let folder = tempfile::TempDir::new().unwrap();
    let output = compare(&[demo()], folder.path(), &["--json"]);
    let file = std::fs::read(folder.path().join("comparison.json")).unwrap();
    let written: Value = serde_json::from_slice(&file).unwrap();
    assert_eq!(output.json(), written);
    let output = compare(&[demo()], folder.path(), &["-q"]);
    assert_eq!(output.out + &output.err, "");
}

#[test]
fn runs_of_one_robot_agree() {
    let runs = ["2", "3", "4"].map(|seed| {
        let seed = format!("simulate.seed={seed}");
        identified(
            &["--set", &seed],
            &["--set", "identify.estimator=least-squares"],
        )
    });
    let folders = runs.each_ref().map(|run| run.path(""));
    let files = folders.each_ref().map(std::path::PathBuf::as_path);
    let out = runs[0].path("compared");
    let json = compare(&files, &out, &["--json"]).json();
    assert_eq!(list_of(&json["compared"]).len(), 3);
    assert_eq!(finding(&json, "runs-disagree"), None);
    // The labels of the files are their folders, because the names are equal.
    let label = str_of(&json["compared"][1]["label"]);
    assert!(files[1].to_str().unwrap().contains(label), "{label}");
}

#[test]
fn runs_of_a_robot_that_changed_disagree() {
    // The cut-off is fixed; a chosen cut-off would differ between the logs.
    let settings = [
        "--set",
        "identify.estimator=least-squares",
        "--set",
        "identify.position_cutoff_hz=20",
    ];
    let before = identified(&[], &settings);
    let changed = Case::new().replace_in("truth.toml", "= 9.358730", "= 9.9");
    changed.record("own.csv", &["--set", "simulate.seed=5"]);
    changed.identify(&[&["-q", "--set", "log.file=own.csv"], &settings[..]].concat());
    let out = before.path("compared");
    let message = compare(&[&before.path(""), &changed.path("")], &out, &[])
        .ends(0)
        .err
        .clone();
    println!("{message}");
    contains(
        &message,
        &["runs-disagree", "joint1.stiffness from 9.3", "gains"],
    );
    assert!(!message.contains("joint2"), "{message}");
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    contains(&report, &["runs disagree", "class=\"bar c1\""]);
}

#[test]
fn parameters_that_only_one_has_are_shown_as_such() {
    let plain = Case::new();
    plain.identify(&["-q"]);
    let offset = Case::new().replace(
        "position_filter_order = 2",
        "position_filter_order = 2\nencoder_offset = \"estimate\"",
    );
    offset.identify(&["-q"]);
    let out = plain.path("compared");
    let output = compare(&[&plain.path(""), &offset.path("")], &out, &["-v"]);
    let message = &output.err;
    contains(message, &["2 of 17 parameters"]);
    output.prints(&["absent"]);
}

#[test]
fn robots_that_share_nothing_are_refused() {
    let case = Case::new();
    case.identify(&["-q"]);
    let other = Case::new()
        .replace("\"joint1\"", "\"shoulder\"")
        .replace("\"joint2\"", "\"elbow\"");
    other.identify(&["-q"]);
    let out = case.path("compared");
    let files = [&*case.path(""), &*other.path("")];
    // The names of the links are equal, those of the joints differ.
    compare(&files, &out, &["-v"])
        .ends(0)
        .tells(&["different-parameters"]);

    let file = "sprung-out/identification.json";
    let other = other
        .replace_in(file, "link1.", "upper.")
        .replace_in(file, "link2.", "lower.");
    let message = compare(&[&case.path(""), &other.path("")], &out, &[])
        .ends(2)
        .err
        .clone();
    contains(
        &message,
        &[
            "no parameter in common",
            "upper.inertia_total",
            "Quanser",
            "the same names",
        ],
    );
}

#[test]
fn different_robots_are_refused_with_their_files() {
    let case = Case::new();
    case.identify(&["-q"]);
    let other = Case::new().replace("name = \"Quanser", "name = \"My Quanser");
    other.identify(&["-q"]);
    let out = case.path("compared");
    let message = compare(&[&case.path(""), &other.path("")], &out, &[])
        .ends(2)
        .err
        .clone();
    let [one, two] = [&case, &other].map(|case| case.path("sprung-out/identification.json"));
    for word in [
        "\"Quanser 2-DOF serial flexible joint\"",
        "\"My Quanser 2-DOF serial flexible joint\"",
        one.to_str().unwrap(),
        two.to_str().unwrap(),
        "one name",
    ] {
        assert!(message.contains(word), "no {word} in {message}");
    }
    assert!(!out.exists(), "a failed run left results");
}

#[test]
fn files_that_are_no_identification_are_named() {
    let mut messages = messages("files_that_are_no_identification_are_named");
    let case = Case::new();
    case.identify(&["-q"]);
    let good = case.path("sprung-out/identification.json");
    let text = std::fs::read_to_string(&good).unwrap();
    let write = |name: &str, text: &str| case.write(name, text);
    write("empty.json", " ");
    let key = "\"results\":";
    let end = text.find(key).unwrap() + key.len();
    write("cut.json", &text[..end]);
    write(
        "newer.json",
        &text.replacen("\"format\": 3", "\"format\": 7", 1),
    );
    write("list.json", "[1, 2]");
    write("schema.json", &sprung(&["schema"]).out);
    write(
        "noresults.json",
        r#"{"format": 1, "results": [], "log": {}}"#,
    );
    case.write("binary.json", [0xff, 0xfe, 0x00]);
    std::fs::create_dir(case.path("folder")).unwrap();
    write("validation.json", r#"{"format": 1, "runs": [{}]}"#);
    for (name, code) in [
        ("empty.json", 2),
        ("cut.json", 2),
        ("newer.json", 2),
        ("list.json", 2),
        ("schema.json", 2),
        ("noresults.json", 2),
        ("binary.json", 2),
        ("validation.json", 2),
        ("experiment.toml", 2),
        ("truth.toml", 2),
        ("identification.csv", 2),
        ("sprung-out/parameters.csv", 2),
        ("sprung-out/report.html", 2),
        ("absent.json", 4),
        ("folder", 4),
    ] {
        let out = case.path("compared");
        let output = compare(&[&good, &case.path(name)], &out, &[]);
        let message = case.message(&output);
        assert_eq!(output.code, Some(code), "{name}: {message}");
        assert_eq!(message.trim().lines().count(), 1, "{message}");
        assert!(!out.exists(), "{name}: a failed run left results");
        // Half of a file ends at another place after every change of its content.
        let (head, tail) = message.split_once(" at line ").unwrap_or((&message, ""));
        let tail = tail.trim_start_matches(|c: char| c.is_ascii_digit() || "column ".contains(c));
        messages.note(name, &format!("{head}{tail}"));
    }
    messages.compare();
}

#[test]
fn kept_promises_are_counted() {
    // A folder holds an identification and its validation; the file is another validation.
    let case = Case::new();
    let broken = case.path("other.json");
    let text = std::fs::read_to_string(demo().join("sprung-out/validation.json")).unwrap();
    let mut validation: Value = serde_json::from_str(&text).unwrap();
    let set = &mut validation["runs"][1]["sets"][0];
    set["promise_kept"] = false.into();
    set["predictions"][1]["torque_ratio"] = 2.3.into();
    std::fs::write(&broken, validation.to_string()).unwrap();
    let out = case.path("compared");
    let text = compare(&[demo(), &broken], &out, &[]).ends(0).out.clone();
    let last = text.trim_end().lines().next_back().unwrap();
    // Each of two validations has a separate log and three parameter sets.
    let start = "The promises are kept in 5 of 6 validations; the largest error is the torque error \
                 of joint2 in prediction (prediction-error, ";
    assert!(last.starts_with(start), "{last}");
    assert!(
        last.ends_with("other.json), 2.3 times the promised one."),
        "{last}"
    );
    contains(&text, &["joint1.stiffness", "own log"]);
    let report = std::fs::read_to_string(out.join("report.html")).unwrap();
    contains(&report, &["kept in 5 of 6 validations", "id=\"promises\""]);

    // Validations alone are compared too.
    let json = compare(&[&broken], &out, &["--json"]).json();
    assert_eq!(list_of(&json["compared"]).len(), 0);
    let promises = list_of(&json["promises"]);
    // Sets with changed values have no promise.
    assert_eq!(promises.len(), 6);
    assert_eq!(promises[3]["predictions"][1]["torque_ratio"], 2.3);
    assert_eq!(promises[0]["same_log"], true);
    contains(str_of(&json["promises_kept"]), &["in 2 of 3 validations"]);
    compare(&[&broken, &broken], &out, &[]).tells(&["given twice"]);
}

#[test]
fn one_result_is_not_enough() {
    let case = Case::new();
    case.identify(&["-q", "--set", "identify.estimator=least-squares"]);
    let file = case.path("sprung-out/identification.json");
    compare(&[&file], &case.path("compared"), &[])
        .ends(2)
        .tells(&["only one result"]);
    compare(&[&file, &case.path("")], &case.path("compared"), &[])
        .ends(2)
        .tells(&["given twice"]);
    sprung(&["compare"]).ends(2);
}

#[test]
fn help_shows_an_example_first() {
    let text = sprung(&["help", "compare"]).out;
    assert!(text.starts_with("Example: sprung compare run1/"), "{text}");
}
