//! The two controllers of the paper: PD on the rotors, and feedforward with
//! state feedback.

use core::ops::Add;

use crate::drives::{Drive, State, Term};
use crate::friction::Law;
use crate::links::{LengthError, Step, lengths};
use crate::parameters::{JointParameter, Side};
use crate::presliding::ALL_ELEMENTS;
use crate::robot::{Robot, Values};
use crate::scalar::{Jet, Scalar};

/// Writes the motor torques of PD control, \[n\], N·m (N).
///
/// - `kp`, `kd`: gains, \[n\], N·m/rad (N/m) and N·m·s/rad (N·s/m).
/// - `phi_d`, `dphi_d`: reference positions and velocities of the rotors, \[n\], rad (m) and rad/s
///   (m/s).
/// - `phi`, `dphi`: measured positions and velocities of the rotors, \[n\].
///
/// If another slice is shorter than `tau`, the last entries of `tau` stay unchanged.
///
/// # Source
///
/// Eq. (24).
pub fn pd(
    kp: &[f64],
    kd: &[f64],
    [phi_d, dphi_d]: [&[f64]; 2],
    [phi, dphi]: [&[f64]; 2],
    tau: &mut [f64],
) {
    let gains = kp.iter().zip(kd);
    let wanted = phi_d.iter().zip(dphi_d);
    let found = phi.iter().zip(dphi);
    for (((tau, (kp, kd)), (phi_d, dphi_d)), (phi, dphi)) in
        tau.iter_mut().zip(gains).zip(wanted).zip(found)
    {
        *tau = kp * (phi_d - phi) + kd * (dphi_d - dphi);
    }
}

/// Taylor series of a torque with its first two time derivatives.
pub type TorqueSeries<S = f64> = Jet<3, S>;

/// Newton steps for the deflection of a cubic spring. They bring the value to rounding from a
/// deflection that is up to twenty times too large.
const DEFLECTION_STEPS: usize = 12;

/// Newton steps for its Taylor series; each doubles the number of correct coefficients.
const SERIES_STEPS: usize = 2;

/// Passes of deflection and torque where damping of a spring or friction under load makes the torque
/// depend on the deflection. Three are exact for damping of a linear spring; with cubic stiffness or
/// load, each multiplies the error by about the part of the torque that depends on the deflection.
const PASSES: usize = 6;

/// Scratch memory of [`Feedforward::fill`]; each slice is \[n\].
#[derive(Debug)]
pub struct FeedforwardScratch<'w, S = f64> {
    /// Taylor series of positions, velocities, accelerations and torques of the links.
    pub series: [&'w mut [TorqueSeries<S>]; 4],
    /// Scratch memory of the inverse dynamics.
    pub steps: &'w mut [Step<TorqueSeries<S>>],
}

/// How a feedforward compensates friction.
#[derive(Clone, Copy, Debug)]
pub struct Compensation<'e, S = f64> {
    /// Speed below which the torques against friction fade, rad/s (m/s), positive.
    pub speed: f64,
    /// Elements of presliding friction along the desired motion until the sample before, \[n × [`ALL_ELEMENTS`]\]; empty if all
    /// slide.
    pub elements: &'e [S],
}

/// Rotor trajectory and motor torques with which a model follows a desired link trajectory; each
/// \[n\].
#[derive(Debug)]
pub struct Feedforward<'o, S = f64> {
    /// Nominal motor torque `tau_d`, N·m (N).
    pub tau: &'o mut [S],
    /// Desired rotor positions, rad (m).
    pub phi: &'o mut [S],
    /// Desired rotor velocities, rad/s (m/s).
    pub dphi: &'o mut [S],
}

