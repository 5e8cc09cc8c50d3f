//! Times one sample: the regressor, the filtered regressor and the accelerations, for the paper's
//! arm and for an arm with seven flexible joints.

use divan::{Bencher, black_box};
use sprung_base::demo;
use sprung_core::drives::State;
use sprung_core::robot::Values;
use sprung_method::regression::FilteredRegression;
use sprung_model::{Model, Scratch};
use sprung_robot::{self as description, DiscretizationName, no_files};

/// Kinematics of the Franka Panda with a spring in every joint.
const PANDA: &str = r#"
format = 1
[robot]
dh_modified = [
  { d_m = 0.333 },
  { alpha_deg = -90.0 },
  { alpha_deg = 90.0, d_m = 0.316 },
  { alpha_deg = 90.0, a_m = 0.0825 },
  { alpha_deg = -90.0, a_m = -0.0825, d_m = 0.384 },
  { alpha_deg = 90.0 },
  { alpha_deg = 90.0, a_m = 0.088 },
]
joint = [
  { name = "a1" }, { name = "a2" }, { name = "a3" }, { name = "a4" },
  { name = "a5" }, { name = "a6" }, { name = "a7" },
]
"#;

const ROBOTS: [(&str, &str); 2] = [("planar-2r", demo::EXPERIMENT), ("panda", PANDA)];

fn main() {
    divan::main();
}

fn model(name: &str) -> Model {
    let text = ROBOTS.iter().find(|(known, _)| *known == name);
    let (_, text) = text.expect("a robot of the list");
    let experiment = description::read(name, text, &[], &mut no_files).expect("it is right");
    Model::new(&experiment).expect("it is right")
}

/// Returns positions and velocities of `n` joints.
fn numbers(n: usize) -> [Vec<f64>; 4] {
    std::array::from_fn(|group| (0..n).map(|i| 0.3 + 0.2 * (i + group) as f64).collect())
}

fn state(numbers: &[Vec<f64>; 4]) -> State<'_> {
    let [q, dq, phi, dphi] = numbers;
    State {
        q,
        dq,
        phi,
        dphi,
        excess: &[],
        elements: &[],
    }
}

#[divan::bench(args = ["planar-2r", "panda"])]
fn regressor_of_a_sample(bencher: Bencher, robot: &str) {
    let model = model(robot);
    let mut scratch = Scratch::new(model.joint_count());
    let numbers = numbers(model.joint_count());
    let (mut momentum, mut rest) = (vec![0.0; model.entries()], vec![0.0; model.entries()]);
    let equations = model.robot();
    bencher.bench_local(move || {
        let mut workspace = scratch.workspace();
        let state = state(black_box(&numbers));
        equations.regressor(&state, &mut workspace, &mut momentum, &mut rest)
    });
}

#[divan::bench(args = ["planar-2r", "panda"])]
fn filtered_regressor_of_a_sample(bencher: Bencher, robot: &str) {
    let model = model(robot);
    let numbers = numbers(model.joint_count());
    let mut regression =
        FilteredRegression::new(&model, 30.0, 1e-3, DiscretizationName::Matched).expect("settings");
    bencher.bench_local(move || {
        let (entries, _) = regression.process(&state(black_box(&numbers)), &numbers[0], &[]);
        entries[0]
    });
}

#[divan::bench(args = ["planar-2r", "panda"])]
fn acceleration(bencher: Bencher, robot: &str) {
    let model = model(robot);
    let n = model.joint_count();
    let mut scratch = Scratch::new(n);
    let numbers = numbers(n);
    let theta: Vec<f64> = (model.parameters().iter())
        .map(|p| if p.name.contains("ixy") { 0.0 } else { 1.0 })
        .collect();
    let bodies = vec![[1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.1, 0.0, 0.0, 0.1]; n];
    let mut out = vec![0.0; model.rows()];
    // The torque acts on the motor rows, because all joints are flexible.
    let torque = [vec![0.0; n], numbers[1].clone()].concat();
    let equations = model.robot();
    bencher.bench_local(move || {
        let values = Values {
            theta: &theta,
            bodies: &bodies,
        };
        let mut workspace = scratch.workspace();
        let state = state(black_box(&numbers));
        equations.acceleration(&values, &state, &torque, &mut workspace, &mut out)
    });
}
