//! Link positions by sensors on the links: motor position minus filtered deflection.
//!
//! A gyroscope gives the rate of the deflection e, and its integral drifts. The rows of a joint with
//! gyroscope pass the filter `h = s²/(s + w)²`, and h e follows from motor position and gyroscope
//! without drift:
//!
//! ```text
//! h e = h phi - s/(s + w)² dq
//! ```
//!
//! A constant bias of the rate has no effect on h e after the filter has settled.
//!
//! An accelerometer gives the acceleration of the joint, which is integrated twice, so h has one more order:
//!
//! ```text
//! h = s³/(s + w)³        h e = h phi - s/(s + w)³ ddq
//! ```
//!
//! Gravity and the motion of the links below are taken from its reading at the link positions by earlier samples.

use super::high_pass::{HighPass, Stage};
use super::raw_block::RawBlock;
use crate::description::{Inertial, RowFilter};
use crate::log::{Channels, InertialSensors, LinkMotion};

/// Forms the link positions of all joints with such a sensor.
#[derive(Clone, Debug)]
pub(super) struct Deflections {
    filters: Vec<HighPass>,
    by_rate: Vec<DeflectionByRate>,
    by_acceleration: Vec<Option<LinkByAcceleration>>,
    period: f64,
}

impl Deflections {
    /// - `period`: T, s.
    pub(super) fn new(channels: &Channels, period: f64) -> Self {
        let sensors = channels.inertial.iter().flat_map(|inertial| &inertial.all);
        let filters: Vec<HighPass> = sensors
            .filter_map(|sensor| channels.instruments.row_filter(sensor.joint))
            .map(|kind| HighPass::new(&kind, period))
            .collect();
        Self {
            by_rate: vec![DeflectionByRate::default(); filters.len()],
            by_acceleration: (0..channels.instruments.joint_count())
                .map(|joint| channels.instruments.row_filter(joint))
                .map(|filter| filter.map(|filter| LinkByAcceleration::new(&filter, period)))
                .collect(),
            period,
            filters,
        }
    }

    /// Forms the link positions from the sample `before` on.
    pub(super) fn form(&mut self, channels: &Channels, before: usize, out: &mut RawBlock) {
        let Some(sensors) = &channels.inertial else {
            return;
        };
        match sensors.kind {
            Inertial::Gyroscope => self.by_rates(sensors, before, out),
            Inertial::Accelerometer => self.by_accelerations(sensors, before, out),
        }
    }

    fn by_rates(&mut self, sensors: &InertialSensors, before: usize, out: &mut RawBlock) {
        let states = self.by_rate.iter_mut().zip(&self.filters);
        for (sensor, (state, filter)) in sensors.all.iter().zip(states) {
            let (weights, bias) = sensors.rate(sensor);
            for k in before..out.time.len() {
                let sum: f64 = (weights.iter())
                    .map(|&(place, weight)| weight * out.inertial[place][k])
                    .sum();
                let (phi, rate) = (out.phi[sensor.joint][k], sum - bias);
                let deflection = state.process(filter, phi, rate);
                out.q[sensor.joint].push(phi - deflection);
                out.rate[sensor.joint].push(rate);
            }
        }
    }
}

impl Deflections {
    fn by_accelerations(&mut self, sensors: &InertialSensors, before: usize, out: &mut RawBlock) {
        for k in before..out.time.len() {
            let mut links: Vec<LinkMotion> = Vec::with_capacity(self.by_acceleration.len());
            for (joint, state) in self.by_acceleration.iter_mut().enumerate() {
                let phi = out.phi[joint][k];
                let index = sensors.all.iter().position(|sensor| sensor.joint == joint);
                let instrument = index.map(|i| (&sensors.all[i], &self.filters[i]));
                let Some(((sensor, filter), state)) = instrument.zip(state.as_mut()) else {
                    // No link above carries a sensor.
                    links.push(sensors.next(&links, [phi, 0.0, 0.0]));
                    continue;
                };
                let reading = [0, 1, 2].map(|axis| {
                    let column = out.inertial.get(3 * joint + axis);
                    (column.and_then(|column| column.get(k)).copied()).unwrap_or_default()
                });
                let [q, dq] = state.predicted(phi, self.period);
                let ddq = sensors.acceleration(sensor, &links, [q, dq], &reading);
                links.push(sensors.next(&links, [q, dq, ddq]));
                state.process(filter, phi, ddq);
                out.q[joint].push(state.q);
                out.rate[joint].push(state.dq);
                out.acceleration[joint].push(ddq);
            }
        }
    }
}

/// Corner of the filter of the velocity over that of the row. One integration drifts less than two, and with a lower
/// corner the link's velocity contains less of the motor's.
const SLOWER: f64 = 0.2;

/// The link position and velocity of a joint from its motor position and the acceleration of the joint.
#[derive(Clone, Copy, Debug)]
struct LinkByAcceleration {
    /// w of the velocity, rad/s, and its filter.
    corner: f64,
    slower: HighPass,
    motor: [Stage; 3],
    link: [Stage; 3],
    /// Of the velocity by the motor, and by the link.
    slow: [Stage; 3],
    fast: [Stage; 2],
    /// Position, velocity and acceleration of the link.
    q: f64,
    dq: f64,
    ddq: f64,
    has_begun: bool,
}