impl<S: Scalar> Feedforward<'_, S> {
    /// Computes the nominal rotor trajectory and motor torques of a model.
    ///
    /// - `q_d`: desired link positions and their time derivatives up to the fourth, \[n\]\[5\].
    /// - `values`: parameters of the model; stiffnesses must be positive, and a spring must not soften
    ///   to zero stiffness.
    /// - `compensation`: `None` for torques without friction. The laws' `tanh(beta v)` becomes `tanh(v / v_c)`
    ///   where that is smoother; presliding friction with elements does not fade.
    ///
    /// Friction acts at the desired velocities and at the references of all covariates, so its torques depend on no
    /// measurement. Without velocity only its constant torques remain: the motors carry gravity. Friction of a link
    /// turns its spring, so the rotors move faster the smaller `v_c` is when a link turns round. Friction of a link
    /// under load follows by iteration.
    ///
    /// The springs have stiffness, cubic stiffness, preload and damping. The torque of damping contains
    /// the rate of the deflection. The third derivative of the deflection, which `q_d` does not
    /// determine, counts as zero: `tau` then lacks its part in the rotor's acceleration, and the
    /// links move as desired.
    ///
    /// The rotor of a rigid joint moves with its link. Back-EMF always counts.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    ///
    /// # Source
    ///
    /// Eq. (32) and the equations before it, with all terms of eq. (1).
    pub fn fill(
        &mut self,
        robot: &Robot<'_>,
        values: &Values<'_>,
        q_d: &[[S; 5]],
        compensation: Option<Compensation<'_, S>>,
        scratch: &mut FeedforwardScratch<'_, S>,
    ) -> Result<(), LengthError> {
        self.move_links(robot, values, q_d, scratch)?;
        let losses = Losses {
            robot,
            values,
            compensation_speed: compensation.map(|compensation| compensation.speed),
        };
        let elements = compensation.map_or(&[][..], |compensation| compensation.elements);
        let [_, dq, deflection, torque] = &mut scratch.series;
        for (i, torque) in torque.iter_mut().enumerate() {
            let link = Link {
                losses: &losses,
                joint: i,
                velocity: dq[i],
                torque: *torque,
            };
            (deflection[i], *torque) = link.deflection_and_torque();
        }
        self.move_rotors(robot, values, q_d, scratch);
        let [_, _, deflection, _] = &scratch.series;
        for term in robot.terms {
            let turns = self.dphi.iter().enumerate();
            let drive = Drive {
                deflection: deflection[term.joint].coefficients[0],
                deflection_rate: S::ZERO,
                link_velocity: S::ZERO,
                motor_velocity: (turns.map(|(k, dphi)| *dphi * robot.ratio(term.joint, k)))
                    .fold(S::ZERO, Add::add),
                excess: [0.0; _],
                elements: (elements.as_chunks::<ALL_ELEMENTS>().0.get(term.joint)).copied(),
            };
            if let Some(loss) = losses.torque(term, Side::Motor, &drive) {
                let tau = &mut self.tau[robot.joint_of(term.row)];
                *tau = *tau + loss;
            }
        }
        Ok(())
    }

    /// Writes the torques of the links, without drives, and zero deflections in place of their
    /// accelerations.
    fn move_links(
        &self,
        robot: &Robot<'_>,
        values: &Values<'_>,
        q_d: &[[S; 5]],
        scratch: &mut FeedforwardScratch<'_, S>,
    ) -> Result<(), LengthError> {
        let [q, dq, ddq, torque] = &mut scratch.series;
        lengths(
            &[
                ("q_d", q_d.len()),
                ("tau", self.tau.len()),
                ("phi", self.phi.len()),
                ("dphi", self.dphi.len()),
                ("series", q.len()),
                ("series", dq.len()),
                ("series", ddq.len()),
            ],
            robot.joints(),
        )?;
        for (i, d) in q_d.iter().enumerate() {
            q[i] = Jet::from_derivatives([d[0], d[1], d[2]]);
            dq[i] = Jet::from_derivatives([d[1], d[2], d[3]]);
            ddq[i] = Jet::from_derivatives([d[2], d[3], d[4]]);
        }
        robot.link_torque(values, q, dq, ddq, scratch.steps, torque)?;
        ddq.fill(Jet::ZERO);
        Ok(())
    }

    /// Writes rotor motion and motor torques from the deflections and torques of the springs.
    fn move_rotors(
        &mut self,
        robot: &Robot<'_>,
        values: &Values<'_>,
        q_d: &[[S; 5]],
        scratch: &mut FeedforwardScratch<'_, S>,
    ) {
        let n = robot.joints();
        let [_, acceleration, deflection, torque] = &mut scratch.series;
        for (i, d) in q_d.iter().enumerate() {
            let rotor = |order: usize| match robot.motor_rows[i] {
                Some(_) => d[order] + deflection[i].derivative(order),
                // In a rigid joint the rotor's motion is the link's.
                None => d[order],
            };
            self.phi[i] = rotor(0);
            self.dphi[i] = rotor(1);
            self.tau[i] = torque[i].derivative(0);
            acceleration[i].coefficients[0] = rotor(2);
        }
        for term in robot.terms {
            if term.what == JointParameter::RotorInertia {
                let parts =
                    (0..n).map(|k| acceleration[k].coefficients[0] * robot.ratio(term.joint, k));
                let motor = parts.reduce(Add::add).unwrap_or(S::ZERO);
                let tau = &mut self.tau[robot.joint_of(term.row)];
                *tau = *tau + motor * term.momentum(1.0) * values.theta[term.column];
            }
        }
    }
}

