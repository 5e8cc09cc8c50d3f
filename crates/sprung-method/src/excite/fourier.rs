//! Finite Fourier series that begin and end at rest.

use std::f64::consts::TAU;

use crate::description::{Reference, Sine};
use crate::model::Model;
use sprung_core::chain::JointKind;

/// Largest multiple of the lowest frequency; more would need more memory than a design has.
pub(super) const MOST_MULTIPLE: usize = 1000;

/// Highest time derivative that a series gives.
pub(super) const ORDERS: usize = 5;

/// The motion of all joints: for each a centre, and sines and cosines of multiples of one frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Lowest angular frequency, rad/s.
    pub rate: f64,
    /// Multiples of it.
    pub harmonics: Vec<usize>,
    /// Centre, then sine and cosine of each multiple, rad (m), per joint.
    pub joints: Vec<Vec<f64>>,
}

impl Series {
    /// Writes the position of a joint and its first four derivatives, rad (m), rad/s (m/s), ….
    #[must_use]
    pub fn at(&self, joint: usize, time: f64) -> [f64; ORDERS] {
        let coefficients = &self.joints[joint];
        let mut all = [0.0; ORDERS];
        all[0] = coefficients[0];
        for (pair, &multiple) in coefficients[1..].chunks(2).zip(&self.harmonics) {
            let rate = self.rate * multiple as f64;
            let (sin, cos) = (rate * time).sin_cos();
            let mut waves = [[sin, cos], [cos, -sin]];
            let mut scale = 1.0;
            for (order, value) in all.iter_mut().enumerate() {
                let [of_sine, of_cosine] = waves[order % 2];
                *value += scale * (pair[0] * of_sine + pair[1] * of_cosine);
                scale *= rate;
                if order % 2 == 1 {
                    for wave in &mut waves {
                        *wave = wave.map(|x| -x);
                    }
                }
            }
        }
        all
    }

    /// Returns the series of the reference of a controller.
    ///
    /// # Errors
    ///
    /// A sentence if the reference has no sines, or frequencies that are no multiples of one frequency.
    pub fn of_reference(reference: &Reference, model: &Model) -> Result<Self, String> {
        let lowest = (reference.sines.iter())
            .map(|sine| sine.frequency_hz)
            .min_by(f64::total_cmp)
            .filter(|frequency| *frequency > 0.0 && frequency.is_finite())
            .ok_or("[controller.reference] has no sines with frequencies above zero")?;
        let multiple = |base: f64, sine: &Sine| (sine.frequency_hz / base).round() as usize;
        let fits = |base: f64| {
            (reference.sines.iter()).all(|sine| {
                let multiple = multiple(base, sine);
                let off = sine.frequency_hz / base - multiple as f64;
                multiple <= MOST_MULTIPLE && off.abs() < 1e-8 * multiple as f64
            })
        };
        let base = (1..=MOST_MULTIPLE)
            .map(|part| lowest / part as f64)
            .find(|base| fits(*base))
            .ok_or_else(|| {
                format!(
                    "the frequencies of [controller.reference] are no multiples, up to {MOST_MULTIPLE}, of one frequency, \
                     so the motion has no period"
                )
            })?;
        let mut harmonics: Vec<usize> = (reference.sines.iter())
            .map(|sine| multiple(base, sine))
            .collect();
        harmonics.sort_unstable();
        harmonics.dedup();
        let names = model.joints();
        let mut joints: Vec<Vec<f64>> = (0..names.len())
            .map(|joint| {
                let centre = match model.kind(joint) {
                    JointKind::Revolute => reference
                        .centre_deg
                        .get(joint)
                        .map(|degrees| degrees.to_radians()),
                    JointKind::Prismatic => reference.centre_m.get(joint).copied(),
                };
                let mut coefficients = vec![0.0; 1 + 2 * harmonics.len()];
                coefficients[0] = centre.unwrap_or(0.0);
                coefficients
            })
            .collect();
        for sine in &reference.sines {
            // The check of the description refuses other names.
            let Some(joint) = names.iter().position(|name| *name == sine.joint) else {
                continue;
            };
            let amplitude = match model.kind(joint) {
                JointKind::Revolute => sine.amplitude_deg.to_radians(),
                JointKind::Prismatic => sine.amplitude_m,
            };
            let multiple = multiple(base, sine);
            let place = harmonics.partition_point(|harmonic| *harmonic < multiple);
            let (sin, cos) = sine.phase_deg.to_radians().sin_cos();
            joints[joint][1 + 2 * place] += amplitude * cos;
            joints[joint][2 + 2 * place] += amplitude * sin;
        }
        Ok(Self {
            rate: TAU * base,
            harmonics,
            joints,
        })
    }

    /// Returns the largest possible absolute value of a derivative of a joint's motion about its centre.
    #[must_use]
    pub fn bound(&self, joint: usize, order: i32) -> f64 {
        let pairs = self.joints[joint][1..].chunks(2).zip(&self.harmonics);
        pairs
            .map(|(pair, &multiple)| {
                pair[0].hypot(pair[1]) * (self.rate * multiple as f64).powi(order)
            })
            .sum()
    }

