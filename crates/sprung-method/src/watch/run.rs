//! Watches logs of a running robot.

use super::contact::{Contact, Contacts};
use super::learn::{Bandwidth, Instants, Monitor, Robot, choose};
use super::result::{Watch, WatchEvent, WatchedJoint, WatchedLog};
use super::walk::Walk;
use crate::curves::{CurveSet, Curves};
use crate::description::Experiment;
use crate::estimate::{EstimateResult, GENERATOR};
use crate::finding::{Finding, Severity};
use crate::log::{Channels, LogBlock, LogSource};
use crate::model::Model;
use crate::preprocess::Decimator;
use crate::prepare::excerpt;
use crate::progress::{Listener, Phase};
use crate::regression::{PassError, Reading};
use crate::validate::{ChosenFor, ParameterSet, ValidateError, channel_delays, read_with};

/// Bandwidth of the torques from outside, rad/s: a contact reaches nine tenths of its torque in 50 ms.
const BANDWIDTH: f64 = 50.0;

/// Largest bandwidth over the sampling rate in rad/s, so that the filters are those of continuous time.
const LARGEST_SHARE_OF_RATE: f64 = 0.025;

/// Limit of the points of a curve.
const POINTS_OF_CURVES: usize = 4096;

/// Code of the finding about a contact.
const CONTACT: &str = "contact";

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
    let channels = Channels::new(&task.experiment.robot, log)?;
    channels.require_sides(&task.experiment.robot)?;
    let delays = channel_delays(&channels, task.chosen, Some(&channels))?;
    let model = task.model.shaped(&task.set.values);
    let theta = model.theta(&task.set.values)?;
    let first = healthy.first_mut().ok_or(ValidateError::NoLog)?;
    let beginning = excerpt(&channels, first).map_err(PassError::from)?;
    let settings = &task.experiment.identify;
    let chosen = (&channels, &delays[..], task.chosen.position_cutoff_hz);
    let reading = read_with((&model, settings), chosen, Some(&beginning), Some(&theta));
    let last = BANDWIDTH.min(LARGEST_SHARE_OF_RATE * std::f64::consts::TAU / beginning.period());
    let robot = Robot {
        reading: &reading,
        model: reading.model(),
        theta: &theta,
        covariance: task.result.covariance.as_ref(),
        bandwidth: Bandwidth {
            cutoff: last,
            last,
        },
    };
    let (robot, monitor) = choose(robot, healthy, beginning.period(), progress)?;
    let mut watching = Watching::new(&robot, &monitor, task.false_alarms_per_h / 3600.0);
    let mut logs = Vec::new();
    let mut events = Vec::new();
    for source in sources {
        logs.push(watching.log(source, &mut events, tell, progress)?);
    }
    let joints = model.joints().iter().zip(&monitor.joints).zip(watching.contacts.thresholds());
    let known = |value: f64| Some(value).filter(|value| value.is_finite());
    let joints = joints.map(|((joint, of), sigma)| WatchedJoint {
        joint: joint.clone(),
        motor_share: of.of_motor,
        variance: of.variance.0.to_vec(),
        threshold_sigma: known(*sigma),
        typical_threshold_nm: known(sigma * of.typical),
    });
    let watch = Watch {
        format: 1,
        generator: GENERATOR.to_owned(),
        robot: task.experiment.robot.name.clone(),
        parameters: task.set.label.clone(),
        false_alarms_per_h: task.false_alarms_per_h,
        bandwidth_rad_per_s: robot.bandwidth.last,
        cutoff_rad_per_s: robot.bandwidth.cutoff,
        learned_from: task.chosen.logs.clone(),
        learned_s: monitor.duration,
        joints: joints.collect(),
        logs,
        events,
    };
    Ok(Watched {
        watch,
        curves: watching.curves(),
    })
}

/// Watches one log after the other.
struct Watching<'a> {
    robot: &'a Robot<'a>,
    monitor: &'a Monitor,
    contacts: Contacts,
    points: Decimator<(f64, Vec<f64>)>,
}

