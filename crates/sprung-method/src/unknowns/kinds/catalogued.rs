//! What the kinds need to know about a log and its robot.

use std::sync::OnceLock;

use sprung_core::parameters::JointParameter;

use crate::description::Experiment;
use crate::log::{Channels, Signal};
use crate::model::Model;
use crate::prepare::{Excerpt, deviation, noise, rms_speeds};
use crate::regression::Reading;

/// What the kinds need to know about a log and its robot.
pub(in crate::unknowns) struct Catalogued<'a> {
    pub(in crate::unknowns) channels: &'a Channels,
    pub(in crate::unknowns) model: &'a Model,
    pub(in crate::unknowns) experiment: &'a Experiment,
    /// Root mean square of each joint's velocity, rad/s (m/s).
    pub(in crate::unknowns) speeds: Vec<f64>,
    pub(in crate::unknowns) names: &'a [String],
    pub(in crate::unknowns) joints: usize,
    /// Whether all parameters are known, so that only changes are sought.
    pub(in crate::unknowns) is_known: bool,
    /// First time of the excerpt and its duration, s.
    pub(in crate::unknowns) span: [f64; 2],
    /// Sampling period, s.
    pub(in crate::unknowns) period: f64,
    excerpt: &'a Excerpt,
    // Whether each channel changes.
    changes: Vec<bool>,
    deflections: Vec<Option<f64>>,
    // Step of each channel after the first request.
    counts: OnceLock<Vec<f64>>,
}

impl<'a> Catalogued<'a> {
    pub(in crate::unknowns) fn new(
        (experiment, reading): (&'a Experiment, &Reading),
        channels: &'a Channels,
        model: &'a Model,
        excerpt: &'a Excerpt,
    ) -> Self {
        let first = excerpt.blocks().iter().find_map(|block| block.time.first());
        let deflections = (0..model.joint_count())
            .map(|joint| {
                let of = |signal| channels.telling(signal, joint);
                let (link, motor) = (of(Signal::Link)?, of(Signal::Motor)?);
                let both = excerpt.channel(link).zip(excerpt.channel(motor));
                Some(deviation(both.map(|(link, motor)| motor - link))).filter(|rms| *rms > 0.0)
            })
            .collect();
        Self {
            experiment,
            speeds: rms_speeds(reading, excerpt),
            channels,
            model,
            names: model.joints(),
            joints: model.joint_count(),
            is_known: (0..model.parameters().len()).all(|index| model.known(index).is_some()),
            span: [first.copied().unwrap_or_default(), excerpt.duration()],
            period: excerpt.period(),
            changes: (0..channels.all.len())
                .map(|channel| excerpt.deviation(channel) > 0.0)
                .collect(),
            excerpt,
            deflections,
            counts: OnceLock::new(),
        }
    }

    /// Returns the channels of some signals of joints that move, joint by joint.
    pub(in crate::unknowns) fn of_signals(
        &self,
        signals: &[Signal],
    ) -> impl Iterator<Item = usize> {
        let of_joint = |joint: usize| {
            let all = signals
                .iter()
                .filter_map(move |&signal| self.channels.telling(signal, joint));
            all.collect::<Vec<usize>>()
        };
        let all: Vec<usize> = (0..self.joints)
            .flat_map(of_joint)
            .filter(|&channel| self.changes[channel])
            .collect();
        all.into_iter()
    }

    /// Returns the standard deviation of a function of a position.
    pub(in crate::unknowns) fn deviation_of(&self, channel: usize, of: impl Fn(f64) -> f64) -> f64 {
        deviation(self.excerpt.channel(channel).map(of))
    }

    pub(in crate::unknowns) fn turns(&self, channel: usize) -> bool {
        self.channels.turns[self.channels.all[channel].joint]
    }

    pub(in crate::unknowns) fn has_preload(&self, joint: usize) -> bool {
        self.model.index(JointParameter::Preload, joint).is_some()
    }

    /// Returns whether another channel of the joint tells the same motion, or the channel is a torque.
    pub(in crate::unknowns) fn is_measured_twice(&self, channel: usize) -> bool {
        let of = &self.channels.all[channel];
        of.quantity.signal() == Signal::Torque || self.deflections[of.joint].is_some()
    }

    /// Returns the root mean square of the deflection of the joint of a position, rad (m), which is the yardstick of errors of
    /// encoders; `None` without two positions.
    pub(in crate::unknowns) fn deflection(&self, channel: usize) -> Option<f64> {
        self.deflection_of(self.channels.all[channel].joint)
    }

    /// Returns the root mean square of the deflection of a joint, rad (m); `None` without two positions.
    pub(in crate::unknowns) fn deflection_of(&self, joint: usize) -> Option<f64> {
        self.deflections[joint]
    }

    pub(in crate::unknowns) fn unit_of_position(&self, channel: usize) -> &'static str {
        if self.turns(channel) { "rad" } else { "m" }
    }

