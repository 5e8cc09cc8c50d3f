//! Statistics of one channel, gathered sample by sample in bounded memory.

use super::sizes::Sizes;

/// Number of events kept per kind; only the largest are kept.
const MAX_EVENTS_KEPT: usize = 8;

/// Maximum number of bins of an overview.
const OVERVIEW_BINS: usize = 512;

/// Minimum number of consecutive samples with one value that count as a stall.
const MIN_STALL_SAMPLES: u64 = 5;

/// A step is isolated if both neighbouring steps are smaller than this fraction of it.
const LONE_STEP_RATIO: f64 = 0.25;

/// Range of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// First value.
    pub first: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl Extent {
    /// Returns whether the channel never changes.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.min.to_bits() == self.max.to_bits()
    }

    /// Returns the difference between the largest and the smallest value.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.max - self.min
    }
}

/// Consecutive samples with equal value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plateau {
    /// Time of the first sample, s.
    pub time: f64,
    /// Number of samples.
    pub samples: u64,
    /// Value of these samples.
    pub value: f64,
    /// Change of the value at the end of the run.
    pub jump: f64,
}

/// One outstanding sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Event {
    /// Time of the sample, s.
    pub time: f64,
    /// Signed size, in the unit of the channel.
    pub size: f64,
}

/// Occurrences of a channel's smallest or largest value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// The value.
    pub value: f64,
    /// Number of samples with this value.
    pub samples: u64,
    /// Number of runs of such samples.
    pub plateaus: u64,
    /// Longest of these runs.
    pub longest: Plateau,
}

/// Smallest and largest values in equal parts of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overview {
    /// Time at which each part begins, s.
    pub time: Vec<f64>,
    /// Smallest and largest value of each part.
    pub between: Vec<[f64; 2]>,
    per_bin: u64,
    in_last: u64,
}

impl Overview {
    fn take(&mut self, time: f64, value: f64) {
        if self.per_bin == 0 {
            self.per_bin = 1;
        }
        if self.in_last == self.per_bin || self.time.is_empty() {
            if self.time.len() == OVERVIEW_BINS {
                self.halve();
            }
            self.time.push(time);
            self.between.push([value, value]);
            self.in_last = 0;
        }
        self.in_last += 1;
        if let Some([low, high]) = self.between.last_mut() {
            *low = low.min(value);
            *high = high.max(value);
        }
    }

    fn halve(&mut self) {
        let pairs = self.between.chunks(2).map(|pair| {
            let fold = |pick: fn(f64, f64) -> f64, at: usize| {
                pair.iter().map(|bin| bin[at]).reduce(pick).unwrap_or(0.0)
            };
            [fold(f64::min, 0), fold(f64::max, 1)]
        });
        self.between = pairs.collect();
        self.time = self.time.iter().step_by(2).copied().collect();
        self.per_bin *= 2;
    }
}

/// Mean and scatter of a channel.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    samples: u64,
    mean: f64,
    // Sum of squared deviations from the mean.
    squares: f64,
}

impl Moments {
    fn take(&mut self, value: f64) {
        self.samples += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.samples as f64;
        self.squares += deviation * (value - self.mean);
    }

    fn deviation(&self) -> f64 {
        (self.squares / self.samples.max(1) as f64).max(0.0).sqrt()
    }
}

/// Samples of a channel that stand out, the largest first.
#[derive(Clone, Debug, Default)]
struct Outstanding {
    spikes: Vec<Event>,
    jumps: Vec<Event>,
    stalls: Vec<Plateau>,
}

/// Statistics of one channel of a log. Their memory does not grow with the log.
#[derive(Clone, Debug)]
pub struct Figures {
    extent: Extent,
    moments: Moments,
    changes: u64,
    steps: Sizes,
    bends: Sizes,
    lone: Sizes,
    outstanding: Outstanding,
    run: Plateau,
    longest: Plateau,
    low: Extreme,
    high: Extreme,
    // The last three samples, oldest first, and how many of them are since a gap.
    last: [(f64, f64); 3],
    remembered: usize,
    overview: Overview,
}

impl Figures {
    /// Returns the statistics of a channel whose first sample is given; [`take`](Self::take) adds
    /// it.
    #[must_use]
    pub(crate) fn new(time: f64, value: f64) -> Self {
        let run = Plateau {
            time,
            samples: 0,
            value,
            jump: 0.0,
        };
        let extreme = Extreme {
            value,
            samples: 0,
            plateaus: 0,
            longest: run,
        };
        Self {
            extent: Extent {
                first: value,
                min: value,
                max: value,
            },
            moments: Moments::default(),
            changes: 0,
            steps: Sizes::default(),
            bends: Sizes::default(),
            lone: Sizes::default(),
            outstanding: Outstanding::default(),
            run,
            longest: run,
            low: extreme,
            high: extreme,
            last: [(time, value); 3],
            remembered: 0,
            overview: Overview::default(),
        }
    }

