//! Torques and mass matrix of a tree of bodies.
//!
//! The momentum of a body is the same bilinear form as the regressor's columns: its component along
//! a motion is the kernel of both motions times the inertial parameters. A simulation needs only
//! the products with the parameters, summed from the tips to the base. This takes a tenth of the
//! operations of the columns.

use crate::chain::{Chain, ChainJoint, Motions};
use crate::links::{LengthError, Step, Workspace, lengths};
use crate::scalar::Scalar;
use crate::space::{Planar, Space, Spatial};
use crate::spatial::{BODY, Force, Motion};

/// Computes the joint torques of a given motion of the links.
///
/// - `bodies`: inertial parameters of the links, \[n\].
/// - `q`, `dq`, `ddq`: link positions, velocities and accelerations, \[n\].
/// - `steps`: scratch memory, \[n\].
/// - `tau`: `M(q) ddq + C(q, dq) dq + g(q)`, \[n\], N·m (N).
///
/// With numbers of type [`Jet`](crate::scalar::Jet), the result also contains the time derivatives
/// of the torques.
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
    match chain.motions() {
        Motions::InPlane => {
            place::<Planar, S>(chain, q, steps);
            torques::<Planar, S>(chain, bodies, [dq, ddq], steps, tau);
        }
        Motions::InSpace => {
            place::<Spatial, S>(chain, q, steps);
            torques::<Spatial, S>(chain, bodies, [dq, ddq], steps, tau);
        }
    }
    Ok(())
}

/// Computes the generalised momenta of the links, and what the joint torques have beside their rates.
///
/// - `bodies`: inertial parameters of the links, \[n\].
/// - `q`, `dq`: link positions and velocities, \[n\], rad (m) and rad/s (m/s).
/// - `steps`: scratch memory, \[n\].
/// - `momentum`: `M(q) dq`, \[n\]; `rest`: `-dT/dq + g(q)` with the kinetic energy `T`, \[n\]. These are the products of
///   the columns of [`regressor`](crate::links::regressor) with the bodies.
///
/// # Errors
///
/// [`LengthError`] if a slice does not fit the chain.
pub fn momentum_and_rest(
    chain: &Chain<'_>,
    bodies: &[[f64; BODY]],
    [q, dq]: [&[f64]; 2],
    steps: &mut [Step],
    [momentum, rest]: [&mut [f64]; 2],
) -> Result<(), LengthError> {
    let n = chain.joints().len();
    lengths(
        &[
            ("bodies", bodies.len()),
            ("q", q.len()),
            ("dq", dq.len()),
            ("steps", steps.len()),
            ("momentum", momentum.len()),
            ("rest", rest.len()),
        ],
        n,
    )?;
    match chain.motions() {
        Motions::InPlane => {
            place::<Planar, f64>(chain, q, steps);
            momenta::<Planar>(chain, bodies, dq, steps, [momentum, rest]);
        }
        Motions::InSpace => {
            place::<Spatial, f64>(chain, q, steps);
            momenta::<Spatial>(chain, bodies, dq, steps, [momentum, rest]);
        }
    }
    Ok(())
}

/// Computes the mass matrix of the links.
///
/// - `bodies`: inertial parameters of the links, \[n\]; `q`: \[n\], rad (m).
/// - `steps`: scratch memory, \[n\].
/// - `matrix`: `M(q)`, \[n × n\], row by row.
///
/// # Errors
///
/// [`LengthError`] if a slice does not fit the chain.
///
/// # Source
///
/// Featherstone, Table 6.2: the composite rigid body algorithm.
pub fn mass_matrix<S: Scalar>(
    chain: &Chain<'_>,
    bodies: &[[f64; BODY]],
    q: &[S],
    steps: &mut [Step<S>],
    matrix: &mut [S],
) -> Result<(), LengthError> {
    let n = chain.joints().len();
    let given = [
        ("bodies", bodies.len()),
        ("q", q.len()),
        ("steps", steps.len()),
    ];
    lengths(&given, n)?;
    lengths(&[("matrix", matrix.len())], n * n)?;
    matrix.fill(S::ZERO);
    match chain.motions() {
        Motions::InPlane => {
            place::<Planar, S>(chain, q, steps);
            masses::<Planar, S>(chain, bodies, steps, n, matrix);
        }
        Motions::InSpace => {
            place::<Spatial, S>(chain, q, steps);
            masses::<Spatial, S>(chain, bodies, steps, n, matrix);
        }
    }
    Ok(())
}

/// Computes the joint torques at zero accelerations and the mass matrix of the links. The caller
/// has checked the lengths of the slices.
///
/// - `width`: numbers in a row of `matrix`; all entries of `matrix` must be zero.
pub(crate) fn bias_and_masses(
    chain: &Chain<'_>,
    bodies: &[[f64; BODY]],
    [q, dq, zeros]: [&[f64]; 3],
    workspace: &mut Workspace<'_>,
    tau: &mut [f64],
    width: usize,
    matrix: &mut [f64],
) {
    match chain.motions() {
        Motions::InPlane => {
            place::<Planar, f64>(chain, q, workspace.steps);
            torques::<Planar, f64>(chain, bodies, [dq, zeros], workspace.steps, tau);
            masses::<Planar, f64>(chain, bodies, workspace.steps, width, matrix);
        }
        Motions::InSpace => {
            place::<Spatial, f64>(chain, q, workspace.steps);
            torques::<Spatial, f64>(chain, bodies, [dq, zeros], workspace.steps, tau);
            masses::<Spatial, f64>(chain, bodies, workspace.steps, width, matrix);
        }
    }
}

