//! Sensors that show nothing: columns that keep one value for much longer than in healthy logs.

use crate::log::{Channels, LogBlock};

/// Time for which any column may keep one value, s.
pub(super) const USUAL_S: f64 = 0.5;

/// Longest time over that in healthy logs.
const RATIO: f64 = 3.0;

/// Time of one value after which positions beside are remembered, s.
const BEGUN_S: f64 = 0.05;

/// A position beside moves at least so many of its steps while a frozen one does not.
const STEPS: f64 = 20.0;

/// Samples of one channel with one value.
#[derive(Clone, Debug)]
struct Run {
    value: f64,
    /// First and last time, s.
    span: [f64; 2],
    /// Positions beside soon after the first time; `None` in a short run.
    beside: Option<Vec<f64>>,
}

/// Runs of equal values of each channel.
#[derive(Clone, Debug)]
pub(super) struct Runs {
    present: Vec<Option<Run>>,
    /// Positions beside a position: the other one of its joint, or those of other joints. A joint that stands still has runs, too.
    beside: Vec<Vec<usize>>,
    /// Smallest change of each channel so far.
    steps: Vec<f64>,
    /// Longest run of each channel that counts, s.
    longest: Vec<f64>,
}

impl Runs {
    pub(super) fn new(channels: &Channels) -> Self {
        let count = channels.all.len();
        let is_position = |at: &usize| channels.all[*at].quantity.is_position();
        let beside = |at: usize| -> Vec<usize> {
            let others: Vec<usize> = (0..count)
                .filter(is_position)
                .filter(|o| *o != at)
                .collect();
            let of_joint = |other: &&usize| channels.all[**other].joint == channels.all[at].joint;
            match others.iter().find(of_joint) {
                _ if !is_position(&at) => Vec::new(),
                Some(partner) => vec![*partner],
                None => others,
            }
        };
        Self {
            present: vec![None; count],
            beside: (0..count).map(beside).collect(),
            steps: vec![f64::INFINITY; count],
            longest: vec![0.0; count],
        }
    }

    /// Takes a block, and calls back at the end of each run that counts with its channel and its span.
    pub(super) fn take(&mut self, block: &LogBlock, each: &mut dyn FnMut(usize, [f64; 2])) {
        for at in 0..block.values.len() {
            let mut gaps = block.gaps.iter().copied().peekable();
            for (k, (&time, &value)) in block.time.iter().zip(&block.values[at]).enumerate() {
                let is_behind_gap = gaps.next_if_eq(&k).is_some();
                if let Some(run) = &mut self.present[at]
                    && run.value.to_bits() == value.to_bits()
                    && !is_behind_gap
                {
                    run.span[1] = time;
                    if run.beside.is_none() && time - run.span[0] > BEGUN_S {
                        let beside = self.beside[at].iter();
                        run.beside = Some(beside.map(|other| block.values[*other][k]).collect());
                    }
                    continue;
                }
                let next = Run {
                    value,
                    span: [time; 2],
                    beside: None,
                };
                let ended = self.present[at].replace(next).filter(|_| !is_behind_gap);
                if let Some(ended) = ended {
                    self.steps[at] = self.steps[at].min((value - ended.value).abs());
                    if self.counts(at, &ended, (block, k)) {
                        self.longest[at] = self.longest[at].max(ended.span[1] - ended.span[0]);
                        each(at, ended.span);
                    }
                }
            }
        }
    }

    /// Returns the channels that keep their value until the end of a block, with the span.
    fn open(&self, block: &LogBlock) -> impl Iterator<Item = (usize, [f64; 2])> {
        let last = block.len().saturating_sub(1);
        (self.present.iter().enumerate()).filter_map(move |(at, run)| {
            let run = run.as_ref()?;
            self.counts(at, run, (block, last))
                .then_some((at, run.span))
        })
    }

    /// Returns the longest run of each channel that counts, with those that last until the end of the log, s.
    pub(super) fn longest(&self, end: &LogBlock) -> Vec<f64> {
        let mut longest = self.longest.clone();
        for (at, span) in self.open(end) {
            longest[at] = longest[at].max(span[1] - span[0]);
        }
        longest
    }

