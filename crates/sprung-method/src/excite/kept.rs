//! Limits that a motion keeps or breaks.

use serde::Serialize;

use super::bounds::Limited;

/// How near to its limit a quantity comes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// The quantity.
    pub what: Limited,
    /// Joint; for a height that of the link, for the tool the last one.
    pub joint: usize,
    /// Largest part of the limit that the motion uses, at most 1.
    pub part: f64,
    /// Time of its largest value, s.
    pub time_s: f64,
}

/// A limit that a motion breaks.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The quantity.
    pub what: Limited,
    /// Joint, as in [`Kept`].
    pub joint: usize,
    /// Time, s.
    pub time_s: f64,
    /// Value; for a height the height.
    pub value: f64,
    /// Part of the limit that the value uses, above 1.
    pub part: f64,
    /// Whether the loop runs away instead.
    pub runs_away: bool,
}

/// The peaks of a motion that keeps its limits.
#[derive(Clone, Debug, Default)]
pub(super) struct Peaks(pub(super) Vec<Kept>);

impl Peaks {
    pub(super) fn note(&mut self, what: Limited, joint: usize, part: f64, time_s: f64) {
        match (self.0.iter_mut()).find(|kept| kept.what == what && kept.joint == joint) {
            Some(kept) if kept.part >= part => {}
            Some(kept) => (kept.part, kept.time_s) = (part, time_s),
            None => self.0.push(Kept {
                what,
                joint,
                part,
                time_s,
            }),
        }
    }

    /// Keeps the larger part of each limit.
    pub(super) fn join(&mut self, more: Vec<Kept>) {
        for kept in more {
            self.note(kept.what, kept.joint, kept.part, kept.time_s);
        }
    }

    pub(super) fn part(&self, what: Limited, joint: usize) -> f64 {
        let kept = self
            .0
            .iter()
            .find(|kept| kept.what == what && kept.joint == joint);
        kept.map_or(0.0, |kept| kept.part)
    }
}

pub(super) fn broken(what: Limited, joint: usize, time_s: f64, value: f64, part: f64) -> Broken {
    Broken {
        what,
        joint,
        time_s,
        value,
        part,
        runs_away: false,
    }
}
