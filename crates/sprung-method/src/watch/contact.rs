//! Torques from outside that exceed their threshold.

use super::learn::JointMonitor;
use super::monitor::HOLD_S;

/// A torque from outside on one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    pub(super) joint: usize,
    /// First and last time above the threshold, s.
    pub(super) span: [f64; 2],
    /// Largest torque with its sign, and the threshold at that time, N·m (N).
    pub(super) torque: f64,
    pub(super) threshold: f64,
}

/// Time around a sensor that shows nothing in which a torque is no contact, s.
const MARGIN_S: f64 = 0.3;

impl Contact {
    /// Returns whether it is in or near one of some spans.
    pub(super) fn is_within(&self, spans: &[[f64; 2]]) -> bool {
        let [begin, end] = self.span;
        (spans.iter()).any(|span| begin < span[1] + MARGIN_S && end > span[0] - MARGIN_S)
    }
}

/// Finds torques above their thresholds, joint by joint.
#[derive(Clone)]
pub(super) struct Contacts {
    /// Threshold of each joint in standard deviations; infinite if it is not known.
    thresholds: Vec<f64>,
    open: Vec<Option<Contact>>,
    /// Whether the zero of the encoders at the spring is known.
    is_zero_known: Vec<bool>,
}

impl Contacts {
    /// - `rate`: false alarms that all joints together may have, 1/s; `bandwidth`: of the residuals, rad/s.
    pub(super) fn new(joints: &[JointMonitor], rate: f64, bandwidth: f64) -> Self {
        let of_joint = rate / joints.len().max(1) as f64;
        Self {
            thresholds: (joints.iter())
                .map(|joint| joint.threshold(of_joint, bandwidth))
                .collect(),
            open: vec![None; joints.len()],
            is_zero_known: vec![false; joints.len()],
        }
    }

    /// Returns the thresholds, in standard deviations.
    pub(super) fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    /// Takes the torque of a joint with its standard deviation; returns a contact that has ended.
    ///
    /// When the zero of the encoders becomes known, a contact that lasts is forgotten, because the zero was its cause.
    ///
    /// - `is_zero_known`: whether this zero is known.
    pub(super) fn take(
        &mut self,
        joint: usize,
        time: f64,
        [torque, deviation]: [f64; 2],
        is_zero_known: bool,
    ) -> Option<Contact> {
        let threshold = self.thresholds[joint] * deviation;
        let was_known = std::mem::replace(&mut self.is_zero_known[joint], is_zero_known);
        if is_zero_known && !was_known {
            self.open[joint] = None;
        }
        let open = &mut self.open[joint];
        let mut ended = None;
        if open.is_some_and(|contact| time - contact.span[1] > HOLD_S) {
            ended = open.take();
        }
        if torque.abs() > threshold {
            let contact = open.get_or_insert(Contact {
                joint,
                span: [time; 2],
                torque,
                threshold,
            });
            contact.span[1] = time;
            if torque.abs() / threshold > contact.torque.abs() / contact.threshold {
                (contact.torque, contact.threshold) = (torque, threshold);
            }
        }
        ended
    }

    /// Returns the contacts that last.
    pub(super) fn open(&self) -> impl Iterator<Item = &Contact> {
        self.open.iter().flatten()
    }

    /// Forgets the contacts that last.
    pub(super) fn forget(&mut self) {
        self.open.fill(None);
    }

    /// Returns the contacts that last until the filters begin again.
    pub(super) fn end(&mut self) -> Vec<Contact> {
        self.open.iter_mut().filter_map(Option::take).collect()
    }
}
