//! URDF: the given file with other inertials, dynamics and transmissions, or a small one.

use std::fmt::Write;
use std::ops::Range;

use roxmltree::{Document, Node};
use sprung_core::chain::JointKind;
use sprung_core::spatial::BODY;

use super::error::ExportError;
use super::mjcf::rotor_body;
use super::names::{escaped, free};
use super::robot::{
    Form, Inertial, MOTOR, ROTOR, SPRING, StandardJoint, StandardRobot, level, number, numbers,
    roll_pitch_yaw,
};
use crate::description::Urdf;
use crate::model::is_possible;

/// Limits of a sliding joint whose limits are unknown; URDF has no sliding joint without limits.
const FAR_M: f64 = 1e3;
const STRONG_N: f64 = 1e6;
const FAST_M_PER_S: f64 = 1e3;

/// Least eigenvalue of the second moments of a link without the bodies that are fixed to it.
const LEAST_MOMENT: f64 = 1e-6;

/// Halvings of the bodies that are fixed to a link before they are removed.
const HALVINGS: i32 = 20;

/// Bodies of the moving links.
type Bodies = Vec<[f64; BODY]>;

/// Names of fixed links with factors of their bodies.
type Factors = Vec<(String, f64)>;

/// A changed URDF.
pub(super) struct Written {
    pub(super) text: String,
    /// Links whose bodies were reduced because the identified link is lighter: name and factor.
    pub(super) reduced: Factors,
    /// Files of meshes.
    pub(super) meshes: Vec<String>,
}

/// Returns a URDF with the links and joints of a robot, and no more.
pub(super) fn minimal(robot: &StandardRobot) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n  <link name=\"{}\"/>\n",
        escaped(&robot.name),
        escaped(&base(robot))
    );
    for joint in &robot.joints {
        let _ = writeln!(text, "  <link name=\"{}\"/>", escaped(&joint.link));
    }
    for joint in &robot.joints {
        let place = &joint.place;
        let parent = place
            .parent
            .map_or_else(|| base(robot), |parent| robot.joints[parent].link.clone());
        let (kind, limit) = match place.kind {
            JointKind::Revolute => ("continuous", String::new()),
            JointKind::Prismatic => ("prismatic", far_limit(joint)),
        };
        let _ = write!(
            text,
            "  <joint name=\"{}\" type=\"{kind}\">\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n    \
             <origin xyz=\"{}\" rpy=\"{}\"/>\n    <axis xyz=\"{}\"/>{limit}\n  </joint>\n",
            escaped(&joint.name),
            escaped(&parent),
            escaped(&joint.link),
            numbers(&place.origin),
            numbers(&roll_pitch_yaw(&place.rotation)),
            numbers(&place.axis),
        );
    }
    text.push_str("</robot>\n");
    text
}

/// Returns the limit of a sliding joint whose positions and velocities have none.
fn far_limit(joint: &StandardJoint) -> String {
    format!(
        "\n    <limit lower=\"-{FAR_M}\" upper=\"{FAR_M}\" effort=\"{}\" velocity=\"{FAST_M_PER_S}\"/>",
        joint.limits.effort.unwrap_or(STRONG_N)
    )
}

/// Returns a name of the base that no link has.
fn base(robot: &StandardRobot) -> String {
    let mut name = "base".to_owned();
    while robot.joints.iter().any(|joint| joint.link == name) {
        name.push('_');
    }
    name
}

/// Returns a URDF with the parameters of a robot. All but inertials, dynamics and transmissions of its joints is
/// unchanged, byte for byte.
///
/// - `file`, `text`: the URDF to change.
/// - `comment`: comment before the first element.
///
/// # Errors
///
/// [`ExportError`] if the URDF is wrong or has a name that the export adds.
pub(super) fn write(
    file: &str,
    text: &str,
    robot: &StandardRobot,
    form: Form,
    comment: &str,
) -> Result<Written, ExportError> {
    let urdf = Urdf::parse(file, text)?;
    let moving: Vec<&str> = robot
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    let (bodies, carried) = without_carried(robot, &urdf, &moving)?;
    // The text was parsed above.
    let Ok(document) = Document::parse(text) else {
        return Ok(Written {
            text: text.to_owned(),
            reduced: Vec::new(),
            meshes: Vec::new(),
        });
    };
    let root = document.root_element();
    check_free(root, robot, form)?;
    let mut edits = Edits {
        text,
        all: vec![(root.range().start..root.range().start, comment.to_owned())],
    };
    for link in named(root, "link") {
        let name = link.attribute("name").unwrap_or_default();
        if let Some(at) = robot.joints.iter().position(|joint| joint.link == name) {
            edits.replace(link, "inertial", &inertial(&Inertial::of(&bodies[at])));
        }
    }
    let mut reduced = Vec::new();
    for (name, factor) in carried {
        let link = named(root, "link").find(|link| link.attribute("name") == Some(name.as_str()));
        if let Some(body) = link.and_then(|link| child(link, "inertial")) {
            edits.all.extend(scaled(body, factor));
            reduced.push((name, factor));
        }
    }
    for element in named(root, "joint") {
        let name = element.attribute("name").unwrap_or_default();
        let Some(joint) = robot.joints.iter().find(|joint| joint.name == name) else {
            continue;
        };
        edits.replace(element, "dynamics", &dynamics(joint, form));
    }
    for element in named(root, "transmission") {
        let is_of = |node: Node<'_, '_>| {
            (node.attribute("name")).is_some_and(|name| moving.contains(&name))
        };
        if named(element, "joint").any(is_of) {
            edits.remove(element);
        }
    }
    let more = additions(root_link(root).unwrap_or_default(), robot, form);
    edits.before_end(root, &more);
    let meshes = root.descendants().filter(|node| node.has_tag_name("mesh"));
    Ok(Written {
        meshes: meshes
            .filter_map(|mesh| mesh.attribute("filename").map(str::to_owned))
            .collect(),
        text: edits.apply(),
        reduced,
    })
}

