//! Columns that are added to the rows of a regression beyond those of the model.

use sprung_core::drives::{State, Term};
use sprung_core::friction::Shape;

use crate::model::Model;
use crate::preprocess::SignalBlock;

/// A column that is added to one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Probe {
    /// A term of a drive with its own shape of the friction laws. Its row and gain are used; its
    /// entry and its column are not.
    Term(Term, Shape),
    /// The rate of change of the row's right-hand side, over the last sampling period. Its parameter is the time in s
    /// by which the torque acts later than logged.
    TorqueRate {
        /// The row.
        row: usize,
    },
    /// The measured torque of a joint's spring.
    SpringTorque {
        /// The row.
        row: usize,
        /// The joint.
        joint: usize,
    },
    /// The third power of a joint's motor torque. Its parameter is that of a torque which saturates.
    TorqueCube {
        /// The row.
        row: usize,
        /// The joint.
        joint: usize,
    },
}

impl Probe {
    /// Returns the row.
    pub(crate) fn row(&self) -> usize {
        match self {
            Self::Term(term, _) => term.row,
            Self::TorqueRate { row }
            | Self::SpringTorque { row, .. }
            | Self::TorqueCube { row, .. } => *row,
        }
    }

    /// Returns the column at one sample, before it is filtered; zero for a column that follows from
    /// the filtered right-hand side.
    pub(super) fn column(
        &self,
        model: &Model,
        state: &State<'_>,
        signals: &SignalBlock,
        k: usize,
    ) -> f64 {
        match self {
            Self::Term(term, shape) => {
                let drive = model.robot().drive(state, term.joint);
                term.rest(&drive, shape)
            }
            Self::TorqueRate { .. } => 0.0,
            Self::TorqueCube { joint, .. } => signals.tau[*joint][k].powi(3),
            Self::SpringTorque { joint, .. } => {
                signals.spring[*joint].get(k).copied().unwrap_or_default()
            }
        }
    }
}
