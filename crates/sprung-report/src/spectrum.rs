//! Power density of evenly spaced samples.

use std::f64::consts::TAU;

/// Number of windows of half overlapping length.
const WINDOWS: usize = 7;

/// Fewest samples of a window, and most frequencies.
const LEAST_SAMPLES: usize = 32;
const MOST_FREQUENCIES: usize = 250;

/// Deviation of a step from the first one that ends evenly spaced samples, relative.
const UNEVEN: f64 = 0.01;

/// A spectrum.
pub(super) struct Spectrum {
    /// Hz.
    pub(super) frequency_hz: Vec<f64>,
    /// Power per Hz, in the square of the unit of the samples.
    pub(super) density: Vec<f64>,
}

/// Returns the mean of the power densities of half overlapping windows over the evenly spaced samples at the beginning;
/// `None` if they are too few.
///
/// - `time`: s; `values`: one per time.
///
/// # Source
///
/// Welch, "The use of fast Fourier transform for the estimation of power spectra", 1967, with Hann windows.
pub(super) fn spectrum(time: &[f64], values: &[Option<f64>]) -> Option<Spectrum> {
    let step = time.get(1)? - time.first()?;
    let is_even = |pair: &[f64]| ((pair[1] - pair[0]) / step - 1.0).abs() < UNEVEN;
    let even = time.windows(2).take_while(|pair| is_even(pair)).count() + 1;
    let values: Vec<f64> = values.iter().take(even).map_while(|value| *value).collect();
    let length = 2 * (values.len() / (WINDOWS + 1));
    if length < LEAST_SAMPLES || step.is_nan() || step <= 0.0 {
        return None;
    }
    let turn = |k: usize| TAU * k as f64 / length as f64;
    let hann: Vec<f64> = (0..length)
        .map(|k| 0.5 - 0.5 * (turn(k) + 0.5 * turn(1)).cos())
        .collect();
    let power: f64 = hann.iter().map(|weight| weight * weight).sum();
    let windows: Vec<Vec<f64>> = (0..WINDOWS)
        .map(|window| {
            let window = &values[window * length / 2..][..length];
            let mean = window.iter().sum::<f64>() / length as f64;
            let weighted = window.iter().zip(&hann);
            weighted
                .map(|(value, weight)| weight * (value - mean))
                .collect()
        })
        .collect();
    let sine: Vec<f64> = (0..length).map(|k| turn(k).sin()).collect();
    let cosine: Vec<f64> = (0..length).map(|k| turn(k).cos()).collect();
    let lines = (length / 2).min(MOST_FREQUENCIES);
    let line = |i: usize| (i + 1) * (length / 2) / lines;
    let density = |index: usize| -> f64 {
        let of_window = |window: &Vec<f64>| -> f64 {
            let (mut real, mut imaginary) = (0.0, 0.0);
            let mut angle = 0;
            for value in window {
                real += value * cosine[angle];
                imaginary += value * sine[angle];
                angle += index;
                if angle >= length {
                    angle -= length;
                }
            }
            2.0 * step * (real * real + imaginary * imaginary) / power
        };
        windows.iter().map(of_window).sum::<f64>() / WINDOWS as f64
    };
    Some(Spectrum {
        frequency_hz: (0..lines)
            .map(|i| line(i) as f64 / (length as f64 * step))
            .collect(),
        density: (0..lines).map(|i| density(line(i))).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_density_integrates_to_the_mean_square_and_peaks_at_the_sine() {
        let time: Vec<f64> = (0..2000).map(|k| 5e-3 * f64::from(k)).collect();
        let values: Vec<Option<f64>> = time
            .iter()
            .map(|t| Some(3.0 * (TAU * 20.0 * t).sin()))
            .collect();
        let found = spectrum(&time, &values).unwrap();
        let step = found.frequency_hz[1] - found.frequency_hz[0];
        let power: f64 = found.density.iter().map(|density| density * step).sum();
        assert!((power / 4.5 - 1.0).abs() < 0.02, "{power}");
        let highest =
            (0..found.density.len()).max_by(|&a, &b| found.density[a].total_cmp(&found.density[b]));
        assert!((found.frequency_hz[highest.unwrap()] - 20.0).abs() <= step);
    }

    #[test]
    fn a_gap_ends_the_samples_and_few_samples_have_no_spectrum() {
        let mut time: Vec<f64> = (0..1000).map(f64::from).collect();
        time[100..].iter_mut().for_each(|t| *t += 5.0);
        assert!(spectrum(&time, &vec![Some(1.0); 1000]).is_none());
        assert!(spectrum(&[], &[]).is_none());
    }
}
