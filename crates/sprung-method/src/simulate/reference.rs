//! Reference trajectories: sums of sines with their exact derivatives.

use crate::description::Reference;
use crate::model::Model;
use sprung_core::chain::JointKind;

#[derive(Clone, Copy, Debug)]
struct Term {
    joint: usize,
    amplitude: f64,
    rate: f64,
    phase: f64,
}

/// A reference trajectory of all joints.
#[derive(Clone, Debug)]
pub struct Trajectory {
    terms: Vec<Term>,
    centre: Vec<f64>,
}

impl Trajectory {
    /// Returns the described trajectory. Sines of unknown joints are skipped, because the check of
    /// the description has rejected them.
    #[must_use]
    pub fn new(reference: &Reference, model: &Model) -> Self {
        let joints = model.joints();
        let terms = reference
            .sines
            .iter()
            .filter_map(|sine| {
                let joint = joints.iter().position(|name| *name == sine.joint)?;
                Some(Term {
                    joint,
                    amplitude: match model.kind(joint) {
                        JointKind::Revolute => sine.amplitude_deg.to_radians(),
                        JointKind::Prismatic => sine.amplitude_m,
                    },
                    rate: std::f64::consts::TAU * sine.frequency_hz,
                    phase: sine.phase_deg.to_radians(),
                })
            })
            .collect();
        let centre = |joint: usize| {
            let turned = reference.centre_deg.get(joint).map(|c| c.to_radians());
            let moved = reference.centre_m.get(joint).copied();
            turned.unwrap_or_default() + moved.unwrap_or_default()
        };
        Self {
            terms,
            centre: (0..joints.len()).map(centre).collect(),
        }
    }

    /// Returns the centres of the joints' motions, \[n\], rad (m).
    #[must_use]
    pub(crate) fn centre(&self) -> &[f64] {
        &self.centre
    }

    /// Writes the position of every joint and its first four derivatives at `time` in s; rad (m),
    /// rad/s (m/s), …, \[n\]\[5\].
    pub fn at(&self, time: f64, all: &mut [[f64; 5]]) {
        for (own, centre) in all.iter_mut().zip(&self.centre) {
            *own = [*centre, 0.0, 0.0, 0.0, 0.0];
        }
        for term in &self.terms {
            let (sin, cos) = (term.rate * time + term.phase).sin_cos();
            let mut scale = term.amplitude;
            for (value, wave) in all[term.joint].iter_mut().zip([sin, cos, -sin, -cos, sin]) {
                *value += scale * wave;
                scale *= term.rate;
            }
        }
    }
}
