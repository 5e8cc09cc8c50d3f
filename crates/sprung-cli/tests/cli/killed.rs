//! What a run that is killed leaves behind.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Case, sprung, stderr};

/// Files of a folder by name.
type Files = BTreeMap<String, Vec<u8>>;

fn files(folder: &Path) -> Files {
    let entries = std::fs::read_dir(folder).unwrap();
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        (name, std::fs::read(entry.path()).unwrap())
    };
    entries.map(read).collect()
}

/// What is on its way to become a result, or says so.
fn is_temporary(name: &str) -> bool {
    name.starts_with('.')
}

fn results(folder: &Path) -> Files {
    let mut all = files(folder);
    all.retain(|name, _| !is_temporary(name));
    all
}

/// One setting makes the results of two runs differ.
const OLD: &str = "identify.filter_cutoff_rad_per_s=30";
const NEW: &str = "identify.filter_cutoff_rad_per_s=25";

fn run(case: &Case, setting: &str) -> Files {
    let output = case.identify(&["--quiet", "--set", setting]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let all = files(&case.path("sprung-out"));
    let left: Vec<&String> = all.keys().filter(|name| is_temporary(name)).collect();
    assert!(left.is_empty(), "left behind: {left:?}");
    all
}

/// Reads the results of a folder.
fn read(case: &Case, folder: &Path) {
    let output = sprung(&[
        "compare",
        folder.to_str().unwrap(),
        case.path("kept").to_str().unwrap(),
        "--quiet",
        "--out",
        case.path("comparison").to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

fn start(case: &Case) -> Child {
    Command::new(env!("CARGO_BIN_EXE_sprung"))
        .arg("identify")
        .arg(case.path("experiment.toml"))
        .args(["--quiet", "--set", NEW])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Waits until a new result is being written, or the run ends.
fn await_writing(folder: &Path, child: &mut Child) {
    while child.try_wait().unwrap().is_none() {
        let writes = std::fs::read_dir(folder).unwrap().any(|entry| {
            let name = entry.unwrap().file_name();
            is_temporary(&name.to_string_lossy())
        });
        if writes {
            return;
        }
        std::thread::yield_now();
    }
}

/// Returns which results are those of the new setting.
///
/// # Panics
///
/// If one is neither whole and new nor whole and old.
fn are_new(found: &Files, old: &Files, new: &Files) -> Vec<bool> {
    assert!(found.keys().eq(old.keys()), "{:?}", found.keys());
    let is_new = |name: &String| {
        let as_in = |run: &Files| essence(name, &found[name]) == essence(name, &run[name]);
        assert!(as_in(old) != as_in(new), "{name} is of neither run");
        as_in(new)
    };
    found.keys().map(is_new).collect()
}

/// What is the same in each run with one setting: all but how long it took.
fn essence(name: &str, bytes: &[u8]) -> String {
    let text = String::from_utf8(bytes.to_vec()).unwrap();
    match name {
        "identification.json" => {
            let json: serde_json::Value = serde_json::from_str(&text).unwrap();
            json["results"][0]["parameters"].to_string()
        }
        "report.html" => {
            assert!(
                text.trim_end().ends_with("</html>"),
                "the report is not whole"
            );
            text.contains(NEW).to_string()
        }
        _ => text,
    }
}

#[test]
fn a_killed_run_leaves_earlier_results_whole() {
    let case = Case::new().replace("[\"least-squares\", \"lsff\"]", "\"least-squares\"");
    let folder = case.path("sprung-out");
    let begin = Instant::now();
    let new = run(&case, NEW);
    let whole = begin.elapsed();
    let old = run(&case, OLD);
    assert_eq!(old.len(), 5, "{:?}", old.keys());
    assert!(are_new(&new, &old, &new).iter().all(|new| *new));
    std::fs::create_dir(case.path("kept")).unwrap();
    for (name, bytes) in &old {
        std::fs::write(case.path("kept").join(name), bytes).unwrap();
    }

    let (mut were_old, mut finished, mut cut_short) = (0, 0, 0);
    for moment in 0..24 {
        let mut child = start(&case);
        if moment < 8 {
            std::thread::sleep(whole * moment / 8);
        } else {
            await_writing(&folder, &mut child);
            std::thread::sleep(Duration::from_micros(200) * (moment - 8));
        }
        // SIGKILL on Unix.
        child.kill().unwrap();
        child.wait().unwrap();
        cut_short += u32::from(files(&folder).len() > results(&folder).len());
        finished += u32::from(folder.join(".sprung-switch").exists());
        read(&case, &folder);
        let are_new = are_new(&results(&folder), &old, &new);
        if are_new.iter().all(|new| !new) {
            were_old += 1;
            continue;
        }
        assert!(
            !are_new.contains(&false),
            "results of two runs: {are_new:?}"
        );
        // That there are old ones to lose again.
        run(&case, OLD);
    }
    println!(
        "of 24 runs {were_old} left the old results; {cut_short} were killed as they wrote, {finished} \
         between the files that take their places"
    );
    assert!(were_old >= 4 && cut_short >= 1, "{were_old}, {cut_short}");
    run(&case, NEW);
}
