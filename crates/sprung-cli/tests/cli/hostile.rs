//! Inputs that nobody should be able to stop a machine with: each ends with an error that names the limit.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::common::{Case, Ran, demo, sprung};

/// A file of a case, and the command that reads it, in which FILE stands for it and OUT for a new folder.
struct Input {
    name: &'static str,
    bytes: Vec<u8>,
    command: &'static str,
    code: i32,
    says: &'static str,
}

const NEW: &str = "new OUT --joints 1 --log FILE";
const URDF: &str = "new OUT --urdf FILE";
const CHECK: &str = "check FILE";
const COMPARE: &str = "compare FILE FILE";

fn gzip(text: &[u8], times: usize) -> Vec<u8> {
    let mut gzip = Command::new("gzip")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = gzip.stdin.take().unwrap();
    let text = text.to_vec();
    let writes = std::thread::spawn(move || {
        for _ in 0..times {
            input.write_all(&text).unwrap();
        }
    });
    let output = gzip.wait_with_output().unwrap();
    writes.join().unwrap();
    output.stdout
}

fn text(parts: &[(&str, usize)]) -> Vec<u8> {
    let parts = parts.iter().map(|(part, times)| part.repeat(*times));
    parts.collect::<String>().into_bytes()
}

fn joints(count: usize) -> Vec<u8> {
    let blocks = (0..count).map(|k| format!("[[robot.joint]]\nname = \"j{k}\"\n"));
    let rows = "{ a_m = 0.1 },".repeat(count);
    let robot = format!("format = 1\n[robot]\nname = \"x\"\ndh_modified = [{rows}]\n");
    (robot + &blocks.collect::<Vec<_>>().concat()).into_bytes()
}

fn chain(count: usize) -> Vec<u8> {
    let joint = |k: usize| {
        format!(
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"continuous\"><parent link=\"l{}\"/>\
             <child link=\"l{k}\"/><axis xyz=\"0 0 1\"/></joint>",
            k - 1
        )
    };
    let joints = (1..=count).map(joint).collect::<Vec<_>>().concat();
    format!("<robot name=\"x\"><link name=\"l0\"/>{joints}</robot>").into_bytes()
}

#[rustfmt::skip]
fn inputs() -> Vec<Input> {
    let row = |name, bytes, command, code, says| Input { name, bytes, command, code, says };
    vec![
        row("commas.csv.gz", gzip(&vec![b','; 1 << 20], 256), NEW, 3, "line 1 has more than 1 MiB"),
        row("digits.csv.gz", gzip(b"11111111", 1 << 22), NEW, 3, "line 1 has more than 1 MiB"),
        row("header.csv", text(&[("column,", 2_000_000)]), NEW, 3, "line 1 has more than 1 MiB"),
        row("quote.csv", text(&[("t,q\n0,\"1\n", 1), ("0,1\n", 1_000_000)]), NEW, 3, "line 3"),
        row("comment.csv", text(&[("#", 4 << 20)]), NEW, 3, "line 1 has more than 1 MiB"),
        row("columns.csv", text(&[("q,", 17_000), ("t\n", 1)]), NEW, 3, "line 1 has 17001 cells, and a log has at most 16384 columns"),
        row("cell.csv", text(&[("t,q\n0,", 1), ("1", 70_000), ("\n", 1)]), NEW, 3, "line 2 has a cell of 70000 bytes, and 64 KiB are the most"),
        row("name.csv", text(&[("t,", 1), ("q", 5000), ("\n0,1\n", 1)]), NEW, 3, "the name of a column has 5000 bytes, and 4 KiB are the most"),
        row("joints.toml", joints(65), CHECK, 2, "describes 65 joints, and sprung reads at most 64"),
        row("joints2000.toml", joints(2000), CHECK, 2, "describes 2000 joints"),
        row("comments.toml", text(&[("format = 1\n", 1), ("# more\n", 200_000)]), CHECK, 2, "an experiment file has at most 1 MiB"),
        row("key.toml", text(&[("format = 1\n", 1), ("a", 900_000), (" = 1\n", 1)]), CHECK, 2, "line 2"),
        row("empty.toml", text(&[("format = 1\nx = [", 1), ("{},", 300_000), ("]\n", 1)]), CHECK, 2, "line 2"),
        row("deep.toml", text(&[("x = ", 1), ("[", 500_000)]), CHECK, 2, "line 1"),
        row("chain.urdf", chain(2000), URDF, 2, "has 2000 movable joints, and sprung reads a URDF with at most 256 movable joints"),
        row("links.urdf", text(&[("<robot name=\"x\">", 1), ("<link name=\"l\"/>", 5000), ("</robot>", 1)]), URDF, 2, "has 5000 links, and sprung reads a URDF with at most 4096 links"),
        row("blanks.urdf", text(&[("<robot name=\"x\">", 1), (" ", 5 << 20)]), URDF, 2, "at most 4 MiB"),
        row("nodes.urdf", text(&[("<robot name=\"x\">", 1), ("<a/>", 1_000_000), ("</robot>", 1)]), URDF, 2, "has no <link>"),
        row("tag.urdf", text(&[("<", 1), ("a", 1_000_000), ("/>", 1)]), URDF, 2, "a URDF begins with <robot>"),
        row("objects.json", text(&[("[", 1), ("{},", 1_000_000), ("1]", 1)]), COMPARE, 2, "it has 1000000 objects, and 131072 are the most"),
        row("numbers.json", text(&[("[", 1), ("0,", 4_000_000), ("1]", 1)]), COMPARE, 2, "it has 4000002 values, and 1048576 are the most"),
    ]
}

