//! Changes of the robot or of a sensor, window by window.
//!
//! A window whose residuals are larger than those of the healthy robot is searched for the fewest changes that explain them, by the
//! catalogue of unknowns with known parameters.

use super::contact::{Contact, Contacts};
use super::learn::{Instants, Monitor, Robot};
use super::residual::Now;
use super::walk::Walk;
use crate::description::Experiment;
use crate::finding::{Finding, Severity};
use crate::log::LogBlock;
use crate::model::{Model, Theta};
use crate::prepare::Excerpt;
use crate::regression::PassError;
use crate::unknowns::{FoundChange, Kind, changes};
use crate::validate::{Logs, OfSet, changed};

/// Length of a window, s.
pub(super) const WINDOW_S: f64 = 15.0;

/// Least length of the last window of a log, s.
const LEAST_S: f64 = 8.0;

/// Mean squared residual over that of the healthy robot from which a window is searched.
const UNUSUAL: f64 = 1.4;

/// The same from which a window without an explanation is reported.
const UNEXPLAINED: f64 = 9.0;

/// Code of the finding about a window that nothing explains.
const RESIDUAL_UNEXPLAINED: &str = "residual-unexplained";

/// Part of the excess of the mean squared residuals that changes must explain.
const EXPLAINED: f64 = 0.7;

/// Factor by which changes lower the product of the squared errors of all equations.
const LEAST_FACTOR: f64 = 1.2;

/// Contacts of a window up to which they are contacts, and not the effect of a change; and the part of its time up to which they are.
const MOST_CONTACTS: usize = 3;
const MOST_IN_CONTACT: f64 = 0.5;

/// What was seen in one window.
pub(super) struct Seen {
    pub(super) changes: Vec<Change>,
    /// Contacts that the changes do not explain; `None` if there are no changes.
    pub(super) contacts: Option<Vec<Contact>>,
}

/// A change that was seen in one window.
pub(super) struct Change {
    pub(super) span: [f64; 2],
    pub(super) joint: Option<usize>,
    pub(super) finding: Finding,
}

/// Mean squares of the residuals of both equations of each joint, over those of the healthy robot.
#[derive(Clone)]
struct Squares {
    sums: Vec<[f64; 2]>,
    count: f64,
}

impl Squares {
    fn new(joints: usize) -> Self {
        Self {
            sums: vec![[0.0; 2]; joints],
            count: 0.0,
        }
    }

    fn see(&mut self, (robot, monitor): (&Robot<'_>, &Monitor), now: &Now) {
        let joints = monitor.joints.iter().enumerate().zip(&mut self.sums);
        for ((joint, of), sums) in joints {
            let squares = of.squares(robot.model, joint, now);
            for (sum, square) in sums.iter_mut().zip(squares) {
                *sum += square;
            }
        }
        self.count += 1.0;
    }

    /// Returns the largest mean of a joint, or of all.
    fn largest(&self, joint: Option<usize>) -> f64 {
        let all = self.sums.iter().enumerate();
        let all = all.filter(|(of, _)| joint.is_none_or(|joint| joint == *of));
        let largest = all
            .flat_map(|(_, sums)| sums)
            .fold(0.0, |most: f64, sum| most.max(*sum));
        largest / self.count.max(1.0)
    }

    /// Returns the sum of the means beyond one.
    fn excess(&self) -> f64 {
        let count = self.count.max(1.0);
        self.sums
            .iter()
            .flatten()
            .map(|sum| (sum / count - 1.0).max(0.0))
            .sum()
    }
}

/// Names in findings.
#[derive(Clone, Copy)]
pub(super) struct Names<'a> {
    /// Origin of the values.
    pub(super) label: &'a str,
    /// The log.
    pub(super) file: &'a str,
    /// Logs of the identification.
    pub(super) identified: &'a [String],
}

/// Collects windows of a log and searches those that are unusual.
pub(super) struct Windows<'a> {
    robot: &'a Robot<'a>,
    monitor: &'a Monitor,
    experiment: &'a Experiment,
    names: Names<'a>,
    period: f64,
    excerpt: Excerpt,
    squares: Squares,
    /// Blocks of the last window, if something had changed in it.
    before: Vec<LogBlock>,
    /// Without contacts.
    contacts: Contacts,
}

