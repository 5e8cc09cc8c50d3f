//! The feedforward of the whole model against its equations of motion.
use sprung_core::controller::{Feedforward, FeedforwardScratch, TorqueSeries};
use sprung_core::friction::Law;
use sprung_core::links::Step;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::scalar::Scalar;

use crate::mixed::{Mixed, for_random_robots};
use crate::support::{JointState, Random, Waves, Worst, feedforward};

/// Step of the finite differences, s.
const H: f64 = 1e-4;

fn nominal(robot: &Mixed, q_d: &[[f64; 5]], speed: Option<f64>) -> (Vec<f64>, JointState) {
    robot.with(|robot, values| feedforward(robot, values, q_d, speed))
}

fn is_friction(what: JointParameter) -> bool {
    matches!(
        what,
        JointParameter::Friction(..) | JointParameter::Change(..)
    )
}

/// Whether a law needs iteration.
fn is_implicit(what: JointParameter) -> bool {
    let under_load = JointParameter::Friction(Side::Link, Law::Load);
    what == JointParameter::Damping || what == under_load
}

/// Gives the laws of all joints the sharpness of the compensation.
fn soften(robot: &mut Mixed, speed: f64) {
    for shape in robot.shapes_mut() {
        shape.sharpness = 1.0 / speed;
    }
}

/// Largest error of the accelerations of links and motors on a desired motion.
fn see_motion(robot: &Mixed, random: &mut Random, speed: Option<f64>, worst: &mut [Worst; 2]) {
    let waves = Waves::draw(random, robot.shapes().len(), 2.0);
    let t = random.between(0.0, 3.0);
    let q_d = waves.at(t);
    let (tau, state) = nominal(robot, &q_d, speed);
    let [ddq, ddphi] = robot.acceleration(&state, &tau);
    let [ahead, behind] = [H, -H].map(|by| nominal(robot, &waves.at(t + by), speed).1.dphi);
    for (i, q_d) in q_d.iter().enumerate() {
        worst[0].see(ddq[i] - q_d[2], q_d[2]);
        let wanted = (ahead[i] - behind[i]) / (2.0 * H);
        worst[1].see(ddphi[i] - wanted, wanted);
    }
}

fn still(random: &mut Random, n: usize) -> Vec<[f64; 5]> {
    let positions = random.list(n, 3.0);
    let still = positions.iter().map(|q| [*q, 0.0, 0.0, 0.0, 0.0]);
    still.collect()
}

#[test]
fn a_robot_at_rest_stays() {
    let mut worst = Worst::default();
    for_random_robots(|robot, random| {
        robot.make_springs_elastic();
        let q_d = still(random, robot.shapes().len());
        let speed = random.between(1e-3, 0.1);
        let mut see = |robot: &Mixed, speed| {
            let (tau, state) = nominal(robot, &q_d, speed);
            for acceleration in robot.acceleration(&state, &tau).concat() {
                worst.see(acceleration, 1.0);
            }
        };
        see(robot, Some(speed));
        robot.set(0.0, |what| {
            matches!(what, JointParameter::Friction(_, Law::Offset))
        });
        see(robot, None);
    });
    worst.assert_below(1e-10, "acceleration at rest");
}

#[test]
fn the_motors_hold_exactly_gravity_at_rest() {
    for_random_robots(|robot, random| {
        robot.make_springs_elastic();
        robot.set(0.0, |what| {
            matches!(what, JointParameter::Friction(_, Law::Offset))
        });
        let n = robot.shapes().len();
        let q_d = still(random, n);
        let q: Vec<TorqueSeries> = q_d.iter().map(|d| TorqueSeries::constant(d[0])).collect();
        let zero = vec![TorqueSeries::ZERO; n];
        let mut gravity = zero.clone();
        robot.with(|robot, values| {
            let mut steps = vec![Step::default(); n];
            (robot.link_torque(values, &q, &zero, &zero, &mut steps, &mut gravity)).unwrap();
        });
        for speed in [None, Some(0.01)] {
            let (tau, _) = nominal(robot, &q_d, speed);
            for (tau, gravity) in tau.iter().zip(&gravity) {
                assert_eq!(tau.to_bits(), (gravity.value() + 0.0).to_bits());
            }
        }
    });
}

#[test]
fn a_robot_moves_as_desired_with_friction_cubic_stiffness_and_preload() {
    let mut worst = [Worst::default(), Worst::default()];
    for_random_robots(|robot, random| {
        robot.make_springs_elastic();
        // The references of the covariates are those of the robot.
        robot.set(0.0, is_implicit);
        let speed = random.between(0.2, 1.0);
        soften(robot, speed);
        see_motion(robot, random, Some(speed), &mut worst);
    });
    let [links, motors] = worst;
    links.assert_below(1e-10, "accelerations of links");
    // The error of the finite difference.
    motors.assert_below(1e-5, "accelerations of motors");
}

#[test]
fn a_robot_without_friction_moves_as_desired_without_compensation() {
    let mut worst = [Worst::default(), Worst::default()];
    for_random_robots(|robot, random| {
        robot.make_springs_elastic();
        robot.set(0.0, |what| is_friction(what) || is_implicit(what));
        see_motion(robot, random, None, &mut worst);
    });
    let [links, motors] = worst;
    links.assert_below(1e-10, "accelerations of links");
    motors.assert_below(1e-6, "accelerations of motors");
}

#[test]
fn damping_of_springs_and_friction_of_links_under_load_are_found_by_iteration() {
    let mut damped = [Worst::default(), Worst::default()];
    let mut loaded = [Worst::default(), Worst::default()];
    let mut both = [Worst::default(), Worst::default()];
    let under_load = JointParameter::Friction(Side::Link, Law::Load);
    for_random_robots(|robot, random| {
        robot.make_springs_elastic();
        soften(robot, 1.0);
        see_motion(robot, random, Some(1.0), &mut both);
        let load = robot.get(under_load);
        robot.set(0.0, |what| what == under_load);
        see_motion(robot, random, Some(1.0), &mut damped);
        robot.set(load, |what| what == under_load);
        robot.set(0.0, |what| what == JointParameter::Damping);
        see_motion(robot, random, Some(1.0), &mut loaded);
    });
    both[0].assert_below(1e-7, "accelerations of links with damping and load");
    damped[0].assert_below(1e-8, "accelerations of links with damping");
    // Damping of the third derivative of the deflection is left out.
    damped[1].assert_below(0.3, "accelerations of motors with damping");
    loaded[0].assert_below(1e-8, "accelerations of links with load");
}

#[test]
fn useless_speeds_keep_the_sharpness_of_the_law_and_wrong_lengths_are_refused() {
    for_random_robots(|robot, random| {
        robot.make_springs_elastic();
        let n = robot.shapes().len();
        let q_d = Waves::draw(random, n, 2.0).at(0.3);
        let (known, _) = nominal(robot, &q_d, Some(0.0));
        for speed in [-1.0, f64::NAN, 1e-9] {
            let (tau, _) = nominal(robot, &q_d, Some(speed));
            assert_eq!(tau, known);
        }
        robot.with(|robot, values| {
            let mut scratch: FeedforwardScratch<'_, f64> = FeedforwardScratch {
                series: [&mut [], &mut [], &mut [], &mut []],
                steps: &mut [],
            };
            let mut out = Feedforward {
                tau: &mut [],
                phi: &mut [],
                dphi: &mut [],
            };
            assert!((out.fill(robot, values, &[], None, &mut scratch)).is_err());
        });
    });
}
