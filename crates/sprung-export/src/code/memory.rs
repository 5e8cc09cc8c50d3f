//! The memory of presliding friction and of the hysteresis of springs in the code, and a motion with memory for the self-test.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_core::drives::State;
use sprung_core::links::LengthError;
use sprung_core::presliding::ALL_ELEMENTS;
use sprung_core::robot::Values;

use super::emit::Language;
use super::graph::values;
use super::trace::{Source, Traced};
use crate::model::{ElementSet, Scratch};
use crate::reload::worst;

/// Number of random states.
const STATES: usize = 1000;

/// Samples of the motion of the self-test.
const SAMPLES: usize = 12;

/// Largest positions, velocities and accelerations by chance: of the links, then of the motors.
const RANGES: [f64; 6] = [1.0, 2.0, 10.0, 1.0, 2.0, 10.0];

/// Largest step of the motion of the self-test over the width of the widest element: some elements slide and some do not.
const STEP: f64 = 0.1;

/// A sample of a motion: positions, velocities and accelerations of links and motors, and the torques of both.
type Sample = [Vec<f64>; 8];

/// Memory as code.
pub(super) struct Memory {
    sets: Vec<ElementSet>,
    /// Whether each joint has a spring.
    is_flexible: Vec<bool>,
    samples: Vec<Sample>,
}

impl Memory {
    /// Returns the memory of a robot; `None` if it needs none, or if a coupled transmission moves its elements.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if the parameters do not fit the robot.
    pub(super) fn new(source: &Source<'_>) -> Result<Option<Self>, LengthError> {
        if !source.has_memory() {
            return Ok(None);
        }
        let mut elements = source.model.elements();
        let sets: Vec<ElementSet> = elements.sets().collect();
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let mut motion = by_chance(source, &mut random);
        let mut samples = Vec::new();
        for _ in 0..SAMPLES {
            let again = by_chance(source, &mut random);
            for order in [1, 2, 4, 5] {
                motion[order].clone_from(&again[order]);
            }
            let mut reaches: Vec<f64> = vec![1e-6; source.robot.joints()];
            for set in &sets {
                let widest = set.widths.into_iter().fold(0.0, f64::max);
                reaches[set.joint] = reaches[set.joint].max(STEP * widest);
            }
            for order in [0, 3] {
                for (position, reach) in motion[order].iter_mut().zip(&reaches) {
                    *position += random.random_range(-reach..*reach);
                }
            }
            rigid(source, &mut motion);
            let now = elements.advance(&motion[0], &motion[3]);
            let [links, motors] = torques(source, &motion, now)?;
            let [q, dq, ddq, phi, dphi, ddphi] = motion.clone();
            samples.push([q, dq, ddq, phi, dphi, ddphi, links, motors]);
        }
        Ok(Some(Self {
            sets,
            is_flexible: source
                .robot
                .motor_rows
                .iter()
                .map(Option::is_some)
                .collect(),
            samples,
        }))
    }

    /// Returns a template of the memory or of its self-test with all that it contains.
    pub(super) fn filled(&self, language: &Language, template: &str) -> String {
        let moves: String = (self.sets.iter())
            .map(|set| {
                let position = match (set.is_of_spring, self.is_flexible[set.joint]) {
                    (true, _) => format!("phi_rad[{0}] - q_rad[{0}]", set.joint),
                    (false, true) => format!("phi_rad[{}]", set.joint),
                    (false, false) => format!("q_rad[{}]", set.joint),
                };
                (language.move_elements)(set.first, &position, &language.constants(&set.widths))
            })
            .collect();
        let samples = (self.samples.iter()).map(|sample| sample.each_ref().map(Vec::as_slice));
        template
            .replace("%MOVES%", &moves)
            .replace("%COUNT%", &self.samples.len().to_string())
            .replace("%SAMPLES%", &language.elements(samples))
    }
}

/// Returns the largest difference of inverse dynamics with memory from the library at random states, relative to the largest torque.
///
/// # Errors
///
/// [`LengthError`] if arrays do not fit the robot.
pub(super) fn prove(source: &Source<'_>, traced: &Traced) -> Result<f64, LengthError> {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut difference = 0.0;
    for _ in 0..STATES {
        let motion = by_chance(source, &mut random);
        let elements: Vec<f64> = (0..source.robot.joints() * ALL_ELEMENTS)
            .map(|_| random.random_range(-1.0..1.0))
            .collect();
        let known = torques(source, &motion, &elements)?.concat();
        let inputs = [motion.concat(), elements].concat();
        let found = values(&traced.operations, &traced.results, &inputs);
        worst(&mut difference, &known, &found);
    }
    Ok(difference)
}

/// Returns positions, velocities and accelerations of links, then of motors.
fn by_chance(source: &Source<'_>, random: &mut ChaCha8Rng) -> [Vec<f64>; 6] {
    let mut motion = RANGES.map(|range| {
        (0..source.robot.joints())
            .map(|_| random.random_range(-range..range))
            .collect()
    });
    rigid(source, &mut motion);
    motion
}

/// Moves the motors of rigid joints with their links.
fn rigid(source: &Source<'_>, motion: &mut [Vec<f64>; 6]) {
    for joint in (0..source.robot.joints()).filter(|&i| source.robot.motor_rows[i].is_none()) {
        for order in 0..3 {
            motion[3 + order][joint] = motion[order][joint];
        }
    }
}

/// Returns the torques of the library on the links from outside, and of the motors.
fn torques(
    source: &Source<'_>,
    [q, dq, ddq, phi, dphi, ddphi]: &[Vec<f64>; 6],
    elements: &[f64],
) -> Result<[Vec<f64>; 2], LengthError> {
    let (robot, n) = (&source.robot, source.robot.joints());
    let state = State {
        q,
        dq,
        phi,
        dphi,
        excess: &[],
        elements,
    };
    let mut acceleration = vec![0.0; robot.rows()];
    for joint in 0..n {
        acceleration[joint] = ddq[joint];
        acceleration[robot.motor_coordinate(joint)] = ddphi[joint];
    }
    let values = Values {
        theta: source.theta,
        bodies: source.bodies,
    };
    let mut required = vec![0.0; robot.rows()];
    let mut scratch = Scratch::new(n);
    robot.required_torques(
        &values,
        &state,
        &acceleration,
        &mut scratch.workspace(),
        &mut required,
    )?;
    let of_link = |joint: usize| robot.motor_rows[joint].map_or(0.0, |_| required[joint]);
    Ok([
        (0..n).map(of_link).collect(),
        (0..n)
            .map(|joint| required[robot.motor_coordinate(joint)])
            .collect(),
    ])
}
