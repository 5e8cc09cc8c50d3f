//! The discrete Fourier transform of any length.

use std::f64::consts::TAU;

use faer::c64;

/// Returns the largest number up to `most` whose prime factors are 2, 3 and 5.
#[must_use]
pub(super) fn smooth_length(most: usize) -> usize {
    let is_smooth = |&length: &usize| {
        let mut rest = length;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (1..=most).rev().find(is_smooth).unwrap_or(0)
}

/// Returns the transforms of real signals of one length, \[lines\] each: `Σ x_k exp(-2πi k m / N)`
/// for m from 0 to below `lines`, which is at most N/2.
#[must_use]
pub(super) fn transforms(signals: &[&[f64]], lines: usize) -> Vec<Vec<c64>> {
    let length = signals.first().map_or(0, |signal| signal.len());
    let roots: Vec<c64> = (0..length)
        .map(|k| {
            let (sin, cos) = (TAU * k as f64 / length as f64).sin_cos();
            c64::new(cos, -sin)
        })
        .collect();
    let mut all = Vec::with_capacity(signals.len());
    // One complex transform gives those of two real signals.
    for pair in signals.chunks(2) {
        let other = pair.get(1).copied().unwrap_or_default();
        let both: Vec<c64> = (0..length)
            .map(|k| c64::new(pair[0][k], other.get(k).copied().unwrap_or_default()))
            .collect();
        let mut out = vec![c64::new(0.0, 0.0); length];
        transform(&both, 1, &mut out, &roots);
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for m in 0..lines {
            let (here, mirrored) = (out[m], out[(length - m) % length].conj());
            first.push((here + mirrored) * 0.5);
            second.push((here - mirrored) * c64::new(0.0, -0.5));
        }
        all.push(first);
        if pair.len() == 2 {
            all.push(second);
        }
    }
    all
}

/// Transforms every `stride`-th number of `x` into `out`, by one prime factor of the length after
/// another.
fn transform(x: &[c64], stride: usize, out: &mut [c64], roots: &[c64]) {
    let length = out.len();
    if length <= 1 {
        out.copy_from_slice(&x[..length]);
        return;
    }
    let factor = (2..=length)
        .find(|factor| length.is_multiple_of(*factor) || factor * factor > length)
        .filter(|factor| length.is_multiple_of(*factor))
        .unwrap_or(length);
    let part = length / factor;
    for (j, out) in out.chunks_mut(part).enumerate() {
        transform(&x[j * stride..], stride * factor, out, roots);
    }
    let turn = roots.len() / length;
    let mut gathered = vec![c64::new(0.0, 0.0); factor];
    for k in 0..part {
        if factor == 2 {
            let (even, odd) = (out[k], out[k + part] * roots[k * turn]);
            out[k] = even + odd;
            out[k + part] = even - odd;
            continue;
        }
        for (j, value) in gathered.iter_mut().enumerate() {
            *value = out[k + j * part];
        }
        for r in 0..factor {
            let at = k + r * part;
            out[at] = (gathered.iter().enumerate())
                .map(|(j, value)| *value * roots[(j * at) % length * turn])
                .sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_are_the_sums_of_their_definition() {
        for length in [1, 2, 12, 30, 49, 97] {
            let signals: Vec<Vec<f64>> = (0..3)
                .map(|i| (0..length).map(|k| ((k * k + i) as f64).sin()).collect())
                .collect();
            let views: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
            let lines = length / 2;
            for (signal, found) in signals.iter().zip(transforms(&views, lines)) {
                assert_eq!(found.len(), lines);
                for (m, value) in found.iter().enumerate() {
                    let expected: c64 = (signal.iter().enumerate())
                        .map(|(k, x)| {
                            let (sin, cos) = (TAU * (k * m) as f64 / length as f64).sin_cos();
                            c64::new(cos, -sin) * *x
                        })
                        .sum();
                    assert!((value - expected).norm() < 1e-11, "{length} {m}");
                }
            }
        }
    }

    #[test]
    fn smooth_lengths_are_near_the_limit() {
        assert_eq!(smooth_length(30_000), 30_000);
        assert_eq!(smooth_length(29_999), 29_160);
        assert_eq!(smooth_length(0), 0);
    }
}
