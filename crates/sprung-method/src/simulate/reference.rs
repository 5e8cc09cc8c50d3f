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

/// Part of the largest velocity or acceleration that counts as rest.
const AT_REST: f64 = 1e-6;

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

    /// Returns the positions at which a motion starts, \[n\], rad (m): those at time zero if no joint has a velocity or an
    /// acceleration then, or else the centres.
    #[must_use]
    pub(crate) fn start(&self) -> Vec<f64> {
        let mut first = vec![[0.0; 5]; self.centre.len()];
        self.at(0.0, &mut first);
        let mut most = vec![[0.0; 3]; self.centre.len()];
        for term in &self.terms {
            for (order, most) in most[term.joint].iter_mut().enumerate() {
                *most += (term.amplitude * term.rate.powi(order as i32)).abs();
            }
        }
        let rests = |(first, most): (&[f64; 5], &[f64; 3])| {
            (1..3).all(|order| first[order].abs() <= AT_REST * most[order])
        };
        if first.iter().zip(&most).all(rests) {
            first.iter().map(|own| own[0]).collect()
        } else {
            self.centre.clone()
        }
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