/// Returns the body of each moving link without the bodies that are fixed to it, and the factors of those that are
/// scaled down.
fn without_carried(
    robot: &StandardRobot,
    urdf: &Urdf,
    moving: &[&str],
) -> Result<(Bodies, Factors), ExportError> {
    let carried = urdf.carried(moving)?;
    let mut factors = Vec::new();
    let mut bodies = Vec::with_capacity(robot.joints.len());
    for (i, joint) in robot.joints.iter().enumerate() {
        let on_link = || carried.iter().filter(|body| body.carrier == i);
        let without = |factor: f64| {
            on_link().fold(joint.body, |body, other| {
                std::array::from_fn(|k| body[k] - factor * other.parameters[k])
            })
        };
        let factor = (0..HALVINGS)
            .map(|k| 0.5_f64.powi(k))
            .find(|factor| is_possible(&without(*factor), LEAST_MOMENT))
            .unwrap_or(0.0);
        if factor < 1.0 {
            factors.extend(on_link().map(|body| (body.link.clone(), factor)));
        }
        bodies.push(without(factor));
    }
    Ok((bodies, factors))
}

fn check_free(root: Node<'_, '_>, robot: &StandardRobot, form: Form) -> Result<(), ExportError> {
    let names = |tag| -> Vec<&str> {
        (named(root, tag))
            .filter_map(|node| node.attribute("name"))
            .collect()
    };
    let (links, joints) = (names("link"), names("joint"));
    for joint in robot.joints.iter().filter(|joint| joint.has_spring(form)) {
        free("link", &format!("{}{ROTOR}", joint.name), &links)?;
        free("joint", &format!("{}{MOTOR}", joint.name), &joints)?;
    }
    Ok(())
}

/// Returns the children with a tag.
fn named<'a, 'i: 'a>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children()
        .filter(move |child| child.tag_name().name() == tag)
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    named(node, tag).next()
}

/// Returns the link that no joint moves.
fn root_link<'a>(root: Node<'a, '_>) -> Option<&'a str> {
    let moved: Vec<&str> = (named(root, "joint"))
        .filter_map(|joint| child(joint, "child")?.attribute("link"))
        .collect();
    named(root, "link")
        .filter_map(|link| link.attribute("name"))
        .find(|name| !moved.contains(name))
}

fn inertial(body: &Inertial) -> String {
    let [ixx, ixy, iyy, ixz, iyz, izz] = body.inertia.map(number);
    format!(
        "<inertial>\n      <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n      <mass value=\"{}\"/>\n      \
         <inertia ixx=\"{ixx}\" ixy=\"{ixy}\" ixz=\"{ixz}\" iyy=\"{iyy}\" iyz=\"{iyz}\" izz=\"{izz}\"/>\n    \
         </inertial>",
        numbers(&body.centre),
        number(body.mass),
    )
}

fn dynamics(joint: &StandardJoint, form: Form) -> String {
    let friction = joint.friction(form);
    format!(
        "<dynamics damping=\"{}\" friction=\"{}\"/>",
        number(friction.viscous),
        number(friction.coulomb)
    )
}

/// Returns the edits that multiply the mass and the inertia of a body; those that remove it for zero.
fn scaled(body: Node<'_, '_>, factor: f64) -> Vec<(Range<usize>, String)> {
    if factor <= 0.0 {
        return vec![(body.range(), String::new())];
    }
    let attributes = ["mass", "inertia"]
        .into_iter()
        .filter_map(|tag| child(body, tag))
        .flat_map(|element| element.attributes().collect::<Vec<_>>());
    attributes
        .filter_map(|attribute| {
            let value: f64 = attribute.value().trim().parse().ok()?;
            Some((attribute.range_value(), number(factor * value)))
        })
        .collect()
}

