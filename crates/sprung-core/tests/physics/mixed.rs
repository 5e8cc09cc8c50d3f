//! Laws for random robots with rigid and flexible joints that turn or slide, every kind of parameter and coupled
//! transmissions.
//!
//! Energies and losses are computed here, independently of the library; the links are point masses.
use std::collections::BTreeMap;

use sprung_core::drives::Term;
use sprung_core::friction::{Family, Law, Shape};
use sprung_core::links::LengthError;
use sprung_core::parameters::JointParameter::{self, Change, Friction};
use sprung_core::parameters::Side;
use sprung_core::presliding::{ALL_ELEMENTS, ELEMENTS};
use sprung_core::robot::{Links, Robot, Torques, Values};
use sprung_core::spatial::BODY;

use crate::bodies::Tree;
use crate::support::{
    JointState, Memory, Random, Waves, Worst, acceleration, entries, feedforward,
    forced_acceleration, products, slope,
};

/// Step of the finite differences, s.
const H: f64 = 1e-4;

pub(crate) struct Mixed {
    tree: Tree,
    bodies: Vec<[f64; BODY]>,
    theta: Vec<f64>,
    terms: Vec<Term>,
    shapes: Vec<Shape>,
    /// Motor positions per joint position.
    ratios: Vec<Vec<f64>>,
    coupling: Option<Vec<f64>>,
    motor_rows: Vec<Option<usize>>,
    selected: Vec<usize>,
    first: Vec<usize>,
    entries: Vec<usize>,
    /// Row and column of every entry.
    places: Vec<(usize, usize)>,
}

impl Mixed {
    fn draw(random: &mut Random, n: usize, coupled: bool) -> Self {
        let tree = Tree::draw(random, n);
        let mut rows = n..;
        let motor_rows: Vec<Option<usize>> = (0..n)
            .map(|_| (random.between(0.0, 1.0) < 0.6).then(|| rows.next().unwrap()))
            .collect();
        let mut ratio =
            |k: usize, i: usize| match motor_rows[k].is_some() == motor_rows[i].is_some() {
                _ if k == i => 1.0,
                true if coupled => random.between(-0.4, 0.4),
                _ => 0.0,
            };
        let ratios: Vec<Vec<f64>> = (0..n)
            .map(|k| (0..n).map(|i| ratio(k, i)).collect())
            .collect();
        let mut robot = Self {
            bodies: tree.bodies(),
            theta: tree.parameters(),
            terms: Vec::new(),
            shapes: (0..n)
                .map(|_| Shape {
                    sharpness: random.between(20.0, 200.0),
                    stribeck_velocity: random.between(0.1, 1.0),
                    presliding_width: random.between(0.1, 1.0),
                    hysteresis_width: 0.05,
                    play: 0.01,
                    play_centre: 0.004,
                })
                .collect(),
            coupling: coupled.then(|| ratios.concat()),
            ratios,
            motor_rows,
            selected: Vec::new(),
            first: Vec::new(),
            entries: Vec::new(),
            places: Vec::new(),
            tree,
        };
        for what in JointParameter::ALL {
            for joint in 0..n {
                robot.add(what, joint, random);
            }
        }
        robot.select(|_| true);
        robot
    }

    /// Keeps some of the link columns. Their entries follow the entries of the drives.
    fn select(&mut self, mut keep: impl FnMut(usize) -> bool) {
        let n = self.shapes.len();
        self.places.truncate(self.terms.len());
        self.selected.clear();
        self.first = vec![0];
        self.entries = vec![usize::MAX; n * n];
        for j in 0..n {
            let columns: Vec<usize> = (j * BODY..(j + 1) * BODY).filter(|c| keep(*c)).collect();
            self.selected.extend(columns.iter().map(|c| c % BODY));
            self.first.push(self.selected.len());
            for i in self.tree.carriers(j) {
                self.entries[i * n + j] = self.places.len();
                self.places
                    .extend(columns.iter().map(|&column| (i, column)));
            }
        }
    }