    /// Returns the step of a position, rad (m); zero if its readings have none.
    pub(in crate::unknowns) fn count(&self, channel: usize) -> f64 {
        let counts = self.counts.get_or_init(|| {
            let step = |channel| noise(self.excerpt, channel).and_then(|(_, step)| step);
            (self.channels.all.iter().enumerate())
                .map(|(at, channel)| channel.quantity.is_position().then(|| step(at)).flatten())
                .map(Option::unwrap_or_default)
                .collect()
        });
        counts[channel]
    }

    /// Returns the largest step of a joint's positions over the root mean square of its deflection; zero without deflection.
    pub(in crate::unknowns) fn count_share(&self, joint: usize) -> f64 {
        let positions = [Signal::Link, Signal::Motor];
        let channels = positions.map(|signal| self.channels.telling(signal, joint));
        let counts = channels
            .iter()
            .flatten()
            .map(|&channel| self.count(channel));
        let largest = counts.fold(0.0, f64::max);
        self.deflections[joint].map_or(0.0, |deflection| largest / deflection)
    }

    /// Returns the part of the moving samples in which a joint's torque brakes the motion.
    pub(in crate::unknowns) fn braking(&self, joint: usize) -> f64 {
        let of = |signal| self.channels.telling(signal, joint);
        let position = of(Signal::Motor).or_else(|| of(Signal::Link));
        let Some((torque, position)) = of(Signal::Torque).zip(position) else {
            return 0.0;
        };
        let (mut braking, mut moving) = (0, 0);
        for block in self.excerpt.blocks() {
            let (torques, positions) = (&block.values[torque], &block.values[position]);
            let moves = positions
                .windows(2 * NEIGHBOURS)
                .zip(&torques[NEIGHBOURS.min(torques.len())..]);
            for (around, torque) in moves {
                let power = torque * (around[2 * NEIGHBOURS - 1] - around[0]);
                braking += usize::from(power < 0.0);
                moving += usize::from(power != 0.0);
            }
        }
        braking as f64 / moving.max(1) as f64
    }

    /// Returns the times of the samples where the deflection of a channel's joint jumps most.
    pub(in crate::unknowns) fn largest_jumps(&self, channel: usize, count: usize) -> Vec<f64> {
        let joint = self.channels.all[channel].joint;
        let of = |signal| self.channels.telling(signal, joint);
        let Some((link, motor)) = of(Signal::Link).zip(of(Signal::Motor)) else {
            return Vec::new();
        };
        let mut largest: Vec<(f64, f64)> = Vec::new();
        for block in self.excerpt.blocks() {
            let deflection: Vec<f64> = (block.values[motor].iter().zip(&block.values[link]))
                .map(|(motor, link)| motor - link)
                .collect();
            let steps: Vec<f64> = deflection
                .windows(2)
                .map(|pair| pair[1] - pair[0])
                .collect();
            for (k, around) in steps.windows(2 * NEIGHBOURS + 1).enumerate() {
                let mean = around.iter().sum::<f64>() / around.len() as f64;
                let at = k + NEIGHBOURS;
                let jump = (steps[at] - mean).abs();
                let place = largest.partition_point(|(other, _)| *other >= jump);
                if place < count {
                    largest.insert(place, (jump, block.time[at + 1]));
                    largest.truncate(count);
                }
            }
        }
        largest.into_iter().map(|(_, time)| time).collect()
    }
}

/// Samples on each side of a jump of which it is compared with the mean.
const NEIGHBOURS: usize = 4;