impl<'a> Watching<'a> {
    /// - `rate`: false alarms of all joints together, 1/s.
    fn new(robot: &'a Robot<'a>, monitor: &'a Monitor, rate: f64) -> Self {
        Self {
            contacts: Contacts::new(&monitor.joints, rate),
            points: Decimator::new(POINTS_OF_CURVES),
            robot,
            monitor,
        }
    }

    fn log(
        &mut self,
        source: &mut LogSource<'_>,
        events: &mut Vec<WatchEvent>,
        tell: &mut dyn FnMut(&WatchEvent),
        progress: &mut dyn Listener,
    ) -> Result<WatchedLog, PassError> {
        let label = source.label();
        let reading: &Reading = self.robot.reading;
        let mut log = source.open(reading.channels())?;
        let mut block = LogBlock::new(reading.channels().all.len());
        let mut more = log.read(&mut block)?;
        let period = log.timing().period;
        let mut walk = Walk::new(reading, period);
        let mut instants = Instants::new(self.robot, period)?;
        let mut watched = 0.0;
        let Self { robot, monitor, contacts, points } = self;
        let model: &Model = robot.model;
        let mut ended: Vec<Contact> = Vec::new();
        while more {
            walk.push(&block, &mut |next| {
                instants.take(next, &mut |time, now, begins| {
                    if begins {
                        ended.extend(contacts.end());
                    }
                    watched += period * instants_per(monitor);
                    let mut point = Vec::new();
                    for (joint, of) in monitor.joints.iter().enumerate() {
                        let outside = of.outside(model, joint, now);
                        ended.extend(contacts.take(joint, time, outside));
                        let threshold = contacts.thresholds()[joint] * outside[1];
                        point.extend([outside[0], threshold]);
                    }
                    points.push(|| (time, point));
                });
            });
            for contact in ended.drain(..) {
                let event = of_contact(&contact, &label, model);
                tell(&event);
                events.push(event);
            }
            progress.tell(Phase::Watching, log.timing().recorded, log.expected())?;
            more = log.read(&mut block)?;
        }
        for contact in contacts.end() {
            let event = of_contact(&contact, &label, model);
            tell(&event);
            events.push(event);
        }
        let duration = log.timing().duration;
        Ok(WatchedLog {
            log: label,
            duration_s: duration,
            blind_s: (duration - watched).max(0.0),
        })
    }

    fn curves(self) -> Curves {
        let joints = self.robot.model.joints();
        let points = self.points.into_items();
        let column = |at: usize| points.iter().map(|(_, values)| values.get(at).copied()).collect();
        Curves {
            columns: joints.iter().map(|joint| format!("{joint}.outside_nm")).collect(),
            sets: [("torque from outside", 0), ("threshold", 1)]
                .map(|(label, which)| CurveSet {
                    label: label.to_owned(),
                    time: points.iter().map(|(time, _)| *time).collect(),
                    values: (0..joints.len()).map(|joint| column(2 * joint + which)).collect(),
                })
                .into(),
        }
    }
}

fn instants_per(monitor: &Monitor) -> f64 {
    monitor.stride as f64
}

fn of_contact(contact: &Contact, log: &str, model: &Model) -> WatchEvent {
    let joint = &model.joints()[contact.joint];
    let unit = match model.kind(contact.joint) {
        sprung_core::chain::JointKind::Revolute => "N·m",
        sprung_core::chain::JointKind::Prismatic => "N",
    };
    let finding = Finding::new(
        Severity::Warning,
        CONTACT,
        format!(
            "{joint}: from {:.2} to {:.2} s a torque from outside of up to {:+.3} {unit} acts on the link; {:.3} {unit} is the \
             threshold in this state",
            contact.span[0], contact.span[1], contact.torque, contact.threshold
        ),
        "look for what touches the robot; if nothing does, record a healthy log of this motion and learn from it",
    );
    WatchEvent {
        log: log.to_owned(),
        begins_s: contact.span[0],
        ends_s: contact.span[1],
        joint: Some(joint.clone()),
        torque_nm: Some(contact.torque),
        threshold_nm: Some(contact.threshold),
        finding: finding.seen(log, "", contact.torque, unit),
    }
}
