//! Logs that are ready for an identification.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use super::as_given::as_given;
use super::estimated_columns::{Doubt, FoundGain};
use super::excerpt::{Excerpt, excerpt};
use super::factors::{FactorError, Factors, find_factors};
use super::held_out::held_out;
use super::inertial_findings::about_stiffnesses;
use super::play::with_plays;
use super::springs::find_springs;
use super::stribeck::{by_likelihood, find_stribeck, with_widths};
use super::sweep::{Sweep, sweep};
use super::velocity_by_likelihood::VelocityByLikelihood;
use super::weights::find_weights;
use crate::description::{Experiment, Weights};
use crate::finding::{Finding, Severity};
use crate::fit::over_reference;
use crate::log::{ChannelError, Channels, LogError, LogSource, time_unit};
use crate::model::Model;
use crate::progress::{Listener, Phase, Stopped};
use crate::regression::{Reading, TransitionWeights};

/// Stribeck velocities by likelihood are used up to this ratio of held-out errors to those of the
/// search by least squares.
const MAX_ERROR_RATIO: f64 = 1.05;

/// Largest accepted standard error of a gain, relative.
const LARGEST_ERROR_SHARE: f64 = 0.1;

/// Number of choices for the progress: cut-off, Stribeck velocities, weights.
const CHOICES: u64 = 3;

/// Errors of a preparation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// The experiment names no log.
    #[error("the experiment has no [log]; say which file to read")]
    NoLog,
    /// The description gives the value of each parameter.
    #[error(
        "[robot] fixed gives all {0} parameters, so the log has nothing to tell; leave out of fixed those that it should give"
    )]
    NothingOpen(usize),
    /// The description of the log is not complete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// A sign or a gain cannot be estimated.
    #[error(transparent)]
    Factor(FactorError),
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The caller stopped the preparation.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<FactorError> for PrepareError {
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other errors pass")]
    fn from(error: FactorError) -> Self {
        match error {
            FactorError::Log(error) => Self::Log(error),
            error => Self::Factor(error),
        }
    }
}

/// Logs with all choices that precede an estimate; [`prepare`] makes it.
#[derive(Clone, Debug)]
pub struct Prepared {
    experiment: Experiment,
    names: Vec<String>,
    reading: Reading,
    cutoff_reason: Option<String>,
    // Cut-off that the noise of the positions allows, Hz.
    noise_cutoff_hz: f64,
    sweep: Option<Sweep>,
    factors: Factors,
    excerpt: Excerpt,
    // Weights for the reading after their first request; copies of the same reading share them.
    weights: Arc<OnceLock<Option<TransitionWeights>>>,
    // Joints and findings about their Stribeck velocities.
    about_stribeck: Vec<(usize, Finding)>,
    about_springs: Vec<Finding>,
    wrong_time_unit: Option<Finding>,
    // What the errors of unknowns that were applied add to the standard errors of parameters, by name.
    doubt: BTreeMap<String, Doubt>,
}

