//! A position servo that moves a pendulum: drive law, friction of a gear under load, and motion.
//!
//! The log of such a servo has targets and positions and no torque. The torque of the motor follows
//! from the drive law. The friction can hold the joint at rest, so a step in time stops the joint if
//! the friction suffices.
//!
//! # Source
//!
//! M. Duclusaud, G. Passault, V. Padois and O. Ly, *Extended friction models for the physics
//! simulation of servo actuators*, ICRA 2025: the models m1 to m6.

use crate::scalar::Scalar;

/// A parameter of a servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ServoParameter {
    /// Torque of the motor at standstill per volt of the winding, or per ampere.
    TorquePerCommand,
    /// Back-EMF per velocity of the output.
    BackEmf,
    /// Inertia of rotor and gear at the output.
    Armature,
    /// Viscous friction.
    Viscous,
    /// Coulomb friction.
    Coulomb,
    /// Additional friction at rest.
    Stribeck,
    /// Friction per torque of the motor.
    LoadMotor,
    /// Friction per external torque.
    LoadExternal,
    /// Additional friction at rest per torque of the motor.
    LoadMotorStribeck,
    /// Additional friction at rest per external torque.
    LoadExternalStribeck,
    /// Additional friction at rest per squared torque of the motor, while the load drives it.
    LoadMotorQuadratic,
    /// Additional friction at rest per squared external torque, while the motor drives the load.
    LoadExternalQuadratic,
    /// Natural logarithm of the velocity at which the Stribeck friction has fallen to 1/e.
    LogStribeckVelocity,
    /// Exponent of the Stribeck friction.
    StribeckExponent,
    /// Angle that is added to a reading of the position to obtain the angle for gravity.
    ZeroOffset,
}

impl ServoParameter {
    /// Number of parameters.
    pub const COUNT: usize = 15;

    /// All parameters, in their order.
    pub const ALL: [Self; Self::COUNT] = [
        Self::TorquePerCommand,
        Self::BackEmf,
        Self::Armature,
        Self::Viscous,
        Self::Coulomb,
        Self::Stribeck,
        Self::LoadMotor,
        Self::LoadExternal,
        Self::LoadMotorStribeck,
        Self::LoadExternalStribeck,
        Self::LoadMotorQuadratic,
        Self::LoadExternalQuadratic,
        Self::LogStribeckVelocity,
        Self::StribeckExponent,
        Self::ZeroOffset,
    ];
}

/// Parameters of a servo, in the order of [`ServoParameter::ALL`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoParameters<S>(pub [S; ServoParameter::COUNT]);

impl<S: Scalar> ServoParameters<S> {
    /// Returns one parameter.
    #[must_use]
    pub fn get(&self, parameter: ServoParameter) -> S {
        self.0[parameter as usize]
    }

    /// Returns the torque that the friction can oppose to the motion, N·m.
    ///
    /// - `motor`, `external`: torque of the motor, and of gravity on the load, N·m.
    /// - `velocity`: rad/s.
    ///
    /// # Source
    ///
    /// Model m6 of the module's source.
    #[must_use]
    pub fn friction_bound(&self, motor: S, external: S, velocity: S) -> S {
        use ServoParameter as P;
        let speed = magnitude(velocity);
        let load = |of_motor, of_external| {
            magnitude(external * self.get(of_external) - motor * self.get(of_motor))
        };
        let mut at_rest = self.get(P::Stribeck)
            + load(P::LoadMotorStribeck, P::LoadExternalStribeck)
            + self.quadratic(motor, external);
        if speed.value() > SLOWEST {
            let relative = speed.ln() - self.get(P::LogStribeckVelocity);
            let fallen = -(relative * self.get(P::StribeckExponent)).exp();
            at_rest = at_rest * fallen.exp();
        }
        let moving = self.get(P::Coulomb) + self.get(P::Viscous) * speed;
        moving + load(P::LoadMotor, P::LoadExternal) + at_rest
    }

