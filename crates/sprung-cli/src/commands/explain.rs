//! `sprung explain`: the meaning of a finding or of a refusal.

use sprung::description::refusals;
use sprung::finding::Explanation;

use crate::args::Explain;
use crate::exit_code::{ExitCode, Failure};
use crate::terminal::{print, print_json};

/// Columns of a line of text.
const WIDTH: usize = 96;
/// Columns of the names before the texts.
const INDENT: usize = 11;

pub(crate) fn run(args: &Explain) -> Result<ExitCode, Failure> {
    let refusals = refusals();
    let all = Explanation::all().iter().chain(&refusals);
    let Some(code) = &args.code else {
        if args.json {
            let table: Vec<Explanation> = all.map(Explanation::in_plain_text).collect();
            print_json(&table);
        } else {
            let codes = all.flat_map(|explanation| &explanation.codes);
            let lines: Vec<&str> = codes.map(String::as_str).collect();
            print(&lines.join("\n"));
        }
        return Ok(ExitCode::Done);
    };
    let found = all.clone().find(|explanation| explanation.has(code));
    let explanation = found.ok_or_else(|| {
        let hint = Explanation::nearest_code(code, all).map_or_else(
            || "sprung explain --list prints all codes".to_owned(),
            |near| format!("did you mean \"{near}\"?"),
        );
        let message = format!("there is no finding \"{code}\"; {hint}");
        Failure::usage(message)
    })?;
    let explanation = explanation.in_plain_text();
    if args.json {
        print_json(&explanation);
    } else {
        print(&shown(&explanation));
    }
    Ok(ExitCode::Done)
}

/// Returns an explanation as text.
fn shown(explanation: &Explanation) -> String {
    let codes = explanation.codes.join(", ");
    let title = format!("{codes} ({})", explanation.section);
    let severity = explanation.severities.join(", ");
    let earlier = explanation.aliases.join(", ");
    let parts = [
        ("earlier", Some(&earlier).filter(|codes| !codes.is_empty())),
        ("severity", Some(&severity)),
        ("cause", Some(&explanation.cause)),
        ("condition", explanation.condition.as_ref()),
        ("remedy", Some(&explanation.remedy)),
        ("ignore it", Some(&explanation.ignore)),
        ("example", explanation.example.as_ref()),
    ];
    let mut lines = vec![title, String::new()];
    for (name, text) in parts {
        if let Some(text) = text {
            let wrapped = wrapped(text, WIDTH - INDENT);
            for (place, line) in wrapped.iter().enumerate() {
                let head = if place == 0 { name } else { "" };
                lines.push(format!("{head:INDENT$}{line}"));
            }
        }
    }
    lines.join("\n")
}

/// Breaks a text into lines.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last().map_or(0, |line| line.chars().count());
        if last > 0 && last + 1 + word.chars().count() > width {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}
