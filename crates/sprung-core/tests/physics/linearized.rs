//! Accelerations row by row, and their derivatives, against the equations of motion and finite differences.

use sprung_core::linearized::{Derivatives, Partial, Partials};
use sprung_core::links::Step;
use sprung_core::robot::{Robot, Values};
use sprung_core::scalar::Scalar;

use crate::mixed::for_random_robots;
use crate::support::{JointState, Memory, ROUNDINGS, Worst, acceleration, slope, slope_rounding};

/// Step of the differences by the state, rad or rad/s. It is short beside the transition of the friction.
const STEP: f64 = 1e-5;

/// Accelerations of the rows' coordinates, and the inverse mass matrix.
fn motion(
    robot: &Robot<'_>,
    values: &Values<'_>,
    state: &JointState,
    torque: &[f64],
) -> [Vec<f64>; 2] {
    let rows = robot.rows();
    let mut memory = Memory::new(robot.joints());
    let mut found = [vec![f64::NAN; rows], vec![f64::NAN; rows * rows]];
    let [acceleration, inverse] = &mut found;
    robot
        .motion(
            values,
            &state.view(),
            torque,
            &mut memory.workspace(),
            acceleration,
            inverse,
        )
        .unwrap();
    found
}

/// A state in which the position or the velocity of one row is changed.
fn changed(
    robot: &Robot<'_>,
    state: &JointState,
    row: usize,
    velocity: bool,
    by: f64,
) -> JointState {
    let mut all = JointState {
        q: state.q.clone(),
        dq: state.dq.clone(),
        phi: state.phi.clone(),
        dphi: state.dphi.clone(),
        elements: state.elements.clone(),
    };
    let joint = robot.joint_of(row);
    let (link, motor) = if velocity {
        (&mut all.dq, &mut all.dphi)
    } else {
        (&mut all.q, &mut all.phi)
    };
    if row < robot.joints() {
        link[joint] += by;
    }
    if robot.motor_coordinate(joint) == row {
        motor[joint] += by;
    }
    all
}

#[test]
fn rows_agree_with_joints() {
    let mut worst = Worst::default();
    for_random_robots(|robot, random| {
        let n = robot.with(|robot, _| robot.joints());
        let (state, tau) = (robot.draw_state(random), random.list(n, 20.0));
        robot.with(|robot, values| {
            let mut torque = vec![0.0; robot.rows()];
            for (joint, tau) in tau.iter().enumerate() {
                torque[robot.motor_coordinate(joint)] = *tau;
            }
            let [found, _] = motion(robot, values, &state, &torque);
            let [ddq, ddphi] = acceleration(robot, values, &state, &tau);
            for joint in 0..n {
                worst.see(found[joint] - ddq[joint], ddq[joint]);
                let motor = found[robot.motor_coordinate(joint)];
                worst.see(motor - ddphi[joint], ddphi[joint]);
            }
        });
    });
    worst.assert_below(1e-12, "rows against joints");
}

#[test]
fn columns_at_the_acceleration_give_the_torque() {
    let mut worst = Worst::default();
    for_random_robots(|robot, random| {
        let state = robot.draw_state(random);
        let places = robot.places().to_vec();
        robot.with(|robot, values| {
            let torque = random.list(robot.rows(), 20.0);
            let [found, _] = motion(robot, values, &state, &torque);
            let mut entries = vec![f64::NAN; robot.entries];
            let mut memory = Memory::new(robot.joints());
            robot
                .torque_entries(&state.view(), &found, &mut memory.workspace(), &mut entries)
                .unwrap();
            let mut required = vec![f64::NAN; robot.rows()];
            (robot.required_torques(
                values,
                &state.view(),
                &found,
                &mut memory.workspace(),
                &mut required,
            ))
            .unwrap();
            let mut sums = vec![0.0; robot.rows()];
            for (entry, &(row, column)) in entries.iter().zip(&places) {
                sums[row] += entry * values.theta[column];
            }
            let largest = torque.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
            for (sum, torque) in sums.iter().zip(&torque) {
                worst.see(sum - torque, largest);
            }
            for (sum, required) in sums.iter().zip(&required) {
                worst.see(sum - required, largest);
            }
        });
    });
    worst.assert_below(1e-10, "columns at the acceleration");
}

#[test]
fn derivatives_are_limits_of_differences() {
    let [mut by_state, mut by_torque] = [(); 2].map(|()| Worst::default());
    for_random_robots(|robot, random| {
        let state = robot.draw_state(random);
        robot.with(|robot, values| {
            let (n, rows) = (robot.joints(), robot.rows());
            let torque = random.list(rows, 20.0);
            let [found, inverse] = motion(robot, values, &state, &torque);
            let largest = found.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
            let mut memory = Memory::new(n);
            let mut numbers = [(); 4].map(|()| vec![Partial::ZERO; n]);
            let [q, dq, ddq, tau] = &mut numbers;
            let mut partials = Partials {
                numbers: [q, dq, ddq, tau],
                steps: &mut vec![Step::default(); n],
            };
            let mut square = [(); 2].map(|()| vec![f64::NAN; rows * rows]);
            let [by_position, by_velocity] = &mut square;
            let mut out = Derivatives {
                by_position,
                by_velocity,
            };
            robot
                .derivatives(
                    values,
                    &state.view(),
                    &found,
                    &inverse,
                    &mut memory.workspace(),
                    &mut partials,
                    &mut out,
                )
                .unwrap();
            for i in 0..rows {
                for j in 0..rows {
                    for velocity in [false, true] {
                        let found = square[usize::from(velocity)][i * rows + j];
                        let difference = slope(STEP, |t| {
                            let state = changed(robot, &state, j, velocity, t);
                            motion(robot, values, &state, &torque)[0][i]
                        });
                        by_state.see(found - difference, largest.max(difference.abs()));
                    }
                    let difference = slope(1e-3, |t| {
                        let mut torque = torque.clone();
                        torque[j] += t;
                        motion(robot, values, &state, &torque)[0][i]
                    });
                    by_torque.see(inverse[i * rows + j] - difference, difference);
                }
            }
        });
    });
    by_state.assert_below(ROUNDINGS * slope_rounding(STEP), "derivatives by the state");
    by_torque.assert_below(1e-9, "derivatives by torques");
}
