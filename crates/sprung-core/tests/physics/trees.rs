//! Laws of physics for random trees of joints, whose links are point masses.
use sprung_core::chain::{Chain, ChainError};
use sprung_core::dynamics::{inverse_dynamics, mass_matrix, momentum_and_rest};
use sprung_core::linear::{factor, solve};
use sprung_core::links::{LengthError, Step, regressor, torque};
use sprung_core::scalar::{Jet, Scalar};
use sprung_core::spatial::BODY;

use crate::bodies::{GRAVITY, Tree};
use crate::support::{
    Memory, ROUNDINGS, Random, Waves, Worst, inner, moved, slope, slope_rounding,
};

/// Momentum, rest and torque of a state, computed from the regressor columns.
fn by_columns(tree: &Tree, q: &[f64], dq: &[f64], ddq: &[f64]) -> [Vec<f64>; 3] {
    let n = tree.joints.len();
    let chain = tree.chain();
    let mut memory = Memory::new(n);
    let workspace = &mut memory.workspace();
    let mut columns = [(); 3].map(|()| vec![f64::NAN; n * n * BODY]);
    let [a, b, c] = &mut columns;
    regressor(&chain, q, dq, workspace, a, b).unwrap();
    torque(&chain, q, dq, ddq, workspace, c).unwrap();
    let pi = tree.parameters();
    columns.map(|matrix| matrix.chunks(pi.len()).map(|row| inner(row, &pi)).collect())
}

/// Momentum and rest of a state, summed from the tips to the base.
fn by_sums(tree: &Tree, q: &[f64], dq: &[f64]) -> [Vec<f64>; 2] {
    let n = tree.joints.len();
    let mut steps = vec![Step::default(); n];
    let [mut momentum, mut rest] = [(); 2].map(|()| vec![f64::NAN; n]);
    let into = [&mut momentum[..], &mut rest[..]];
    momentum_and_rest(&tree.chain(), &tree.bodies(), [q, dq], &mut steps, into).unwrap();
    [momentum, rest]
}

/// Torque of a state, computed by the recursive Newton-Euler algorithm.
fn by_recursion<S: Scalar>(tree: &Tree, [q, dq, ddq]: [&[S]; 3]) -> Vec<S> {
    let n = tree.joints.len();
    let mut steps = vec![Step::default(); n];
    let mut tau = vec![S::ZERO; n];
    let bodies = tree.bodies();
    inverse_dynamics(&tree.chain(), &bodies, q, dq, ddq, &mut steps, &mut tau).unwrap();
    tau
}

fn matrix_of(tree: &Tree, q: &[f64]) -> Vec<f64> {
    let n = tree.joints.len();
    let mut matrix = vec![f64::NAN; n * n];
    let mut memory = Memory::new(n);
    let workspace = &mut memory.workspace();
    mass_matrix(
        &tree.chain(),
        &tree.bodies(),
        q,
        workspace.steps,
        &mut matrix,
    )
    .unwrap();
    matrix
}

fn for_random_trees(mut law: impl FnMut(&Tree, &[f64], &[f64], &[f64])) {
    let mut random = Random::new(20);
    for n in 1..=12 {
        for _ in 0..4 {
            let tree = Tree::draw(&mut random, n);
            let [q, dq, ddq] = [2.0, 1.5, 3.0].map(|limit| random.list(n, limit));
            law(&tree, &q, &dq, &ddq);
        }
    }
}

/// Errors of torques and momenta below this size are absolute, N·m or N·m·s.
const SMALL: f64 = 10.0;

impl Worst {
    fn compare(&mut self, found: f64, expected: f64) {
        self.see(found - expected, expected.abs().max(SMALL));
    }
}

#[test]
fn momentum_is_that_of_the_points() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, dq, ddq| {
        let [momentum, _, _] = by_columns(tree, q, dq, ddq);
        for (found, row) in momentum.iter().zip(tree.mass_matrix(q)) {
            worst.compare(*found, inner(&row, dq));
        }
    });
    worst.assert_below(1e-13, "momentum");
}

#[test]
fn sums_of_momentum_and_rest_are_those_of_the_columns() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, dq, ddq| {
        let [momentum, rest, _] = by_columns(tree, q, dq, ddq);
        let sums = by_sums(tree, q, dq);
        for (found, expected) in sums.iter().zip([momentum, rest]) {
            for (found, expected) in found.iter().zip(expected) {
                worst.compare(*found, expected);
            }
        }
    });
    worst.assert_below(1e-13, "sums");
}

