//! Spectra of the errors of the equations of motion by sensor noise and disturbances.

use faer::{Mat, c64, linalg::solvers::Solve};
use sprung_core::friction::Scale;
use sprung_core::parameters::JointParameter;
use sprung_core::robot::Values;

use crate::model::{Model, Scratch};
use crate::simulate::JointState;

/// Errors of sensors and disturbances of one experiment, per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// Sampling period of the log, s.
    pub period: f64,
    /// Steps of the link and of the motor positions, rad (m), \[n\] each.
    pub steps: [Vec<f64>; 2],
    /// White noise of the logged torque, N·m (N), \[n\].
    pub torque: Vec<f64>,
    /// Disturbances of links and motors, N·m (N), \[n\] each.
    pub disturbances: [Vec<f64>; 2],
    /// Corner frequency of the spectrum of the disturbances, Hz.
    pub corner: f64,
}

impl Errors {
    /// Returns the step of the position of a coordinate.
    pub(super) fn step(&self, model: &Model, row: usize) -> f64 {
        let joint = model.joint_of(row);
        let is_motor = row >= model.joint_count() || !model.is_flexible(joint);
        self.steps[usize::from(is_motor)][joint]
    }
}

/// Returns a matrix for each angular frequency that turns the transforms of the errors of all rows into independent
/// numbers of variance one per second: the inverse root of their spectrum, \[2 rows × 2 rows\], real parts first.
pub(super) fn whiteners(
    model: &Model,
    theta: &[f64],
    errors: &Errors,
    poses: &[Vec<f64>],
    rates: &[f64],
) -> Vec<Mat<f64>> {
    let rows = model.coordinates();
    let masses = mean_mass(model, theta, poses);
    let [stiffness, damping] = slopes_at(model, theta, MOVING);
    let spectrum = |rate: f64| {
        let dynamic = Mat::from_fn(rows, rows, |i, j| {
            c64::new(
                stiffness[(i, j)] - rate * rate * masses[(i, j)],
                rate * damping[(i, j)],
            )
        });
        let positions = Mat::from_fn(rows, rows, |i, j| {
            let step = errors.step(model, j);
            dynamic[(i, j)] * (step * step / 12.0 * errors.period).sqrt()
        });
        let mut sum = &positions * positions.adjoint();
        for row in 0..rows {
            let joint = model.joint_of(row);
            let is_motor = model.is_torque_row(row);
            if is_motor {
                sum[(row, row)] += errors.torque[joint].powi(2) * errors.period;
            }
            let level = errors.disturbances[usize::from(is_motor)][joint];
            let corner = std::f64::consts::TAU * errors.corner;
            sum[(row, row)] += 2.0 * level * level * corner / (corner * corner + rate * rate);
        }
        sum
    };
    (rates.iter())
        .map(|&rate| {
            let sum = spectrum(rate);
            let scale: Vec<f64> = (0..rows)
                .map(|row| sum[(row, row)].re.max(f64::MIN_POSITIVE).sqrt())
                .collect();
            let mut scaled = Mat::from_fn(rows, rows, |i, j| sum[(i, j)] / (scale[i] * scale[j]));
            for row in 0..rows {
                scaled[(row, row)] += c64::new(1e-12, 0.0);
            }
            let inverse = match scaled.llt(faer::Side::Lower) {
                Ok(factor) => {
                    let lower = factor.L().to_owned();
                    lower
                        .partial_piv_lu()
                        .solve(Mat::<c64>::identity(rows, rows))
                }
                Err(_) => Mat::identity(rows, rows),
            };
            Mat::from_fn(2 * rows, 2 * rows, |i, j| {
                let entry = inverse[(i % rows, j % rows)] / scale[j % rows];
                match (i < rows, j < rows) {
                    (true, true) | (false, false) => entry.re,
                    (true, false) => -entry.im,
                    (false, true) => entry.im,
                }
            })
        })
        .collect()
}

pub(super) fn mean_mass(model: &Model, theta: &[f64], poses: &[Vec<f64>]) -> Mat<f64> {
    let rows = model.coordinates();
    let bodies = model.bodies(theta);
    let values = Values {
        theta,
        bodies: &bodies,
    };
    let mut scratch = Scratch::new(model.joint_count());
    let mut sum = Mat::zeros(rows, rows);
    let mut mass = vec![0.0; rows * rows];
    for q in poses {
        let computed = model
            .robot()
            .mass_matrix(&values, q, &mut scratch.workspace(), &mut mass);
        if computed.is_ok() {
            sum += Mat::from_fn(rows, rows, |i, j| mass[i * rows + j] / poses.len() as f64);
        }
    }
    sum
}

