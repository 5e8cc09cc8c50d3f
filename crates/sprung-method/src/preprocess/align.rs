//! Undoes delays and forms link positions.

use sprung_core::covariate::Covariate;

use super::deflections::Deflections;
use super::raw_block::RawBlock;
use crate::description::{LinkPosition, Measures, Signal};
use crate::log::{Channels, LogBlock, Mix};

/// Returns the place of a covariate of a joint among the covariates of all joints.
fn place(joint: usize, covariate: Covariate) -> usize {
    joint * Covariate::COUNT + covariate as usize
}

/// Where the value of an output sample comes from, relative to the sample `samples` ahead of the output sample.
#[derive(Clone, Copy, Debug)]
enum Reading {
    /// The sample itself.
    Sample,
    /// Mean of two values that are each held for a period, weighted by the durations for which they act.
    Held([f64; 2]),
    /// Weights of the samples -1, 0, 1, 2 around it.
    Cubic([f64; 4]),
}

/// Offset of a channel ahead of the output sample.
#[derive(Clone, Copy, Debug)]
struct Lead {
    samples: usize,
    reading: Reading,
}

/// Fraction of a sample that counts as zero.
const WHOLE_SAMPLE_TOLERANCE: f64 = 1e-6;

/// Hold in periods from which a value counts as held for the whole period.
const WHOLE_HOLD: f64 = 1.0 - WHOLE_SAMPLE_TOLERANCE;

