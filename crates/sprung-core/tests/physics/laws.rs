//! Laws that the equations of motion obey, at seeded random robots and states.
//!
//! The robots are drawn as bodies: masses, centres of mass, inertias. Energy
//! and angular momentum come from the velocities of these bodies in the plane,
//! so they share nothing with the columns but the definition of theta.
use sprung_core::controller::Feedforward;
use sprung_core::planar_2r::Pose;
use sprung_core::regressor::{Acceleration, JointState, PARAMETERS, PlanarArm, ROW_COLUMNS};

use crate::support::{Body, Random, rate_of, scaled};

const CASES: usize = 200;

/// Everything that one random case needs.
struct Case {
    bodies: Body,
    theta: [f64; PARAMETERS],
    arm: PlanarArm,
    state: JointState,
    tau: [f64; 2],
}

impl Case {
    fn draw(random: &mut Random) -> Self {
        let bodies = Body::draw(random);
        let (q, deflection) = (random.pair(3.0), random.pair(0.3));
        Self {
            theta: bodies.theta(random),
            bodies,
            arm: PlanarArm {
                coulomb_sharpness: [random.between(20.0, 200.0), random.between(20.0, 200.0)],
            },
            state: JointState {
                q,
                dq: random.pair(3.0),
                phi: [q[0] + deflection[0], q[1] + deflection[1]],
                dphi: [q[0] + deflection[0], q[1] + deflection[1]],
            },
            tau: random.pair(5.0),
        }
    }

    fn acceleration(&self) -> Acceleration {
        self.arm.acceleration(&self.theta, &self.state, &self.tau)
    }

    /// A point of the parabola that leaves the state with the acceleration the
    /// torque causes; first derivatives there are those of the true motion.
    fn moved(&self, acceleration: &Acceleration, t: f64) -> JointState {
        let position = |x: [f64; 2], v: [f64; 2], a: [f64; 2]| {
            [0, 1].map(|i: usize| x[i] + t * (v[i] + 0.5 * t * a[i]))
        };
        let velocity = |v: [f64; 2], a: [f64; 2]| [0, 1].map(|i: usize| v[i] + t * a[i]);
        let s = &self.state;
        JointState {
            q: position(s.q, s.dq, acceleration.ddq),
            dq: velocity(s.dq, acceleration.ddq),
            phi: position(s.phi, s.dphi, acceleration.ddphi),
            dphi: velocity(s.dphi, acceleration.ddphi),
        }
    }

    /// Torques of link and motor friction.
    fn friction(&self) -> ([f64; 2], [f64; 2]) {
        let law = |viscous: usize, coulomb: usize, velocity: [f64; 2]| {
            [0, 1].map(|i: usize| {
                self.theta[viscous + i] * velocity[i]
                    + self.theta[coulomb + i] * (self.arm.coulomb_sharpness[i] * velocity[i]).tanh()
            })
        };
        (law(5, 11, self.state.dq), law(7, 13, self.state.dphi))
    }
}

fn for_each_case(mut test: impl FnMut(&Case)) {
    let mut random = Random::new(20_170_501);
    for _ in 0..CASES {
        test(&Case::draw(&mut random));
    }
}

/// `Y_a theta` and `Y_b theta`.
fn products(case: &Case, state: &JointState) -> ([f64; 4], [f64; 4]) {
    let entries = case.arm.regressor(state);
    let (mut momentum, mut rest) = ([0.0; 4], [0.0; 4]);
    let mut next = entries.iter();
    for (row, columns) in ROW_COLUMNS.iter().enumerate() {
        for (&column, entry) in columns.iter().zip(&mut next) {
            momentum[row] += entry.momentum * case.theta[column];
            rest[row] += entry.rest * case.theta[column];
        }
    }
    (momentum, rest)
}

/// The paper's printed `C_A`.
fn printed_coriolis(theta: &[f64; PARAMETERS], q: &[f64; 2], dq: &[f64; 2]) -> [[f64; 2]; 2] {
    let c = theta[1] * q[1].sin();
    [[-c * dq[1], -c * (dq[0] + dq[1])], [c * dq[0], 0.0]]
}

fn times(m: &[[f64; 2]; 2], v: &[f64; 2]) -> [f64; 2] {
    m.map(|row| row[0] * v[0] + row[1] * v[1])
}

#[test]
fn mass_matrix_is_symmetric_positive_and_that_of_the_bodies() {
    let mut worst: f64 = 0.0;
    for_each_case(|case| {
        let m = PlanarArm::mass_matrix(&case.theta, &case.state.q);
        assert!((m[0][1] - m[1][0]).abs() < 1e-15);
        assert!(m[0][0] > 0.0 && m[0][0] * m[1][1] - m[0][1] * m[1][0] > 0.0);
        let dq = case.state.dq;
        let p = times(&m, &dq);
        let energy = case.bodies.kinetic_energy(&case.state.q, &dq);
        let columns = products(case, &case.state).0;
        worst = worst
            .max(scaled(0.5 * (p[0] * dq[0] + p[1] * dq[1]) - energy, energy))
            .max(scaled(columns[0] - p[0], p[0]))
            .max(scaled(columns[1] - p[1], p[1]));
    });
    println!("mass matrix against bodies: {worst:.1e}");
    assert!(worst < 1e-13, "{worst:e}");
}

