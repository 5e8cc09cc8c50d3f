//! Watches logs of a running robot.

use super::blind::{Blindness, USUAL_S};
use super::changes::{Change, Names, WINDOW_S, Windows};
use super::contact::{Contact, Contacts};
use super::events::{of_blindness, of_change, of_contact, of_gap};
use super::learn::{Bandwidth, Instants, Monitor, Robot, learn, zero_deviations};
use super::result::{Watch, WatchEvent, WatchedJoint, WatchedLog};
use super::walk::Walk;
use crate::curves::{CurveSet, Curves};
use crate::description::{Experiment, WrongSamples};
use crate::estimate::{EstimateResult, GENERATOR, Verdict};
use crate::log::{Channels, LogBlock, LogSource};
use crate::model::Model;
use crate::prepare::excerpt;
use crate::preprocess::Decimator;
use crate::progress::{Listener, Phase};
use crate::regression::PassError;
use crate::validate::{ChosenFor, KnownLogs, ParameterSet, ValidateError, channel_delays};

/// Bandwidth of the torques from outside, rad/s: a contact reaches nine tenths of its torque in 50 ms.
const BANDWIDTH: f64 = 50.0;

/// Largest bandwidth over the sampling rate in rad/s, so that the filters are those of continuous time.
const LARGEST_SHARE_OF_RATE: f64 = 0.025;

/// Largest ratio of the sampling rates of a log and of the healthy ones, which have the same noise then.
const LARGEST_CHANGE_OF_RATE: f64 = 1.2;

/// Limit of the points of a curve.
const POINTS_OF_CURVES: usize = 4096;

/// What is watched.
pub struct WatchTask<'a> {
    /// The experiment.
    pub experiment: &'a Experiment,
    /// Its model, with the laws of the identification.
    pub model: &'a Model,
    /// The values.
    pub set: &'a ParameterSet,
    /// The result from which they come.
    pub result: &'a EstimateResult,
    /// Choices of the identification that found the parameters.
    pub chosen: &'a ChosenFor,
    /// False alarms that all joints together may have in an hour.
    pub false_alarms_per_h: f64,
}

/// What happened, with curves of torques and thresholds.
#[derive(Clone, Debug)]
pub struct Watched {
    /// The results.
    pub watch: Watch,
    /// Torques from outside and their thresholds, N·m (N).
    pub curves: Curves,
}

/// Watches logs of a running robot.
///
/// - `healthy`: logs of the robot as it was identified; `sources`: the logs to watch.
/// - `tell`: is called with each event as soon as it has ended.
///
/// # Errors
///
/// [`ValidateError`] if a description or a log is faulty.
pub fn watch(
    task: &WatchTask<'_>,
    healthy: &mut [LogSource<'_>],
    sources: &mut [LogSource<'_>],
    tell: &mut dyn FnMut(&WatchEvent),
    progress: &mut dyn Listener,
) -> Result<Watched, ValidateError> {
    task.model.check_names(&task.set.values)?;
    let log = task.experiment.log.as_ref().ok_or(ValidateError::NoLog)?;
    let mut channels = Channels::new(&task.experiment.robot, log)?;
    // Code on a controller mends no samples either.
    channels.wrong_samples = WrongSamples::Keep;
    let channels = channels;
    channels.require_sides(&task.experiment.robot)?;
    if channels.inertial.is_some() {
        return Err(ValidateError::InertialSensors);
    }
    let delays = channel_delays(&channels, task.chosen, Some(&channels))?;
    let model = task.model.shaped(&task.set.values);
    let theta = model.theta(&task.set.values)?;
    if healthy.iter().all(LogSource::has_unknown_payload) {
        return Err(ValidateError::NoHealthyLog);
    }
    let first = healthy.first_mut().ok_or(ValidateError::NoLog)?;
    let beginning = excerpt(&channels, first).map_err(PassError::from)?;
    let settings = &task.experiment.identify;
    let logs = KnownLogs {
        model: &model,
        settings,
        channels: &channels,
        delays: &delays,
        cutoff_hz: task.chosen.position_cutoff_hz,
    };
    let reading = logs.reading(Some(&beginning), Some(&theta));
    let last = BANDWIDTH.min(LARGEST_SHARE_OF_RATE * std::f64::consts::TAU / beginning.period());
    let zeros = zero_deviations(&reading, &theta, &beginning);
    let robot = Robot {
        zeros: &zeros,
        reading: &reading,
        model: reading.model(),
        theta: &theta,
        covariance: task.result.covariance.as_ref(),
        bandwidth: Bandwidth { cutoff: last, last },
    };
    let (robot, monitor) = learn(robot, healthy, progress)?;
    let mut watching = Watching::new(&robot, &monitor, task, tell);
    let mut logs = Vec::new();
    for source in sources {
        logs.push(watching.log(source, progress)?);
    }
    let thresholds = watching.contacts.thresholds();
    let joints = model.joints().iter().zip(&monitor.joints).zip(thresholds);
    let known = |value: f64| Some(value).filter(|value| value.is_finite());
    let joints = joints.map(|((joint, of), sigma)| WatchedJoint {
        joint: joint.clone(),
        motor_share: of.of_motor,
        variance: of.variance.0.to_vec(),
        zero_nm: of.zero,
        threshold_sigma: known(*sigma),
        typical_threshold_nm: known(sigma * of.typical),
    });
    let watch = Watch {
        format: 1,
        generator: GENERATOR.to_owned(),
        robot: task.experiment.robot.name.clone(),
        parameters: task.set.label.clone(),
        accepted_unusable: task.result.verdict == Verdict::Unusable,
        false_alarms_per_h: task.false_alarms_per_h,
        period_s: monitor.period,
        bandwidth_rad_per_s: robot.bandwidth.last,
        cutoff_rad_per_s: robot.bandwidth.cutoff,
        learned_from: task.chosen.logs.clone(),
        learned_s: monitor.duration,
        joints: joints.collect(),
        logs,
        events: std::mem::take(&mut watching.events),
    };
    Ok(Watched {
        watch,
        curves: curves(model.joints(), &watching.points.into_items()),
    })
}

/// Watches one log after the other.
struct Watching<'a> {
    robot: &'a Robot<'a>,
    monitor: &'a Monitor,
    task: &'a WatchTask<'a>,
    contacts: Contacts,
    points: Decimator<(f64, Vec<f64>)>,
    /// Duration of the logs before, s.
    end: f64,
    events: Vec<WatchEvent>,
    tell: &'a mut dyn FnMut(&WatchEvent),
}

/// What is known of the log that is watched.
struct OneLog<'a> {
    label: &'a str,
    /// T, s.
    period: f64,
    walk: Walk<'a>,
    instants: Instants<'a>,
    windows: Windows<'a>,
    blindness: Blindness,
    /// Times in which a channel showed nothing, s.
    blind: Vec<[f64; 2]>,
    /// Time with thresholds, s.
    watched: f64,
    /// Added to its time so that logs follow one another in the curves, s.
    later: f64,
    /// Time of the last sample, s.
    last: f64,
    /// Contacts of the present window.
    pending: Vec<Contact>,
    /// Number of earlier events.
    events: usize,
}

