//! Changes of the robot or of a sensor, window by window.
//!
//! A window whose residuals are larger than those of the healthy robot is searched for the fewest changes that explain them, by the
//! catalogue of unknowns with known parameters.

use super::contact::{Contact, Contacts};
use super::learn::{Instants, Monitor, Robot};
use super::residual::Now;
use super::squares::Squares;
use super::walk::Walk;
use crate::description::Experiment;
use crate::finding::{Finding, Severity};
use crate::log::LogBlock;
use crate::model::{Model, Theta};
use crate::prepare::Excerpt;
use crate::regression::PassError;
use crate::unknowns::{Asked, FoundChange, Kind, changes};
use crate::validate::{Logs, OfSet, changed};

/// Length of a window, s.
pub(super) const WINDOW_S: f64 = 15.0;

/// Least length of the last window of a log, s.
const LEAST_S: f64 = 8.0;

/// Mean squared residual over that of the healthy robot from which a window without an explanation is reported.
const UNEXPLAINED: f64 = 9.0;

/// Code of the finding about a window that nothing explains.
const RESIDUAL_UNEXPLAINED: &str = "residual-unexplained";

/// What counts as an explanation of a window.
const ASKED: Asked = Asked {
    least_factor: 1.2,
    are_zeros_free: true,
};

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

/// Changes that explain a window.
struct Changed {
    joint: Option<usize>,
    findings: Vec<Finding>,
    /// The model and its parameters with the changes of the robot.
    model: Model,
    theta: Theta,
}

impl Changed {
    /// - `span`: of the window, s; `contacts`: that the changes leave.
    fn seen(&self, span: [f64; 2], contacts: Vec<Contact>) -> Seen {
        let change = |finding: &Finding| Change {
            span,
            joint: self.joint,
            finding: finding.clone(),
        };
        Seen {
            changes: self.findings.iter().map(change).collect(),
            contacts: Some(contacts),
        }
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
    /// The same without the time of contacts.
    untouched: Squares,
    /// What had changed in the window before.
    last: Option<Changed>,
    /// Squares that no change explains; only larger ones are searched again.
    unexplained: Option<Squares>,
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
            untouched: Squares::new(monitor.joints.len()),
            last: None,
            unexplained: None,
            contacts,
            robot,
            monitor,
            experiment,
            names,
            period,
        }
    }

    /// Takes an instant of the window.
    ///
    /// - `is_touched`: whether there is a contact.
    pub(super) fn see(&mut self, now: &Now, is_touched: bool) {
        self.squares.see((self.robot, self.monitor), now);
        if !is_touched {
            self.untouched.see((self.robot, self.monitor), now);
        }
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
        let excerpt = std::mem::replace(&mut self.excerpt, empty);
        let squares = self.squares.replaced();
        let untouched = self.untouched.replaced();
        let nothing = Seen {
            changes: Vec::new(),
            contacts: None,
        };
        let last = self.last.take();
        let is_touched = self.is_touched(&excerpt, contacts);
        let rest = if is_touched { untouched } else { squares };
        let is_usual =
            excerpt.samples() == 0 || !rest.is_unusual(self.robot, self.unexplained.as_ref());
        if is_usual && (last.is_none() || !is_touched) {
            return Ok(nothing);
        }
        let before = self
            .along(&excerpt, (self.robot.model, self.robot.theta))?
            .0;
        if let Some(last) = last {
            let (after, contacts) = self.along(&excerpt, (&last.model, &last.theta))?;
            if is_usual || before.is_explained_by(self.robot, &after) {
                let seen = last.seen(excerpt.span(), contacts);
                self.last = Some(last);
                return Ok(seen);
            }
        }
        if is_usual || excerpt.duration() < LEAST_S {
            return Ok(nothing);
        }
        let Some((changed, contacts)) = self.searched(&excerpt, &before) else {
            let found = self.about_unexplained(&excerpt, &rest);
            self.unexplained = Some(rest);
            return Ok(Seen {
                changes: found.into_iter().collect(),
                ..nothing
            });
        };
        if changed.findings.is_empty() {
            self.unexplained = Some(rest);
            return Ok(nothing);
        }
        let seen = changed.seen(excerpt.span(), contacts);
        self.last = Some(changed);
        Ok(seen)
    }

    /// Searches a window for the fewest changes that explain its residuals; returns them with the contacts that they leave.
    fn searched(&self, excerpt: &Excerpt, before: &Squares) -> Option<(Changed, Vec<Contact>)> {
        let (robot, names) = (self.robot, self.names);
        let known: Vec<(usize, f64)> = robot.theta.iter().copied().enumerate().collect();
        let reading = robot.reading.with_model(robot.model.with_fixed(&known));
        let explained = |excerpt: &Excerpt, (loosened, theta): (&Model, &Theta)| {
            let model = robot.model.clone().with_plays_of(loosened);
            let (after, contacts) = self.along(excerpt, (&model, theta)).ok()?;
            let explained = (model, theta.clone(), after, contacts);
            before
                .is_explained_by(robot, &explained.2)
                .then_some(explained)
        };
        let given = (excerpt, names.file);
        let (found, (model, theta, after, contacts)) =
            changes(self.experiment, &reading, given, ASKED, explained)?;
        // Incremental encoders have another zero after each start.
        let found: Vec<FoundChange> = (found.into_iter())
            .filter(|change| change.found.kind != Kind::Offset)
            .collect();
        let falls = |joint: Option<usize>| {
            let [before, after] = [before, &after].map(|of| of.largest(joint).sqrt());
            (after < before).then(|| {
                format!("the residual falls from {before:.1} to {after:.1} times that of the healthy robot")
            })
        };
        let set = OfSet {
            label: names.label,
            model: robot.model,
            theta: robot.theta,
        };
        let logs = Logs {
            run: &[names.file.to_owned()],
            identified: names.identified,
            channels: reading.channels(),
            gain: &|_| None,
        };
        let size = before.largest(None).sqrt();
        let changed = Changed {
            joint: found.first().and_then(|change| change.joint),
            findings: changed(&set, &found, (&falls, size), &logs),
            model,
            theta,
        };
        Some((changed, contacts))
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
    fn about_unexplained(&self, excerpt: &Excerpt, squares: &Squares) -> Option<Change> {
        let largest = squares.largest(None);
        if largest < UNEXPLAINED {
            return None;
        }
        let joint = (0..self.monitor.joints.len()).max_by(|a, b| {
            squares
                .largest(Some(*a))
                .total_cmp(&squares.largest(Some(*b)))
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
        self.last = None;
        self.squares.replaced();
        self.untouched.replaced();
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
                        let is_zero_known = now.zeros[joint].is_some();
                        all.extend(contacts.take(joint, time, outside, is_zero_known));
                    }
                });
            });
        }
        all.extend(contacts.end());
        Ok((squares, all))
    }
}
