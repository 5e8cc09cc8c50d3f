//! Link columns of any tree of joints, for one sample at a time.
//!
//! Row `i` has columns of link `j` only if joint `i` carries link `j`. The axis of joint `i` and
//! its rate are transformed to the frame of link `j`. Every column is the kernel at a pair of
//! motions.

use crate::chain::{Chain, ChainJoint, Motions};
use crate::scalar::Scalar;
use crate::space::{Planar, Space, Spatial};
use crate::spatial::{BODY, Force, Motion, Transform};

/// Scratch memory for one joint.
#[derive(Clone, Copy, Debug)]
pub struct JointScratch<S = f64> {
    velocity: Motion<S>,
    acceleration: Motion<S>,
    gravity: Motion<S>,
}

impl<S: Scalar> Default for JointScratch<S> {
    fn default() -> Self {
        Self {
            velocity: Motion::default(),
            acceleration: Motion::default(),
            gravity: Motion::default(),
        }
    }
}

/// Scratch memory for a pair of a joint and a link that it carries.
#[derive(Clone, Copy, Debug)]
pub struct PairScratch<S = f64> {
    axis: Motion<S>,
    axis_rate: Motion<S>,
}

impl<S: Scalar> Default for PairScratch<S> {
    fn default() -> Self {
        Self {
            axis: Motion::default(),
            axis_rate: Motion::default(),
        }
    }
}

/// Scratch memory of the recursive dynamics for one joint.
#[derive(Clone, Copy, Debug)]
pub struct Step<S = f64> {
    pub(crate) transform: Transform<S>,
    pub(crate) velocity: Motion<S>,
    pub(crate) acceleration: Motion<S>,
    pub(crate) force: Force<S>,
    pub(crate) composite: [S; BODY],
}

impl<S: Scalar> Default for Step<S> {
    fn default() -> Self {
        Self {
            transform: Transform::default(),
            velocity: Motion::default(),
            acceleration: Motion::default(),
            force: Force::default(),
            composite: [S::ZERO; BODY],
        }
    }
}

/// Scratch memory, owned by the caller.
#[derive(Debug)]
pub struct Workspace<'w, S = f64> {
    /// One entry per joint.
    pub joints: &'w mut [JointScratch<S>],
    /// One entry per joint.
    pub steps: &'w mut [Step<S>],
    /// One entry per pair of joints, \[n²\].
    pub pairs: &'w mut [PairScratch<S>],
    /// Numbers of the dynamics; [`numbers_len`] returns how many.
    pub numbers: &'w mut [S],
}

/// Returns the length of `numbers` in a [`Workspace`] for `joints` joints.
#[must_use]
pub const fn numbers_len(joints: usize) -> usize {
    // A mass matrix of 2n coordinates, and 4n numbers of vectors.
    4 * joints * (joints + 1)
}

/// Parts of the numbers of a [`Workspace`].
pub(crate) struct Parts<'p> {
    /// Mass matrix of all coordinates, or its factors; at most \[(2n)²\].
    pub(crate) masses: &'p mut [f64],
    /// One number for each motor, \[n\].
    pub(crate) motors: &'p mut [f64],
    /// One number for each coordinate; at most \[2n\].
    pub(crate) vector: &'p mut [f64],
    /// One number for each joint, \[n\].
    pub(crate) more: &'p mut [f64],
}

impl<'p> Parts<'p> {
    pub(crate) fn new(numbers: &'p mut [f64], joints: usize) -> Self {
        let (masses, rest) = numbers.split_at_mut(4 * joints * joints);
        let (motors, rest) = rest.split_at_mut(joints);
        let (vector, more) = rest.split_at_mut(2 * joints);
        Self {
            masses,
            motors,
            vector,
            more,
        }
    }
}

impl Workspace<'_, f64> {
    /// Splits the numbers into parts; the caller has checked their lengths.
    pub(crate) fn parts(&mut self) -> Parts<'_> {
        Parts::new(self.numbers, self.joints.len())
    }
}

/// A slice has the wrong length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LengthError {
    /// Name of the slice.
    pub what: &'static str,
    /// Required length.
    pub expected: usize,
    /// Length of the given slice.
    pub found: usize,
}

impl core::fmt::Display for LengthError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            what,
            expected,
            found,
        } = self;
        write!(f, "{what} has {found} entries, {expected} are needed")
    }
}

impl core::error::Error for LengthError {}

