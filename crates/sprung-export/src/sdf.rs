//! SDF, the format of Gazebo, with the rotor inertias of Drake.
//!
//! A flexible joint is a chain: the motor's joint carries a rotor without mass, and a joint with a spring
//! carries the link. The rotor's inertia belongs to the coordinate of the motor only, so there is no
//! gyroscopic coupling, as in the identified model.

use std::fmt::Write;

use sprung_core::chain::JointKind;

use super::names::escaped;
use super::robot::{
    Form, Friction, Inertial, MOTOR, ROTOR, SPRING, StandardJoint, StandardRobot, number, numbers,
    quaternion,
};

/// Body of a rotor: so light that it has no effect, because SDF demands a body.
const LIGHT: Inertial = Inertial {
    mass: 1e-12,
    centre: [0.0; 3],
    inertia: [1e-15, 0.0, 1e-15, 0.0, 0.0, 1e-15],
};

/// Returns the file of a robot.
pub(super) fn write(robot: &StandardRobot, form: Form, comment: &str) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n{comment}<sdf version=\"1.9\">\n  \
         <model name=\"{}\" xmlns:drake=\"http://drake.mit.edu\">\n",
        escaped(&robot.name)
    );
    for joint in &robot.joints {
        let parent = joint.place.parent.map(|at| robot.joints[at].link.as_str());
        let [w, x, y, z] = quaternion(&joint.place.rotation);
        let frame = parent.map_or_else(|| "__model__".to_owned(), escaped);
        let pose = format!(
            "<pose relative_to=\"{frame}\" rotation_format=\"quat_xyzw\">{} {}</pose>",
            numbers(&joint.place.origin),
            numbers(&[x, y, z, w])
        );
        let from = parent.map_or_else(|| "world".to_owned(), escaped);
        let (name, link_name) = (escaped(&joint.name), escaped(&joint.link));
        if joint.has_spring(form) {
            let rotor = format!("{name}{ROTOR}");
            link(&mut text, &rotor, &pose, &LIGHT);
            let here = format!("<pose relative_to=\"{rotor}\"/>");
            link(&mut text, &link_name, &here, &joint.inertial());
            let friction = Friction {
                viscous: joint.drive.motor.viscous + joint.drive.link.viscous,
                coulomb: joint.drive.motor.coulomb + joint.drive.link.coulomb,
            };
            motor(
                &mut text,
                joint,
                &[&format!("{name}{MOTOR}"), &from, &rotor],
                friction,
            );
            let _ = write!(
                text,
                "    <joint name=\"{name}{SPRING}\" type=\"{}\">\n      <parent>{rotor}</parent>\n      \
                 <child>{link_name}</child>\n      <axis>\n        <xyz>{}</xyz>\n        \
                 <limit>\n          <effort>0</effort>\n        </limit>\n        <dynamics>\n          \
                 <damping>{}</damping>\n          <friction>0</friction>\n          \
                 <spring_reference>0</spring_reference>\n          \
                 <spring_stiffness>{}</spring_stiffness>\n        </dynamics>\n      </axis>\n    </joint>\n",
                kind(joint),
                numbers(&joint.place.axis),
                number(joint.drive.damping),
                number(joint.drive.stiffness)
            );
        } else {
            link(&mut text, &link_name, &pose, &joint.inertial());
            motor(
                &mut text,
                joint,
                &[&name, &from, &link_name],
                joint.friction(form),
            );
        }
    }
    text.push_str("  </model>\n</sdf>\n");
    text
}

fn link(text: &mut String, name: &str, pose: &str, body: &Inertial) {
    let [ixx, ixy, iyy, ixz, iyz, izz] = body.inertia.map(number);
    let _ = write!(
        text,
        "    <link name=\"{name}\">\n      {pose}\n      <inertial>\n        <pose>{} 0 0 0</pose>\n        \
         <mass>{}</mass>\n        <inertia>\n          <ixx>{ixx}</ixx>\n          <ixy>{ixy}</ixy>\n          \
         <ixz>{ixz}</ixz>\n          <iyy>{iyy}</iyy>\n          <iyz>{iyz}</iyz>\n          \
         <izz>{izz}</izz>\n        </inertia>\n      </inertial>\n    </link>\n",
        numbers(&body.centre),
        number(body.mass)
    );
}

/// Writes a joint with an actuator.
///
/// - `names`: joint, parent, child.
fn motor(text: &mut String, joint: &StandardJoint, names: &[&str; 3], friction: Friction) {
    let [name, parent, child] = names;
    let limits = &joint.limits;
    let mut limit = String::new();
    for (key, value) in [
        ("lower", limits.lower),
        ("upper", limits.upper),
        ("effort", limits.effort),
        ("velocity", limits.velocity),
    ] {
        if let Some(value) = value {
            let _ = writeln!(limit, "          <{key}>{}</{key}>", number(value));
        }
    }
    let _ = write!(
        text,
        "    <joint name=\"{name}\" type=\"{}\">\n      <parent>{parent}</parent>\n      <child>{child}</child>\n      \
         <axis>\n        <xyz>{}</xyz>\n        <limit>\n{limit}        </limit>\n        <dynamics>\n          \
         <damping>{}</damping>\n          <friction>{}</friction>\n        </dynamics>\n      </axis>\n      \
         <drake:rotor_inertia>{}</drake:rotor_inertia>\n      <drake:gear_ratio>1</drake:gear_ratio>\n    \
         </joint>\n",
        kind(joint),
        numbers(&joint.place.axis),
        number(friction.viscous),
        number(friction.coulomb),
        number(joint.drive.rotor_inertia)
    );
}

fn kind(joint: &StandardJoint) -> &'static str {
    match joint.place.kind {
        JointKind::Revolute => "revolute",
        JointKind::Prismatic => "prismatic",
    }
}
