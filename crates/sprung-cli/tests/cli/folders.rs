//! Folders: places of logs and results, wrong paths of experiments, remaining files.

use std::path::Path;

use crate::common::{Case, Ran, demo, sprung, str_of};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Checks the exit code and the message of a command that fails.
#[track_caller]
fn refused(output: &Ran, code: i32, fragments: &[&str]) {
    let message = &output.err;
    println!("{message}");
    output.ends(code);
    for fragment in fragments {
        assert!(message.contains(fragment), "no {fragment:?} in: {message}");
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_found_before_the_log_is_read() {
    // The fault of the log would be found first if it were read first.
    let case = Case::new().cell(5, 2, "x");
    case.fails(3, &["line 6 of"]);
    let experiment = case.path("experiment.toml");
    for (verb, file) in [
        ("identify", "identification.json"),
        ("check", "check.html"),
        ("identify", "report.html"),
    ] {
        let out = case.path(&format!("taken-{file}"));
        std::fs::create_dir_all(out.join(file)).unwrap();
        let output = sprung(&[verb, text(&experiment), "--out", text(&out)]);
        refused(&output, 4, &["cannot write", file, "directory"]);
    }
    case.write("file", "");
    let out = case.path("file/out");
    let output = sprung(&["check", text(&experiment), "--out", text(&out)]);
    refused(
        &output,
        4,
        &["cannot create the folder", "choose another folder"],
    );
}

#[test]
fn a_command_that_fails_leaves_no_empty_folders() {
    let case = Case::new().cell(5, 2, "x");
    let output = case.identify(&["--out", text(&case.path("new/deep"))]);
    refused(&output, 3, &["line 6 of"]);
    assert!(!case.path("new").exists());
    std::fs::create_dir(case.path("new")).unwrap();
    refused(
        &case.identify(&["--out", text(&case.path("new/deep"))]),
        3,
        &[],
    );
    assert!(case.path("new").exists() && !case.path("new/deep").exists());
}

#[test]
fn a_missing_experiment_leads_to_new() {
    let case = Case::of(&[]);
    let folder = case.path("");
    let output = sprung(&["identify", text(&folder)]);
    refused(
        &output,
        4,
        &[
            "there is no experiment file",
            "experiment.toml; sprung new",
            "writes one to start from",
        ],
    );
    case.write("arm.toml", "");
    let output = sprung(&["check", text(&folder)]);
    refused(
        &output,
        4,
        &["give one of the other files by name", "arm.toml"],
    );
    let output = sprung(&["check", text(&case.path("amr.toml"))]);
    refused(
        &output,
        4,
        &[
            "there is no experiment file",
            "amr.toml",
            "sprung new FOLDER",
        ],
    );
}

#[test]
fn what_is_given_instead_of_an_experiment_is_named() {
    let case = Case::of(&[
        ("arm.urdf", "<robot name='r'/>"),
        ("arm.xacro", "<robot name='r'/>"),
        ("robot.xml", "<?xml version='1.0'?>\n<robot name='r'/>"),
        ("scene.xml", "<mujoco/>"),
        ("page", "<!DOCTYPE html><html></html>"),
        ("result", "{\"format\": 1}"),
        ("table.txt", "# made today\nt q phi tau\n0.0 1.0 1.0 0.1\n"),
        ("numbers", "1.0;2.0;3.0\n"),
        ("run.tsv", "t\tq\n"),
    ]);
    let bytes: [(&str, &[u8]); 5] = [
        ("bag", b"\x89MCAP0\r\nrest"),
        ("archive", b"PK\x03\x04rest"),
        ("wide", b"\xff\xfef\0o\0r\0m\0"),
        ("latin", b"format = 1\nname = \"Gelenk \xfc\"\n"),
        ("program", b"\x7fELF\0\0\0"),
    ];
    for (file, bytes) in bytes {
        case.write(file, bytes);
    }
    std::fs::create_dir(case.path("folder")).unwrap();
    case.write("folder/run_0.mcap", b"\x89MCAP0\r\n");
    for (file, what, remedy) in [
        ("arm.urdf", "is a URDF,", "--urdf"),
        ("arm.xacro", "is a xacro file,", "expand it with xacro"),
        ("robot.xml", "is a URDF,", "--urdf"),
        (
            "scene.xml",
            "is XML of another program,",
            "convert the robot to URDF",
        ),
        ("page", "is a report,", "that these results come from"),
        ("result", "is JSON,", "that these results come from"),
        ("table.txt", "is a table of numbers,", "[log]"),
        ("numbers", "is a table of numbers,", "[log]"),
        ("run.tsv", "is a log,", "[log]"),
        ("bag", "is an MCAP file,", "[log]"),
        ("archive", "is a zip archive,", "[log]"),
        ("wide", "is UTF-16 text,", "save it as UTF-8"),
        (
            "latin",
            "is text in another encoding than UTF-8,",
            "save it as UTF-8",
        ),
        ("program", "is a binary file,", "[log]"),
        ("folder", "is a folder with a bag, which is a log,", "[log]"),
        ("gone.csv", "is a log,", "sprung new FOLDER"),
    ] {
        let output = sprung(&["identify", text(&case.path(file))]);
        refused(&output, 2, &[file, what, "not an experiment file", remedy]);
    }
}

#[test]
fn identify_finds_the_log_that_simulate_writes() {
    let case = Case::new();
    let (experiment, log) = (
        case.path("experiment.toml"),
        case.path("identification.csv"),
    );
    std::fs::remove_file(&log).unwrap();
    let simulate = |more: &[&str]| {
        let short = ["--set", "simulate.duration_s=3"];
        sprung(&[&["simulate", text(&experiment)][..], &short, more].concat())
    };
    let output = simulate(&[]);
    output.ends(0);
    assert!(!output.out.contains("identify it with"), "{}", output.out);
    case.identify(&["-q"]).ends(0);

    // It may be a measured log.
    let before = std::fs::read(&log).unwrap();
    let seed = ["--set", "simulate.seed=7"];
    refused(
        &simulate(&seed),
        2,
        &[
            "exists and is not overwritten",
            "--out",
            "--set log.file=FILE",
        ],
    );
    assert_eq!(std::fs::read(&log).unwrap(), before);

    let out = case.path("other");
    let said = simulate(&["--out", text(&out)]).out;
    let (_, command) = said
        .split_once("identify it with: sprung ")
        .unwrap_or_else(|| panic!("{said}"));
    let words: Vec<&str> = command.split_whitespace().collect();
    let json = sprung(&[&words[..], &["--json"][..]].concat()).json();
    assert!(
        str_of(&json["log"]["file"]).contains("other"),
        "{}",
        json["log"]
    );

    // A twin writes CSV, whatever the name of the log.
    let said = simulate(&["--set", "log.file=run.csv.gz"]).out;
    assert!(
        case.path("run.csv").exists() && said.contains("--set log.file="),
        "{said}"
    );
}

#[test]
fn experiments_in_one_folder_keep_their_results_apart() {
    let case = Case::new().replace("[\"least-squares\", \"lsff\"]", "\"least-squares\"");
    let twin = case.path("second.toml");
    std::fs::copy(case.path("experiment.toml"), &twin).unwrap();
    case.identify(&["-q"]).ends(0);
    let first = std::fs::read(case.path("sprung-out/identification.json")).unwrap();
    let set = ["--set", "identify.position_cutoff_hz=12"];
    sprung(&[&["identify", text(&twin), "-q"][..], &set].concat()).ends(0);
    let second = case.path("sprung-out-second/identification.json");
    assert!(second.exists());
    assert_eq!(
        std::fs::read(case.path("sprung-out/identification.json")).unwrap(),
        first
    );

    // The folder of both has results of two experiments.
    let out = case.path("compared");
    let folder = case.path("");
    let output = sprung(&["compare", text(&folder), text(demo()), "--out", text(&out)]);
    refused(
        &output,
        2,
        &["has several folders of results", "sprung-out-second"],
    );
    let paths = [case.path("sprung-out"), case.path("sprung-out-second")];
    sprung(&[
        "compare",
        text(&paths[0]),
        text(&paths[1]),
        "--out",
        text(&out),
    ])
    .ends(0);
    std::fs::remove_dir_all(&paths[0]).unwrap();
    sprung(&["compare", text(&folder), text(demo()), "--out", text(&out)]).ends(0);
}

#[test]
fn temporary_files_of_a_killed_run_go_with_the_next_command() {
    let case = Case::new();
    let out = case.path("sprung-out");
    let left = out.join(".sprung-Ab12.part");
    let leave = || {
        std::fs::create_dir_all(&out).unwrap();
        std::fs::write(&left, "half").unwrap();
    };
    // The command fails, but the folder is clean.
    leave();
    let missing = ["--set", "log.file=gone.csv"];
    refused(&case.identify(&missing), 4, &["gone.csv"]);
    assert!(!left.exists());
    // A command that only reads cleans too.
    case.identify(&["-q"]).ends(0);
    leave();
    let compared = case.path("compared");
    sprung(&[
        "compare",
        text(&out),
        text(demo()),
        "-q",
        "--out",
        text(&compared),
    ])
    .ends(0);
    assert!(!left.exists());
    // The file of a running command stays.
    leave();
    let file = std::fs::File::open(&left).unwrap();
    file.lock().unwrap();
    refused(&case.identify(&missing), 4, &["gone.csv"]);
    assert!(left.exists());
}