/// Losses of the motion of a robot: friction, if it is compensated, and back-EMF.
struct Losses<'r> {
    robot: &'r Robot<'r>,
    values: &'r Values<'r>,
    compensation_speed: Option<f64>,
}

impl Losses<'_> {
    /// Returns the torque of a term in its row; `None` if it is no loss on this side of the spring.
    fn torque<S: Scalar>(&self, term: &Term, side: Side, drive: &Drive<S>) -> Option<S> {
        let mut shape = self.robot.shapes[term.joint];
        let is_loss = match (term.what, self.compensation_speed) {
            (JointParameter::Friction(friction_side, _), Some(speed)) => {
                if speed > 0.0 {
                    shape.sharpness = shape.sharpness.min(1.0 / speed);
                }
                friction_side == side
            }
            (JointParameter::BackEmf, _) => side == Side::Motor,
            (
                JointParameter::RotorInertia
                | JointParameter::Stiffness
                | JointParameter::CubicStiffness
                | JointParameter::Damping
                | JointParameter::Hysteresis(_)
                | JointParameter::Preload
                | JointParameter::TorqueOffset
                | JointParameter::Friction(..)
                | JointParameter::Change(..),
                _,
            ) => false,
        };
        is_loss.then(|| term.rest(drive, &shape) * self.values.theta[term.column])
    }
}

/// Parameters of a spring.
#[derive(Clone, Copy, Debug, Default)]
struct Spring {
    stiffness: f64,
    cubic: f64,
    damping: f64,
    preload: f64,
}

impl Spring {
    /// Returns the spring of a joint; `None` for a rigid joint.
    fn of(robot: &Robot<'_>, values: &Values<'_>, joint: usize) -> Option<Self> {
        robot.motor_rows[joint]?;
        let mut spring = Self::default();
        for term in robot.terms.iter().filter(|term| term.joint == joint) {
            let coefficient = match term.what {
                JointParameter::Stiffness => &mut spring.stiffness,
                JointParameter::CubicStiffness => &mut spring.cubic,
                JointParameter::Damping => &mut spring.damping,
                JointParameter::Preload => &mut spring.preload,
                JointParameter::RotorInertia
                | JointParameter::Hysteresis(_)
                | JointParameter::BackEmf
                | JointParameter::TorqueOffset
                | JointParameter::Friction(..)
                | JointParameter::Change(..) => continue,
            };
            *coefficient = values.theta[term.column];
        }
        Some(spring)
    }

