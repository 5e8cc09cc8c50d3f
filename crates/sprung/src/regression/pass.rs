//! One pass over a log: from its blocks to a reduced system.

use sprung_core::filter::FilterError;

use super::filtered::{FilteredRegression, FilteredSample};
use super::reduction::{Reduction, System};
use crate::description::Identify;
use crate::log::{Channels, LogBlock, LogError, LogSource, Summary};
use crate::model::Model;
use crate::preprocess::{Aligner, Butterworth, FilterDesignError, RawSample, Signal, Smoother};

/// What keeps a log from being reduced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PassError {
    /// A filter does not fit the log.
    #[error(transparent)]
    FilterDesign(#[from] FilterDesignError),
    /// The filter pair is too fast for the log.
    #[error(
        "filter_cutoff_rad_per_s = {cutoff} is too fast for {rate:.6} samples per second; choose it \
         below the rate, 5 to 100 suits most robots"
    )]
    TooFast {
        /// λ, rad/s.
        cutoff: f64,
        /// Sampling rate, Hz.
        rate: f64,
    },
    /// The filter pair cannot be built.
    #[error("{0}")]
    FilterPair(FilterError),
    /// The log is wrong.
    #[error(transparent)]
    Log(#[from] LogError),
}

/// How a log is to be read.
#[derive(Clone, Copy, Debug)]
pub struct Reading<'a> {
    /// The equations.
    pub model: &'a Model,
    /// Filters.
    pub settings: &'a Identify,
    /// Meaning of the columns.
    pub channels: &'a Channels,
    /// Delays to undo, s, one per channel.
    pub delays: &'a [f64],
}

/// Sees what passes; by default it looks away.
pub trait Observer {
    /// Sees samples before they are filtered.
    ///
    /// - `period`: T, s.
    fn raw(&mut self, _period: f64, _samples: &[RawSample]) {}

    /// Sees a sample of the filtered regression.
    fn filtered(&mut self, _sample: &FilteredSample) {}
}

impl Observer for () {}

/// The stages between log and system, with their memory.
#[derive(Clone, Debug)]
pub struct Stages {
    period: f64,
    needed: usize,
    aligner: Aligner,
    smoother: Smoother,
    regression: FilteredRegression,
    reduction: Reduction,
    raw: Vec<RawSample>,
    signals: Vec<Signal>,
}

impl Stages {
    /// Returns stages that have seen nothing.
    ///
    /// - `period`: T of the log, s.
    ///
    /// # Errors
    ///
    /// [`PassError`] if a filter does not fit the period.
    pub fn new(reading: &Reading<'_>, period: f64) -> Result<Self, PassError> {
        let settings = reading.settings;
        let filter = Butterworth::new(
            settings.position_filter_order,
            settings.position_cutoff_hz,
            period,
        )?;
        if settings.filter_cutoff_rad_per_s * period > 1.0 {
            return Err(PassError::TooFast {
                cutoff: settings.filter_cutoff_rad_per_s,
                rate: 1.0 / period,
            });
        }
        let aligner = Aligner::new(reading.channels, reading.delays, period);
        Ok(Self {
            period,
            // The filter's padding, one sample beyond it, and the two that
            // the central difference takes.
            needed: filter.padding() + aligner.lost() + 3,
            aligner,
            smoother: Smoother::new(&filter, period),
            regression: FilteredRegression::new(
                reading.model.arm(),
                settings.filter_cutoff_rad_per_s,
                period,
                settings.discretization,
            )
            .map_err(PassError::FilterPair)?,
            reduction: Reduction::new(reading.model),
            raw: Vec::new(),
            signals: Vec::new(),
        })
    }

    /// Returns how many samples a log must have at least.
    #[must_use]
    pub fn needed(&self) -> usize {
        self.needed
    }

    /// Takes the next block.
    pub fn push(&mut self, block: &LogBlock, observer: &mut impl Observer) {
        self.raw.clear();
        self.aligner.push(block, &mut self.raw);
        observer.raw(self.period, &self.raw);
        self.smoother.push(&self.raw, &mut self.signals);
        reduce(
            &mut self.signals,
            &mut self.regression,
            &mut self.reduction,
            observer,
        );
    }

    /// Ends the log; returns nothing if it was too short.
    pub fn finish(mut self, observer: &mut impl Observer) -> Option<System> {
        if !self.smoother.finish(&mut self.signals) {
            return None;
        }
        reduce(
            &mut self.signals,
            &mut self.regression,
            &mut self.reduction,
            observer,
        );
        Some(self.reduction.finish())
    }
}

fn reduce(
    signals: &mut Vec<Signal>,
    regression: &mut FilteredRegression,
    reduction: &mut Reduction,
    observer: &mut impl Observer,
) {
    for signal in signals.drain(..) {
        let sample = regression.process(signal.time, &signal.state, &signal.tau);
        reduction.push(&sample);
        observer.filtered(&sample);
    }
}

fn longest_delay(delays: &[f64]) -> f64 {
    let spread = |pick: fn(f64, f64) -> f64| delays.iter().copied().fold(0.0, pick);
    spread(f64::max) - spread(f64::min)
}

/// What a pass leaves of a log.
#[derive(Clone, Debug)]
pub struct Passed {
    /// The reduced system.
    pub system: System,
    /// Figures of the columns.
    pub summary: Summary,
    /// Sampling period, s.
    pub period: f64,
    /// Time between first and last sample, s.
    pub duration: f64,
    /// Largest deviation of a step from the period, as a part of it.
    pub jitter: f64,
}

/// Reads a log once, block by block, and reduces it.
///
/// - `progress`: called with the number of samples read so far.
///
/// # Errors
///
/// [`PassError`] if the log is wrong, too short, or does not fit the filters.
pub fn read_through(
    reading: &Reading<'_>,
    source: &mut LogSource<'_>,
    observer: &mut impl Observer,
    progress: &mut dyn FnMut(u64),
) -> Result<Passed, PassError> {
    let mut log = source.open(reading.channels)?;
    let mut block = LogBlock::new(reading.channels.all.len());
    log.read(&mut block)?;
    let period = log.clock().period().unwrap_or_default();
    let mut stages = Stages::new(reading, period)?;
    let mut summary = Summary::new(reading.channels);
    while !block.is_empty() {
        summary.take(&block);
        stages.push(&block, observer);
        progress(log.clock().samples());
        log.read(&mut block)?;
    }
    let needed = stages.needed() as u64;
    let system = stages.finish(observer).ok_or_else(|| LogError::TooShort {
        file: source.name.clone(),
        found: log.clock().samples(),
        needed,
        why: format!(
            "three periods of position_cutoff_hz = {} pad each end of the zero-phase filter, and \
             delays take {:.3} s",
            reading.settings.position_cutoff_hz,
            longest_delay(reading.delays)
        ),
    })?;
    Ok(Passed {
        system,
        summary,
        period,
        duration: log.clock().duration(),
        jitter: log.clock().jitter(),
    })
}
