//! The information of a motion or a log.

use std::collections::BTreeMap;
use std::path::Path;

use sprung_base::progress::Listener;
use sprung_log::LogSource;
use sprung_method::estimate::{KnownTruth, information_bound};
use sprung_method::excite::{Frequencies, Information, Series, information};

use super::task::Setup;
use crate::session::error::SessionError;
use crate::session::excite_error::ExciteError;
use crate::session::load::Session;
use crate::session::parameters::Parameters;

impl Session {
    /// Returns the information of a motion: by the bound of the default estimator, and where that is singular by the
    /// spectra of the search, which `assumed` then states.
    pub(super) fn bought(
        &self,
        setup: &Setup,
        (frequencies, series): (&Frequencies, &Series),
        assumed: &mut Vec<String>,
        progress: &mut dyn Listener,
    ) -> Result<Information, SessionError> {
        let reference = series.reference(&setup.model);
        let session = self.with_experiment(setup.with_motion(reference, frequencies.duration()))?;
        let parameters = Parameters::named("design", setup.named());
        let twin = session.twin(None, Some(&parameters))?;
        let bound = match session.bound(&twin, progress) {
            Err(SessionError::NoBound) => None,
            other => Information::of_bound(&other?),
        };
        if let Some(bound) = bound {
            return Ok(bound);
        }
        assumed.push(
            "the motion tells almost nothing about some combination of parameters, so that the bound of the default estimator \
             has no finite value; standard errors come from the spectra of the search, with little prior knowledge of each \
             parameter"
                .to_owned(),
        );
        let task = setup.task(None, &[]);
        let information = information(&task, frequencies, series);
        information.ok_or_else(|| ExciteError::NoBound.into())
    }

    /// Returns the information of a recorded log at the values of the design.
    pub(super) fn information_of_log(
        &self,
        setup: &Setup,
        file: &Path,
    ) -> Result<Information, SessionError> {
        let name = file.display().to_string();
        let mut open = |_: Option<&Path>| self.files.open(file);
        let mut sources = [LogSource::files(&name, &mut open)];
        setup
            .information_of(&mut sources)?
            .ok_or(SessionError::NoBound)
    }
}

impl Setup {
    /// Returns the information of logs at the values of the design; `None` if they do not determine all parameters.
    pub(super) fn information_of(
        &self,
        sources: &mut [LogSource<'_>],
    ) -> Result<Option<Information>, SessionError> {
        let delays = BTreeMap::new();
        let noise = self.noise();
        let truth = KnownTruth {
            theta: &self.theta,
            noise: &noise,
            delays: &delays,
        };
        let bound = information_bound(&self.experiment, &self.model, truth, sources)?;
        Ok(bound.as_ref().and_then(Information::of_bound))
    }
}
