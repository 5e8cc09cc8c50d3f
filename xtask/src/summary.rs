//! The last lines of a run of tests: times, skipped tests, failures.

use std::collections::{BTreeMap, BTreeSet};

use crate::run::Outcome;
use crate::steps::{Steps, Time, processor_time};

/// How many of the slowest tests are named.
const SLOWEST: usize = 10;

/// Prints the summary; returns whether all passed.
pub(crate) fn print(steps: &Steps, outcome: &Outcome) -> bool {
    slowest(outcome);
    times(steps);
    let skipped = skipped(outcome);
    for test in &outcome.failed {
        eprintln!("── failed: {test}");
    }
    if !steps.failed.is_empty() {
        eprintln!("── FAILED: {}", steps.failed.join(", "));
        return false;
    }
    let passed = outcome.ended - skipped;
    match skipped {
        _ if outcome.ended == 0 => eprintln!("── all passed"),
        0 => eprintln!("── all passed: {passed} tests; no test was skipped"),
        1 => eprintln!("── all passed: {passed} tests; 1 test was SKIPPED"),
        _ => eprintln!("── all passed: {passed} tests; {skipped} tests were SKIPPED"),
    }
    true
}

fn slowest(outcome: &Outcome) {
    let mut times = outcome.times.clone();
    if times.is_empty() {
        return;
    }
    times.sort_by(|a, b| b.1.total_cmp(&a.1));
    eprintln!("── slowest tests, s");
    for (test, seconds) in times.iter().take(SLOWEST) {
        eprintln!("{seconds:8.2}  {test}");
    }
}

fn times(steps: &Steps) {
    eprintln!("── steps: elapsed and processor time, s");
    let line = |time: &Time| {
        let processor = time.processor.map_or_else(
            || " ".repeat(8),
            |used| format!("{:8.1}", used.as_secs_f64()),
        );
        eprintln!(
            "{:8.1}{processor}  {}",
            time.elapsed.as_secs_f64(),
            time.step
        );
    };
    steps.times.iter().for_each(line);
    line(&Time {
        step: "together".to_owned(),
        elapsed: steps.begin.elapsed(),
        processor: processor_time(),
    });
}

/// Prints the skipped tests by their reason; returns how many there are.
fn skipped(outcome: &Outcome) -> usize {
    let mut by_reason: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let mut tests = BTreeSet::new();
    for (test, reason) in &outcome.skipped {
        // A test that lacks two things is named with the first.
        if tests.insert(test.as_str()) {
            by_reason.entry(reason).or_default().insert(test);
        }
    }
    for (reason, tests) in by_reason {
        eprintln!("── SKIPPED because {reason}");
        for test in tests {
            eprintln!("          {test}");
        }
    }
    tests.len()
}
