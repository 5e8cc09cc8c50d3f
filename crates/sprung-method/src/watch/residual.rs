//! Residuals of the equations of motion along a log, sample by sample.

use sprung_core::drives::State;
use sprung_core::filter::FilterState;
use sprung_core::observer::{Chain3, ObserverFilters, ZeroTorque};
use sprung_core::robot::Values;
use sprung_core::spatial::BODY;

use crate::model::{Elements, Model, Scratch, Theta};
use crate::preprocess::RawBlock;

/// Quantities with which the error of a model grows.
pub(super) const FEATURES: usize = 5;

/// Memory of the observer along one log.
pub(super) struct Residuals<'m> {
    model: &'m Model,
    theta: &'m Theta,
    bodies: Vec<[f64; BODY]>,
    filters: ObserverFilters,
    scratch: Scratch,
    elements: Elements,
    /// Link positions, motor positions, motor torques, torques of springs, each \[n\].
    chains: [Vec<Chain3>; 4],
    last: Vec<FilterState>,
    of_features: Vec<FilterState>,
    zeros: Vec<ZeroTorque>,
    /// Samples since the filters have begun.
    since: usize,
    pub(super) now: Now,
}

/// The last sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Now {
    pub(super) q: Vec<f64>,
    pub(super) dq: Vec<f64>,
    pub(super) phi: Vec<f64>,
    pub(super) dphi: Vec<f64>,
    pub(super) excess: Vec<f64>,
    pub(super) elements: Vec<f64>,
    /// Acceleration of each coordinate, \[rows\], rad/s² (m/s²).
    pub(super) acceleration: Vec<f64>,
    /// Filtered torque less that of the model, \[rows\], N·m (N).
    pub(super) residual: Vec<f64>,
    /// Squares of the filtered quantities with which the error of a model grows, joint by joint: one, velocity, torque,
    /// acceleration, and nearness of a reversal.
    pub(super) features: Vec<[f64; FEATURES]>,
    /// Constant residual of each motor by another zero of an encoder, N·m (N); `None` while it is not known.
    pub(super) zeros: Vec<Option<f64>>,
}

impl Now {
    pub(super) fn state(&self) -> State<'_> {
        State {
            q: &self.q,
            dq: &self.dq,
            phi: &self.phi,
            dphi: &self.dphi,
            excess: &self.excess,
            elements: &self.elements,
        }
    }
}

impl<'m> Residuals<'m> {
    pub(super) fn new((model, theta): (&'m Model, &'m Theta), filters: ObserverFilters) -> Self {
        let (n, rows) = (model.joint_count(), model.coordinates());
        let chains = || vec![Chain3::default(); n];
        Self {
            bodies: model.bodies(theta),
            filters,
            scratch: Scratch::new(n),
            elements: model.elements(),
            chains: [chains(), chains(), chains(), chains()],
            last: vec![FilterState::default(); rows],
            of_features: vec![FilterState::default(); n * FEATURES],
            zeros: vec![ZeroTorque::default(); n],
            since: 0,
            now: Now {
                acceleration: vec![0.0; rows],
                residual: vec![0.0; rows],
                features: vec![[0.0; FEATURES]; n],
                zeros: vec![None; n],
                ..Now::default()
            },
            model,
            theta,
        }
    }

    /// Begins another log, or continues behind a gap.
    pub(super) fn restart(&mut self) {
        self.since = 0;
        self.zeros.fill(ZeroTorque::default());
        self.last.fill(FilterState::default());
        self.of_features.fill(FilterState::default());
        self.elements.restart();
    }

    /// Returns the samples after which the filters have settled.
    pub(super) fn settle(&self) -> usize {
        self.filters.settle()
    }

    /// Returns whether the filters have settled.
    pub(super) fn is_settled(&self) -> bool {
        self.since > self.filters.settle()
    }

    /// Takes sample `k` of a block; its residuals are in `now`.
    pub(super) fn take(&mut self, samples: &RawBlock, k: usize) {
        let columns = [&samples.q, &samples.phi, &samples.tau, &samples.spring];
        let columns = columns.map(|columns| RawBlock::at(columns, k));
        self.step(columns.each_ref().map(Vec::as_slice), samples.excess_at(k));
    }

