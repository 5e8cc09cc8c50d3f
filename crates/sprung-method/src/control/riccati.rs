//! The discrete algebraic Riccati equation.

use faer::Mat;
use faer::linalg::solvers::Solve;

/// Most doublings; each squares the transition, so 60 of them leave no stable one.
const DOUBLINGS: usize = 60;

/// Relative change at which the solution counts as found.
const FOUND: f64 = 1e-12;

/// Returns the gain `K` with which the torques `u = -K x` minimise the sum of `xᵀ Q x + uᵀ R u` for `x' = A x + B u`; `None` if
/// no gain keeps the sum finite.
///
/// - `transition`: A, \[m × m\]; `input`: B, \[m × n\].
/// - `state`: diagonal of Q, \[m\]; `torque`: diagonal of R, positive, \[n\].
///
/// # Source
///
/// Chu, Fan, Lin and Wang, "Structure-preserving algorithms for periodic discrete-time algebraic Riccati equations", Int. J.
/// Control 77, 2004: the doubling algorithm.
pub(super) fn gain(
    transition: &Mat<f64>,
    input: &Mat<f64>,
    state: &[f64],
    torque: &[f64],
) -> Option<Mat<f64>> {
    let (m, n) = (transition.nrows(), input.ncols());
    let scaled = Mat::from_fn(m, n, |i, k| input[(i, k)] / torque[k].sqrt());
    let mut a = transition.clone();
    let mut g = &scaled * scaled.transpose();
    let mut h = Mat::from_fn(m, m, |i, j| if i == j { state[i] } else { 0.0 });
    for _ in 0..DOUBLINGS {
        let inner = (Mat::<f64>::identity(m, m) + &g * &h).partial_piv_lu();
        let solved = inner.solve(&a);
        let of_g = inner.solve(&g);
        let added = a.transpose() * &h * &solved;
        let next_g = &g + &a * of_g * a.transpose();
        let next_h = &h + &added;
        a = &a * &solved;
        g = (&next_g + next_g.transpose()) * faer::Scale(0.5);
        h = (&next_h + next_h.transpose()) * faer::Scale(0.5);
        let (size, change) = (h.norm_l2(), added.norm_l2());
        if !size.is_finite() {
            return None;
        }
        if change <= FOUND * size {
            let product = input.transpose() * &h;
            let weighted = &product * input;
            let inner = Mat::from_fn(n, n, |i, k| {
                weighted[(i, k)] + if i == k { torque[i] } else { 0.0 }
            });
            return Some(inner.partial_piv_lu().solve(product * transition));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gain_of_a_double_integrator_has_the_known_poles() {
        // With cost w⁴ q² + u² and small periods, the poles have the rate w and the damping 1/√2.
        let (period, rate) = (1e-4, 20.0_f64);
        let a = Mat::from_fn(2, 2, |i, j| [[1.0, period], [0.0, 1.0]][i][j]);
        let b = Mat::from_fn(2, 1, |i, _| [0.5 * period * period, period][i]);
        let gain = gain(&a, &b, &[rate.powi(4), 0.0], &[1.0]).unwrap();
        assert!((gain[(0, 0)] / rate.powi(2) - 1.0).abs() < 5e-3);
        assert!((gain[(0, 1)] / (rate * 2.0_f64.sqrt()) - 1.0).abs() < 5e-3);
    }

    #[test]
    fn the_gain_solves_the_equation_and_an_unreachable_growth_has_none() {
        let a = Mat::from_fn(2, 2, |i, j| [[1.2, 0.3], [0.0, 0.8]][i][j]);
        let b = Mat::from_fn(2, 1, |i, _| [0.4, 0.1][i]);
        let (q, r) = ([1.0, 2.0], [0.5]);
        let k = gain(&a, &b, &q, &r).unwrap();
        // The cost of a start under the gain equals that of one step and the rest: compare with nearby gains.
        let cost = |k: &Mat<f64>| {
            let closed = &a - &b * k;
            let (mut sum, mut x) = (0.0, Mat::from_fn(2, 1, |i, _| [1.0, -0.7][i]));
            for _ in 0..2000 {
                let u = -(k * &x)[(0, 0)];
                sum += q[0] * x[(0, 0)].powi(2) + q[1] * x[(1, 0)].powi(2) + r[0] * u * u;
                x = &closed * &x;
            }
            sum
        };
        let least = cost(&k);
        for (i, step) in [(0, 1e-3), (0, -1e-3), (1, 1e-3), (1, -1e-3)] {
            let mut other = k.clone();
            other[(0, i)] += step;
            assert!(cost(&other) > least);
        }
        let none = Mat::from_fn(2, 1, |i, _| [0.0, 0.1][i]);
        let apart = Mat::from_fn(2, 2, |i, j| [[1.2, 0.0], [0.0, 0.8]][i][j]);
        assert!(super::gain(&apart, &none, &q, &r).is_none());
    }
}
