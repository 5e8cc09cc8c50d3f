//! A mechanism as a file describes it, and its dynamics by the equations of Newton and Euler in the
//! frame of the world.
//!
//! The dynamics share no code with those of `sprung_core`, which use spatial vectors and base
//! parameters, so their comparison is an independent test.

use std::array::from_fn;

type Vector = [f64; 3];
type Matrix = [Vector; 3];

const UNTURNED: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A mechanism that was read from a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Mechanism {
    /// Parents come before their children.
    pub(super) joints: Vec<MechanismJoint>,
    pub(super) springs: Vec<Spring>,
    /// Acceleration of free fall, m/s²; `None` if the file does not contain it.
    pub(super) gravity: Option<Vector>,
}

/// A joint and the body that it moves.
#[derive(Clone, Debug)]
pub(super) struct MechanismJoint {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    /// Frame of the joint in the parent's frame at position zero; the columns are its axes.
    pub(super) rotation: Matrix,
    pub(super) origin: Vector,
    /// Unit vector in the joint's frame.
    pub(super) axis: Vector,
    pub(super) slides: bool,
    pub(super) mass: f64,
    /// Centre of mass in the joint's frame.
    pub(super) centre: Vector,
    /// Inertia about the centre of mass in the joint's axes.
    pub(super) inertia: Matrix,
    /// Inertia that acts only on this coordinate.
    pub(super) armature: f64,
    pub(super) damping: f64,
    pub(super) coulomb: f64,
}

impl Default for MechanismJoint {
    /// A joint on the base without mass, about the z axis.
    fn default() -> Self {
        Self {
            name: String::new(),
            parent: None,
            rotation: UNTURNED,
            origin: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            slides: false,
            mass: 0.0,
            centre: [0.0; 3],
            inertia: [[0.0; 3]; 3],
            armature: 0.0,
            damping: 0.0,
            coulomb: 0.0,
        }
    }
}

/// A spring and damper on a linear combination of coordinates.
#[derive(Clone, Debug)]
pub(super) struct Spring {
    pub(super) coefficients: Vec<(usize, f64)>,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
}

/// Positions, velocities and accelerations of all joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion<'a> {
    pub(super) q: &'a [f64],
    pub(super) dq: &'a [f64],
    pub(super) ddq: &'a [f64],
}

/// Motion of a body in the frame of the world.
#[derive(Clone, Copy, Debug, Default)]
struct Moving {
    axes: Matrix,
    place: Vector,
    axis: Vector,
    turning: Vector,
    turning_rate: Vector,
    acceleration: Vector,
}

impl Mechanism {
    /// Returns the index of a joint.
    pub(super) fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Returns the torques of a motion with gravity, springs and viscous friction.
    pub(super) fn torques(&self, motion: &Motion<'_>, gravity: Vector) -> Vec<f64> {
        let mut torques = self.inertial_torques(motion, gravity);
        for (i, joint) in self.joints.iter().enumerate() {
            torques[i] += joint.damping * motion.dq[i];
        }
        for spring in &self.springs {
            let along = |values: &[f64]| -> f64 {
                let terms = spring.coefficients.iter();
                terms.map(|(i, by)| by * values[*i]).sum()
            };
            let torque = spring.stiffness * along(motion.q) + spring.damping * along(motion.dq);
            for (i, by) in &spring.coefficients {
                torques[*i] += by * torque;
            }
        }
        torques
    }

    /// Returns the mass matrix, row by row.
    pub(super) fn masses(&self, q: &[f64]) -> Vec<f64> {
        let n = self.joints.len();
        let zeros = vec![0.0; n];
        let mut masses = vec![0.0; n * n];
        for column in 0..n {
            let mut unit = zeros.clone();
            unit[column] = 1.0;
            let motion = Motion {
                q,
                dq: &zeros,
                ddq: &unit,
            };
            let torques = self.inertial_torques(&motion, [0.0; 3]);
            for (row, torque) in torques.into_iter().enumerate() {
                masses[row * n + column] = torque;
            }
        }
        masses
    }

