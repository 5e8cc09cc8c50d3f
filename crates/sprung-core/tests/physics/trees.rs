//! Laws of physics for random trees of joints, whose links are point masses.
//!
//! The masses' positions and velocities are found in the base's frame, by a
//! path that shares nothing with the columns.
use sprung_core::chain::{Chain, ChainError, ChainJoint, JointKind};
use sprung_core::links::{JointScratch, LengthError, PairScratch, Workspace, regressor, torque};
use sprung_core::spatial::{BODY, product, rotation};

use crate::support::Random;

type Vector = [f64; 3];

const GRAVITY: Vector = [0.7, -1.2, -9.6];

struct Tree {
    joints: Vec<ChainJoint>,
    /// Mass and place in the joint's frame, five for each link.
    masses: Vec<Vec<(f64, Vector)>>,
}

fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn turned(r: &[Vector; 3], v: Vector) -> Vector {
    r.map(|row| dot(row, v))
}

impl Tree {
    fn draw(random: &mut Random, n: usize) -> Self {
        let mut vector = |limit: f64| [0; 3].map(|_| random.between(-limit, limit));
        let unit = |v: Vector| v.map(|x| x / dot(v, v).sqrt());
        let mut joints = Vec::new();
        let mut masses = Vec::new();
        for j in 0..n {
            let placement = rotation(
                &unit(add(vector(1.0), [0.1, 0.0, 2.0])),
                3.0 * vector(1.0)[0],
            );
            let pick = vector(1.0);
            joints.push(ChainJoint {
                // Mostly a chain, sometimes a branch or a second tree.
                parent: match j {
                    0 => None,
                    _ if pick[0] > 0.6 => Some((0.5 * (pick[1] + 1.0) * j as f64) as usize),
                    _ if pick[0] < -0.9 => None,
                    _ => Some(j - 1),
                },
                rotation: placement,
                origin: vector(0.5),
                axis: unit(add(vector(1.0), [0.0, 1.5, 0.0])),
                kind: if pick[2] > 0.6 {
                    JointKind::Prismatic
                } else {
                    JointKind::Revolute
                },
            });
            masses.push(
                (0..5)
                    .map(|_| (vector(1.0)[0].abs() + 0.1, vector(0.3)))
                    .collect(),
            );
        }
        Self { joints, masses }
    }

    fn parameters(&self) -> Vec<f64> {
        let mut pi = Vec::new();
        for link in &self.masses {
            let mut body = [0.0; BODY];
            for (m, [x, y, z]) in link {
                let terms = [
                    1.0,
                    *x,
                    *y,
                    *z,
                    y * y + z * z,
                    -x * y,
                    x * x + z * z,
                    -x * z,
                    -y * z,
                    x * x + y * y,
                ];
                for (sum, term) in body.iter_mut().zip(terms) {
                    *sum += m * term;
                }
            }
            pi.extend(body);
        }
        pi
    }

    /// Axes, origins and turns of all joints in the base's frame.
    fn places(&self, q: &[f64]) -> Vec<(Vector, Vector, [Vector; 3])> {
        let mut places: Vec<(Vector, Vector, [Vector; 3])> = Vec::new();
        for (joint, q) in self.joints.iter().zip(q) {
            let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let (_, origin, turn) = joint
                .parent
                .map_or(([0.0; 3], [0.0; 3], identity), |parent| places[parent]);
            let mut own = product(&turn, &joint.rotation);
            let mut at = add(origin, turned(&turn, joint.origin));
            let axis = turned(&own, joint.axis);
            match joint.kind {
                JointKind::Revolute => own = product(&own, &rotation(&joint.axis, *q)),
                JointKind::Prismatic => at = add(at, axis.map(|x| x * q)),
            }
            places.push((axis, at, own));
        }
        places
    }