    /// Adds a parameter of a joint, or of its motor.
    fn add(&mut self, what: JointParameter, joint: usize, random: &mut Random) {
        let flexible = self.motor_rows[joint].is_some();
        let (low, high) = match what {
            JointParameter::RotorInertia => (0.05, 0.5),
            JointParameter::Stiffness => (50.0, 500.0),
            JointParameter::CubicStiffness => (100.0, 1000.0),
            JointParameter::Preload | Friction(_, Law::Offset) => (-1.0, 1.0),
            JointParameter::Damping
            | JointParameter::Hysteresis(_)
            | JointParameter::Friction(..)
            | JointParameter::Change(..)
            | JointParameter::BackEmf
            | JointParameter::TorqueOffset => (0.1, 1.0),
        };
        let column = self.theta.len();
        let mut put = |row: usize, gain: f64| {
            self.terms.push(Term {
                row,
                entry: self.places.len(),
                column,
                what,
                joint,
                gain,
            });
            self.places.push((row, column));
        };
        match what {
            Friction(Side::Link, _) | Change(Side::Link, ..) => put(joint, 1.0),
            Friction(Side::Motor, _)
            | Change(Side::Motor, ..)
            | JointParameter::RotorInertia
            | JointParameter::BackEmf => {
                for (i, &ratio) in self.ratios[joint].iter().enumerate() {
                    if ratio != 0.0 {
                        put(self.motor_rows[i].unwrap_or(i), ratio);
                    }
                }
            }
            // It belongs to the sensor.
            JointParameter::TorqueOffset => return,
            _ if flexible => {
                put(joint, -1.0);
                put(self.motor_rows[joint].unwrap(), 1.0);
            }
            // A rigid joint has no spring.
            JointParameter::Stiffness
            | JointParameter::CubicStiffness
            | JointParameter::Damping
            | JointParameter::Hysteresis(_)
            | JointParameter::Preload => return,
        }
        self.theta.push(match what {
            JointParameter::Hysteresis(at) => 0.1 + 0.1 * f64::from(at),
            _ => random.between(low, high),
        });
    }

    pub(crate) fn with<T>(&self, use_robot: impl FnOnce(&Robot<'_>, &Values<'_>) -> T) -> T {
        let robot = Robot {
            links: Links {
                shares: &[],
                chain: self.tree.chain(),
                selected: &self.selected,
                first: &self.first,
                entries: &self.entries,
            },
            terms: &self.terms,
            shapes: &self.shapes,
            coupling: self.coupling.as_deref(),
            motor_rows: &self.motor_rows,
            entries: self.places.len(),
        };
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        use_robot(&robot, &values)
    }

    /// Shapes of the friction laws, \[n\].
    pub(crate) fn shapes_mut(&mut self) -> &mut [Shape] {
        &mut self.shapes
    }

    pub(crate) fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// A parameter of a kind; zero if there is none.
    pub(crate) fn get(&self, what: JointParameter) -> f64 {
        let mut terms = self.terms.iter().filter(|term| term.what == what);
        terms.next().map_or(0.0, |term| self.theta[term.column])
    }

    /// Sets the parameters of some kinds.
    pub(crate) fn set(&mut self, value: f64, is_meant: impl Fn(JointParameter) -> bool) {
        for term in self.terms.iter().filter(|term| is_meant(term.what)) {
            self.theta[term.column] = value;
        }
    }

    /// Removes hysteresis and play, which a feedforward leaves out.
    pub(crate) fn make_springs_elastic(&mut self) {
        self.set(0.0, |what| matches!(what, JointParameter::Hysteresis(_)));
        for shape in &mut self.shapes {
            shape.play = 0.0;
        }
    }

    /// Row and column of every entry.
    pub(crate) fn places(&self) -> &[(usize, usize)] {
        &self.places
    }

    pub(crate) fn acceleration(&self, state: &JointState, tau: &[f64]) -> [Vec<f64>; 2] {
        self.with(|robot, values| acceleration(robot, values, state, tau))
    }

    fn products(&self, state: &JointState) -> [Vec<f64>; 2] {
        self.with(|robot, values| products(robot, &self.places, values.theta, state))
    }

    /// Bits of the entries of `Y_a` and `Y_b` by row and column.
    fn entries(&self, state: &JointState) -> BTreeMap<(usize, usize), [u64; 2]> {
        let [momentum, rest] = self.with(|robot, _| entries(robot, state));
        let both = momentum
            .iter()
            .zip(&rest)
            .map(|(a, b)| [a.to_bits(), b.to_bits()]);
        self.places.iter().copied().zip(both).collect()
    }