    fn inertial_torques(&self, motion: &Motion<'_>, gravity: Vector) -> Vec<f64> {
        let moving = self.moving(motion, gravity);
        let n = self.joints.len();
        let (mut forces, mut moments) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        let mut torques = vec![0.0; n];
        for (i, joint) in self.joints.iter().enumerate().rev() {
            let body = &moving[i];
            let arm = turned(&body.axes, &joint.centre);
            let at_centre = sum(
                &body.acceleration,
                &sum(
                    &cross(&body.turning_rate, &arm),
                    &cross(&body.turning, &cross(&body.turning, &arm)),
                ),
            );
            let force = at_centre.map(|a| joint.mass * a);
            let inertia = |v: &Vector| {
                let inside = from_fn(|k| (0..3).map(|l| body.axes[l][k] * v[l]).sum());
                turned(&body.axes, &turned(&joint.inertia, &inside))
            };
            let spin = cross(&body.turning, &inertia(&body.turning));
            let moment = sum(
                &sum(&inertia(&body.turning_rate), &spin),
                &cross(&arm, &force),
            );
            forces[i] = sum(&forces[i], &force);
            moments[i] = sum(&moments[i], &moment);
            let along = if joint.slides {
                &forces[i]
            } else {
                &moments[i]
            };
            torques[i] = dot(&body.axis, along) + joint.armature * motion.ddq[i];
            if let Some(parent) = joint.parent {
                let lever = difference(&body.place, &moving[parent].place);
                let carried = sum(&moments[i], &cross(&lever, &forces[i]));
                moments[parent] = sum(&moments[parent], &carried);
                forces[parent] = sum(&forces[parent], &forces[i]);
            }
        }
        torques
    }

    /// Returns the motion of all bodies; the base accelerates against gravity.
    fn moving(&self, motion: &Motion<'_>, gravity: Vector) -> Vec<Moving> {
        let base = Moving {
            axes: UNTURNED,
            acceleration: gravity.map(|g| -g),
            ..Moving::default()
        };
        let mut moving: Vec<Moving> = Vec::with_capacity(self.joints.len());
        for (i, joint) in self.joints.iter().enumerate() {
            let from = joint.parent.map_or(base, |parent| moving[parent]);
            let (q, v, a) = (motion.q[i], motion.dq[i], motion.ddq[i]);
            let still = product(&from.axes, &joint.rotation);
            let axis = turned(&still, &joint.axis);
            let slide = if joint.slides { q } else { 0.0 };
            let lever: Vector = sum(&turned(&from.axes, &joint.origin), &axis.map(|x| slide * x));
            let carried = sum(
                &from.acceleration,
                &sum(
                    &cross(&from.turning_rate, &lever),
                    &cross(&from.turning, &cross(&from.turning, &lever)),
                ),
            );
            let mut body = Moving {
                axes: still,
                place: sum(&from.place, &lever),
                axis,
                turning: from.turning,
                turning_rate: from.turning_rate,
                acceleration: carried,
            };
            let drift = cross(&from.turning, &axis);
            if joint.slides {
                body.acceleration = from_fn(|k| carried[k] + 2.0 * v * drift[k] + a * axis[k]);
            } else {
                body.axes = product(&still, &about(&joint.axis, q));
                body.turning = from_fn(|k| from.turning[k] + v * axis[k]);
                body.turning_rate = from_fn(|k| from.turning_rate[k] + a * axis[k] + v * drift[k]);
            }
            moving.push(body);
        }
        moving
    }
}

/// Rotation about a unit vector, by the formula of Rodrigues.
fn about(axis: &Vector, angle: f64) -> Matrix {
    let (sin, cos) = angle.sin_cos();
    let [x, y, z] = *axis;
    let skew = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    from_fn(|i| {
        from_fn(|j| {
            let unit = if i == j { cos } else { 0.0 };
            unit + sin * skew[i][j] + (1.0 - cos) * axis[i] * axis[j]
        })
    })
}

/// Returns the rotation of a quaternion w, x, y, z of any length.
pub(super) fn rotation_of(quaternion: [f64; 4]) -> Matrix {
    let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [w, x, y, z] = quaternion.map(|part| part / length);
    let (vector, twice) = ([x, y, z], [2.0 * x, 2.0 * y, 2.0 * z]);
    let skew = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let squared = x * x + y * y + z * z;
    from_fn(|i| {
        from_fn(|j| {
            let unit = if i == j { w * w - squared } else { 0.0 };
            unit + twice[i] * vector[j] + 2.0 * w * skew[i][j]
        })
    })
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sum(a: &Vector, b: &Vector) -> Vector {
    from_fn(|k| a[k] + b[k])
}

fn difference(a: &Vector, b: &Vector) -> Vector {
    from_fn(|k| a[k] - b[k])
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn turned(matrix: &Matrix, v: &Vector) -> Vector {
    from_fn(|k| dot(&matrix[k], v))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    from_fn(|i| from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}
