//! The feedforward of the whole model against its equations of motion.
use sprung_core::controller::{Feedforward, FeedforwardScratch};
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

use crate::mixed::{Mixed, for_random_robots};
use crate::support::{JointState, Random, Waves, Worst, feedforward_with};

/// Step of the finite differences, s.
const H: f64 = 1e-4;

fn nominal(robot: &Mixed, q_d: &[[f64; 5]], scales: &[f64]) -> (Vec<f64>, JointState) {
    robot.with(|robot, values| feedforward_with(robot, values, q_d, Some(scales)))
}

/// Whether the smooth law of the feedforward is the law of the model if both have the same sharpness.
fn is_same(what: JointParameter) -> bool {
    match what {
        JointParameter::Friction(_, law) => matches!(
            law,
            Law::Viscous | Law::Coulomb | Law::Stribeck | Law::Offset | Law::Load
        ),
        _ => what != JointParameter::Damping,
    }
}

/// Largest error of the accelerations of links and motors on a desired motion.
fn see_motion(robot: &Mixed, random: &mut Random, scales: &[f64], worst: &mut [Worst; 2]) {
    let waves = Waves::draw(random, scales.len(), 2.0);
    let t = random.between(0.0, 3.0);
    let q_d = waves.at(t);
    let (tau, state) = nominal(robot, &q_d, scales);
    let [ddq, ddphi] = robot.acceleration(&state, &tau);
    let [ahead, behind] = [H, -H].map(|by| nominal(robot, &waves.at(t + by), scales).1.dphi);
    for (i, q_d) in q_d.iter().enumerate() {
        worst[0].see(ddq[i] - q_d[2], q_d[2]);
        let wanted = (ahead[i] - behind[i]) / (2.0 * H);
        worst[1].see(ddphi[i] - wanted, wanted);
    }
}

#[test]
fn a_robot_at_rest_stays() {
    let mut worst = Worst::default();
    for_random_robots(|robot, random| {
        let n = robot.shapes_mut().len();
        let positions = random.list(n, 3.0);
        let q_d: Vec<[f64; 5]> = positions.iter().map(|q| [*q, 0.0, 0.0, 0.0, 0.0]).collect();
        let scales: Vec<f64> = (0..n).map(|_| random.between(1e-3, 0.1)).collect();
        let (tau, state) = nominal(robot, &q_d, &scales);
        for acceleration in robot.acceleration(&state, &tau).concat() {
            worst.see(acceleration, 1.0);
        }
    });
    worst.assert_below(1e-10, "acceleration at rest");
}

#[test]
fn a_robot_with_smooth_laws_moves_as_desired() {
    let mut worst = [Worst::default(), Worst::default()];
    for_random_robots(|robot, random| {
        robot.set(0.0, |what| !is_same(what));
        // Friction of links under load is found by iteration.
        robot.set(0.0, |what| {
            what == JointParameter::Friction(Side::Link, Law::Load)
        });
        let n = robot.shapes_mut().len();
        let scales: Vec<f64> = (0..n).map(|_| random.between(0.2, 1.0)).collect();
        for (shape, scale) in robot.shapes_mut().iter_mut().zip(&scales) {
            shape.sharpness = 1.0 / scale;
        }
        see_motion(robot, random, &scales, &mut worst);
    });
    let [links, motors] = worst;
    links.assert_below(1e-10, "accelerations of links");
    // The error of the finite difference.
    motors.assert_below(1e-4, "accelerations of motors");
}

#[test]
fn damping_of_springs_and_friction_of_links_under_load_are_found_by_iteration() {
    let mut worst = [Worst::default(), Worst::default()];
    let mut without = [Worst::default(), Worst::default()];
    for_random_robots(|robot, random| {
        robot.set(0.0, |what| {
            !is_same(what) && what != JointParameter::Damping
        });
        let n = robot.shapes_mut().len();
        let scales = vec![1.0; n];
        for shape in robot.shapes_mut() {
            shape.sharpness = 1.0;
        }
        see_motion(robot, random, &scales, &mut worst);
        robot.set(0.0, |what| what == JointParameter::Damping);
        see_motion(robot, random, &scales, &mut without);
    });
    let [links, motors] = worst;
    links.assert_below(1e-6, "accelerations of links with damping");
    // Damping of the third derivative of the deflection is left out.
    motors.assert_below(0.3, "accelerations of motors with damping");
    let [links, _] = without;
    links.assert_below(1e-10, "accelerations of links without damping");
}

#[test]
fn friction_only_adds_to_the_feedforward_without_friction() {
    for_random_robots(|robot, random| {
        robot.set(0.0, |what| {
            !matches!(
                what,
                JointParameter::RotorInertia | JointParameter::Stiffness
            )
        });
        let n = robot.shapes_mut().len();
        let q_d = Waves::draw(random, n, 2.0).at(0.3);
        let [without, with] = [None, Some(vec![0.01; n])].map(|scales| {
            robot.with(|robot, values| feedforward_with(robot, values, &q_d, scales.as_deref()))
        });
        let numbers = |(tau, state): &(Vec<f64>, JointState)| -> Vec<u64> {
            let all = [tau, &state.phi, &state.dphi];
            (all.iter().flat_map(|own| own.iter()))
                .map(|x| (x + 0.0).to_bits())
                .collect()
        };
        assert_eq!(numbers(&without), numbers(&with));
    });
}

#[test]
fn useless_scales_keep_the_sharpness_of_the_law_and_missing_ones_are_refused() {
    for_random_robots(|robot, random| {
        let n = robot.shapes_mut().len();
        let q_d = Waves::draw(random, n, 2.0).at(0.3);
        let (known, _) = nominal(robot, &q_d, &vec![0.0; n]);
        for scale in [-1.0, f64::NAN, 1e-9] {
            let (tau, _) = nominal(robot, &q_d, &vec![scale; n]);
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
            assert!((out.fill_with_friction(robot, values, &[], &[], &mut scratch)).is_err());
        });
    });
}
