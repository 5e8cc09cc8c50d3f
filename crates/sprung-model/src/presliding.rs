//! Elements of presliding friction of a robot along a motion.

use sprung_core::presliding::{ELEMENTS, moved};

use super::Model;

/// Elements of presliding friction of all motors. They are zero at the beginning of a motion.
#[derive(Clone, Debug, Default)]
pub struct Presliding {
    motors: Vec<Motor>,
    // [n × ELEMENTS]; empty if no motor has this friction.
    elements: Vec<f64>,
    has_begun: bool,
}

/// A motor with presliding friction.
#[derive(Clone, Debug)]
struct Motor {
    joint: usize,
    /// Of the widest element, rad (m).
    width: f64,
    /// Turns of the motor before the coupled transmission per turn of each motor behind it, \[n\].
    ratios: Vec<f64>,
    /// At the last sample, rad (m).
    position: f64,
}

impl Motor {
    fn at(&self, phi: &[f64]) -> f64 {
        (self.ratios.iter().zip(phi))
            .map(|(ratio, phi)| ratio * phi)
            .sum()
    }
}

impl Model {
    /// Returns the elements of presliding friction at the beginning of a motion.
    #[must_use]
    pub fn presliding(&self) -> Presliding {
        let n = self.joint_count();
        let motors: Vec<Motor> = (0..n)
            .filter_map(|joint| {
                Some(Motor {
                    joint,
                    width: self.presliding_width(joint)?,
                    ratios: (0..n).map(|of| self.robot().ratio(joint, of)).collect(),
                    position: 0.0,
                })
            })
            .collect();
        Presliding {
            elements: vec![0.0; if motors.is_empty() { 0 } else { n * ELEMENTS }],
            motors,
            has_begun: false,
        }
    }
}

impl Presliding {
    /// Returns whether no motor has this friction.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.motors.is_empty()
    }

    /// Begins another motion.
    pub fn restart(&mut self) {
        self.has_begun = false;
        self.elements.fill(0.0);
    }

    /// Moves on to the next sample and returns its elements, \[n × [`ELEMENTS`]\]; empty if no motor has this friction.
    ///
    /// - `phi`: positions of the motors behind gear and coupling, \[n\], rad (m).
    pub fn advance(&mut self, phi: &[f64]) -> &[f64] {
        for motor in &mut self.motors {
            let position = motor.at(phi);
            if self.has_begun {
                slide(&mut self.elements, motor, position - motor.position);
            }
            motor.position = position;
        }
        self.has_begun = true;
        &self.elements
    }

    /// Moves on by a travel of each motor.
    ///
    /// - `travel`: of the motors before the coupled transmission, \[n\], rad (m).
    pub fn turn(&mut self, travel: &[f64]) -> &[f64] {
        for motor in &self.motors {
            slide(&mut self.elements, motor, travel[motor.joint]);
        }
        &self.elements
    }

    /// Writes the elements at positions between the last sample and the next, without moving on.
    ///
    /// - `phi`: as of [`Self::advance`]; `out`: \[n × [`ELEMENTS`]\], or empty.
    pub fn write_at(&self, phi: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(&self.elements);
        if self.has_begun {
            for motor in &self.motors {
                slide(out, motor, motor.at(phi) - motor.position);
            }
        }
    }
}

fn slide(elements: &mut [f64], motor: &Motor, travel: f64) {
    let (of_joints, _) = elements.as_chunks_mut::<ELEMENTS>();
    if let Some(of_joint) = of_joints.get_mut(motor.joint) {
        *of_joint = moved(of_joint, travel, motor.width);
    }
}
