//! Robots of several kinds in all formats, and files with one wrong number.

use std::collections::BTreeMap;

use super::mechanism::rotation_of;
use super::mujoco::mujoco;
use super::read_mjcf;
use super::standard::standard;
use super::write::{Request, export, prove};
use super::{DrawOrigin, Earlier, Form, Format, How, Origin, Proof, earlier};
use crate::description::{Experiment, no_files, read};
use crate::model::Model;

const FORMATS: [Format; 4] = [Format::Urdf, Format::Mjcf, Format::Sdf, Format::Json];

/// Turning and sliding joints, flexible and rigid, in a tilted world.
const MIXED: &str = r#"format = 1
[robot]
name = "mixed & <odd>"
dh_modified = [
  { alpha_deg = 0.0, d_m = 0.3, theta_deg = 20.0 },
  { alpha_deg = -90.0, a_m = 0.1, prismatic = true },
  { alpha_deg = 90.0, a_m = 0.2, d_m = 0.1 },
]
gravity_m_per_s2 = [1.0, -2.0, -9.0]
[[robot.joint]]
name = "a"
spring = ["linear", "damping", "cubic"]
gear_ratio = 50.0
[[robot.joint]]
name = "b"
[[robot.joint]]
name = "c"
transmission = "rigid"
motor_friction = ["viscous-asymmetric", "coulomb", "stribeck"]
"#;

const PLANAR: &str = r#"format = 1
[robot]
name = "planar"
kinematics = "planar-2r"
[[robot.joint]]
name = "j1"
[[robot.joint]]
name = "j2"
"#;

struct Case {
    experiment: Experiment,
    model: Model,
    values: BTreeMap<String, f64>,
}

fn case(text: &str, values: &[(&str, f64)]) -> Case {
    let experiment = read("test", text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let values = values
        .iter()
        .map(|(name, value)| ((*name).to_owned(), *value));
    Case {
        experiment,
        model,
        values: values.collect(),
    }
}

fn mixed() -> Case {
    let mut case = case(
        MIXED,
        &[
            ("a.rotor_inertia", 0.8),
            ("a.stiffness", 900.0),
            ("a.spring_damping", 0.7),
            ("a.cubic_stiffness", 40.0),
            ("a.link_viscous", 0.4),
            ("a.motor_viscous", 3.0),
            ("a.link_coulomb", 0.2),
            ("a.motor_coulomb", 1.5),
            ("b.rotor_inertia", 4.0),
            ("b.stiffness", 9000.0),
            ("b.motor_viscous", 30.0),
            ("c.rotor_inertia", 0.02),
            ("c.motor_viscous_positive", 0.3),
            ("c.motor_viscous_negative", 0.1),
            ("c.motor_coulomb", 0.25),
            ("c.motor_stribeck", 0.1),
        ],
    );
    let names = [
        "m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz",
    ];
    for (link, by) in [("link1", 1.0), ("link2", 0.6), ("link3", 0.3)] {
        let body = [4.0, 0.4, -0.2, 0.3, 0.12, 0.03, 0.15, -0.02, 0.025, 0.2];
        for (name, value) in names.iter().zip(body) {
            case.values.insert(format!("{link}.{name}"), by * value);
        }
    }
    case
}

fn planar() -> Case {
    case(
        PLANAR,
        &[
            ("link1.inertia_total", 0.2),
            ("link2.coupling", 0.02),
            ("link2.inertia", 0.013),
            ("j1.rotor_inertia", 0.2),
            ("j2.rotor_inertia", 0.007),
            ("j1.stiffness", 9.0),
            ("j2.stiffness", 4.0),
            ("j1.motor_viscous", 8.0),
            ("j2.link_viscous", 0.003),
        ],
    )
}

fn request(case: &Case, format: Format, form: Form) -> Request<'_> {
    Request {
        format,
        form,
        experiment: &case.experiment,
        model: &case.model,
        values: &case.values,
        urdf: None,
        is_there: &|_| false,
        evidence: &[],
        origin: Origin {
            experiment: "test--case.toml".to_owned(),
            parameters: "values.toml".to_owned(),
            estimator: None,
            verdict: None,
            draw: None,
            logs: Vec::new(),
            values: Vec::new(),
        },
        control: None,
        observer: None,
    }
}

#[test]
fn code_is_the_identified_model() {
    for case in [mixed(), planar()] {
        for format in [Format::C, Format::Rust] {
            let found = export(&request(&case, format, Form::Rigid)).unwrap();
            assert_eq!(found.texts.len(), format.files().len());
            assert!(found.proof.inverse_dynamics > 0.0 && found.proof.inverse_dynamics < 1e-12);
            assert!(found.proof.mass_matrix < 1e-12 && found.proof.accelerations < 1e-9);
            for text in &found.texts {
                assert_eq!(earlier(text), Earlier::Unchanged);
            }
        }
    }
}

