//! The simulated closed loop as a function of its unknowns.

use super::levenberg::Problem;
use super::record::{MIN_NOISE_RAD, Position, Record};
use super::simulation_counter::SimulationCounter;
use crate::description::Controller;
use crate::log::Signal;
use crate::model::{Model, Theta};
use crate::named::Named;
use crate::preprocess::RawBlock;
use crate::simulate::ClosedLoop;

/// Tolerance of the integration, rad and rad/s, relative to the smallest noise of a position, and
/// its limits. An encoder of 2e5 counts per turn gives a tolerance of 1e-8. With it the integration
/// error is 2e-10 rad over the 10 s experiment, a thousandth of the effect of a difference step of
/// half a standard error.
const TOLERANCE_SHARE_OF_NOISE: f64 = 1e-3;

/// Largest tolerance: an encoder of 2^22 counts has this resolution.
const MAX_TOLERANCE_RAD: f64 = 1e-6;

/// Maximum number of integration steps: this number per sample plus this number per millisecond. It
/// is ten times the number for a robot, so stiffer parameters are impossible.
const MAX_STEPS_PER_MS: f64 = 15.0;

/// First difference step of a parameter, relative to its value or its linear standard error.
const FIRST_DIFFERENCE_SHARE: f64 = 1e-4;

/// Largest difference step, relative to the same scale.
const LARGEST_DIFFERENCE_SHARE: f64 = 1e-2;

/// A closed loop with unknown parameters and unknown offsets of its sensors.
pub(super) struct Loop<'a> {
    model: &'a Model,
    controller: &'a Controller,
    record: &'a Record,
    tolerance: f64,
    base: Theta,
    // Index in theta of each unknown parameter. The offsets of the positions follow these unknowns.
    free: Vec<usize>,
}

impl<'a> Loop<'a> {
    /// - `base`: start of the search, \[p\].
    /// - `determined`: whether the log determines each parameter, \[p\]. Fixed parameters are never
    ///   unknowns.
    pub(super) fn new(
        model: &'a Model,
        controller: &'a Controller,
        record: &'a Record,
        base: Theta,
        determined: &[bool],
    ) -> Self {
        let free = (model.parameters().iter().enumerate())
            .filter(|(i, parameter)| parameter.fixed.is_none() && determined[*i])
            .map(|(i, _)| i)
            .collect();
        let noises = record.positions.iter().map(|position| position.noise);
        let tolerance = TOLERANCE_SHARE_OF_NOISE * noises.fold(f64::INFINITY, f64::min);
        Self {
            model,
            controller,
            record,
            tolerance: tolerance.clamp(MIN_NOISE_RAD, MAX_TOLERANCE_RAD),
            base,
            free,
        }
    }

