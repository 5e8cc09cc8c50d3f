//! Laws of physics for the paper's arm with random parameters and states; the seeds are fixed.
//!
//! The robots are drawn as bodies: masses, centres of mass, inertias. Energy and angular momentum are computed from
//! the planar velocities of these bodies. They share only the definition of theta with the regressor columns.
use sprung_core::friction::Shape;
use sprung_core::links::LengthError;
use sprung_core::links::Step;
use sprung_core::parameters::JointParameter;
use sprung_core::robot::Values;
use sprung_core::spatial::BODY;

use crate::bodies::Body;
use crate::closed_form::{INERTIAL, Pose};
use crate::planar_2r::{self, ENTRIES, JOINTS, PARAMETERS, robot};
use crate::rows::ROW_COLUMNS;
use crate::support::{
    JointState, Memory, Random, Waves, Worst, acceleration, feedforward, products, slope,
    slope_rounding,
};

const CASES: usize = 200;

/// Step of the finite differences, s.
const H: f64 = 1e-4;

/// Everything that one random case needs.
struct Case {
    bodies: Body,
    theta: [f64; PARAMETERS],
    links: [[f64; BODY]; JOINTS],
    shapes: [Shape; JOINTS],
    state: JointState,
    tau: [f64; 2],
}

impl Case {
    fn draw(random: &mut Random) -> Self {
        let bodies = Body::draw(random);
        let theta = bodies.theta(random);
        let (q, deflection) = (random.pair(3.0), random.pair(0.3));
        Self {
            links: planar_2r::bodies(&theta),
            theta,
            bodies,
            shapes: [(); 2].map(|()| Shape {
                sharpness: random.between(20.0, 200.0),
                stribeck_velocity: 0.1,
                presliding_width: 0.5,
                hysteresis_width: 0.05,
                play: 0.0,
                play_centre: 0.0,
            }),
            state: JointState {
                q: q.to_vec(),
                dq: random.list(2, 3.0),
                phi: vec![q[0] + deflection[0], q[1] + deflection[1]],
                dphi: random.list(2, 3.0),
                elements: Vec::new(),
            },
            tau: random.pair(5.0),
        }
    }

    fn values(&self) -> Values<'_> {
        Values {
            theta: &self.theta,
            bodies: &self.links,
        }
    }

    fn acceleration(&self) -> [Vec<f64>; 2] {
        acceleration(&robot(&self.shapes), &self.values(), &self.state, &self.tau)
    }

    /// `Y_a theta` and `Y_b theta`.
    fn products(&self, state: &JointState) -> [Vec<f64>; 2] {
        products(&robot(&self.shapes), &places(), &self.theta, state)
    }

    fn mass(&self, q: &[f64]) -> [[f64; 2]; 2] {
        let mut m = [f64::NAN; 4 * JOINTS * JOINTS];
        let mut memory = Memory::new(JOINTS);
        robot(&self.shapes)
            .mass_matrix(&self.values(), q, &mut memory.workspace(), &mut m)
            .unwrap();
        [[m[0], m[1]], [m[4], m[5]]]
    }

    /// Torques of link and motor friction.
    fn friction(&self) -> ([f64; 2], [f64; 2]) {
        let law = |viscous: usize, coulomb: usize, velocity: &[f64]| {
            [0, 1].map(|i: usize| {
                self.theta[viscous + i] * velocity[i]
                    + self.theta[coulomb + i] * (self.shapes[i].sharpness * velocity[i]).tanh()
            })
        };
        (law(5, 11, &self.state.dq), law(7, 13, &self.state.dphi))
    }
}

fn for_each_case(mut test: impl FnMut(&Case)) {
    let mut random = Random::new(20_170_501);
    for _ in 0..CASES {
        test(&Case::draw(&mut random));
    }
}

/// Row and column of every entry.
fn places() -> Vec<(usize, usize)> {
    let rows = ROW_COLUMNS.iter().enumerate();
    rows.flat_map(|(row, columns)| columns.iter().map(move |&column| (row, column)))
        .collect()
}

/// The paper's printed `C_A`.
fn printed_coriolis(theta: &[f64; PARAMETERS], q: &[f64], dq: &[f64]) -> [[f64; 2]; 2] {
    let c = theta[1] * q[1].sin();
    [[-c * dq[1], -c * (dq[0] + dq[1])], [c * dq[0], 0.0]]
}