impl<'a> Watching<'a> {
    fn new(
        robot: &'a Robot<'a>,
        monitor: &'a Monitor,
        task: &'a WatchTask<'a>,
        tell: &'a mut dyn FnMut(&WatchEvent),
    ) -> Self {
        let rate = task.false_alarms_per_h / 3600.0;
        Self {
            contacts: Contacts::new(&monitor.joints, rate, robot.bandwidth.last),
            points: Decimator::new(POINTS_OF_CURVES),
            end: 0.0,
            events: Vec::new(),
            robot,
            monitor,
            task,
            tell,
        }
    }

    fn log(
        &mut self,
        source: &mut LogSource<'_>,
        progress: &mut dyn Listener,
    ) -> Result<WatchedLog, ValidateError> {
        let label = source.label();
        let channels = self.robot.reading.channels();
        let mut log = source.open(channels).map_err(PassError::from)?;
        let mut block = LogBlock::new(channels.all.len());
        let mut more = log.read(&mut block).map_err(PassError::from)?;
        let period = log.timing().period;
        if (period / self.monitor.period).ln().abs() > LARGEST_CHANGE_OF_RATE.ln() {
            return Err(ValidateError::OtherRate {
                file: label,
                found: 1.0 / period,
                learned: 1.0 / self.monitor.period,
            });
        }
        let names = Names {
            label: &self.task.set.label,
            file: &label,
            identified: &self.task.chosen.logs,
        };
        let watched = (self.robot, self.monitor);
        let mut one = OneLog {
            label: &label,
            period,
            walk: Walk::new(self.robot.reading, period),
            instants: Instants::new(self.robot, period)?,
            windows: Windows::new(
                watched,
                self.contacts.clone(),
                self.task.experiment,
                names,
                period,
            ),
            blindness: Blindness::new(channels, &self.monitor.runs),
            blind: Vec::new(),
            watched: 0.0,
            later: self.end - block.time.first().copied().unwrap_or_default(),
            last: block.time.first().copied().unwrap_or_default(),
            pending: Vec::new(),
            events: self.events.len(),
        };
        while more {
            self.block(&mut one, &block)?;
            progress.tell(Phase::Watching, log.timing().recorded, log.expected())?;
            more = log.read(&mut block).map_err(PassError::from)?;
        }
        self.end(&mut one)?;
        let duration = log.timing().duration;
        self.end += duration;
        let blind: f64 = one.blind.iter().map(|span| span[1] - span[0]).sum();
        Ok(WatchedLog {
            duration_s: duration,
            blind_s: (duration - one.watched + blind).clamp(0.0, duration),
            log: label,
        })
    }