/// Returns rotors and transmissions.
fn additions(root: &str, robot: &StandardRobot, form: Form) -> String {
    let mut text = String::new();
    for joint in &robot.joints {
        let name = escaped(&joint.name);
        let drive = &joint.drive;
        if joint.has_spring(form) {
            text.push_str(&rotor(root, joint, robot));
            text.push_str(&transmission(
                &format!("{name}{MOTOR}"),
                drive.gear_ratio,
                "",
            ));
            let _ = write!(
                text,
                "  <transmission name=\"{name}{SPRING}\">\n    <type>sprung/Spring</type>\n    \
                 <joint name=\"{name}{MOTOR}\"/>\n    <joint name=\"{name}\"/>\n    \
                 <stiffness>{}</stiffness>\n    <damping>{}</damping>\n  </transmission>\n",
                number(drive.stiffness),
                number(drive.damping)
            );
        } else {
            let inertia = format!(
                "\n      <drake:rotor_inertia xmlns:drake=\"http://drake.mit.edu\" value=\"{}\"/>\n      \
                 <drake:gear_ratio xmlns:drake=\"http://drake.mit.edu\" value=\"1\"/>",
                number(drive.rotor_inertia)
            );
            text.push_str(&transmission(&name, drive.gear_ratio, &inertia));
        }
    }
    text
}

/// Returns a rotor that moves on the root link.
fn rotor(root: &str, joint: &StandardJoint, robot: &StandardRobot) -> String {
    let (name, drive) = (escaped(&joint.name), &joint.drive);
    let (mass, inertia) = rotor_body(joint);
    let (kind, axis, limit) = match joint.place.kind {
        JointKind::Revolute => ("continuous", [0.0, 0.0, 1.0], String::new()),
        JointKind::Prismatic => ("prismatic", level(&robot.gravity), far_limit(joint)),
    };
    let body = Inertial {
        mass,
        centre: [0.0; 3],
        inertia: [inertia, 0.0, inertia, 0.0, 0.0, inertia],
    };
    format!(
        "  <link name=\"{name}{ROTOR}\">\n    {}\n  </link>\n  <joint name=\"{name}{MOTOR}\" type=\"{kind}\">\n    \
         <parent link=\"{}\"/>\n    <child link=\"{name}{ROTOR}\"/>\n    <axis xyz=\"{}\"/>{limit}\n    \
         <dynamics damping=\"{}\" friction=\"{}\"/>\n  </joint>\n",
        inertial(&body),
        escaped(root),
        numbers(&axis),
        number(drive.motor.viscous),
        number(drive.motor.coulomb)
    )
}

fn transmission(joint: &str, ratio: f64, more: &str) -> String {
    format!(
        "  <transmission name=\"{joint}_transmission\">\n    \
         <type>transmission_interface/SimpleTransmission</type>\n    <joint name=\"{joint}\">\n      \
         <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>\n    </joint>\n    \
         <actuator name=\"{joint}_actuator\">\n      <mechanicalReduction>{}</mechanicalReduction>{more}\n    \
         </actuator>\n  </transmission>\n",
        number(ratio)
    )
}

/// Edits of a text by ranges that do not overlap.
struct Edits<'a> {
    text: &'a str,
    all: Vec<(Range<usize>, String)>,
}

impl Edits<'_> {
    /// Replaces the children with a tag by one, or adds it.
    fn replace(&mut self, node: Node<'_, '_>, tag: &'static str, new: &str) {
        let mut found = named(node, tag);
        match found.next() {
            Some(first) => {
                self.all.push((first.range(), new.to_owned()));
                for other in found {
                    self.remove(other);
                }
            }
            None => self.before_end(node, &format!("  {new}\n  ")),
        }
    }

    /// Removes an element with the line break and the spaces before it.
    fn remove(&mut self, node: Node<'_, '_>) {
        let Range { start, end } = node.range();
        let before = self.text[..start].trim_end_matches([' ', '\t']);
        let start = if before.ends_with('\n') {
            before.trim_end_matches('\n').trim_end_matches('\r').len()
        } else {
            start
        };
        self.all.push((start..end, String::new()));
    }

    /// Inserts text before the end of an element.
    fn before_end(&mut self, node: Node<'_, '_>, new: &str) {
        let Range { start, end } = node.range();
        let text = &self.text[start..end];
        if let Some(open) = text.strip_suffix("/>").filter(|_| !node.has_children()) {
            let name = open[1..].split(|c: char| c.is_whitespace()).next();
            let at = start + open.trim_end().len();
            let close = format!(">\n  {new}</{}>", name.unwrap_or_default());
            self.all.push((at..end, close));
        } else if let Some(close) = text.rfind("</") {
            self.all
                .push((start + close..start + close, new.to_owned()));
        }
    }

    fn apply(mut self) -> String {
        // Insertions at one place keep their order.
        self.all.sort_by_key(|(range, _)| range.start);
        let mut text = String::with_capacity(2 * self.text.len());
        let mut done = 0;
        for (range, new) in &self.all {
            text.push_str(&self.text[done..range.start]);
            text.push_str(new);
            done = range.end;
        }
        text.push_str(&self.text[done..]);
        text
    }
}