    /// Returns the quadratic part of the friction at rest, N·m; it exists where the two torques act
    /// against each other.
    fn quadratic(&self, motor: S, external: S) -> S {
        if motor.value() * external.value() >= 0.0 {
            S::ZERO
        } else if motor.value().abs() > external.value().abs() {
            external * external * self.get(ServoParameter::LoadExternalQuadratic)
        } else {
            motor * motor * self.get(ServoParameter::LoadMotorQuadratic)
        }
    }
}

/// Speed below which the Stribeck friction counts as that at rest, rad/s.
const SLOWEST: f64 = 1e-9;

/// Drive law of a position servo: proportional and derivative feedback with a limit. The command is
/// the voltage of the winding, or the current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveLaw {
    /// Command per position error, V/rad or A/rad.
    pub gain: f64,
    /// Command per velocity, V·s/rad or A·s/rad.
    pub damping: f64,
    /// Largest command, V or A.
    pub limit: f64,
}

impl DriveLaw {
    /// Returns the command, V or A.
    ///
    /// - `target`, `position`: rad; `velocity`: rad/s.
    #[must_use]
    pub fn command<S: Scalar>(&self, target: f64, position: S, velocity: S) -> S {
        let command = (S::constant(target) - position) * self.gain - velocity * self.damping;
        if command.value() > self.limit {
            S::constant(self.limit)
        } else if command.value() < -self.limit {
            S::constant(-self.limit)
        } else {
            command
        }
    }
}

/// A known load of the servo: inertia, and torque of gravity `sine · sin q + cosine · cos q`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Inertia about the axis, kg·m².
    pub inertia: f64,
    /// N·m.
    pub sine: f64,
    /// N·m.
    pub cosine: f64,
}

/// Position and velocity of a servo, rad and rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoState<S> {
    /// rad.
    pub position: S,
    /// rad/s.
    pub velocity: S,
}

/// A servo with its load.
#[derive(Clone, Copy, Debug)]
pub struct Servo<S> {
    parameters: ServoParameters<S>,
    load: Load,
    inertia: S,
    by_inertia: S,
}

impl<S: Scalar> Servo<S> {
    /// Returns a servo with its load.
    #[must_use]
    pub fn new(parameters: ServoParameters<S>, load: Load) -> Self {
        let inertia = parameters.get(ServoParameter::Armature) + S::constant(load.inertia);
        Self {
            parameters,
            load,
            inertia,
            by_inertia: inertia.recip(),
        }
    }

    /// Returns torque of the motor and torque of gravity, N·m.
    ///
    /// - `command`: V or A; `None` while the drive is off.
    #[must_use]
    pub fn torques(&self, command: Option<S>, state: ServoState<S>) -> (S, S) {
        use ServoParameter as P;
        let motor = command.map_or(S::ZERO, |command| {
            (command - self.parameters.get(P::BackEmf) * state.velocity)
                * self.parameters.get(P::TorquePerCommand)
        });
        let angle = state.position + self.parameters.get(P::ZeroOffset);
        let (sin, cos) = angle.sin_cos();
        (motor, sin * self.load.sine + cos * self.load.cosine)
    }

    /// Advances the state by one step of second order.
    ///
    /// - `command`: V or A, constant during the step; `None` while the drive is off.
    /// - `disturbance`: further torque, N·m.
    /// - `period`: s.
    #[must_use]
    pub fn step(
        &self,
        state: ServoState<S>,
        command: Option<S>,
        disturbance: f64,
        period: f64,
    ) -> ServoState<S> {
        let input = (command, disturbance);
        let middle = self.velocity_after(0.5 * period, state.velocity, state, input);
        let halfway = ServoState {
            position: state.position + (state.velocity + middle) * (0.25 * period),
            velocity: middle,
        };
        let velocity = self.velocity_after(period, state.velocity, halfway, input);
        ServoState {
            position: state.position + (state.velocity + velocity) * (0.5 * period),
            velocity,
        }
    }

    /// Returns the velocity after a time, s, from `velocity`, with the torques at the state `at`. It
    /// is zero where the friction can stop the joint in this time.
    fn velocity_after(
        &self,
        time: f64,
        velocity: S,
        at: ServoState<S>,
        (command, disturbance): (Option<S>, f64),
    ) -> S {
        let (motor, external) = self.torques(command, at);
        let bound = self.parameters.friction_bound(motor, external, at.velocity);
        let net = motor + external + S::constant(disturbance);
        let stopping = self.inertia * velocity * (1.0 / time) + net;
        if stopping.value().abs() <= bound.value() {
            return S::ZERO;
        }
        let friction = if stopping.value() > 0.0 {
            bound
        } else {
            -bound
        };
        velocity + (net - friction) * self.by_inertia * time
    }
}