fn times(m: &[[f64; 2]; 2], v: &[f64]) -> [f64; 2] {
    m.map(|row| row[0] * v[0] + row[1] * v[1])
}

#[test]
fn terms_stand_where_the_order_of_theta_puts_them() {
    let places = places();
    assert_eq!(places.len(), ENTRIES);
    let arm = robot(
        &[Shape {
            sharpness: 1.0,
            stribeck_velocity: 1.0,
            presliding_width: 0.5,
            hysteresis_width: 0.05,
            play: 0.0,
            play_centre: 0.0,
        }; 2],
    );
    for term in arm.terms {
        assert_eq!(places[term.entry], (term.row, term.column));
        let kinds = JointParameter::ALL.iter();
        let kind = kinds.take_while(|kind| **kind != term.what).count();
        assert_eq!(term.column, INERTIAL + kind * JOINTS + term.joint);
        assert_eq!(arm.joint_of(term.row), term.joint);
    }
    let links = places.iter().filter(|(_, column)| *column < INERTIAL);
    assert_eq!(links.count() + arm.terms.len(), ENTRIES);
}

#[test]
fn mass_matrix_is_symmetric_positive_and_that_of_the_bodies() {
    let mut worst = Worst::default();
    for_each_case(|case| {
        let (q, dq) = (&case.state.q, &case.state.dq);
        let m = case.mass(q);
        assert!((m[0][1] - m[1][0]).abs() < 1e-15);
        assert!(m[0][0] > 0.0 && m[0][0] * m[1][1] - m[0][1] * m[1][0] > 0.0);
        let p = times(&m, dq);
        let energy = case.bodies.kinetic_energy(q, dq);
        let [columns, _] = case.products(&case.state);
        worst.see(0.5 * (p[0] * dq[0] + p[1] * dq[1]) - energy, energy);
        worst.see(columns[0] - p[0], p[0]);
        worst.see(columns[1] - p[1], p[1]);
    });
    worst.assert_below(1e-13, "mass matrix against bodies");
}

#[test]
fn regressor_times_parameters_is_the_equation_of_motion() {
    let mut worst = Worst::default();
    for_each_case(|case| {
        let acceleration = case.acceleration();
        let [_, rest] = case.products(&case.state);
        let wanted = [0.0, 0.0, case.tau[0], case.tau[1]];
        for row in 0..4 {
            let momentum = |t: f64| case.products(&case.state.moved(&acceleration, t))[0][row];
            worst.see(slope(H, momentum) + rest[row] - wanted[row], rest[row]);
        }
    });
    worst.assert_below(1e-9, "equation of motion");
}

#[test]
fn energy_changes_by_the_power_of_motors_and_friction() {
    let mut worst = Worst::default();
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
        let rate = slope(H, |t| energy(&case.state.moved(&acceleration, t)));
        let (link, motor) = case.friction();
        let s = &case.state;
        let (mut power, mut lost) = (0.0, 0.0);
        for i in 0..2 {
            power += case.tau[i] * s.dphi[i];
            lost += link[i] * s.dq[i] + motor[i] * s.dphi[i];
        }
        assert!(lost >= 0.0);
        worst.see(rate - (power - lost), energy(s));
    });
    worst.assert_below(1e-9, "power balance");
}

#[test]
fn angular_momentum_changes_by_the_torque_of_the_first_joint() {
    let mut worst = Worst::default();
    for_each_case(|case| {
        let acceleration = case.acceleration();
        let rate = slope(H, |t| {
            let s = case.state.moved(&acceleration, t);
            case.bodies.angular_momentum(&s.q, &s.dq)
        });
        let s = &case.state;
        let torque = case.theta[9] * (s.phi[0] - s.q[0]) - case.friction().0[0];
        worst.see(rate - torque, torque);
    });
    worst.assert_below(1e-9, "angular momentum");
}

