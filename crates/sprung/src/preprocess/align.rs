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

/// Brings the channels of a log onto one clock.
#[derive(Clone, Debug)]
pub struct Aligner {
    channels: Channels,
    leads: Vec<Lead>,
    reach: usize,
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
        let leads: Vec<Lead> = delays
            .iter()
            .map(|delay| {
                let lead = (delay - earliest) / period;
                let whole = (lead + 1e-6).floor();
                let f = lead - whole;
                let weights = (f > 1e-6).then(|| {
                    [
                        -f * (f - 1.0) * (f - 2.0) / 6.0,
                        (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0,
                        -(f + 1.0) * f * (f - 2.0) / 2.0,
                        (f + 1.0) * f * (f - 1.0) / 6.0,
                    ]
                });
                Lead {
                    // Channels are read from one sample on, so that cubics
                    // find the sample before.
                    samples: whole as usize + 1,
                    weights,
                }
            })
            .collect();
        let any = leads.iter().any(|lead| lead.weights.is_some());
        let reach =
            leads.iter().map(|lead| lead.samples).max().unwrap_or(1) + if any { 2 } else { 0 };
        let mut aligner = Self {
            channels: channels.clone(),
            reach,
            time: Vec::new(),
            buffers: vec![Vec::new(); leads.len()],
            leads,
        };
        if !any {
            // Nothing is interpolated: no sample is lost at the start.
            for lead in &mut aligner.leads {
                lead.samples -= 1;
            }
            aligner.reach -= 1;
        }
        aligner
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
                time: self.time[k],
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