    /// Takes a sample.
    ///
    /// - `signals`: positions of links and motors, torques of motors and of sensors, each \[n\]; `excess`: covariates minus their
    ///   references.
    pub(super) fn step(&mut self, [q, phi, tau, spring]: [&[f64]; 4], excess: Vec<f64>) {
        self.since += 1;
        if self.since == 1 {
            let filters = &self.filters;
            for (chains, values) in self.chains.iter_mut().zip([q, phi, tau, spring]) {
                for (chain, value) in chains.iter_mut().zip(values) {
                    *chain = Chain3::settled(filters, *value);
                }
            }
            for (chain, value) in self.chains[2].iter_mut().zip(tau) {
                *chain = Chain3::settled_held(filters, *value);
            }
        }
        let filters = &self.filters;
        let [links, motors, torques, springs] = &mut self.chains;
        let now = &mut self.now;
        let moves = |chains: &mut [Chain3], values: &[f64]| -> Vec<[f64; 3]> {
            let all = chains.iter_mut().zip(values);
            all.map(|(chain, value)| filters.motion(chain, *value))
                .collect()
        };
        let (of_links, of_motors) = (moves(links, q), moves(motors, phi));
        let column = |of: &[[f64; 3]], order: usize| of.iter().map(|x| x[order]).collect();
        (now.q, now.dq) = (column(&of_links, 0), column(&of_links, 1));
        (now.phi, now.dphi) = (column(&of_motors, 0), column(&of_motors, 1));
        let robot = self.model.regressor();
        for (joint, (link, motor)) in of_links.iter().zip(&of_motors).enumerate() {
            now.acceleration[joint] = link[2];
            now.acceleration[robot.motor_coordinate(joint)] = motor[2];
        }
        let tau: Vec<f64> = (torques.iter_mut().zip(tau))
            .map(|(chain, value)| filters.held(chain, *value))
            .collect();
        let spring: Vec<f64> = (springs.iter_mut().zip(spring))
            .map(|(chain, value)| filters.continuous(chain, *value))
            .collect();
        now.excess = excess;
        now.elements.clear();
        now.elements
            .extend_from_slice(self.elements.advance(&now.q, &now.phi));
        let values = Values {
            theta: self.theta,
            bodies: &self.bodies,
        };
        let mut required = vec![0.0; now.residual.len()];
        let computed = robot.required_torques(
            &values,
            &now.state(),
            &now.acceleration,
            &mut self.scratch.workspace(),
            &mut required,
        );
        if computed.is_err() {
            required.fill(f64::NAN);
        }
        for (row, (required, memory)) in required.iter().zip(&mut self.last).enumerate() {
            let [motor, sensor] = self.model.right_hand_side(row).torques();
            let mut torque = motor.map_or(0.0, |joint| tau[joint]);
            if let Some(joint) = sensor {
                torque += if motor.is_some() {
                    -spring[joint]
                } else {
                    spring[joint]
                };
            }
            now.residual[row] = filters.last(memory, torque - required);
        }
        let is_settled = self.since > filters.settle();
        for (joint, &torque) in tau.iter().enumerate() {
            let velocity = now.dphi[joint];
            let direction = (self.model.sharpness(joint) * velocity).tanh();
            let motor = robot.motor_coordinate(joint);
            if is_settled && motor != joint {
                let zero = &mut self.zeros[joint];
                zero.take(
                    filters,
                    direction,
                    [now.residual[joint], now.residual[motor]],
                );
                now.zeros[joint] = zero.of_motor();
            }
            let raw = [
                1.0,
                velocity,
                torque,
                now.acceleration[motor],
                1.0 - direction * direction,
            ];
            let memories = &mut self.of_features[joint * FEATURES..];
            for ((feature, memory), raw) in now.features[joint].iter_mut().zip(memories).zip(raw) {
                *feature = filters.last(memory, raw.abs()).powi(2);
            }
            now.features[joint][0] = 1.0;
        }
    }
}
