//! The open loops over the frequency, with the band of the posterior.

use faer::c64;
use rayon::prelude::*;

use super::pictures::{Banded, LoopCurve};
use super::pose::linear;
use super::sampled::{Law, Sampled};
use super::task::ControlTask;
use crate::description::Controller;

/// Number of frequencies, and the lowest as a part of half the sampling rate.
const FREQUENCIES: usize = 240;
const LOWEST: f64 = 2e-4;

/// Most robots in a band.
const ROBOTS: usize = 40;

/// Returns the loop of each motor in the first pose.
pub(super) fn loop_curves(task: &ControlTask<'_>, controller: &Controller) -> Vec<LoopCurve> {
    let n = task.model.joint_count();
    let nyquist = 0.5 / task.period;
    let hz: Vec<f64> = (0..FREQUENCIES)
        .map(|k| 0.98 * nyquist * LOWEST.powf(1.0 - k as f64 / (FREQUENCIES - 1) as f64))
        .collect();
    let law = Law::of(controller, n);
    let robots: Vec<&[f64]> = std::iter::once(&task.theta[..])
        .chain(task.draws.iter().take(ROBOTS).map(|draw| &draw[..]))
        .collect();
    let all: Vec<Vec<Vec<c64>>> = (robots.par_iter())
        .filter_map(|theta| {
            let linear = linear(task.model, theta, &task.poses[0])?;
            let plant = Sampled::new(task.model, &linear, task.period);
            Some(hz.iter().map(|hz| plant.loops(&law, *hz)).collect())
        })
        .collect();
    (0..n)
        .map(|joint| {
            let gains: Vec<Vec<f64>> = (all.iter())
                .map(|response| {
                    response
                        .iter()
                        .map(|at| 20.0 * at[joint].norm().log10())
                        .collect()
                })
                .collect();
            let phases: Vec<Vec<f64>> = all
                .iter()
                .map(|response| unwrapped(response, joint))
                .collect();
            let band = |all: &[Vec<f64>]| {
                let all: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
                Banded::of(&all)
            };
            LoopCurve {
                joint: task.model.joints()[joint].clone(),
                hz: hz.clone(),
                gain_db: band(&gains),
                phase_deg: band(&phases),
            }
        })
        .collect()
}

/// Returns the phase without jumps, degrees; at the lowest frequency it is between -360 and 0.
fn unwrapped(response: &[Vec<c64>], joint: usize) -> Vec<f64> {
    let mut last: Option<f64> = None;
    response
        .iter()
        .map(|at| {
            let phase = at[joint].im.atan2(at[joint].re).to_degrees();
            let near = match last {
                None => phase - if phase > 0.0 { 360.0 } else { 0.0 },
                Some(last) => phase + 360.0 * ((last - phase) / 360.0).round(),
            };
            last = Some(near);
            near
        })
        .collect()
}
