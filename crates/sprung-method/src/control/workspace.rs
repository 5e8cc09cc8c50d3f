//! Poses that fill a workspace.

/// Prime numbers, bases of the Halton sequence.
const PRIMES: [u32; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// Returns poses that fill the ranges evenly, the middle first; \[count\]\[n\].
///
/// - `ranges`: lowest and highest position of each joint, \[n\], rad (m).
///
/// # Source
///
/// Halton, "On the efficiency of certain quasi-random sequences of points", Numerische Mathematik 2, 1960.
#[must_use]
pub fn workspace_poses(ranges: &[[f64; 2]], count: usize) -> Vec<Vec<f64>> {
    let at = |index: usize| -> Vec<f64> {
        (ranges.iter().enumerate())
            .map(|(joint, [low, high])| {
                let part = if index == 0 {
                    0.5
                } else {
                    radical_inverse(index as u32, PRIMES[joint % PRIMES.len()])
                };
                low + part * (high - low)
            })
            .collect()
    };
    (0..count).map(at).collect()
}

/// Returns the digits of a number after the point, in reverse order.
fn radical_inverse(mut index: u32, base: u32) -> f64 {
    let (mut part, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        part += digit * f64::from(index % base);
        index /= base;
    }
    part
}
