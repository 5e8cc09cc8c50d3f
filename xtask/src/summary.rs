//! The last lines of a run of tests: where the time went, what was skipped, what failed.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use crate::run::Outcome;
use crate::steps::Steps;

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
    if let Some(step) = &steps.failed {
        eprintln!("── FAILED at the step {step}");
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
    eprintln!("── steps, s");
    let line = |name: &str, time: Duration| eprintln!("{:8.1}  {name}", time.as_secs_f64());
    for (name, time) in &steps.times {
        line(name, *time);
    }
    line("together", steps.begin.elapsed());
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
