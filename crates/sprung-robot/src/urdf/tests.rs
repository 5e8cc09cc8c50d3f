//! Reading of correct files.

use sprung_core::chain::JointKind;

use super::{TreeJoint, Urdf, UrdfError};

/// Two revolute joints; the frame of the second link is rotated and shifted, and carries a fixed tool.
const ARM: &str = "<?xml version='1.0'?>
<robot name='arm'>
  <!-- The base is fixed to the world and off its origin. -->
  <link name='world'/>
  <joint name='mount' type='fixed'>
    <parent link='world'/><child link='base'/><origin xyz='0 0 1'/>
  </joint>
  <link name='base'>
    <inertial>
      <mass value='9'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>
    </inertial>
  </link>
  <joint name='shoulder' type='revolute'>
    <parent link='base'/><child link='upper'/>
    <origin xyz='0.1 0.2 0.3' rpy='0 0 1.5707963267948966'/>
    <axis xyz='0 0 2'/>
    <limit lower='-1.5' upper='2' effort='40' velocity='3'/>
  </joint>
  <link name='upper'>
    <visual><origin xyz='a b c'/></visual>
    <inertial>
      <origin xyz='0.5 0 0'/><mass value='2'/>
      <inertia ixx='0.01' ixy='0' ixz='0' iyy='0.02' iyz='0' izz='0.03'/>
    </inertial>
  </link>
  <joint name='elbow' type='continuous'>
    <parent link='upper'/><child link='fore'/><origin xyz='1 0 0'/>
    <limit lower='0' upper='0' effort='inf' velocity='1.7e308'/>
  </joint>
  <link name='fore'/>
  <joint name='flange' type='fixed'>
    <parent link='fore'/><child link='tool'/>
    <origin xyz='0 0.3 0' rpy='0 0 1.5707963267948966'/>
    <axis xyz='0 0 0'/>
  </joint>
  <link name='tool'>
    <inertial>
      <origin xyz='0.1 0 0'/><mass value='2'/>
      <inertia ixx='0' ixy='0' ixz='0' iyy='0' iyz='0' izz='0'/>
    </inertial>
  </link>
  <transmission name='t'><joint name='shoulder'/></transmission>
  <gazebo reference='upper'><anything/></gazebo>
</robot>
";

fn parse(text: &str) -> Urdf {
    Urdf::parse("arm.urdf", text).unwrap()
}

fn names(tree: &[TreeJoint]) -> Vec<&str> {
    tree.iter().map(|joint| joint.name.as_str()).collect()
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64]) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-14;
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(near),
        "{found:?} is not {expected:?}"
    );
}

#[test]
fn names_kinds_and_limits_of_an_arm_are_read() {
    let arm = parse(ARM);
    assert_eq!(arm.name(), "arm");
    let [shoulder, elbow] = arm.movable() else {
        panic!("{:?}", arm.movable());
    };
    assert_eq!(
        (shoulder.name.as_str(), shoulder.child.as_str()),
        ("shoulder", "upper")
    );
    assert_eq!(
        (shoulder.kind, shoulder.continuous),
        (JointKind::Revolute, false)
    );
    assert_eq!((shoulder.lower, shoulder.upper), (Some(-1.5), Some(2.0)));
    assert_eq!(
        (shoulder.effort, shoulder.velocity),
        (Some(40.0), Some(3.0))
    );
    assert!(elbow.continuous);
    // A continuous joint has no position limits; infinite limits count as absent.
    assert_eq!((elbow.lower, elbow.upper), (None, None));
    assert_eq!((elbow.effort, elbow.velocity), (None, None));
}

#[test]
fn frames_and_merged_bodies_are_those_of_a_hand_computation() {
    let tree = parse(ARM).tree(&["shoulder", "elbow"]).unwrap();
    let [shoulder, elbow] = &tree[..] else {
        panic!("{tree:?}");
    };
    // The mount lifts the base by one metre; the body of the base does not move.
    assert_eq!(shoulder.joint.parent, None);
    assert_close(&shoulder.joint.origin, &[0.1, 0.2, 1.3]);
    let quarter = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert_close(shoulder.joint.rotation.as_flattened(), &quarter);
    assert_close(&shoulder.joint.axis, &[0.0, 0.0, 1.0]);
    assert_eq!(
        (shoulder.link.as_str(), shoulder.limits.torque_nm),
        ("upper", Some(40.0))
    );
    // 2 kg at x = 0.5: 0.5 kg·m² about y and z.
    assert_close(
        &shoulder.inertial.unwrap(),
        &[2.0, 1.0, 0.0, 0.0, 0.01, 0.0, 0.52, 0.0, 0.0, 0.53],
    );
    assert_eq!(elbow.joint.parent, Some(0));
    assert_close(&elbow.joint.origin, &[1.0, 0.0, 0.0]);
    assert_close(&elbow.joint.axis, &[1.0, 0.0, 0.0]);
    // The tool's point mass is at y = 0.3 + 0.1 of the forearm's frame.
    assert_close(
        &elbow.inertial.unwrap(),
        &[2.0, 0.0, 0.8, 0.0, 0.32, 0.0, 0.0, 0.0, 0.0, 0.32],
    );
}