#[test]
fn momentum_has_a_symmetric_and_positive_mass_matrix() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, _, ddq| {
        let n = q.len();
        let unit = |i: usize| -> Vec<f64> { (0..n).map(|k| f64::from(u8::from(k == i))).collect() };
        let m: Vec<Vec<f64>> = (0..n)
            .map(|i| by_columns(tree, q, &unit(i), ddq)[0].clone())
            .collect();
        for (i, row) in m.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                worst.compare(*entry, m[j][i]);
            }
        }
        // The kinetic energy is positive for any velocity.
        let energy = inner(ddq, &by_columns(tree, q, ddq, ddq)[0]);
        assert!(energy > 0.0);
    });
    worst.assert_below(1e-13, "symmetry");
}

#[test]
fn composite_mass_matrix_is_symmetric_positive_and_that_of_the_points() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, _, ddq| {
        let n = q.len();
        let m = matrix_of(tree, q);
        for (i, row) in tree.mass_matrix(q).iter().enumerate() {
            for (j, expected) in row.iter().enumerate() {
                worst.compare(m[i * n + j], *expected);
                assert_eq!(m[i * n + j].to_bits(), m[j * n + i].to_bits());
            }
        }
        // A Cholesky factor exists only if the matrix is positive definite.
        let mut force: Vec<f64> = m.chunks(n).map(|row| inner(row, ddq)).collect();
        let mut factors = m.clone();
        assert!(factor(&mut factors, n));
        solve(&factors, &mut force);
        for (found, expected) in force.iter().zip(ddq) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    });
    worst.assert_below(1e-13, "mass matrix");
}

#[test]
fn rest_is_the_slope_of_the_lagrangian() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, dq, ddq| {
        let [_, rest, _] = by_columns(tree, q, dq, ddq);
        for (i, found) in rest.iter().enumerate() {
            let lagrangian = |t: f64| {
                let mut q = q.to_vec();
                q[i] += t;
                tree.kinetic(&q, dq) - tree.potential(&q)
            };
            worst.compare(*found, -slope(2e-3, lagrangian));
        }
    });
    worst.assert_below(ROUNDINGS * slope_rounding(2e-3), "rest");
}

#[test]
fn torque_is_the_rate_of_momentum_plus_rest() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, dq, ddq| {
        let [_, rest, torque] = by_columns(tree, q, dq, ddq);
        for i in 0..q.len() {
            let momentum = |t: f64| {
                let at = moved(&moved(q, dq, t), ddq, 0.5 * t * t);
                by_columns(tree, &at, &moved(dq, ddq, t), ddq)[0][i]
            };
            worst.compare(torque[i], slope(1e-3, momentum) + rest[i]);
        }
    });
    worst.assert_below(ROUNDINGS * slope_rounding(1e-3), "torque");
}

#[test]
fn columns_times_parameters_are_the_recursion() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, dq, ddq| {
        let [_, _, torque] = by_columns(tree, q, dq, ddq);
        for (found, expected) in by_recursion(tree, [q, dq, ddq]).iter().zip(torque) {
            worst.compare(*found, expected);
        }
    });
    worst.assert_below(1e-13, "recursion");
}

#[test]
fn power_goes_into_energy() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, dq, ddq| {
        let [_, _, torque] = by_columns(tree, q, dq, ddq);
        let energy = |t: f64| {
            let at = moved(&moved(q, dq, t), ddq, 0.5 * t * t);
            tree.kinetic(&at, &moved(dq, ddq, t)) + tree.potential(&at)
        };
        let rate = slope(1e-3, energy);
        worst.compare(inner(dq, &torque), rate);
        worst.compare(inner(dq, &by_recursion(tree, [q, dq, ddq])), rate);
    });
    worst.assert_below(ROUNDINGS * slope_rounding(1e-3), "power");
}

