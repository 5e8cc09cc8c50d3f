//! The page of the findings, written from their explanations; `sprung explain`.

use std::fmt::Write;
use std::process::Command;

use sprung::finding::Explanation;

use super::experiment::same_or_written;
use crate::common::{stderr, stdout};

const HEAD: &str = "# Findings

A finding is an observation that you must know. It has a code, a severity, a text with values, a remedy and, where one
line of the experiment file corrects the cause, this line. This page has the cause, the condition and the remedy of each code;
`sprung explain CODE` prints them, and `sprung explain --list` prints all codes. [Verdict, promise and
proof](../explanation/verdict.md#findings-and-their-cost) says what severities cost, [How the check
works](../explanation/checks.md) its method.
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
    let codes: Vec<String> = explanation
        .codes
        .iter()
        .map(|code| format!("`{code}`"))
        .collect();
    // Links in the texts begin at the root of the repository.
    let linked = |text: &str| {
        text.replace("](docs/", "](../")
            .replace("](../reference/", "](")
    };
    let mut text = format!("\n### {}\n\n", codes.join(", "));
    writeln!(text, "- Cause: {}.", linked(&explanation.cause)).unwrap();
    let severities = explanation.severities.join(", ");
    match &explanation.condition {
        Some(condition) => {
            writeln!(text, "- Condition ({severities}): {}.", linked(condition)).unwrap();
        }
        None => writeln!(text, "- Severity: {severities}.").unwrap(),
    }
    writeln!(text, "- Remedy: {}.", linked(&explanation.remedy)).unwrap();
    if let Some(example) = &explanation.example {
        writeln!(text, "\n> {example}").unwrap();
    }
    text
}

#[test]
fn the_page_is_that_of_the_explanations() {
    same_or_written("docs/reference/findings.md", page());
}

fn explain(words: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_sprung"))
        .arg("explain")
        .args(words)
        .output()
        .unwrap()
}

#[test]
fn a_finding_is_explained_and_all_are_listed() {
    let list = stdout(&explain(&["--list"]));
    let codes: Vec<&str> = list.lines().collect();
    assert_eq!(
        codes.len(),
        Explanation::all()
            .iter()
            .map(|explanation| explanation.codes.len())
            .sum::<usize>()
    );
    for code in ["gaps", "weakly-excited", "noisy-torque"] {
        assert!(codes.contains(&code));
        let output = explain(&[code]);
        let text = stdout(&output);
        assert!(
            output.status.success() && text.lines().next().unwrap().contains(code),
            "{text}"
        );
        assert!(
            text.contains("\ncause ") && text.contains("\nremedy "),
            "{text}"
        );
        assert!(
            !text.contains("](") && text.lines().all(|line| line.chars().count() < 110),
            "{text}"
        );
    }
}

#[test]
fn an_unknown_code_names_the_nearest() {
    let output = explain(&["weakly-exited"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("did you mean \"weakly-excited\"?"),
        "{}",
        stderr(&output)
    );
    let output = explain(&["zzz"]);
    assert!(
        stderr(&output).contains("sprung explain --list"),
        "{}",
        stderr(&output)
    );
    assert_eq!(explain(&[]).status.code(), Some(2));
}
