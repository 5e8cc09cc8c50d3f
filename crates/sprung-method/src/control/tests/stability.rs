//! Tests of the stability of sampled loops.

use std::f64::consts::TAU;

use faer::c64;
use sprung_core::velocity::AveragedVelocity;

use super::super::margins::stability;
use super::super::pose::linear;
use super::super::sampled::{Law, Sampled};
use super::{Arm, PERIOD, arm};
use crate::description::Controller;
use crate::simulate::ClosedLoop;

#[test]
fn one_period_of_the_sampled_equations_is_that_of_the_simulation() {
    const SMALL: f64 = 1e-4;
    let Arm {
        model,
        theta,
        controller,
    } = arm();
    let q = [0.2, -0.5];
    let plant = Sampled::new(&model, &linear(&model, &theta, &q).unwrap(), PERIOD);
    // Deviations of both links and both motors, then torques of both motors.
    for column in 0..6 {
        let mut start = [q[0], q[1], q[0], q[1]];
        let mut torque = [0.0; 2];
        match column {
            0..4 => start[column] += SMALL,
            _ => torque[column - 4] = SMALL,
        }
        let at = Some((&start[..2], &start[2..]));
        let mut closed_loop = ClosedLoop::new(&model, &theta, &controller, PERIOD, at)
            .unwrap()
            .with_tolerance(1e-13);
        closed_loop.advance(&torque).unwrap();
        let state = closed_loop.state();
        let found = [&state.q, &state.phi, &state.dq, &state.dphi].map(Vec::clone);
        let predicted = plant.column(column);
        for (row, (found, predicted)) in found.concat().iter().zip(predicted).enumerate() {
            let before = [q[0], q[1], q[0], q[1], 0.0, 0.0, 0.0, 0.0][row];
            let found = (found - before) / SMALL;
            assert!(
                (found - predicted).abs() < 1e-5 * (1.0 + predicted.abs()),
                "column {column}, row {row}: {found} {predicted}"
            );
        }
    }
}

#[test]
fn the_gain_of_the_velocity_estimator_is_that_of_its_averages() {
    let mut controller = arm().controller;
    controller.velocity_window = [4, 2];
    let law = Law::of(&controller, 2);
    let mut estimator = AveragedVelocity::new(4, 2, PERIOD).unwrap();
    let angle = TAU * 37.0 * PERIOD;
    let gain = law.estimator(c64::new(angle.cos(), angle.sin()), PERIOD);
    for k in 0..400 {
        let found = estimator.process((angle * f64::from(k)).cos());
        if k > 20 {
            let wave = c64::new((angle * f64::from(k)).cos(), (angle * f64::from(k)).sin());
            assert!((found - (gain * wave).re).abs() < 1e-9, "{k}");
        }
    }
}

/// Returns the controller with the gains of one motor times a factor.
fn scaled(controller: &Controller, joint: usize, factor: f64) -> Controller {
    let mut controller = controller.clone();
    controller.kp_nm_per_rad[joint] *= factor;
    controller.kd_nms_per_rad[joint] *= factor;
    controller
}

#[test]
fn gain_margins_end_where_poles_leave_the_unit_circle() {
    let Arm {
        model,
        theta,
        controller,
    } = arm();
    for q in [[0.0, 0.0], [0.3, 1.2]] {
        let of =
            |controller: &Controller| stability(&model, &theta, controller, &q, PERIOD).unwrap();
        let now = of(&controller);
        assert!(
            now.growth_per_s.is_none() && now.least_damping > 0.0,
            "{now:?}"
        );
        for joint in 0..2 {
            let factor = 10.0_f64.powf(now.margins[joint].gain_db / 20.0);
            assert!(factor.is_finite() && factor > 1.0, "{now:?}");
            let is_stable = |by: f64| of(&scaled(&controller, joint, by)).growth_per_s.is_none();
            assert!(
                is_stable(0.98 * factor) && is_stable(1.02 / factor),
                "{now:?}"
            );
            assert!(
                !is_stable(1.02 * factor) || !is_stable(0.98 / factor),
                "{now:?}"
            );
        }
    }
}

#[test]
fn a_loop_with_a_negative_gain_grows() {
    let Arm {
        model,
        theta,
        mut controller,
    } = arm();
    controller.kd_nms_per_rad[0] = -50.0;
    let stability = stability(&model, &theta, &controller, &[0.0; 2], PERIOD).unwrap();
    assert!(
        stability.growth_per_s.unwrap() > 1.0 && stability.least_damping < 1.0,
        "{stability:?}"
    );
}

#[test]
fn an_unstable_loop_runs_away_in_the_simulation_and_a_stable_one_comes_to_rest() {
    let Arm {
        model,
        theta,
        controller,
    } = arm();
    let q = [0.0, 0.0];
    let margin = stability(&model, &theta, &controller, &q, PERIOD)
        .unwrap()
        .margins[1]
        .gain_db;
    let factor = 10.0_f64.powf(margin / 20.0);
    let mut still = controller.clone();
    still.reference.sines.clear();
    // Largest deflection of the last tenth of 3 s after a small deflection.
    let rest = |by: f64| -> f64 {
        let controller = scaled(&still, 1, by);
        let start = Some((&[0.0, 0.01][..], &[0.0, 0.0][..]));
        let mut plant = ClosedLoop::new(&model, &theta, &controller, PERIOD, start).unwrap();
        let mut most: f64 = 0.0;
        for k in 0..3000 {
            let state = plant.state();
            let tau = plant.command(plant.time(), &state.q, &state.phi);
            if plant.advance(&tau).is_err() {
                return f64::INFINITY;
            }
            if k > 2700 {
                most = most.max((state.phi[1] - state.q[1]).abs());
            }
        }
        most
    };
    let (stable, unstable) = (rest(0.9 * factor), rest(1.1 * factor));
    assert!(stable < 8e-3 && unstable > 0.1, "{stable} {unstable}");
}