/// Prepares logs: finds open signs and gains, keeps the beginning of the first log, chooses the
/// cut-off from it, and estimates Stribeck velocities.
///
/// - `sources`: the logs, all with the same columns.
/// - `progress`: receives each choice.
///
/// # Errors
///
/// [`PrepareError`] if the description is not complete, the first log cannot be read, or it does
/// not determine a quantity that is to be estimated from it.
pub fn prepare(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Prepared, PrepareError> {
    let parameters = model.parameters().len();
    if (0..parameters).all(|index| model.known(index).is_some()) {
        return Err(PrepareError::NothingOpen(parameters));
    }
    let (experiment, factors) = find_factors(experiment, model, sources)?;
    let experiment = experiment.into_owned();
    let log = experiment.log.as_ref().ok_or(PrepareError::NoLog)?;
    let channels = Channels::new(&experiment.robot, log)?;
    channels.require_references(&experiment.robot)?;
    let names: Vec<String> = sources.iter().map(LogSource::label).collect();
    progress.tell(Phase::Preparing, 1, Some(CHOICES))?;
    let first = sources.first_mut().ok_or(PrepareError::NoLog)?;
    let excerpt = excerpt(&channels, first)?;
    let wrong_time_unit = time_unit(&first.label(), &channels, excerpt.period())
        .filter(|finding| finding.severity == Severity::Error);
    let beginning = Beginning {
        names,
        factors,
        excerpt,
        wrong_time_unit,
    };
    choose(experiment, model, (&channels, beginning), progress)
}

/// The beginning of the first log, which no further choice changes.
struct Beginning {
    names: Vec<String>,
    factors: Factors,
    excerpt: Excerpt,
    wrong_time_unit: Option<Finding>,
}

/// Makes the choices after signs and gains.
fn choose(
    experiment: Experiment,
    model: &Model,
    (channels, beginning): (&Channels, Beginning),
    progress: &mut dyn Listener,
) -> Result<Prepared, PrepareError> {
    let Beginning {
        names,
        factors,
        excerpt,
        wrong_time_unit,
    } = beginning;
    let mut choosing = |choice| progress.tell(Phase::Preparing, choice, Some(CHOICES));
    let (reading, cutoff_reason) = as_given(model, &experiment.identify, channels, &excerpt);
    choosing(2)?;
    let (reading, mut about_springs) = with_widths_and_plays(&reading, &excerpt);
    let (reading, about_stribeck) = with_stribeck_velocities(&reading, &excerpt);
    let (reading, about_stiff) = find_springs(&reading, &excerpt);
    about_springs.extend(about_stiff);
    about_springs.extend(about_stiffnesses(&reading, &excerpt));
    Ok(Prepared {
        experiment,
        names,
        noise_cutoff_hz: reading.position_cutoff_hz(),
        reading,
        cutoff_reason,
        sweep: None,
        factors,
        excerpt,
        weights: Arc::default(),
        about_stribeck,
        about_springs,
        wrong_time_unit,
        doubt: BTreeMap::new(),
    })
}

/// Returns the reading with estimates of the widths and plays that the model leaves open, and findings about plays.
fn with_widths_and_plays(reading: &Reading, excerpt: &Excerpt) -> (Reading, Vec<Finding>) {
    let reading = reading.with_model(with_widths(reading, excerpt));
    let (model, findings) = with_plays(&reading, excerpt);
    (reading.with_model(model), findings)
}

/// Returns the reading with estimates of the Stribeck velocities that the model leaves open, and findings about them.
fn with_stribeck_velocities(
    reading: &Reading,
    excerpt: &Excerpt,
) -> (Reading, Vec<(usize, Finding)>) {
    if reading.model().unknown_stribeck().is_empty() {
        return (reading.clone(), Vec::new());
    }
    let (model, findings) = find_stribeck(reading, excerpt);
    (reading.with_model(model), findings)
}

impl Prepared {
    /// Makes all choices again for an experiment with other laws or delays or with rigid joints, from the beginning of the
    /// log that was read.
    ///
    /// - `experiment`: made from [`experiment`](Self::experiment).
    ///
    /// # Errors
    ///
    /// The errors of [`prepare`], but for those of reading.
    pub(crate) fn again(
        &self,
        experiment: &Experiment,
        model: &Model,
        progress: &mut dyn Listener,
    ) -> Result<Self, PrepareError> {
        let log = experiment.log.as_ref().ok_or(PrepareError::NoLog)?;
        let channels = Channels::new(&experiment.robot, log)?;
        let beginning = Beginning {
            names: self.names.clone(),
            factors: self.factors.clone(),
            excerpt: (self.excerpt).with_channels(self.reading.channels(), &channels),
            wrong_time_unit: self.wrong_time_unit.clone(),
        };
        let again = choose(experiment.clone(), model, (&channels, beginning), progress)?;
        Ok(again.with_doubt(self.doubt.clone()))
    }

    /// Returns the same logs with what the errors of unknowns that were applied add to the standard errors of parameters, by name.
    #[must_use]
    pub(crate) fn with_doubt(mut self, doubt: BTreeMap<String, Doubt>) -> Self {
        self.doubt = doubt;
        self
    }

    /// Returns what the errors of unknowns that were applied add to the standard error of each parameter, \[p\].
    pub(crate) fn doubt(&self) -> Vec<Doubt> {
        let parameters = self.reading.model().parameters().iter();
        let of = |name: &String| self.doubt.get(name).copied().unwrap_or_default();
        parameters.map(|parameter| of(&parameter.name)).collect()
    }

    /// Returns the same logs with estimated gains of columns, without the choices that depend on them.
    #[must_use]
    pub(crate) fn with_gains(mut self, gains: Vec<FoundGain>) -> Self {
        if gains.is_empty() {
            return self;
        }
        let channels = self.reading.channels().clone();
        for gain in &gains {
            let of = (channels.all.iter()).position(|channel| channel.column == gain.column);
            if let Some(channel) = of {
                self.excerpt = self.excerpt.scaled(channel, gain.value);
            }
        }
        self.factors.gains.extend(gains);
        self.factors.write_into(&mut self.experiment);
        self
    }

    /// Checks that all gains are known well enough.
    ///
    /// # Errors
    ///
    /// [`FactorError::NotTold`] for a gain that the log leaves open.
    pub(crate) fn require_gains(&self) -> Result<(), FactorError> {
        let channels = self.reading.channels();
        let open = (channels.all.iter()).find(|channel| channel.open_gain);
        let is_vague =
            |gain: &&FoundGain| gain.standard_error > LARGEST_ERROR_SHARE * gain.value.max(0.0);
        let vague = self.factors.gains.iter().find(is_vague);
        let (column, found) = match (vague, open) {
            (Some(gain), _) => (
                &gain.column,
                format!(
                    "it would be {:.3} (standard error {:.3})",
                    gain.value, gain.standard_error
                ),
            ),
            (None, Some(channel)) => (
                &channel.column,
                "other values explain the torques about as well, the log is too short, or its columns have another meaning"
                    .to_owned(),
            ),
            (None, None) => return Ok(()),
        };
        Err(FactorError::NotTold(format!(
            "the gain of \"{column}\" cannot be estimated: {found}; check that known values and signs are right, log more \
             motion of this joint, or give the gain as a number in gain"
        )))
    }

    /// Returns the experiment, including the estimated signs and gains.
    #[must_use]
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Returns the same logs with other settings for reading them.
    #[must_use]
    pub(crate) fn with_reading(self, reading: Reading) -> Self {
        Self {
            reading,
            weights: Arc::default(),
            ..self
        }
    }

    /// Returns the same logs with another model of the same equations.
    #[must_use]
    pub(crate) fn with_model(self, model: Model) -> Self {
        let reading = self.reading.with_model(model);
        self.with_reading(reading)
    }

    /// Returns the names of the logs, for messages.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the settings for reading the logs.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        &self.reading
    }

    /// Returns the settings with which a check reads the logs: without weights, which could mask
    /// faulty samples, and with the cut-off that the noise allows, which alters the motion least.
    pub(crate) fn examined(&self) -> Reading {
        (self.reading.without_weights()).with_position_cutoff(self.noise_cutoff_hz)
    }

    /// Returns the reason for the cut-off, if sprung chose it.
    #[must_use]
    pub fn cutoff_reason(&self) -> Option<&str> {
        self.cutoff_reason.as_deref()
    }

    /// Returns the estimates with other cut-offs from the beginning of the first log; `None` before
    /// the weights are known, or if the log is too short.
    #[must_use]
    pub(crate) fn sweep(&self) -> Option<&Sweep> {
        self.sweep.as_ref()
    }

    /// Returns the estimated signs and gains.
    #[must_use]
    pub fn factors(&self) -> &Factors {
        &self.factors
    }

    /// Returns the beginning of the first log.
    #[must_use]
    pub fn excerpt(&self) -> &Excerpt {
        &self.excerpt
    }

    /// Returns findings about signs, gains and Stribeck velocities.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        let file = self.names.first().map_or("", String::as_str);
        let mut findings = self.factors.findings(file);
        findings.extend(
            self.about_stribeck
                .iter()
                .map(|(_, finding)| finding.clone()),
        );
        findings.extend_from_slice(&self.about_springs);
        findings
    }

    /// Returns the error that the time of the first log has another unit, if sprung detected it.
    #[must_use]
    pub fn wrong_time_unit(&self) -> Option<&Finding> {
        self.wrong_time_unit.as_ref()
    }

    /// Replaces Stribeck velocities and the findings about them, unless the new velocities raise the
    /// held-out error of the motor torques.
    #[must_use]
    pub(crate) fn with_velocities(mut self, velocities: &[VelocityByLikelihood]) -> Self {
        if velocities.is_empty() {
            return self;
        }
        let model = velocities
            .iter()
            .fold(self.reading.model().clone(), |model, velocity| {
                model.with_stribeck(velocity.joint, velocity.velocity)
            });
        let reading = self.reading.with_model(model);
        let errors = held_out(&self.excerpt, &self.reading).zip(held_out(&self.excerpt, &reading));
        if errors
            .is_some_and(|(searched, likely)| over_reference(likely, searched) > MAX_ERROR_RATIO)
        {
            return self;
        }
        for velocity in velocities {
            let finding = by_likelihood(reading.model(), velocity);
            self.about_stribeck
                .retain(|(joint, _)| *joint != velocity.joint);
            self.about_stribeck.push((velocity.joint, finding));
        }
        self.with_reading(reading)
    }

    /// Returns whether a joint has this Stribeck velocity.
    #[must_use]
    pub(crate) fn uses(&self, velocity: &VelocityByLikelihood) -> bool {
        let used = self.reading.model().stribeck_velocity(velocity.joint);
        (used - velocity.velocity).abs() <= f64::EPSILON * velocity.velocity
    }

    /// Adds the weights of samples that the settings request, and sweeps the cut-off of the
    /// positions. If sprung chooses the cut-off and a lower one predicts held-out torque better,
    /// the lower one replaces it.
    ///
    /// # Errors
    ///
    /// [`Stopped`] if the progress listener stops the work.
    pub fn weighted(mut self, progress: &mut dyn Listener) -> Result<Self, Stopped> {
        progress.tell(Phase::Preparing, CHOICES, Some(CHOICES))?;
        self.weigh();
        let from_noise = self.reading.position_cutoff_hz();
        self.sweep = sweep(&self.reading, &self.excerpt, self.cutoff_reason.is_some());
        let chosen = (self.sweep.as_ref()).map(|sweep| sweep.points[sweep.chosen].cutoff_hz);
        if let Some((chosen, reason)) = chosen.zip(self.cutoff_reason.as_mut())
            && chosen < 0.999 * from_noise
        {
            *reason = format!(
                "it predicts held-out parts of the log better than {from_noise:.3} Hz, the highest \
                 cut-off that the noise allows ({reason})"
            );
            let lower = self.reading.without_weights().with_position_cutoff(chosen);
            self = self.with_reading(lower);
            self.weigh();
        }
        Ok(self)
    }

    fn weigh(&mut self) {
        self.reading = self.weighted_reading();
    }

    /// Returns the reading with weights for its model and filters.
    pub(crate) fn weighted_reading(&self) -> Reading {
        let weights = match self.reading.settings().weights {
            Weights::None => None,
            Weights::Transition => (self.weights)
                .get_or_init(|| find_weights(&self.reading, &self.excerpt))
                .as_ref(),
        };
        match weights {
            Some(weights) => self.reading.with_weights(weights.clone()),
            None => self.reading.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{self, no_files};
    use crate::progress::Unheard;

    #[test]
    fn a_robot_whose_parameters_are_all_given_is_refused() {
        let read = |text: &str| description::read("experiment.toml", text, &[], &mut no_files);
        let mut experiment = read(demo::EXPERIMENT).unwrap();
        let open = Model::new(&experiment).unwrap();
        for parameter in open.parameters() {
            experiment.robot.fixed.insert(parameter.name.clone(), 1.0);
        }
        let given = Model::new(&experiment).unwrap();
        let refused = prepare(&experiment, &given, &mut [], &mut Unheard).unwrap_err();
        assert!(
            matches!(refused, PrepareError::NothingOpen(15)),
            "{refused}"
        );
    }
}
