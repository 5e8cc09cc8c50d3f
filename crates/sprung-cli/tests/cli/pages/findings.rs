//! The page of the findings, written from their explanations; `sprung explain`.

use std::fmt::Write;

use serde_json::{Value, json};
use sprung::description::refusals;
use sprung::finding::Explanation;

use super::experiment::same_or_written;
use crate::common::{Ran, contains, program};

const HEAD: &str = "# Findings

A finding is an observation that you must know. It has a code, a severity, a text with values, a remedy and, where one
line of the experiment file corrects the cause, this line. This page has the cause, the condition, the remedy of each
code, and when you may ignore it; `sprung explain CODE` prints them with an example, `sprung explain --list` prints all codes, and `--json` prints
either as JSON. [Verdict, promise and proof](../explanation/verdict.md#findings-and-their-cost) says what severities
cost, [How the check works](../explanation/checks.md) its method.
";

/// Returns the page.
fn page() -> String {
    let mut page = HEAD.to_owned();
    let mut section = "";
    for explanation in Explanation::all() {
        if explanation.section != section {
            section = explanation.section;
            write!(page, "\n## {section}\n").unwrap();
        }
        page.push_str(&entry(explanation));
    }
    page
}

fn entry(explanation: &Explanation) -> String {
    let quoted = |codes: &[String]| {
        let codes: Vec<String> = codes.iter().map(|code| format!("`{code}`")).collect();
        codes.join(", ")
    };
    // Links in the texts begin at the root of the repository.
    let linked = |text: &str| {
        text.replace("](docs/", "](../")
            .replace("](../reference/", "](")
    };
    let mut text = format!("\n### {}\n\n", quoted(&explanation.codes));
    let cause = linked(&explanation.cause);
    let (first, rest) = cause.split_at(cause.chars().next().map_or(0, char::len_utf8));
    write!(text, "{}{rest}.\n\n", first.to_uppercase()).unwrap();
    let severities = explanation.severities.join(", ");
    match &explanation.condition {
        Some(condition) => {
            writeln!(text, "- When ({severities}): {}.", linked(condition)).unwrap();
        }
        None => writeln!(text, "- Severity: {severities}.").unwrap(),
    }
    writeln!(text, "- Remedy: {}.", linked(&explanation.remedy)).unwrap();
    writeln!(
        text,
        "- When to ignore it: {}.",
        linked(&explanation.ignore)
    )
    .unwrap();
    text
}

#[test]
fn the_page_is_that_of_the_explanations() {
    same_or_written("docs/reference/findings.md", page());
}

fn explain(words: &[&str]) -> Ran {
    Ran::of(program().arg("explain").args(words))
}

#[test]
fn a_finding_is_explained_and_all_are_listed() {
    let list = explain(&["--list"]).out;
    let codes: Vec<&str> = list.lines().collect();
    let refusals = refusals();
    let all = Explanation::all().iter().chain(&refusals);
    let count: usize = all.map(|explanation| explanation.codes.len()).sum();
    assert_eq!(codes.len(), count);
    for code in [
        "gaps",
        "weakly-excited",
        "noisy-signal",
        "servo-of-several-joints",
    ] {
        assert!(codes.contains(&code));
        let output = explain(&[code]);
        let text = &output.out;
        assert!(
            output.code == Some(0) && text.lines().next().unwrap().contains(code),
            "{text}"
        );
        contains(text, &["\ncause ", "\nremedy ", "\nexample "]);
        assert!(
            !text.contains("](") && text.lines().all(|line| line.chars().count() < 110),
            "{text}"
        );
    }
}

#[test]
fn an_unknown_code_names_the_nearest() {
    explain(&["weakly-exited"])
        .ends(2)
        .tells(&["did you mean \"weakly-excited\"?"]);
    explain(&["zzz"]).tells(&["sprung explain --list"]);
    explain(&[]).ends(2);
}

#[test]
fn an_earlier_code_has_the_explanation_of_its_successor() {
    let earlier = explain(&["noisy-torque"]).out;
    assert_eq!(earlier, explain(&["noisy-signal"]).out);
    contains(&earlier, &["\nearlier "]);
}

#[test]
fn explanations_as_json_have_plain_texts() {
    let read = |words: &[&str]| explain(words).json();
    let table = read(&["--list", "--json"]);
    let table = table.as_array().unwrap();
    assert_eq!(table.len(), Explanation::all().len() + refusals().len());
    let one = read(&["noisy-torque", "--json"]);
    assert!(table.contains(&one), "{one:#}");
    assert_eq!(one["codes"], json!(["noisy-signal"]));
    assert_eq!(one["severities"], json!(["warning"]));
    for entry in table {
        for key in ["section", "cause", "remedy", "ignore", "example"] {
            let text = entry[key].as_str().unwrap();
            assert!(!text.is_empty() && !text.contains("]("), "{entry:#}");
        }
    }
    let output = explain(&["weakly-exited", "--json"]);
    let error: Value = serde_json::from_str(&output.err).unwrap();
    assert_eq!(error["code"], "usage");
    output.ends(2);
}