#[test]
fn code_of_too_many_joints_is_refused() {
    let joint = |i: usize| format!("[[robot.joint]]\nname = \"j{i}\"\ntransmission = \"rigid\"\n");
    let rows = "  { alpha_deg = 90.0, a_m = 0.1 },\n".repeat(33);
    let joints: String = (0..33).map(joint).collect();
    let text = format!(
        "format = 1\n[robot]\nname = \"long\"\ndh_modified = [\n{rows}]\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\n{joints}"
    );
    let mut case = case(&text, &[]);
    for i in 0..33 {
        for (name, value) in [
            ("m", 1.0),
            ("mx", 0.0),
            ("my", 0.0),
            ("mz", 0.0),
            ("ixx", 0.1),
            ("ixy", 0.0),
            ("iyy", 0.1),
            ("ixz", 0.0),
            ("iyz", 0.0),
            ("izz", 0.1),
        ] {
            case.values.insert(format!("link{}.{name}", i + 1), value);
        }
    }
    for i in 0..33 {
        case.values.insert(format!("j{i}.rotor_inertia"), 0.1);
    }
    let error = export(&request(&case, Format::C, Form::Flexible)).unwrap_err();
    assert!(error.to_string().contains("33 joints"), "{error}");
}

#[test]
fn every_format_says_every_robot() {
    for case in [mixed(), planar()] {
        for format in FORMATS {
            for form in [Form::Flexible, Form::Rigid] {
                let found = export(&request(&case, format, form)).unwrap();
                let Proof {
                    inverse_dynamics,
                    mass_matrix,
                    accelerations,
                    ..
                } = found.proof;
                // Rotors of SDF have a tiny mass.
                let limit = if format == Format::Sdf { 1e-9 } else { 1e-12 };
                assert!(
                    inverse_dynamics < limit && mass_matrix < limit,
                    "{:?}",
                    found.proof
                );
                assert!(accelerations < limit, "{format:?} {:?}", found.proof);
            }
        }
    }
}

/// Numbers of a file have all digits.
fn same(found: &[f64], of_file: &[f64]) {
    let bits = |all: &[f64]| all.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(found), bits(of_file), "{found:?} and {of_file:?}");
}

/// MuJoCo numbers bodies, joints and tendons in the order of the file.
#[test]
fn fields_of_mujoco_are_those_of_the_file() {
    for case in [mixed(), planar()] {
        for form in [Form::Flexible, Form::Rigid] {
            let request = request(&case, Format::Mjcf, form);
            let file = read_mjcf::read(&export(&request).unwrap().texts[0]).unwrap();
            let (names, fields) = mujoco(&request).unwrap();
            let joints: Vec<&String> = file.joints.iter().map(|joint| &joint.name).collect();
            assert_eq!(names.joints.iter().collect::<Vec<_>>(), joints);
            assert_eq!(names.bodies.len(), joints.len() + 1);
            assert_eq!(names.tendons.len(), file.springs.len());
            for (at, joint) in file.joints.iter().enumerate() {
                let body = [fields.body_mass[at + 1]];
                let found = [
                    fields.dof_armature[at],
                    fields.dof_damping[at],
                    fields.dof_frictionloss[at],
                ];
                let of_file = [joint.armature, joint.damping, joint.coulomb];
                same(&found, &of_file);
                same(&body, &[joint.mass]);
                same(&fields.body_ipos[at + 1], &joint.centre);
                let (axes, moments) = (fields.body_iquat[at + 1], fields.body_inertia[at + 1]);
                let r = rotation_of(axes);
                for (i, k) in (0..3).flat_map(|i| (0..3).map(move |k| (i, k))) {
                    let entry: f64 = (0..3).map(|l| r[i][l] * moments[l] * r[k][l]).sum();
                    assert!((entry - joint.inertia[i][k]).abs() < 1e-14 * moments[0]);
                }
            }
            for (at, spring) in file.springs.iter().enumerate() {
                let found = [fields.tendon_stiffness[at], fields.tendon_damping[at]];
                same(&found, &[spring.stiffness, spring.damping]);
            }
        }
    }
}

#[test]
fn a_drawn_robot_is_no_estimate() {
    let case = mixed();
    for format in FORMATS {
        let mut request = request(&case, format, Form::Flexible);
        let estimate = export(&request).unwrap();
        request.origin.draw = Some(DrawOrigin {
            robot: 17,
            count: 1000,
            seed: 5,
        });
        let draw = export(&request).unwrap();
        assert!(draw.proof.states < estimate.proof.states);
        let words = if format == Format::Json {
            "\"robot\": 17"
        } else {
            "draw: robot 17 of 1000 from the posterior, counted from 0, seed 5; not the estimate"
        };
        assert!(draw.texts[0].contains(words), "{}", draw.texts[0]);
        assert!(!estimate.texts[0].contains("draw"));
        assert_eq!(earlier(&draw.texts[0]), Earlier::Unchanged);
    }
}

