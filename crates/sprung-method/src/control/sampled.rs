//! The sampled closed loop about rest: poles, and the loop of each motor with the others closed.

use std::f64::consts::TAU;

use faer::linalg::solvers::Solve;
use faer::{Mat, Scale, c64};

use super::linear::Linear;
use super::riccati;
use crate::description::{Controller, ControllerKind};
use crate::model::Model;

/// The feedback of a controller: gains on measured positions and on estimated velocities.
#[derive(Clone, Debug)]
pub(super) struct Law {
    /// On link and motor positions, \[n × 2n\].
    pub(super) position: Mat<f64>,
    /// On their estimated velocities, \[n × 2n\].
    pub(super) velocity: Mat<f64>,
    /// Samples of both averages of the velocity estimator.
    averages: [usize; 2],
}

impl Law {
    /// Returns the feedback of a controller of n joints.
    #[must_use]
    pub(super) fn of(controller: &Controller, n: usize) -> Self {
        let [p1, p2] = controller.velocity_window;
        let mut law = Self {
            position: Mat::zeros(n, 2 * n),
            velocity: Mat::zeros(n, 2 * n),
            averages: [p1 + 1, p2 + 1],
        };
        match controller.kind {
            ControllerKind::Pd => {
                for i in 0..n {
                    law.position[(i, n + i)] = controller.kp_nm_per_rad[i];
                    law.velocity[(i, n + i)] = controller.kd_nms_per_rad[i];
                }
            }
            ControllerKind::StateFeedback => {
                for (i, row) in controller.gain.iter().enumerate() {
                    for k in 0..2 * n {
                        law.position[(i, k)] = row[k];
                        law.velocity[(i, k)] = row[2 * n + k];
                    }
                }
            }
        }
        law
    }

    /// Returns the gain of the velocity estimator at z, 1/s.
    pub(super) fn estimator(&self, z: c64, period: f64) -> c64 {
        let [p, r] = self.averages;
        let back = z.inv();
        let mut sum = c64::new(0.0, 0.0);
        let mut power = c64::new(1.0, 0.0);
        for _ in 0..p {
            sum += power;
            power *= back;
        }
        sum * (c64::new(1.0, 0.0) - back.powu(r as u32)) * (1.0 / (period * (p * r) as f64))
    }
}

/// A robot about rest whose motor torques are constant over each period.
#[derive(Clone, Debug)]
pub(super) struct Sampled {
    /// Transition of positions and velocities of all coordinates, \[2 rows × 2 rows\].
    transition: Mat<f64>,
    /// Effect of the motor torques, \[2 rows × n\].
    input: Mat<f64>,
    /// Coordinate of each link and of each motor, \[2n\].
    outputs: Vec<usize>,
    period: f64,
}

impl Sampled {
    /// Returns the sampled equations of a robot.
    #[must_use]
    pub(super) fn new(model: &Model, linear: &Linear, period: f64) -> Self {
        let n = model.joint_count();
        let torques: Vec<usize> = (0..n).map(|k| model.torque_row(k)).collect();
        let robot = model.robot();
        let motors = (0..n).map(|k| robot.motor_coordinate(k));
        let outputs: Vec<usize> = (0..n).chain(motors).collect();
        Self::of(linear, &torques, &outputs, period)
    }

    /// Returns the sampled equations.
    ///
    /// - `torques`: coordinate on which each motor acts, \[n\]; `outputs`: coordinate of each link and of each motor, \[2n\].
    pub(super) fn of(linear: &Linear, torques: &[usize], outputs: &[usize], period: f64) -> Self {
        let (n, rows) = (torques.len(), linear.mass.nrows());
        let factors = linear.mass.partial_piv_lu();
        let spring = factors.solve(&linear.stiffness);
        let damper = factors.solve(&linear.damping);
        let acting = factors.solve(&Mat::from_fn(rows, n, |i, k| {
            f64::from(u8::from(i == torques[k]))
        }));
        let size = 2 * rows + n;
        let rates = Mat::from_fn(size, size, |i, j| {
            let part = if i < rows {
                f64::from(u8::from(j == i + rows))
            } else if i >= 2 * rows {
                0.0
            } else if j < rows {
                -spring[(i - rows, j)]
            } else if j < 2 * rows {
                -damper[(i - rows, j - rows)]
            } else {
                acting[(i - rows, j - 2 * rows)]
            };
            period * part
        });
        let whole = exponential(&rates);
        Self {
            transition: whole.submatrix(0, 0, 2 * rows, 2 * rows).to_owned(),
            input: whole.submatrix(0, 2 * rows, 2 * rows, n).to_owned(),
            outputs: outputs.to_vec(),
            period,
        }
    }

    /// Returns the number of coordinates.
    #[must_use]
    pub(super) fn rows(&self) -> usize {
        self.transition.nrows() / 2
    }

    /// Returns the gain that minimises a quadratic cost of positions and velocities of all coordinates, \[n × 2 rows\]; `None` if
    /// none stabilises the equations.
    ///
    /// - `state`: weights of positions, then of velocities, \[2 rows\]; `torque`: weights of the torques, \[n\].
    pub(super) fn quadratic_gain(&self, state: &[f64], torque: &[f64]) -> Option<Mat<f64>> {
        riccati::gain(&self.transition, &self.input, state, torque)
    }

    /// Returns the state after one period that began with one in a position or a torque: positions and velocities of all
    /// coordinates.
    ///
    /// - `index`: of a position, or after them of a motor torque.
    #[cfg(test)]
    pub(super) fn column(&self, index: usize) -> Vec<f64> {
        let rows = self.transition.nrows() / 2;
        match index.checked_sub(rows) {
            None => self.transition.col_as_slice(index).to_vec(),
            Some(torque) => self.input.col_as_slice(torque).to_vec(),
        }
    }

