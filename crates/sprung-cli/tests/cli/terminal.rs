//! Output on the terminal: width, order, errors for scripts, texts for shells.

use serde_json::Value;

use crate::common::{Case, Ran, contains, demo, program, sprung, str_of};

const PHI1: usize = 3;

/// Runs the program on a terminal of this width.
fn on_terminal(width: usize, args: &[&str]) -> Ran {
    Ran::of(program().args(args).env("COLUMNS", width.to_string()))
}

fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
    words.sort();
    words.dedup();
    words
}

#[test]
fn output_fits_the_terminal_and_words_stay_whole() {
    let case = Case::new();
    let path = case.path("experiment.toml");
    let experiment = path.to_str().unwrap();
    for verb in ["identify", "check"] {
        let wide = on_terminal(1000, &[verb, experiment, "-v"]);
        wide.ends(0);
        for width in [120, 80, 60, 40] {
            let narrow = on_terminal(width, &[verb, experiment, "-v"]);
            let (wide_text, narrow_text) = (
                [wide.out.as_str(), &wide.err],
                [narrow.out.as_str(), &narrow.err],
            );
            let all = words(&wide_text.concat());
            for (wide, narrow) in wide_text.iter().zip(&narrow_text) {
                for line in narrow.lines() {
                    // A path is one word, which is not broken.
                    let is_long = line
                        .split_whitespace()
                        .any(|word| word.chars().count() + 6 > width);
                    let length = line.trim_end().chars().count();
                    assert!(length <= width || is_long, "{length} > {width}: {line}");
                }
                // Lists write a colon after the names of columns.
                let unknown = |word: &String| !all.contains(word) && !word.ends_with(':');
                let new: Vec<String> = words(narrow).into_iter().filter(unknown).collect();
                assert!(
                    new.is_empty(),
                    "{verb} at {width}: {new:?} is not in {wide}"
                );
            }
        }
    }
    // Two tables, one per estimator, with the parameters in each.
    let narrow = on_terminal(80, &["identify", experiment]).out;
    assert_eq!(narrow.matches("\n joint1.stiffness").count(), 2, "{narrow}");
    let wide = on_terminal(200, &["identify", experiment]).out;
    assert_eq!(wide.matches("\n joint1.stiffness").count(), 1, "{wide}");
}

#[test]
fn the_demo_ends_with_what_was_found() {
    let folder = tempfile::TempDir::new().unwrap();
    let out = folder.path().join("demo");
    let output = sprung(&["demo", "--out", out.to_str().unwrap()]);
    let (said, notes) = (output.out, output.err);
    let last: Vec<&str> = said.lines().rev().take(5).collect();
    assert!(
        last[4].starts_with("prediction-error found 15 of 15 parameters"),
        "{last:#?}"
    );
    assert!(last[1].starts_with("The promise is kept"), "{last:#?}");
    assert!(
        last[0].starts_with("Good: on a new experiment"),
        "{last:#?}"
    );
    // LSFF does not decide: its findings take one line per table.
    let about = notes.lines().filter(|line| line.contains("lsff")).count();
    assert!((1..=3).contains(&about), "{notes}");
    contains(&notes, &["-v prints its findings"]);
    assert!(!notes.contains("remedy: excite the joint"), "{notes}");
}

#[test]
fn errors_are_json_if_results_are() {
    let error = |output: &Ran, code: &str, exit_code: i32| -> Value {
        assert_eq!(output.out, "");
        let error: Value = serde_json::from_str(&output.err).unwrap();
        let codes = (&error["code"], &error["exit_code"]);
        assert_eq!(codes, (&code.into(), &exit_code.into()));
        error
    };
    let case = Case::new();
    let missing = case.identify(&["--json", "--set", "log.file=gone.csv"]);
    error(&missing, "file", 4);
    let unknown = case.identify(&["--json", "--set", "log.nam=1"]);
    let unknown = error(&unknown, "usage", 2);
    contains(str_of(&unknown["text"]), &["unknown key"]);
    contains(str_of(&unknown["remedy"]), &["did you mean"]);
    let degrees = Case::new().column(PHI1, f64::to_degrees);
    let refused = error(&degrees.identify(&["--json"]), "units-disagree", 3);
    let first = &refused["findings"][0];
    for key in ["text", "remedy"] {
        assert_eq!(refused[key], first[key], "{key}");
    }
    let line = sprung(&["identify", "--json", "--thread", "2", "x"]);
    let line = error(&line, "usage", 2);
    contains(str_of(&line["text"]), &["--thread"]);
    error(&sprung(&["compare", "--json", "/nonexistent"]), "file", 4);
}

#[test]
fn compare_ends_with_its_conclusion() {
    let case = Case::new().replace("[\"least-squares\", \"lsff\"]", "\"least-squares\"");
    case.identify(&["-q"]).ends(0);
    let other = Case::new().replace("[\"least-squares\", \"lsff\"]", "\"least-squares\"");
    let file = "identification.json";
    other.identify(&["-q"]).ends(0);
    let out = case.at("compared");
    let paths = [case.path("sprung-out"), other.path("sprung-out")];
    let compare = || {
        let [one, two] = paths.each_ref().map(|path| path.to_str().unwrap());
        let output = sprung(&["compare", one, two, "--out", &out]);
        output.ends(0);
        output.out.lines().last().unwrap().to_owned()
    };
    let last = compare();
    assert!(last.starts_with("The results agree: in no of "), "{last}");
    // Another stiffness, a hundred standard errors away.
    let text = std::fs::read_to_string(paths[1].join(file)).unwrap();
    let mut json: Value = serde_json::from_str(&text).unwrap();
    for parameter in json["results"][0]["parameters"].as_array_mut().unwrap() {
        if parameter["name"] == "joint1.stiffness" {
            parameter["value"] = 20.0.into();
        }
    }
    std::fs::write(paths[1].join(file), json.to_string()).unwrap();
    let last = compare();
    assert!(
        last.starts_with("The results disagree: 1 of ") && last.contains("(joint1.stiffness)"),
        "{last}"
    );
    let one = demo().to_str().unwrap();
    sprung(&["compare", one, "--out", &out]).prints(&["does not test them"]);
}

#[test]
fn shells_and_man_get_their_texts() {
    for (shell, word) in [
        ("bash", "complete -F"),
        ("zsh", "#compdef sprung"),
        ("fish", "complete -c sprung"),
        ("powershell", "Register-ArgumentCompleter"),
    ] {
        let text = sprung(&["completions", shell]).ends(0).out.clone();
        assert!(
            text.contains(word) && text.contains("identify"),
            "{shell}: {text}"
        );
    }
    sprung(&["completions", "cmd"])
        .ends(2)
        .tells(&["possible values: bash"]);
    sprung(&["man"]).prints(&[".TH sprung 1", "sprung\\-identify(1)"]);
    sprung(&["man", "identify"]).prints(&[".TH sprung-identify 1", "\\-\\-threads"]);
    sprung(&["man", "identfy"])
        .ends(2)
        .tells(&["the verbs are demo, new,"]);
}