/// Visits the columns of the filtered regression, for every pair of a joint and a link that it
/// carries. All other columns are zero.
///
/// - `q`, `dq`: link positions and velocities, \[n\], rad (m) and rad/s (m/s).
/// - `visit`: called with joint `i`, link `j` and two rows of \[10\], the momentum and the rest.
///   Times the inertial parameters, the momentum gives `M(q) dq`, and the rest gives
///   `-dT/dq + g(q)`, where `T` is the kinetic energy. `d/dt(momentum) + rest` is the joint torque.
///
/// No Coriolis matrix and no derivative of the mass matrix is needed: the derivative of a link's
/// velocity by `q_i` is `v_i × s_i`, transformed to the frame of the link.
///
/// # Errors
///
/// [`LengthError`] if a slice does not fit the chain.
pub(crate) fn columns(
    chain: &Chain<'_>,
    q: &[f64],
    dq: &[f64],
    workspace: &mut Workspace<'_>,
    visit: impl FnMut(usize, usize, &[f64; BODY], &[f64; BODY]),
) -> Result<(), LengthError> {
    let n = chain.joints().len();
    check(n, &[("q", q.len()), ("dq", dq.len())], workspace)?;
    match chain.motions() {
        Motions::InPlane => visit_columns::<Planar>(chain, q, dq, workspace, visit),
        Motions::InSpace => visit_columns::<Spatial>(chain, q, dq, workspace, visit),
    }
    Ok(())
}

fn visit_columns<P: Space>(
    chain: &Chain<'_>,
    q: &[f64],
    dq: &[f64],
    workspace: &mut Workspace<'_>,
    mut visit: impl FnMut(usize, usize, &[f64; BODY], &[f64; BODY]),
) {
    move_all::<P, f64>(chain, q, dq, None, workspace);
    let heavy = chain.base_acceleration().is_some();
    let [mut momentum, mut energy, mut rest] = [[0.0; BODY]; 3];
    for_pairs(chain, workspace, |i, j, pair, link| {
        P::kernel(&pair.axis, &link.velocity, &mut momentum);
        P::kernel(&pair.axis_rate, &link.velocity, &mut energy);
        if heavy {
            P::kernel(&pair.axis, &link.gravity, &mut rest);
            for &k in P::SHOWN {
                rest[k] -= energy[k];
            }
        } else {
            for &k in P::SHOWN {
                rest[k] = -energy[k];
            }
        }
        visit(i, j, &momentum, &rest);
    });
}

/// Writes the columns of the filtered regression of all links, zeros included.
///
/// - `momentum`, `rest`: \[n × 10n\], row by row. Times the inertial parameters, `momentum` gives
///   `M(q) dq`, and `d/dt(momentum) + rest` gives the joint torque.
///
/// # Errors
///
/// [`LengthError`] if a slice does not fit the chain.
pub fn regressor(
    chain: &Chain<'_>,
    q: &[f64],
    dq: &[f64],
    workspace: &mut Workspace<'_>,
    momentum: &mut [f64],
    rest: &mut [f64],
) -> Result<(), LengthError> {
    let n = chain.joints().len();
    lengths(
        &[("momentum", momentum.len()), ("rest", rest.len())],
        n * n * BODY,
    )?;
    momentum.fill(0.0);
    rest.fill(0.0);
    columns(chain, q, dq, workspace, |i, j, of_momentum, of_rest| {
        let at = (i * n + j) * BODY;
        momentum[at..at + BODY].copy_from_slice(of_momentum);
        rest[at..at + BODY].copy_from_slice(of_rest);
    })
}

/// Writes the columns of the joint torque at given accelerations.
///
/// - `ddq`: link accelerations, \[n\].
/// - `torque`: \[n × 10n\], row by row. Times the inertial parameters it gives
///   `M(q) ddq + C(q, dq) dq + g(q)`.
///
/// # Errors
///
/// [`LengthError`] if a slice does not fit the chain.
pub fn torque<S: Scalar>(
    chain: &Chain<'_>,
    q: &[S],
    dq: &[S],
    ddq: &[S],
    workspace: &mut Workspace<'_, S>,
    torque: &mut [S],
) -> Result<(), LengthError> {
    let n = chain.joints().len();
    lengths(&[("torque", torque.len())], n * n * BODY)?;
    torque.fill(S::ZERO);
    torque_columns(chain, [q, dq, ddq], workspace, |i, j, columns| {
        let at = (i * n + j) * BODY;
        torque[at..at + BODY].copy_from_slice(columns);
    })
}

/// Visits the columns of the joint torque at given accelerations, for every pair of a joint and a
/// link that it carries. All other columns are zero.
///
/// - `motion`: link positions, velocities and accelerations, \[n\] each.
/// - `visit`: called with joint `i`, link `j` and a row of \[10\].
///
/// # Errors
///
/// [`LengthError`] if a slice does not fit the chain.
pub(crate) fn torque_columns<S: Scalar>(
    chain: &Chain<'_>,
    motion: [&[S]; 3],
    workspace: &mut Workspace<'_, S>,
    visit: impl FnMut(usize, usize, &[S; BODY]),
) -> Result<(), LengthError> {
    let n = chain.joints().len();
    let [q, dq, ddq] = motion;
    let given = [("q", q.len()), ("dq", dq.len()), ("ddq", ddq.len())];
    check(n, &given, workspace)?;
    match chain.motions() {
        Motions::InPlane => visit_torque_columns::<Planar, S>(chain, motion, workspace, visit),
        Motions::InSpace => visit_torque_columns::<Spatial, S>(chain, motion, workspace, visit),
    }
    Ok(())
}