impl LinkByAcceleration {
    /// - `row`: filter of the row; `period`: T, s.
    fn new(row: &RowFilter, period: f64) -> Self {
        let slower = RowFilter {
            corner: SLOWER * row.corner,
            ..*row
        };
        Self {
            corner: slower.corner,
            slower: HighPass::new(&slower, period),
            motor: Default::default(),
            link: Default::default(),
            slow: Default::default(),
            fast: Default::default(),
            q: 0.0,
            dq: 0.0,
            ddq: 0.0,
            has_begun: false,
        }
    }

    /// Returns position and velocity of the link at the next sample, before its acceleration is known.
    fn predicted(&self, phi: f64, period: f64) -> [f64; 2] {
        if !self.has_begun {
            return [phi, 0.0];
        }
        let dq = self.dq + period * self.ddq;
        [self.q + 0.5 * period * (self.dq + dq), dq]
    }

    /// Takes the acceleration of the joint.
    fn process(&mut self, filter: &HighPass, phi: f64, ddq: f64) {
        if !self.has_begun {
            self.has_begun = true;
            self.motor[0].input = phi;
            self.slow[0].input = phi;
            self.link[0].input = ddq;
            self.fast[0].input = ddq;
        }
        let high = filter.process(&mut self.motor, phi);
        let [first, second, third] = &mut self.link;
        let position = filter.sum(first, ddq);
        let position = filter.sum(second, position);
        self.q = phi - (high - filter.rise(third, position));
        // s (1 - s²/(s + w)²) phi + s/(s + w)² ddq, with the lower corner.
        let (w, slower) = (self.corner, &self.slower);
        let [first, second, third] = &mut self.slow;
        let once = slower.rise(first, phi);
        let by_motor = w * (2.0 * slower.rise(second, once) + w * slower.sum(third, once));
        let [first, second] = &mut self.fast;
        let integral = slower.sum(first, ddq);
        self.dq = by_motor + slower.rise(second, integral);
        self.ddq = ddq;
    }
}

/// The filtered deflection of a joint from its motor position and the rate of its link.
#[derive(Clone, Copy, Debug, Default)]
struct DeflectionByRate {
    motor: [Stage; 2],
    link: [Stage; 2],
    has_begun: bool,
}

impl DeflectionByRate {
    /// Returns h e, rad.
    ///
    /// - `phi`: motor position, rad; `rate`: rate of the link, rad/s.
    fn process(&mut self, filter: &HighPass, phi: f64, rate: f64) -> f64 {
        if !self.has_begun {
            self.has_begun = true;
            self.motor[0].input = phi;
            self.link[0].input = rate;
            return 0.0;
        }
        let [integral, high] = &mut self.link;
        let integral = filter.sum(integral, rate);
        filter.process(&mut self.motor, phi) - filter.rise(high, integral)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deflections_from_rates_equal_filtered_deflections() {
        let (corner, period) = (1.3, 1e-3);
        let filter = HighPass::new(
            &RowFilter {
                corner,
                order: 2,
                settling_time_constants: 6.0,
            },
            period,
        );
        let mut by_rate = DeflectionByRate::default();
        let mut exact = [Stage::default(); 2];
        let mut worst = 0.0_f64;
        for k in 0..20_000_u64 {
            let t = k as f64 * period;
            let deflection = 0.05 * (7.0 * t).sin();
            let q = (2.0 * t).sin();
            // The rate has a bias of 0.02 rad/s.
            let rate = 2.0 * (2.0 * t).cos() + 0.02;
            let found = by_rate.process(&filter, q + deflection, rate);
            let expected = filter.process(&mut exact, deflection);
            if k > 2 * filter.settling() {
                worst = worst.max((found - expected).abs());
            }
        }
        // The bias decays as t exp(-corner t), and 12 time constants have passed. The trapezoidal rule integrates the
        // motion of the link at 2 rad/s with an error of (ωT)²/12.
        let bias = 0.02 / corner * 12.0 * (-12.0_f64).exp();
        let limit = bias + (2.0 * period).powi(2) / 12.0;
        assert!(worst < limit, "{worst:e}");
    }
    #[test]
    fn links_follow_from_accelerations() {
        let period = 1e-3;
        let row = RowFilter {
            corner: 1.9,
            order: 3,
            settling_time_constants: 9.0,
        };
        let filter = HighPass::new(&row, period);
        let mut link = LinkByAcceleration::new(&row, period);
        let mut exact = [Stage::default(); 3];
        let mut worst = [0.0_f64; 2];
        for k in 0..60_000_u64 {
            let t = k as f64 * period;
            let deflection = 0.05 * (7.0 * t).sin();
            let (q, dq) = ((2.0 * t).sin(), 2.0 * (2.0 * t).cos());
            // The acceleration has a bias of 0.5 rad/s².
            link.process(&filter, q + deflection, -4.0 * (2.0 * t).sin() + 0.5);
            let high = filter.process(&mut exact, deflection);
            if k > 10 * filter.settling() {
                worst[0] = worst[0].max((link.q - (q + deflection - high)).abs());
                worst[1] = worst[1].max((link.dq - dq).abs());
            }
        }
        // Errors of the integration; the velocity has a tenth of the deflection's rate,
        // 0.35 rad/s, and the rest of the bias.
        assert!(worst[0] < 1e-4 && worst[1] < 0.1, "{worst:?}");
    }
}