    /// Returns whether a run of a channel that ends with a sample shows that the channel is frozen.
    fn counts(&self, at: usize, run: &Run, (block, k): (&LogBlock, usize)) -> bool {
        let Some(before) = &run.beside else {
            return false;
        };
        let beside = &self.beside[at];
        let moves = |(other, before): (&usize, &f64)| {
            (block.values[*other][k] - before).abs() > STEPS * self.steps[*other]
        };
        beside.is_empty() || beside.iter().zip(before).any(moves)
    }
}

/// Finds the times at which a channel shows nothing.
pub(super) struct Blindness {
    runs: Runs,
    /// Longest run that is usual, by channel, s.
    usual: Vec<f64>,
    /// Channels that show nothing, with the time from which on and the last time.
    open: Vec<Option<[f64; 2]>>,
}

impl Blindness {
    /// - `healthy`: longest runs in healthy logs, by channel, s.
    pub(super) fn new(channels: &Channels, healthy: &[f64]) -> Self {
        Self {
            runs: Runs::new(channels),
            usual: healthy
                .iter()
                .map(|longest| (RATIO * longest).max(USUAL_S))
                .collect(),
            open: vec![None; channels.all.len()],
        }
    }

    /// Returns whether a channel shows nothing at present.
    pub(super) fn is_blind(&self) -> bool {
        self.open.iter().any(Option::is_some)
    }

    /// Returns the channels that show nothing at present, each with the span.
    pub(super) fn open(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        let open = self.open.iter().enumerate();
        open.filter_map(|(channel, span)| Some((channel, (*span)?)))
    }

    /// Takes a block and returns the channels that showed nothing and show something again, each with the span.
    pub(super) fn take(&mut self, block: &LogBlock) -> Vec<(usize, [f64; 2])> {
        let (usual, mut ended) = (&self.usual, Vec::new());
        let is_long = |at: usize, span: [f64; 2]| span[1] - span[0] > usual[at];
        self.runs.take(block, &mut |at, span| {
            if is_long(at, span) {
                ended.push((at, span));
            }
        });
        self.open.fill(None);
        for (at, span) in self.runs.open(block) {
            self.open[at] = Some(span).filter(|span| is_long(at, *span));
        }
        ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{no_files, read};

    /// Two joints with both encoders and torques: channel 0 is a link position, or the test says which it is not.
    fn channels() -> Channels {
        let experiment = read(
            "experiment.toml",
            crate::demo::EXPERIMENT,
            &[],
            &mut no_files,
        )
        .unwrap();
        Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap()
    }

    fn block(channels: &Channels, from: usize, values: impl Fn(usize, f64) -> f64) -> LogBlock {
        let mut block = LogBlock::new(channels.all.len());
        block.time = (from..from + 1000).map(|k| k as f64 * 1e-3).collect();
        for (at, column) in block.values.iter_mut().enumerate() {
            *column = block.time.iter().map(|time| values(at, *time)).collect();
        }
        block
    }

    fn position(time: f64) -> f64 {
        ((3.0 * time).sin() / 1e-3).round() * 1e-3
    }

    #[test]
    fn a_frozen_column_is_found_and_a_joint_at_rest_is_not() {
        let channels = channels();
        let is_position = |at: usize| channels.all[at].quantity.is_position();
        let frozen = (0..channels.all.len()).find(|&at| is_position(at)).unwrap();
        let usual = vec![0.02; channels.all.len()];
        let noise = |at: usize, time: f64| ((at as f64 + 1.0) * 1e4 * time).sin();
        let mut moving = Blindness::new(&channels, &usual);
        let value = |at: usize, time: f64| match at {
            at if at == frozen => position(time.min(0.3)),
            at if is_position(at) => position(time),
            _ => noise(at, time),
        };
        assert!(moving.take(&block(&channels, 0, value)).is_empty());
        assert_eq!(moving.open.iter().filter(|open| open.is_some()).count(), 1);
        assert!(moving.open[frozen].is_some());
        let after = |at: usize, time: f64| {
            if is_position(at) {
                position(time)
            } else {
                noise(at, time)
            }
        };
        let ended = moving.take(&block(&channels, 1000, after));
        assert_eq!(ended.len(), 1);
        assert_eq!(ended[0].0, frozen);
        let mut resting = Blindness::new(&channels, &usual);
        let rest = |at: usize, time: f64| {
            if is_position(at) {
                position(time.min(0.3))
            } else {
                noise(at, time)
            }
        };
        assert!(resting.take(&block(&channels, 0, rest)).is_empty());
        assert!(resting.open.iter().all(Option::is_none));
    }
}
