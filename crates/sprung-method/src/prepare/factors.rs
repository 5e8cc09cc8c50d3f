//! Finds the open signs and the open side of the torque constants, before all other choices.

use std::borrow::Cow;

use super::as_given::as_given;
use super::estimated_columns::{FoundGain, FoundSide, FoundSign};
use super::excerpt::{Excerpt, excerpt};
use super::gain::tellable;
use super::sign::signs;
use super::torque_side::torque_side;
use crate::description::{Experiment, Factor, Side};
use crate::finding::{Finding, Severity};
use crate::log::{ChannelError, Channels, LogError, LogSource};
use crate::model::Model;
use crate::numbers::with_error;
use crate::regression::Reading;

/// Errors of the search for signs and gains.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FactorError {
    /// The log does not determine a sign, a gain or the side of the torque constants.
    #[error("{0}")]
    NotTold(String),
    /// The description of the log is not complete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
}

/// Estimated signs and gains, and the side of the torque constants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Factors {
    /// Estimated signs.
    pub signs: Vec<FoundSign>,
    /// Estimated gains.
    pub gains: Vec<FoundGain>,
    /// Side of the torque constants, if the description does not give it.
    pub side: Option<FoundSide>,
}

impl Factors {
    /// Returns findings about the signs, the gains and the side.
    ///
    /// - `file`: name of the log.
    #[must_use]
    pub fn findings(&self, file: &str) -> Vec<Finding> {
        let signs = self.signs.iter().map(|sign| {
            let way = if sign.value < 0.0 {
                "has the opposite direction of the model"
            } else {
                "has the direction of the model"
            };
            let line = format!("sign = {{ \"{}\" = {} }}", sign.column, sign.value);
            Finding::new(
                Severity::Info,
                "sign-estimated",
                format!(
                    "\"{}\" {way} (sign {}): {}; log-likelihood +{:.0} against the other sign",
                    sign.column, sign.value, sign.because, sign.log_likelihood
                ),
                "give the sign as a number to keep it fixed",
            )
            .seen(file, &sign.column, sign.value, "")
            .mended_by("[log]", &line)
        });
        let gains = self.gains.iter().map(|gain| {
            let [value, error] = with_error(gain.value, gain.standard_error);
            let line = format!("gain = {{ \"{}\" = {:.6} }}", gain.column, gain.value);
            Finding::new(
                Severity::Info,
                "gain-estimated",
                format!(
                    "\"{}\" must be multiplied by {value} (standard error {error}): with this gain the equations of the \
                     robot explain the torques best",
                    gain.column
                ),
                "give the gain as a number to keep it fixed; the intervals then take it for exact",
            )
            .seen(file, &gain.column, gain.value, "")
            .mended_by("[log]", &line)
        });
        let side = self.side.iter().map(|found| {
            let (word, column) = (found.side.word(), &found.column);
            Finding::new(
                Severity::Info,
                "torque-side-found",
                format!(
                    "the torque constants hold for the {}, {}",
                    match found.side {
                        Side::Output => "output and contain the gear ratios",
                        Side::Motor => "motors before the gears",
                    },
                    found.because
                ),
                "give torque_constant_side to keep it fixed",
            )
            .seen(file, column, 0.0, "")
            .mended_by(
                "[robot.joint_defaults]",
                &format!("torque_constant_side = \"{word}\""),
            )
        });
        signs.chain(gains).chain(side).collect()
    }

    /// Writes the found values into the description.
    pub(super) fn write_into(&self, experiment: &mut Experiment) {
        let signs = self.signs.iter().map(|s| (s.column.clone(), s.value));
        let gains = self.gains.iter().map(|g| (g.column.clone(), g.value));
        if let Some(log) = &mut experiment.log {
            log.settle(&signs.collect(), &gains.collect());
        }
        if let Some(found) = &self.side {
            experiment.robot.settle_torque_side(found.side);
        }
    }
}

/// Finds the open signs and the side of the torque constants from the beginning of the first log, and checks that it can tell
/// open gains; returns the experiment with what was found, and the estimates.
///
/// The torque equation of a joint decides all its signs together: with the right signs inertia,
/// stiffness and friction are positive and the equation explains the torque. Gains are estimated afterwards, together with all
/// other unknowns of the log.
///
/// # Errors
///
/// [`FactorError`] if the log cannot be read or does not determine one of them; the message
/// gives a remedy.
pub fn find_factors<'a>(
    experiment: &'a Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
) -> Result<(Cow<'a, Experiment>, Factors), FactorError> {
    let unchanged = || Ok((Cow::Borrowed(experiment), Factors::default()));
    let Some(log) = &experiment.log else {
        return unchanged();
    };
    let open = |factors: &std::collections::BTreeMap<String, Factor>| {
        factors.values().any(|factor| *factor == Factor::Estimate)
    };
    let is_side_open = is_side_open(experiment);
    if !open(&log.sign) && !open(&log.gain) && !is_side_open {
        return unchanged();
    }
    let Some(first) = sources.first_mut() else {
        return unchanged();
    };
    let file = first.name.clone();
    let mut now = experiment.clone();
    let mut found = Factors::default();
    let channels = Channels::new(&now.robot, log)?;
    let beginning = excerpt(&channels, first)?;
    if channels.all.iter().any(|channel| channel.open_sign) {
        let reading = reading_while_open(&now, model, &channels, &beginning);
        found.signs = signs(&reading, &beginning, &file).map_err(FactorError::NotTold)?;
        found.write_into(&mut now);
    }
    if is_side_open {
        let settled = Channels::new(&now.robot, now.log.as_ref().unwrap_or(log))?;
        let beginning = excerpt(&settled, first)?;
        let (reading, _) = as_given(model, &now.identify, &settled, &beginning);
        let side = torque_side(&now.robot.joint, &reading, &beginning, &file);
        found.side = Some(side.map_err(FactorError::NotTold)?);
        found.write_into(&mut now);
    }
    for channel in (0..channels.all.len()).filter(|&i| channels.all[i].open_gain) {
        tellable(model, &channels, channel).map_err(FactorError::NotTold)?;
    }
    Ok((Cow::Owned(now), found))
}

/// Returns whether the log has currents or voltages whose torque constants hold for an unknown side of the gearbox.
fn is_side_open(experiment: &Experiment) -> bool {
    let channels = (experiment.log.as_ref()).map(|log| Channels::new(&experiment.robot, log));
    channels.is_some_and(|channels| {
        channels.is_ok_and(|channels| channels.all.iter().any(|channel| channel.open_side))
    })
}

/// Returns the settings for reading the beginning of a log while signs or gains are open.
fn reading_while_open(
    experiment: &Experiment,
    model: &Model,
    channels: &Channels,
    excerpt: &Excerpt,
) -> Reading {
    as_given(model, &experiment.identify, channels, excerpt).0
}
