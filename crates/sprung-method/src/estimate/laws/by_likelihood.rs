//! Delays and Stribeck velocities of the ladder's laws, by likelihood.

use super::candidates::{Change, torque_channel};
use super::chosen::{Chosen, is_small, laws_of, names};
use crate::description::{Delay, Estimator, Experiment, Laws};
use crate::estimate::result::Refinement;
use crate::estimate::result::{LawDelay, LawRung, LawsByHoldOut};
use crate::estimate::statistics::is_significant;
use crate::prepare::{DelayGain, Prepared};

impl Chosen {
    /// Adds delays that the likelihood gives, if they are significant and do not raise the held-out
    /// error; returns their columns.
    ///
    /// - `before`: the logs without these delays; `prepared`: the logs with estimates of the delays
    ///   of `columns`.
    pub(in crate::estimate) fn add_delays(
        &mut self,
        before: &Prepared,
        prepared: &Prepared,
        columns: &[String],
    ) -> Vec<String> {
        let channels = &prepared.reading().channels().all;
        let mut added = Vec::new();
        for column in columns {
            let channel = channels
                .iter()
                .position(|channel| channel.column == *column);
            let used = channel.and_then(|channel| {
                let likely = prepared.delays().likely(channel)?;
                let gain = DelayGain::of(before.excerpt(), before.reading(), channel, likely.0);
                gain.is_none_or(|gain| !gain.is_higher()).then_some(likely)
            });
            let rung =
                used.and_then(|used| delay_by_likelihood(prepared, column, used, &self.result));
            if let Some(rung) = rung {
                self.result.rungs.push(rung);
                added.push(column.clone());
            }
        }
        added
    }

    /// Replaces the Stribeck velocities that the ladder found.
    ///
    /// - `found`: joint, velocity and standard error, rad/s (m/s).
    pub(in crate::estimate) fn set_velocities<'n>(
        &mut self,
        found: impl IntoIterator<Item = (&'n str, f64, f64)>,
    ) {
        replace_velocities(&mut self.result, found);
    }

    /// Returns the laws for the results, with the Stribeck velocities of a refinement that is used.
    pub(in crate::estimate) fn described(&self, refined: Option<&Refinement>) -> LawsByHoldOut {
        let mut laws = self.result.clone();
        let velocities = refined.into_iter().flat_map(|own| &own.stribeck_velocities);
        replace_velocities(
            &mut laws,
            velocities.map(|own| (own.joint.as_str(), own.velocity, own.standard_error)),
        );
        laws
    }
}

fn replace_velocities<'n>(
    laws: &mut LawsByHoldOut,
    found: impl IntoIterator<Item = (&'n str, f64, f64)>,
) {
    for (joint, velocity, error) in found {
        for rung in (laws.rungs.iter_mut()).filter(|rung| rung.made && rung.joint == joint) {
            if rung.stribeck_velocity.is_some() {
                rung.stribeck_velocity = Some(velocity);
                rung.stribeck_velocity_error = Some(error);
            }
        }
    }
}

/// Returns a change by a delay that the likelihood gives, if the delay is significant.
///
/// - `delay`: delay of the column and its standard error, s.
fn delay_by_likelihood(
    prepared: &Prepared,
    column: &str,
    (delay_s, standard_error_s): (f64, f64),
    laws: &LawsByHoldOut,
) -> Option<LawRung> {
    let channels = &prepared.reading().channels().all;
    let channel = channels.iter().find(|channel| channel.column == column)?;
    let period = prepared.excerpt().period();
    if !is_significant(delay_s, standard_error_s, period) || !is_small(delay_s) {
        return None;
    }
    let (of, law) = names(Change::TorqueDelay);
    Some(LawRung {
        joint: prepared.reading().model().joints()[channel.joint].clone(),
        of: of.to_owned(),
        law: law.to_owned(),
        gain: 0.0,
        gain_scatter: 0.0,
        held_out: laws
            .rungs
            .last()
            .map_or(laws.held_out, |rung| rung.held_out),
        not_told_apart_from: Vec::new(),
        stribeck_velocity: None,
        stribeck_velocity_error: None,
        delay: Some(LawDelay {
            column: column.to_owned(),
            delay_s,
            standard_error_s,
        }),
        made: true,
    })
}

/// Returns the columns of the torques whose delays are to be estimated: those of joints with
/// `laws = "auto"` and without any delay. There are none without a refinement, which estimates
/// delays more sharply than the filtered regression.
///
/// - `prepared`: the logs, whose columns are those of the experiment.
pub(in crate::estimate) fn open_delays(
    prepared: &Prepared,
    experiment: &Experiment,
) -> Vec<String> {
    let channels = prepared.reading().channels();
    let is_open = |joint: &usize| {
        let mut own = channels
            .all
            .iter()
            .filter(|channel| channel.joint == *joint);
        laws_of(experiment, *joint) == Laws::Auto && own.all(|channel| channel.delay.is_none())
    };
    let given = experiment.log.as_ref().map(|log| &log.delay_s);
    let is_given = |column: &String| {
        given.is_some_and(|given| given.estimates_all() || given.contains_key(column))
    };
    if !(experiment.identify.estimator).contains(&Estimator::PredictionError) {
        return Vec::new();
    }
    (0..experiment.robot.joint.len())
        .filter(is_open)
        .filter_map(|joint| torque_channel(channels, joint))
        .map(|channel| channels.all[channel].column.clone())
        .filter(|column| !is_given(column))
        .collect()
}

/// Returns the experiment with delays of columns to be estimated.
pub(in crate::estimate) fn with_open_delays(
    experiment: &Experiment,
    columns: &[String],
) -> Experiment {
    let mut open = experiment.clone();
    if let Some(log) = &mut open.log {
        let columns = columns.iter().cloned();
        (log.delay_s).extend(columns.map(|column| (column, Delay::Estimate)));
    }
    open
}
