//! Reference trajectories with their exact derivatives: sums of sines, and moves from one pose to another, both through an
//! input shaper.

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

/// A rest-to-rest motion of all joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Positions at the beginning and at the end, \[n\] each, rad (m).
    pub ends: [Vec<f64>; 2],
    /// Time at which it begins, s.
    pub begin: f64,
    /// Its length, s; 0 for a step.
    pub duration: f64,
}

/// Coefficients of the polynomial of degree nine, from the fifth power: its first four derivatives are zero at both ends.
const REST_TO_REST: [f64; 5] = [126.0, -420.0, 540.0, -315.0, 70.0];

impl Move {
    /// Returns the part of the way at a time and its first four derivatives.
    fn part(&self, time: f64) -> [f64; 5] {
        let after = time - self.begin;
        if after < 0.0 {
            return [0.0; 5];
        }
        if after >= self.duration {
            return [1.0, 0.0, 0.0, 0.0, 0.0];
        }
        let x = after / self.duration;
        let mut part = [0.0; 5];
        let mut rate = 1.0;
        for (order, part) in part.iter_mut().enumerate() {
            for (k, factor) in REST_TO_REST.iter().enumerate() {
                let falling: f64 = (0..order).map(|step| (5 + k - step) as f64).product();
                *part += factor * falling * x.powi((5 + k - order) as i32);
            }
            *part *= rate;
            rate /= self.duration;
        }
        part
    }
}

/// A reference trajectory of all joints.
#[derive(Clone, Debug)]
pub struct Trajectory {
    terms: Vec<Term>,
    centre: Vec<f64>,
    to: Option<Move>,
    /// Times and parts of the impulses of a shaper; empty without one.
    shaper: Vec<[f64; 2]>,
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
            to: None,
            shaper: Vec::new(),
        }
    }

    /// Returns a move.
    #[must_use]
    pub fn of_move(to: Move) -> Self {
        Self {
            terms: Vec::new(),
            centre: to.ends[0].clone(),
            to: Some(to),
            shaper: Vec::new(),
        }
    }

    /// Returns the trajectory after an input shaper.
    ///
    /// - `shaper`: times, s, and parts of its impulses; before time zero the trajectory rests at its start.
    #[must_use]
    pub fn shaped(self, shaper: Vec<[f64; 2]>) -> Self {
        Self { shaper, ..self }
    }

    /// Returns the positions at which a motion starts, \[n\], rad (m): those at time zero if no joint has a velocity or an
    /// acceleration then, or else the centres.
    #[must_use]
    pub(crate) fn start(&self) -> Vec<f64> {
        if let Some(to) = &self.to {
            return to.ends[0].clone();
        }
        let mut first = vec![[0.0; 5]; self.centre.len()];
        self.unshaped(0.0, &mut first);
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
            first.iter().map(|state| state[0]).collect()
        } else {
            self.centre.clone()
        }
    }

    /// Writes the position of every joint and its first four derivatives at `time` in s; rad (m),
    /// rad/s (m/s), …, \[n\]\[5\].
    pub fn at(&self, time: f64, all: &mut [[f64; 5]]) {
        if self.shaper.is_empty() {
            return self.unshaped(time, all);
        }
        let start = self.start();
        let mut states = vec![[0.0; 5]; all.len()];
        all.fill([0.0; 5]);
        for [delay, part] in &self.shaper {
            if time < *delay {
                for (state, start) in states.iter_mut().zip(&start) {
                    *state = [*start, 0.0, 0.0, 0.0, 0.0];
                }
            } else {
                self.unshaped(time - delay, &mut states);
            }
            for (sum, state) in all.iter_mut().zip(&states) {
                for (sum, value) in sum.iter_mut().zip(state) {
                    *sum += part * value;
                }
            }
        }
    }

    fn unshaped(&self, time: f64, all: &mut [[f64; 5]]) {
        for (state, centre) in all.iter_mut().zip(&self.centre) {
            *state = [*centre, 0.0, 0.0, 0.0, 0.0];
        }
        if let Some(to) = &self.to {
            let part = to.part(time);
            let ways = to.ends[0].iter().zip(&to.ends[1]);
            for (state, (from, end)) in all.iter_mut().zip(ways) {
                for (value, part) in state.iter_mut().zip(part) {
                    *value += (end - from) * part;
                }
            }
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