/// Returns the absolute value.
fn magnitude<S: Scalar>(x: S) -> S {
    if x.value() < 0.0 { -x } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;

    const VALUES: [f64; ServoParameter::COUNT] = [
        0.7, 1.6, 0.012, 0.03, 0.06, 0.05, 0.1, 0.08, 0.09, 0.07, 0.05, 0.04, -0.7, 1.3, 0.01,
    ];

    const LOAD: Load = Load {
        inertia: 0.02,
        sine: -1.3,
        cosine: 0.2,
    };

    const LAW: DriveLaw = DriveLaw {
        gain: 75.0,
        damping: 0.1,
        limit: 14.0,
    };

    /// Position after a short motion with the drive on, then off.
    fn end<S: Scalar>(values: [S; ServoParameter::COUNT]) -> S {
        let servo = Servo::new(ServoParameters(values), LOAD);
        let mut state = ServoState {
            position: S::constant(0.1),
            velocity: S::constant(0.3),
        };
        for k in 0..300 {
            let command = LAW.command(0.8, state.position, state.velocity);
            state = servo.step(state, (k < 200).then_some(command), 0.0, 1e-3);
        }
        state.position
    }

    #[test]
    fn derivatives_are_limits_of_differences() {
        let variables = core::array::from_fn(|i| Dual::<15>::variable(VALUES[i], i));
        let dual = end(variables);
        assert!((dual.value - end(VALUES)).abs() < 1e-15);
        for (i, partial) in dual.partials.into_iter().enumerate() {
            let moved = |step: f64| {
                let mut values = VALUES;
                values[i] += step;
                end(values)
            };
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!(
                (partial - difference).abs() < 1e-6 * (1.0 + difference.abs()),
                "{:?}: {partial} and {difference}",
                ServoParameter::ALL[i]
            );
        }
    }

    #[test]
    fn friction_holds_the_load_at_rest_and_lets_it_fall_beyond_its_bound() {
        let servo = Servo::new(ServoParameters(VALUES), LOAD);
        let fell = |position: f64| {
            let mut state = ServoState {
                position,
                velocity: 0.0,
            };
            for _ in 0..100 {
                state = servo.step(state, None, 0.0, 1e-3);
            }
            (state.position - position).abs()
        };
        // The torque of gravity is zero at atan(0.2/1.3) = 0.153 rad.
        assert!(fell(0.16) == 0.0);
        assert!(fell(0.9) > 0.01);
    }

    #[test]
    fn without_friction_a_pendulum_keeps_its_energy() {
        let mut values = VALUES;
        for value in &mut values[3..12] {
            *value = 0.0;
        }
        let servo = Servo::new(ServoParameters(values), LOAD);
        let energy = |state: ServoState<f64>| {
            let (sin, cos) = libm::sincos(state.position + 0.01);
            let inertia = LOAD.inertia + 0.012;
            0.5 * inertia * state.velocity * state.velocity + LOAD.sine * cos - LOAD.cosine * sin
        };
        let mut state = ServoState {
            position: 1.0,
            velocity: 0.0,
        };
        let start = energy(state);
        let mut drift = 0.0_f64;
        for _ in 0..2000 {
            state = servo.step(state, None, 0.0, 1e-3);
            drift = drift.max((energy(state) - start).abs());
        }
        // Two seconds; the potential energy changes by 1.2 J.
        assert!(drift < 2e-3, "{drift:e}");
    }

    #[test]
    fn the_command_is_limited() {
        assert!((LAW.command(0.1, 0.0, 0.0) - 7.5_f64).abs() < 1e-12);
        assert!((LAW.command(3.0, 0.0, 0.0) - 14.0_f64).abs() < 1e-12);
        assert!((LAW.command(-3.0, 0.0, 0.0) + 14.0_f64).abs() < 1e-12);
    }
}