    /// A state; a rigid joint's motor moves with its link.
    pub(crate) fn draw_state(&self, random: &mut Random) -> JointState {
        let n = self.shapes.len();
        let [q, dq] = [2.0, 1.5].map(|limit| random.list(n, limit));
        let mut beside = |link: &[f64], limit: f64| {
            let both = link.iter().zip(&self.motor_rows);
            both.map(|(x, row)| match row {
                Some(_) => x + random.between(-limit, limit),
                None => *x,
            })
            .collect()
        };
        JointState {
            phi: beside(&q, 0.3),
            dphi: beside(&dq, 1.5),
            q,
            dq,
            elements: random.list(n * ALL_ELEMENTS, 1.0),
        }
    }

    /// A parameter, or zero if the joint lacks it.
    fn value(&self, what: JointParameter, joint: usize) -> f64 {
        let mut terms = self.terms.iter();
        let term = terms.find(|term| term.what == what && term.joint == joint);
        term.map_or(0.0, |term| self.theta[term.column])
    }

    fn motor_velocity(&self, motor: usize, dphi: &[f64]) -> f64 {
        self.ratios[motor]
            .iter()
            .zip(dphi)
            .map(|(r, v)| r * v)
            .sum()
    }

    fn energy(&self, s: &JointState) -> f64 {
        let mut sum = self.tree.kinetic(&s.q, &s.dq) + self.tree.potential(&s.q);
        for i in 0..s.q.len() {
            let speed = self.motor_velocity(i, &s.dphi);
            let d = s.phi[i] - s.q[i];
            let shape = &self.shapes[i];
            let behind_play = ((d - shape.play_centre).abs() - shape.play).max(0.0);
            sum += 0.5 * self.value(JointParameter::RotorInertia, i) * speed * speed
                + 0.5 * self.value(JointParameter::Stiffness, i) * behind_play * behind_play
                + 0.25 * self.value(JointParameter::CubicStiffness, i) * d.powi(4)
                - self.value(JointParameter::Preload, i) * d;
        }
        sum
    }

    /// Power of friction and damping that cannot be negative, and power of offsets, presliding friction
    /// and hysteresis.
    fn losses(&self, s: &JointState) -> (f64, f64) {
        let (mut lost, mut of_offsets) = (0.0, 0.0);
        for i in 0..s.q.len() {
            for (side, v) in [
                (Side::Link, s.dq[i]),
                (Side::Motor, self.motor_velocity(i, &s.dphi)),
            ] {
                let of = |law: Law| self.value(Friction(side, law), i);
                let step = (self.shapes[i].sharpness * v).tanh();
                let bell = (v / self.shapes[i].stribeck_velocity).powi(2);
                let (viscous, coulomb) = if v > 0.0 {
                    (of(Law::ViscousPositive), of(Law::CoulombPositive))
                } else {
                    (of(Law::ViscousNegative), of(Law::CoulombNegative))
                };
                lost += v * v * (of(Law::Viscous) + viscous);
                lost += v * step * (of(Law::Coulomb) + coulomb + of(Law::Stribeck) * (-bell).exp());
                lost += v * v * v.abs() * of(Law::Quadratic);
                lost += v * step * (s.phi[i] - s.q[i]).abs() * of(Law::Load);
                of_offsets += v * of(Law::Offset);
                let laws = Family::Presliding.laws().iter();
                match side {
                    Side::Motor => {
                        let elements = &s.elements[i * ALL_ELEMENTS..i * ALL_ELEMENTS + ELEMENTS];
                        let torque = laws.zip(elements).map(|(&law, z)| of(law) * z);
                        of_offsets += v * torque.sum::<f64>();
                    }
                    // Links have no elements, so theirs slide.
                    Side::Link => lost += v * step * laws.map(|&law| of(law)).sum::<f64>(),
                }
            }
            let rate = s.dphi[i] - s.dq[i];
            lost += self.value(JointParameter::Damping, i) * rate * rate;
            let of_spring = &s.elements[i * ALL_ELEMENTS + ELEMENTS..(i + 1) * ALL_ELEMENTS];
            for (at, z) in (0..).zip(of_spring) {
                of_offsets += rate * z * self.value(JointParameter::Hysteresis(at), i);
            }
            let speed = self.motor_velocity(i, &s.dphi);
            lost += self.value(JointParameter::BackEmf, i) * speed * speed;
        }
        (lost, of_offsets)
    }
}

