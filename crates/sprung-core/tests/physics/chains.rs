//! Link columns of whole robots: Pinocchio's numbers, and the closed form of
//! the planar arm.
use serde_json::Value;
use sprung_core::chain::{Chain, ChainJoint, JointKind, Motions};
use sprung_core::dynamics::{inverse_dynamics, mass_matrix};
use sprung_core::links::{Step, regressor, torque};
use sprung_core::spatial::BODY;

use crate::closed_form::{Pose, torque as closed_torque};
use crate::support::{Memory, Random, Worst};

/// Largest error relative to the largest number of the same kind: rounding of double precision.
const TOLERANCE: f64 = 1e-12;

fn numbers(value: &Value) -> Vec<f64> {
    (value.as_array().unwrap().iter())
        .map(|x| x.as_f64().unwrap())
        .collect()
}

fn vector(value: &Value) -> [f64; 3] {
    numbers(value).try_into().unwrap()
}

fn joints(robot: &Value) -> Vec<ChainJoint> {
    let joint = |value: &Value| {
        let rows = value["rotation"].as_array().unwrap();
        ChainJoint {
            parent: value["parent"].as_u64().map(|parent| parent as usize),
            rotation: [vector(&rows[0]), vector(&rows[1]), vector(&rows[2])],
            origin: vector(&value["origin"]),
            axis: vector(&value["axis"]),
            kind: if value["prismatic"] == true {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            },
        }
    };
    robot["joints"]
        .as_array()
        .unwrap()
        .iter()
        .map(joint)
        .collect()
}

/// Momentum, rest and torque columns of one state.
struct Columns {
    momentum: Vec<f64>,
    rest: Vec<f64>,
    torque: Vec<f64>,
}

fn columns(chain: &Chain<'_>, q: &[f64], dq: &[f64], ddq: &[f64]) -> Columns {
    let n = chain.joints().len();
    let mut memory = Memory::new(n);
    let workspace = &mut memory.workspace();
    let [mut momentum, mut rest, mut of_torque] = [(); 3].map(|()| vec![0.0; n * n * BODY]);
    regressor(chain, q, dq, workspace, &mut momentum, &mut rest).unwrap();
    torque(chain, q, dq, ddq, workspace, &mut of_torque).unwrap();
    Columns {
        momentum,
        rest,
        torque: of_torque,
    }
}

