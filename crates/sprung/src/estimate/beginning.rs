//! The beginning of the first log, for what is chosen or searched.

use super::prediction_error::refine_delays;
use crate::check::{Delays, Excerpt, excerpt};
use crate::description::Delay;
use crate::log::{Channels, LogError, LogSource};
use crate::progress::Listener;
use crate::regression::{PassError, Reading};

/// The beginning of the first log, read when it is first needed.
pub(super) struct Beginning<'a, 's> {
    pub(super) sources: &'a mut [LogSource<'s>],
    pub(super) excerpt: Option<Excerpt>,
}

impl Beginning<'_, '_> {
    pub(super) fn get(&mut self, channels: &Channels) -> Result<Option<&Excerpt>, LogError> {
        if self.excerpt.is_none() {
            self.excerpt = match self.sources.first_mut() {
                Some(first) => Some(excerpt(channels, first)?),
                None => None,
            };
        }
        Ok(self.excerpt.as_ref())
    }

    /// Asks the likelihood of the logs for delays that are to be estimated.
    pub(super) fn refine_delays(
        &mut self,
        reading: &Reading<'_>,
        delays: &mut Delays,
        progress: &mut dyn Listener,
    ) -> Result<(), PassError> {
        if self.for_delays(reading.channels)?.is_some()
            && let Some(excerpt) = &self.excerpt
        {
            refine_delays(reading, delays, self.sources, excerpt, progress)?;
        }
        delays.settle();
        Ok(())
    }

    /// Returns it if a delay is to be estimated.
    pub(super) fn for_delays(
        &mut self,
        channels: &Channels,
    ) -> Result<Option<&Excerpt>, PassError> {
        let wanted = (channels.all.iter()).any(|c| c.delay == Some(Delay::Estimate));
        if wanted {
            Ok(self.get(channels)?)
        } else {
            Ok(None)
        }
    }
}