/// Weights of the samples -1, 0, 1 and 2 for the mean of a cubic over values at positions of mean `f`, between 0 and 1, that
/// fill a period in steps of length `hold`, in periods. With a hold of 1 it is the value at `f`.
///
/// ```text
/// w_i = L_i(f) + V/2 L_i''(f)        V = (1 − hold²)/12        L_i: Lagrange cubic
/// ```
fn cubic_mean(f: f64, hold: f64) -> [f64; 4] {
    let half_variance = (1.0 - hold * hold) / 24.0;
    [
        -f * (f - 1.0) * (f - 2.0) / 6.0 + half_variance * (1.0 - f),
        (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0 + half_variance * (3.0 * f - 2.0),
        -(f + 1.0) * f * (f - 2.0) / 2.0 + half_variance * (1.0 - 3.0 * f),
        (f + 1.0) * f * (f - 1.0) / 6.0 + half_variance * f,
    ]
}

/// Splits a delay relative to the earliest one into whole samples and a fraction.
fn split(lead: f64) -> (usize, f64) {
    let whole = (lead + WHOLE_SAMPLE_TOLERANCE).floor();
    // Limits absurd delays to more samples than any log has.
    (whole.min(1e15) as usize, lead - whole)
}

/// Forms the positions of links and motors of aligned samples.
#[derive(Clone, Debug)]
struct Positions {
    compliances: Vec<f64>,
    deflections: Deflections,
}

/// Aligns the channels of a log in time.
#[derive(Clone, Debug)]
pub(crate) struct Aligner {
    channels: Channels,
    // `None` for a channel that is left out.
    leads: Vec<Option<Lead>>,
    reach: usize,
    // Time from the first sample in the buffers to the event, s.
    shift: f64,
    time: Vec<f64>,
    buffers: Vec<Vec<f64>>,
    // `None` if the positions are left out.
    positions: Option<Positions>,
}

impl Aligner {
    /// Returns an aligner for a new segment.
    ///
    /// - `delays`: delay of each channel relative to the event, s, in the order of
    ///   [`Channels::all`].
    /// - `compliances`: of the joints with torque sensor, \[n\], rad/(N·m) (m/N); `period`: T, s.
    ///
    /// Cubics interpolate delays that are not whole numbers of samples. Torques are means from a sample to the next.
    #[must_use]
    pub(crate) fn new(
        channels: &Channels,
        delays: &[f64],
        compliances: &[f64],
        period: f64,
    ) -> Self {
        let holds = channels.holds(delays, period);
        let delays = &channels.acting_delays(delays, period);
        let earliest = delays.iter().copied().fold(0.0, f64::min);
        let mut leads: Vec<Lead> = (delays.iter().zip(holds))
            .map(|(delay, hold)| {
                let (samples, fraction) = split((delay - earliest) / period);
                let reading = if fraction > WHOLE_SAMPLE_TOLERANCE {
                    Reading::Cubic(cubic_mean(fraction, hold))
                } else {
                    Reading::Sample
                };
                Lead { samples, reading }
            })
            .collect();
        let longest = leads.iter().map(|lead| lead.samples).max().unwrap_or(0);
        let mut reach = longest;
        let mut shift = -earliest;
        let is_cubic = |lead: &Lead| matches!(lead.reading, Reading::Cubic(_));
        if leads.iter().any(is_cubic) {
            // A cubic needs one sample before and two samples after.
            for lead in &mut leads {
                lead.samples += 1;
            }
            reach = longest + 3;
            shift += period;
        }
        let positions = Positions {
            compliances: compliances.to_vec(),
            deflections: Deflections::new(channels, period),
        };
        Self {
            positions: Some(positions),
            ..Self::of(
                channels,
                leads.into_iter().map(Some).collect(),
                reach,
                shift,
            )
        }
    }

    /// Returns an aligner for torques and covariates only. It drops the samples at the ends that other channels need.
    ///
    /// - `delays`: delay of each channel relative to the event, s, in the order of [`Channels::all`]; `period`: T, s.
    #[must_use]
    pub(crate) fn at_samples(channels: &Channels, delays: &[f64], period: f64) -> Self {
        let holds = channels.holds(delays, period);
        let delays = &channels.acting_delays(delays, period);
        let earliest = delays.iter().copied().fold(0.0, f64::min);
        let has_cubic = holds.iter().any(|hold| *hold < WHOLE_HOLD);
        // A cubic needs one sample before.
        let ahead = if has_cubic { 1.0 } else { 0.0 };
        let first = ((-earliest / period).ceil() + ahead) * period;
        let lead = |delay: &f64| (delay + first) / period;
        let all = channels.all.iter().zip(delays).zip(holds);
        let leads = all.map(|((channel, delay), hold)| {
            let lead = lead(delay);
            match channel.quantity.signal() {
                Signal::Torque => {
                    let (samples, fraction) = split(lead);
                    let part = fraction.max(0.0);
                    let reading = if hold < WHOLE_HOLD {
                        Reading::Cubic(cubic_mean(part, hold))
                    } else {
                        Reading::Held([1.0 - part, part])
                    };
                    Some(Lead { samples, reading })
                }
                // Covariates are slow.
                Signal::Covariate(_) => Some(Lead {
                    samples: lead.round().min(1e15) as usize,
                    reading: Reading::Sample,
                }),
                Signal::Link
                | Signal::Motor
                | Signal::Target
                | Signal::Switch
                | Signal::Spring
                | Signal::Inertial(..) => None,
            }
        });
        let leads = leads.collect();
        let longest = delays.iter().map(lead).fold(0.0, f64::max);
        // The held value of the latest channel changes during the period after the sample; a cubic needs another one.
        let reach = longest.ceil().min(1e15) as usize + 1 + usize::from(has_cubic);
        Self::of(channels, leads, reach, first)
    }

    fn of(channels: &Channels, leads: Vec<Option<Lead>>, reach: usize, shift: f64) -> Self {
        Self {
            channels: channels.clone(),
            reach,
            shift,
            time: Vec::new(),
            buffers: vec![Vec::new(); leads.len()],
            leads,
            positions: None,
        }
    }

    /// Returns the number of samples that are lost at the end, where late channels have no more
    /// data.
    #[must_use]
    pub(crate) fn lost(&self) -> usize {
        self.reach
    }

    /// Returns the time from the first sample of a segment to the first finished sample, s.
    #[must_use]
    pub(crate) fn shift(&self) -> f64 {
        self.shift
    }

    /// Processes a block and appends the finished samples to `out`.
    pub(crate) fn push(&mut self, block: &LogBlock, out: &mut RawBlock) {
        self.push_columns(block.time.iter().copied(), &block.values, out);
    }

    /// The same for columns that are not in a block.
    pub(crate) fn push_columns(
        &mut self,
        time: impl Iterator<Item = f64>,
        columns: &[Vec<f64>],
        out: &mut RawBlock,
    ) {
        self.time.extend(time);
        if self.reach > 0 {
            for ((buffer, lead), values) in self.buffers.iter_mut().zip(&self.leads).zip(columns) {
                if lead.is_some() {
                    buffer.extend_from_slice(values);
                }
            }
        }
        let ready = self.time.len().saturating_sub(self.reach);
        if ready == 0 {
            return;
        }
        let before = out.len();
        out.time
            .extend(self.time[..ready].iter().map(|time| time + self.shift));
        // Without reach no sample waits for a later one.
        let sources = if self.reach > 0 {
            &self.buffers
        } else {
            columns
        };
        self.read(sources, ready, out);
        if let Some(mix) = &self.channels.torque_mix {
            couple(mix, &mut out.tau, before..before + ready);
        }
        self.relate_covariates(before, out);
        if let Some(positions) = &mut self.positions {
            positions.form(&self.channels, before, out);
        }
        self.time.drain(..ready);
        for buffer in &mut self.buffers {
            buffer.drain(..ready.min(buffer.len()));
        }
    }

    /// Appends the values of `ready` samples.
    fn read(&self, sources: &[Vec<f64>], ready: usize, out: &mut RawBlock) {
        let all = (self.channels.all.iter().zip(&self.leads)).zip(sources);
        for ((channel, lead), buffer) in all {
            let joint = channel.joint;
            let Some(lead) = lead else {
                continue;
            };
            let column = match channel.quantity.signal() {
                Signal::Link => &mut out.q[joint],
                Signal::Motor => &mut out.phi[joint],
                Signal::Torque => &mut out.tau[joint],
                // Logs of robots have no such channels.
                Signal::Target | Signal::Switch => continue,
                Signal::Spring => &mut out.spring[joint],
                // Link positions are formed from them later.
                Signal::Inertial(_, axis) => {
                    let at = joint * 3 + axis as usize;
                    out.inertial
                        .resize(out.inertial.len().max(at + 1), Vec::new());
                    &mut out.inertial[at]
                }
                Signal::Covariate(covariate) => &mut out.excess[place(joint, covariate)],
            };
            let at = lead.samples;
            match lead.reading {
                Reading::Sample => column.extend_from_slice(&buffer[at..at + ready]),
                Reading::Held(w) => {
                    let held = (at..at + ready).map(|k| w[0] * buffer[k] + w[1] * buffer[k + 1]);
                    column.extend(held);
                }
                Reading::Cubic(w) => column.extend((at..at + ready).map(|k| {
                    w[0] * buffer[k - 1]
                        + w[1] * buffer[k]
                        + w[2] * buffer[k + 1]
                        + w[3] * buffer[k + 2]
                })),
            }
        }
    }

    /// Completes the covariates of samples from `before` on, and takes their references from them.
    fn relate_covariates(&self, before: usize, out: &mut RawBlock) {
        for covariate in &self.channels.covariates {
            let at = place(covariate.joint, covariate.covariate);
            let source = (self
                .channels
                .of_covariate(covariate.covariate, covariate.joint))
            .map(|channel| self.channels.all[channel].joint);
            match source {
                Some(joint) if joint != covariate.joint => {
                    let shared = out.excess[place(joint, covariate.covariate)][before..].to_vec();
                    out.excess[at].extend(shared);
                }
                Some(_) => {}
                None => {
                    let times = out.time[before..].iter();
                    out.excess[at].extend(times.map(|time| time - out.begin));
                }
            }
        }
        for covariate in &self.channels.covariates {
            let column = &mut out.excess[place(covariate.joint, covariate.covariate)];
            for value in column.iter_mut().skip(before) {
                *value -= covariate.reference;
            }
        }
    }
}

impl Positions {
    /// Forms the positions of samples from `before` on.
    fn form(&mut self, channels: &Channels, before: usize, out: &mut RawBlock) {
        if let Some(mix) = &channels.position_mix {
            couple(mix, &mut out.phi, before..out.time.len());
        }
        for (offset, (q, phi)) in (channels.offsets.iter()).zip(out.q.iter_mut().zip(&mut out.phi))
        {
            // Rigid joints and differences of positions are corrected below.
            for column in [phi, q] {
                for value in column.iter_mut().skip(before) {
                    *value += offset;
                }
            }
        }
        for channel in &channels.all {
            if let Measures::Position { link, motor } = channel.quantity.measures()
                && link * motor != 0.0
            {
                let offset = channels.offsets[channel.joint];
                let phi = &out.phi[channel.joint][before..];
                for (q, phi) in out.q[channel.joint][before..].iter_mut().zip(phi) {
                    *q -= motor * (phi - offset);
                }
            }
        }
        for (joint, instrument) in channels.instruments.iter().enumerate() {
            let phi = &out.phi[joint][before..];
            match instrument.link_position() {
                LinkPosition::Motor => out.q[joint].extend_from_slice(phi),
                LinkPosition::ByTorque => {
                    let compliance = self.compliances[joint];
                    let pairs = phi.iter().zip(&out.spring[joint][before..]);
                    out.q[joint].extend(pairs.map(|(phi, spring)| phi - compliance * spring));
                }
                // These positions are there already, and those follow.
                LinkPosition::Column | LinkPosition::ByMotion(_) => {}
            }
        }
        self.deflections.form(channels, before, out);
    }
}

/// Turns the values of motors into those of joints.
fn couple(mix: &Mix, columns: &mut [Vec<f64>], samples: std::ops::Range<usize>) {
    for k in samples {
        let joints = Mix::apply(&mix.forward, &RawBlock::at(columns, k));
        for (column, value) in columns.iter_mut().zip(joints) {
            column[k] = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{Instrument, Instrumentation, TorqueHold, TorqueReading};
    use crate::log::{Channel, CovariateOfJoint, Quantity};

    const PERIOD: f64 = 1e-3;
    const JOINTS: usize = 2;

    fn channels(link: Quantity) -> Channels {
        let quantities = [link, Quantity::MotorPosition, Quantity::MotorTorque];
        let all = quantities
            .into_iter()
            .flat_map(|quantity| (0..JOINTS).map(move |joint| (quantity, joint)))
            .map(|(quantity, joint)| Channel {
                column: String::new(),
                origin: crate::log::Origin::default(),
                quantity,
                joint,
                gear_ratio: None,
                before_gear: false,
                counts_per_turn: None,
                factor: 1.0,
                delay: None,
                open_sign: false,
                open_gain: false,
                open_side: false,
            })
            .collect();
        Channels {
            time: crate::log::TimeSource {
                origin: crate::log::TimeOrigin::Period(PERIOD),
                stream: None,
                factor: 1.0,
                sampling: None,
                are_dates: false,
            },
            csv: crate::description::CsvForm::default(),
            nan: crate::description::MissingValues::Refuse,
            wrong_samples: crate::description::WrongSamples::Keep,
            all,
            exact_torque: false,
            torque_hold: None,
            instruments: Instrumentation::of(vec![Instrument::Link; JOINTS]),
            inertial: None,
            turns: vec![true; JOINTS],
            offsets: vec![0.0, 0.3],
            covariates: Vec::new(),
            position_mix: None,
            torque_mix: None,
        }
    }

    fn signal(channel: usize, time: f64) -> f64 {
        (10.0 * time + channel as f64).sin()
    }

    /// Samples of channels with delays, aligned in small blocks.
    fn aligned(link: Quantity, delays: &[f64]) -> RawBlock {
        let mut aligner = Aligner::new(&channels(link), delays, &[0.0; JOINTS], PERIOD);
        let mut out = RawBlock::new(JOINTS);
        for start in (0..2000).step_by(77) {
            let mut block = LogBlock::new(delays.len());
            for k in start..(start + 77).min(2000) {
                let time = f64::from(k) * PERIOD;
                block.time.push(time);
                for (channel, values) in block.values.iter_mut().enumerate() {
                    values.push(signal(channel, time - delays[channel]));
                }
            }
            aligner.push(&block, &mut out);
        }
        out
    }

    #[test]
    fn delays_are_undone() {
        for delays in [
            [0.0; 6],
            [0.004, 0.0, 0.0, 0.011, 0.0, 0.0],
            [0.0, 0.0, -0.0073, 0.0, 0.0, 0.021_6],
        ] {
            let samples = aligned(Quantity::LinkPosition, &delays);
            // Delays of up to 21.6 ms and 7.3 ms early cut samples off: 1969 to 2000 of 2000
            // remain.
            assert!(samples.len() > 1950 && samples.len() <= 2000);
            if delays.iter().all(|delay| *delay == 0.0) {
                assert_eq!(samples.len(), 2000);
            }
            let columns = [&samples.q[..], &samples.phi, &samples.tau].concat();
            let error = |k: usize| {
                let offset = |c: usize| if c == 1 || c == 3 { 0.3 } else { 0.0 };
                (columns.iter().enumerate())
                    .map(|(c, x)| (x[k] - offset(c) - signal(c, samples.time[k])).abs())
                    .fold(0.0, f64::max)
            };
            let worst = (0..samples.len()).map(error).fold(0.0, f64::max);
            // A cubic through four samples has the largest error in the middle: 9/16 h⁴ x⁗ / 24, at 10 rad/s.
            let limit = 9.0 / 16.0 * (10.0 * PERIOD).powi(4) / 24.0;
            assert!(worst < limit, "{delays:?}: {worst:e}");
        }
    }

    #[test]
    fn deflections_are_added_to_the_motor() {
        let samples = aligned(Quantity::LinkDeflection, &[0.15, 0.15, 0.0, 0.0, 0.0, 0.0]);
        for (k, &time) in samples.time.iter().enumerate() {
            for joint in 0..JOINTS {
                let expected =
                    signal(joint, time) + signal(JOINTS + joint, time) + 0.3 * joint as f64;
                assert!((samples.q[joint][k] - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_mean_of_torques_that_change_within_a_period_is_exact_for_cubics() {
        let torque = |time: f64| {
            let x = time / PERIOD / 10.0;
            x * x * x - 4.0 * x * x + x - 2.0
        };
        for steps in [2_u32, 4, 5] {
            let mut channels = channels(Quantity::LinkPosition);
            channels.torque_hold = Some(TorqueHold {
                reading: TorqueReading::Held,
                controller_period: Some(PERIOD / f64::from(steps)),
            });
            let columns: Vec<f64> = (0..60).map(|k| torque(f64::from(k) * PERIOD)).collect();
            let times = || (0..60).map(|k| f64::from(k) * PERIOD);
            let delays = [0.0; 6];
            let aligners = [
                Aligner::new(&channels, &delays, &[0.0; JOINTS], PERIOD),
                Aligner::at_samples(&channels, &delays, PERIOD),
            ];
            for mut aligner in aligners {
                let mut out = RawBlock::new(JOINTS);
                aligner.push_columns(times(), &vec![columns.clone(); 6], &mut out);
                assert!(out.len() > 50);
                for (time, found) in out.time.iter().zip(&out.tau[0]) {
                    let part = PERIOD / f64::from(steps);
                    let mean = (0..steps).map(|k| torque(time + f64::from(k) * part));
                    let mean = mean.sum::<f64>() / f64::from(steps);
                    assert!((found - mean).abs() < 1e-9, "{steps}: {found} {mean}");
                }
            }
        }
    }

    #[test]
    fn torques_are_held_and_covariates_are_nearest_at_samples_of_the_log() {
        let mut channels = channels(Quantity::LinkPosition);
        channels.all.push(Channel {
            quantity: Quantity::Covariate(Covariate::Temperature),
            ..channels.all[0].clone()
        });
        channels.covariates.push(CovariateOfJoint {
            joint: 1,
            covariate: Covariate::Temperature,
            reference: 20.0,
        });
        let delays = [0.0, 0.0, 0.0, -0.0014, 0.0, 0.002_25, 0.0016];
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        let mut aligner = Aligner::at_samples(&channels, &delays, PERIOD);
        let mut out = RawBlock::new(JOINTS);
        for columns in [&ramp[..40], &ramp[40..]] {
            let times = columns.iter().map(|k| k * PERIOD);
            aligner.push_columns(times, &vec![columns.to_vec(); delays.len()], &mut out);
        }
        // Two samples of the early motor position, three of the late torque, and one for its hold.
        assert!((aligner.shift() - 0.002).abs() < 1e-12);
        assert_eq!(out.len(), 100 - 2 - 3 - 1);
        assert!(out.q[0].is_empty() && out.phi[1].is_empty());
        for (k, time) in out.time.iter().enumerate() {
            let sample = (k + 2) as f64;
            let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9);
            near(*time, sample * PERIOD);
            near(out.tau[0][k], sample);
            near(out.tau[1][k], sample + 2.25);
            near(
                out.excess[place(1, Covariate::Temperature)][k],
                sample + 2.0 - 20.0,
            );
        }
    }
}