fn times(columns: &[f64], pi: &[f64]) -> Vec<f64> {
    (columns.chunks(pi.len()))
        .map(|row| row.iter().zip(pi).map(|(a, b)| a * b).sum())
        .collect()
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

fn assert_close(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    let mut worst = Worst::default();
    for (a, b) in found.iter().zip(expected) {
        worst.see(a - b, scale);
    }
    worst.assert_below(TOLERANCE, what);
}

fn fixture() -> Value {
    serde_json::from_str(include_str!("../fixtures/chains.json")).unwrap()
}

/// Compares the products of Pinocchio with the regressor columns and with the recursions.
fn check_products(chain: &Chain<'_>, pi: &[f64], case: &Value) {
    let of = |key: &str| numbers(&case[key]);
    let (q, dq, ddq) = (of("q"), of("qd"), of("qdd"));
    let rest = sum(&of("pin_minus_CT_qd"), &of("pin_gravity"));
    let found = columns(chain, &q, &dq, &ddq);
    assert_close("momentum", &times(&found.momentum, pi), &of("pin_momentum"));
    assert_close("rest", &times(&found.rest, pi), &rest);
    assert_close("torque", &times(&found.torque, pi), &of("pin_tau"));

    let n = chain.joints().len();
    let (bodies, _) = pi.as_chunks::<BODY>();
    let mut tau = vec![f64::NAN; n];
    let mut recursion = |dq: &[f64], ddq: &[f64]| {
        let mut steps = vec![Step::default(); n];
        inverse_dynamics(chain, bodies, &q, dq, ddq, &mut steps, &mut tau).unwrap();
        tau.clone()
    };
    assert_close("recursion", &recursion(&dq, &ddq), &of("pin_tau"));
    let rest = vec![0.0; n];
    assert_close("gravity", &recursion(&rest, &rest), &of("pin_gravity"));

    let mut matrix = vec![f64::NAN; n * n];
    let mut memory = Memory::new(n);
    mass_matrix(chain, bodies, &q, memory.workspace().steps, &mut matrix).unwrap();
    assert_close("mass matrix", &times(&matrix, &dq), &of("pin_momentum"));
}

#[test]
fn columns_and_recursions_are_what_pinocchio_computes() {
    let fixture = fixture();
    for name in ["planar2r", "arm7"] {
        let robot = &fixture[name];
        let joints = joints(robot);
        let chain = Chain::new(&joints, vector(&robot["gravity"])).unwrap();
        for case in robot["cases"].as_array().unwrap() {
            check_products(&chain, &numbers(&robot["pi"]), case);
        }
    }
}

#[test]
fn every_column_is_that_of_independent_code() {
    let fixture = fixture();
    for name in ["planar2r", "arm7"] {
        let Some(path) = sprung_testing::golden(&format!("{name}.json")) else {
            return;
        };
        let text = std::fs::read_to_string(path).unwrap();
        let golden: Value = serde_json::from_str(&text).unwrap();
        let joints = joints(&fixture[name]);
        let chain = Chain::new(&joints, vector(&golden["gravity"])).unwrap();
        for case in golden["cases"].as_array().unwrap() {
            let of = |key: &str| numbers(&case[key]);
            let matrix = |key: &str| -> Vec<f64> {
                let rows = case[key].as_array().unwrap();
                rows.iter().flat_map(numbers).collect()
            };
            let found = columns(&chain, &of("q"), &of("qd"), &of("qdd"));
            assert_close("Ya", &found.momentum, &matrix("Ya"));
            assert_close("Yi + G", &found.rest, &sum(&matrix("Yi"), &matrix("G")));
            assert_close("Y", &found.torque, &matrix("Y"));
            check_products(&chain, &numbers(&golden["pi"]), case);
        }
    }
}

#[test]
fn planar_arm_in_closed_form_is_the_chain_with_vertical_axes() {
    let fixture = fixture();
    let joints = joints(&fixture["planar2r"]);
    let chain = Chain::new(&joints, [0.0, 0.0, -9.81]).unwrap();
    let length = joints[1].origin[0];
    let mut random = Random::new(7);
    for _ in 0..100 {
        // theta1 = izz1 + L1² m2 + izz2, theta2 = L1 mx2, theta3 = izz2.
        let theta = [0; 3].map(|_| random.between(0.01, 0.5));
        let mut pi = vec![0.0; 2 * BODY];
        pi[BODY - 1] = theta[0] - theta[2];
        pi[BODY + 1] = theta[1] / length;
        pi[2 * BODY - 1] = theta[2];
        let [q, dq, ddq] = [3.0, 4.0, 9.0].map(|limit| random.pair(limit));
        let found = columns(&chain, &q, &dq, &ddq);
        let pose = Pose::<f64>::new(&q);
        let closed = |columns: [[f64; 3]; 2]| {
            columns.map(|row| row.iter().zip(theta).map(|(a, b)| a * b).sum::<f64>())
        };
        assert_close(
            "momentum",
            &times(&found.momentum, &pi),
            &closed(pose.momentum(&dq)),
        );
        assert_close("rest", &times(&found.rest, &pi), &closed(pose.rest(&dq)));
        let closed = closed_torque(&theta, &q, &dq, &ddq);
        assert_close("torque", &times(&found.torque, &pi), &closed);
    }
}

/// A tree with branches whose joints turn about z or slide perpendicular to z.
fn flat_tree(random: &mut Random, n: usize) -> Vec<ChainJoint> {
    (0..n)
        .map(|j| {
            let turn = random.between(-3.0, 3.0);
            let (sin, cos) = turn.sin_cos();
            let slides = random.between(0.0, 1.0) < 0.4;
            let (along_y, along_x) = random.between(-3.0, 3.0).sin_cos();
            let [x, y] = random.pair(0.5);
            ChainJoint {
                parent: (j > 0).then(|| random.between(0.0, j as f64) as usize),
                rotation: [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]],
                origin: [x, y, random.between(-0.5, 0.5)],
                axis: if slides {
                    [along_x, along_y, 0.0]
                } else {
                    [
                        0.0,
                        0.0,
                        if random.between(-1.0, 1.0) < 0.0 {
                            -1.0
                        } else {
                            1.0
                        },
                    ]
                },
                kind: if slides {
                    JointKind::Prismatic
                } else {
                    JointKind::Revolute
                },
            }
        })
        .collect()
}

#[test]
fn motions_in_a_plane_are_those_in_space() {
    let mut random = Random::new(9);
    for case in 0..60 {
        let n = 1 + case % 5;
        let joints = flat_tree(&mut random, n);
        let gravity = if case % 2 == 0 {
            [1.0, -9.0, 3.0]
        } else {
            [0.0, 0.0, -9.81]
        };
        let flat = Chain::new(&joints, gravity).unwrap();
        assert_eq!(flat.motions(), Motions::InPlane);
        let full = Chain::checked(&joints, gravity, Motions::InSpace);
        let [q, dq, ddq] = [3.0, 4.0, 9.0].map(|limit| random.list(n, limit));
        let [a, b] = [&flat, &full].map(|chain| columns(chain, &q, &dq, &ddq));
        assert_close("momentum", &a.momentum, &b.momentum);
        assert_close("rest", &a.rest, &b.rest);
        assert_close("torque", &a.torque, &b.torque);
        let bodies: Vec<[f64; BODY]> = (0..n)
            .map(|_| random.list(BODY, 1.0).try_into().unwrap())
            .collect();
        let [a, b] = [&flat, &full].map(|chain| {
            let (mut tau, mut matrix) = (vec![0.0; n], vec![0.0; n * n]);
            let steps = &mut vec![Step::default(); n];
            inverse_dynamics(chain, &bodies, &q, &dq, &ddq, steps, &mut tau).unwrap();
            let mut memory = Memory::new(n);
            mass_matrix(chain, &bodies, &q, memory.workspace().steps, &mut matrix).unwrap();
            [tau, matrix]
        });
        assert_close("torques", &a[0], &b[0]);
        assert_close("masses", &a[1], &b[1]);
    }
}
