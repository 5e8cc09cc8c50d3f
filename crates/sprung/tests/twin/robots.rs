//! Numbers of parameters of robots in the literature, and the planar arm described in two ways.

use std::path::Path;

use sprung_base::progress::Unheard;
use sprung_method::estimate::identify;
use sprung_model::Model;
use sprung_robot::{self as description, Constraints, Estimator, Experiment, no_files};

use crate::in_memory::with_source;
use crate::support::Twin;

fn flexible(kinematics: &str, joints: usize) -> Model {
    let names: Vec<String> = (1..=joints).map(|i| format!("joint{i}")).collect();
    let blocks = format!(
        "[[robot.joint]]\nname = \"{}\"\n",
        names.join("\"\n[[robot.joint]]\nname = \"")
    );
    let text = format!(
        "format = 1\n[robot]\n{kinematics}\n{blocks}[identify]\nencoder_offset = \"none\"\n"
    );
    let experiment = description::read("robot", &text, &[], &mut no_files).unwrap();
    Model::new(&experiment).unwrap()
}

#[test]
fn totals_are_those_of_the_literature() {
    let panda =
        "dh_modified = [{ d_m = 0.333 }, { alpha_deg = -90 }, { alpha_deg = 90, d_m = 0.316 },
        { alpha_deg = 90, a_m = 0.0825 }, { alpha_deg = -90, a_m = -0.0825, d_m = 0.384 },
        { alpha_deg = 90 }, { alpha_deg = 90, a_m = 0.088 }]"
            .replace('\n', " ");
    assert_eq!(flexible(&panda, 7).parameters().len(), 85);
    let ur5 = "dh_classic = [{ alpha_deg = 90, d_m = 0.089159 }, { a_m = -0.425 },
        { a_m = -0.39225 }, { alpha_deg = 90, d_m = 0.10915 }, { alpha_deg = -90, d_m = 0.09465 },
        { d_m = 0.0823 }]"
        .replace('\n', " ");
    assert_eq!(flexible(&ur5, 6).parameters().len(), 72);
    let planar = "dh_modified = [{}, { a_m = 0.343 }]";
    assert_eq!(flexible(planar, 2).parameters().len(), 16);
    let symmetric = format!("{planar}\nassume_zero = [\"link2.my\"]");
    assert_eq!(flexible(&symmetric, 2).parameters().len(), 15);
}

#[test]
fn a_rigid_arm_lumps_its_rotors_with_its_links() {
    let text = "format = 1\n[robot]\ndh_modified = [{ prismatic = true }]\n\
                gravity_m_per_s2 = [9.81, 0.0, 0.0]\n[[robot.joint]]\nname = \"carriage\"\n\
                transmission = \"rigid\"\n";
    let experiment = description::read("robot", text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let names: Vec<&str> = model.parameters().iter().map(|p| p.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "link1.m + carriage.rotor_inertia",
            "carriage.motor_viscous",
            "carriage.motor_coulomb",
            "carriage.motor_offset"
        ]
    );
    let units: Vec<&str> = model.parameters().iter().map(|p| p.unit).collect();
    assert_eq!(units, ["kg", "N·s/m", "N", "N"]);
}

/// Length of the first link, m. The parameters of the planar arm do not depend on it.
const LENGTH: f64 = 0.343;

const URDF: &str = r#"<robot name="planar"><link name="base"/><link name="link1"/><link name="link2"/>
<joint name="joint1" type="revolute"><parent link="base"/><child link="link1"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
<joint name="joint2" type="revolute"><parent link="link1"/><child link="link2"/>
<origin xyz="0.343 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint></robot>"#;

/// The demo's experiment with its arm described by a URDF.
fn by_urdf() -> Experiment {
    let text = sprung_base::demo::EXPERIMENT
        .replace(
            "kinematics = \"planar-2r\"",
            "urdf = \"planar.urdf\"\nassume_zero = [\"link2.my\"]",
        )
        .replace("\"link1.inertia_total\" = 0.190807\n", "")
        .replace("\"link2.coupling\"      = 0.016474\n", "")
        .replace("\"link2.inertia\"       = 0.010724\n", "")
        .replace("[identify]", "[identify]\nencoder_offset = \"none\"");
    let mut open = |path: &Path| {
        assert_eq!(path, Path::new("planar.urdf"));
        Ok(URDF.to_owned())
    };
    description::read("experiment.toml", &text, &[], &mut open).unwrap()
}

#[test]
fn urdf_and_closed_form_give_the_same_estimates() {
    let mut closed = Twin::new();
    let mut urdf = by_urdf();
    for experiment in [&mut closed.experiment, &mut urdf] {
        experiment.identify.estimator = vec![Estimator::LeastSquares];
        // Closed form and tree have different unknowns, and so different priors.
        experiment.identify.constraints = Constraints::None;
    }
    let log = closed.log(closed.experiment.simulate.as_ref().unwrap());
    let values = |experiment: &Experiment| -> Vec<f64> {
        let model = Model::new(experiment).unwrap();
        with_source(&log, |source| {
            let found = identify(experiment, &model, &mut [source], &mut Unheard).unwrap();
            let result = &found.identification.results[0];
            result.parameters.iter().map(|p| p.value.unwrap()).collect()
        })
    };
    let (mut tree, closed) = (values(&urdf), values(&closed.experiment));
    assert_eq!(tree.len(), closed.len());
    // The base parameters of the tree are izz1 + L1² m2, mx2 and izz2; the next lines turn them into the paper's.
    tree[0] += tree[2];
    tree[1] *= LENGTH;
    let worst = (tree.iter().zip(&closed))
        .map(|(a, b)| (a / b - 1.0).abs())
        .fold(0.0, f64::max);
    println!("URDF against closed form: {worst:.1e}");
    // Both descriptions have the same equations, so their estimates differ by rounding times the condition number,
    // which is below 1e4 after scaling.
    assert!(worst < 1e4 * 4.0 * f64::EPSILON, "{worst:e}");
}
