//! Measures time and memory of a check of a long log.
//!
//! `cargo bench -p sprung-cli --bench size` simulates an hour of the seven-joint twin (3.6 million
//! rows, 22 columns, 1.5 GB of text), writes it as CSV and Parquet into a temporary folder, and
//! prints elapsed time, processor time (which other programs on the machine do not lengthen) and
//! peak memory of `sprung check`. Arguments after `--`:
//!
//! - `--hours 1`: length of the log.
//! - `--folder DIR`: keeps the logs in this folder, and uses the logs that are already there.
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]
#![expect(clippy::unwrap_used, reason = "a benchmark may panic")]

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use sprung_testing::Figure;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::properties::WriterProperties;

/// Goals for one hour: time in s, and memory in MB if memory has a goal.
const GOALS: [(&str, f64, Option<f64>); 2] =
    [("log.parquet", 15.0, Some(200.0)), ("log.csv", 25.0, None)];

/// Rows per row group, the default of pyarrow.
const ROWS_PER_GROUP: usize = 1 << 20;

/// Rows passed to the writer at once.
const ROWS_PER_WRITE: usize = 1 << 14;

fn main() {
    // `cargo test --all-targets` starts benchmarks too.
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("cargo bench -p sprung-cli --bench size checks a log of one hour");
        return;
    }
    let (hours, kept) = arguments();
    let temporary = tempfile::TempDir::new().unwrap();
    let folder = kept.unwrap_or_else(|| temporary.path().to_owned());
    std::fs::create_dir_all(&folder).unwrap();
    if !folder.join("log.csv").exists() {
        record(&folder, hours);
    }
    if !folder.join("log.parquet").exists() {
        convert(&folder);
    }
    println!(
        "{:<12} {:>8} {:>9} {:>9} {:>9} {:>10}  goal for an hour",
        "log", "MB", "s", "cpu s", "peak MB", "samples"
    );
    for (log, seconds, megabytes) in GOALS {
        let bytes = std::fs::metadata(folder.join(log)).unwrap().len();
        let run = check(&folder, log);
        let memory = megabytes.map_or_else(String::new, |goal| format!(", {goal} MB"));
        println!(
            "{log:<12} {:>8.0} {:>9.2} {:>9.2} {:>9.1} {:>10}  {seconds} s{memory}",
            bytes as f64 / 1e6,
            run.seconds,
            run.cpu_seconds,
            run.peak_mb,
            run.samples
        );
        let text = format!(
            "`check` of `{log}`, {hours} h of seven joints, {} samples",
            run.samples
        );
        Figure::lower(&format!("check {log}"), &text, run.cpu_seconds, "s").note();
        Figure::lower(
            &format!("check {log}, memory"),
            "the same: memory",
            run.peak_mb,
            "MB",
        )
        .scatter(0.1)
        .note();
    }
}

fn arguments() -> (f64, Option<PathBuf>) {
    let (mut hours, mut folder) = (1.0, None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().expect("an argument lacks its value");
        match word.as_str() {
            // Cargo adds this argument.
            "--bench" => {}
            "--hours" => hours = value().parse().expect("--hours is a number"),
            "--folder" => folder = Some(PathBuf::from(value())),
            other => panic!("no argument {other}"),
        }
    }
    (hours, folder)
}

fn sprung() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sprung"))
}

/// Simulates the twin and writes its log as CSV.
fn record(folder: &Path, hours: f64) {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/seven-joint-twin");
    for file in ["experiment.toml", "truth.toml"] {
        std::fs::copy(example.join(file), folder.join(file)).unwrap();
    }
    let (out, duration) = (folder.join("twin"), 3600.0 * hours - 0.001);
    let status = sprung()
        .arg("simulate")
        .arg(folder)
        .args(["--quiet", "--set", "log.file=log.csv"])
        .arg("--set")
        .arg(format!("simulate.duration_s={duration}"))
        .arg("--out")
        .arg(&out)
        .status();
    assert!(status.unwrap().success(), "the twin was not recorded");
    std::fs::rename(out.join("log.csv"), folder.join("log.csv")).unwrap();
}

/// Converts the log from CSV to Parquet.
fn convert(folder: &Path) {
    let mut lines = BufReader::new(File::open(folder.join("log.csv")).unwrap()).lines();
    let header = lines.next().unwrap().unwrap();
    let field = |name| Field::new(name, DataType::Float64, false);
    let schema = Arc::new(Schema::new(
        header.split(',').map(field).collect::<Vec<_>>(),
    ));
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_max_row_group_row_count(Some(ROWS_PER_GROUP))
        .build();
    let part = folder.join("log.parquet.part");
    let file = File::create(&part).unwrap();
    let mut writer = ArrowWriter::try_new(file, schema.clone(), Some(properties)).unwrap();
    let mut columns: Vec<Vec<f64>> =
        vec![Vec::with_capacity(ROWS_PER_WRITE); schema.fields().len()];
    let mut write = |columns: &mut Vec<Vec<f64>>| {
        let arrays = columns
            .iter_mut()
            .map(|column| Arc::new(Float64Array::from(std::mem::take(column))) as ArrayRef);
        let batch = RecordBatch::try_new(schema.clone(), arrays.collect()).unwrap();
        writer.write(&batch).unwrap();
    };
    for line in lines {
        for (column, cell) in columns.iter_mut().zip(line.unwrap().split(',')) {
            column.push(cell.parse().unwrap());
        }
        if columns[0].len() == ROWS_PER_WRITE {
            write(&mut columns);
        }
    }
    write(&mut columns);
    writer.close().unwrap();
    std::fs::rename(part, folder.join("log.parquet")).unwrap();
}

struct Run {
    seconds: f64,
    cpu_seconds: f64,
    peak_mb: f64,
    samples: u64,
}

/// Checks a log and measures the time and the memory.
fn check(folder: &Path, log: &str) -> Run {
    let out = folder.join("out");
    let start = Instant::now();
    let mut child = sprung()
        .arg("check")
        .arg(folder)
        .args(["--quiet", "--set"])
        .arg(format!("log.file={log}"))
        .arg("--out")
        .arg(&out)
        .stderr(Stdio::inherit())
        .spawn()
        .unwrap();
    let (mut cpu_seconds, mut peak_mb) = (0.0_f64, 0.0_f64);
    let status = loop {
        // A process that has ended gives no figures.
        cpu_seconds = cpu_seconds.max(processor_time(child.id()).unwrap_or(0.0));
        peak_mb = peak_mb.max(high_water(child.id()).unwrap_or(0.0));
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let seconds = start.elapsed().as_secs_f64();
    // A log of the twin has at most serious findings, no errors.
    assert!(matches!(status.code(), Some(0 | 1)), "{log}: {status}");
    let text = std::fs::read_to_string(out.join("check.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    Run {
        seconds,
        cpu_seconds,
        peak_mb,
        samples: report["logs"][0]["samples"].as_u64().unwrap(),
    }
}

/// Returns the processor time of a process so far, user and system mode together, s. Linux provides
/// it in hundredths.
fn processor_time(process: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The fields follow the name of the program, which may contain blanks.
    let (_, fields) = text.rsplit_once(')')?;
    let ticks = |field: usize| fields.split_whitespace().nth(field)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// Returns the peak resident memory of a process so far, MB. Linux provides it.
fn high_water(process: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0 / 1e6)
}