#[test]
fn regressor_times_parameters_is_the_equation_of_motion() {
    let mut worst: f64 = 0.0;
    for_each_case(|case| {
        let acceleration = case.acceleration();
        let rest = products(case, &case.state).1;
        let wanted = [0.0, 0.0, case.tau[0], case.tau[1]];
        for row in 0..4 {
            let rate = rate_of(|t| products(case, &case.moved(&acceleration, t)).0[row]);
            worst = worst.max(scaled(rate + rest[row] - wanted[row], rest[row]));
        }
    });
    println!("equation of motion: {worst:.1e}");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn energy_changes_by_the_power_of_motors_and_friction() {
    let mut worst: f64 = 0.0;
    for_each_case(|case| {
        let acceleration = case.acceleration();
        let energy = |s: &JointState| {
            let joints: f64 = (0..2)
                .map(|i| {
                    let deflection = s.phi[i] - s.q[i];
                    0.5 * case.theta[3 + i] * s.dphi[i] * s.dphi[i]
                        + 0.5 * case.theta[9 + i] * deflection * deflection
                })
                .sum();
            case.bodies.kinetic_energy(&s.q, &s.dq) + joints
        };
        let rate = rate_of(|t| energy(&case.moved(&acceleration, t)));
        let (link, motor) = case.friction();
        let s = &case.state;
        let (mut power, mut lost) = (0.0, 0.0);
        for i in 0..2 {
            power += case.tau[i] * s.dphi[i];
            lost += link[i] * s.dq[i] + motor[i] * s.dphi[i];
        }
        assert!(lost >= 0.0);
        worst = worst.max(scaled(rate - (power - lost), energy(s)));
    });
    println!("power balance: {worst:.1e}");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn angular_momentum_changes_by_the_torque_of_the_first_joint() {
    let mut worst: f64 = 0.0;
    for_each_case(|case| {
        let acceleration = case.acceleration();
        let rate = rate_of(|t| {
            let s = case.moved(&acceleration, t);
            case.bodies.angular_momentum(&s.q, &s.dq)
        });
        let s = &case.state;
        let torque = case.theta[9] * (s.phi[0] - s.q[0]) - case.friction().0[0];
        worst = worst.max(scaled(rate - torque, torque));
    });
    println!("angular momentum: {worst:.1e}");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn mass_rate_minus_twice_the_printed_coriolis_matrix_is_skew() {
    let mut worst: f64 = 0.0;
    for_each_case(|case| {
        let (q, dq) = (case.state.q, case.state.dq);
        let mass = |q: [f64; 2], i: usize, j: usize| PlanarArm::mass_matrix(&case.theta, &q)[i][j];
        let c = printed_coriolis(&case.theta, &q, &dq);
        let mut rate = [[0.0; 2]; 2];
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            rate[i][j] = rate_of(|t| mass([q[0] + t * dq[0], q[1] + t * dq[1]], i, j));
        }
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            let sum = rate[i][j] + rate[j][i] - 2.0 * (c[i][j] + c[j][i]);
            worst = worst.max(sum.abs());
        }
        // What stands beside the rate of the momentum is (-dM/dt + C) dq.
        let rest = Pose::new(&q).rest(&dq);
        let (of_rate, of_c) = (times(&rate, &dq), times(&c, &dq));
        for i in 0..2 {
            let columns: f64 = rest[i].iter().zip(&case.theta).map(|(y, x)| y * x).sum();
            worst = worst.max((columns - of_c[i] + of_rate[i]).abs());
        }
    });
    println!("skew symmetry: {worst:.1e}");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn feedforward_is_the_motion_it_promises() {
    let mut worst: f64 = 0.0;
    let mut random = Random::new(33);
    for _ in 0..CASES {
        let mut case = Case::draw(&mut random);
        for friction in [5, 6, 7, 8, 11, 12, 13, 14] {
            case.theta[friction] = 0.0;
        }
        let theta = case.theta;
        let (amplitude, speed, phase) = (random.pair(1.0), random.pair(5.0), random.pair(3.0));
        let derivatives = |t: f64| {
            [0, 1].map(|i: usize| {
                let (sin, cos) = (speed[i] * t + phase[i]).sin_cos();
                let w = speed[i];
                let wave = [
                    sin,
                    w * cos,
                    -w * w * sin,
                    -w.powi(3) * cos,
                    w.powi(4) * sin,
                ];
                wave.map(|x| amplitude[i] * x)
            })
        };
        // phi_d = q_d + w_d / k with w_d = M ddq_d + C dq_d as printed.
        let rotor = |t: f64, i: usize| {
            let d = derivatives(t);
            let (q, dq, ddq) = (d.map(|x| x[0]), d.map(|x| x[1]), d.map(|x| x[2]));
            let inertial = times(&PlanarArm::mass_matrix(&theta, &q), &ddq);
            let coriolis = times(&printed_coriolis(&theta, &q, &dq), &dq);
            q[i] + (inertial[i] + coriolis[i]) / theta[9 + i]
        };
        let wanted = derivatives(0.0);
        let nominal = Feedforward::new(&wanted, &theta);
        let found = case.arm.acceleration(&theta, &nominal.state, &nominal.tau);
        for (i, wanted) in wanted.iter().enumerate() {
            let rate = rate_of(|t| rotor(t, i));
            let second = rate_of(|t| rate_of(|s| rotor(t + s, i)));
            let phi = nominal.state.phi[i];
            worst = worst
                .max(scaled(phi - rotor(0.0, i), phi))
                .max(scaled(nominal.state.dphi[i] - rate, rate))
                .max(scaled(found.ddq[i] - wanted[2], wanted[2]));
            // The double difference quotient is good to 1e-16 / h².
            assert!(scaled(found.ddphi[i] - second, second) < 1e-6);
        }
    }
    println!("feedforward: {worst:.1e}");
    assert!(worst < 1e-9, "{worst:e}");
}
