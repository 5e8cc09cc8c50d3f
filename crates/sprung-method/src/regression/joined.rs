//! Joins the reduced systems of logs on one time axis.

use super::system::System;

/// The reduced systems of logs in sequence.
#[derive(Clone, Debug)]
pub(super) struct Joined {
    pub(super) system: System,
    /// First and last time of each log on the common time axis, s.
    pub(super) spans: Vec<[f64; 2]>,
}

impl Joined {
    /// Returns the system of the first log.
    ///
    /// - `span`: first and last time of the log, s.
    pub(super) fn new(system: System, span: [f64; 2]) -> Self {
        Self {
            system,
            spans: vec![span],
        }
    }

    /// Appends the next log. It continues at the end of the previous log, independent of its own time
    /// stamps.
    ///
    /// - `span`: first and last time of the log, s; `period`: its T, s.
    pub(super) fn append(&mut self, system: System, span: [f64; 2], period: f64) {
        let end = self.spans.last().map_or(0.0, |last| last[1] + period);
        self.place(system, span, end - span[0]);
    }

    /// Appends the next log, whose times are already those of the common axis.
    pub(super) fn append_following(&mut self, system: System, span: [f64; 2]) {
        self.place(system, span, 0.0);
    }

    fn place(&mut self, system: System, span: [f64; 2], later: f64) {
        self.system.append(system, later);
        self.spans.push(span.map(|time| time + later));
    }
}