    /// Mass, place and velocity per joint velocity of every point.
    fn points(&self, q: &[f64]) -> Vec<(f64, Vector, Vec<Vector>)> {
        let places = self.places(q);
        let mut points = Vec::new();
        for (j, link) in self.masses.iter().enumerate() {
            for (mass, local) in link {
                let (_, origin, turn) = &places[j];
                let at = add(*origin, turned(turn, *local));
                let mut rates = vec![[0.0; 3]; self.joints.len()];
                let mut carrier = Some(j);
                while let Some(i) = carrier {
                    let (axis, pivot, _) = places[i];
                    rates[i] = match self.joints[i].kind {
                        JointKind::Revolute => cross(axis, add(at, pivot.map(|x| -x))),
                        JointKind::Prismatic => axis,
                    };
                    carrier = self.joints[i].parent;
                }
                points.push((*mass, at, rates));
            }
        }
        points
    }

    fn mass_matrix(&self, q: &[f64]) -> Vec<Vec<f64>> {
        let n = self.joints.len();
        let mut m = vec![vec![0.0; n]; n];
        for (mass, _, rates) in self.points(q) {
            for (row, a) in m.iter_mut().zip(&rates) {
                for (entry, b) in row.iter_mut().zip(&rates) {
                    *entry += mass * dot(*a, *b);
                }
            }
        }
        m
    }

    fn kinetic(&self, q: &[f64], dq: &[f64]) -> f64 {
        let m = self.mass_matrix(q);
        0.5 * dq
            .iter()
            .zip(&m)
            .map(|(v, row)| v * inner(row, dq))
            .sum::<f64>()
    }

    fn potential(&self, q: &[f64]) -> f64 {
        self.points(q)
            .iter()
            .map(|(m, at, _)| -m * dot(GRAVITY, *at))
            .sum()
    }
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn moved(q: &[f64], dq: &[f64], t: f64) -> Vec<f64> {
    q.iter().zip(dq).map(|(q, v)| q + t * v).collect()
}

/// Slope at zero by differences of sixth order.
fn slope(f: impl Fn(f64) -> f64, h: f64) -> f64 {
    let d = |k: f64| f(k * h) - f(-k * h);
    (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h)
}

/// Momentum, rest and torque of a state, by the columns.
fn by_columns(tree: &Tree, q: &[f64], dq: &[f64], ddq: &[f64]) -> [Vec<f64>; 3] {
    let n = tree.joints.len();
    let chain = Chain::new(&tree.joints, GRAVITY).unwrap();
    let (mut joints, mut pairs) = (
        vec![JointScratch::default(); n],
        vec![PairScratch::default(); n * n],
    );
    let mut workspace = Workspace {
        joints: &mut joints,
        pairs: &mut pairs,
    };
    let mut columns = [(); 3].map(|()| vec![0.0; n * n * BODY]);
    let [a, b, c] = &mut columns;
    regressor(&chain, q, dq, &mut workspace, a, b).unwrap();
    torque(&chain, q, dq, ddq, &mut workspace, c).unwrap();
    let pi = tree.parameters();
    columns.map(|matrix| matrix.chunks(pi.len()).map(|row| inner(row, &pi)).collect())
}

fn for_random_trees(mut law: impl FnMut(&Tree, &[f64], &[f64], &[f64])) {
    let mut random = Random::new(20);
    for n in 1..=12 {
        for _ in 0..4 {
            let tree = Tree::draw(&mut random, n);
            let mut draw = |limit: f64| -> Vec<f64> {
                (0..n).map(|_| random.between(-limit, limit)).collect()
            };
            let (q, dq, ddq) = (draw(2.0), draw(1.5), draw(3.0));
            law(&tree, &q, &dq, &ddq);
        }
    }
}

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() < tolerance * expected.abs().max(10.0),
        "{found} {expected}"
    );
}

