//! The feedforward of a controller as operations, and its comparison with the library.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_core::controller::{Compensation, Feedforward, FeedforwardScratch};
use sprung_core::links::{LengthError, Step};
use sprung_core::robot::Values;
use sprung_core::scalar::{Jet, Scalar};

use super::graph::{Graph, Operand, Symbol, values};
use super::trace::{Array, DPHI, ELEMENTS, PHI, Source, TAU, Traced};
use crate::reload::worst;

/// Number of random motions.
const MOTIONS: usize = 1000;

/// Ranges of random motions and of their derivatives.
const RANGES: [f64; 5] = [std::f64::consts::PI, 2.0, 10.0, 50.0, 250.0];

const INPUTS: [&str; 5] = [
    "q_d_rad",
    "dq_d_rad_per_s",
    "ddq_d_rad_per_s2",
    "dddq_d_rad_per_s3",
    "ddddq_d_rad_per_s4",
];

const OUTPUTS: [&str; 3] = [TAU, PHI, DPHI];

/// Motions of the self-test.
const TESTED: usize = 10;

/// A desired motion of the self-test.
#[derive(Clone, Debug)]
pub(super) struct DesiredMotion {
    /// Positions, then their derivatives, \[5n\], and elements of presliding friction.
    desired: Vec<f64>,
    /// Torques, positions and velocities of the motors.
    nominal: [Vec<f64>; 3],
}

impl DesiredMotion {
    /// Returns all arrays, in the order of the self-tests.
    pub(super) fn all(&self) -> [&[f64]; 4] {
        let [tau, phi, dphi] = &self.nominal;
        [&self.desired, tau, phi, dphi]
    }
}

impl Source<'_> {
    /// Returns motor torques, positions and velocities of the rotors, each \[n\].
    ///
    /// - `elements`: of presliding friction along the desired motion; empty if all slide.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if arrays do not fit the robot.
    pub(super) fn nominal<S: Scalar>(
        &self,
        compensation_speed: Option<f64>,
        q_d: &[[S; 5]],
        elements: &[S],
    ) -> Result<[Vec<S>; 3], LengthError> {
        let n = self.robot.joints();
        let [mut tau, mut phi, mut dphi] = [(); 3].map(|()| vec![S::ZERO; n]);
        let mut out = Feedforward {
            tau: &mut tau,
            phi: &mut phi,
            dphi: &mut dphi,
        };
        let values = Values {
            theta: self.theta,
            bodies: self.bodies,
        };
        let mut series = [(); 4].map(|()| vec![Jet::ZERO; n]);
        let mut scratch = FeedforwardScratch {
            series: series.each_mut().map(Vec::as_mut_slice),
            steps: &mut vec![Step::default(); n],
        };
        let compensation = compensation_speed.map(|speed| Compensation { speed, elements });
        out.fill(&self.robot, &values, q_d, compensation, &mut scratch)?;
        Ok([tau, phi, dphi])
    }

    /// Returns the number of elements that the feedforward has as arguments.
    pub(super) fn elements_of_feedforward(&self, compensation_speed: Option<f64>) -> usize {
        if compensation_speed.is_some() && self.has_presliding() {
            self.array(ELEMENTS).length
        } else {
            0
        }
    }

    /// Returns the function of the feedforward.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if arrays do not fit the robot.
    pub(super) fn feedforward(
        &self,
        compensation_speed: Option<f64>,
    ) -> Result<Traced, LengthError> {
        let n = self.robot.joints();
        let graph = Graph::default();
        let q_d: Vec<[Symbol<'_>; 5]> = (0..n)
            .map(|i| std::array::from_fn(|order| graph.input(order * n + i)))
            .collect();
        let elements: Vec<Symbol<'_>> = (0..self.elements_of_feedforward(compensation_speed))
            .map(|at| graph.input(INPUTS.len() * n + at))
            .collect();
        let results = self.nominal(compensation_speed, &q_d, &elements)?.concat();
        let results: Vec<Operand> = results.into_iter().map(Symbol::operand).collect();
        let arrays = |names: &[&'static str]| -> Vec<Array> {
            names.iter().map(|name| self.array(name)).collect()
        };
        Ok(Traced {
            name: "feedforward",
            about: "Feedforward: torques of the motors, and motion of the rotors, for a desired motion of the links.",
            inputs: if elements.is_empty() {
                arrays(&INPUTS)
            } else {
                arrays(&[&INPUTS[..], &[ELEMENTS]].concat())
            },
            outputs: arrays(&OUTPUTS),
            operations: graph.needed(&results),
            results,
        })
    }

    /// Returns the largest difference of the operations from the library at random motions, relative to
    /// the largest number of an array, and the motions of the self-test.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if arrays do not fit the robot.
    pub(super) fn prove_feedforward(
        &self,
        compensation_speed: Option<f64>,
        traced: &Traced,
    ) -> Result<(f64, Vec<DesiredMotion>), LengthError> {
        let n = self.robot.joints();
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let mut difference = 0.0;
        let mut tested = Vec::new();
        for _ in 0..MOTIONS {
            let q_d: Vec<[f64; 5]> = (0..n)
                .map(|_| RANGES.map(|range| random.random_range(-range..range)))
                .collect();
            let elements: Vec<f64> = (0..self.elements_of_feedforward(compensation_speed))
                .map(|_| random.random_range(-1.0..1.0))
                .collect();
            let known = self.nominal(compensation_speed, &q_d, &elements)?;
            let inputs: Vec<f64> = (0..RANGES.len())
                .flat_map(|order| q_d.iter().map(move |d| d[order]))
                .chain(elements)
                .collect();
            let found = values(&traced.operations, &traced.results, &inputs);
            for (known, found) in known.iter().zip(found.chunks(n)) {
                worst(&mut difference, known, found);
            }
            if tested.len() < TESTED {
                tested.push(DesiredMotion {
                    desired: inputs,
                    nominal: known,
                });
            }
        }
        Ok((difference, tested))
    }
}