#[test]
fn mass_rate_minus_twice_the_coriolis_matrix_takes_no_power() {
    let mut worst = Worst::default();
    for_random_trees(|tree, q, dq, _| {
        let rest = vec![0.0; q.len()];
        let gravity = by_recursion(tree, [q, &rest, &rest]);
        let turning = by_recursion(tree, [q, dq, &rest]);
        // Rate of the kinetic energy of the point masses at constant joint velocity.
        let rate = slope(1e-3, |t| tree.kinetic(&moved(q, dq, t), dq));
        worst.compare(inner(dq, &turning) - inner(dq, &gravity), rate);
        for (i, found) in gravity.iter().enumerate() {
            let potential = |t: f64| {
                let mut q = q.to_vec();
                q[i] += t;
                tree.potential(&q)
            };
            worst.compare(*found, slope(2e-3, potential));
        }
    });
    worst.assert_below(ROUNDINGS * slope_rounding(1e-3), "Coriolis and gravity");
}

#[test]
fn series_of_torques_are_their_time_derivatives() {
    let [mut first, mut second] = [(); 2].map(|()| Worst::default());
    let mut random = Random::new(12);
    for n in 1..=12 {
        let tree = Tree::draw(&mut random, n);
        let waves = Waves::draw(&mut random, n, 1.5);
        let at = |t: f64| {
            let d = waves.at(t);
            let of_order = |order: usize| -> Vec<f64> { d.iter().map(|d| d[order]).collect() };
            by_recursion(&tree, [&of_order(0), &of_order(1), &of_order(2)])
        };
        let series = |order: usize| -> Vec<Jet<3>> {
            let derivatives = |d: &[f64; 5]| Jet::from_derivatives([0, 1, 2].map(|k| d[order + k]));
            waves.at(0.0).iter().map(derivatives).collect()
        };
        let tau = by_recursion(&tree, [&series(0), &series(1), &series(2)]);
        for (i, tau) in tau.iter().enumerate() {
            let value = at(0.0)[i];
            assert!((tau.derivative(0) - value).abs() < 1e-13 * value.abs().max(SMALL));
            first.compare(tau.derivative(1), slope(2e-3, |t| at(t)[i]));
            let rate = |t: f64| slope(5e-3, |s| at(t + s)[i]);
            second.compare(tau.derivative(2), slope(5e-3, rate));
        }
    }
    first.assert_below(ROUNDINGS * slope_rounding(2e-3), "first derivative");
    // A difference of differences.
    let limit = ROUNDINGS * slope_rounding(5e-3).powi(2) / f64::EPSILON;
    second.assert_below(limit, "second derivative");
}

#[test]
fn wrong_trees_and_lengths_are_refused() {
    let mut tree = Tree::draw(&mut Random::new(1), 3);
    tree.joints[1].parent = Some(2);
    assert_eq!(
        Chain::new(&tree.joints, GRAVITY).unwrap_err(),
        ChainError::Order {
            joint: 1,
            parent: 2
        }
    );
    tree.joints[1].parent = Some(0);
    for axis in [[0.0; 3], [0.0, 1.0, 0.1], [f64::NAN; 3]] {
        tree.joints[2].axis = axis;
        assert_eq!(
            Chain::new(&tree.joints, GRAVITY).unwrap_err(),
            ChainError::Axis { joint: 2 }
        );
    }
    tree.joints[2].axis = [0.0, 1.0, 0.0];
    let chain = tree.chain();
    let expect = |what: &'static str, expected: usize, found: usize| LengthError {
        what,
        expected,
        found,
    };
    let mut memory = Memory::new(3);
    let mut columns = [0.0; 9 * BODY];
    let [q, dq] = [[0.0; 3]; 2];
    let workspace = &mut memory.workspace();
    let short = torque(&chain, &q, &dq, &[0.0; 2], workspace, &mut columns);
    assert_eq!(short.unwrap_err(), expect("ddq", 3, 2));

    let bodies = tree.bodies();
    let mut steps = [Step::default(); 2];
    let short = inverse_dynamics(&chain, &bodies, &q, &dq, &dq, &mut steps, &mut [0.0; 3]);
    assert_eq!(short.unwrap_err(), expect("steps", 3, 2));
    let into = [&mut [0.0; 3][..], &mut [0.0; 3][..]];
    let short = momentum_and_rest(&chain, &bodies, [&q, &dq], &mut steps, into);
    assert_eq!(short.unwrap_err(), expect("steps", 3, 2));
    let short = mass_matrix(&chain, &bodies, &q, workspace.steps, &mut [0.0; 8]);
    assert_eq!(short.unwrap_err(), expect("matrix", 9, 8));
}