    /// Takes the next sample.
    pub(crate) fn take(&mut self, time: f64, value: f64) {
        self.moments.take(value);
        self.extent.min = self.extent.min.min(value);
        self.extent.max = self.extent.max.max(value);
        self.overview.take(time, value);
        self.follow(time, value);
        let (is_lower, is_higher) = (value < self.low.value, value > self.high.value);
        at_extreme(&mut self.low, &self.run, is_lower);
        at_extreme(&mut self.high, &self.run, is_higher);
        if self.remembered >= 1 {
            self.steps.take((value - self.last[2].1).abs());
        }
        if self.remembered == 3 {
            self.look_back(value);
        }
        self.last = [self.last[1], self.last[2], (time, value)];
        self.remembered = (self.remembered + 1).min(3);
    }

    /// Records that samples are missing before the next one.
    pub(crate) fn gap(&mut self) {
        self.remembered = 0;
        // A change across a gap is not an event.
        self.run.samples = 0;
    }

    /// Updates the current run of equal values.
    fn follow(&mut self, time: f64, value: f64) {
        let same = self.run.samples > 0 && value.to_bits() == self.run.value.to_bits();
        if same {
            self.run.samples += 1;
        } else {
            if self.run.samples > 0 {
                self.changes += 1;
                self.run.jump = value - self.run.value;
                if self.run.samples >= MIN_STALL_SAMPLES {
                    keep(&mut self.outstanding.stalls, self.run, |stall| {
                        stall.jump.abs()
                    });
                }
            }
            self.run = Plateau {
                time,
                samples: 1,
                value,
                jump: 0.0,
            };
        }
        if self.run.samples > self.longest.samples {
            self.longest = self.run;
        }
    }

    /// Examines the two middle samples of the last four.
    ///
    /// - `value`: the value after the three remembered samples.
    fn look_back(&mut self, value: f64) {
        let x = [self.last[0].1, self.last[1].1, self.last[2].1, value];
        let bend = x[1] - 0.5 * (x[0] + x[2]);
        self.bends.take(bend.abs());
        // The samples of a vibration at half the rate alternate.
        if (x[2] - x[0]).abs().max((x[3] - x[2]).abs()) < 0.5 * bend.abs() {
            self.lone.take(bend.abs());
            let event = Event {
                time: self.last[1].0,
                size: bend,
            };
            keep(&mut self.outstanding.spikes, event, |event| {
                event.size.abs()
            });
        }
        let (before, step, after) = (x[1] - x[0], x[2] - x[1], x[3] - x[2]);
        if before.abs().max(after.abs()) < LONE_STEP_RATIO * step.abs() {
            let event = Event {
                time: self.last[2].0,
                size: step,
            };
            keep(&mut self.outstanding.jumps, event, |event| event.size.abs());
        }
    }

    /// Returns the first, smallest and largest value.
    #[must_use]
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.moments.samples
    }

    /// Returns the mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.moments.mean
    }

    /// Returns the standard deviation.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.moments.deviation()
    }

    /// Returns the fraction of samples that differ from the preceding one.
    #[must_use]
    pub fn changing(&self) -> f64 {
        self.changes as f64 / self.moments.samples.max(2).saturating_sub(1) as f64
    }

    /// Returns the distribution of absolute steps between consecutive samples.
    #[must_use]
    pub fn steps(&self) -> &Sizes {
        &self.steps
    }

    /// Returns the distribution of distances between a sample and the mean of its neighbours.
    #[must_use]
    pub fn bends(&self) -> &Sizes {
        &self.bends
    }

    /// Returns the distribution of these distances for samples whose neighbours agree.
    #[must_use]
    pub fn lone(&self) -> &Sizes {
        &self.lone
    }

    /// Returns the samples farthest from two neighbours that agree, largest distance first.
    #[must_use]
    pub fn spikes(&self) -> &[Event] {
        &self.outstanding.spikes
    }

    /// Returns the largest steps between two much smaller steps, largest first.
    #[must_use]
    pub fn jumps(&self) -> &[Event] {
        &self.outstanding.jumps
    }

    /// Returns runs of at least five equal samples, sorted by the change at their end, largest
    /// first.
    #[must_use]
    pub fn stalls(&self) -> &[Plateau] {
        &self.outstanding.stalls
    }

    /// Returns the longest run of equal values.
    #[must_use]
    pub fn longest(&self) -> Plateau {
        self.longest
    }

    /// Returns the occurrences of the smallest and of the largest value.
    #[must_use]
    pub fn extremes(&self) -> [Extreme; 2] {
        [self.low, self.high]
    }

    /// Returns the times of the first and the last sample, s.
    pub(crate) fn span(&self) -> [f64; 2] {
        let first = self.overview.time.first().copied();
        [first.unwrap_or_default(), self.last[2].0]
    }

    /// Returns the smallest and largest values over the course of the log.
    #[must_use]
    pub fn overview(&self) -> &Overview {
        &self.overview
    }
}

