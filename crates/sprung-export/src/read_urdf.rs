//! Reads an exported URDF again. The tree comes from the reader of experiments, which is independent of the writer.

use roxmltree::{Document, Node};
use sprung_core::chain::JointKind;

use super::mechanism::{Mechanism, MechanismJoint, Spring};
use crate::description::Urdf;

/// Returns the mechanism of a URDF.
///
/// - `joints`: joints that move; the others are fixed. Joints of motors on the root link follow.
///
/// # Errors
///
/// The reason why the file cannot be read.
pub(super) fn read(text: &str, joints: &[String]) -> Result<Mechanism, String> {
    let urdf = Urdf::parse("the exported URDF", text).map_err(|error| error.to_string())?;
    let names: Vec<&str> = joints.iter().map(String::as_str).collect();
    let tree = urdf.tree(&names).map_err(|error| error.to_string())?;
    let document = Document::parse(text).map_err(|error| error.to_string())?;
    let root = document.root_element();
    let mut mechanism = Mechanism::default();
    for moving_link in tree {
        let body = (moving_link.inertial)
            .ok_or_else(|| format!("{} has no inertial", moving_link.link))?;
        let [m, x, y, z] = [body[0], body[1], body[2], body[3]];
        let squared = (x * x + y * y + z * z) / m;
        let h = [x, y, z];
        let about_origin = [
            [body[4], body[5], body[7]],
            [body[5], body[6], body[8]],
            [body[7], body[8], body[9]],
        ];
        let inertia = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let diagonal = if i == j { squared } else { 0.0 };
                about_origin[i][j] - diagonal + h[i] * h[j] / m
            })
        });
        let element = element(root, "joint", &moving_link.name)?;
        let dynamics = element
            .children()
            .find(|node| node.has_tag_name("dynamics"));
        let of = |key: &str| {
            let value = dynamics.and_then(|node| node.attribute(key));
            value.map_or(Ok(0.0), number)
        };
        mechanism.joints.push(MechanismJoint {
            parent: moving_link.joint.parent,
            rotation: moving_link.joint.rotation,
            origin: moving_link.joint.origin,
            axis: moving_link.joint.axis,
            slides: moving_link.joint.kind == JointKind::Prismatic,
            mass: m,
            centre: h.map(|x| x / m),
            inertia,
            armature: armature(root, &moving_link.name)?,
            damping: of("damping")?,
            coulomb: of("friction")?,
            name: moving_link.name,
        });
    }
    mechanism.springs = springs(root, &mechanism)?;
    Ok(mechanism)
}

fn element<'a, 'i>(root: Node<'a, 'i>, tag: &str, name: &str) -> Result<Node<'a, 'i>, String> {
    let mut found = root.children().filter(|node| node.has_tag_name(tag));
    found
        .find(|node| node.attribute("name") == Some(name))
        .ok_or_else(|| format!("it has no {tag} {name}"))
}

pub(super) fn number(text: &str) -> Result<f64, String> {
    let number = text.trim().parse();
    number.map_err(|_| format!("{text:?} is not a number"))
}

/// Returns the rotor inertia that Drake adds to a joint.
fn armature(root: Node<'_, '_>, joint: &str) -> Result<f64, String> {
    let transmissions = root
        .children()
        .filter(|node| node.has_tag_name("transmission"));
    let mut inertia = 0.0;
    for transmission in transmissions {
        let is_of = |node: Node<'_, '_>| {
            node.has_tag_name("joint") && node.attribute("name") == Some(joint)
        };
        if !transmission.children().any(is_of) {
            continue;
        }
        let of = |name: &str| {
            let node = transmission
                .descendants()
                .find(|node| node.tag_name().name() == name);
            node.and_then(|node| node.attribute("value")).map(number)
        };
        if let (Some(rotor), Some(ratio)) = (of("rotor_inertia"), of("gear_ratio")) {
            let ratio = ratio?;
            inertia += rotor? * ratio * ratio;
        }
    }
    Ok(inertia)
}

fn springs(root: Node<'_, '_>, mechanism: &Mechanism) -> Result<Vec<Spring>, String> {
    let mut springs = Vec::new();
    for transmission in root
        .children()
        .filter(|node| node.has_tag_name("transmission"))
    {
        let text = |name: &str| {
            let node = transmission.children().find(|node| node.has_tag_name(name));
            node.and_then(|node| node.text())
        };
        if text("type") != Some("sprung/Spring") {
            continue;
        }
        let joints = transmission
            .children()
            .filter(|node| node.has_tag_name("joint"));
        let signs = [1.0, -1.0];
        let coefficients = joints.zip(signs).map(|(node, sign)| {
            let name = node.attribute("name").unwrap_or_default();
            let at = mechanism.joint(name);
            Ok((at.ok_or_else(|| format!("it has no joint {name}"))?, sign))
        });
        springs.push(Spring {
            coefficients: coefficients.collect::<Result<_, String>>()?,
            stiffness: number(text("stiffness").unwrap_or_default())?,
            damping: number(text("damping").unwrap_or_default())?,
        });
    }
    Ok(springs)
}
