//! Output on the terminal: width, order, errors for scripts, texts for shells.

use std::process::{Command, Output};

use serde_json::Value;

use crate::common::{Case, demo, sprung, stderr, stdout};

const PHI1: usize = 3;

/// Runs the program on a terminal of this width.
fn on_terminal(width: usize, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sprung"))
        .args(args)
        .env("COLUMNS", width.to_string())
        .output()
        .unwrap()
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
        assert_eq!(wide.status.code(), Some(0), "{}", stderr(&wide));
        for width in [120, 80, 60, 40] {
            let narrow = on_terminal(width, &[verb, experiment, "-v"]);
            let (wide_text, narrow_text) = (
                [stdout(&wide), stderr(&wide)],
                [stdout(&narrow), stderr(&narrow)],
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
    let narrow = stdout(&on_terminal(80, &["identify", experiment]));
    assert_eq!(narrow.matches("\n joint1.stiffness").count(), 2, "{narrow}");
    let wide = stdout(&on_terminal(200, &["identify", experiment]));
    assert_eq!(wide.matches("\n joint1.stiffness").count(), 1, "{wide}");
}

#[test]
fn the_demo_ends_with_what_was_found() {
    let folder = tempfile::TempDir::new().unwrap();
    let out = folder.path().join("demo");
    let output = sprung(&["demo", "--out", out.to_str().unwrap()]);
    let (said, notes) = (stdout(&output), stderr(&output));
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
    assert!(notes.contains("-v prints its findings"), "{notes}");
    assert!(!notes.contains("remedy: excite the joint"), "{notes}");
}

#[test]
fn errors_are_json_if_results_are() {
    let error = |output: &Output| -> Value {
        assert!(output.stdout.is_empty(), "{}", stdout(output));
        serde_json::from_slice(&output.stderr).unwrap_or_else(|_| panic!("{}", stderr(output)))
    };
    let case = Case::new();
    let missing = error(&case.identify(&["--json", "--set", "log.file=gone.csv"]));
    assert_eq!(
        (&missing["code"], &missing["exit_code"]),
        (&"file".into(), &4.into())
    );
    let unknown = error(&case.identify(&["--json", "--set", "log.nam=1"]));
    assert_eq!(
        (&unknown["code"], &unknown["exit_code"]),
        (&"usage".into(), &2.into())
    );
    assert!(
        unknown["text"].as_str().unwrap().contains("unknown key"),
        "{unknown}"
    );
    assert!(
        unknown["remedy"].as_str().unwrap().contains("did you mean"),
        "{unknown}"
    );
    let degrees = Case::new().column(PHI1, f64::to_degrees);
    let refused = error(&degrees.identify(&["--json"]));
    assert_eq!(
        (&refused["code"], &refused["exit_code"]),
        (&"units-disagree".into(), &3.into())
    );
    let first = &refused["findings"][0];
    assert_eq!(
        (&refused["text"], &refused["remedy"]),
        (&first["text"], &first["remedy"])
    );
    let line = error(&sprung(&["identify", "--json", "--thread", "2", "x"]));
    assert_eq!(
        (&line["code"], &line["exit_code"]),
        (&"usage".into(), &2.into())
    );
    assert!(
        line["text"].as_str().unwrap().contains("--thread"),
        "{line}"
    );
    let compared = error(&sprung(&["compare", "--json", "/nonexistent"]));
    assert_eq!(compared["code"], "file");
}

#[test]
fn compare_ends_with_its_conclusion() {
    let case = Case::new().replace("[\"least-squares\", \"lsff\"]", "\"least-squares\"");
    assert_eq!(case.identify(&["-q"]).status.code(), Some(0));
    let other = Case::new().replace("[\"least-squares\", \"lsff\"]", "\"least-squares\"");
    let file = "identification.json";
    assert_eq!(other.identify(&["-q"]).status.code(), Some(0));
    let out = case.path("compared");
    let paths = [case.path("sprung-out"), other.path("sprung-out")];
    let compare = || {
        let [one, two] = paths.each_ref().map(|path| path.to_str().unwrap());
        let output = sprung(&["compare", one, two, "--out", out.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stdout(&output).lines().last().unwrap().to_owned()
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
    let output = sprung(&["compare", one, "--out", out.to_str().unwrap()]);
    assert!(
        stdout(&output).contains("does not test them"),
        "{}",
        stdout(&output)
    );
}

#[test]
fn shells_and_man_get_their_texts() {
    for (shell, word) in [
        ("bash", "complete -F"),
        ("zsh", "#compdef sprung"),
        ("fish", "complete -c sprung"),
        ("powershell", "Register-ArgumentCompleter"),
    ] {
        let output = sprung(&["completions", shell]);
        assert_eq!(output.status.code(), Some(0));
        let text = stdout(&output);
        assert!(
            text.contains(word) && text.contains("identify"),
            "{shell}: {text}"
        );
    }
    let wrong = sprung(&["completions", "cmd"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(
        stderr(&wrong).contains("possible values: bash"),
        "{}",
        stderr(&wrong)
    );
    let page = stdout(&sprung(&["man"]));
    assert!(
        page.contains(".TH sprung 1") && page.contains("sprung\\-identify(1)"),
        "{page}"
    );
    let page = stdout(&sprung(&["man", "identify"]));
    assert!(
        page.contains(".TH sprung-identify 1") && page.contains("\\-\\-threads"),
        "{page}"
    );
    let wrong = sprung(&["man", "identfy"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(
        stderr(&wrong).contains("the verbs are demo, new,"),
        "{}",
        stderr(&wrong)
    );
}
