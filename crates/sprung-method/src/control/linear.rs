//! The equations of a robot linearised about a pose.
//!
//! `M ẍ + C ẋ + K x = u` with the coordinates x of all links and of the motors of flexible joints.

use faer::Mat;
use sprung_core::drives::State;
use sprung_core::linearized::{Derivatives, Partial, Partials};
use sprung_core::links::Step;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::robot::Values;
use sprung_core::scalar::Scalar;

use crate::model::{Model, Scratch};

/// Matrices of the equations, \[rows × rows\] each.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    pub(super) mass: Mat<f64>,
    pub(super) damping: Mat<f64>,
    pub(super) stiffness: Mat<f64>,
}

/// Positions of links and motors, \[n\] each, rad (m).
#[derive(Clone, Debug)]
pub(super) struct Pose {
    pub(super) q: Vec<f64>,
    pub(super) phi: Vec<f64>,
}

impl Linear {
    /// Linearises the equations at rest in a pose; `None` if the mass matrix is not positive definite.
    ///
    /// - `friction`: equivalent viscous friction of each friction term, per unit of its parameter; zero for other
    ///   terms, \[terms\].
    #[must_use]
    pub(super) fn new(model: &Model, theta: &[f64], friction: &[f64], pose: &Pose) -> Option<Self> {
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
            elements: &[],
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
                | JointParameter::Hysteresis(_)
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

    /// Returns the equations of some coordinates while the others are held.
    #[must_use]
    pub(super) fn of(&self, free: &[usize]) -> Self {
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
