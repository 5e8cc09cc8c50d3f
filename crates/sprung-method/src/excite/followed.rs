//! Links that follow the reference exactly: springs deflect by the torques of the links, without friction.

use std::f64::consts::TAU;

use faer::Mat;

use super::motion::{ByMotion, Moved, fill_torque, waves};
use super::physics::{MotionAt, Physics};

/// A robot whose links follow one period of a series.
#[derive(Clone, Debug)]
pub(super) struct Followed {
    physics: Physics,
    waves: Vec<Mat<f64>>,
    /// Derivatives of periodic samples, once and twice, \[samples × samples\]; `None` without springs.
    derivative: Option<[Mat<f64>; 2]>,
}

impl Followed {
    pub(super) fn new(physics: Physics, rate: f64, harmonics: &[usize], samples: usize) -> Self {
        let period = TAU / rate;
        let times: Vec<f64> = (0..samples)
            .map(|t| period * t as f64 / samples as f64)
            .collect();
        let has_springs = physics.stiffness.iter().any(Option::is_some);
        Self {
            waves: waves(rate, harmonics, 3, &times),
            derivative: has_springs.then(|| derivatives(rate, samples)),
            physics,
        }
    }

    pub(super) fn run(&mut self, coefficients: &[Vec<f64>]) -> Moved {
        let n = coefficients.len();
        let samples = self.waves[0].nrows();
        let given = Mat::from_fn(coefficients[0].len(), n, |i, j| coefficients[j][i]);
        let signals: Vec<Mat<f64>> = self.waves.iter().map(|wave| wave * &given).collect();
        let model = self.physics.model.clone();
        let count = model.robot().entries;
        let mut at = vec![MotionAt::zero(n); samples];
        let mut entries = vec![0.0; count];
        let mut deflection = Mat::zeros(samples, n);
        let mut deflections = vec![0.0; n];
        for (t, at) in at.iter_mut().enumerate() {
            for (order, signal) in signals.iter().enumerate() {
                for joint in 0..n {
                    at.link[order][joint] = signal[(t, joint)];
                    at.motor[order][joint] = signal[(t, joint)];
                }
            }
            if self.derivative.is_some() {
                self.physics.entries(at, &mut entries);
                self.physics.deflections(&entries, &mut deflections);
                for (joint, x) in deflections.iter().enumerate() {
                    deflection[(t, joint)] = *x;
                }
            }
        }
        if let Some([once, twice]) = &self.derivative {
            let all = [deflection.clone(), once * &deflection, twice * &deflection];
            for (t, at) in at.iter_mut().enumerate() {
                for (order, signal) in all.iter().enumerate() {
                    for joint in 0..n {
                        at.motor[order][joint] += signal[(t, joint)];
                    }
                }
            }
        }
        let mut all = Mat::zeros(samples, count);
        let mut torque = Mat::zeros(samples, model.coordinates());
        for (t, at) in at.iter().enumerate() {
            self.physics.entries(at, &mut entries);
            for (entry, x) in entries.iter().enumerate() {
                all[(t, entry)] = *x;
            }
            fill_torque(&self.physics, &entries, |row, sum| torque[(t, row)] = sum);
        }
        Moved {
            at,
            entries: all,
            torque,
            trace: Vec::new(),
            coefficients: coefficients.to_vec(),
        }
    }

    pub(super) fn pull(&mut self, moved: &Moved, mut by: ByMotion) -> Vec<Vec<f64>> {
        let (samples, n) = (moved.at.len(), moved.at[0].link[0].len());
        let count = moved.entries.ncols();
        for (t, motion) in by.at.iter_mut().enumerate() {
            let weights = (0..count).map(|entry| by.entries[(t, entry)]);
            self.physics.pull(&moved.at[t], weights, motion);
            for order in 0..3 {
                for joint in 0..n {
                    motion.link[order][joint] += motion.motor[order][joint];
                }
            }
        }
        if let Some([once, twice]) = &self.derivative {
            let of = |order: usize| Mat::from_fn(samples, n, |t, j| by.at[t].motor[order][j]);
            let sum = of(0) + once.transpose() * of(1) + twice.transpose() * of(2);
            let mut by_deflections = vec![0.0; n];
            for (t, by) in by.at.iter_mut().enumerate() {
                for (joint, x) in by_deflections.iter_mut().enumerate() {
                    *x = sum[(t, joint)];
                }
                self.physics
                    .pull_deflections(&moved.at[t], &by_deflections, by);
            }
        }
        let mut sum = Mat::zeros(self.waves[0].ncols(), n);
        for (order, waves) in self.waves.iter().enumerate() {
            let derivatives = Mat::from_fn(samples, n, |t, j| by.at[t].link[order][j]);
            sum += waves.transpose() * derivatives;
        }
        (0..n)
            .map(|joint| (0..sum.nrows()).map(|i| sum[(i, joint)]).collect())
            .collect()
    }
}

/// Returns the derivatives of the trigonometric polynomial through periodic samples.
fn derivatives(rate: f64, samples: usize) -> [Mat<f64>; 2] {
    let most = (samples - 1) / 2;
    [1, 2].map(|order| {
        let kernel: Vec<f64> = (0..samples)
            .map(|d| {
                let sum: f64 = (1..=most)
                    .map(|k| {
                        let angle = TAU * (k * d % samples) as f64 / samples as f64;
                        let rate = rate * k as f64;
                        if order == 1 {
                            -rate * angle.sin()
                        } else {
                            -rate * rate * angle.cos()
                        }
                    })
                    .sum();
                2.0 * sum / samples as f64
            })
            .collect();
        Mat::from_fn(samples, samples, |t, s| kernel[(t + samples - s) % samples])
    })
}
