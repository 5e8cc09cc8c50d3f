//! Gains for a bandwidth and a damping, at a pose.

use std::f64::consts::TAU;

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::linear::Linear;
use super::sampled::Sampled;
use crate::description::Feedback;
use crate::model::Model;

/// What the gains are for.
#[derive(Clone, Debug)]
pub(super) struct Aim {
    pub(super) feedback: Feedback,
    /// Bandwidth of each joint, Hz, \[n\].
    pub(super) bandwidth_hz: Vec<f64>,
    /// Damping ratio.
    pub(super) damping: f64,
}

/// Inertia, friction and stiffness of one joint alone.
#[derive(Clone, Copy, Debug)]
struct Joint {
    /// Coordinates of link and motor; equal for a rigid joint.
    link: usize,
    motor: usize,
    /// Inertia of the link with the links that it carries, kg·m² (kg).
    carried: f64,
    /// Inertia of the motor; 0 for a rigid joint.
    rotor: f64,
    /// Viscous friction of link and motor, N·m·s/rad (N·s/m).
    friction: f64,
    /// Stiffness of the spring, N·m/rad (N/m); 0 for a rigid joint.
    stiffness: f64,
}

impl Joint {
    fn all(model: &Model, linear: &Linear) -> Vec<Self> {
        let robot = model.robot();
        (0..model.joint_count())
            .map(|link| {
                let motor = robot.motor_coordinate(link);
                let is_flexible = motor != link;
                let diagonal = |matrix: &Mat<f64>, at: usize| matrix[(at, at)];
                Self {
                    link,
                    motor,
                    carried: diagonal(&linear.mass, link),
                    rotor: if is_flexible {
                        diagonal(&linear.mass, motor)
                    } else {
                        0.0
                    },
                    friction: diagonal(&linear.damping, link)
                        + if is_flexible {
                            diagonal(&linear.damping, motor)
                        } else {
                            0.0
                        },
                    stiffness: if is_flexible {
                        -linear.stiffness[(motor, link)]
                    } else {
                        0.0
                    },
                }
            })
            .collect()
    }

    fn inertia(&self) -> f64 {
        self.carried + self.rotor
    }
}

/// Returns the natural frequency of each link on its spring while all motors are held, Hz; 0 for a rigid joint. \[n\]
pub(super) fn held_hz(model: &Model, linear: &Linear) -> Vec<f64> {
    (Joint::all(model, linear).iter())
        .map(|joint| (joint.stiffness / joint.carried).max(0.0).sqrt() / TAU)
        .collect()
}

/// Returns the gains of a state feedback, \[n\]\[4n\]: on the errors of link positions, motor positions, link velocities and motor
/// velocities. `None` if no gain stabilises the equations. The gains of a rigid joint act on its motor.
pub(super) fn gains(
    model: &Model,
    linear: &Linear,
    plant: &Sampled,
    aim: &Aim,
) -> Option<Vec<Vec<f64>>> {
    let joints = Joint::all(model, linear);
    match aim.feedback {
        Feedback::StateFeedback => quadratic(&joints, plant, aim),
        Feedback::LinkDamping => Some(link_damping(&joints, linear, aim)),
        Feedback::Pd | Feedback::Declared => Some(motors(&joints, aim)),
    }
}

/// Returns `kp` and `kd` with which a motor moves its joint as one body with a natural frequency and a damping.
fn of_motor(joint: &Joint, hz: f64, damping: f64) -> [f64; 2] {
    let rate = TAU * hz;
    let inertia = joint.inertia();
    let kd = 2.0 * damping * rate * inertia - joint.friction;
    [inertia * rate * rate, kd.max(0.0)]
}

fn motors(joints: &[Joint], aim: &Aim) -> Vec<Vec<f64>> {
    let n = joints.len();
    (joints.iter().zip(&aim.bandwidth_hz).enumerate())
        .map(|(i, (joint, hz))| {
            let mut row = vec![0.0; 4 * n];
            [row[n + i], row[3 * n + i]] = of_motor(joint, *hz, aim.damping);
            row
        })
        .collect()
}

/// Returns the gains of a quadratic cost for each joint alone: two inertias on a spring, or one without a spring. They
/// ignore the coupling by the links, so they depend less on the pose.
pub(super) fn of_joints(
    model: &Model,
    linear: &Linear,
    period: f64,
    aim: &Aim,
) -> Option<Vec<Vec<f64>>> {
    let joints = Joint::all(model, linear);
    let n = joints.len();
    let mut all = vec![vec![0.0; 4 * n]; n];
    for (i, joint) in joints.iter().enumerate() {
        let alone = linear.of(&if joint.motor == joint.link {
            vec![joint.link]
        } else {
            vec![joint.link, joint.motor]
        });
        let last = alone.mass.nrows() - 1;
        let plant = Sampled::of(&alone, &[last], &[0, last], period);
        let joint = Joint {
            link: 0,
            motor: last,
            ..*joint
        };
        let aim = Aim {
            bandwidth_hz: vec![aim.bandwidth_hz[i]],
            ..aim.clone()
        };
        let found = quadratic(&[joint], &plant, &aim)?;
        for order in 0..4 {
            all[i][order * n + i] = found[0][order];
        }
    }
    Some(all)
}