/// Runs a command of a case with a bounded address space, in KiB.
fn limited(command: &str, file: &Path, out: &Path) -> Ran {
    let words = command.replace("FILE", &file.display().to_string());
    let words = words.replace("OUT", &out.display().to_string());
    Ran::of(
        Command::new("sh")
            .args([
                "-c",
                "ulimit -v 1500000 && exec \"$0\" \"$@\"",
                env!("CARGO_BIN_EXE_sprung"),
            ])
            .args(words.split(' ')),
    )
}

#[test]
fn no_input_takes_more_than_its_limit() {
    for Input {
        name,
        bytes,
        command,
        code,
        says,
    } in inputs()
    {
        let folder = TempDir::new().unwrap();
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        let output = limited(command, &file, &folder.path().join("out"));
        let told = &output.err;
        assert_eq!(output.code, Some(code), "{name}: {told}");
        assert!(told.contains(says), "{name}: {told}");
        assert!(told.len() < 1000, "{name}: {told}");
        assert!(!folder.path().join("out").exists(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn pipes_sockets_and_devices_are_no_inputs() {
    let folder = TempDir::new().unwrap();
    let (pipe, socket) = (folder.path().join("pipe"), folder.path().join("socket"));
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    for (file, kind) in [
        (pipe.as_path(), "it is a pipe"),
        (&socket, "it is a socket"),
        (Path::new("/dev/zero"), "it is a device"),
    ] {
        for command in [NEW, URDF, CHECK, COMPARE] {
            let output = limited(command, file, &folder.path().join("out"));
            let told = &output.err;
            assert_eq!(output.code, Some(4), "{command} {told}");
            assert!(told.contains(kind), "{command} {told}");
        }
    }
    // The log that an experiment names.
    let case = Case::new();
    case.remove("identification.csv");
    let pipe = case.path("identification.csv");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    case.identify(&[]).ends(4).tells(&["it is a pipe"]);
}

#[test]
fn control_characters_reach_no_terminal() {
    let log = "t,\u{1b}[31mq1\u{1b}[0m,\u{9b}31mtau1,q\u{202e}2\n0,\u{1b}]0;owned\u{7},1,2\n";
    let case = Case::of(&[
        ("log.csv", log),
        ("experiment.toml", "format = 1\n\"a\\u001b[31m\" = 1\n"),
        ("\u{1b}[31mlog.csv", log),
        (
            "robot.urdf",
            "<robot name=\"x\"><link name=\"a&#27;[31m\"/></robot>",
        ),
    ]);
    let out = case.at("out");
    for (command, file) in [
        (NEW, "log.csv"),
        (NEW, "\u{1b}[31mlog.csv"),
        (NEW, "\u{1b}[31mother.csv"),
        (URDF, "robot.urdf"),
        (CHECK, "experiment.toml"),
        (CHECK, "\u{1b}[31mexperiment.toml"),
        ("\u{1b}[31mcheck", ""),
        ("compare FILE --json", "log.csv"),
    ] {
        let file = case.at(file);
        let args: Vec<&str> = (command.split(' '))
            .map(|word| match word {
                "FILE" => &file,
                "OUT" => &out,
                word => word,
            })
            .collect();
        let output = sprung(&args);
        let written = output.out + &output.err;
        let raw = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!written.contains(raw), "{args:?}: {written:?}");
        let _ = std::fs::remove_dir_all(&out);
    }
}

#[test]
fn names_with_control_characters_give_an_experiment_that_can_be_read() {
    let row = |k: i32| format!("{},{},{},1\n", f64::from(k) * 0.01, k % 7, k % 5);
    let rows = (0..500).map(row).collect::<Vec<_>>().concat();
    let log = format!("t,\u{1b}[31mq1\u{1b}[0m,tau1,\"mo\nde\"\n{rows}");
    let case = Case::of(&[("log.csv", &log)]);
    let out = case.path("out").display().to_string();
    sprung(&["new", &out, "--joints", "1", "--log", &case.at("log.csv")]).ends(0);
    // A place to fill in is an error as well, but one of the keys and not of the text.
    sprung(&["check", &out]).tells(&["FILL IN"]);
}

#[cfg(unix)]
#[test]
fn what_cannot_be_written_ends_with_code_4_and_leaves_nothing() {
    let binary = env!("CARGO_BIN_EXE_sprung");
    let experiment = demo().join("experiment.toml").display().to_string();
    let linear = "identify.estimator=least-squares";
    let run = |shell: &str, out: &Path| {
        Ran::of(
            Command::new("sh")
                .args(["-c", shell, binary, &experiment, &out.display().to_string()])
                .args(["--set", linear]),
        )
    };
    for (name, shell, says) in [
        (
            "full",
            "exec \"$0\" identify \"$1\" --out \"$2\" \"$3\" \"$4\" > /dev/full",
            "cannot write to stdout",
        ),
        (
            "pipe",
            "{ \"$0\" identify \"$1\" --out \"$2\" \"$3\" \"$4\"; echo $? > \"$2.code\"; } | true; exit $(cat \"$2.code\")",
            "",
        ),
        (
            "size",
            "ulimit -f 8; exec \"$0\" identify \"$1\" --out \"$2\" \"$3\" \"$4\"",
            "results of earlier runs are unchanged",
        ),
        (
            "place",
            "exec \"$0\" identify \"$1\" --out /dev/null/out \"$3\" \"$4\"",
            "cannot create the folder",
        ),
    ] {
        let folder = TempDir::new().unwrap();
        let out = folder.path().join("out");
        let output = run(shell, &out);
        let told = &output.err;
        assert_eq!(output.code, Some(4), "{name}: {told}");
        assert!(told.contains(says), "{name}: {told}");
        let left = std::fs::read_dir(&out).into_iter().flatten();
        let left = left.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let parts: Vec<String> = left.filter(|name| name.contains(".part")).collect();
        assert_eq!(parts, Vec::<String>::new(), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_told_before_the_log_is_read() {
    let log = demo().join("identification.csv").display().to_string();
    for args in [
        ["new", "/dev/null/arm", "--log", &log],
        ["new", "/proc/arm", "--log", "no-such.csv"],
    ] {
        sprung(&args).ends(4).tells(&["cannot create the folder"]);
    }
}
