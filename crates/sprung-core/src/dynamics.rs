//! The equations of motion solved for torques and for accelerations.
//!
//! The bodies' momentum is the same bilinear form as the regressor's columns:
//! [`momentum`] times a motion is [`kernel`](crate::spatial::kernel) times the
//! inertial parameters. Summed from the tips to the base it costs a tenth of
//! the columns, which is what a simulation needs.

use crate::chain::{Chain, JointKind};
use crate::links::{LengthError, Step, Workspace, lengths};
use crate::scalar::Scalar;
use crate::spatial::{BODY, Motion, dot, momentum};

/// Writes the joint torques that a motion of the links takes.
///
/// - `bodies`: inertial parameters of the links, \[n\].
/// - `q`, `dq`, `ddq`: link positions, velocities and accelerations, \[n\].
/// - `steps`: scratch memory, \[n\].
/// - `tau`: `M(q) ddq + C(q, dq) dq + g(q)`, \[n\], N·m (N).
///
/// With Taylor series for numbers it gives the torques' time derivatives too.
///
/// # Errors
///
/// [`LengthError`] if a slice does not fit the chain.
///
/// # Source
///
/// Featherstone, Table 5.1: the recursive Newton-Euler algorithm.
pub fn inverse_dynamics<S: Scalar>(
    chain: &Chain<'_>,
    bodies: &[[f64; BODY]],
    q: &[S],
    dq: &[S],
    ddq: &[S],
    steps: &mut [Step<S>],
    tau: &mut [S],
) -> Result<(), LengthError> {
    let n = chain.joints().len();
    lengths(
        &[
            ("bodies", bodies.len()),
            ("q", q.len()),
            ("dq", dq.len()),
            ("ddq", ddq.len()),
            ("steps", steps.len()),
            ("tau", tau.len()),
        ],
        n,
    )?;
    let base = Step {
        acceleration: Motion::constant(&chain.base_acceleration()),
        ..Step::default()
    };
    for (j, joint) in chain.joints().iter().enumerate() {
        let (done, rest) = steps.split_at_mut(j);
        let before = joint.parent.map_or(&base, |parent| &done[parent]);
        let step = &mut rest[0];
        let axis = Motion::constant(&joint.motion());
        let own = axis.times(dq[j]);
        step.transform = joint.transform(q[j]);
        step.velocity = step.transform.apply(&before.velocity).plus(&own);
        step.acceleration = (step.transform.apply(&before.acceleration))
            .plus(&axis.times(ddq[j]))
            .plus(&step.velocity.cross(&own));
        step.force = momentum(&bodies[j], &step.acceleration)
            .plus(&(step.velocity).cross_force(&momentum(&bodies[j], &step.velocity)));
    }
    for (j, joint) in chain.joints().iter().enumerate().rev() {
        let force = steps[j].force;
        let along = match joint.kind {
            JointKind::Revolute => &force.moment,
            JointKind::Prismatic => &force.force,
        };
        tau[j] = dot(along, &joint.axis.map(S::constant));
        if let Some(parent) = joint.parent {
            let carried = steps[j].transform.back(&force);
            steps[parent].force = steps[parent].force.plus(&carried);
        }
    }
    Ok(())
}

/// Writes the mass matrix of the links.
///
/// - `bodies`: inertial parameters of the links, \[n\]; `q`: \[n\], rad (m).
/// - `matrix`: `M(q)`, \[n × n\], row by row.
///
/// # Errors
///
/// [`LengthError`] if a slice does not fit the chain.
///
/// # Source
///
/// Featherstone, Table 6.2: the composite rigid body algorithm.
pub fn mass_matrix(
    chain: &Chain<'_>,
    bodies: &[[f64; BODY]],
    q: &[f64],
    workspace: &mut Workspace<'_>,
    matrix: &mut [f64],
) -> Result<(), LengthError> {
    let n = chain.joints().len();
    lengths(
        &[
            ("bodies", bodies.len()),
            ("q", q.len()),
            ("workspace.joints", workspace.joints.len()),
        ],
        n,
    )?;
    lengths(&[("matrix", matrix.len())], n * n)?;
    let links = &mut *workspace.joints;
    for (j, joint) in chain.joints().iter().enumerate() {
        links[j].transform = joint.transform(q[j]);
        links[j].composite = bodies[j];
    }
    matrix.fill(0.0);
    for (j, joint) in chain.joints().iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            let carried = links[j].transform.back_body(&links[j].composite);
            for (sum, part) in links[parent].composite.iter_mut().zip(carried) {
                *sum += part;
            }
        }
        let axis = joint.motion();
        let mut force = momentum(&links[j].composite, &axis);
        matrix[j * n + j] = axis.power(&force);
        let mut at = j;
        while let Some(i) = chain.joints()[at].parent {
            force = links[at].transform.back(&force);
            let entry = chain.joints()[i].motion().power(&force);
            matrix[i * n + j] = entry;
            matrix[j * n + i] = entry;
            at = i;
        }
    }
    Ok(())
}

/// Solves `A x = b` in place for a symmetric positive definite matrix; `b`
/// holds NaN afterwards if `A` is not one.
///
/// - `a`: \[n × n\], of which the lower triangle is read, overwritten by `L` of
///   `L D L^T`, and `1 / D` on the diagonal; `b`: \[n\].
pub fn solve_positive(a: &mut [f64], b: &mut [f64]) {
    let n = b.len();
    for i in 0..n {
        let (above, row) = a.split_at_mut(i * n);
        let mut pivot = row[i];
        for j in 0..i {
            // Row i holds L D so far: entries behind j are still those of A.
            let known: f64 = (0..j).map(|k| row[k] * above[j * n + k]).sum();
            row[j] -= known;
        }
        for j in 0..i {
            let scaled = row[j] * above[j * n + j];
            pivot -= row[j] * scaled;
            row[j] = scaled;
        }
        row[i] = if pivot > 0.0 { 1.0 / pivot } else { f64::NAN };
    }
    for i in 1..n {
        let known: f64 = (0..i).map(|k| a[i * n + k] * b[k]).sum();
        b[i] -= known;
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| a[k * n + i] * b[k]).sum();
        b[i] = b[i] * a[i * n + i] - known;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_system_is_solved() {
        // A = L D L^T with L = [1 0 0; 1/2 1 0; -1/2 2/3 1] and D = diag(4, 9, 1), and
        // b = A [1 -2 3]^T; the upper triangle is not read.
        let unread = f64::NAN;
        let mut a = [4.0, unread, unread, 2.0, 10.0, unread, -2.0, 5.0, 6.0];
        let mut b = [-6.0, -3.0, 6.0];
        solve_positive(&mut a, &mut b);
        for (found, expected) in b.iter().zip([1.0, -2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-15);
        }
        for (at, expected) in [
            (0, 0.25),
            (3, 0.5),
            (4, 1.0 / 9.0),
            (6, -0.5),
            (7, 2.0 / 3.0),
            (8, 1.0),
        ] {
            assert!((a[at] - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn matrix_that_is_not_positive_has_no_solution() {
        for mut a in [
            [1.0, 2.0, 2.0, 1.0],
            [-1.0, 0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, -1.0],
            [1.0, 1.0, 1.0, 1.0],
            [0.0; 4],
            [f64::NAN, 0.0, 0.0, 1.0],
        ] {
            let mut b = [1.0, 2.0];
            solve_positive(&mut a, &mut b);
            assert!(b.iter().all(|x| x.is_nan()), "{a:?}: {b:?}");
        }
    }
}
