//! The links' inertial parameters in theta.

use sprung_core::chain::{Chain, ChainError, ChainJoint, JointKind, Motions};
use sprung_core::spatial::BODY;

/// The paper's arm as a tree. The length of link 1 is arbitrary, because theta contains it.
const PLANAR_2R: [ChainJoint; 2] = [
    ChainJoint {
        parent: None,
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        origin: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        kind: JointKind::Revolute,
    },
    ChainJoint {
        parent: Some(0),
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        origin: [1.0, 0.0, 0.0],
        axis: [0.0, 0.0, 1.0],
        kind: JointKind::Revolute,
    },
];

/// Names and units of the link inertial parameters of the paper's arm.
///
/// The rotor of joint 2 is at the tip of link 1 (the paper's Table II puts it elsewhere) and the
/// centre of mass of link 2 is on the link's axis. The parameters are
///
/// - `theta1 = I1 + I2 + m1 l1² + (m2 + m_r2) L1² + m2 l2²`,
/// - `theta2 = m2 L1 l2`,
/// - `theta3 = I2 + m2 l2²`.
pub(super) const PLANAR_2R_NAMES: [(&str, &str); 3] = [
    ("link1.inertia_total", "kg·m²"),
    ("link2.coupling", "kg·m²"),
    ("link2.inertia", "kg·m²"),
];

/// A parameter of theta that also enters another parameter's body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shared {
    /// Index in theta.
    pub(super) parameter: usize,
    /// Index in theta of the other parameter.
    pub(super) of: usize,
    /// Factor of the parameter in the other parameter.
    pub(super) factor: f64,
}

/// Links with their inertial parameters at the beginning of theta.
#[derive(Clone, Debug)]
pub(super) struct Inertial {
    joints: Vec<ChainJoint>,
    /// Acceleration of free fall in the base frame, m/s².
    pub(super) gravity: [f64; 3],
    motions: Motions,
    /// Which of the [`BODY`] parameters each parameter is, link by link.
    pub(super) kinds: Vec<usize>,
    /// Index in theta of each link's first parameter, then the end of the last link's.
    pub(super) first: Vec<usize>,
    pub(super) shared: Vec<Shared>,
}

impl Inertial {
    /// Returns the links of a tree with the selected parameters.
    ///
    /// - `selected`: increasing indices; parameter `k` of link `j` has the index `10 j + k`.
    ///
    /// # Errors
    ///
    /// [`ChainError`] if the joints do not form a tree.
    pub(super) fn of_tree(
        joints: &[ChainJoint],
        gravity: [f64; 3],
        selected: &[usize],
    ) -> Result<Self, ChainError> {
        Ok(Self {
            joints: joints.to_vec(),
            gravity,
            motions: Chain::new(joints, gravity)?.motions(),
            kinds: selected.iter().map(|index| index % BODY).collect(),
            first: (0..=joints.len())
                .map(|j| selected.partition_point(|index| *index < j * BODY))
                .collect(),
            shared: Vec::new(),
        })
    }

    /// Returns the paper's arm: `theta1 - theta3` is `izz` of link 1 about its
    /// joint, `theta2` is `mx` of link 2 and `theta3` its `izz`.
    ///
    /// # Errors
    ///
    /// Never fails, because the arm's joints form a tree.
    pub(super) fn planar_2r() -> Result<Self, ChainError> {
        let (izz, mx) = (9, 1);
        let shared = Shared {
            parameter: 2,
            of: 0,
            factor: -1.0,
        };
        Ok(Self {
            shared: vec![shared],
            ..Self::of_tree(&PLANAR_2R, [0.0; 3], &[izz, BODY + mx, BODY + izz])?
        })
    }

    /// Returns the number of link inertial parameters in theta.
    pub(super) fn len(&self) -> usize {
        self.kinds.len()
    }

    pub(super) fn chain(&self) -> Chain<'_> {
        Chain::checked(&self.joints, self.gravity, self.motions)
    }

    /// Returns whether a joint moves a link.
    pub(super) fn carries(&self, joint: usize, link: usize) -> bool {
        let mut carrier = Some(link);
        while carrier.is_some_and(|carrier| carrier > joint) {
            carrier = carrier.and_then(|carrier| self.joints[carrier].parent);
        }
        carrier == Some(joint)
    }

    /// Returns one body per link, \[n\]; the bodies have the link inertias of theta.
    pub(super) fn bodies(&self, theta: &[f64]) -> Vec<[f64; BODY]> {
        let mut bodies = vec![[0.0; BODY]; self.joints.len()];
        let places = self.first.windows(2).zip(&mut bodies);
        for (range, body) in places {
            for parameter in range[0]..range[1] {
                body[self.kinds[parameter]] = theta[parameter];
            }
        }
        for shared in &self.shared {
            let link = self.first.partition_point(|first| *first <= shared.of) - 1;
            bodies[link][self.kinds[shared.of]] += shared.factor * theta[shared.parameter];
        }
        bodies
    }
}