    /// Returns the period of the series, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        TAU / self.rate
    }

    /// Returns the series with all amplitudes times a factor. The motion still begins at the same position.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut series = self.clone();
        for joint in &mut series.joints {
            let cosines: f64 = joint[1..].iter().skip(1).step_by(2).sum();
            for amplitude in &mut joint[1..] {
                *amplitude *= factor;
            }
            joint[0] += (1.0 - factor) * cosines;
        }
        series
    }

    /// Returns the series as the reference of a controller.
    #[must_use]
    pub fn reference(&self, model: &Model) -> Reference {
        let mut sines = Vec::new();
        for (joint, coefficients) in self.joints.iter().enumerate() {
            let turns = model.kind(joint) == JointKind::Revolute;
            for (pair, &multiple) in coefficients[1..].chunks(2).zip(&self.harmonics) {
                let amplitude = pair[0].hypot(pair[1]);
                if amplitude == 0.0 {
                    continue;
                }
                sines.push(Sine {
                    joint: model.joints()[joint].clone(),
                    amplitude_deg: if turns { amplitude.to_degrees() } else { 0.0 },
                    amplitude_m: if turns { 0.0 } else { amplitude },
                    frequency_hz: multiple as f64 * self.rate / TAU,
                    phase_deg: pair[1].atan2(pair[0]).to_degrees(),
                });
            }
        }
        let turns = |joint: usize| model.kind(joint) == JointKind::Revolute;
        let joints = self.joints.iter().enumerate();
        Reference {
            sines,
            centre_deg: (joints.clone())
                .map(|(joint, coefficients)| {
                    if turns(joint) {
                        coefficients[0].to_degrees()
                    } else {
                        0.0
                    }
                })
                .collect(),
            centre_m: joints
                .map(|(joint, coefficients)| if turns(joint) { 0.0 } else { coefficients[0] })
                .collect(),
        }
    }
}

/// The series of one joint as linear functions of free numbers: those whose velocity and acceleration are zero at
/// the beginning of a period.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    /// Coefficients (centre, sines and cosines) of each free number.
    functions: Vec<Vec<f64>>,
}

impl Basis {
    /// - `sizes`: typical amplitude of each multiple, rad (m); the first free number is the centre, in units of
    ///   `centre`.
    #[must_use]
    pub(super) fn new(harmonics: &[usize], sizes: &[f64], centre: f64) -> Self {
        let count = 1 + 2 * harmonics.len();
        let mut functions = vec![vec![0.0; count]];
        functions[0][0] = centre;
        for (side, power) in [(0, 1), (1, 2)] {
            let weights: Vec<f64> = (harmonics.iter().zip(sizes))
                .map(|(&multiple, size)| size * (multiple as f64).powi(power))
                .collect();
            for free in complement(&weights) {
                let mut function = vec![0.0; count];
                for (k, (x, size)) in free.iter().zip(sizes).enumerate() {
                    function[1 + 2 * k + side] = x * size;
                }
                functions.push(function);
            }
        }
        Self { functions }
    }

    /// Returns the number of free numbers.
    #[must_use]
    pub(super) fn count(&self) -> usize {
        self.functions.len()
    }

    /// Returns the coefficients of free numbers.
    #[must_use]
    pub(super) fn coefficients(&self, free: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.functions[0].len()];
        for (x, function) in free.iter().zip(&self.functions) {
            for (sum, value) in sum.iter_mut().zip(function) {
                *sum += x * value;
            }
        }
        sum
    }

    /// Returns the derivatives by the free numbers from those by the coefficients.
    #[must_use]
    pub(super) fn pull(&self, by_coefficients: &[f64]) -> Vec<f64> {
        let functions = self.functions.iter();
        functions
            .map(|function| {
                function
                    .iter()
                    .zip(by_coefficients)
                    .map(|(f, g)| f * g)
                    .sum()
            })
            .collect()
    }

    /// Returns the free numbers nearest to given coefficients.
    #[must_use]
    pub(super) fn free(&self, coefficients: &[f64]) -> Vec<f64> {
        let count = self.count();
        let mut normal = vec![0.0; count * count];
        let right = self.pull(coefficients);
        for (i, a) in self.functions.iter().enumerate() {
            for (j, b) in self.functions.iter().enumerate().take(i + 1) {
                normal[i * count + j] = a.iter().zip(b).map(|(a, b)| a * b).sum();
            }
        }
        let mut free = right;
        if sprung_core::linear::factor(&mut normal, count) {
            sprung_core::linear::solve(&normal, &mut free);
        }
        free
    }
}

/// Returns an orthonormal basis of the vectors perpendicular to `w`, by the reflection that turns `w` into the first
/// axis.
fn complement(w: &[f64]) -> Vec<Vec<f64>> {
    let length = w.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut v = w.to_vec();
    let Some(first) = v.first_mut() else {
        return Vec::new();
    };
    *first += length.copysign(*first);
    let square: f64 = v.iter().map(|x| x * x).sum();
    (1..w.len())
        .map(|axis| {
            let factor = if square > 0.0 {
                2.0 * v[axis] / square
            } else {
                0.0
            };
            let mut column: Vec<f64> = v.iter().map(|x| -factor * x).collect();
            column[axis] += 1.0;
            column
        })
        .collect()
}