pub(crate) fn for_random_robots(mut law: impl FnMut(&mut Mixed, &mut Random)) {
    let mut random = Random::new(21);
    for n in 1..=8 {
        for coupled in [false, true] {
            for _ in 0..6 {
                law(&mut Mixed::draw(&mut random, n, coupled), &mut random);
            }
        }
    }
}

#[test]
fn acceleration_solves_every_row() {
    let mut worst = Worst::default();
    for_random_robots(|robot, random| {
        let n = robot.shapes.len();
        let (state, tau) = (robot.draw_state(random), random.list(n, 20.0));
        let found = robot.acceleration(&state, &tau);
        let [_, rest] = robot.products(&state);
        for (row, rest) in rest.iter().enumerate() {
            let momentum = |t: f64| robot.products(&state.moved(&found, t))[0][row];
            let joint = robot.with(|robot, _| robot.joint_of(row));
            let driven = row >= n || robot.motor_rows[row].is_none();
            let wanted = if driven { tau[joint] } else { 0.0 };
            worst.see(slope(H, momentum) + rest - wanted, *rest);
        }
        for (i, row) in robot.motor_rows.iter().enumerate() {
            let together = found[0][i].to_bits() == found[1][i].to_bits();
            assert_eq!(together, row.is_none(), "joint {i}");
        }
    });
    worst.assert_below(1e-9, "rows");
}

#[test]
fn torques_on_links_stand_beside_those_of_their_rows() {
    let mut worst = Worst::default();
    for_random_robots(|robot, random| {
        let n = robot.shapes.len();
        let (state, tau) = (robot.draw_state(random), random.list(n, 20.0));
        let link = random.list(n, 10.0);
        let torques = Torques {
            motor: &tau,
            link: Some(&link),
        };
        let found =
            robot.with(|robot, values| forced_acceleration(robot, values, &state, &torques));
        let [_, rest] = robot.products(&state);
        for (row, rest) in rest.iter().enumerate() {
            let momentum = |t: f64| robot.products(&state.moved(&found, t))[0][row];
            let joint = robot.with(|robot, _| robot.joint_of(row));
            let driven = row >= n || robot.motor_rows[row].is_none();
            let mut wanted = if driven { tau[joint] } else { 0.0 };
            wanted += if row < n { link[joint] } else { 0.0 };
            worst.see(slope(H, momentum) + rest - wanted, *rest);
        }
    });
    worst.assert_below(1e-9, "rows");
}

#[test]
fn columns_that_are_not_selected_are_left_out() {
    for_random_robots(|robot, random| {
        let state = robot.draw_state(random);
        let full = robot.entries(&state);
        robot.select(|_| random.between(0.0, 1.0) < 0.4);
        let found = robot.entries(&state);
        assert!(found.len() < full.len());
        for (place, entry) in &found {
            assert_eq!(full.get(place), Some(entry), "{place:?}");
        }
    });
}

#[test]
fn power_goes_into_energy_and_friction() {
    let mut worst = Worst::default();
    for_random_robots(|robot, random| {
        let n = robot.shapes.len();
        let (state, tau) = (robot.draw_state(random), random.list(n, 20.0));
        let found = robot.acceleration(&state, &tau);
        let rate = slope(H, |t| robot.energy(&state.moved(&found, t)));
        let power: f64 = tau.iter().zip(&state.dphi).map(|(tau, v)| tau * v).sum();
        let (lost, of_offsets) = robot.losses(&state);
        assert!(lost >= 0.0);
        worst.see(rate - (power - lost - of_offsets), robot.energy(&state));
    });
    worst.assert_below(1e-9, "power balance");
}

