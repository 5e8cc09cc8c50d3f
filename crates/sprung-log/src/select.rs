//! Selects the samples of a window while a log is read.

use std::ops::Range;

use super::error::{LogError, Place};
use super::miss::Miss;
use crate::description::Window;

/// Part of the window that was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reached {
    Before,
    Inside,
    After,
}

/// Extent of a window beyond the log, and whether the log itself is complete.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beyond {
    /// Time between the beginning of the window and the first sample of the log, s.
    pub before: f64,
    /// Time between the last sample of the log and the end of the window, s.
    pub after: f64,
    /// Number of samples that the window has after the last sample of the log.
    pub samples_after: u64,
    /// Place in the middle of which the log ends, if it was cut off.
    pub cut: Option<Place>,
}

/// The window of a log and the position of the reader relative to it.
#[derive(Clone, Debug)]
pub(super) struct Selector {
    window: Window,
    // Bounds on the axis of the reader, s.
    from: f64,
    to: f64,
    placed: bool,
    reached: Reached,
    // Number of rows so far, of those inside, and the time of the last row.
    rows: u64,
    inside: u64,
    last: f64,
    // Time of the first row after the window.
    after: f64,
    beyond: Beyond,
}

impl Selector {
    pub(super) fn new(window: Window) -> Self {
        Self {
            from: window.from_s.unwrap_or(f64::NEG_INFINITY),
            to: window.to_s.unwrap_or(f64::INFINITY),
            window,
            placed: false,
            reached: Reached::Before,
            rows: 0,
            inside: 0,
            last: f64::NAN,
            after: f64::NAN,
            beyond: Beyond::default(),
        }
    }

    /// Returns the window as it is declared.
    pub(super) fn window(&self) -> Window {
        self.window
    }

    /// Returns whether no later row can lie in the window.
    pub(super) fn ended(&self) -> bool {
        self.reached == Reached::After
    }

    /// Returns the extent of the window beyond the log, as far as it is known.
    pub(super) fn beyond(&self) -> Beyond {
        self.beyond
    }

    /// Returns the next rows that lie in the window.
    ///
    /// - `times`: their times, s; `origin`: the time that was subtracted from them, s.
    pub(super) fn select(&mut self, times: &[f64], origin: f64) -> Range<usize> {
        if !std::mem::replace(&mut self.placed, true) {
            self.place(origin);
        }
        let (mut begin, mut end) = (0, 0);
        for (i, &time) in times.iter().enumerate() {
            let index = self.rows;
            if self.reached == Reached::Before && self.is_reached(time, index) {
                self.reached = Reached::Inside;
                begin = i;
                end = i;
            }
            let past = time >= self.to || self.window.to_index.is_some_and(|to| index >= to);
            if self.reached == Reached::Inside && past {
                self.reached = Reached::After;
                self.after = time;
                return begin..end;
            }
            self.rows += 1;
            self.last = time;
            if self.reached == Reached::Inside {
                if index == 0 && self.from.is_finite() {
                    self.beyond.before = (time - self.from).max(0.0);
                }
                self.inside += 1;
                end = i + 1;
            }
        }
        begin..end
    }

    /// Records the end of the log, or checks that the window is not empty.
    ///
    /// # Errors
    ///
    /// [`LogError::EmptyWindow`] if no row lies in the window.
    pub(super) fn finish(&mut self, file: &str) -> Result<(), LogError> {
        if self.inside == 0 && !self.window.is_whole() {
            return Err(LogError::EmptyWindow {
                file: file.to_owned(),
                window: Box::new(self.window),
                log: self.miss(),
            });
        }
        if self.reached != Reached::After {
            let after = self.to - self.last;
            self.beyond.after = if after.is_finite() {
                after.max(0.0)
            } else {
                0.0
            };
            let missing = (self.window.to_index).map_or(0, |to| to.saturating_sub(self.rows));
            self.beyond.samples_after = missing;
        }
        Ok(())
    }

    /// Moves bounds since 1970 to the axis of the reader, which begins at the first sample.
    fn place(&mut self, origin: f64) {
        // No log lasts half the time since 1970.
        for bound in [&mut self.from, &mut self.to] {
            if origin > 0.0 && bound.is_finite() && *bound > 0.5 * origin {
                *bound -= origin;
            }
        }
    }

    fn is_reached(&self, time: f64, index: u64) -> bool {
        let by_time = self.window.from_s.is_none() || time >= self.from;
        by_time && self.window.from_index.is_none_or(|from| index >= from)
    }

    fn miss(&self) -> Miss {
        match (self.reached, self.rows) {
            (Reached::After, 0) => Miss::LogBegins { time: self.after },
            (Reached::After, _) => Miss::Between {
                before: self.last,
                after: self.after,
            },
            (_, samples) => Miss::LogEnds {
                time: self.last,
                samples,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selector(from_s: f64, to_s: f64) -> Selector {
        Selector::new(Window {
            from_s: Some(from_s),
            to_s: Some(to_s),
            ..Window::default()
        })
    }

    #[test]
    fn the_end_does_not_belong_to_the_window() {
        let mut selector = selector(1.0, 3.0);
        assert_eq!(selector.select(&[0.0, 0.5, 1.0, 2.0], 0.0), 2..4);
        assert_eq!(selector.select(&[2.5, 3.0, 4.0], 0.0), 0..1);
        assert!(selector.ended());
        selector.finish("run.csv").unwrap();
        assert_eq!(selector.beyond(), Beyond::default());
    }

    #[test]
    fn indices_count_from_zero() {
        let mut selector = Selector::new(Window {
            from_index: Some(1),
            to_index: Some(3),
            ..Window::default()
        });
        assert_eq!(selector.select(&[0.0, 1.0, 2.0, 3.0], 0.0), 1..3);
        assert!(selector.ended());
    }

    #[test]
    fn times_since_1970_may_count_from_either_origin() {
        let origin = 1.7e9;
        for (from, to) in [(1.0, 3.0), (origin + 1.0, origin + 3.0)] {
            assert_eq!(
                selector(from, to).select(&[0.0, 1.0, 2.0, 3.0], origin),
                1..3
            );
        }
    }

    #[test]
    fn an_empty_window_is_located() {
        let missed = |mut selector: Selector, times: &[f64]| {
            assert!(selector.select(times, 0.0).is_empty());
            selector.finish("run.csv").unwrap_err().to_string()
        };
        let text = missed(selector(5.0, 6.0), &[0.0, 1.0]);
        assert!(text.contains("its 2 samples end at 1 s"), "{text}");
        let text = missed(selector(5.0, 6.0), &[7.0, 8.0]);
        assert!(text.contains("its first sample is at 7 s"), "{text}");
        let text = missed(selector(5.0, 6.0), &[0.0, 8.0]);
        assert!(text.contains("no sample between 0 s and 8 s"), "{text}");
    }

    #[test]
    fn the_extent_beyond_the_log_is_known() {
        let mut selector = selector(-1.0, 10.0);
        assert_eq!(selector.select(&[0.5, 1.0], 0.0), 0..2);
        selector.finish("run.csv").unwrap();
        let beyond = selector.beyond();
        assert_eq!((beyond.before, beyond.after), (1.5, 9.0));
    }
}
