//! Second moments of the mass of a body, from its inertial parameters.
//!
//! A body is possible if its mass is positive and if its density nowhere needs to be negative: the
//! second moments of its mass, with the first moments and the mass, form a positive definite matrix.
//!
//! ```text
//! J = [ ½ tr(I) 1 − I   h ]
//!     [ hᵀ              m ]  ≻ 0
//! ```
//!
//! # Source
//!
//! Wensing, Kim and Slotine, "Linear matrix inequalities for physically consistent inertial parameter
//! identification", IEEE Robotics and Automation Letters, 2018.

use sprung_core::linear::factor;
use sprung_core::spatial::BODY;

use super::convex::{Block, Entry, ROWS};

/// Entries of J that each inertial parameter of a body changes. J is symmetric.
const ENTRIES: [&[Entry]; BODY] = [
    &[Entry::at(3, 3, 1.0)],
    &[Entry::at(0, 3, 1.0)],
    &[Entry::at(1, 3, 1.0)],
    &[Entry::at(2, 3, 1.0)],
    &[
        Entry::at(0, 0, -0.5),
        Entry::at(1, 1, 0.5),
        Entry::at(2, 2, 0.5),
    ],
    &[Entry::at(0, 1, -1.0)],
    &[
        Entry::at(0, 0, 0.5),
        Entry::at(1, 1, -0.5),
        Entry::at(2, 2, 0.5),
    ],
    &[Entry::at(0, 2, -1.0)],
    &[Entry::at(1, 2, -1.0)],
    &[
        Entry::at(0, 0, 0.5),
        Entry::at(1, 1, 0.5),
        Entry::at(2, 2, -0.5),
    ],
];

/// Returns J of a body whose parameters are unknowns or known.
///
/// - `parameter`: returns the unknown or the value of an inertial parameter.
pub fn second_moments(parameter: impl Fn(usize) -> Result<usize, f64>) -> Block {
    let mut block = Block::new(ROWS, Vec::new());
    for (k, entries) in ENTRIES.iter().enumerate() {
        match parameter(k) {
            Ok(unknown) => block.terms.push((unknown, entries.to_vec())),
            Err(value) => block.add_constant(entries, value),
        }
    }
    block
}

/// Returns whether a body is possible. A thin rod and a thin plate are not, but bodies close to them.
///
/// - `least`: smallest eigenvalue of J relative to its trace, after the units are chosen such that the
///   body has the mass 1 and the root mean square radius 1.
#[must_use]
pub fn is_possible(body: &[f64; BODY], least: f64) -> bool {
    let radius = 0.5 * (body[4] + body[6] + body[9]) / body[0];
    if !(body[0] > 0.0 && radius > 0.0 && body.iter().all(|value| value.is_finite())) {
        return false;
    }
    let length = radius.sqrt();
    let mut j = second_moments(|k| Err(body[k])).constant;
    for (at, entry) in j.iter_mut().enumerate() {
        for index in [at / ROWS, at % ROWS] {
            *entry /= body[0].sqrt() * if index < 3 { length } else { 1.0 };
        }
    }
    let trace: f64 = (0..ROWS).map(|k| j[k * (ROWS + 1)]).sum();
    for k in 0..ROWS {
        j[k * (ROWS + 1)] -= least * trace;
    }
    factor(&mut j, ROWS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inertias_obey_the_triangle_inequality() {
        let body = |izz: f64| [1.0, 0.0, 0.0, 0.0, 0.02, 0.0, 0.03, 0.0, 0.0, izz];
        assert!(is_possible(&body(0.045), 1e-6));
        assert!(!is_possible(&body(0.051), 1e-6));
        // The mass would have to be outside of the body.
        let mut far = body(0.045);
        far[3] = 0.5;
        assert!(!is_possible(&far, 1e-6));
        assert!(!is_possible(&[0.0; BODY], 1e-6));
    }
}