#[test]
fn mass_rate_minus_twice_the_printed_coriolis_matrix_is_skew() {
    let mut worst = Worst::default();
    for_each_case(|case| {
        let (q, dq) = (&case.state.q, &case.state.dq);
        let c = printed_coriolis(&case.theta, q, dq);
        let mut rate = [[0.0; 2]; 2];
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            rate[i][j] = slope(H, |t| {
                case.mass(&[q[0] + t * dq[0], q[1] + t * dq[1]])[i][j]
            });
        }
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            worst.see(rate[i][j] + rate[j][i] - 2.0 * (c[i][j] + c[j][i]), 1.0);
        }
        // The columns beside the rate of the momentum give (-dM/dt + C) dq.
        let rest = Pose::new(&[q[0], q[1]]).rest(&[dq[0], dq[1]]);
        let (of_rate, of_c) = (times(&rate, dq), times(&c, dq));
        for i in 0..2 {
            let columns: f64 = rest[i].iter().zip(&case.theta).map(|(y, x)| y * x).sum();
            worst.see(columns - of_c[i] + of_rate[i], 1.0);
        }
    });
    worst.assert_below(1e-9, "skew symmetry");
}

#[test]
fn feedforward_is_the_motion_it_promises() {
    let [mut worst, mut worst_second] = [(); 2].map(|()| Worst::default());
    let mut largest = 1.0_f64;
    let mut random = Random::new(33);
    for _ in 0..CASES {
        let mut case = Case::draw(&mut random);
        for friction in [5, 6, 7, 8, 11, 12, 13, 14] {
            case.theta[friction] = 0.0;
        }
        let waves = Waves::draw(&mut random, JOINTS, 5.0);
        // phi_d = q_d + w_d / k with w_d = M ddq_d + C dq_d, as the paper prints it.
        let rotor = |t: f64, i: usize| {
            let d = waves.at(t);
            let [q, dq, ddq] = [0, 1, 2].map(|order: usize| [d[0][order], d[1][order]]);
            let inertial = times(&case.mass(&q), &ddq);
            let coriolis = times(&printed_coriolis(&case.theta, &q, &dq), &dq);
            q[i] + (inertial[i] + coriolis[i]) / case.theta[9 + i]
        };
        let wanted = waves.at(0.0);
        let arm = robot(&case.shapes);
        let (tau, state) = feedforward(&arm, &case.values(), &wanted, None);
        let [ddq, ddphi] = acceleration(&arm, &case.values(), &state, &tau);
        for (i, wanted) in wanted.iter().enumerate() {
            let rate = slope(H, |t| rotor(t, i));
            let second = slope(H, |t| slope(H, |s| rotor(t + s, i)));
            largest = largest.max(state.phi[i].abs());
            worst.see(state.phi[i] - rotor(0.0, i), state.phi[i]);
            worst.see(state.dphi[i] - rate, rate);
            worst.see(ddq[i] - wanted[2], wanted[2]);
            worst_second.see(ddphi[i] - second, second);
        }
    }
    worst.assert_below(1e-9, "feedforward");
    // A difference of differences of positions of up to `largest`, each with a few roundings.
    let limit = 4.0 * largest * slope_rounding(H).powi(2) / f64::EPSILON;
    worst_second.assert_below(limit, "feedforward's rotor acceleration");
}

#[test]
fn slices_that_do_not_fit_are_refused() {
    let case = Case::draw(&mut Random::new(1));
    let arm = robot(&case.shapes);
    let (two, three) = ([0.0; 2], [0.0; 3]);
    let refused = |what: &'static str, expected: usize| LengthError {
        what,
        expected,
        found: 3,
    };
    let torque = |q: &[f64], dq: &[f64], ddq: &[f64]| {
        let steps = &mut [Step::default(); JOINTS];
        arm.link_torque(&case.values(), q, dq, ddq, steps, &mut [0.0; 2])
            .unwrap_err()
    };
    assert_eq!(torque(&three, &two, &two), refused("q", 2));
    assert_eq!(torque(&two, &three, &two), refused("dq", 2));
    assert_eq!(torque(&two, &two, &three), refused("ddq", 2));
    let mut memory = Memory::new(JOINTS);
    let mut mass = |q: &[f64], matrix: &mut [f64]| {
        arm.mass_matrix(&case.values(), q, &mut memory.workspace(), matrix)
            .unwrap_err()
    };
    assert_eq!(mass(&three, &mut [0.0; 16]), refused("q", 2));
    assert_eq!(mass(&two, &mut [0.0; 3]), refused("matrix", 16));
}
