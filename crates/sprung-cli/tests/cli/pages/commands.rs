//! The page of the commands, and the commands of the questions.

use super::{beside_the_demo, of_repository, run_commands};
use crate::common::sprung;

const PAGE: &str = "docs/reference/commands.md";

#[test]
fn its_commands_run() {
    let folder = beside_the_demo();
    let printed = run_commands(&of_repository(PAGE), folder.path());
    assert!(printed.len() >= 8, "{}", printed.len());
    assert!(folder.path().join("second-run/identification.csv").exists());
}

#[test]
fn commands_of_the_questions_run() {
    let folder = beside_the_demo();
    let page = of_repository("docs/how-to/faq.md");
    let printed = run_commands(&page, folder.path());
    assert!(printed.len() >= 14, "{}", printed.len());
    assert!(printed.iter().any(|text| text.contains("\nignore it ")));
}

#[test]
fn it_names_the_exit_codes_of_the_help() {
    let help = sprung(&["--help"]).out;
    let listed = help.split("Exit codes:").nth(1).unwrap();
    let codes: Vec<&str> = (listed.lines())
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert_eq!(codes.len(), 5, "{listed}");
    let page = of_repository(PAGE);
    let section = page.split("## Exit codes").nth(1).unwrap();
    let rows: Vec<&str> = (section.lines())
        .filter_map(|line| line.strip_prefix("| ")?.split(' ').next())
        .filter(|cell| cell.parse::<u8>().is_ok())
        .collect();
    assert_eq!(rows, codes);
}

#[test]
fn it_names_all_verbs() {
    let help = sprung(&["--help"]).out;
    let verbs = help.split("Commands:").nth(1).unwrap();
    let verbs = verbs.split("Options:").next().unwrap();
    let page = of_repository(PAGE);
    let section = page.split("## Verbs").nth(1).unwrap();
    for line in verbs.lines().filter(|line| line.starts_with("  ")) {
        let verb = line.split_whitespace().next().unwrap();
        let is_named = section.contains(&format!("| `{verb}"));
        assert!(is_named || verb == "help", "{verb}");
    }
}
