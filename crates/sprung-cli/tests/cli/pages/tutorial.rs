//! The tutorial, followed step by step.

use std::fs;

use tempfile::TempDir;

use super::{blocks, first_result, of_repository, path_in_repository};
use crate::common::{Ran, contains, program, sprung};

/// Joins the lines of the quotations of a page.
fn quotations(page: &str) -> Vec<String> {
    let mut all = Vec::new();
    let mut is_inside = false;
    for line in page.lines() {
        match line.strip_prefix("> ") {
            Some(words) if is_inside => {
                let last: &mut String = all.last_mut().unwrap();
                last.push(' ');
                last.push_str(words);
            }
            Some(words) => all.push(words.to_owned()),
            None => {}
        }
        is_inside = line.starts_with("> ");
    }
    all
}

#[test]
fn it_leads_to_the_report() {
    let page = of_repository("docs/tutorial.md");
    let folder = TempDir::new().unwrap();
    for file in ["arm.urdf", "run.mcap", "second.mcap"] {
        let source = path_in_repository("examples/two-joint-arm").join(file);
        fs::copy(source, folder.path().join(file)).unwrap();
    }
    let commands = blocks(&page, "sh");
    let edits = blocks(&page, "toml");
    assert_eq!((commands.len(), edits.len()), (4, 2));
    let run = |k: usize| {
        let words: Vec<&str> = commands[k].split_whitespace().collect();
        assert_eq!(words[0], "sprung");
        let output = Ran::of(program().args(&words[1..]).current_dir(folder.path()));
        assert!(output.code == Some(0), "{words:?}: {output:?}");
        output.out + &output.err
    };
    run(0);

    let file = folder.path().join("my-arm/experiment.toml");
    let begun = fs::read_to_string(&file).unwrap();
    for line in edits[0].lines() {
        assert!(begun.contains(&format!("\n{line}\n")), "{line}: {begun}");
    }
    fs::write(&file, format!("{begun}\n{}", edits[1])).unwrap();

    let last_line = blocks(&page, "text")[1].clone();
    let printed = run(1);
    contains(&printed, &[&last_line]);
    let printed = run(2);
    for line in blocks(&page, "text")[2].lines() {
        let stiffness: Vec<&str> = line.split_whitespace().collect();
        let result = first_result(&folder.path().join("my-arm/sprung-out"));
        let all = result["parameters"].as_array().unwrap();
        let found = all.iter().find(|one| one["name"] == stiffness[0]).unwrap();
        let shown: f64 = stiffness[3].parse().unwrap();
        let error = found["standard_error"].as_f64().unwrap();
        let off = (found["value"].as_f64().unwrap() - shown).abs();
        assert!(off <= 0.1 * error, "{line}: {found}");
    }
    let quoted = quotations(&page);
    assert_eq!(quoted.len(), 2);
    assert!(printed.contains(&quoted[0]), "{printed}");
    let printed = run(3);
    assert!(printed.contains(&quoted[1]), "{printed}");
    let report = fs::metadata(folder.path().join("my-arm/sprung-out/report.html"));
    assert!(report.unwrap().len() > 10_000);
}

#[test]
fn its_arm_can_be_simulated_again() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let twin = path_in_repository("examples/two-joint-arm/twin.toml");
    let twin = twin.to_str().unwrap();
    for run in [&[][..], &["--run", "second motion"]] {
        let output = sprung(&[&["simulate", twin, "--out", out][..], run].concat());
        assert!(output.code == Some(0), "{output:?}");
    }
    for log in ["run.csv", "second.csv"] {
        let text = fs::read_to_string(folder.path().join(log)).unwrap();
        assert_eq!(text.lines().count(), 3001);
    }
}
