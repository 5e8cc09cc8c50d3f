//! MJCF, the format of MuJoCo.
//!
//! The rotor of a flexible joint is a body beside the base, whose hinge has the coordinate of the motor. A
//! fixed tendon from this hinge to that of the link is the spring. These are the equations of the
//! identified model, without the gyroscopic coupling that a rotor on a moving link would have.

use std::fmt::Write;

use sprung_core::chain::JointKind;

use super::names::escaped;
use super::robot::{
    Form, Friction, MOTOR, ROTOR, SPRING, StandardJoint, StandardRobot, level, number, numbers,
    quaternion,
};

/// Mass of a rotor that turns. The mass of the real rotor is a part of its link.
const ROTOR_MASS: f64 = 1e-3;

/// Inertia of a rotor that slides, over its mass.
const SLIDING_INERTIA: f64 = 0.01;

/// Returns the file of a robot.
pub(super) fn write(robot: &StandardRobot, form: Form, comment: &str) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n{comment}<mujoco model=\"{}\">\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n  \
         <option gravity=\"{}\" integrator=\"implicitfast\"/>\n  <worldbody>\n",
        escaped(&robot.name),
        numbers(&robot.gravity)
    );
    for (i, joint) in robot.joints.iter().enumerate() {
        if joint.place.parent.is_none() {
            link(&mut text, robot, form, i, 2);
        }
    }
    for joint in robot.joints.iter().filter(|joint| joint.has_spring(form)) {
        rotor(&mut text, joint, robot);
    }
    text.push_str("  </worldbody>\n");
    if robot.joints.iter().any(|joint| joint.has_spring(form)) {
        text.push_str("  <tendon>\n");
        for joint in robot.joints.iter().filter(|joint| joint.has_spring(form)) {
            let name = escaped(&joint.name);
            let _ = write!(
                text,
                "    <fixed name=\"{name}{SPRING}\" stiffness=\"{}\" damping=\"{}\" springlength=\"0\">\n      \
                 <joint joint=\"{name}{MOTOR}\" coef=\"1\"/>\n      <joint joint=\"{name}\" coef=\"-1\"/>\n    \
                 </fixed>\n",
                number(joint.drive.stiffness),
                number(joint.drive.damping)
            );
        }
        text.push_str("  </tendon>\n");
    }
    text.push_str("  <actuator>\n");
    for joint in &robot.joints {
        let name = escaped(&joint.name);
        let motor = if joint.has_spring(form) { MOTOR } else { "" };
        let limit = joint.limits.effort.map_or_else(String::new, |effort| {
            let effort = number(effort);
            format!(" ctrlrange=\"-{effort} {effort}\"")
        });
        let _ = writeln!(
            text,
            "    <motor name=\"{name}\" joint=\"{name}{motor}\" gear=\"1\"{limit}/>"
        );
    }
    text.push_str("  </actuator>\n</mujoco>\n");
    text
}

/// Writes a link with the links that it carries.
fn link(text: &mut String, robot: &StandardRobot, form: Form, at: usize, depth: usize) {
    let joint = &robot.joints[at];
    let (indent, body) = ("  ".repeat(depth), joint.inertial());
    let [ixx, ixy, iyy, ixz, iyz, izz] = body.inertia;
    let range = match (joint.limits.lower, joint.limits.upper) {
        (Some(lower), Some(upper)) if lower < upper => {
            format!(" range=\"{} {}\"", number(lower), number(upper))
        }
        _ => String::new(),
    };
    let _ = write!(
        text,
        "{indent}<body name=\"{}\" pos=\"{}\" quat=\"{}\">\n{indent}  <inertial pos=\"{}\" mass=\"{}\" \
         fullinertia=\"{}\"/>\n{indent}  <joint name=\"{}\" type=\"{}\" axis=\"{}\" armature=\"{}\"{}{range}/>\n",
        escaped(&joint.link),
        numbers(&joint.place.origin),
        numbers(&quaternion(&joint.place.rotation)),
        numbers(&body.centre),
        number(body.mass),
        numbers(&[ixx, iyy, izz, ixy, ixz, iyz]),
        escaped(&joint.name),
        kind(joint),
        numbers(&joint.place.axis),
        number(armature(joint, form)),
        friction(joint.friction(form)),
    );
    for (i, other) in robot.joints.iter().enumerate() {
        if other.place.parent == Some(at) {
            link(text, robot, form, i, depth + 1);
        }
    }
    let _ = writeln!(text, "{indent}</body>");
}

/// Returns the mass of a rotor's body, and its inertia about any axis.
pub(super) fn rotor_body(joint: &StandardJoint) -> (f64, f64) {
    let size = joint.drive.rotor_inertia;
    match joint.place.kind {
        JointKind::Revolute => (ROTOR_MASS, size),
        JointKind::Prismatic => (size, SLIDING_INERTIA * size),
    }
}

/// Returns the rotor inertia that acts on the coordinate of the link.
pub(super) fn armature(joint: &StandardJoint, form: Form) -> f64 {
    if joint.has_spring(form) {
        0.0
    } else {
        joint.drive.rotor_inertia
    }
}

/// Returns the joints in the order in which their links are written.
pub(super) fn order(robot: &StandardRobot) -> Vec<usize> {
    fn add(order: &mut Vec<usize>, robot: &StandardRobot, parent: Option<usize>) {
        for (i, joint) in robot.joints.iter().enumerate() {
            if joint.place.parent == parent {
                order.push(i);
                add(order, robot, Some(i));
            }
        }
    }
    let mut order = Vec::with_capacity(robot.joints.len());
    add(&mut order, robot, None);
    order
}

fn rotor(text: &mut String, joint: &StandardJoint, robot: &StandardRobot) {
    let name = escaped(&joint.name);
    let axis = match joint.place.kind {
        JointKind::Revolute => [0.0, 0.0, 1.0],
        JointKind::Prismatic => level(&robot.gravity),
    };
    let (mass, inertia) = rotor_body(joint);
    let inertia = number(inertia);
    let _ = write!(
        text,
        "    <body name=\"{name}{ROTOR}\">\n      <inertial pos=\"0 0 0\" mass=\"{}\" \
         diaginertia=\"{inertia} {inertia} {inertia}\"/>\n      <joint name=\"{name}{MOTOR}\" type=\"{}\" \
         axis=\"{}\"{}/>\n    </body>\n",
        number(mass),
        kind(joint),
        numbers(&axis),
        friction(joint.drive.motor),
    );
}

fn kind(joint: &StandardJoint) -> &'static str {
    match joint.place.kind {
        JointKind::Revolute => "hinge",
        JointKind::Prismatic => "slide",
    }
}

fn friction(friction: Friction) -> String {
    format!(
        " damping=\"{}\" frictionloss=\"{}\"",
        number(friction.viscous),
        number(friction.coulomb)
    )
}
