//! Delays of channels to a fraction of a sample, by the likelihood of the log.

mod refined;
mod searched_segment;

use crate::check::LikelyDelay;
use crate::description::{Estimator, Experiment};
use crate::estimate::errors::IdentifyError;
use crate::estimate::result::RefinedDelay;
use crate::estimate::steps::prepare_with_laws;
use crate::log::LogSource;
use crate::model::Model;
use crate::progress::Listener;
use refined::{Refined, significance};
use searched_segment::{RowDelay, SearchedSegment};

/// Maximum number of refinements with the delay of a suspected channel.
const MAX_TRIALS: usize = 16;

/// A suspected channel is no rival of a channel that explains the log if the evidence for its delay
/// is below this fraction.
const RIVAL_SHARE: f64 = 0.5;

/// Starts of a search for a delay, s, after the estimates of the last refinement and of the torque
/// row.
const FURTHER_STARTS_S: [f64; 2] = [0.0, 0.02];

/// Two starts are the same if they differ by less than this number of samples. From each start the
/// search finds delays within about ten samples.
const SAME_START_SAMPLES: f64 = 5.0;

/// Finds channels that are recorded late, by the likelihood of the first log.
///
/// A refinement estimates the delay of every channel by one step. The search repeats the refinement
/// with the delay of one suspected channel estimated, the likeliest first: the most significant one
/// or, where no refinement follows the log, the one that explains its torque row best. It accepts a
/// channel if no other significant delay is left and the delay does not raise the held-out error of
/// the motor torques. Joints whose description gives a delay are not searched.
///
/// All refinements use one segment of the log, whose length bounds their work.
///
/// # Errors
///
/// [`IdentifyError`] as for [`identify`](crate::estimate::identify::identify).
pub fn late_channels(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Vec<LikelyDelay>, IdentifyError> {
    let mut experiment = experiment.clone();
    experiment.identify.estimator = vec![Estimator::PredictionError];
    let prepared = prepare_with_laws(&experiment, model, sources, progress)?;
    let searched = (sources.first_mut()).and_then(|first| SearchedSegment::new(&prepared, first));
    let Some(mut searched) = searched else {
        return Ok(Vec::new());
    };
    let channels = searched.reading().channels();
    let is_given = |joint: usize| {
        (channels.all.iter()).any(|channel| channel.joint == joint && channel.delay.is_some())
    };
    let joints = (0..model.joint_count()).filter(|joint| !is_given(*joint));
    let joints: Vec<usize> = joints.collect();
    let columns = (channels.all.iter())
        .map(|channel| (channel.joint, channel.column.clone()))
        .collect();
    let now = searched.refined(None, usize::MAX, progress)?;
    let mut search = LateSearch {
        by_row: if now.is_sound() {
            Vec::new()
        } else {
            searched.by_torque_rows(&joints)
        },
        trials: MAX_TRIALS,
        columns,
        joints,
        now,
        searched,
        progress,
        found: Vec::new(),
    };
    // One late link channel makes its neighbours seem late. So the search first tries one channel
    // that explains all delays, then one channel per joint.
    for explains in [Explains::EveryJoint, Explains::ItsJoint] {
        while let Some(accepted) = search.likeliest(explains)? {
            search.accept(accepted);
        }
    }
    Ok(search.found)
}

/// Set of delays that a late channel has to explain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Explains {
    /// No other channel of any joint has a significant delay.
    EveryJoint,
    /// No other channel of the same joint has a significant delay.
    ItsJoint,
}

/// A search for late channels that accepts one channel at a time.
struct LateSearch<'a, 's> {
    searched: SearchedSegment<'a, 's>,
    progress: &'a mut dyn Listener,
    /// Joint and column of each channel.
    columns: Vec<(usize, String)>,
    /// Joints whose description gives no delay.
    joints: Vec<usize>,
    /// Delays by the torque rows; none if the first refinement follows the log.
    by_row: Vec<RowDelay>,
    /// Refinement with the delays found so far.
    now: Refined,
    /// Number of refinements that are left.
    trials: usize,
    found: Vec<LikelyDelay>,
}

/// A channel that may be late.
struct Suspect {
    channel: usize,
    /// Significance of its delay, or the logarithm by which the delay lowers the residual of its
    /// torque row if no refinement follows the log.
    evidence: f64,
    /// Delays from which the search starts, s.
    starts: Vec<f64>,
}

/// A late channel with the refinement that estimates its delay.
struct Accepted {
    channel: usize,
    delay: LikelyDelay,
    then: Refined,
}