/// Velocity at which friction is linearised, beyond the transition of Coulomb friction, rad/s (m/s).
pub(super) const MOVING: f64 = 1.0;

/// Returns the derivatives of the torques of the drives by positions and velocities of all coordinates.
///
/// - `velocity`: of all joints, rad/s (m/s).
pub(super) fn slopes_at(model: &Model, theta: &[f64], velocity: f64) -> [Mat<f64>; 2] {
    let (n, rows) = (model.joint_count(), model.coordinates());
    let robot = model.robot();
    let still = vec![0.0; n];
    let moving = vec![velocity; n];
    let state = JointState {
        q: still.clone(),
        dq: moving.clone(),
        phi: still,
        dphi: moving,
    };
    let mut all = [Mat::zeros(rows, rows), Mat::zeros(rows, rows)];
    for term in robot.terms {
        if term.what == JointParameter::RotorInertia {
            continue;
        }
        let drive = robot.drive(&state.view(), term.joint);
        let slopes = term.slopes(&drive, &robot.shapes[term.joint]);
        let motor = robot.motor_coordinate(term.joint);
        let value = theta[term.column];
        for (order, slope) in [slopes.deflection, slopes.deflection_rate]
            .into_iter()
            .enumerate()
        {
            if motor != term.joint {
                all[order][(term.row, motor)] += value * slope;
                all[order][(term.row, term.joint)] -= value * slope;
            }
        }
        all[1][(term.row, term.joint)] += value * slopes.link_velocity;
        for k in 0..n {
            let ratio = robot.ratio(term.joint, k);
            all[1][(term.row, robot.motor_coordinate(k))] += value * slopes.motor_velocity * ratio;
        }
    }
    all
}

/// How fast a robot's equations are.
#[derive(Clone, Debug)]
pub(super) struct Fastest {
    /// Resonance of each spring with motors and links free, Hz.
    pub(super) resonances: Vec<f64>,
    /// Step with which Runge-Kutta steps of order 4 are stable, s.
    pub(super) step: f64,
    /// Largest sharpness of Coulomb friction for this step, s/rad (s/m), per joint.
    sharpness: Vec<f64>,
}

/// Longest step of the simulation, s.
const LONGEST_STEP: f64 = 2.5e-3;

impl Fastest {
    /// Returns the fastest rate of the equations of a robot, by inertias and stiffnesses of single
    /// joints.
    pub(super) fn of(model: &Model, theta: &[f64]) -> Self {
        let (n, rows) = (model.joint_count(), model.coordinates());
        let masses = mean_mass(model, theta, &[vec![0.0; n]]);
        let [stiffness, viscous] = slopes_at(model, theta, MOVING);
        let [_, still] = slopes_at(model, theta, 0.0);
        let inertia = |row: usize| masses[(row, row)];
        let is_mass = |row: &usize| inertia(*row).is_finite() && inertia(*row) > 0.0;
        let mut step = LONGEST_STEP;
        for row in (0..rows).filter(is_mass) {
            let rate = viscous[(row, row)].abs() / inertia(row);
            let angular = (stiffness[(row, row)].abs() / inertia(row)).sqrt();
            step = step.min(1.0 / rate.max(angular));
        }
        let sharpness = |joint: usize| {
            let rows = [joint, model.torque_row(joint)].into_iter().filter(is_mass);
            let parts = rows.map(|row| {
                let by_coulomb = still[(row, row)] - viscous[(row, row)];
                let free = 2.0 * inertia(row) / step - viscous[(row, row)];
                if by_coulomb > free {
                    free / by_coulomb
                } else {
                    1.0
                }
            });
            model.sharpness(joint) * parts.fold(1.0, f64::min)
        };
        let resonance = |joint: usize| {
            let motor = model.torque_row(joint);
            let sum = 1.0 / inertia(joint) + 1.0 / inertia(motor);
            (stiffness[(motor, motor)].abs() * sum).sqrt() / std::f64::consts::TAU
        };
        let flexible = (0..n).filter(|&joint| model.is_flexible(joint));
        Self {
            resonances: flexible
                .map(resonance)
                .filter(|hz| hz.is_finite())
                .collect(),
            sharpness: (0..n).map(sharpness).collect(),
            step,
        }
    }

    /// Returns a model whose Coulomb friction is not too sharp for the step. The information of a motion hardly
    /// depends on it.
    pub(super) fn softened(&self, model: &Model) -> Model {
        let mut soft = model.clone();
        for (joint, &sharpness) in self.sharpness.iter().enumerate() {
            soft.set_scale(joint, Scale::Sharpness, sharpness);
        }
        soft
    }
}