#[test]
fn joints_that_do_not_move_are_merged_at_zero() {
    let arm = parse(ARM);
    let tree = arm.tree(&["shoulder"]).unwrap();
    // 2 kg at x = 0.5 and 2 kg at (1, 0.4).
    assert_close(
        &tree[0].inertial.unwrap(),
        &[4.0, 3.0, 0.8, 0.0, 0.33, -0.8, 2.52, 0.0, 0.0, 2.85],
    );
    let tree = arm.tree(&["elbow"]).unwrap();
    assert_eq!((names(&tree), tree[0].joint.parent), (vec!["elbow"], None));
    // One metre along x of a frame that is rotated about z.
    assert_close(&tree[0].joint.origin, &[0.1, 1.2, 1.3]);
    assert_eq!(arm.tree(&[]), Ok(Vec::new()));
}

/// Returns a point after rotation by roll, pitch and yaw, one plane after the other, and a shift.
fn placed([x, y, z]: [f64; 3], [roll, pitch, yaw]: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let turned = |a: f64, b: f64, angle: f64| {
        (
            a * angle.cos() - b * angle.sin(),
            a * angle.sin() + b * angle.cos(),
        )
    };
    let (y, z) = turned(y, z, roll);
    let (z, x) = turned(z, x, pitch);
    let (x, y) = turned(x, y, yaw);
    [x + to[0], y + to[1], z + to[2]]
}

/// Returns the ten inertial parameters of point masses.
fn sums(points: &[(f64, [f64; 3])]) -> [f64; 10] {
    let mut sums = [0.0; 10];
    for (m, [x, y, z]) in points {
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let terms = [
            1.0,
            *x,
            *y,
            *z,
            yy + zz,
            -x * y,
            xx + zz,
            -x * z,
            -y * z,
            xx + yy,
        ];
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += m * term;
        }
    }
    sums
}

#[test]
fn a_body_of_point_masses_is_merged_through_all_rotations() {
    // Their centre of mass is the origin of the inertial frame.
    let points = [
        (0.5, [0.2, 0.0, 0.1]),
        (0.5, [-0.2, 0.4, -0.1]),
        (1.0, [0.1, -0.1, 0.3]),
        (2.0, [-0.05, -0.05, -0.15]),
    ];
    let at_center = sums(&points);
    assert_close(&at_center[1..4], &[0.0; 3]);
    let [mass, _, _, _, ixx, ixy, iyy, ixz, iyz, izz] = at_center;
    let text = format!(
        "<robot name='r'><link name='base'/><link name='arm'/><link name='tool'><inertial>
         <origin xyz='0.1 -0.2 0.3' rpy='0.4 -0.5 0.6'/><mass value='{mass}'/>
         <inertia ixx='{ixx}' ixy='{ixy}' ixz='{ixz}' iyy='{iyy}' iyz='{iyz}' izz='{izz}'/>
         </inertial></link>
         <joint name='turn' type='revolute'><parent link='base'/><child link='arm'/></joint>
         <joint name='tool' type='fixed'><parent link='arm'/><child link='tool'/>
         <origin xyz='-0.7 0.8 0.9' rpy='1.1 1.2 -1.3'/></joint></robot>"
    );
    let tree = parse(&text).tree(&["turn"]).unwrap();
    let points = points.map(|(m, point)| {
        let in_link = placed(point, [0.4, -0.5, 0.6], [0.1, -0.2, 0.3]);
        (m, placed(in_link, [1.1, 1.2, -1.3], [-0.7, 0.8, 0.9]))
    });
    assert_close(&tree[0].inertial.unwrap(), &sums(&points));
}