    /// Returns the deflection `e` with `K e + K_3 e³ = torque`.
    fn deflection<S: Scalar>(&self, torque: TorqueSeries<S>) -> TorqueSeries<S> {
        let linear = torque.over(self.stiffness);
        if self.cubic.abs() <= 0.0 {
            return linear;
        }
        let [wanted, ..] = torque.coefficients;
        let [mut value, rate, second] = linear.coefficients;
        for _ in 0..DEFLECTION_STEPS {
            value = self.newton(value, wanted);
        }
        let mut series = Jet {
            coefficients: [value, rate, second],
        };
        for _ in 0..SERIES_STEPS {
            series = self.newton(series, torque);
        }
        series
    }

    fn newton<S: Scalar>(&self, e: S, torque: S) -> S {
        let square = e * e;
        let stiffness = square * (3.0 * self.cubic) + S::constant(self.stiffness);
        // e - (K e + K_3 e³ - torque) / (K + 3 K_3 e²), on one denominator.
        (square * e * (2.0 * self.cubic) + torque) * stiffness.recip()
    }
}

/// A link on its desired motion.
struct Link<'r, S> {
    losses: &'r Losses<'r>,
    joint: usize,
    velocity: TorqueSeries<S>,
    /// Torque of the inertias and of gravity.
    torque: TorqueSeries<S>,
}

impl<S: Scalar> Link<'_, S> {
    /// Returns the deflection of the joint's spring, and the torque that joint or spring transmit to
    /// the link.
    fn deflection_and_torque(&self) -> (TorqueSeries<S>, TorqueSeries<S>) {
        let Some(spring) = Spring::of(self.losses.robot, self.losses.values, self.joint) else {
            return (Jet::ZERO, self.torque_at(Jet::ZERO));
        };
        let is_implicit = spring.damping.abs() > 0.0 || self.is_loaded();
        let passes = if is_implicit { PASSES } else { 1 };
        let [mut deflection, mut torque] = [Jet::ZERO; 2];
        for _ in 0..passes {
            torque = self.torque_at(deflection);
            let elastic =
                torque + Jet::constant(spring.preload) - deflection.rate() * spring.damping;
            deflection = spring.deflection(elastic);
        }
        (deflection, torque)
    }

    /// Returns whether the friction depends on the deflection.
    fn is_loaded(&self) -> bool {
        let Losses { robot, values, .. } = self.losses;
        let under_load = JointParameter::Friction(Side::Link, Law::Load);
        let counts = |term: &Term| {
            let is_there = values.theta[term.column].abs() > 0.0;
            term.what == under_load && term.row == self.joint && is_there
        };
        self.losses.compensation_speed.is_some() && robot.terms.iter().any(counts)
    }

    /// Returns the torque on the link with the friction at a deflection.
    fn torque_at(&self, deflection: TorqueSeries<S>) -> TorqueSeries<S> {
        let drive = Drive {
            deflection,
            deflection_rate: Jet::ZERO,
            link_velocity: self.velocity,
            motor_velocity: Jet::ZERO,
            excess: [0.0; _],
            elements: None,
        };
        let terms = self.losses.robot.terms.iter();
        (terms.filter(|term| term.row == self.joint))
            .filter_map(|term| self.losses.torque(term, Side::Link, &drive))
            .fold(self.torque, Add::add)
    }
}

/// Adds state feedback about the trajectory of a [`Feedforward`] to its torques.
///
/// - `gain`: `F`, \[n\] rows of \[4n\], applied to the errors of link positions, rotor positions,
///   link velocities and rotor velocities, in this order.
/// - `tau`: torques of the feedforward, \[n\], N·m (N).
///
/// # Source
///
/// Eq. (33).
pub fn state_feedback(gain: &[&[f64]], desired: &State<'_>, measured: &State<'_>, tau: &mut [f64]) {
    let wanted = [desired.q, desired.phi, desired.dq, desired.dphi];
    let found = [measured.q, measured.phi, measured.dq, measured.dphi];
    for (tau, row) in tau.iter_mut().zip(gain) {
        let errors = (wanted.iter().zip(&found))
            .flat_map(|(wanted, found)| wanted.iter().zip(*found))
            .map(|(wanted, found)| wanted - found);
        *tau += row
            .iter()
            .zip(errors)
            .map(|(gain, e)| gain * e)
            .sum::<f64>();
    }
}