/// Returns the gains with the least cost: for one body, poles with the rate `w` and the damping `d` minimise the
/// integral of `w⁴ q² + (4 d² - 2) w² q̇² + (tau/J)²`. The cost weights the links, so vibrations of the springs are
/// weighted by the motion of the links.
fn quadratic(joints: &[Joint], plant: &Sampled, aim: &Aim) -> Option<Vec<Vec<f64>>> {
    let (n, rows) = (joints.len(), plant.rows());
    let mut state = vec![0.0; 2 * rows];
    let mut torque = Vec::with_capacity(n);
    for (joint, hz) in joints.iter().zip(&aim.bandwidth_hz) {
        let rate = TAU * hz;
        state[joint.link] = rate.powi(4);
        state[rows + joint.link] = (4.0 * aim.damping * aim.damping - 2.0).max(0.0) * rate * rate;
        torque.push(joint.inertia().powi(-2));
    }
    let found = plant.quadratic_gain(&state, &torque)?;
    let all = (0..n).map(|i| {
        let mut row = vec![0.0; 4 * n];
        for (k, joint) in joints.iter().enumerate() {
            for (order, at) in [(0, 0), (1, rows)] {
                row[(2 * order + 1) * n + k] += found[(i, at + joint.motor)];
                if joint.motor != joint.link {
                    row[2 * order * n + k] += found[(i, at + joint.link)];
                }
            }
        }
        row
    });
    Some(all.collect())
}

/// Returns the gains of the elastic structure preserving control, which damps the links as a damper between link and base does.
///
/// With `η = φ + K⁻¹ D q̇`, the torque `τ = kp (η_d - η) + kd (η̇_d - η̇) - D q̇ - B K⁻¹ D q⃛` of each joint leaves the link's equation
/// with the damper D and that of the motor with its inertia B. Acceleration and jerk of the links follow from the equations at
/// the pose, without the motors' torques.
///
/// # Source
///
/// Keppler, Lakatos, Ott and Albu-Schäffer, "Elastic Structure Preserving (ESP) Control for Compliantly Actuated Robots", IEEE
/// Trans. Robotics 34, 2018, eqs. (15) to (23).
fn link_damping(joints: &[Joint], linear: &Linear, aim: &Aim) -> Vec<Vec<f64>> {
    let (n, rows) = (joints.len(), linear.mass.nrows());
    let factors = linear.mass.partial_piv_lu();
    let by_position = -factors.solve(&linear.stiffness);
    let by_velocity = -factors.solve(&linear.damping);
    // The jerk: the time derivative of the accelerations.
    let jerk_by_position = &by_velocity * &by_position;
    let jerk_by_velocity = &by_velocity * &by_velocity + &by_position;
    (joints.iter().zip(&aim.bandwidth_hz).enumerate())
        .map(|(i, (joint, hz))| {
            let [kp, kd] = of_motor(joint, *hz, aim.damping);
            let mut row = vec![0.0; 4 * n];
            row[n + i] += kp;
            row[3 * n + i] += kd;
            if joint.stiffness <= 0.0 {
                return row;
            }
            let wanted = 2.0 * aim.damping.min(1.0) * (joint.stiffness * joint.carried).sqrt();
            let damper = (wanted - linear.damping[(joint.link, joint.link)]).max(0.0);
            let lead = damper / joint.stiffness;
            row[2 * n + i] += kp * lead + damper;
            let mut add = |factor: f64, matrix: &Mat<f64>, order: usize| {
                for (k, other) in joints.iter().enumerate() {
                    let motor = matrix[(joint.link, other.motor)];
                    row[(2 * order + 1) * n + k] += factor * motor;
                    if other.motor != other.link {
                        row[2 * order * n + k] += factor * matrix[(joint.link, other.link)];
                    }
                }
            };
            add(kd * lead, &by_position, 0);
            add(kd * lead, &by_velocity, 1);
            add(joint.rotor * lead, &jerk_by_position, 0);
            add(joint.rotor * lead, &jerk_by_velocity, 1);
            debug_assert_eq!(by_position.nrows(), rows);
            row
        })
        .collect()
}
