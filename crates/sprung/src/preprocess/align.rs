//! Delays undone, link positions formed.

use crate::log::{Channels, LogBlock, Quantity};
use crate::model::JOINT_COUNT;

/// One sample of the log on a common clock, not filtered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RawSample {
    /// Time, s.
    pub time: f64,
    /// Link positions, rad.
    pub q: [f64; JOINT_COUNT],
    /// Motor positions, rad.
    pub phi: [f64; JOINT_COUNT],
    /// Motor torques, N·m.
    pub tau: [f64; JOINT_COUNT],
}

/// How far ahead of the output sample a channel is read.
#[derive(Clone, Copy, Debug)]
struct Lead {
    samples: usize,
    // Lagrange weights of the samples -1, 0, 1, 2 around it; nothing if the
    // delay is a whole number of samples.
    weights: Option<[f64; 4]>,
}

/// Part of a sample that counts as none.
const EXACT: f64 = 1e-6;

/// Lagrange weights of the samples -1, 0, 1 and 2 at a place between 0 and 1.
fn cubic(f: f64) -> [f64; 4] {
    [
        -f * (f - 1.0) * (f - 2.0) / 6.0,
        (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0,
        -(f + 1.0) * f * (f - 2.0) / 2.0,
        (f + 1.0) * f * (f - 1.0) / 6.0,
    ]
}

/// Brings the channels of a log onto one clock.
#[derive(Clone, Debug)]
pub struct Aligner {
    channels: Channels,
    leads: Vec<Lead>,
    reach: usize,
    // From the first sample that is read to the event, s.
    shift: f64,
    time: Vec<f64>,
    buffers: Vec<Vec<f64>>,
}

impl Aligner {
    /// Returns an aligner that has seen nothing.
    ///
    /// - `delays`: how much later than its event each channel was recorded,
    ///   s, in the order of [`Channels::all`].
    /// - `period`: T, s.
    ///
    /// Delays that are not whole numbers of samples are interpolated by cubics.
    #[must_use]
    pub fn new(channels: &Channels, delays: &[f64], period: f64) -> Self {
        let earliest = delays.iter().copied().fold(0.0, f64::min);
        let mut leads: Vec<Lead> = delays
            .iter()
            .map(|delay| {
                let lead = (delay - earliest) / period;
                let whole = (lead + EXACT).floor();
                let fraction = lead - whole;
                Lead {
                    // Absurd delays ask for more than any log has.
                    samples: whole.min(1e15) as usize,
                    weights: (fraction > EXACT).then(|| cubic(fraction)),
                }
            })
            .collect();
        let longest = leads.iter().map(|lead| lead.samples).max().unwrap_or(0);
        let mut reach = longest;
        let mut shift = -earliest;
        if leads.iter().any(|lead| lead.weights.is_some()) {
            // Cubics look one sample back and two ahead.
            for lead in &mut leads {
                lead.samples += 1;
            }
            reach = longest + 3;
            shift += period;
        }
        Self {
            channels: channels.clone(),
            reach,
            shift,
            time: Vec::new(),
            buffers: vec![Vec::new(); leads.len()],
            leads,
        }
    }

    /// Returns how many samples are lost at the end, because a late channel has
    /// no more.
    #[must_use]
    pub fn lost(&self) -> usize {
        self.reach
    }

    /// Takes a block and appends the samples that are ready to `out`.
    pub fn push(&mut self, block: &LogBlock, out: &mut Vec<RawSample>) {
        self.time.extend_from_slice(&block.time);
        for (buffer, values) in self.buffers.iter_mut().zip(&block.values) {
            buffer.extend_from_slice(values);
        }
        let ready = self.time.len().saturating_sub(self.reach);
        out.reserve(ready);
        for k in 0..ready {
            let mut sample = RawSample {
                time: self.time[k] + self.shift,
                ..RawSample::default()
            };
            for ((channel, lead), buffer) in
                self.channels.all.iter().zip(&self.leads).zip(&self.buffers)
            {
                let at = k + lead.samples;
                let value = match lead.weights {
                    None => buffer[at],
                    Some(w) => {
                        w[0] * buffer[at - 1]
                            + w[1] * buffer[at]
                            + w[2] * buffer[at + 1]
                            + w[3] * buffer[at + 2]
                    }
                };
                let slot = match channel.quantity {
                    Quantity::LinkPosition | Quantity::LinkDeflection => &mut sample.q,
                    Quantity::MotorPosition => &mut sample.phi,
                    Quantity::MotorTorque => &mut sample.tau,
                };
                slot[channel.joint] = value;
            }
            for channel in &self.channels.all {
                if channel.quantity == Quantity::LinkDeflection {
                    sample.q[channel.joint] += sample.phi[channel.joint];
                }
            }
            out.push(sample);
        }
        self.time.drain(..ready);
        for buffer in &mut self.buffers {
            buffer.drain(..ready);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Channel;

    const PERIOD: f64 = 1e-3;

    fn channels(link: Quantity) -> Channels {
        let quantities = [link, Quantity::MotorPosition, Quantity::MotorTorque];
        let all = quantities
            .into_iter()
            .flat_map(|quantity| (0..JOINT_COUNT).map(move |joint| (quantity, joint)))
            .map(|(quantity, joint)| Channel {
                column: String::new(),
                quantity,
                joint,
                factor: 1.0,
                delay: None,
            })
            .collect();
        Channels {
            time: "t".to_owned(),
            time_factor: 1.0,
            all,
        }
    }

    fn signal(channel: usize, time: f64) -> f64 {
        (10.0 * time + channel as f64).sin()
    }

    /// Samples of channels that were recorded late, aligned in small blocks.
    fn aligned(link: Quantity, delays: &[f64]) -> Vec<RawSample> {
        let mut aligner = Aligner::new(&channels(link), delays, PERIOD);
        let mut out = Vec::new();
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
    fn late_channels_come_back_to_their_time() {
        for delays in [
            [0.0; 6],
            [0.004, 0.0, 0.0, 0.011, 0.0, 0.0],
            [0.0, 0.0, -0.0073, 0.0, 0.0, 0.021_6],
        ] {
            let samples = aligned(Quantity::LinkPosition, &delays);
            assert!(samples.len() > 1950 && samples.len() <= 2000);
            if delays.iter().all(|delay| *delay == 0.0) {
                assert_eq!(samples.len(), 2000);
            }
            let error = |sample: &RawSample| {
                let found = [sample.q, sample.phi, sample.tau].concat();
                (found.iter().enumerate())
                    .map(|(c, x)| (x - signal(c, sample.time)).abs())
                    .fold(0.0, f64::max)
            };
            let worst = samples.iter().map(error).fold(0.0, f64::max);
            assert!(worst < 1e-8, "{delays:?}: {worst:e}");
        }
    }

    #[test]
    fn deflections_are_added_to_the_motor() {
        for sample in aligned(Quantity::LinkDeflection, &[0.15, 0.15, 0.0, 0.0, 0.0, 0.0]) {
            for joint in 0..JOINT_COUNT {
                let expected =
                    signal(joint, sample.time) + signal(JOINT_COUNT + joint, sample.time);
                assert!((sample.q[joint] - expected).abs() < 1e-12);
            }
        }
    }
}
