//! The linear equations of links and motors at the lines of a spectrum, and their derivatives.

use faer::{Mat, c64};

use super::inverse::inverse;
use super::lines::Lines;

const ZERO: c64 = c64::new(0.0, 0.0);

/// Places of the unknowns in their vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    n: usize,
}

impl Places {
    pub(super) fn new(lines: &Lines) -> Self {
        Self { n: lines.joints() }
    }

    /// Returns the place of an entry of M, kg·m² (kg).
    pub(super) fn inertia(i: usize, j: usize) -> usize {
        let (low, high) = (i.min(j), i.max(j));
        high * (high + 1) / 2 + low
    }

    fn joint(self, group: usize, joint: usize) -> usize {
        self.n * (self.n + 1) / 2 + group * self.n + joint
    }

    /// Returns the place of the logarithm of a rotor inertia.
    pub(super) fn rotor(self, joint: usize) -> usize {
        self.joint(0, joint)
    }

    /// Returns the place of the logarithm of a stiffness.
    pub(super) fn stiffness(self, joint: usize) -> usize {
        self.joint(1, joint)
    }

    /// Returns the place of the viscous friction of a link.
    pub(super) fn link_damping(self, joint: usize) -> usize {
        self.joint(2, joint)
    }

    /// Returns the place of the viscous friction of a motor.
    pub(super) fn motor_damping(self, joint: usize) -> usize {
        self.joint(3, joint)
    }

    /// Returns the place of the dry friction of a motor.
    fn dry(self, joint: usize) -> usize {
        self.joint(4, joint)
    }

    /// Returns the place of the transient of a coordinate: links, then motors.
    fn transient(self, coordinate: usize, order: usize) -> usize {
        self.joint(5, 0) + 2 * coordinate + order
    }

    /// Returns the indices of the unknowns of a single joint: inertia, rotor, stiffness, motor damping.
    pub(super) fn of_joint(self, joint: usize) -> [usize; 4] {
        [
            Self::inertia(joint, joint),
            self.rotor(joint),
            self.stiffness(joint),
            self.motor_damping(joint),
        ]
    }

    /// Returns the places of the states at both ends.
    pub(super) fn of_transients(self) -> std::ops::Range<usize> {
        self.transient(0, 0)..self.count()
    }

    /// Returns the number of unknowns.
    pub(super) fn count(self) -> usize {
        self.joint(5, 0) + 4 * self.n
    }
}

/// The squared error of the motor positions and its derivatives.
#[derive(Clone, Debug)]
pub(super) struct Errors {
    /// Sum of the squared errors, each over its variance.
    pub(super) cost: f64,
    /// Real part of Dᴴ D with the derivatives D, \[unknowns × unknowns\].
    pub(super) normal: Mat<f64>,
    /// Real part of Dᴴ e, \[unknowns\].
    pub(super) gradient: Vec<f64>,
    /// Measured minus computed positions, \[n\]\[lines\].
    pub(super) residuals: Vec<Vec<c64>>,
}

/// Motor positions by the equations at a line, with the terms of their derivatives.
struct AtLine {
    /// Positions of links and motors, \[2n\].
    positions: Vec<c64>,
    /// Motor positions per torque on links and motors, \[n × 2n\].
    response: Vec<c64>,
}

/// Equations with spectra and the variances of their positions.
pub(super) struct Equations<'a> {
    pub(super) lines: &'a Lines,
    pub(super) places: Places,
    /// Variances of the motor positions, \[n\]\[lines\].
    pub(super) variances: &'a [Vec<f64>],
}

