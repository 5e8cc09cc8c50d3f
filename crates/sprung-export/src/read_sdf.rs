//! Reads an exported SDF again: links, joints, springs and the rotor inertias of Drake.

use roxmltree::{Document, Node};

use super::mechanism::{Mechanism, MechanismJoint, Spring, rotation_of};
use super::read_mjcf::{child, unit, words};
use super::read_urdf::number;

/// Returns the mechanism of an SDF. The frame of a joint is that of its child.
///
/// # Errors
///
/// The reason why the file cannot be read.
pub(super) fn read(text: &str) -> Result<Mechanism, String> {
    let document = Document::parse(text).map_err(|error| error.to_string())?;
    let model = child(document.root_element(), "model").ok_or("it has no model")?;
    let mut mechanism = Mechanism::default();
    let mut links: Vec<String> = Vec::new();
    for joint in model.children().filter(|node| node.has_tag_name("joint")) {
        let name = joint.attribute("name").unwrap_or_default().to_owned();
        let parent = match text_of(joint, "parent")? {
            "world" => None,
            parent => {
                let at = links.iter().position(|link| link == parent);
                Some(at.ok_or_else(|| format!("{name} comes before its parent"))?)
            }
        };
        let carried = text_of(joint, "child")?;
        let mut all = model.children().filter(|node| node.has_tag_name("link"));
        let link = all.find(|node| node.attribute("name") == Some(carried));
        let link = link.ok_or_else(|| format!("there is no link {carried}"))?;
        let axis = child(joint, "axis").ok_or("a joint has no axis")?;
        let dynamics = child(axis, "dynamics").ok_or("a joint has no dynamics")?;
        let optional = |key: &str| match child(dynamics, key) {
            Some(node) => number(node.text().unwrap_or_default()),
            None => Ok(0.0),
        };
        let index = mechanism.joints.len();
        if optional("spring_stiffness")? != 0.0 {
            mechanism.springs.push(Spring {
                coefficients: vec![(index, 1.0)],
                stiffness: optional("spring_stiffness")?,
                damping: 0.0,
            });
        }
        if optional("spring_reference")? != 0.0 {
            return Err(format!("the spring {name} is stretched at position zero"));
        }
        let mut read = body(link, parent.map(|at| links[at].as_str()))?;
        read.name = name;
        read.parent = parent;
        read.axis = unit(words(text_of(axis, "xyz")?)?);
        read.slides = joint.attribute("type") == Some("prismatic");
        read.armature = rotor(joint)?;
        read.damping = optional("damping")?;
        read.coulomb = optional("friction")?;
        mechanism.joints.push(read);
        links.push(carried.to_owned());
    }
    Ok(mechanism)
}

/// Returns the rotor inertia after the gear.
fn rotor(joint: Node<'_, '_>) -> Result<f64, String> {
    let of = |name: &str| {
        let node = joint.children().find(|node| node.tag_name().name() == name);
        node.and_then(|node| node.text()).map(number)
    };
    match (of("rotor_inertia"), of("gear_ratio")) {
        (Some(inertia), Some(ratio)) => {
            let ratio = ratio?;
            Ok(inertia? * ratio * ratio)
        }
        _ => Ok(0.0),
    }
}

fn body(link: Node<'_, '_>, parent: Option<&str>) -> Result<MechanismJoint, String> {
    let pose = child(link, "pose").ok_or("a link has no pose")?;
    if pose.attribute("relative_to") != Some(parent.unwrap_or("__model__")) {
        return Err("the pose of a link is not relative to its parent".to_owned());
    }
    let [px, py, pz, x, y, z, w] = match pose.text() {
        Some(text) => words(text)?,
        None => [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    };
    let inertial = child(link, "inertial").ok_or("a link has no inertial")?;
    let [cx, cy, cz, roll, pitch, yaw] = words(text_of(inertial, "pose")?)?;
    if [roll, pitch, yaw].iter().any(|angle| *angle != 0.0) {
        return Err("an inertial is turned".to_owned());
    }
    let inertia = child(inertial, "inertia").ok_or("a link has no inertia")?;
    let of = |key: &str| number(text_of(inertia, key)?);
    let [xy, xz, yz] = [of("ixy")?, of("ixz")?, of("iyz")?];
    Ok(MechanismJoint {
        rotation: rotation_of([w, x, y, z]),
        origin: [px, py, pz],
        mass: number(text_of(inertial, "mass")?)?,
        centre: [cx, cy, cz],
        inertia: [
            [of("ixx")?, xy, xz],
            [xy, of("iyy")?, yz],
            [xz, yz, of("izz")?],
        ],
        ..MechanismJoint::default()
    })
}

fn text_of<'a>(node: Node<'a, '_>, tag: &str) -> Result<&'a str, String> {
    let text = child(node, tag).and_then(|node| node.text());
    text.ok_or_else(|| format!("a <{}> has no {tag}", node.tag_name().name()))
}