/// Updates an extreme by a sample that lies on it, beyond it or inside.
///
/// - `run`: the current run of equal values, which ends with this sample.
fn at_extreme(extreme: &mut Extreme, run: &Plateau, beyond: bool) {
    if beyond {
        *extreme = Extreme {
            value: run.value,
            samples: 0,
            plateaus: 0,
            longest: *run,
        };
    } else if run.value.to_bits() != extreme.value.to_bits() {
        return;
    }
    extreme.samples += 1;
    extreme.plateaus += u64::from(run.samples == 1);
    if run.samples >= extreme.longest.samples {
        extreme.longest = *run;
    }
}

/// Inserts an item into a list sorted by decreasing size, and drops the smallest if the list is
/// full.
fn keep<T: Copy>(kept: &mut Vec<T>, new: T, size: impl Fn(&T) -> f64) {
    let new_size = size(&new);
    if kept.len() == MAX_EVENTS_KEPT && kept.last().is_some_and(|last| size(last) >= new_size) {
        return;
    }
    let at = kept.partition_point(|other| size(other) >= new_size);
    kept.insert(at, new);
    kept.truncate(MAX_EVENTS_KEPT);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: impl Iterator<Item = f64>) -> Figures {
        let mut figures: Option<Figures> = None;
        for (k, value) in values.enumerate() {
            let time = k as f64 * 1e-3;
            (figures.get_or_insert_with(|| Figures::new(time, value))).take(time, value);
        }
        figures.unwrap()
    }

    fn wave(k: i32) -> f64 {
        (f64::from(k) * 0.01).sin()
    }

    #[test]
    fn moments_are_those_of_all_samples() {
        let figures = of((0..100_000).map(|k| 1e6 + f64::from(k % 2)));
        // Rounding of numbers of 1e6 is 1e-10.
        assert!((figures.mean() - 1e6 - 0.5).abs() < 1e-9);
        assert!((figures.deviation() - 0.5).abs() < 1e-9);
        assert!((figures.changing() - 1.0).abs() < 1e-12);
        assert!(figures.overview().time.len() <= OVERVIEW_BINS);
        let [low, high] = figures.overview().between[3];
        assert!((low - 1e6).abs() < 1e-9 && (high - low - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_spike_is_one_sample_and_a_jump_stays() {
        let spike = of((0..1000).map(|k| wave(k) + f64::from(u8::from(k == 700))));
        let found = spike.spikes()[0];
        // The wave's curvature adds at most 0.01²/2 to the spike.
        assert!((found.time - 0.7).abs() < 1e-9 && (found.size - 1.0).abs() < 0.5e-4);
        assert!(spike.jumps().iter().all(|jump| jump.size.abs() < 0.1));
        let jump = of((0..1000).map(|k| wave(k) - f64::from(u8::from(k >= 400))));
        let found = jump.jumps()[0];
        // A step of the wave adds at most 0.01 to the jump.
        assert!((found.time - 0.4).abs() < 1e-9 && (found.size + 1.0).abs() < 0.01);
        assert!(jump.spikes().iter().all(|spike| spike.size.abs() < 0.1));
    }

    #[test]
    fn a_vibration_that_decays_has_no_lone_samples() {
        let ringing = of((0..1000).map(|k| wave(k) + (-0.8_f64).powi(k)));
        // The steps of the wave, 0.01, hide a vibration of less than 0.03.
        assert!(ringing.spikes().iter().all(|spike| spike.size.abs() < 0.05));
        assert!(ringing.bends().quantile(1.0) > 1.0);
    }

    #[test]
    fn plateaus_have_time_length_and_change() {
        let clipped = of((0..2000).map(|k| wave(k).min(0.8)));
        let high = clipped.extremes()[1];
        assert!((high.value - 0.8).abs() < 1e-15);
        // The wave has three full peaks within 20 rad, and a fourth begins.
        assert_eq!(high.plateaus, 4);
        // Samples above 0.8 in a full peak, and in the fourth one; each plateau may lose one by rounding.
        let rise = 0.8_f64.asin();
        let full = (std::f64::consts::PI - 2.0 * rise) / 0.01;
        let begun = 2000.0 - (3.0 * std::f64::consts::TAU + rise) / 0.01;
        let longest = high.longest.samples as f64;
        assert!((longest - full).abs() <= 1.0, "{high:?}");
        let samples = high.samples as f64;
        assert!((samples - 3.0 * full - begun).abs() <= 4.0, "{high:?}");
        let held = of((0..1000).map(|k| wave(if (300..340).contains(&k) { 300 } else { k })));
        let stall = held.stalls()[0];
        assert_eq!(stall.samples, 40);
        assert!((stall.time - 0.3).abs() < 1e-9);
        assert!((stall.jump - (wave(340) - wave(300))).abs() < 1e-12);
    }

    #[test]
    fn no_event_spans_a_gap() {
        let mut figures = Figures::new(0.0, 0.0);
        for k in 0..100 {
            if k == 50 {
                figures.gap();
            }
            figures.take(f64::from(k), if k < 50 { 0.0 } else { 9.0 });
        }
        assert!(figures.jumps().is_empty() && figures.stalls().is_empty());
    }
}
