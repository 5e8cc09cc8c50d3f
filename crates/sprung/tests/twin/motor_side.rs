//! Springs of the 2-DOF arm from its motors alone.
//!
//! `cargo bench -p sprung --bench springs` prints the figures of docs/how-to/no-link-encoder.md.

use sprung_base::finding::Severity;

use crate::logs::named;
use crate::springs::{Errors, STIFFNESS, identification, multisine, truth, vibrations};

#[test]
fn vibrations_of_the_motors_give_the_springs() {
    for seed in 0..2 {
        let (springs, codes) = vibrations(seed);
        assert!(
            codes.iter().any(|code| code == "springs-by-vibration"),
            "{codes:?}"
        );
        for spring in &springs {
            let [error, sigmas] = spring.stiffness;
            println!("{}: stiffness {error:+.4} ({sigmas:+.1})", spring.joint);
            assert!(error.abs() < 0.03, "{} {error}", spring.joint);
        }
        // All 24 intervals of the benchmark contain the truth; of the four of one log one may miss.
        let held: usize = springs.iter().map(Errors::held).sum();
        assert!(held >= 3, "seed {seed}: {held} of 4");
    }
}

#[test]
fn a_slow_motion_gives_no_spring() {
    let found = identification(&multisine(0.3, 4.0, 1), &truth(), 1);
    assert!(
        found
            .springs_from_motor
            .iter()
            .all(|spring| spring.stiffness.is_none())
    );
    let finding = named(&found.findings, "resonance-not-excited");
    assert_eq!(finding.severity, Severity::Warning);
}

#[test]
fn dry_friction_that_hides_the_vibrations_gives_no_spring() {
    // The friction of the demo: the motors hardly feel the springs.
    let mut truth = truth();
    truth.insert("joint1.motor_viscous".to_owned(), 8.435_283);
    truth.insert("joint2.motor_viscous".to_owned(), 0.135_564);
    truth.insert("joint1.motor_coulomb".to_owned(), 1.360_21);
    truth.insert("joint2.motor_coulomb".to_owned(), 0.162_529);
    let found = identification(&multisine(1.0, 1.0, 1), &truth, 1);
    for (spring, stiffness) in found.springs_from_motor.iter().zip(STIFFNESS) {
        let near = spring
            .stiffness
            .is_none_or(|value| (value - stiffness).abs() < 0.1 * stiffness);
        assert!(near, "{spring:?}");
    }
}
