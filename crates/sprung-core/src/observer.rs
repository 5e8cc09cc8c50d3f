//! Torques from outside, on line: the filtered torques less those that the model needs for the filtered motion.
//!
//! All signals pass the same three low-pass filters in series. Then velocity and acceleration are exact
//! derivatives of the filtered position, and positions and torques have the same delay:
//!
//! ```text
//! L(s) = ω/(s + ω)      x = L³ y      ẋ = ω (L² y − x)      ẍ = ω² (L y − 2 L² y + x)
//! ```
//!
//! A last filter `λ/(s + λ)` removes the noise of the accelerations. With the momentum `p = M(q) q̇` of the filtered motion the
//! result is the residual of the observer of generalised momentum:
//!
//! ```text
//! r = λ/(s + λ) [τ − M q̈ − h(q, q̇)] = λ (∫ (τ + Ṁ q̇ − h − r) dt − p)
//! ```
//!
//! [`ZeroTorque`] is the constant part that another zero of an encoder adds.
//!
//! # Source
//!
//! De Luca, Albu-Schäffer, Haddadin and Hirzinger, IROS 2006: the observer of generalised momentum, and its form for
//! flexible joints.

use crate::filter::{Discretization, FilterError, FilterPair, FilterState};

/// Time constants of the last filter after which an observer has settled.
const SETTLED: f64 = 8.0;

/// Motion that the torque of a zero remembers, in each direction, s.
pub const ZERO_MEMORY_S: f64 = 10.0;

/// Motion in each direction from which the torque of a zero is known, s.
pub const ZERO_KNOWN_S: f64 = 0.5;

/// The filters of an observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserverFilters {
    /// Of continuous signals.
    continuous: FilterPair,
    /// The first one of a torque that is held between samples.
    held: FilterPair,
    /// The last one, of the residuals.
    last: FilterPair,
    /// ω, rad/s.
    cutoff: f64,
    /// T, s.
    period: f64,
    settle: usize,
}

/// Outputs of three low-pass filters in series.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chain3 {
    states: [FilterState; 3],
    outputs: [f64; 3],
}

impl ObserverFilters {
    /// - `cutoff`: ω of the three filters, `bandwidth`: λ of the last one, rad/s; `period`: T, s.
    ///
    /// # Errors
    ///
    /// [`FilterError`] if a value is not positive and finite.
    pub fn new(cutoff: f64, bandwidth: f64, period: f64) -> Result<Self, FilterError> {
        let tustin = |of: f64| FilterPair::new(of, period, Discretization::Tustin);
        Ok(Self {
            continuous: tustin(cutoff)?,
            held: FilterPair::new(cutoff, period, Discretization::ZeroOrderHold)?,
            last: tustin(bandwidth)?,
            cutoff,
            period,
            settle: libm::ceil(SETTLED / (bandwidth * period)) as usize,
        })
    }

    /// Returns the samples after which the observer has settled.
    #[must_use]
    pub fn settle(&self) -> usize {
        self.settle
    }

    /// Filters a position and returns it with its velocity and acceleration.
    pub fn motion(&self, chain: &mut Chain3, position: f64) -> [f64; 3] {
        chain.process(&self.continuous, &self.continuous, position);
        let [one, two, three] = chain.outputs;
        let w = self.cutoff;
        [
            three,
            w * (two - three),
            w * w * (one - two - (two - three)),
        ]
    }

    /// Filters a torque that is held from each sample to the next.
    pub fn held(&self, chain: &mut Chain3, torque: f64) -> f64 {
        chain.process(&self.held, &self.continuous, torque)
    }

    /// Filters a continuous signal.
    pub fn continuous(&self, chain: &mut Chain3, value: f64) -> f64 {
        chain.process(&self.continuous, &self.continuous, value)
    }

    /// Filters a residual once more; the first one begins at rest.
    pub fn last(&self, state: &mut FilterState, residual: f64) -> f64 {
        self.last.process(state, 0.0, residual)
    }
}

impl Chain3 {
    /// Returns the filters after they have received the same value for ever.
    #[must_use]
    pub fn settled(filters: &ObserverFilters, value: f64) -> Self {
        Self {
            states: [FilterState::settled(&filters.continuous, value); 3],
            outputs: [value; 3],
        }
    }

    /// Returns the filters of a held torque after they have received the same value for ever.
    #[must_use]
    pub fn settled_held(filters: &ObserverFilters, value: f64) -> Self {
        let mut settled = Self::settled(filters, value);
        settled.states[0] = FilterState::settled(&filters.held, value);
        settled
    }

    fn process(&mut self, first: &FilterPair, others: &FilterPair, value: f64) -> f64 {
        let mut value = value;
        for (at, (state, output)) in (self.states.iter_mut().zip(&mut self.outputs)).enumerate() {
            let pair = if at == 0 { first } else { others };
            value = pair.process(state, 0.0, value);
            *output = value;
        }
        value
    }
}

