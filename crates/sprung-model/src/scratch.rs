//! Memory for the equations of one robot.

use sprung_core::links::{JointScratch, PairScratch, Step, Workspace, numbers_len};

/// Owns the memory that a [`Workspace`] borrows.
#[derive(Clone, Debug)]
pub struct Scratch {
    joints: Vec<JointScratch>,
    steps: Vec<Step>,
    pairs: Vec<PairScratch>,
    numbers: Vec<f64>,
}

impl Scratch {
    /// Returns memory for `joints` joints.
    #[must_use]
    pub fn new(joints: usize) -> Self {
        Self {
            joints: vec![JointScratch::default(); joints],
            steps: vec![Step::default(); joints],
            pairs: vec![PairScratch::default(); joints * joints],
            numbers: vec![0.0; numbers_len(joints)],
        }
    }

    /// Returns a workspace that borrows the memory.
    pub fn workspace(&mut self) -> Workspace<'_> {
        Workspace {
            joints: &mut self.joints,
            steps: &mut self.steps,
            pairs: &mut self.pairs,
            numbers: &mut self.numbers,
        }
    }
}
