//! The equations of a robot linearised about the mean pose of a log.
//!
//! `M ẍ + C ẋ + K x = u` with the coordinates x of all links and of the motors of flexible joints.

use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use sprung_core::drives::State;
use sprung_core::linearized::{Derivatives, Partial, Partials};
use sprung_core::links::Step;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::robot::Values;
use sprung_core::scalar::Scalar;

use super::record::Segment;
use crate::model::{Model, Scratch};

/// Samples from which friction is linearised.
const FRICTION_SAMPLES: usize = 2000;

/// Time over which a velocity is a difference of positions, s. It is longer than the steps of an encoder
/// and shorter than a vibration.
const VELOCITY_TIME_S: f64 = 0.01;

/// Number of poses of the log.
const POSES: usize = 64;

/// Matrices of the equations, \[rows × rows\] each.
#[derive(Clone, Debug)]
pub(crate) struct Linear {
    pub(crate) mass: Mat<f64>,
    pub(crate) damping: Mat<f64>,
    pub(crate) stiffness: Mat<f64>,
}

/// Where the equations are linearised.
#[derive(Clone, Debug)]
pub(super) struct OperatingPoint {
    /// Mean pose: link and motor positions, \[n\] each.
    pub(super) mean: Pose,
    /// Poses of the log.
    pub(super) poses: Vec<Pose>,
    /// Viscous friction nearest to each friction term along the log, per unit of its parameter; zero
    /// for other terms. \[terms\]
    pub(super) friction: Vec<f64>,
}

/// Positions of links and motors, \[n\] each, rad (m).
#[derive(Clone, Debug)]
pub(crate) struct Pose {
    pub(crate) q: Vec<f64>,
    pub(crate) phi: Vec<f64>,
}

impl OperatingPoint {
    /// Returns the operating point of a segment of a log.
    ///
    /// Friction that is not linear becomes the viscous friction with the least mean square error along
    /// the log, `Σ f v/Σ v²`. For a Gaussian velocity this is the slope of the best linear
    /// approximation.
    ///
    /// # Source
    ///
    /// Pintelon and Schoukens, "System Identification: A Frequency Domain Approach", 2nd edition, 2012,
    /// Section 3.4; Bussgang's theorem.
    #[must_use]
    pub(super) fn of(model: &Model, segment: &Segment) -> Self {
        let n = model.joint_count();
        let samples = segment.len();
        let pose = |value: &dyn Fn(&[f64]) -> f64| Pose {
            q: (0..n).map(|joint| value(segment.link(joint))).collect(),
            phi: (0..n).map(|joint| value(segment.motor(joint))).collect(),
        };
        let mean = |column: &[f64]| column.iter().sum::<f64>() / column.len().max(1) as f64;
        let robot = model.robot();
        let mut products = vec![[0.0; 2]; robot.terms.len()];
        let step = (samples / FRICTION_SAMPLES).max(1);
        for k in (0..samples).step_by(step) {
            along(model, segment, k, &mut |index, rest, velocity| {
                let [product, square] = &mut products[index];
                *product += rest * velocity;
                *square += velocity * velocity;
            });
        }
        let ratio = |[product, square]: [f64; 2]| if square > 0.0 { product / square } else { 0.0 };
        Self {
            mean: pose(&mean),
            poses: (0..POSES)
                .map(|k| pose(&|column| column[k * samples.saturating_sub(1) / POSES]))
                .collect(),
            friction: products.into_iter().map(ratio).collect(),
        }
    }
}

/// Passes each friction term at a sample to `take`: its index, its torque per unit of the parameter, and the velocity
/// of its side.
fn along(model: &Model, segment: &Segment, k: usize, take: &mut dyn FnMut(usize, f64, f64)) {
    let robot = model.robot();
    let n = model.joint_count();
    let lag = ((0.5 * VELOCITY_TIME_S / segment.period()) as usize).max(1);
    let (before, behind) = (k.saturating_sub(lag), (k + lag).min(segment.len() - 1));
    let time = (behind - before) as f64 * segment.period();
    let columns = |of: &dyn Fn(&[f64]) -> f64, side: &dyn Fn(usize) -> usize| -> Vec<f64> {
        (0..n)
            .map(|joint| of(&segment.columns[side(joint)]))
            .collect()
    };
    let (motors, links) = (|joint: usize| n + joint, |joint: usize| 2 * n + joint);
    let value = |column: &[f64]| column[k];
    let rate = |column: &[f64]| (column[behind] - column[before]) / time;
    let (q, phi) = (columns(&value, &links), columns(&value, &motors));
    let (dq, dphi) = (columns(&rate, &links), columns(&rate, &motors));
    let state = State {
        q: &q,
        dq: &dq,
        phi: &phi,
        dphi: &dphi,
        excess: &[],
        presliding: &[],
    };
    for (index, term) in robot.terms.iter().enumerate() {
        if let JointParameter::Friction(side, _) = term.what {
            let drive = robot.drive(&state, term.joint);
            let rest = term.rest(&drive, &robot.shapes[term.joint]);
            take(index, rest, drive.conditions(side).velocity);
        }
    }
}

impl OperatingPoint {
    /// Returns the nonlinear rest of the friction torque on each motor, \[n\]\[samples\], N·m (N). No torque of the log
    /// contains it, so it disturbs the frequency response.
    #[must_use]
    pub(super) fn distortion(
        &self,
        model: &Model,
        theta: &[f64],
        segment: &Segment,
    ) -> Vec<Vec<f64>> {
        let robot = model.robot();
        let mut all = vec![Vec::with_capacity(segment.len()); model.joint_count()];
        for k in 0..segment.len() {
            for torques in &mut all {
                torques.push(0.0);
            }
            along(model, segment, k, &mut |index, rest, velocity| {
                let term = &robot.terms[index];
                if matches!(term.what, JointParameter::Friction(Side::Motor, _))
                    && let Some(torque) = all[robot.joint_of(term.row)].last_mut()
                {
                    *torque += theta[term.column] * (rest - self.friction[index] * velocity);
                }
            });
        }
        all
    }
}