/// The constant torque of a spring at whose encoders the zero is not that of the identification: an incremental encoder has
/// another one after each start.
///
/// It has opposite signs in the equations of link and motor; a torque from outside is in that of the link alone, and an offset of the
/// motor's torque in that of the motor alone. The mean of both directions of motion does not contain an error of the friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ZeroTorque {
    /// Motion in each direction, s.
    motion: [f64; 2],
    /// Mean residuals of link and motor in each direction, N·m (N).
    means: [[f64; 2]; 2],
}

impl ZeroTorque {
    /// Takes the residuals of link and motor, N·m (N).
    ///
    /// - `direction`: that of the motion, from −1 to 1; near 0 its friction is not known.
    pub fn take(&mut self, filters: &ObserverFilters, direction: f64, residuals: [f64; 2]) {
        let at = usize::from(direction < 0.0);
        let weight = direction * direction * filters.period;
        let motion = &mut self.motion[at];
        *motion = (*motion + weight).min(ZERO_MEMORY_S);
        if *motion > 0.0 {
            for (mean, residual) in self.means[at].iter_mut().zip(residuals) {
                *mean += weight / *motion * (residual - *mean);
            }
        }
    }

    /// Returns the torque in the equation of the motor, N·m (N); `None` until the joint has moved in both directions.
    #[must_use]
    pub fn of_motor(&self) -> Option<f64> {
        if self.motion.iter().any(|motion| *motion < ZERO_KNOWN_S) {
            return None;
        }
        let [link, motor] =
            core::array::from_fn(|at| 0.5 * (self.means[0][at] + self.means[1][at]));
        let size = libm::fmin(libm::fabs(link), libm::fabs(motor));
        Some(if link * motor < 0.0 {
            libm::copysign(size, motor)
        } else {
            0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 1e-3;

    fn filters() -> ObserverFilters {
        ObserverFilters::new(200.0, 50.0, PERIOD).unwrap()
    }

    #[test]
    fn velocity_and_acceleration_are_derivatives_of_the_filtered_position() {
        let filters = filters();
        let mut chain = Chain3::settled(&filters, 0.0);
        let mut all = [[0.0; 3]; 3];
        for k in 0..400 {
            all.rotate_left(1);
            let t = f64::from(k) * PERIOD;
            all[2] = filters.motion(&mut chain, libm::sin(9.0 * t));
        }
        // The trapezoidal rule, which is that of the filters.
        for order in 0..2 {
            let rise = all[2][order] - all[1][order];
            let mean = 0.5 * (all[2][order + 1] + all[1][order + 1]);
            assert!((rise - PERIOD * mean).abs() < 1e-13, "{order}");
        }
    }

    #[test]
    fn a_parabola_has_its_acceleration_and_all_signals_the_same_delay() {
        let filters = filters();
        let mut position = Chain3::settled(&filters, 0.0);
        let mut torque = Chain3::settled_held(&filters, 0.0);
        let (mut motion, mut held) = ([0.0; 3], 0.0);
        let ramp = |t: f64| 3.0 * t;
        for k in 0..2000 {
            let t = f64::from(k) * PERIOD;
            motion = filters.motion(&mut position, t * t);
            // Held: on average half a sample behind its stamp.
            held = filters.held(&mut torque, ramp(t + 0.5 * PERIOD));
        }
        let end = 1999.0 * PERIOD;
        assert!((motion[2] - 2.0).abs() < 1e-9);
        let delay = end - 0.5 * motion[1];
        assert!((delay - 3.0 / 200.0).abs() < 1e-9, "{delay}");
        assert!(
            (held - ramp(end - delay)).abs() < 1e-4 * ramp(end),
            "{held}"
        );
    }

    #[test]
    fn a_constant_signal_stays_and_a_step_of_the_residual_is_seen() {
        let filters = filters();
        let mut chain = Chain3::settled_held(&filters, 7.0);
        for _ in 0..50 {
            assert!((filters.held(&mut chain, 7.0) - 7.0).abs() < 1e-12);
        }
        let mut state = FilterState::default();
        let mut seen = 0.0;
        for _ in 0..=50 {
            seen = filters.last(&mut state, 1.0);
        }
        assert!(
            (seen - (1.0 - libm::exp(-50.0 * 50e-3))).abs() < 0.01,
            "{seen}"
        );
    }

    #[test]
    fn the_torque_of_a_zero_is_no_contact_no_offset_of_the_motor_and_no_friction() {
        let filters = filters();
        let seen = |link: f64, motor: f64, friction: f64| {
            let mut zero = ZeroTorque::default();
            for k in 0..4000 {
                let direction = if k % 1000 < 400 { 1.0 } else { -1.0 };
                zero.take(&filters, direction, [link, motor + friction * direction]);
            }
            zero.of_motor().unwrap()
        };
        assert!((seen(2.0, -2.0, 0.5) + 2.0).abs() < 1e-9);
        assert!((seen(-3.0, 2.0, 0.5) - 2.0).abs() < 1e-9);
        assert!(seen(2.0, 0.5, 0.0) == 0.0 && seen(0.0, 2.0, 0.5) == 0.0);
        assert!(seen(0.0, -1.0, 0.5).abs() < 1e-9);
        let mut forward = ZeroTorque::default();
        for _ in 0..4000 {
            forward.take(&filters, 1.0, [2.0, -2.0]);
        }
        assert_eq!(forward.of_motor(), None);
    }
}
