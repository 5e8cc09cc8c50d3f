//! The paper's planar arm as a tree: 15 parameters in its order.
//!
//! Link 1 has unit length. Its inertia about joint 1 is `theta1 - theta3`. The first moment of link 2 is `theta2`,
//! and its inertia about joint 2 is `theta3`.
use sprung_core::chain::{Chain, ChainJoint, JointKind, Motions};
use sprung_core::drives::Term;
use sprung_core::friction::{Law, Shape};
use sprung_core::parameters::JointParameter::{self, Friction, RotorInertia, Stiffness};
use sprung_core::parameters::Side::{Link, Motor};
use sprung_core::robot::{Links, Robot, Share};
use sprung_core::spatial::BODY;

/// Number of joints.
pub(crate) const JOINTS: usize = 2;

/// Number of parameters.
pub(crate) const PARAMETERS: usize = 15;

/// Number of entries of the regressor that can differ from zero.
pub(crate) const ENTRIES: usize = 19;

const fn joint(parent: Option<usize>, origin: [f64; 3]) -> ChainJoint {
    ChainJoint {
        parent,
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        origin,
        axis: [0.0, 0.0, 1.0],
        kind: JointKind::Revolute,
    }
}

const TREE: [ChainJoint; JOINTS] = [joint(None, [0.0; 3]), joint(Some(0), [1.0, 0.0, 0.0])];

const fn term(row: usize, entry: usize, column: usize, what: JointParameter, gain: f64) -> Term {
    Term {
        row,
        entry,
        column,
        what,
        joint: row % JOINTS,
        gain,
    }
}

const TERMS: [Term; 14] = [
    term(0, 3, 5, Friction(Link, Law::Viscous), 1.0),
    term(0, 4, 9, Stiffness, -1.0),
    term(0, 5, 11, Friction(Link, Law::Coulomb), 1.0),
    term(1, 8, 6, Friction(Link, Law::Viscous), 1.0),
    term(1, 9, 10, Stiffness, -1.0),
    term(1, 10, 12, Friction(Link, Law::Coulomb), 1.0),
    term(2, 11, 3, RotorInertia, 1.0),
    term(2, 12, 7, Friction(Motor, Law::Viscous), 1.0),
    term(2, 13, 9, Stiffness, 1.0),
    term(2, 14, 13, Friction(Motor, Law::Coulomb), 1.0),
    term(3, 15, 4, RotorInertia, 1.0),
    term(3, 16, 8, Friction(Motor, Law::Viscous), 1.0),
    term(3, 17, 10, Stiffness, 1.0),
    term(3, 18, 14, Friction(Motor, Law::Coulomb), 1.0),
];

/// Returns the arm.
pub(crate) fn robot(shapes: &[Shape; JOINTS]) -> Robot<'_> {
    Robot {
        links: Links {
            chain: Chain::checked(&TREE, [0.0; 3], Motions::InPlane),
            // izz of link 1; mx and izz of link 2.
            selected: &[9, 1, 9],
            first: &[0, 1, 3],
            entries: &[0, 1, usize::MAX, 6],
            shares: &[Share {
                entry: 2,
                of: 0,
                factor: -1.0,
            }],
        },
        terms: &TERMS,
        shapes,
        coupling: None,
        motor_rows: &[Some(2), Some(3)],
        entries: ENTRIES,
    }
}

/// Returns the bodies of its links.
pub(crate) fn bodies(theta: &[f64; PARAMETERS]) -> [[f64; BODY]; JOINTS] {
    let mut bodies = [[0.0; BODY]; JOINTS];
    bodies[0][9] = theta[0] - theta[2];
    bodies[1][1] = theta[1];
    bodies[1][9] = theta[2];
    bodies
}