    /// Returns the least-squares problem.
    ///
    /// - `errors`: standard errors of linear least squares, \[p\].
    /// - `counter`: counts the simulations. After a stop it prevents further simulations.
    pub(super) fn problem<'b>(
        &'b self,
        errors: &[f64],
        counter: &'b SimulationCounter<'_>,
    ) -> Problem<'b> {
        let parameter_scales = self.free.iter().map(|&i| {
            let error = Some(errors[i]).filter(|e| e.is_finite()).unwrap_or(0.0);
            self.base[i].abs().max(error).max(f64::MIN_POSITIVE.sqrt())
        });
        let offsets = || self.record.positions.iter().map(|p| p.noise);
        let scale: Vec<f64> = parameter_scales.chain(offsets()).collect();
        let parameters = self.free.len();
        Problem {
            residuals: Box::new(|x| {
                counter.start_simulation().ok()?;
                self.residuals(x)
            }),
            start: (self.free.iter().map(|&i| self.base[i]))
                .chain(offsets().map(|_| 0.0))
                .collect(),
            first: (scale.iter().enumerate())
                .map(|(i, s)| {
                    if i < parameters {
                        FIRST_DIFFERENCE_SHARE * s
                    } else {
                        0.1 * s
                    }
                })
                .collect(),
            largest: (scale.iter().enumerate())
                .map(|(i, s)| {
                    if i < parameters {
                        LARGEST_DIFFERENCE_SHARE * s
                    } else {
                        *s
                    }
                })
                .collect(),
            prior: (self.free.iter().map(|_| 0.0))
                .chain(offsets().map(f64::recip))
                .collect(),
        }
    }

    /// Returns the parameter vector with the values of the unknowns, \[p\].
    pub(super) fn theta(&self, x: &[f64]) -> Theta {
        let mut theta = self.base.clone();
        for (&i, value) in self.free.iter().zip(x) {
            theta[i] = *value;
        }
        theta
    }

    /// Writes values of the unknown parameters into a list of all parameters.
    pub(super) fn spread<T: Clone>(
        &self,
        of: &[Option<f64>],
        value: impl Fn(Option<f64>) -> T,
        others: &[T],
    ) -> Vec<T> {
        let mut all = others.to_vec();
        for (&i, entry) in self.free.iter().zip(of) {
            all[i] = value(*entry);
        }
        all
    }

    /// Returns the name of an unknown.
    pub(super) fn name(&self, unknown: usize) -> String {
        if let Some(&i) = self.free.get(unknown) {
            return self.model.parameters()[i].name.clone();
        }
        let position = self.record.positions.get(unknown - self.free.len());
        let column = position.map_or("", |position| &position.column);
        format!("the offset of \"{column}\"")
    }

    /// Returns the offset of each position, rad (m), by column.
    pub(super) fn offsets(&self, x: &[f64]) -> Named {
        (self.record.positions.iter().zip(&x[self.free.len()..]))
            .map(|(position, value)| (position.column.clone(), *value))
            .collect()
    }

    /// Returns the root mean square of the scaled residuals of each position, by column.
    pub(super) fn rms(&self, residuals: &[f64]) -> Named {
        let columns = residuals.chunks(self.record.len());
        (self.record.positions.iter().zip(columns))
            .map(|(position, r)| {
                let squares: f64 = r.iter().map(|r| r * r).sum();
                (position.column.clone(), (squares / r.len() as f64).sqrt())
            })
            .collect()
    }

    /// Returns measured minus simulated positions over their noise, position after position.
    /// Returns `None` if the parameters are not those of a robot, the loop runs away or it is too
    /// stiff.
    fn residuals(&self, x: &[f64]) -> Option<Vec<f64>> {
        let theta = self.theta(x);
        let Self { model, record, .. } = self;
        model.check_stiffness(&theta).ok()?;
        let (q, phi) = record.start();
        let start = Some((&q[..], &phi[..]));
        let mut plant = ClosedLoop::new(model, &theta, self.controller, record.period, start)
            .ok()?
            .with_tolerance(self.tolerance);
        let offsets = &x[self.free.len()..];
        let samples = record.len();
        let per_sample = MAX_STEPS_PER_MS * (1.0 + 1e3 * record.period);
        let budget = (per_sample * samples as f64) as u64;
        let mut residuals = vec![0.0; samples * record.positions.len()];
        for k in 0..samples {
            let state = plant.state();
            let (mut q, mut phi) = (state.q, state.phi);
            self.measure(offsets, &mut q, &mut phi);
            for (c, position) in record.positions.iter().enumerate() {
                let error = read(position, &record.samples, k) - shown(position, &q, &phi);
                residuals[c * samples + k] = error / position.noise;
            }
            if k + 1 < samples {
                // The controller uses the sensors' readings with offset but without quantisation.
                let tau = plant.command(record.samples.time[k], &q, &phi);
                plant.advance(&tau).ok()?;
                if plant.steps() > budget {
                    return None;
                }
            }
        }
        residuals.iter().all(|r| r.is_finite()).then_some(residuals)
    }

    /// Adds the offsets of the sensors to true positions.
    fn measure(&self, offsets: &[f64], q: &mut [f64], phi: &mut [f64]) {
        for (position, offset) in self.record.positions.iter().zip(offsets) {
            let joint = position.joint;
            let signal = position.quantity.signal();
            if signal == Signal::Motor {
                phi[joint] += offset;
            }
            if signal == Signal::Link || !self.model.is_flexible(joint) {
                q[joint] += offset;
            }
        }
    }
}

/// Returns the reading of an exact sensor, rad (m).
fn shown(position: &Position, q: &[f64], phi: &[f64]) -> f64 {
    let joint = position.joint;
    (position.quantity).shown([q[joint], phi[joint]], [0.0; 2], [0.0; 3], |_| 0.0)
}

/// Returns the logged reading of a sample, rad (m).
fn read(position: &Position, samples: &RawBlock, k: usize) -> f64 {
    let joint = position.joint;
    let positions = [samples.q[joint][k], samples.phi[joint][k]];
    (position.quantity).shown(positions, [0.0; 2], [0.0; 3], |_| 0.0)
}
