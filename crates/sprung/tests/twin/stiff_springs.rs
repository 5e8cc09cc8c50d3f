//! Springs that a log does not determine, with and without torque sensors.
//!
//! `cargo bench -p sprung --bench stiff` shows many logs.

use sprung_method::estimate::Verdict;
use sprung_model::Model;

use crate::stiff::{Twin, draw, stiffnesses};

/// Stiffnesses of the example, N·m/rad.
const USUAL: [f64; 7] = [17_800.0, 18_380.0, 13_380.0, 9476.0, 4288.0, 3914.0, 2392.0];

const CODE: &str = "stiffness-not-determined";

#[test]
fn stiff_springs_have_values_or_lower_bounds() {
    let draw = draw(5, 6.0, stiffnesses(5));
    let mut bounds = 0;
    for (joint, spring) in draw.springs.iter().enumerate() {
        match (spring.value, spring.above) {
            (Some(value), None) => {
                let ratio = value / spring.truth;
                assert!((0.3..3.0).contains(&ratio), "joint{}: {ratio}", joint + 1);
            }
            (None, Some(above)) => {
                println!(
                    "joint{}: {:.3e}, above {above:.3e}",
                    joint + 1,
                    spring.truth
                );
                assert!(above < spring.truth && above > spring.known / 5.0);
                bounds += 1;
            }
            other => panic!("joint{}: {other:?}", joint + 1),
        }
    }
    assert!(bounds > 0);
    let found = &draw.identification;
    assert!(found.findings.iter().any(|finding| finding.code == CODE));
    assert_ne!(found.results[0].verdict, Verdict::Unusable);
    // Equal up to the weights of the rows of springs.
    assert!((draw.squares[0] / draw.squares[1] - 1.0).abs() < 0.1);
}

#[test]
fn no_spring_at_all_leaves_the_rest() {
    let draw = draw(2, 3.0, [5e7; 7]);
    assert!(draw.springs.iter().all(|spring| spring.value.is_none()));
    assert!(
        draw.springs
            .iter()
            .all(|spring| spring.above.unwrap() < 5e7)
    );
    assert_ne!(draw.identification.results[0].verdict, Verdict::Unusable);
    assert!((draw.squares[0] / draw.squares[1] - 1.0).abs() < 0.1);
    // A simulation takes the springs at their bounds.
    let twin = Twin::new([5e7; 7], true);
    let sets = sprung_method::validate::ParameterSet::of(&draw.identification);
    let theta = twin.model.theta(&sets[0].values).unwrap();
    assert!(twin.model.check_stiffness(&theta).is_ok());
}

#[test]
fn without_torque_sensor_a_stiff_joint_becomes_rigid_with_one_friction() {
    let mut stiffness = USUAL;
    stiffness[1] = 3e7;
    let twin = Twin::new(stiffness, false);
    let found = twin.identify(&twin.log(1, 6.0));
    let result = &found.results[0];
    println!("{:?}\n{}", found.rigid_joints, result.decision.sentence);
    let rigid: Vec<&str> = found
        .rigid_joints
        .iter()
        .map(|joint| joint.joint.as_str())
        .collect();
    assert_eq!(rigid, ["joint2"]);
    let rigid = &found.rigid_joints[0];
    assert!(rigid.stiffness_above_nm_per_rad < 3e7 && rigid.stiffness_above_nm_per_rad > 1e5);
    let compared = rigid.hold_out.unwrap();
    assert!(compared.rigid.unwrap() < 0.05);
    assert!(found.findings.iter().any(|finding| finding.code == CODE));
    // One friction: the sums over link and motor.
    assert!(result.parameter("joint2.stiffness").is_none());
    assert!(result.parameter("joint2.link_viscous").is_none());
    let viscous = result.parameter("joint2.motor_viscous").unwrap();
    let both = ["link_viscous", "motor_viscous"].map(|name| twin.values[&format!("joint2.{name}")]);
    let ratio = viscous.value.unwrap() / both.iter().sum::<f64>();
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    for joint in [1, 3, 4, 5] {
        let name = format!("joint{joint}.stiffness");
        let ratio = result.parameter(&name).unwrap().value.unwrap() / stiffness[joint - 1];
        assert!((ratio - 1.0).abs() < 0.05, "{name}: {ratio}");
    }
    assert_ne!(result.verdict, Verdict::Unusable);
    // The description that validations use has the same parameters.
    let described =
        sprung_method::estimate::with_rigid_joints(&twin.experiment, &found.rigid_joints);
    let model = Model::new(&described).unwrap();
    let names = model.parameters().iter().map(|parameter| &parameter.name);
    assert!(names.eq(result.parameters.iter().map(|parameter| &parameter.name)));
}

#[test]
fn usual_springs_stay_flexible() {
    let twin = Twin::new(USUAL, false);
    let found = twin.identify(&twin.log(1, 4.0));
    assert!(found.rigid_joints.is_empty(), "{:?}", found.rigid_joints);
    assert!(found.findings.iter().all(|finding| finding.code != CODE));
    let sensors = draw(1, 4.0, USUAL);
    assert!(sensors.springs.iter().all(|spring| spring.above.is_none()));
}
