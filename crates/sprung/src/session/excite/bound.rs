//! The information that a motion buys for the default estimator.

use sprung_base::progress::Listener;
use sprung_method::excite::Information;
use sprung_method::validate::ParameterSet;
use sprung_robot::Experiment;

use super::task::Setup;
use crate::session::error::SessionError;
use crate::session::excite_error::ExciteError;
use crate::session::load::Session;
use crate::session::parameters::Parameters;

/// Returns the information that the motion of a twin buys, by the bound of the default estimator.
pub(super) fn full(
    session: &Session,
    setup: &Setup,
    experiment: Experiment,
    progress: &mut dyn Listener,
) -> Result<Information, SessionError> {
    let own = session.with_experiment(experiment)?;
    let parameters = Parameters {
        sets: vec![ParameterSet {
            label: "design".to_owned(),
            values: setup.named(),
            promise: Vec::new(),
        }],
        identification: None,
    };
    let twin = own.twin(None, Some(&parameters))?;
    let bound = match own.bound(&twin, progress) {
        Err(SessionError::NoBound) => return Err(ExciteError::NoBound.into()),
        other => other?,
    };
    Information::of_bound(&bound).ok_or_else(|| ExciteError::NoBound.into())
}
