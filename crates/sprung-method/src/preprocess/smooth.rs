//! Filtered positions and their derivatives.

use rayon::prelude::*;
use sprung_core::covariate::Covariate;

use super::raw_block::RawBlock;
use crate::model::Elements;

use super::zero_phase::{Butterworth, ZeroPhase};

/// Samples for the regressor: filtered positions, velocities and torques.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignalBlock {
    /// Time, s.
    pub time: Vec<f64>,
    /// Link positions, rad (m), \[n\] vectors.
    pub q: Vec<Vec<f64>>,
    /// Link velocities, rad/s (m/s).
    pub dq: Vec<Vec<f64>>,
    /// Link accelerations, rad/s² (m/s²); empty if no joint has an accelerometer.
    pub ddq: Vec<Vec<f64>>,
    /// Motor positions, rad (m).
    pub phi: Vec<Vec<f64>>,
    /// Motor velocities, rad/s (m/s).
    pub dphi: Vec<Vec<f64>>,
    /// Motor torques, N·m (N), held until the next sample.
    pub tau: Vec<Vec<f64>>,
    /// Measured torques of the springs, N·m (N), not filtered; empty for a joint without torque
    /// sensor.
    pub spring: Vec<Vec<f64>>,
    /// Covariates minus their references, \[n × [`Covariate::COUNT`]\] vectors; empty where no friction
    /// depends on a covariate.
    pub excess: Vec<Vec<f64>>,
}

impl SignalBlock {
    /// Returns an empty block for `joints` joints.
    #[must_use]
    pub fn new(joints: usize) -> Self {
        let columns = || vec![Vec::new(); joints];
        Self {
            time: Vec::new(),
            q: columns(),
            dq: columns(),
            ddq: columns(),
            phi: columns(),
            dphi: columns(),
            tau: columns(),
            spring: columns(),
            excess: vec![Vec::new(); joints * Covariate::COUNT],
        }
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Returns whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Makes room for further samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        let columns = self.columns().filter(|column| !column.is_empty());
        columns.for_each(|column| column.reserve(samples));
    }

    /// Appends samples of the same robot.
    pub fn append(&mut self, mut later: Self) {
        for (column, more) in self.columns().zip(later.columns()) {
            column.append(more);
        }
    }

    /// Adds the signals of another block; empty columns are zero.
    pub(crate) fn add(&mut self, other: &Self) {
        let pairs = [
            (&mut self.q, &other.q),
            (&mut self.dq, &other.dq),
            (&mut self.phi, &other.phi),
            (&mut self.dphi, &other.dphi),
            (&mut self.tau, &other.tau),
        ];
        for (to, from) in pairs
            .into_iter()
            .flat_map(|(to, from)| to.iter_mut().zip(from))
        {
            if to.is_empty() {
                to.clone_from(from);
            } else {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
            }
        }
    }

    /// Returns the first of every `count` samples with the mean of their torques, which are held;
    /// leaves out samples at the end that are fewer.
    #[must_use]
    pub(crate) fn thinned(&self, count: usize) -> Self {
        let means = |column: &Vec<f64>| -> Vec<f64> {
            let parts = column.chunks_exact(count);
            parts
                .map(|part| part.iter().sum::<f64>() / count as f64)
                .collect()
        };
        Self {
            tau: self.tau.iter().map(means).collect(),
            spring: (self.spring.iter())
                .map(|spring| centred(spring, count))
                .collect(),
            ..self.each(|column| column.chunks_exact(count).map(|part| part[0]).collect())
        }
    }

    /// Moves elements along the samples and returns those of each, \[samples × n × elements\]; empty if no joint has any.
    #[must_use]
    pub(crate) fn elements(&self, elements: &mut Elements) -> Vec<f64> {
        let mut all = Vec::new();
        if elements.is_empty() {
            return all;
        }
        let n = self.phi.len();
        let mut positions = vec![0.0; 2 * n];
        for k in 0..self.len() {
            for (position, column) in positions.iter_mut().zip(self.q.iter().chain(&self.phi)) {
                *position = column[k];
            }
            let (q, phi) = positions.split_at(n);
            all.extend_from_slice(elements.advance(q, phi));
        }
        all
    }

    /// Returns the first of every `count` samples.
    #[must_use]
    pub(crate) fn picked(&self, count: usize) -> Self {
        self.each(|column| column.iter().copied().step_by(count).collect())
    }

    /// Returns a block whose columns are formed from these.
    fn each(&self, form: impl Fn(&Vec<f64>) -> Vec<f64>) -> Self {
        let of_joints = |columns: &[Vec<f64>]| columns.iter().map(&form).collect();
        Self {
            time: form(&self.time),
            q: of_joints(&self.q),
            dq: of_joints(&self.dq),
            ddq: of_joints(&self.ddq),
            phi: of_joints(&self.phi),
            dphi: of_joints(&self.dphi),
            tau: of_joints(&self.tau),
            spring: of_joints(&self.spring),
            excess: of_joints(&self.excess),
        }
    }