impl<'a> Windows<'a> {
    /// - `contacts`: that finds them, without any; `period`: T, s.
    pub(super) fn new(
        (robot, monitor): (&'a Robot<'a>, &'a Monitor),
        contacts: Contacts,
        experiment: &'a Experiment,
        names: Names<'a>,
        period: f64,
    ) -> Self {
        Self {
            excerpt: Excerpt::lasting(period, WINDOW_S),
            squares: Squares::new(monitor.joints.len()),
            before: Vec::new(),
            contacts,
            robot,
            monitor,
            experiment,
            names,
            period,
        }
    }

    /// Takes an instant of the window.
    pub(super) fn see(&mut self, now: &Now) {
        self.squares.see((self.robot, self.monitor), now);
    }

    /// Takes a block whose instants were seen; returns whether it completes the window.
    pub(super) fn push(&mut self, block: &LogBlock) -> bool {
        !self.excerpt.push(block)
    }

    /// Ends the window, and returns what was seen in it.
    ///
    /// - `contacts`: that ended in it or last.
    ///
    /// # Errors
    ///
    /// [`PassError`] if the filters do not fit the period.
    pub(super) fn ended(&mut self, contacts: &[Contact]) -> Result<Seen, PassError> {
        let empty = Excerpt::lasting(self.period, WINDOW_S);
        let mut excerpt = std::mem::replace(&mut self.excerpt, empty);
        let before = std::mem::take(&mut self.before);
        let begin = excerpt.span()[0];
        if excerpt.duration() < LEAST_S && !before.is_empty() {
            // The end of a log has the change of the window before.
            let blocks = before.iter().chain(excerpt.blocks());
            let mut joined = Excerpt::lasting(self.period, 2.0 * WINDOW_S);
            blocks.for_each(|block| {
                joined.push(block);
            });
            excerpt = joined;
        }
        let none = Squares::new(self.monitor.joints.len());
        let squares = std::mem::replace(&mut self.squares, none);
        let nothing = Seen {
            changes: Vec::new(),
            contacts: None,
        };
        let is_short = excerpt.duration() < LEAST_S;
        if is_short || squares.largest(None) < UNUSUAL || self.is_touched(&excerpt, contacts) {
            return Ok(nothing);
        }
        let before = self.along(&excerpt, (self.robot.model, self.robot.theta))?;
        let known: Vec<(usize, f64)> = self.robot.theta.iter().copied().enumerate().collect();
        let reading = self.robot.reading;
        let known = reading.with_model(self.robot.model.with_fixed(&known));
        let explained = |excerpt: &Excerpt, (loosened, theta): (&Model, &Theta)| {
            let mut model = self.robot.model.clone();
            for joint in 0..model.joint_count() {
                model.set_play(joint, loosened.play(joint).unwrap_or_default());
            }
            let after = self.along(excerpt, (&model, theta)).ok()?;
            let is_explained = after.0.excess() <= (1.0 - EXPLAINED) * before.0.excess();
            is_explained.then_some(after)
        };
        let found = changes(
            self.experiment,
            &known,
            (&excerpt, self.names.file),
            LEAST_FACTOR,
            explained,
        );
        let Some((changes, after)) = found else {
            return Ok(Seen {
                changes: self.unexplained(&excerpt, &before.0).into_iter().collect(),
                ..nothing
            });
        };
        // Incremental encoders have another zero after each start.
        let changes: Vec<FoundChange> = (changes.into_iter())
            .filter(|change| change.found.kind != Kind::Offset)
            .collect();
        let (after, mut contacts) = after;
        contacts.retain(|contact| contact.span[0] >= begin);
        self.before = excerpt.blocks().to_vec();
        let falls = |joint: Option<usize>| {
            let [before, after] = [&before.0, &after].map(|of| of.largest(joint).sqrt());
            (after < before).then(|| {
                format!("the residual falls from {before:.1} to {after:.1} times that of the healthy robot")
            })
        };
        let set = OfSet {
            label: self.names.label,
            model: self.robot.model,
            theta: self.robot.theta,
        };
        let logs = Logs {
            run: &[self.names.file.to_owned()],
            identified: self.names.identified,
            channels: reading.channels(),
            gain: &|_| None,
        };
        let joint = changes.first().and_then(|change| change.joint);
        let size = before.0.largest(None).sqrt();
        let findings = changed(&set, &changes, (&falls, size), &logs).into_iter();
        Ok(Seen {
            changes: findings
                .map(|finding| Change {
                    span: excerpt.span(),
                    joint,
                    finding,
                })
                .collect(),
            contacts: Some(contacts),
        })
    }

    /// Returns whether something has touched the robot for a part of a window.
    fn is_touched(&self, excerpt: &Excerpt, contacts: &[Contact]) -> bool {
        let [begin, end] = excerpt.span();
        let of_joint = |joint: usize| {
            let of_joint = contacts
                .iter()
                .filter(move |contact| contact.joint == joint);
            let time = of_joint
                .clone()
                .map(|contact| (contact.span[1].min(end) - contact.span[0].max(begin)).max(0.0));
            (of_joint.count(), time.sum::<f64>() / (end - begin))
        };
        let all: Vec<(usize, f64)> = (0..self.monitor.joints.len()).map(of_joint).collect();
        let is_change =
            |(count, part): &(usize, f64)| *count > MOST_CONTACTS || *part > MOST_IN_CONTACT;
        !contacts.is_empty() && !all.iter().any(is_change)
    }

    /// Reports a window that no change explains, if its residuals are far from those of the healthy robot.
    fn unexplained(&self, excerpt: &Excerpt, before: &Squares) -> Option<Change> {
        let largest = before.largest(None);
        if largest < UNEXPLAINED {
            return None;
        }
        let joint = (0..self.monitor.joints.len()).max_by(|a, b| {
            before
                .largest(Some(*a))
                .total_cmp(&before.largest(Some(*b)))
        })?;
        let ratio = largest.sqrt();
        let finding = Finding::new(
            Severity::Warning,
            RESIDUAL_UNEXPLAINED,
            format!(
                "the residual of {} is {ratio:.1} times that of the healthy robot, and sprung found no change of the robot or of a \
                 column that explains this",
                self.robot.model.joints()[joint]
            ),
            "compare the robot with that of the identification, and look for a contact that lasts; identify again if the robot is as \
             it should be",
        );
        Some(Change {
            span: excerpt.span(),
            joint: Some(joint),
            finding: finding.seen(self.names.file, "", ratio, ""),
        })
    }

    /// Drops the present window: a sensor shows nothing, or something has touched the robot.
    pub(super) fn drop(&mut self) {
        self.excerpt = Excerpt::lasting(self.period, WINDOW_S);
        self.before.clear();
        self.squares = Squares::new(self.monitor.joints.len());
    }

    /// Returns the squares along a window with some values, and the contacts.
    fn along(
        &self,
        excerpt: &Excerpt,
        (model, theta): (&Model, &Theta),
    ) -> Result<(Squares, Vec<Contact>), PassError> {
        let robot = Robot {
            model,
            theta,
            ..*self.robot
        };
        let mut squares = Squares::new(self.monitor.joints.len());
        let mut walk = Walk::new(robot.reading, self.period);
        let mut instants = Instants::new(&robot, self.period)?;
        let (mut contacts, mut all) = (self.contacts.clone(), Vec::new());
        for block in excerpt.blocks() {
            walk.push(block, &mut |next| {
                instants.take(&next, &mut |time, now, _| {
                    squares.see((&robot, self.monitor), now);
                    for (joint, of) in self.monitor.joints.iter().enumerate() {
                        let outside = of.outside(model, joint, now);
                        all.extend(contacts.take(joint, time, outside));
                    }
                });
            });
        }
        all.extend(contacts.end());
        Ok((squares, all))
    }
}
