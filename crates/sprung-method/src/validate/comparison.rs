//! Compares candidates with a log, sample by sample.

use super::candidate::{COMPARED, Candidate, MEASURED};
use crate::curves::CurveSet;
use crate::description::Controller;
use crate::model::Theta;
use crate::preprocess::{Decimator, RawBlock};
use crate::regression::{Observer, Restart};

/// Limit of the points of a curve.
const POINTS_OF_CURVES: usize = 2048;

/// Runs every candidate along the log.
pub(super) struct Comparison<'a> {
    controller: Option<&'a Controller>,
    candidates: &'a mut [Candidate],
    /// Change of theta by the payload of each remaining log, the last log first.
    payloads: Vec<Option<Theta>>,
    /// The change by the payload of the present log.
    carried: Option<Theta>,
    points: Decimator<Point>,
    started: bool,
    gap: bool,
}

impl<'a> Comparison<'a> {
    /// Returns a comparison for a new run; loops are simulated if there is a controller.
    ///
    /// - `payloads`: change of theta by the payload of each log.
    pub(super) fn new(
        controller: Option<&'a Controller>,
        candidates: &'a mut [Candidate],
        payloads: impl DoubleEndedIterator<Item = Option<Theta>>,
    ) -> Self {
        Self {
            controller,
            candidates,
            payloads: payloads.rev().collect(),
            carried: None,
            points: Decimator::new(POINTS_OF_CURVES),
            started: false,
            gap: false,
        }
    }

    /// Returns whether a gap ended the simulation of a loop.
    pub(super) fn ended_at_gap(&self) -> bool {
        self.gap && self.controller.is_some()
    }

    /// Returns the measured curves, then one set per shown candidate.
    ///
    /// - `joints`: number of joints.
    pub(super) fn curves(self, joints: usize) -> Vec<CurveSet> {
        curves(self.candidates, &self.points.into_items(), joints)
    }
}

impl Observer for Comparison<'_> {
    fn restart(&mut self, why: Restart) {
        match why {
            Restart::Begin => {
                self.started = false;
                self.carried = self.payloads.pop().flatten();
            }
            Restart::Gap => {
                self.gap = true;
                self.candidates.iter_mut().for_each(Candidate::stop);
            }
        }
    }

    fn raw(&mut self, period: f64, samples: &RawBlock) {
        for k in 0..samples.len() {
            if !std::mem::replace(&mut self.started, true)
                && let Some(controller) = self.controller
            {
                let (q, phi) = (RawBlock::at(&samples.q, k), RawBlock::at(&samples.phi, k));
                for candidate in &mut *self.candidates {
                    candidate.start(controller, period, (&q, &phi), self.carried.as_deref());
                }
            }
            let modelled: Vec<_> = (self.candidates.iter_mut())
                .map(|candidate| candidate.compare(samples, k))
                .collect();
            self.points.push(|| Point {
                time: samples.time[k] + samples.later,
                measured: [&samples.q, &samples.phi, &samples.tau]
                    .into_iter()
                    .flat_map(|columns| RawBlock::at(columns, k))
                    .collect(),
                modelled,
            });
        }
    }
}

/// One sample: measured values and those of each candidate.
struct Point {
    time: f64,
    measured: Vec<f64>,
    modelled: Vec<Vec<Option<f64>>>,
}

fn curves(candidates: &[Candidate], points: &[Point], joints: usize) -> Vec<CurveSet> {
    let time: Vec<f64> = points.iter().map(|point| point.time).collect();
    let collect = |label: &str, of: &dyn Fn(&Point, usize) -> Option<f64>| CurveSet {
        label: label.to_owned(),
        time: time.clone(),
        values: (0..COMPARED * joints)
            .map(|at| points.iter().map(|point| of(point, at)).collect())
            .collect(),
    };
    let measured = collect(MEASURED, &|point, at| Some(point.measured[at]));
    // A loop that runs away would dwarf all other curves.
    let shown = (candidates.iter().enumerate()).filter(|(_, candidate)| candidate.is_shown());
    std::iter::once(measured)
        .chain(shown.map(|(index, candidate)| {
            collect(&candidate.label, &|point, at| point.modelled[index][at])
        }))
        .collect()
}
