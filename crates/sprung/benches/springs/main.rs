//! Springs of the 2-DOF arm from its motors alone: errors and intervals of logs with different phases.
//!
//! `cargo bench -p sprung --bench springs [-- --seeds 6]`
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

#[path = "../../tests/twin/in_memory.rs"]
mod in_memory;
#[path = "twin.rs"]
mod springs;

use std::collections::BTreeMap;

use rayon::prelude::*;
use springs::{Errors, vibrations};
use sprung_testing::Figure;

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("cargo bench -p sprung --bench springs prints the table");
        return;
    }
    let seeds = seeds();
    let all: Vec<Vec<Errors>> = (0..seeds)
        .into_par_iter()
        .map(|seed| vibrations(seed).0)
        .collect();
    for spring in all.iter().flatten() {
        let ([stiffness, of_stiffness], [rotor, of_rotor]) = (spring.stiffness, spring.rotor);
        println!(
            "{}: stiffness {:+.2} % ({of_stiffness:+.1}), rotor {:+.2} % ({of_rotor:+.1})",
            spring.joint,
            100.0 * stiffness,
            100.0 * rotor
        );
    }
    let held: usize = all.iter().flatten().map(Errors::held).sum();
    let count = 2 * all.iter().flatten().count();
    println!("{held} of {count} intervals contain the truth");
    let mut largest: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
    for errors in all.iter().flatten() {
        let most = largest.entry(&errors.joint).or_default();
        most[0] = most[0].max(100.0 * errors.stiffness[0].abs());
        most[1] = most[1].max(100.0 * errors.rotor[0].abs());
    }
    for (joint, [stiffness, rotor]) in largest {
        for (what, value) in [("stiffness", stiffness), ("rotor inertia", rotor)] {
            let text = format!("springs from motors alone, {joint}: largest error of the {what}");
            Figure::lower(&format!("{joint} {what}"), &text, value, "%").note();
        }
    }
    let inside = 100.0 * held as f64 / count as f64;
    let text =
        format!("springs from motors alone: 95 % intervals that contain the truth, of {count}");
    Figure::neutral("motors alone, inside", &text, inside, "%").note();
}

/// Returns the number after `--seeds`, or 6.
fn seeds() -> u64 {
    let mut words = std::env::args().skip_while(|word| word != "--seeds");
    let seeds = words.nth(1).map(|word| word.parse());
    seeds.map_or(6, |seeds| seeds.expect("--seeds needs a number"))
}
