//! Spectra of torques and positions at the lines of a discrete Fourier transform.

use std::f64::consts::{PI, TAU};

use faer::c64;

use super::fourier::{smooth_length, transforms};
use super::record::Segment;

/// Highest line relative to the sampling rate.
const HIGHEST_LINE: f64 = 0.4;

/// Fewest samples of a spectrum.
const FEWEST_SAMPLES: usize = 1000;

/// Spectra of all joints.
#[derive(Clone, Debug)]
pub(super) struct Spectra {
    /// Frequency of each line, Hz.
    pub(super) hz: Vec<f64>,
    // First sample and number of samples of the transform.
    from: usize,
    length: usize,
    /// Motor torques as they act, held between the samples of the log, \[n\]\[lines\].
    pub(super) torque: Vec<Vec<c64>>,
    /// Motor positions, \[n\]\[lines\].
    pub(super) motor: Vec<Vec<c64>>,
}

impl Spectra {
    /// Returns the spectra of a whole segment; `None` if it is too short.
    #[must_use]
    pub(super) fn of(segment: &Segment) -> Option<Self> {
        let length = smooth_length(segment.len());
        if length < FEWEST_SAMPLES {
            return None;
        }
        let count = (HIGHEST_LINE * length as f64) as usize;
        let duration = length as f64 * segment.period();
        let mut spectra = Self {
            hz: (1..count).map(|line| line as f64 / duration).collect(),
            from: segment.len() - length,
            length,
            torque: Vec::new(),
            motor: Vec::new(),
        };
        let n = segment.joints();
        let mut all = spectra.of_columns(&segment.columns);
        spectra.motor = all.split_off(n);
        for torque in &mut all {
            for (value, hz) in torque.iter_mut().zip(&spectra.hz) {
                *value *= hold(*hz, segment.log_period);
            }
        }
        spectra.torque = all;
        Some(spectra)
    }

    /// Returns the spectra of columns with one value per sample of the segment.
    #[must_use]
    pub(super) fn of_columns(&self, columns: &[Vec<f64>]) -> Vec<Vec<c64>> {
        let length = self.length as f64;
        let centred: Vec<Vec<f64>> = (columns.iter())
            .map(|column| {
                let samples = &column[self.from..self.from + self.length];
                let mean = samples.iter().sum::<f64>() / length;
                samples.iter().map(|x| x - mean).collect()
            })
            .collect();
        let views: Vec<&[f64]> = centred.iter().map(Vec::as_slice).collect();
        let count = (HIGHEST_LINE * length) as usize;
        transforms(&views, count)
            .into_iter()
            .map(|spectrum| {
                (spectrum.into_iter().skip(1))
                    .map(|value| value / length)
                    .collect()
            })
            .collect()
    }
}

/// Returns the frequency response of holding each sample until the next one.
fn hold(hz: f64, period: f64) -> c64 {
    let half = PI * hz * period;
    let (sin, cos) = half.sin_cos();
    c64::new(cos, -sin) * (sin / half)
}

/// Returns jω, rad/s.
pub(super) fn imaginary(hz: f64) -> c64 {
    c64::new(0.0, TAU * hz)
}
