//! Springs of 1e5 to 1e7 N·m/rad of the twin with seven joints and torque sensors, moved below 1 Hz: which ones are
//! determined, the lower bounds of the others, and the errors of all other parameters.
//!
//! `cargo bench -p sprung --bench stiff [-- --seeds 50]`
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

#[path = "../../tests/twin/in_memory.rs"]
mod in_memory;
#[path = "twin.rs"]
mod stiff;

use sprung_testing::Figure;
use stiff::{Draw, Spring, draw, stiffnesses};

const DURATION_S: f64 = 10.0;

/// A stiffness that is wrong by a larger factor is absurd.
const ABSURD: f64 = 10.0;

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("cargo bench -p sprung --bench stiff prints the figures");
        return;
    }
    let seeds = seeds();
    let mut all: Vec<Draw> = Vec::new();
    for seed in 1..=seeds {
        let draw = draw(seed, DURATION_S, stiffnesses(seed));
        let [with, rigid] = draw.squares;
        println!(
            "seed {seed}: {} of 7 determined, errors {:.3} times those of rigid joints, {} {}",
            draw.springs
                .iter()
                .filter(|spring| spring.value.is_some())
                .count(),
            (with / rigid).sqrt(),
            draw.identification.results[0].verdict.word(),
            draw.identification.results[0].decision.findings.join(" ")
        );
        all.push(draw);
    }
    let springs = || all.iter().flat_map(|draw| &draw.springs);
    let count = springs().count();
    let determined: Vec<&Spring> = springs().filter(|spring| spring.value.is_some()).collect();
    let is_absurd = |spring: &&&Spring| {
        let ratio = spring.value.map_or(1.0, |value| value / spring.truth);
        !(ABSURD.recip()..ABSURD).contains(&ratio)
    };
    let absurd = determined.iter().filter(is_absurd).count();
    println!(
        "{} of {count} springs determined, {absurd} of them negative or wrong by more than {ABSURD} times",
        determined.len()
    );
    let bounds: Vec<(f64, &Spring)> = springs()
        .filter_map(|spring| Some((spring.above?, spring)))
        .collect();
    let held = bounds
        .iter()
        .filter(|(above, spring)| *above < spring.truth);
    println!(
        "{} of {} lower bounds are below the truth",
        held.count(),
        bounds.len()
    );
    let part = |count: usize, all: usize| 100.0 * count as f64 / all.max(1) as f64;
    let text = format!("stiff springs with torque sensors, {count} springs");
    let note = |what: &str, share: f64| {
        Figure::neutral(
            &format!("stiff, {what}"),
            &format!("{text}: {what}"),
            share,
            "%",
        )
        .note();
    };
    note("determined", part(determined.len(), count));
    note(
        "determined and wrong by more than ten times",
        part(absurd, determined.len()),
    );
    let below = bounds
        .iter()
        .filter(|(above, spring)| *above < spring.truth);
    note(
        "lower bounds below the truth",
        part(below.count(), bounds.len()),
    );
    let mut ratios: Vec<f64> = bounds
        .iter()
        .map(|(above, spring)| above / spring.known)
        .collect();
    ratios.sort_by(f64::total_cmp);
    if let Some(median) = ratios.get(ratios.len() / 2) {
        println!("median of the bound over that of a known model: {median:.2}");
    }
    let sum = |which: usize| all.iter().map(|draw| draw.squares[which]).sum::<f64>();
    println!(
        "rms error of the other parameters over that with rigid joints: {:.3}",
        (sum(0) / sum(1)).sqrt()
    );
}

/// Returns the number after `--seeds`, or 50.
fn seeds() -> u64 {
    let mut words = std::env::args().skip_while(|word| word != "--seeds");
    let seeds = words.nth(1).map(|word| word.parse());
    seeds.map_or(50, |seeds| seeds.expect("--seeds needs a number"))
}
