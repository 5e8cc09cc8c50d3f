//! Elements of presliding friction and of the hysteresis of springs along a motion of a robot.

use sprung_core::presliding::{ALL_ELEMENTS, ELEMENTS, SPRING_WIDTHS, WIDTHS, moved};

use super::Model;

/// Elements of presliding friction and of the hysteresis of springs of all joints. They are zero at the beginning of a motion.
#[derive(Clone, Debug, Default)]
pub struct Elements {
    sets: Vec<Set>,
    // [n × ALL_ELEMENTS]; empty if no joint has any.
    values: Vec<f64>,
    has_begun: bool,
}

/// Elements that move together.
#[derive(Clone, Debug)]
struct Set {
    /// Index of the first element among those of all joints.
    first: usize,
    joint: usize,
    is_of_spring: bool,
    /// Of the widest element, rad (m); the others as shares of it.
    width: f64,
    shares: &'static [f64; ELEMENTS],
    /// Turns of what moves them per turn of each motor and each link, \[2 × n\].
    ratios: Vec<f64>,
    /// At the last sample, rad (m).
    position: f64,
}

impl Set {
    fn at(&self, phi: &[f64], q: &[f64]) -> f64 {
        (self.ratios.iter().zip(phi.iter().chain(q)))
            .map(|(ratio, position)| ratio * position)
            .sum()
    }

    fn slide(&self, elements: &mut [f64], travel: f64) {
        let of_set = elements.get_mut(self.first..self.first + ELEMENTS);
        if let Some(of_set) = of_set.and_then(|all| <&mut [f64; ELEMENTS]>::try_from(all).ok()) {
            *of_set = moved(of_set, travel, self.width, self.shares);
        }
    }
}

impl Model {
    /// Returns the elements of presliding friction and hysteresis at the beginning of a motion.
    #[must_use]
    pub fn elements(&self) -> Elements {
        let n = self.joint_count();
        let of_motor = |joint: usize| {
            Some(Set {
                first: joint * ALL_ELEMENTS,
                joint,
                is_of_spring: false,
                width: self.presliding_width(joint)?,
                shares: &WIDTHS,
                ratios: (0..n).map(|of| self.robot().ratio(joint, of)).collect(),
                position: 0.0,
            })
        };
        let of_spring = |joint: usize| {
            let mut ratios = vec![0.0; 2 * n];
            (ratios[joint], ratios[n + joint]) = (1.0, -1.0);
            Some(Set {
                first: joint * ALL_ELEMENTS + ELEMENTS,
                joint,
                is_of_spring: true,
                width: self.hysteresis_width(joint)?,
                shares: &SPRING_WIDTHS,
                ratios,
                position: 0.0,
            })
        };
        let sets: Vec<Set> = (0..n)
            .flat_map(|joint| of_motor(joint).into_iter().chain(of_spring(joint)))
            .collect();
        Elements {
            values: vec![0.0; if sets.is_empty() { 0 } else { n * ALL_ELEMENTS }],
            sets,
            has_begun: false,
        }
    }
}

/// Elements of one joint that move together, as code needs them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementSet {
    /// Index of the first of its [`ELEMENTS`] elements among those of all joints.
    pub first: usize,
    /// Joint.
    pub joint: usize,
    /// Whether the deflection moves them; otherwise the motor does.
    pub is_of_spring: bool,
    /// Width of each element, rad (m).
    pub widths: [f64; ELEMENTS],
}

impl Elements {
    /// Returns the sets of elements.
    pub fn sets(&self) -> impl Iterator<Item = ElementSet> {
        self.sets.iter().map(|set| ElementSet {
            first: set.first,
            joint: set.joint,
            is_of_spring: set.is_of_spring,
            widths: set.shares.map(|share| share * set.width),
        })
    }

    /// Returns whether no joint has any.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// Returns the elements at the last sample, \[n × [`ALL_ELEMENTS`]\]; empty if no joint has any.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Begins another motion.
    pub fn restart(&mut self) {
        self.has_begun = false;
        self.values.fill(0.0);
    }

    /// Moves on to the next sample and returns its elements, \[n × [`ALL_ELEMENTS`]\]; empty if no joint has any.
    ///
    /// - `q`, `phi`: positions of the links and of the motors behind gear and coupling, each \[n\], rad (m).
    pub fn advance(&mut self, q: &[f64], phi: &[f64]) -> &[f64] {
        for set in &mut self.sets {
            let position = set.at(phi, q);
            if self.has_begun {
                set.slide(&mut self.values, position - set.position);
            }
            set.position = position;
        }
        self.has_begun = true;
        &self.values
    }

    /// Moves on by travels. Springs behind a coupled transmission do not move.
    ///
    /// - `links`, `motors`: of the links, and of the motors before the coupled transmission, each \[n\], rad (m).
    pub fn turn(&mut self, links: &[f64], motors: &[f64]) -> &[f64] {
        for set in &self.sets {
            let link = if set.is_of_spring {
                links[set.joint]
            } else {
                0.0
            };
            set.slide(&mut self.values, motors[set.joint] - link);
        }
        &self.values
    }

    /// Writes the elements at positions between the last sample and the next, without moving on.
    ///
    /// - `q`, `phi`: as of [`Self::advance`]; `out`: \[n × [`ALL_ELEMENTS`]\], or empty.
    pub fn write_at(&self, q: &[f64], phi: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(&self.values);
        if self.has_begun {
            for set in &self.sets {
                set.slide(out, set.at(phi, q) - set.position);
            }
        }
    }
}