/// A hand with two fingers; its file lists children before parents.
const HAND: &str = "<robot name='hand' xmlns:xacro='http://ros.org/wiki/xacro' xmlns:g='urn:g'>
  <joint name='finger' type='prismatic'>
    <parent link='palm'/><child link='finger'/><axis xyz='0 3 4'/>
    <limit lower='0' upper='0.04' effort='20' velocity='0.1'/>
  </joint>
  <joint name='copy' type='prismatic'>
    <parent link='palm'/><child link='other'/><axis xyz='0 -1 0'/><mimic joint='finger'/>
  </joint>
  <joint name='slide' type='prismatic'><parent link='world'/><child link='cart'/></joint>
  <joint name='wrist' type='revolute'>
    <parent link='stand'/><child link='palm'/><axis xyz='1e-200 0 0'/>
  </joint>
  <joint name='stand' type='fixed'><parent link='world'/><child link='stand'/></joint>
  <g:joint name='not of this namespace'/>
  <link name='world'/> <link name='cart'/> <link name='palm'/> <link name='finger'/>
  <link name='stand'/>
  <link name='other'>
    <inertial>
      <mass value='1'/><inertia ixx='0' ixy='0' ixz='0' iyy='0' iyz='0' izz='0'/>
    </inertial>
  </link>
</robot>";

#[test]
fn branches_keep_the_order_of_the_file_after_their_parents() {
    let hand = parse(HAND);
    let movable: Vec<&str> = hand.movable().iter().map(|j| j.name.as_str()).collect();
    assert_eq!(movable, ["wrist", "finger", "slide"]);
    let tree = hand.tree(&["slide", "wrist", "finger"]).unwrap();
    let parents: Vec<_> = tree.iter().map(|j| j.joint.parent).collect();
    assert_eq!(parents, [None, None, Some(1)]);
    assert_eq!(tree[2].joint.kind, JointKind::Prismatic);
    assert_close(&tree[2].joint.axis, &[0.0, 0.6, 0.8]);
    assert_close(&tree[1].joint.axis, &[1.0, 0.0, 0.0]);
    // Only the mimicking finger has a body, held at zero on the palm.
    assert_eq!(tree[0].inertial, None);
    assert!(
        tree[1]
            .inertial
            .is_some_and(|palm| (palm[0] - 1.0).abs() < 1e-15)
    );
    assert_eq!(tree[2].inertial, None);
}

#[test]
fn no_text_makes_it_panic() {
    for text in [ARM, HAND] {
        for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)) {
            let cut = Urdf::parse("cut.urdf", &text[..end]);
            assert!(cut.is_err() || text[end..].trim().is_empty(), "{end}");
            // Without one byte the text may be valid or not.
            let without = [&text[..end], text.get(end + 1..).unwrap_or_default()].concat();
            if let Ok(robot) = Urdf::parse("cut.urdf", &without) {
                let all: Vec<&str> = robot.movable().iter().map(|j| j.name.as_str()).collect();
                assert!(robot.tree(&all).is_ok(), "{end}");
            }
        }
    }
}

#[test]
fn deep_and_long_files_are_read() {
    let deep = format!(
        "<robot name='r'>{}{}</robot>",
        "<a>".repeat(50_000),
        "</a>".repeat(50_000)
    );
    assert!(matches!(
        Urdf::parse("deep.urdf", &deep),
        Err(UrdfError::NoLink { line: 1, .. })
    ));
    // A long chain, listed from its tip to its base.
    let n = 4_000;
    let chain: Vec<String> = (1..=n)
        .rev()
        .map(|child| {
            let parent = child - 1;
            let moves = child == 1 || child % 20 == 0;
            let kind = if moves { "continuous" } else { "fixed" };
            format!(
                "<link name='l{child}'/><joint name='j{child}' type='{kind}'>
                 <parent link='l{parent}'/><child link='l{child}'/></joint>"
            )
        })
        .collect();
    let long = parse(&format!(
        "<robot name='r'><link name='l0'/>{}</robot>",
        chain.concat()
    ));
    assert_eq!(long.movable().len(), 1 + n / 20);
    let last = format!("j{n}");
    let tree = long.tree(&["j1", &last]).unwrap();
    assert_eq!(tree[1].joint.parent, Some(0));
    // A name beyond 200 bytes is compared with no other name.
    let endless = "j".repeat(1_000_000);
    assert!(long.tree(&[&endless]).is_err());
}
