//! Reads an exported MJCF again: bodies, hinges, slides and fixed tendons.

use roxmltree::{Document, Node};

use super::mechanism::{Mechanism, MechanismJoint, Spring, rotation_of};

/// Returns the mechanism of an MJCF.
///
/// # Errors
///
/// The reason why the file cannot be read.
pub(super) fn read(text: &str) -> Result<Mechanism, String> {
    let document = Document::parse(text).map_err(|error| error.to_string())?;
    let root = document.root_element();
    let mut mechanism = Mechanism::default();
    if let Some(option) = child(root, "option") {
        mechanism.gravity = Some(several(option, "gravity")?);
    }
    let world = child(root, "worldbody").ok_or("it has no worldbody")?;
    bodies(world, None, &mut mechanism)?;
    let tendons = child(root, "tendon")
        .into_iter()
        .flat_map(|element| element.children());
    for tendon in tendons.filter(|node| node.has_tag_name("fixed")) {
        let joints = tendon.children().filter(|node| node.has_tag_name("joint"));
        let coefficients = joints.map(|node| {
            let name = node.attribute("joint").unwrap_or_default();
            let at = mechanism.joint(name);
            let at = at.ok_or_else(|| format!("it has no joint {name}"))?;
            Ok((at, one(node, "coef")?))
        });
        let coefficients = coefficients.collect::<Result<_, String>>()?;
        let [rest] = several::<1>(tendon, "springlength")?;
        if rest != 0.0 {
            return Err(format!("a spring is stretched by {rest}"));
        }
        mechanism.springs.push(Spring {
            coefficients,
            stiffness: one(tendon, "stiffness")?,
            damping: one(tendon, "damping")?,
        });
    }
    for actuator in child(root, "actuator")
        .into_iter()
        .flat_map(|element| element.children())
    {
        let joint = actuator.attribute("joint");
        if joint.is_some_and(|joint| mechanism.joint(joint).is_none()) {
            return Err("an actuator drives no joint".to_owned());
        }
    }
    Ok(mechanism)
}

fn bodies(
    node: Node<'_, '_>,
    parent: Option<usize>,
    mechanism: &mut Mechanism,
) -> Result<(), String> {
    for body in node.children().filter(|node| node.has_tag_name("body")) {
        let joint = child(body, "joint").ok_or("a body has no joint")?;
        let inertial = child(body, "inertial").ok_or("a body has no inertial")?;
        let inertia = if inertial.has_attribute("fullinertia") {
            let [xx, yy, zz, xy, xz, yz] = several(inertial, "fullinertia")?;
            [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
        } else {
            let [x, y, z] = several(inertial, "diaginertia")?;
            [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]
        };
        let turn = if body.has_attribute("quat") {
            several(body, "quat")?
        } else {
            [1.0, 0.0, 0.0, 0.0]
        };
        let origin = if body.has_attribute("pos") {
            several(body, "pos")?
        } else {
            [0.0; 3]
        };
        let index = mechanism.joints.len();
        mechanism.joints.push(MechanismJoint {
            name: joint.attribute("name").unwrap_or_default().to_owned(),
            parent,
            rotation: rotation_of(turn),
            origin,
            axis: unit(several(joint, "axis")?),
            slides: joint.attribute("type") == Some("slide"),
            mass: one(inertial, "mass")?,
            centre: several(inertial, "pos")?,
            inertia,
            armature: if joint.has_attribute("armature") {
                one(joint, "armature")?
            } else {
                0.0
            },
            damping: one(joint, "damping")?,
            coulomb: one(joint, "frictionloss")?,
        });
        bodies(body, Some(index), mechanism)?;
    }
    Ok(())
}

pub(super) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|node| node.has_tag_name(tag))
}

pub(super) fn unit(axis: [f64; 3]) -> [f64; 3] {
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    axis.map(|x| x / length)
}

fn one(node: Node<'_, '_>, key: &str) -> Result<f64, String> {
    let [value] = several(node, key)?;
    Ok(value)
}

fn several<const N: usize>(node: Node<'_, '_>, key: &str) -> Result<[f64; N], String> {
    let text = node.attribute(key);
    let text = text.ok_or_else(|| format!("a <{}> has no {key}", node.tag_name().name()))?;
    words(text)
}

/// Returns the numbers of a text.
pub(super) fn words<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let wrong = || format!("{text:?} is not {N} numbers");
    let numbers: Option<Vec<f64>> = (text.split_whitespace())
        .map(|word| word.parse().ok())
        .collect();
    (numbers.ok_or_else(wrong)?.try_into()).map_err(|_| wrong())
}