#[test]
fn values_that_the_experiment_gives_need_no_other() {
    let assumed = "assume_zero = [\"link3.mz\"]\nfixed = { \"c.rotor_inertia\" = 0.05 }\ngravity";
    let mut case = mixed();
    case.experiment = read(
        "test",
        &MIXED.replacen("gravity", assumed, 1),
        &[],
        &mut no_files,
    )
    .unwrap();
    case.model = Model::new(&case.experiment).unwrap();
    for name in ["link3.mz", "c.rotor_inertia"] {
        case.values.remove(name);
    }
    let found = export(&request(&case, Format::Mjcf, Form::Flexible)).unwrap();
    assert!(
        found.texts[0].contains("armature=\"0.05\""),
        "{}",
        found.texts[0]
    );
}

#[test]
fn what_no_format_has_is_said() {
    let case = mixed();
    let of = |format: Format, what: &str| {
        let said = export(&request(&case, format, Form::Flexible))
            .unwrap()
            .said;
        let row = said.iter().find(|row| row.what == what);
        row.unwrap_or_else(|| panic!("{format:?} {what} {said:?}"))
            .how
    };
    for (format, what, how) in [
        (Format::Mjcf, "springs", How::Exact),
        (Format::Urdf, "springs", How::Dropped),
        (Format::Mjcf, "viscous friction", How::Exact),
        (Format::Sdf, "viscous friction", How::Approximated),
        (Format::Mjcf, "a.cubic_stiffness", How::Dropped),
        (Format::Json, "a.cubic_stiffness", How::Exact),
        (Format::Mjcf, "c.motor_stribeck", How::Dropped),
        (Format::Mjcf, "c.motor_viscous_positive", How::Approximated),
        (Format::Sdf, "gravity", How::Dropped),
    ] {
        assert_eq!(of(format, what), how, "{format:?} {what}");
    }
}

/// The proof must fail if any number of the model is wrong.
#[test]
fn a_wrong_number_is_seen() {
    let case = mixed();
    let identified = standard(&case.experiment, &case.model, &case.values).unwrap();
    for (format, changes) in [
        (
            Format::Urdf,
            &[
                ("damping=\"0.4\"", "damping=\"0.41\""),
                ("<stiffness>900<", "<stiffness>901<"),
                ("friction=\"1.5\"", "friction=\"1.4\""),
                ("mass value=\"4\"", "mass value=\"4.001\""),
                ("xyz=\"0.2 -0.1", "xyz=\"0.25 -0.1"),
                ("axis xyz=\"0 0 1\"", "axis xyz=\"0 0 -1\""),
                (
                    "rotor_inertia xmlns:drake=\"http://drake.mit.edu\" value=\"0.02\"",
                    "rotor_inertia xmlns:drake=\"http://drake.mit.edu\" value=\"0.03\"",
                ),
            ][..],
        ),
        (
            Format::Mjcf,
            &[
                ("gravity=\"1 ", "gravity=\"1.1 "),
                ("stiffness=\"9000\"", "stiffness=\"900\""),
                ("coef=\"-1\"", "coef=\"1\""),
                ("diaginertia=\"0.8 ", "diaginertia=\"0.8 0 "),
                ("armature=\"0.02\"", "armature=\"0\""),
                ("type=\"slide\"", "type=\"hinge\""),
                ("damping=\"30\"", "damping=\"31\""),
            ],
        ),
        (
            Format::Sdf,
            &[
                ("<spring_stiffness>900<", "<spring_stiffness>901<"),
                ("<drake:rotor_inertia>0.8<", "<drake:rotor_inertia>0.9<"),
                ("<damping>3.4<", "<damping>3<"),
                ("<mass>4<", "<mass>5<"),
                ("type=\"prismatic\"", "type=\"revolute\""),
            ],
        ),
        (
            Format::Json,
            &[
                ("\"is_flexible\": true", "\"is_flexible\": false"),
                ("\"value\": 900.0", "\"value\": 901.0"),
                ("\"mass_kg\": 4.0", "\"mass_kg\": 4.1"),
                ("\"parent\": \"a\"", "\"parent\": null"),
            ],
        ),
    ] {
        let request = request(&case, format, Form::Flexible);
        let text = export(&request).unwrap().texts.remove(0);
        assert!(prove(&request, &identified, &text).is_ok());
        for (from, to) in changes {
            assert!(text.contains(from), "{format:?} lacks {from}\n{text}");
            let wrong = text.replacen(from, to, 1);
            let error = prove(&request, &identified, &wrong);
            assert!(error.is_err(), "{format:?} {from} {to}: {error:?}");
        }
    }
}