    /// Takes the next block of a log.
    fn block(&mut self, one: &mut OneLog<'_>, block: &LogBlock) -> Result<(), PassError> {
        let Self {
            robot,
            monitor,
            contacts,
            points,
            ..
        } = self;
        let OneLog {
            walk,
            instants,
            windows,
            watched,
            later,
            ..
        } = one;
        let mut ended: Vec<Contact> = Vec::new();
        walk.push(block, &mut |next| {
            instants.take(&next, &mut |time, now, begins| {
                if begins {
                    ended.extend(contacts.end());
                }
                *watched += one.period * monitor.stride as f64;
                let mut point = Vec::new();
                for (joint, of) in monitor.joints.iter().enumerate() {
                    let outside = of.outside(robot.model, joint, now);
                    let is_zero_known = now.zeros[joint].is_some();
                    ended.extend(contacts.take(joint, time, outside, is_zero_known));
                    let threshold = contacts.thresholds()[joint] * outside[1];
                    point.extend([outside[0], threshold]);
                }
                windows.see(now, contacts.open().next().is_some());
                points.push(|| (*later + time, point));
            });
        });
        let shown_again = one.blindness.take(block);
        let is_blind = !shown_again.is_empty() || one.blindness.is_blind();
        self.gaps(one, block);
        self.blind(one, shown_again);
        one.pending.extend(ended);
        if is_blind {
            one.windows.drop();
            let pending = std::mem::take(&mut one.pending);
            self.contacts(one, &pending);
        } else if one.windows.push(block) {
            self.window(one)?;
        }
        Ok(())
    }

    /// Ends a window. Contacts in it may be the effect of a change.
    fn window(&mut self, one: &mut OneLog<'_>) -> Result<(), PassError> {
        let pending = std::mem::take(&mut one.pending);
        let all: Vec<Contact> = pending
            .iter()
            .chain(self.contacts.open())
            .copied()
            .collect();
        let seen = one.windows.ended(&all)?;
        if seen.contacts.is_some() {
            self.contacts.forget();
        }
        self.contacts(one, seen.contacts.as_ref().unwrap_or(&pending));
        self.changes(one, seen.changes);
        Ok(())
    }

    /// Ends a log.
    fn end(&mut self, one: &mut OneLog<'_>) -> Result<(), PassError> {
        if one.blindness.is_blind() {
            one.windows.drop();
        }
        let open = one.blindness.open().collect();
        self.blind(one, open);
        self.window(one)?;
        let ended = self.contacts.end();
        self.contacts(one, &ended);
        Ok(())
    }

    /// Reports long times without samples.
    fn gaps(&mut self, one: &mut OneLog<'_>, block: &LogBlock) {
        for &gap in &block.gaps {
            let before = gap.checked_sub(1).map(|last| block.time[last]);
            let span = [before.unwrap_or(one.last), block.time[gap]];
            if span[1] - span[0] > USUAL_S {
                let event = of_gap(span, one.label);
                self.add(one, event);
            }
        }
        one.last = block.time.last().copied().unwrap_or(one.last);
    }

    fn blind(&mut self, one: &mut OneLog<'_>, channels: Vec<(usize, [f64; 2])>) {
        for (channel, span) in channels {
            one.blind.push(span);
            let event = of_blindness(channel, span, one.label, self.robot.reading);
            self.add(one, event);
        }
    }

    /// Adds the contacts that no sensor without signal explains.
    fn contacts(&mut self, one: &OneLog<'_>, contacts: &[Contact]) {
        let open = one.blindness.open().map(|(_, span)| span);
        let spans: Vec<[f64; 2]> = one.blind.iter().copied().chain(open).collect();
        for contact in contacts.iter().filter(|contact| !contact.is_within(&spans)) {
            self.add(one, of_contact(contact, one.label, self.robot.model));
        }
    }

    fn changes(&mut self, one: &OneLog<'_>, changes: Vec<Change>) {
        for change in changes {
            let event = of_change(change, one.label, self.robot.model);
            self.add(one, event);
        }
    }

    /// Adds an event. A change that lasts is one event.
    fn add(&mut self, one: &OneLog<'_>, event: WatchEvent) {
        let is_same = |other: &&mut WatchEvent| {
            other.torque_nm.is_none()
                && (&other.finding.code, &other.joint) == (&event.finding.code, &event.joint)
                && event.begins_s - other.ends_s < WINDOW_S
        };
        let mut of_log = self.events[one.events..].iter_mut().rev();
        if let Some(same) = of_log.find(is_same) {
            same.ends_s = event.ends_s;
        } else {
            (self.tell)(&event);
            self.events.push(event);
        }
    }
}

/// Returns the curves of the torques from outside and of their thresholds.
///
/// - `points`: time, and torque and threshold of each joint.
fn curves(joints: &[String], points: &[(f64, Vec<f64>)]) -> Curves {
    let column = |at: usize| {
        points
            .iter()
            .map(|(_, values)| values.get(at).copied())
            .collect()
    };
    Curves {
        columns: joints
            .iter()
            .map(|joint| format!("{joint}.outside_nm"))
            .collect(),
        sets: [("torque from outside", 0), ("threshold", 1)]
            .map(|(label, which)| CurveSet {
                label: label.to_owned(),
                time: points.iter().map(|(time, _)| *time).collect(),
                values: (0..joints.len())
                    .map(|joint| column(2 * joint + which))
                    .collect(),
            })
            .into(),
    }
}
