//! Filtered positions and their derivatives.

use std::collections::VecDeque;

use sprung_core::regressor::JointState;

use super::align::RawSample;
use super::zero_phase::{Butterworth, ZeroPhase};
use crate::model::JOINT_COUNT;

const POSITIONS: usize = 2 * JOINT_COUNT;

/// One sample that a regressor can use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signal {
    /// Time, s.
    pub time: f64,
    /// Positions and velocities.
    pub state: JointState,
    /// Motor torques, N·m, held until the next sample.
    pub tau: [f64; JOINT_COUNT],
}

/// Filters positions without phase shift and differentiates them.
///
/// The first and the last sample are lost to the central difference.
///
/// # Source
///
/// Section 2.3.3 and eq. (27).
#[derive(Clone, Debug)]
pub struct Smoother {
    filters: Vec<ZeroPhase>,
    filtered: Vec<Vec<f64>>,
    waiting: VecDeque<(f64, [f64; JOINT_COUNT])>,
    column: Vec<f64>,
    period: f64,
}

impl Smoother {
    /// Returns a smoother that has seen nothing.
    ///
    /// - `period`: T, s.
    #[must_use]
    pub fn new(filter: &Butterworth, period: f64) -> Self {
        Self {
            filters: vec![ZeroPhase::new(filter.clone()); POSITIONS],
            filtered: vec![Vec::new(); POSITIONS],
            waiting: VecDeque::new(),
            column: Vec::new(),
            period,
        }
    }

    /// Takes samples and appends those that are ready to `out`.
    pub fn push(&mut self, samples: &[RawSample], out: &mut Vec<Signal>) {
        self.waiting
            .extend(samples.iter().map(|sample| (sample.time, sample.tau)));
        for (i, (filter, filtered)) in self.filters.iter_mut().zip(&mut self.filtered).enumerate() {
            self.column.clear();
            self.column.extend(samples.iter().map(|sample| {
                if i < JOINT_COUNT {
                    sample.q[i]
                } else {
                    sample.phi[i - JOINT_COUNT]
                }
            }));
            filter.push(&self.column, filtered);
        }
        self.differentiate(out);
    }

    /// Ends the log and appends the remaining samples to `out`.
    ///
    /// Returns false if the log was too short for the filter's padding.
    #[must_use]
    pub fn finish(mut self, out: &mut Vec<Signal>) -> bool {
        for (filter, filtered) in std::mem::take(&mut self.filters)
            .into_iter()
            .zip(&mut self.filtered)
        {
            if !filter.finish(filtered) {
                return false;
            }
        }
        self.differentiate(out);
        true
    }

    fn differentiate(&mut self, out: &mut Vec<Signal>) {
        let ready = self.filtered[0].len().saturating_sub(2);
        let scale = 0.5 / self.period;
        for k in 1..=ready {
            // `waiting` still holds the sample before.
            let (time, tau) = self.waiting[1];
            self.waiting.pop_front();
            let position = |i: usize| self.filtered[i][k];
            let velocity = |i: usize| scale * (self.filtered[i][k + 1] - self.filtered[i][k - 1]);
            out.push(Signal {
                time,
                state: JointState {
                    q: std::array::from_fn(position),
                    dq: std::array::from_fn(velocity),
                    phi: std::array::from_fn(|i| position(i + JOINT_COUNT)),
                    dphi: std::array::from_fn(|i| velocity(i + JOINT_COUNT)),
                },
                tau,
            });
        }
        for filtered in &mut self.filtered {
            filtered.drain(..ready);
        }
    }
}