#[test]
fn coupling_of_ones_is_none() {
    let mut worst = Worst::default();
    for_random_robots(|robot, random| {
        if robot.coupling.is_some() {
            return;
        }
        let n = robot.shapes.len();
        let (state, tau) = (robot.draw_state(random), random.list(n, 20.0));
        let alone = robot.acceleration(&state, &tau).concat();
        robot.coupling = Some(robot.ratios.concat());
        for (found, expected) in robot.acceleration(&state, &tau).concat().iter().zip(alone) {
            worst.see(found - expected, expected);
        }
    });
    worst.assert_below(1e-13, "coupling of ones");
}

#[test]
fn masses_that_are_not_positive_give_no_acceleration() {
    for_random_robots(|robot, random| {
        let n = robot.shapes.len();
        let (state, tau) = (robot.draw_state(random), random.list(n, 20.0));
        let rotor = |term: &&Term| term.what == JointParameter::RotorInertia;
        let columns: Vec<usize> = (robot.terms.iter().filter(rotor))
            .map(|term| term.column)
            .collect();
        for inertia in [0.0, -0.1] {
            for &at in &columns {
                robot.theta[at] = inertia;
            }
            let [_, ddphi] = robot.acceleration(&state, &tau);
            for (ddphi, row) in ddphi.iter().zip(&robot.motor_rows) {
                assert!(ddphi.is_nan() || row.is_none(), "{ddphi}");
            }
        }
        robot.bodies.fill([0.0; BODY]);
        let [ddq, _] = robot.acceleration(&state, &tau);
        assert!(ddq.iter().all(|ddq| ddq.is_nan()), "{ddq:?}");
    });
}

#[test]
fn feedforward_is_the_motion_it_promises() {
    let [mut worst, mut worst_rate] = [(); 2].map(|()| Worst::default());
    for_random_robots(|robot, random| {
        robot.make_springs_elastic();
        for term in &robot.terms {
            let kept = term.what.is_vital();
            robot.theta[term.column] *= f64::from(u8::from(kept));
        }
        let waves = Waves::draw(random, robot.shapes.len(), 2.0);
        let nominal =
            |t: f64| robot.with(|robot, values| feedforward(robot, values, &waves.at(t), None));
        let (tau, state) = nominal(0.0);
        let [ddq, ddphi] = robot.acceleration(&state, &tau);
        for (i, wanted) in waves.at(0.0).iter().enumerate() {
            worst.see(ddq[i] - wanted[2], wanted[2]);
            let rate = slope(1e-3, |t| nominal(t).1.phi[i]);
            worst_rate.see(state.dphi[i] - rate, rate);
            let rate = slope(1e-3, |t| nominal(t).1.dphi[i]);
            worst_rate.see(ddphi[i] - rate, rate);
        }
    });
    worst.assert_below(1e-10, "feedforward");
    worst_rate.assert_below(1e-9, "feedforward's rates");
}

#[test]
fn slices_that_do_not_fit_are_refused() {
    let robot = Mixed::draw(&mut Random::new(3), 3, true);
    let state = robot.draw_state(&mut Random::new(4));
    let expect = |what: &'static str, expected: usize, found: usize| LengthError {
        what,
        expected,
        found,
    };
    robot.with(|robot, values| {
        let mut memory = Memory::new(3);
        let mut entries = vec![0.0; robot.entries];
        let mut short = memory.workspace();
        short.numbers = &mut short.numbers[1..];
        let refused = robot.regressor(
            &state.view(),
            &mut short,
            &mut entries.clone(),
            &mut entries,
        );
        let needed = sprung_core::links::numbers_len(3);
        let error = expect("workspace.numbers", needed, needed - 1);
        assert_eq!(refused.unwrap_err(), error);

        let workspace = &mut memory.workspace();
        let refused = robot.regressor(&state.view(), workspace, &mut entries, &mut []);
        assert_eq!(refused.unwrap_err(), expect("rest", robot.entries, 0));
        let torque = vec![0.0; robot.rows()];
        let mut out = vec![0.0; robot.rows() - 1];
        let refused = robot.acceleration(values, &state.view(), &torque, workspace, &mut out);
        let error = expect("acceleration", robot.rows(), robot.rows() - 1);
        assert_eq!(refused.unwrap_err(), error);
    });
}