    /// Returns all columns.
    fn columns(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let groups = (self.q.iter_mut())
            .chain(&mut self.dq)
            .chain(&mut self.ddq)
            .chain(&mut self.phi)
            .chain(&mut self.dphi)
            .chain(&mut self.tau)
            .chain(&mut self.spring)
            .chain(&mut self.excess);
        std::iter::once(&mut self.time).chain(groups)
    }

    /// Keeps the first samples.
    fn truncate(&mut self, samples: usize) {
        self.columns().for_each(|column| column.truncate(samples));
    }

    /// Removes some samples.
    fn remove(&mut self, from: usize, count: usize) {
        for column in self.columns().filter(|column| !column.is_empty()) {
            column.drain(from..from + count);
        }
    }
}

/// Returns means over `count` samples about every `count`-th sample, as many as there are whole groups
/// of samples.
fn centred(values: &[f64], count: usize) -> Vec<f64> {
    let groups = values.len() / count;
    (0..groups)
        .map(|group| {
            let at = group * count;
            let reach = (count / 2).min(at).min(values.len() - 1 - at);
            let window = &values[at - reach..=at + reach];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

/// One position with its filter.
#[derive(Clone, Debug)]
struct Column {
    filter: ZeroPhase,
    filtered: Vec<f64>,
}

impl Column {
    /// Appends the finished positions and their central differences.
    fn differentiate(&mut self, period: f64, position: &mut Vec<f64>, velocity: &mut Vec<f64>) {
        let scale = 0.5 / period;
        let filtered = &self.filtered;
        let ready = filtered.len().saturating_sub(2);
        position.extend_from_slice(&filtered[filtered.len().min(1)..][..ready]);
        velocity.extend(filtered.windows(3).map(|w| scale * (w[2] - w[0])));
        self.filtered.drain(..ready);
    }

    /// Appends the finished values of a column of measured velocities or accelerations.
    fn values(&mut self, velocity: &mut Vec<f64>) {
        let filtered = &self.filtered;
        let ready = filtered.len().saturating_sub(2);
        velocity.extend_from_slice(&filtered[filtered.len().min(1)..][..ready]);
        self.filtered.drain(..ready);
    }
}

/// Filters positions without phase shift and differentiates them.
///
/// The central difference removes the first and the last sample. At a gap one period of the cut-off
/// is removed on either side, because the robot moves there and the filter has no data beyond the
/// gap.
///
/// # Source
///
/// Section 2.3.3 and eq. (27).
#[derive(Clone, Debug)]
pub(crate) struct Smoother {
    // Motor positions, then link positions of flexible joints.
    columns: Vec<Column>,
    // Velocities of links by gyroscopes, with their joints.
    rates: Vec<(usize, Column)>,
    // Accelerations of joints by accelerometers, with their joints.
    accelerations: Vec<(usize, Column)>,
    // Joint of each link position in `columns`.
    flexible: Vec<usize>,
    rigid: Vec<usize>,
    time: Vec<f64>,
    tau: Vec<Vec<f64>>,
    spring: Vec<Vec<f64>>,
    excess: Vec<Vec<f64>>,
    period: f64,
    // Samples to remove beside a gap, and how many remain to be removed after the last gap.
    edge: usize,
    to_drop: usize,
}

impl Smoother {
    /// Returns a smoother for a new log.
    ///
    /// - `flexible`: whether each joint's link has a separate position.
    /// - `period`: T, s.
    #[must_use]
    pub(crate) fn new(filter: &Butterworth, flexible: &[bool], period: f64) -> Self {
        let (links, rigid): (Vec<usize>, Vec<usize>) =
            (0..flexible.len()).partition(|&joint| flexible[joint]);
        let column = Column {
            filter: ZeroPhase::new(filter.clone()),
            filtered: Vec::new(),
        };
        let measured: Vec<(usize, Column)> = (links.iter())
            .map(|&joint| (joint, column.clone()))
            .collect();
        Self {
            accelerations: measured.clone(),
            rates: measured,
            columns: vec![column; flexible.len() + links.len()],
            flexible: links,
            rigid,
            time: Vec::new(),
            tau: vec![Vec::new(); flexible.len()],
            spring: vec![Vec::new(); flexible.len()],
            excess: vec![Vec::new(); flexible.len() * Covariate::COUNT],
            period,
            edge: filter.edge(),
            to_drop: 0,
        }
    }

    /// Prepares the smoother for samples that follow a gap.
    #[must_use]
    pub(crate) fn behind_gap(mut self) -> Self {
        self.to_drop = self.edge;
        self
    }

    /// Processes samples and appends finished samples to `out`.
    pub(crate) fn push(&mut self, samples: &RawBlock, out: &mut SignalBlock) {
        (self.time).extend(samples.time.iter().map(|time| time + samples.later));
        let held = (self.tau.iter_mut()).chain(&mut self.excess);
        for (buffer, column) in held.zip(samples.tau.iter().chain(&samples.excess)) {
            buffer.extend_from_slice(column);
        }
        for (buffer, spring) in self.spring.iter_mut().zip(&samples.spring) {
            buffer.extend_from_slice(spring);
        }
        let links = self.flexible.iter().map(|&joint| &samples.q[joint]);
        let inputs: Vec<&Vec<f64>> = samples.phi.iter().chain(links).collect();
        (self.columns.par_iter_mut().zip(inputs)).for_each(|(column, input)| {
            column.filter.push(input, &mut column.filtered);
        });
        if !samples.is_empty() {
            let has = |all: &[Vec<f64>], joint: usize| {
                all.get(joint).is_some_and(|values| !values.is_empty())
            };
            self.rates.retain(|(joint, _)| has(&samples.rate, *joint));
            (self.accelerations).retain(|(joint, _)| has(&samples.acceleration, *joint));
        }
        for (measured, all) in [
            (&mut self.rates, &samples.rate),
            (&mut self.accelerations, &samples.acceleration),
        ] {
            for (joint, column) in measured {
                let values = all.get(*joint).map_or(&[][..], Vec::as_slice);
                column.filter.push(values, &mut column.filtered);
            }
        }
        self.differentiate(out);
    }

    /// Ends a segment at a gap, like [`Smoother::finish`], and removes the samples beside the gap.
    #[must_use]
    pub(crate) fn finish_at_gap(self, out: &mut SignalBlock) -> bool {
        let edge = self.edge;
        let finished = self.finish(out);
        out.truncate(out.len().saturating_sub(edge));
        finished
    }

    /// Ends the log and appends the remaining samples to `out`.
    ///
    /// Returns false if the log was too short for the filter's padding.
    #[must_use]
    pub(crate) fn finish(mut self, out: &mut SignalBlock) -> bool {
        let measured = self.rates.iter_mut().chain(&mut self.accelerations);
        let measured = measured.map(|(_, column)| column);
        for column in self.columns.iter_mut().chain(measured) {
            if !column.filter.clone().finish(&mut column.filtered) {
                return false;
            }
        }
        self.differentiate(out);
        true
    }

    fn differentiate(&mut self, out: &mut SignalBlock) {
        let ready = (self.columns.first()).map_or(0, |c| c.filtered.len().saturating_sub(2));
        let n = out.phi.len();
        let (motors, links) = self.columns.split_at_mut(n);
        if !self.accelerations.is_empty() {
            let scale = (self.period * self.period).recip();
            for &joint in &self.rigid {
                let bends = motors[joint].filtered.windows(3);
                let bends = bends.map(|w| scale * (w[2] - 2.0 * w[1] + w[0]));
                out.ddq[joint].extend(bends);
            }
            for (joint, column) in &mut self.accelerations {
                column.values(&mut out.ddq[*joint]);
            }
        }
        for (joint, column) in motors.iter_mut().enumerate() {
            column.differentiate(self.period, &mut out.phi[joint], &mut out.dphi[joint]);
        }
        for (column, &joint) in links.iter_mut().zip(&self.flexible) {
            column.differentiate(self.period, &mut out.q[joint], &mut out.dq[joint]);
        }
        let before = out.len();
        for (joint, column) in &mut self.rates {
            let velocity = &mut out.dq[*joint];
            velocity.truncate(before);
            column.values(velocity);
        }
        for &joint in &self.rigid {
            out.q[joint].extend_from_slice(&out.phi[joint][before..]);
            out.dq[joint].extend_from_slice(&out.dphi[joint][before..]);
        }
        // `time` still contains the sample before the first finished sample.
        let kept = self.time.len().min(1);
        out.time.extend_from_slice(&self.time[kept..][..ready]);
        self.time.drain(..ready);
        let torques = self.tau.iter_mut().zip(&mut out.tau);
        let springs = self.spring.iter_mut().zip(&mut out.spring);
        let excesses = self.excess.iter_mut().zip(&mut out.excess);
        let held = torques.chain(springs).chain(excesses);
        // Joints without torque sensor or covariate have empty columns.
        for (buffer, column) in held.filter(|(buffer, _)| !buffer.is_empty()) {
            column.extend_from_slice(&buffer[kept..][..ready]);
            buffer.drain(..ready);
        }
        let dropped = self.to_drop.min(ready);
        self.to_drop -= dropped;
        out.remove(before, dropped);
    }
}
