//! Reference trajectories: sums of sines with exact derivatives.

use crate::description::Reference;
use crate::model::JOINT_COUNT;

#[derive(Clone, Copy, Debug)]
struct Term {
    joint: usize,
    amplitude: f64,
    rate: f64,
    phase: f64,
}

/// A reference for every joint.
#[derive(Clone, Debug)]
pub struct Trajectory {
    terms: Vec<Term>,
}

impl Trajectory {
    /// Returns the trajectory that a file describes.
    ///
    /// - `joints`: names of the joints; sines of other joints are passed over,
    ///   the description has refused them.
    #[must_use]
    pub fn new(reference: &Reference, joints: &[String]) -> Self {
        let terms = reference
            .sines
            .iter()
            .filter_map(|sine| {
                Some(Term {
                    joint: joints.iter().position(|name| *name == sine.joint)?,
                    amplitude: sine.amplitude_deg.to_radians(),
                    rate: std::f64::consts::TAU * sine.frequency_hz,
                    phase: sine.phase_deg.to_radians(),
                })
            })
            .collect();
        Self { terms }
    }

    /// Returns the position of every joint and its derivatives up to the
    /// fourth, at `time` in s; rad, rad/s, ….
    #[must_use]
    pub fn at(&self, time: f64) -> [[f64; 5]; JOINT_COUNT] {
        let mut all = [[0.0; 5]; JOINT_COUNT];
        for term in &self.terms {
            let (sin, cos) = (term.rate * time + term.phase).sin_cos();
            let mut scale = term.amplitude;
            for (value, wave) in all[term.joint].iter_mut().zip([sin, cos, -sin, -cos, sin]) {
                *value += scale * wave;
                scale *= term.rate;
            }
        }
        all
    }
}
