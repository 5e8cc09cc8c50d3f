//! Counts the faults of logs that the check finds, and its false alarms.
//!
//! `cargo bench -p sprung --bench faults` prints the tables. Arguments after `--` change their
//! extent:
//!
//! - `--seeds 10`: number of logs per fault and size.
//! - `--clean 100`: number of logs without fault, with the demo's encoders and with coarser
//!   encoders.
//! - `--kinds saturated,spike`: only faults whose names contain one of these words.
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

mod faults;
#[path = "../../tests/twin/in_memory.rs"]
mod in_memory;
mod twin;

use std::collections::BTreeMap;

use faults::{Fault, KINDS, Kind};
use in_memory::with_source;
use rayon::prelude::*;
use sprung_base::finding::Severity;
use sprung_base::progress::Unheard;
use sprung_method::check::{CheckReport, check};
use sprung_model::Model;
use sprung_testing::Figure;
use twin::{Demo, Table};

struct Arguments {
    seeds: u64,
    clean: u64,
    kinds: Vec<String>,
}

impl Arguments {
    /// Reads the command line. Returns `None` if `cargo bench` did not start the program.
    ///
    /// # Panics
    ///
    /// If an argument is unknown or has no valid value.
    fn new() -> Option<Self> {
        let mut found = Self {
            seeds: 10,
            clean: 100,
            kinds: vec![String::new()],
        };
        let mut bench = false;
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().expect("an argument lacks its value");
            match word.as_str() {
                "--bench" => bench = true,
                "--seeds" => found.seeds = value().parse().expect("--seeds is a number"),
                "--clean" => found.clean = value().parse().expect("--clean is a number"),
                "--kinds" => found.kinds = value().split(',').map(str::to_owned).collect(),
                other => panic!("no argument {other}"),
            }
        }
        bench.then_some(found)
    }
}

fn main() {
    let Some(arguments) = Arguments::new() else {
        return;
    };
    let demo = Demo::new();
    if arguments.clean > 0 {
        clean("demo", &demo, arguments.clean, |seed| demo.table(seed, 1.0));
        clean("4096 counts", &demo, arguments.clean, |seed| {
            demo.with_counts(seed, 4096)
        });
    }
    faults(&demo, &arguments);
}

/// Returns the report of a check.
fn report(demo: &Demo, fault: &Fault) -> CheckReport {
    let experiment = fault.experiment(&demo.experiment);
    let model = Model::new(&experiment).expect("the twin has a model");
    let log = fault.table.csv();
    let checked = with_source(&log, |source| {
        check(&experiment, &model, &mut [source], &mut Unheard)
    })
    .expect("the log can be read");
    checked.report
}

/// Returns the codes of the findings above a note.
fn alarms(report: &CheckReport) -> Vec<String> {
    (report.findings.iter())
        .filter(|finding| finding.severity >= Severity::Warning)
        .map(|finding| finding.code.clone())
        .collect()
}

/// Checks logs without fault. Every finding above a note is a false alarm, and so is every unknown, because results use it.
fn clean(name: &str, demo: &Demo, logs: u64, table: impl Fn(u64) -> Table + Sync) {
    let all: Vec<Vec<String>> = (0..logs)
        .into_par_iter()
        .map(|seed| {
            let fault = Fault::none(table(1000 + seed));
            let report = report(demo, &fault);
            let unknowns = report.unknowns.iter().map(|unknown| unknown.id.clone());
            alarms(&report).into_iter().chain(unknowns).collect()
        })
        .collect();
    let wrong = all.iter().filter(|codes| !codes.is_empty()).count();
    println!("clean logs, {name}: {wrong} of {logs} with a false alarm");
    let text = format!("false alarms in {logs} logs without fault, {name}");
    Figure::lower(&format!("clean, {name}"), &text, wrong as f64, "").note();
    let mut codes: BTreeMap<&str, usize> = BTreeMap::new();
    for code in all.iter().flatten() {
        *codes.entry(code).or_default() += 1;
    }
    for (code, count) in codes {
        println!("  {code}: {count}");
    }
}

fn faults(demo: &Demo, arguments: &Arguments) {
    let seeds = arguments.seeds;
    println!("\nfaults: part found at five sizes, {seeds} logs each");
    let wanted =
        |kind: &&Kind| (arguments.kinds.iter()).any(|word| kind.name.contains(word.as_str()));
    let (mut found, mut all) = (0, 0);
    for kind in KINDS.iter().filter(wanted) {
        let found_before = found as u32;
        let mut cells = Vec::new();
        let mut missed: BTreeMap<String, usize> = BTreeMap::new();
        for &size in &kind.sizes {
            let hits: Vec<Result<(), String>> = (0..seeds)
                .into_par_iter()
                .map(|seed| {
                    let fault = kind.inject(demo, size, seed);
                    let report = report(demo, &fault);
                    let hit = (report.findings.iter())
                        .any(|finding| kind.codes.contains(&finding.code.as_str()));
                    if hit {
                        Ok(())
                    } else {
                        Err(alarms(&report).join("+"))
                    }
                })
                .collect();
            let hit = hits.iter().filter(|hit| hit.is_ok()).count();
            for instead in hits.into_iter().filter_map(Result::err) {
                *missed.entry(instead).or_default() += 1;
            }
            found += hit;
            all += seeds as usize;
            cells.push(format!(
                "{size} {}: {:.0} %",
                kind.unit,
                100.0 * hit as f64 / seeds.max(1) as f64
            ));
        }
        println!("  {:28} {}", kind.name, cells.join(" | "));
        let of_kind = f64::from(found as u32 - found_before);
        let percent = 100.0 * of_kind / (kind.sizes.len() as f64 * seeds as f64).max(1.0);
        // The table of the page has the kinds that are not always found.
        let text = match kind.sizes[..] {
            [first, .., last] if percent < 100.0 => {
                format!(
                    "{}, {first} {unit} to {last} {unit}",
                    kind.name,
                    unit = kind.unit
                )
            }
            _ => String::new(),
        };
        Figure::higher(kind.name, &text, percent, "%").note();
        for (instead, count) in missed {
            let instead = if instead.is_empty() {
                "nothing"
            } else {
                &instead
            };
            println!("      {count} missed, said instead: {instead}");
        }
    }
    let percent = 100.0 * f64::from(found as u32) / f64::from(all.max(1) as u32);
    println!("found {found} of {all}, {percent:.1} %");
    let text = format!("all {all} logs with a fault");
    Figure::higher("faults", &text, percent, "%").note();
}