fn visit_torque_columns<P: Space, S: Scalar>(
    chain: &Chain<'_>,
    [q, dq, ddq]: [&[S]; 3],
    workspace: &mut Workspace<'_, S>,
    mut visit: impl FnMut(usize, usize, &[S; BODY]),
) {
    move_all::<P, S>(chain, q, dq, Some(ddq), workspace);
    let [mut columns, mut turning] = [[S::ZERO; BODY]; 2];
    for_pairs(chain, workspace, |i, j, pair, link| {
        P::kernel(&pair.axis, &link.acceleration, &mut columns);
        P::kernel(
            &P::cross(&link.velocity, &pair.axis),
            &link.velocity,
            &mut turning,
        );
        for &k in P::SHOWN {
            columns[k] = columns[k] - turning[k];
        }
        visit(i, j, &columns);
    });
}

pub(crate) fn check<S>(
    n: usize,
    given: &[(&'static str, usize)],
    workspace: &Workspace<'_, S>,
) -> Result<(), LengthError> {
    lengths(given, n)?;
    lengths(
        &[
            ("workspace.joints", workspace.joints.len()),
            ("workspace.steps", workspace.steps.len()),
        ],
        n,
    )?;
    lengths(&[("workspace.pairs", workspace.pairs.len())], n * n)?;
    lengths(
        &[("workspace.numbers", workspace.numbers.len())],
        numbers_len(n),
    )
}

pub(crate) fn lengths(given: &[(&'static str, usize)], expected: usize) -> Result<(), LengthError> {
    for &(what, found) in given {
        if found != expected {
            return Err(LengthError {
                what,
                expected,
                found,
            });
        }
    }
    Ok(())
}

/// Computes velocities, accelerations and axes from the base to the tips.
fn move_all<P: Space, S: Scalar>(
    chain: &Chain<'_>,
    q: &[S],
    dq: &[S],
    ddq: Option<&[S]>,
    workspace: &mut Workspace<'_, S>,
) {
    let n = chain.joints().len();
    let base = (chain.base_acceleration()).map(|base| Motion::constant(&base));
    for (j, joint) in chain.joints().iter().enumerate() {
        let (done, rest) = workspace.joints.split_at_mut(j);
        let link = &mut rest[0];
        let [mut velocity, mut acceleration, mut gravity] = [Motion::default(); 3];
        match (joint.parent, &base) {
            (Some(parent), _) => {
                let (parent_link, transform) = (&done[parent], P::transform(joint, q[j]));
                velocity = P::apply(&transform, &parent_link.velocity);
                if ddq.is_some() {
                    acceleration = P::apply(&transform, &parent_link.acceleration);
                } else if base.is_some() {
                    gravity = P::apply(&transform, &parent_link.gravity);
                }
                let mut ancestor = Some(parent);
                while let Some(i) = ancestor {
                    let carried = &workspace.pairs[i * n + parent];
                    workspace.pairs[i * n + j] = PairScratch {
                        axis: P::apply(&transform, &carried.axis),
                        axis_rate: P::apply(&transform, &carried.axis_rate),
                    };
                    ancestor = parent_of(chain.joints(), i);
                }
            }
            (None, Some(base)) => {
                gravity = P::apply(&P::transform(joint, q[j]), base);
                acceleration = gravity;
            }
            // Without gravity, the columns do not depend on the position of a link on the base.
            (None, None) => {}
        }
        P::add_along(joint, dq[j], &mut velocity);
        let axis_rate = P::axis_rate(&velocity, joint);
        if let Some(ddq) = ddq {
            P::add_along(joint, ddq[j], &mut acceleration);
            P::add_times(&axis_rate, dq[j], &mut acceleration);
        }
        (link.velocity, link.acceleration, link.gravity) = (velocity, acceleration, gravity);
        workspace.pairs[j * n + j] = PairScratch {
            axis: Motion::constant(&joint.motion()),
            axis_rate,
        };
    }
}

/// Visits every pair of a link and a joint that carries it.
fn for_pairs<S>(
    chain: &Chain<'_>,
    workspace: &Workspace<'_, S>,
    mut visit: impl FnMut(usize, usize, &PairScratch<S>, &JointScratch<S>),
) {
    let n = chain.joints().len();
    for j in 0..n {
        let mut carrier = Some(j);
        while let Some(i) = carrier {
            visit(i, j, &workspace.pairs[i * n + j], &workspace.joints[j]);
            carrier = parent_of(chain.joints(), i);
        }
    }
}

fn parent_of(joints: &[ChainJoint], joint: usize) -> Option<usize> {
    joints[joint].parent
}