impl Equations<'_> {
    /// Returns the errors at values of the unknowns; `None` if the equations cannot be solved.
    pub(super) fn errors(&self, x: &[f64]) -> Option<Errors> {
        let (n, count) = (self.places.n, self.places.count());
        let mut errors = Errors {
            cost: 0.0,
            normal: Mat::zeros(count, count),
            gradient: vec![0.0; count],
            residuals: vec![Vec::with_capacity(self.lines.s.len()); n],
        };
        let mut slopes = vec![ZERO; count];
        for line in 0..self.lines.s.len() {
            let state = self.at_line(x, line)?;
            for motor in 0..n {
                let error = self.lines.motor[motor][line] - state.positions[n + motor];
                let weight = self.variances[motor][line].recip();
                errors.cost += weight * error.norm_sqr();
                errors.residuals[motor].push(error);
                self.slopes(x, line, (&state, motor), &mut slopes);
                for (i, a) in slopes.iter().enumerate() {
                    let left = a.conj() * weight;
                    errors.gradient[i] += (left * error).re;
                    for (j, b) in slopes[..=i].iter().enumerate() {
                        errors.normal[(i, j)] += left.re * b.re - left.im * b.im;
                    }
                }
            }
        }
        for i in 0..count {
            for j in 0..i {
                errors.normal[(j, i)] = errors.normal[(i, j)];
            }
        }
        errors.cost.is_finite().then_some(errors)
    }

    /// Returns the cost alone.
    pub(super) fn cost(&self, x: &[f64]) -> Option<f64> {
        let n = self.places.n;
        let mut cost = 0.0;
        for line in 0..self.lines.s.len() {
            let state = self.at_line(x, line)?;
            for motor in 0..n {
                let error = self.lines.motor[motor][line] - state.positions[n + motor];
                cost += error.norm_sqr() / self.variances[motor][line];
            }
        }
        cost.is_finite().then_some(cost)
    }

    /// Eliminates the links, whose block is `A = M s² + D s + K`, and solves for the motors.
    fn at_line(&self, x: &[f64], line: usize) -> Option<AtLine> {
        let (n, places, s) = (self.places.n, self.places, self.lines.s[line]);
        let stiffness: Vec<f64> = (0..n).map(|i| x[places.stiffness(i)].exp()).collect();
        let mut links = vec![ZERO; n * n];
        for i in 0..n {
            for j in 0..n {
                links[i * n + j] = s * s * x[Places::inertia(i, j)];
            }
            links[i * n + i] += s * x[places.link_damping(i)] + stiffness[i];
        }
        let links = inverse(&links, n)?;
        let mut motors = vec![ZERO; n * n];
        for i in 0..n {
            for j in 0..n {
                motors[i * n + j] = -links[i * n + j] * (stiffness[i] * stiffness[j]);
            }
            let rotor = x[places.rotor(i)].exp();
            motors[i * n + i] += s * s * rotor + s * x[places.motor_damping(i)] + stiffness[i];
        }
        let motors = inverse(&motors, n)?;
        let mut response = vec![ZERO; 2 * n * n];
        for i in 0..n {
            for j in 0..n {
                response[i * 2 * n + j] = (0..n)
                    .map(|k| motors[i * n + k] * stiffness[k] * links[k * n + j])
                    .sum();
                response[i * 2 * n + n + j] = motors[i * n + j];
            }
        }
        let transient = |coordinate: usize| {
            s * x[places.transient(coordinate, 1)] + x[places.transient(coordinate, 0)]
        };
        let torques: Vec<c64> = (0..2 * n)
            .map(|coordinate| {
                let transient_part = transient(coordinate);
                let Some(motor) = coordinate.checked_sub(n) else {
                    return transient_part;
                };
                let dry = self.lines.direction[motor].as_ref();
                let dry = dry.map_or(ZERO, |spectrum| spectrum[line] * x[places.dry(motor)]);
                transient_part + self.lines.torque[motor][line] - dry
            })
            .collect();
        let of_motors: Vec<c64> = (0..n)
            .map(|i| {
                (0..2 * n)
                    .map(|j| response[i * 2 * n + j] * torques[j])
                    .sum()
            })
            .collect();
        let mut positions: Vec<c64> = (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| links[i * n + j] * (torques[j] + of_motors[j] * stiffness[j]))
                    .sum()
            })
            .collect();
        positions.extend(of_motors);
        Some(AtLine {
            positions,
            response,
        })
    }

    /// Writes the derivatives of a motor position by the unknowns.
    fn slopes(&self, x: &[f64], line: usize, (state, motor): (&AtLine, usize), out: &mut [c64]) {
        let (n, places, s) = (self.places.n, self.places, self.lines.s[line]);
        let response = &state.response[motor * 2 * n..(motor + 1) * 2 * n];
        let positions = &state.positions;
        for i in 0..n {
            for j in 0..=i {
                let mut moved = response[i] * positions[j];
                if i != j {
                    moved += response[j] * positions[i];
                }
                out[Places::inertia(i, j)] = -(s * s * moved);
            }
            let of_motor = s * response[n + i] * positions[n + i];
            out[places.rotor(i)] = -(s * of_motor * x[places.rotor(i)].exp());
            out[places.motor_damping(i)] = -of_motor;
            out[places.link_damping(i)] = -(s * response[i] * positions[i]);
            let deflection = positions[n + i] - positions[i];
            let spring = (response[n + i] - response[i]) * deflection;
            out[places.stiffness(i)] = -(spring * x[places.stiffness(i)].exp());
            let direction = self.lines.direction[i].as_ref();
            out[places.dry(i)] =
                direction.map_or(ZERO, |spectrum| -(response[n + i] * spectrum[line]));
        }
        for (coordinate, value) in response.iter().enumerate() {
            out[places.transient(coordinate, 0)] = *value;
            out[places.transient(coordinate, 1)] = s * *value;
        }
    }
}