    /// Returns the positions of links and motors per unit of torque, \[2n × n\].
    fn response(&self, z: c64) -> Mat<c64> {
        let size = self.transition.nrows();
        let matrix = Mat::from_fn(size, size, |i, j| {
            let entry = c64::new(-self.transition[(i, j)], 0.0);
            if i == j { entry + z } else { entry }
        });
        let n = self.input.ncols();
        let input = Mat::from_fn(size, n, |i, k| c64::new(self.input[(i, k)], 0.0));
        let states = matrix.partial_piv_lu().solve(&input);
        Mat::from_fn(self.outputs.len(), n, |i, k| states[(self.outputs[i], k)])
    }

    /// Returns the loop of each motor, opened there while the others are closed, at a frequency; \[n\].
    ///
    /// With the loop transfer `T` of all motors and `S = (I + T)⁻¹` it is `1/S_ii − 1`.
    ///
    /// - `hz`: below half the sampling rate.
    ///
    /// # Source
    ///
    /// Skogestad and Postlethwaite, Multivariable Feedback Control, 2nd edition, 2005, Section 9.6.
    pub(super) fn loops(&self, law: &Law, hz: f64) -> Vec<c64> {
        let angle = TAU * hz * self.period;
        let z = c64::new(angle.cos(), angle.sin());
        let (response, velocity) = (self.response(z), law.estimator(z, self.period));
        let n = self.input.ncols();
        let gain = Mat::from_fn(n, 2 * n, |i, k| {
            velocity * law.velocity[(i, k)] + c64::new(law.position[(i, k)], 0.0)
        });
        let mut whole = gain * response;
        for i in 0..n {
            whole[(i, i)] += c64::new(1.0, 0.0);
        }
        let identity = Mat::<c64>::identity(n, n);
        let sensitivity = whole.partial_piv_lu().solve(&identity);
        (0..n)
            .map(|i| sensitivity[(i, i)].inv() - c64::new(1.0, 0.0))
            .collect()
    }

    /// Returns the poles of the closed loop with its velocity estimators, in the plane of z; `None` if they cannot be
    /// computed.
    pub(super) fn poles(&self, law: &Law) -> Option<Vec<c64>> {
        let (size, n) = (self.transition.nrows(), self.input.ncols());
        let [p, r] = law.averages;
        let lags = p + r - 1;
        let used: Vec<usize> = (0..2 * n)
            .filter(|&k| (0..n).any(|i| law.velocity[(i, k)] != 0.0))
            .collect();
        let scale = 1.0 / (self.period * (p * r) as f64);
        let weight = |age: usize| {
            let after = f64::from(u8::from(age < p));
            let before = f64::from(u8::from((r..r + p).contains(&age)));
            scale * (after - before)
        };
        let m = used.len();
        let whole = size + lags * m;
        let mut matrix = Mat::<f64>::zeros(whole, whole);
        // Torque as a function of the state and of past positions.
        let mut torque = Mat::<f64>::zeros(n, whole);
        for i in 0..n {
            for k in 0..2 * n {
                let gain = law.position[(i, k)] + law.velocity[(i, k)] * weight(0);
                torque[(i, self.outputs[k])] -= gain;
            }
            for age in 1..=lags {
                for (place, &k) in used.iter().enumerate() {
                    torque[(i, size + (age - 1) * m + place)] -= law.velocity[(i, k)] * weight(age);
                }
            }
        }
        let driven = &self.input * &torque;
        for i in 0..size {
            for j in 0..whole {
                let transition = if j < size {
                    self.transition[(i, j)]
                } else {
                    0.0
                };
                matrix[(i, j)] = transition + driven[(i, j)];
            }
        }
        for (place, &k) in used.iter().enumerate() {
            matrix[(size + place, self.outputs[k])] = 1.0;
            for age in 1..lags {
                matrix[(size + age * m + place, size + (age - 1) * m + place)] = 1.0;
            }
        }
        let all = matrix.eigenvalues().ok()?;
        all.iter()
            .all(|pole| pole.re.is_finite() && pole.im.is_finite())
            .then_some(all)
    }

    /// Returns the rate of a pole, 1/s: its logarithm over the period; `None` for a pole at zero.
    pub(super) fn rate(&self, pole: c64) -> Option<c64> {
        let size = pole.norm();
        (size > 0.0).then(|| c64::new(size.ln(), pole.im.atan2(pole.re)) * (1.0 / self.period))
    }
}

/// Terms of the series of the exponential, and norm up to which they are exact to rounding.
const TERMS: usize = 12;
const NORM: f64 = 0.25;

/// Returns the exponential of a matrix, by scaling and squaring of its series.
fn exponential(matrix: &Mat<f64>) -> Mat<f64> {
    let size = matrix.nrows();
    let row = |i: usize| (0..size).map(|j| matrix[(i, j)].abs()).sum::<f64>();
    let norm = (0..size).map(row).fold(0.0, f64::max);
    let squarings = if norm > NORM {
        (norm / NORM).log2().ceil().min(60.0) as i32
    } else {
        0
    };
    let scaled = matrix * Scale(0.5_f64.powi(squarings));
    let mut term = Mat::<f64>::identity(size, size);
    let mut sum = term.clone();
    for k in 1..=TERMS {
        term = &term * &scaled * Scale(1.0 / k as f64);
        sum += &term;
    }
    for _ in 0..squarings {
        sum = &sum * &sum;
    }
    sum
}
