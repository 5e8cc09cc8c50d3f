//! Random robots made of bodies: the paper's arm with two rigid links, and trees of joints whose links are point
//! masses.
//!
//! Positions and velocities are computed in the frame of the base, independently of the regressor columns.
use sprung_core::chain::{Chain, ChainJoint, JointKind};
use sprung_core::spatial::{BODY, product, rotation};

use crate::support::{Random, inner};

/// Two links and the rotor that sits on the tip of the first.
pub(crate) struct Body {
    mass: [f64; 2],
    /// Distance of the centre of mass from the link's joint.
    centre: [f64; 2],
    /// About the centre of mass.
    inertia: [f64; 2],
    length: f64,
    rotor_mass: f64,
}

/// The centre of a body.
struct Centre {
    mass: f64,
    position: [f64; 2],
    velocity: [f64; 2],
}

impl Body {
    pub(crate) fn draw(random: &mut Random) -> Self {
        Self {
            mass: [random.between(0.2, 3.0), random.between(0.2, 3.0)],
            centre: [random.between(0.05, 0.4), random.between(0.05, 0.4)],
            inertia: [random.between(0.001, 0.1), random.between(0.001, 0.1)],
            length: random.between(0.2, 0.6),
            rotor_mass: random.between(0.0, 1.0),
        }
    }

    /// Link parameters by their definition; joint parameters at random.
    pub(crate) fn theta(&self, random: &mut Random) -> [f64; 15] {
        let ([m1, m2], [l1, l2]) = (self.mass, self.centre);
        let mut theta = [0.0; 15];
        theta[0] = self.inertia[0]
            + self.inertia[1]
            + m1 * l1 * l1
            + (m2 + self.rotor_mass) * self.length * self.length
            + m2 * l2 * l2;
        theta[1] = m2 * self.length * l2;
        theta[2] = self.inertia[1] + m2 * l2 * l2;
        for (from, low, high) in [
            (3, 0.005, 0.3),
            (5, 0.0, 0.1),
            (7, 0.0, 9.0),
            (9, 2.0, 50.0),
            (11, 0.0, 0.1),
            (13, 0.0, 2.0),
        ] {
            theta[from] = random.between(low, high);
            theta[from + 1] = random.between(low, high);
        }
        theta
    }

    fn centres(&self, q: &[f64], dq: &[f64]) -> [Centre; 3] {
        let (angle, speed) = ([q[0], q[0] + q[1]], [dq[0], dq[0] + dq[1]]);
        let arm = |r: f64, i: usize| {
            let (sin, cos) = angle[i].sin_cos();
            (
                [r * cos, r * sin],
                [-r * speed[i] * sin, r * speed[i] * cos],
            )
        };
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let (first, first_rate) = arm(self.centre[0], 0);
        let (tip, tip_rate) = arm(self.length, 0);
        let (second, second_rate) = arm(self.centre[1], 1);
        let centre = |mass, position, velocity| Centre {
            mass,
            position,
            velocity,
        };
        [
            centre(self.mass[0], first, first_rate),
            centre(self.rotor_mass, tip, tip_rate),
            centre(self.mass[1], sum(tip, second), sum(tip_rate, second_rate)),
        ]
    }

    pub(crate) fn kinetic_energy(&self, q: &[f64], dq: &[f64]) -> f64 {
        let spin = [dq[0], dq[0] + dq[1]];
        let turning: f64 = (0..2).map(|i| self.inertia[i] * spin[i] * spin[i]).sum();
        let moving: f64 = (self.centres(q, dq).iter())
            .map(|body| (body.mass, body.velocity))
            .map(|(m, v)| m * (v[0] * v[0] + v[1] * v[1]))
            .sum();
        0.5 * (turning + moving)
    }

    /// About the axis of the first joint.
    pub(crate) fn angular_momentum(&self, q: &[f64], dq: &[f64]) -> f64 {
        let turning = self.inertia[0] * dq[0] + self.inertia[1] * (dq[0] + dq[1]);
        let moving: f64 = (self.centres(q, dq).iter())
            .map(|body| (body.mass, (body.position, body.velocity)))
            .map(|(m, (x, v))| m * (x[0] * v[1] - x[1] * v[0]))
            .sum();
        turning + moving
    }
}

pub(crate) type Vector = [f64; 3];

pub(crate) const GRAVITY: Vector = [0.7, -1.2, -9.6];

