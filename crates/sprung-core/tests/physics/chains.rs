//! Link columns of whole robots: Pinocchio's numbers, and the closed form of
//! the planar arm.
use serde_json::Value;
use sprung_core::chain::{Chain, ChainJoint, JointKind};
use sprung_core::links::{JointScratch, PairScratch, Workspace, regressor, torque};
use sprung_core::planar_2r::Pose;
use sprung_core::spatial::BODY;

use crate::support::Random;

/// Largest error, as part of the largest number of the same kind.
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
    let mut joints = vec![JointScratch::default(); n];
    let mut pairs = vec![PairScratch::default(); n * n];
    let mut workspace = Workspace {
        joints: &mut joints,
        pairs: &mut pairs,
    };
    let mut all = Columns {
        momentum: vec![0.0; n * n * BODY],
        rest: vec![0.0; n * n * BODY],
        torque: vec![0.0; n * n * BODY],
    };
    regressor(
        chain,
        q,
        dq,
        &mut workspace,
        &mut all.momentum,
        &mut all.rest,
    )
    .unwrap();
    torque(chain, q, dq, ddq, &mut workspace, &mut all.torque).unwrap();
    all
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
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < TOLERANCE * scale, "{what}: {a} {b}");
    }
}

fn fixture() -> Value {
    serde_json::from_str(include_str!("../fixtures/chains.json")).unwrap()
}

#[test]
fn columns_times_parameters_are_what_pinocchio_computes() {
    let fixture = fixture();
    for name in ["planar2r", "arm7"] {
        let robot = &fixture[name];
        let joints = joints(robot);
        let chain = Chain::new(&joints, vector(&robot["gravity"])).unwrap();
        let pi = numbers(&robot["pi"]);
        for case in robot["cases"].as_array().unwrap() {
            let of = |key: &str| numbers(&case[key]);
            let found = columns(&chain, &of("q"), &of("qd"), &of("qdd"));
            assert_close(
                "momentum",
                &times(&found.momentum, &pi),
                &of("pin_momentum"),
            );
            let rest = sum(&of("pin_minus_CT_qd"), &of("pin_gravity"));
            assert_close("rest", &times(&found.rest, &pi), &rest);
            assert_close("torque", &times(&found.torque, &pi), &of("pin_tau"));
        }
    }
}

#[test]
fn every_column_is_that_of_independent_code() {
    let fixture = fixture();
    for name in ["planar2r", "arm7"] {
        let path = format!(
            "{}/../../../shared/golden/{name}.json",
            env!("CARGO_MANIFEST_DIR")
        );
        let Ok(text) = std::fs::read_to_string(&path) else {
            eprintln!("skipped: no golden vectors at {path}");
            return;
        };
        let golden: Value = serde_json::from_str(&text).unwrap();
        let joints = joints(&fixture[name]);
        let chain = Chain::new(&joints, vector(&golden["gravity"])).unwrap();
        for case in golden["cases"].as_array().unwrap() {
            let of = |key: &str| numbers(&case[key]);
            let matrix = |key: &str| -> Vec<f64> {
                case[key]
                    .as_array()
                    .unwrap()
                    .iter()
                    .flat_map(numbers)
                    .collect()
            };
            let found = columns(&chain, &of("q"), &of("qd"), &of("qdd"));
            assert_close("Ya", &found.momentum, &matrix("Ya"));
            assert_close("Yi + G", &found.rest, &sum(&matrix("Yi"), &matrix("G")));
            assert_close("Y", &found.torque, &matrix("Y"));
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
        let (q, dq) = (random.pair(3.0), random.pair(4.0));
        let found = columns(&chain, &q, &dq, &[0.0; 2]);
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
    }
}