impl LateSearch<'_, '_> {
    /// Returns the columns of a joint.
    fn columns(&self, joint: usize) -> Vec<&str> {
        (self.columns.iter())
            .filter(|(other, _)| *other == joint)
            .map(|(_, column)| column.as_str())
            .collect()
    }

    /// Returns channels that may be late, the likeliest first. Joints with a channel already found
    /// are left out.
    fn suspects(&self) -> Vec<Suspect> {
        let is_open = |joint: &&usize| {
            let columns = self.columns(**joint);
            !(self.found.iter()).any(|delay| columns.contains(&delay.column.as_str()))
        };
        let mut suspects: Vec<Suspect> = (self.joints.iter().filter(is_open))
            .flat_map(|&joint| {
                let of_joint = |row: &RowDelay| self.columns[row.channel].0 == joint;
                let by_row = self.by_row.iter().any(of_joint);
                self.now.suspects(&self.columns(joint), by_row)
            })
            .filter_map(|delay| self.suspect(&delay))
            .collect();
        suspects.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        suspects
    }

    fn suspect(&self, delay: &RefinedDelay) -> Option<Suspect> {
        let is_same = |(_, column): &(usize, String)| *column == delay.column;
        let channel = self.columns.iter().position(is_same)?;
        let by_row = self.by_row.iter().find(|row| row.channel == channel);
        Some(Suspect {
            channel,
            evidence: if self.by_row.is_empty() {
                significance(delay)
            } else {
                by_row.map_or(0.0, |row| -row.left.ln())
            },
            starts: (by_row.map(|row| row.delay).into_iter())
                .chain([delay.delay_s])
                .chain(FURTHER_STARTS_S)
                .collect(),
        })
    }

    /// Tries the suspected channels up to the first that explains the log, and its rivals. Returns
    /// the likeliest of them.
    fn likeliest(&mut self, explains: Explains) -> Result<Option<Accepted>, IdentifyError> {
        let mut best: Option<(f64, Accepted)> = None;
        for suspect in self.suspects() {
            if (best.as_ref()).is_some_and(|(most, _)| suspect.evidence <= RIVAL_SHARE * most) {
                break;
            }
            let rungs = (best.as_ref()).map_or(usize::MAX, |(_, before)| before.then.rungs());
            let Some(tried) = self.explanation(explains, &suspect, rungs)? else {
                continue;
            };
            let most = best.as_ref().map_or(suspect.evidence, |(most, _)| *most);
            if (best.as_ref()).is_none_or(|(_, before)| tried.then.is_likelier(&before.then)) {
                best = Some((most, tried));
            }
        }
        Ok(best.map(|(_, accepted)| accepted))
    }

    /// Estimates the delay of a suspected channel from several starts. Returns it if it explains
    /// the log.
    ///
    /// - `rungs`: number of rungs of the ladder to try.
    fn explanation(
        &mut self,
        explains: Explains,
        suspect: &Suspect,
        rungs: usize,
    ) -> Result<Option<Accepted>, IdentifyError> {
        let channel = suspect.channel;
        let column = self.columns[channel].1.clone();
        let same = SAME_START_SAMPLES * self.searched.period();
        let mut before: Vec<f64> = Vec::new();
        for &start in &suspect.starts {
            if self.trials == 0 || before.iter().any(|other| (other - start).abs() < same) {
                continue;
            }
            self.trials -= 1;
            before.push(start);
            let then = (self.searched).refined(Some((channel, start)), rungs, self.progress)?;
            let Some(delay) = then.likely_delay(&column).filter(|_| then.used) else {
                continue;
            };
            let explains = self.explained(explains, channel, &then)
                && self.searched.predicts(channel, delay.delay);
            return Ok(explains.then_some(Accepted {
                channel,
                delay,
                then,
            }));
        }
        Ok(None)
    }

    /// Returns whether a refinement leaves no significant delay except that of one channel.
    fn explained(&self, explains: Explains, channel: usize, then: &Refined) -> bool {
        let (joint, column) = &self.columns[channel];
        (self.joints.iter())
            .filter(|&other| explains == Explains::EveryJoint || other == joint)
            .all(|&other| then.significant(&self.columns(other), column).is_empty())
    }

    /// Accepts a delay: it is known from now on.
    fn accept(&mut self, accepted: Accepted) {
        (self.searched).set_delay(accepted.channel, accepted.delay.delay);
        self.now = accepted.then;
        self.found.push(accepted.delay);
    }
}
