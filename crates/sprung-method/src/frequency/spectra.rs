//! Spectra of torques and positions at the lines of a discrete Fourier transform.

use std::f64::consts::{PI, TAU};

use faer::c64;

use super::fourier::{smooth_length, transforms};
use super::period::period;
use super::record::Segment;

/// Highest line relative to the sampling rate.
const HIGHEST_LINE: f64 = 0.4;

/// Fewest samples of a spectrum.
const FEWEST_SAMPLES: usize = 1000;

/// Largest prime factor of the length of a transform, beyond which it would be slow.
const LARGEST_FACTOR: usize = 1000;

/// Spectra of all joints.
#[derive(Clone, Debug)]
pub(super) struct Spectra {
    /// Frequency of each line, Hz.
    pub(super) hz: Vec<f64>,
    /// Duration of the samples, s.
    pub(super) duration: f64,
    /// Number of periods, if the motion repeats itself. Then the lines are the harmonics, and their
    /// values are means over the periods.
    pub(super) periods: Option<usize>,
    // First sample and number of samples of the transform, and the step between its lines.
    from: usize,
    length: usize,
    step: usize,
    /// Motor torques as they act, held between the samples of the log, \[n\]\[lines\].
    pub(super) torque: Vec<Vec<c64>>,
    /// Motor positions, \[n\]\[lines\].
    pub(super) motor: Vec<Vec<c64>>,
    /// Link positions, \[n\]\[lines\].
    pub(super) link: Vec<Vec<c64>>,
}

impl Spectra {
    /// Returns the spectra of a segment; `None` if it is too short.
    #[must_use]
    pub(super) fn of(segment: &Segment) -> Option<Self> {
        let repeated = period(segment).and_then(|period| {
            let all = segment.len() / period;
            // The first of several periods contains the transient of the start.
            let periods = if all > 2 { all - 1 } else { all };
            (periods > 1 && largest_factor(period * periods) <= LARGEST_FACTOR)
                .then_some((period, periods))
        });
        Self::of_periods(segment, repeated)
    }

    /// Returns the spectra of a whole segment, whether its motion repeats itself or not; `None` if it is too short.
    #[must_use]
    pub(super) fn of_whole(segment: &Segment) -> Option<Self> {
        Self::of_periods(segment, None)
    }

    /// - `repeated`: samples of a period and number of periods; `None` without.
    fn of_periods(segment: &Segment, repeated: Option<(usize, usize)>) -> Option<Self> {
        let (length, step) = match repeated {
            Some((period, periods)) => (period * periods, periods),
            None => (smooth_length(segment.len()), 1),
        };
        if length < FEWEST_SAMPLES {
            return None;
        }
        let count = (HIGHEST_LINE * length as f64) as usize;
        let duration = length as f64 * segment.period();
        let lines = (0..count).step_by(step).skip(1);
        let mut spectra = Self {
            hz: lines.map(|line| line as f64 / duration).collect(),
            duration,
            periods: repeated.map(|(_, periods)| periods),
            from: segment.len() - length,
            length,
            step,
            torque: Vec::new(),
            motor: Vec::new(),
            link: Vec::new(),
        };
        let n = segment.joints();
        let mut all = spectra.of_columns(&segment.columns);
        spectra.link = all.split_off(2 * n);
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
                (spectrum.into_iter().step_by(self.step).skip(1))
                    .map(|value| value / length)
                    .collect()
            })
            .collect()
    }

    /// Returns the range of the lines nearest to a frequency, in a band and not more than a number.
    pub(super) fn window(
        &self,
        centre: f64,
        half_width: f64,
        most: usize,
    ) -> std::ops::Range<usize> {
        let place = |hz: f64| self.hz.partition_point(|line| *line < hz);
        let (from, to) = (place(centre - half_width), place(centre + half_width));
        let middle = place(centre);
        from.max(middle.saturating_sub(most / 2))..to.min(middle + most / 2)
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

fn largest_factor(mut number: usize) -> usize {
    let mut factor = 2;
    while factor * factor <= number {
        if number.is_multiple_of(factor) {
            number /= factor;
        } else {
            factor += 1;
        }
    }
    number
}
