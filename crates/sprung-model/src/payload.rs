//! Payloads at the links of a model.

use sprung_core::spatial::BODY;

use super::{Model, ModelError, Theta};
use crate::description::{Experiment, Payload};

impl Model {
    /// Returns the index of the link that carries a payload.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownParameter`] for an unknown link, [`ModelError::Carries`] for a link some of
    /// whose parameters are given.
    pub fn link_of_payload(&self, payload: &Payload) -> Result<usize, ModelError> {
        let names = self.tree().map_or(&[][..], |tree| &tree.links);
        let link = match &payload.link {
            None => names.len().checked_sub(1),
            Some(name) => names.iter().position(|other| other == name),
        };
        let wanted = payload.link.as_deref().unwrap_or_default();
        let link = link.ok_or_else(|| ModelError::unknown(wanted, names.iter()))?;
        let range = link * BODY..(link + 1) * BODY;
        let given = (self.links()).and_then(|links| {
            let index = links.known.keys().find(|index| range.contains(index))?;
            Some(links.name(*index).to_owned())
        });
        match given {
            Some(parameter) => Err(ModelError::Carries {
                link: names[link].clone(),
                parameter,
            }),
            None => Ok(link),
        }
    }

    /// Returns the change of theta by a known payload, \[p\]; `None` for an unknown payload, or one that
    /// the robot cannot carry.
    #[must_use]
    pub fn change_by_payload(&self, payload: &Payload) -> Option<Theta> {
        let body = payload.known()?;
        let link = self.link_of_payload(payload).ok()?;
        let mut change = vec![0.0; self.parameters().len()];
        for (k, value) in body.iter().enumerate() {
            for (entry, by) in change
                .iter_mut()
                .zip(self.change_by_standard(link * BODY + k))
            {
                *entry += value * by;
            }
        }
        Some(change)
    }

    /// Checks that the links of the robot can carry the payloads of the logs.
    pub(super) fn check_payloads(&self, experiment: &Experiment) -> Result<(), ModelError> {
        let of_runs = (experiment.validate.iter()).filter_map(|run| run.log.as_ref());
        let files =
            (experiment.log.iter().chain(of_runs)).flat_map(|log| log.file.iter().flatten());
        let is_servo = experiment
            .robot
            .joint
            .iter()
            .any(|joint| joint.servo.is_some());
        for payload in files
            .filter_map(|file| file.payload.as_ref())
            .filter(|_| !is_servo)
        {
            self.link_of_payload(payload)?;
        }
        Ok(())
    }
}