/// Writes the transforms of all joints into `steps`.
fn place<P: Space, S: Scalar>(chain: &Chain<'_>, q: &[S], steps: &mut [Step<S>]) {
    let weightless = chain.base_acceleration().is_none();
    for ((joint, q), step) in chain.joints().iter().zip(q).zip(steps) {
        // Without gravity, the torques do not depend on the position of a link on the base.
        if joint.parent.is_some() || !weightless {
            step.transform = P::transform(joint, *q);
        }
    }
}

/// Computes the joint torques of a motion; `steps` contains the transforms.
fn torques<P: Space, S: Scalar>(
    chain: &Chain<'_>,
    bodies: &[[f64; BODY]],
    [dq, ddq]: [&[S]; 2],
    steps: &mut [Step<S>],
    tau: &mut [S],
) {
    let base = chain.base_acceleration();
    for (j, joint) in chain.joints().iter().enumerate() {
        let (done, rest) = steps.split_at_mut(j);
        let step = &mut rest[0];
        let [mut velocity, mut acceleration] = [Motion::default(); 2];
        match (joint.parent, &base) {
            (Some(parent), _) => {
                velocity = P::apply(&step.transform, &done[parent].velocity);
                acceleration = P::apply(&step.transform, &done[parent].acceleration);
            }
            (None, Some(base)) => {
                acceleration = P::apply(&step.transform, &Motion::constant(base));
            }
            (None, None) => {}
        }
        P::add_along(joint, dq[j], &mut velocity);
        P::add_along(joint, ddq[j], &mut acceleration);
        P::add_times(&P::axis_rate(&velocity, joint), dq[j], &mut acceleration);
        step.force = P::force(&bodies[j], &velocity, &acceleration);
        (step.velocity, step.acceleration) = (velocity, acceleration);
    }
    gather::<P, S>(chain, steps, |j, joint, step| {
        tau[j] = P::along(joint, &step.force);
    });
}

/// Computes momenta and the rest of the torques; `steps` contains the transforms.
fn momenta<P: Space>(
    chain: &Chain<'_>,
    bodies: &[[f64; BODY]],
    dq: &[f64],
    steps: &mut [Step],
    [momentum, rest]: [&mut [f64]; 2],
) {
    let base = chain.base_acceleration();
    for (j, joint) in chain.joints().iter().enumerate() {
        let (done, steps) = steps.split_at_mut(j);
        let step = &mut steps[0];
        let [mut velocity, mut gravity] = [Motion::default(); 2];
        match (joint.parent, &base) {
            (Some(parent), _) => {
                velocity = P::apply(&step.transform, &done[parent].velocity);
                gravity = P::apply(&step.transform, &done[parent].acceleration);
            }
            (None, Some(base)) => gravity = P::apply(&step.transform, &Motion::constant(base)),
            (None, None) => {}
        }
        P::add_along(joint, dq[j], &mut velocity);
        (step.velocity, step.acceleration) = (velocity, gravity);
    }
    let still = Motion::default();
    for (step, body) in steps.iter_mut().zip(bodies) {
        step.force = P::force(body, &still, &step.velocity);
    }
    gather::<P, f64>(chain, steps, |j, joint, step| {
        momentum[j] = P::along(joint, &step.force);
        rest[j] = -P::axis_rate(&step.velocity, joint).power(&step.force);
    });
    if base.is_some() {
        for (step, body) in steps.iter_mut().zip(bodies) {
            step.force = P::force(body, &still, &step.acceleration);
        }
        gather::<P, f64>(chain, steps, |j, joint, step| {
            rest[j] += P::along(joint, &step.force);
        });
    }
}

/// Sums the forces of the bodies from the tips to the base; visits each joint with the sum that it carries.
fn gather<P: Space, S: Scalar>(
    chain: &Chain<'_>,
    steps: &mut [Step<S>],
    mut visit: impl FnMut(usize, &ChainJoint, &Step<S>),
) {
    for (j, joint) in chain.joints().iter().enumerate().rev() {
        let (done, rest) = steps.split_at_mut(j);
        let step = &rest[0];
        visit(j, joint, step);
        if let Some(parent) = joint.parent {
            P::add_back(&step.transform, &step.force, &mut done[parent].force);
        }
    }
}

/// Computes the mass matrix; `steps` contains the transforms.
fn masses<P: Space, S: Scalar>(
    chain: &Chain<'_>,
    bodies: &[[f64; BODY]],
    steps: &mut [Step<S>],
    width: usize,
    matrix: &mut [S],
) {
    for (step, body) in steps.iter_mut().zip(bodies) {
        step.composite = body.map(S::constant);
    }
    for (j, joint) in chain.joints().iter().enumerate().rev() {
        let (done, rest) = steps.split_at_mut(j);
        let step = &rest[0];
        if let Some(parent) = joint.parent {
            P::add_body_back(
                &step.transform,
                &step.composite,
                &mut done[parent].composite,
            );
        }
        let mut force = P::momentum_along(&step.composite, joint);
        matrix[j * width + j] = P::along(joint, &force);
        let mut at = j;
        while let Some(i) = chain.joints()[at].parent {
            let mut carried = Force::default();
            P::add_back(&steps[at].transform, &force, &mut carried);
            force = carried;
            let entry = P::along(&chain.joints()[i], &force);
            matrix[i * width + j] = entry;
            matrix[j * width + i] = entry;
            at = i;
        }
    }
}