/// Axis, origin and rotation of a joint in the frame of the base.
#[derive(Clone, Copy)]
struct Place {
    axis: Vector,
    origin: Vector,
    turn: [Vector; 3],
}

/// A point mass.
struct Point {
    mass: f64,
    position: Vector,
    /// Velocity per velocity of each joint.
    rates: Vec<Vector>,
}

/// A tree of joints whose links are point masses.
pub(crate) struct Tree {
    pub(crate) joints: Vec<ChainJoint>,
    /// Mass and position in the joint's frame; five point masses for each link.
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

/// Rodrigues' formula, column by column.
fn rodrigues(axis: Vector, angle: f64) -> [Vector; 3] {
    let (sin, cos) = angle.sin_cos();
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| {
        let along = axis.map(|x| (1.0 - cos) * dot(axis, unit) * x);
        let across = cross(axis, unit).map(|x| sin * x);
        add(add(unit.map(|x| cos * x), across), along)
    });
    [0, 1, 2].map(|i: usize| columns.map(|column| column[i]))
}

impl Tree {
    pub(crate) fn draw(random: &mut Random, n: usize) -> Self {
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
                // In most cases a joint continues the chain; otherwise it starts a branch or a second tree.
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

    pub(crate) fn bodies(&self) -> Vec<[f64; BODY]> {
        let sum = |link: &Vec<(f64, Vector)>| {
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
            body
        };
        self.masses.iter().map(sum).collect()
    }

    pub(crate) fn parameters(&self) -> Vec<f64> {
        self.bodies().concat()
    }

    pub(crate) fn chain(&self) -> Chain<'_> {
        Chain::new(&self.joints, GRAVITY).unwrap()
    }

    /// Joint `j` and all joints that carry it.
    pub(crate) fn carriers(&self, j: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(j), |&i| self.joints[i].parent)
    }

    fn places(&self, q: &[f64]) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::new();
        for (joint, q) in self.joints.iter().zip(q) {
            let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let base = Place {
                axis: [0.0; 3],
                origin: [0.0; 3],
                turn: identity,
            };
            let Place { origin, turn, .. } = joint.parent.map_or(base, |parent| places[parent]);
            let mut orientation = product(&turn, &joint.rotation);
            let mut at = add(origin, turned(&turn, joint.origin));
            let axis = turned(&orientation, joint.axis);
            match joint.kind {
                JointKind::Revolute => {
                    orientation = product(&orientation, &rodrigues(joint.axis, *q));
                }
                JointKind::Prismatic => at = add(at, axis.map(|x| x * q)),
            }
            places.push(Place {
                axis,
                origin: at,
                turn: orientation,
            });
        }
        places
    }

    fn points(&self, q: &[f64]) -> Vec<Point> {
        let places = self.places(q);
        let mut points = Vec::new();
        for (j, link) in self.masses.iter().enumerate() {
            for (mass, local) in link {
                let Place { origin, turn, .. } = &places[j];
                let at = add(*origin, turned(turn, *local));
                let mut rates = vec![[0.0; 3]; self.joints.len()];
                for i in self.carriers(j) {
                    let Place {
                        axis,
                        origin: pivot,
                        ..
                    } = places[i];
                    rates[i] = match self.joints[i].kind {
                        JointKind::Revolute => cross(axis, add(at, pivot.map(|x| -x))),
                        JointKind::Prismatic => axis,
                    };
                }
                points.push(Point {
                    mass: *mass,
                    position: at,
                    rates,
                });
            }
        }
        points
    }

    pub(crate) fn mass_matrix(&self, q: &[f64]) -> Vec<Vec<f64>> {
        let n = self.joints.len();
        let mut m = vec![vec![0.0; n]; n];
        for Point { mass, rates, .. } in self.points(q) {
            for (row, a) in m.iter_mut().zip(&rates) {
                for (entry, b) in row.iter_mut().zip(&rates) {
                    *entry += mass * dot(*a, *b);
                }
            }
        }
        m
    }

    pub(crate) fn kinetic(&self, q: &[f64], dq: &[f64]) -> f64 {
        let momentum = self.mass_matrix(q).into_iter().map(|row| inner(&row, dq));
        0.5 * dq.iter().zip(momentum).map(|(v, p)| v * p).sum::<f64>()
    }

    pub(crate) fn potential(&self, q: &[f64]) -> f64 {
        self.points(q)
            .iter()
            .map(|point| -point.mass * dot(GRAVITY, point.position))
            .sum()
    }
}