impl Linear {
    /// Linearises the equations at rest in a pose; `None` if the mass matrix is not positive definite.
    ///
    /// - `friction`: equivalent viscous friction of each friction term, per unit of its parameter; zero for other
    ///   terms, \[terms\].
    #[must_use]
    pub(crate) fn new(model: &Model, theta: &[f64], friction: &[f64], pose: &Pose) -> Option<Self> {
        let (robot, n, rows) = (model.robot(), model.joint_count(), model.rows());
        // Friction is added below: its own derivative at rest holds only for the slowest motions.
        let mut smooth = theta.to_vec();
        for term in robot.terms {
            if matches!(term.what, JointParameter::Friction(..)) {
                smooth[term.column] = 0.0;
            }
        }
        let bodies = model.bodies(theta);
        let values = Values {
            theta: &smooth,
            bodies: &bodies,
        };
        let still = vec![0.0; n];
        let state = State {
            q: &pose.q,
            dq: &still,
            phi: &pose.phi,
            dphi: &still,
            excess: &[],
            presliding: &[],
        };
        let mut scratch = Scratch::new(n);
        let mut workspace = scratch.workspace();
        let (mut inverse, mut mass) = (vec![0.0; rows * rows], vec![0.0; rows * rows]);
        let (none, mut acceleration) = (vec![0.0; rows], vec![0.0; rows]);
        (robot.motion(
            &values,
            &state,
            &none,
            &mut workspace,
            &mut acceleration,
            &mut inverse,
        ))
        .ok()?;
        (robot.mass_matrix(&values, &pose.q, &mut workspace, &mut mass)).ok()?;
        let mut numbers: [Vec<Partial>; 4] = std::array::from_fn(|_| vec![Partial::ZERO; n]);
        let [first, second, third, fourth] = &mut numbers;
        let mut steps = vec![Step::<Partial>::default(); n];
        let mut partials = Partials {
            numbers: [first, second, third, fourth],
            steps: &mut steps,
        };
        let (mut by_position, mut by_velocity) = (vec![0.0; rows * rows], vec![0.0; rows * rows]);
        let mut out = Derivatives {
            by_position: &mut by_position,
            by_velocity: &mut by_velocity,
        };
        // The torques that hold the pose leave no acceleration.
        robot
            .derivatives(
                &values,
                &state,
                &none,
                &inverse,
                &mut workspace,
                &mut partials,
                &mut out,
            )
            .ok()?;
        let square = |values: &[f64]| Mat::from_fn(rows, rows, |i, j| values[i * rows + j]);
        let mass = square(&mass);
        let mut damping = -&mass * square(&by_velocity);
        for (term, slope) in robot.terms.iter().zip(friction) {
            let torque = theta[term.column] * slope;
            match term.what {
                JointParameter::Friction(Side::Link, _) => {
                    damping[(term.row, term.joint)] += torque;
                }
                JointParameter::Friction(Side::Motor, _) => {
                    for k in 0..n {
                        damping[(term.row, robot.motor_coordinate(k))] +=
                            torque * robot.ratio(term.joint, k);
                    }
                }
                JointParameter::RotorInertia
                | JointParameter::Stiffness
                | JointParameter::CubicStiffness
                | JointParameter::Damping
                | JointParameter::Preload
                | JointParameter::Change(..)
                | JointParameter::BackEmf
                | JointParameter::TorqueOffset => {}
            }
        }
        let is_finite = inverse.iter().all(|x| x.is_finite());
        is_finite.then(|| Self {
            stiffness: -&mass * square(&by_position),
            mass,
            damping,
        })
    }

    /// Returns the mean of the equations; `None` without equations.
    #[must_use]
    pub(super) fn mean(all: &[Self]) -> Option<Self> {
        let rows = all.first()?.mass.nrows();
        let mean = |matrix: fn(&Self) -> &Mat<f64>| {
            let sum = |i, j| all.iter().map(|linear| matrix(linear)[(i, j)]).sum::<f64>();
            Mat::from_fn(rows, rows, |i, j| sum(i, j) / all.len() as f64)
        };
        Some(Self {
            mass: mean(|linear| &linear.mass),
            damping: mean(|linear| &linear.damping),
            stiffness: mean(|linear| &linear.stiffness),
        })
    }

    /// Returns the response of all coordinates to a torque on each coordinate at a frequency,
    /// \[rows × rows\].
    ///
    /// - `s`: jω, rad/s.
    #[must_use]
    pub(super) fn response(&self, s: c64, inputs: &[usize]) -> Mat<c64> {
        let rows = self.mass.nrows();
        let matrix = Mat::from_fn(rows, rows, |i, j| {
            s * s * self.mass[(i, j)] + s * self.damping[(i, j)] + self.stiffness[(i, j)]
        });
        let torques = Mat::from_fn(rows, inputs.len(), |i, k| {
            c64::new(f64::from(u8::from(i == inputs[k])), 0.0)
        });
        matrix.partial_piv_lu().solve(&torques)
    }

    /// Returns the equations of some coordinates while the others are held.
    #[must_use]
    pub(crate) fn of(&self, free: &[usize]) -> Self {
        let rows = free.len();
        let without =
            |matrix: &Mat<f64>| Mat::from_fn(rows, rows, |i, j| matrix[(free[i], free[j])]);
        Self {
            mass: without(&self.mass),
            damping: without(&self.damping),
            stiffness: without(&self.stiffness),
        }
    }
}