#[test]
fn momentum_is_that_of_the_points() {
    for_random_trees(|tree, q, dq, ddq| {
        let [momentum, _, _] = by_columns(tree, q, dq, ddq);
        for (found, row) in momentum.iter().zip(tree.mass_matrix(q)) {
            assert_close(*found, inner(&row, dq), 1e-13);
        }
    });
}

#[test]
fn mass_matrix_is_symmetric_and_positive() {
    for_random_trees(|tree, q, _, ddq| {
        let n = q.len();
        let unit = |i: usize| -> Vec<f64> { (0..n).map(|k| f64::from(u8::from(k == i))).collect() };
        let m: Vec<Vec<f64>> = (0..n)
            .map(|i| by_columns(tree, q, &unit(i), ddq)[0].clone())
            .collect();
        for (i, row) in m.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                assert_close(*entry, m[j][i], 1e-13);
            }
        }
        // The energy of any motion is positive.
        let energy = inner(ddq, &by_columns(tree, q, ddq, ddq)[0]);
        assert!(energy > 0.0);
    });
}

#[test]
fn rest_is_the_slope_of_the_lagrangian() {
    for_random_trees(|tree, q, dq, ddq| {
        let [_, rest, _] = by_columns(tree, q, dq, ddq);
        for (i, found) in rest.iter().enumerate() {
            let lagrangian = |t: f64| {
                let mut q = q.to_vec();
                q[i] += t;
                tree.kinetic(&q, dq) - tree.potential(&q)
            };
            assert_close(*found, -slope(lagrangian, 2e-3), 1e-8);
        }
    });
}

#[test]
fn torque_is_the_rate_of_momentum_plus_rest() {
    for_random_trees(|tree, q, dq, ddq| {
        let [_, rest, torque] = by_columns(tree, q, dq, ddq);
        for i in 0..q.len() {
            let momentum = |t: f64| {
                let at = moved(&moved(q, dq, t), ddq, 0.5 * t * t);
                by_columns(tree, &at, &moved(dq, ddq, t), ddq)[0][i]
            };
            assert_close(torque[i], slope(momentum, 1e-3) + rest[i], 1e-8);
        }
    });
}

#[test]
fn power_goes_into_energy() {
    for_random_trees(|tree, q, dq, ddq| {
        let [_, _, torque] = by_columns(tree, q, dq, ddq);
        let energy = |t: f64| {
            let at = moved(&moved(q, dq, t), ddq, 0.5 * t * t);
            tree.kinetic(&at, &moved(dq, ddq, t)) + tree.potential(&at)
        };
        assert_close(inner(dq, &torque), slope(energy, 1e-3), 1e-8);
    });
}

#[test]
fn wrong_trees_and_lengths_are_refused() {
    let mut tree = Tree::draw(&mut Random::new(1), 3);
    tree.joints[1].parent = Some(2);
    assert_eq!(
        Chain::new(&tree.joints, GRAVITY).unwrap_err(),
        ChainError::Order {
            joint: 1,
            parent: 2
        }
    );
    tree.joints[1].parent = Some(0);
    tree.joints[2].axis = [0.0; 3];
    assert_eq!(
        Chain::new(&tree.joints, GRAVITY).unwrap_err(),
        ChainError::Axis { joint: 2 }
    );
    tree.joints[2].axis = [0.0, 1.0, 0.0];
    let chain = Chain::new(&tree.joints, GRAVITY).unwrap();
    let mut joints = [JointScratch::default(); 3];
    let mut pairs = [PairScratch::default(); 9];
    let mut workspace = Workspace {
        joints: &mut joints,
        pairs: &mut pairs,
    };
    let mut columns = [0.0; 9 * BODY];
    let short = torque(
        &chain,
        &[0.0; 3],
        &[0.0; 3],
        &[0.0; 2],
        &mut workspace,
        &mut columns,
    );
    assert_eq!(
        short.unwrap_err(),
        LengthError {
            what: "ddq",
            expected: 3,
            found: 2
        }
    );
}
