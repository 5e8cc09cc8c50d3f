//! Data for the examination of the joints of a log.

use sprung_core::parameters::JointParameter;

use crate::description::Experiment;
use crate::log::{Quantity, Signal};
use crate::prepare::Excerpt;
use crate::regression::{Reading, Triangle};

/// Standard errors from zero at which a value counts as significant.
pub(super) const SIGNIFICANT_SIGMAS: f64 = 5.0;

/// Data for the examination of the joints of a log.
pub(super) struct CheckContext<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) reading: &'a Reading,
    pub(super) excerpt: &'a Excerpt,
    /// The excerpt with the fewest samples that the filters allow, for trials.
    pub(super) few: Excerpt,
    /// One factor of all samples of the excerpt for each row.
    pub(super) whole: Vec<Triangle>,
    pub(super) file: &'a str,
    pub(super) independent: f64,
}

impl CheckContext<'_> {
    pub(super) fn name(&self, joint: usize) -> &str {
        &self.reading.model().joints()[joint]
    }

    pub(super) fn column(&self, quantities: &[Quantity], joint: usize) -> &str {
        (self.reading.channels().all.iter())
            .find(|c| c.joint == joint && quantities.contains(&c.quantity))
            .map_or("", |c| &c.column)
    }

    pub(super) fn link(&self, joint: usize) -> &str {
        let channels = self.reading.channels();
        let link = channels.telling(Signal::Link, joint);
        link.map_or("", |i| &channels.all[i].column)
    }

    pub(super) fn about_stiffness(&self, joint: usize) -> Option<String> {
        let model = self.reading.model();
        let index = model.index(JointParameter::Stiffness, joint)?;
        Some(model.parameters()[index].name.clone())
    }
}
