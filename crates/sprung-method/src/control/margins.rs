//! Stability of the closed loop: margins of each motor's loop, and the least damping.

use std::f64::consts::{PI, TAU};

use faer::c64;

use super::pose::linear;
use super::sampled::{Law, Sampled};
use crate::description::Controller;
use crate::model::Model;

/// Even steps of the frequency in its logarithm, and further frequencies about each resonance of the loop, in half widths.
const STEPS: usize = 100;
const ABOUT: [f64; 5] = [-2.5, -0.8, 0.0, 0.8, 2.5];

/// Damping ratio above which a vibration makes no narrow peak.
const BROAD: f64 = 0.3;

/// Lowest frequency, part of half the sampling rate.
const LOWEST: f64 = 1e-4;

/// The margins of one motor's loop with the others closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Least factor by which the gain may grow or fall, dB.
    pub gain_db: f64,
    /// Least phase that may be lost or won, degrees.
    pub phase_deg: f64,
    /// Highest frequency at which the gain of the open loop falls below one, Hz; 0 without one.
    pub crossover_hz: f64,
}

/// A pole of the sampled closed loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopPole {
    /// Natural frequency, Hz.
    pub hz: f64,
    /// Damping ratio; negative for a vibration that grows.
    pub damping: f64,
}

/// The stability of a loop about rest in a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Stability {
    /// Rate at which the least stable motion grows, 1/s; `None` if the loop is stable.
    pub growth_per_s: Option<f64>,
    /// Least damping ratio of the poles that vibrate; 1 without any.
    pub least_damping: f64,
    /// Margins of each motor's loop, \[n\]; they have a meaning only if the loop is stable.
    pub margins: Vec<Margins>,
    /// Poles that vibrate below 90 % of half the sampling rate, lowest frequency first.
    pub vibrations: Vec<LoopPole>,
}

/// A pole whose imaginary part is a smaller part of its rate does not vibrate.
const REAL: f64 = 1e-9;

/// Growth within one period that counts as instability.
const GROWS: f64 = 1e-6;

/// Part of half the sampling rate below which a pole counts as a vibration of the robot.
const BELOW: f64 = 0.9;

/// Returns the stability of a sampled closed loop about rest in a pose; `None` if no robot can have the values or a number is
/// not finite.
///
/// Friction counts by its slope in motion, so Coulomb friction adds no damping.
///
/// - `theta`: values of the robot, \[p\].
/// - `q`: link positions, \[n\], rad (m).
/// - `period`: of the controller, s.
///
/// # Source
///
/// Åström and Wittenmark, Computer-Controlled Systems, 3rd edition, 1997, Sections 2.3 and 3.2.
#[must_use]
pub fn stability(
    model: &Model,
    theta: &[f64],
    controller: &Controller,
    q: &[f64],
    period: f64,
) -> Option<Stability> {
    let plant = Sampled::new(model, &linear(model, theta, q)?, period);
    let law = Law::of(controller, model.joint_count());
    let poles = plant.poles(&law)?;
    let nyquist = 0.5 / period;
    let rates: Vec<c64> = poles.iter().filter_map(|pole| plant.rate(*pole)).collect();
    let growth = rates
        .iter()
        .map(|rate| rate.re)
        .fold(f64::NEG_INFINITY, f64::max);
    let vibrating: Vec<c64> = (rates.into_iter())
        .filter(|rate| rate.im > REAL * rate.norm() && rate.norm() < BELOW * TAU * nyquist)
        .collect();
    let mut frequencies: Vec<f64> = (0..=STEPS)
        .map(|k| nyquist * LOWEST.powf(1.0 - k as f64 / STEPS as f64))
        .collect();
    for rate in vibrating
        .iter()
        .filter(|rate| -rate.re < BROAD * rate.norm())
    {
        let width = rate.re.abs() / TAU;
        frequencies.extend(ABOUT.map(|part| rate.im / TAU + part * width));
    }
    frequencies.retain(|frequency| *frequency > 0.0 && *frequency < nyquist);
    frequencies.sort_by(f64::total_cmp);
    let open: Vec<Vec<c64>> = (frequencies.iter())
        .map(|hz| plant.loops(&law, *hz))
        .collect();
    let margins = (0..model.joint_count())
        .map(|joint| {
            let response: Vec<c64> = open.iter().map(|loops| loops[joint]).collect();
            margins(&frequencies, &response)
        })
        .collect();
    let mut vibrations: Vec<LoopPole> = (vibrating.iter())
        .map(|rate| LoopPole {
            hz: rate.norm() / TAU,
            damping: -rate.re / rate.norm(),
        })
        .collect();
    vibrations.sort_by(|a, b| a.hz.total_cmp(&b.hz));
    Some(Stability {
        growth_per_s: (growth * period > GROWS).then_some(growth),
        least_damping: vibrations
            .iter()
            .map(|vibration| vibration.damping)
            .fold(1.0, f64::min),
        margins,
        vibrations,
    })
}

/// Returns the margins of an open loop at rising frequencies.
fn margins(frequencies: &[f64], open: &[c64]) -> Margins {
    let mut margins = Margins {
        gain_db: f64::INFINITY,
        phase_deg: 180.0,
        crossover_hz: 0.0,
    };
    for (hz, pair) in frequencies.windows(2).zip(open.windows(2)) {
        let [before, after] = [pair[0], pair[1]];
        if before.im.signum() * after.im.signum() < 0.0 {
            let part = before.im / (before.im - after.im);
            let real = before.re + part * (after.re - before.re);
            if real < 0.0 {
                margins.gain_db = margins.gain_db.min((20.0 * (-real).log10()).abs());
            }
        }
        let [first, second] = [before.norm().ln(), after.norm().ln()];
        if (first < 0.0) != (second < 0.0) {
            let part = first / (first - second);
            let at = before + (after - before) * part;
            let phase = PI - at.im.atan2(at.re).abs();
            margins.phase_deg = margins.phase_deg.min(phase.to_degrees());
            if first >= 0.0 {
                margins.crossover_hz = hz[0] + part * (hz[1] - hz[0]);
            }
        }
    }
    margins
}
