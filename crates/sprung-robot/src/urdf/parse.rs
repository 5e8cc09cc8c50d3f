//! Turns the text of a file into a checked tree of links and joints.

use std::collections::HashMap;

use sprung_core::chain::JointKind;

use super::body::Body;
use super::error::{UrdfError, near};
use super::geometry::{geometries, placement};
use super::robot::{Freedom, Joint, Limits, Link, Mobility, Urdf, UrdfJoint};
use super::xml::{Element, Source};
use crate::input_limits::{LINKS, URDF_BYTES, URDF_JOINTS, size};

impl Urdf {
    /// Reads a robot description.
    ///
    /// - `file`: name for messages.
    /// - `text`: contents of the file, with xacro macros expanded.
    ///
    /// # Errors
    ///
    /// [`UrdfError`] with the line if the text is not XML, is not one tree of revolute, continuous,
    /// prismatic and fixed joints, or contains an invalid number.
    pub fn parse(file: &str, text: &str) -> Result<Self, UrdfError> {
        parse(file, text)
    }
}

fn parse(file: &str, text: &str) -> Result<Urdf, UrdfError> {
    if text.len() > URDF_BYTES {
        return Err(UrdfError::TooLarge {
            file: file.to_owned(),
            found: format!("{} bytes", text.len()),
            most: size(URDF_BYTES),
        });
    }
    let source = Source::new(file, text);
    let document = source.document()?;
    let robot = Element::root(&document, &source);
    if robot.tag() != "robot" {
        return Err(UrdfError::Root {
            file: robot.file(),
            line: robot.line(),
            found: robot.tag().to_owned(),
        });
    }
    robot.refuse_xacro()?;
    let mut links = read_links(&robot)?;
    links.extend(implicit_world(&robot, &links)?);
    let joints = read_joints((&robot, &source), &links)?;
    let joints = parents_first(file, &links, joints)?;
    one_root(file, &links, &joints)?;
    let movable = movable(&joints, &links);
    if movable.len() > URDF_JOINTS {
        return Err(UrdfError::TooLarge {
            file: robot.file(),
            found: format!("{} movable joints", movable.len()),
            most: format!("{URDF_JOINTS} movable joints"),
        });
    }
    if movable.is_empty() {
        return Err(UrdfError::NothingMoves {
            file: robot.file(),
            line: robot.line(),
        });
    }
    let mut notes = source.notes();
    notes.extend(about_bodies(&links, &joints));
    Ok(Urdf {
        notes,
        file: robot.file(),
        name: robot.needed("name")?.to_owned(),
        links,
        joints,
        movable,
    })
}

fn read_links(robot: &Element<'_, '_>) -> Result<Vec<Link>, UrdfError> {
    let mut lines = HashMap::new();
    let mut links = Vec::new();
    let count = robot.children("link").count();
    if count > LINKS {
        return Err(UrdfError::TooLarge {
            file: robot.file(),
            found: format!("{count} links"),
            most: format!("{LINKS} links"),
        });
    }
    for mut element in robot.children("link") {
        let (name, line) = (element.needed("name")?, element.line());
        new_name("link", name, &element, &mut lines)?;
        element.called = format!("link \"{name}\"");
        let inertial = element.child("inertial")?;
        links.push(Link {
            name: name.to_owned(),
            line,
            body: inertial.map(|inertial| body(name, &inertial)).transpose()?,
            geometry: geometries(&element),
        });
    }
    if links.is_empty() {
        return Err(UrdfError::NoLink {
            file: robot.file(),
            line: robot.line(),
        });
    }
    Ok(links)
}

/// Stores the line of a name.
///
/// # Errors
///
/// [`UrdfError::SameName`] if the name is not new.
fn new_name<'a>(
    what: &'static str,
    name: &'a str,
    element: &Element<'_, '_>,
    lines: &mut HashMap<&'a str, usize>,
) -> Result<(), UrdfError> {
    match lines.insert(name, element.line()) {
        None => Ok(()),
        Some(first) => Err(UrdfError::SameName {
            file: element.file(),
            line: element.line(),
            what,
            name: name.to_owned(),
            first,
        }),
    }
}

fn body(link: &str, inertial: &Element<'_, '_>) -> Result<Body, UrdfError> {
    let mass = inertial.needed_child("mass", "<mass value=\"1.5\"/>")?;
    let kilograms = mass.number("value")?;
    if kilograms < 0.0 {
        return Err(UrdfError::NegativeMass {
            file: mass.file(),
            line: mass.line(),
            link: link.to_owned(),
            mass: kilograms,
        });
    }
    let inertia = inertial.needed_child(
        "inertia",
        "<inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/>",
    )?;
    let [ixx, ixy, ixz] = [
        inertia.number("ixx")?,
        inertia.number("ixy")?,
        inertia.number("ixz")?,
    ];
    let [iyy, iyz, izz] = [
        inertia.number("iyy")?,
        inertia.number("iyz")?,
        inertia.number("izz")?,
    ];
    Ok(Body {
        mass: kilograms,
        placement: placement(inertial)?,
        inertia: [[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]],
    })
}

/// Returns the link `world`, which Drake adds to a file whose joints name it and that does not describe it.
fn implicit_world(robot: &Element<'_, '_>, links: &[Link]) -> Result<Option<Link>, UrdfError> {
    const WORLD: &str = "world";
    if links.iter().any(|link| link.name == WORLD) {
        return Ok(None);
    }
    for joint in robot.children("joint") {
        if let Some(parent) = joint.child("parent")?
            && parent.attribute("link")? == Some(WORLD)
        {
            return Ok(Some(Link {
                name: WORLD.to_owned(),
                line: parent.line(),
                body: None,
                geometry: Vec::new(),
            }));
        }
    }
    Ok(None)
}

/// Returns whether a joint carries the whole robot: no other joint moves its parent.
fn carries_root(robot: &Element<'_, '_>, joint: &Element<'_, '_>) -> Result<bool, UrdfError> {
    let link = |joint: &Element<'_, '_>, role| match joint.child(role)? {
        Some(end) => Ok(end.attribute("link")?.map(str::to_owned)),
        None => Ok(None),
    };
    let parent = link(joint, "parent")?;
    for other in robot.children("joint") {
        if link(&other, "child")? == parent {
            return Ok(false);
        }
    }
    Ok(true)
}

fn read_joints(
    (robot, source): (&Element<'_, '_>, &Source<'_>),
    links: &[Link],
) -> Result<Vec<Joint>, UrdfError> {
    let indices: HashMap<&str, usize> = (links.iter().enumerate())
        .map(|(index, link)| (link.name.as_str(), index))
        .collect();
    let mut lines = HashMap::new();
    let mut joints = Vec::new();
    for mut element in robot.children("joint") {
        let name = element.needed("name")?;
        new_name("joint", name, &element, &mut lines)?;
        element.called = format!("joint \"{name}\"");
        let mobility = if element.needed("type")? == "floating" && carries_root(robot, &element)? {
            source.note(format!(
                "line {}: joint \"{name}\" lets the whole robot float; sprung fixes it, so record logs with the base at rest",
                element.line()
            ));
            Mobility::Fixed
        } else {
            mobility(name, &element)?
        };
        let end = |role, example| {
            let end = element.needed_child(role, example)?;
            let link = end.needed("link")?;
            (indices.get(link).copied()).ok_or_else(|| UrdfError::UnknownLink {
                file: end.file(),
                line: end.line(),
                joint: name.to_owned(),
                role,
                link: link.to_owned(),
                nearest: near(link, links.iter().map(|link| &*link.name)),
            })
        };
        joints.push(Joint {
            name: name.to_owned(),
            line: element.line(),
            parent: end("parent", "<parent link=\"base\"/>")?,
            child: end("child", "<child link=\"link1\"/>")?,
            placement: placement(&element)?,
            mobility,
        });
    }
    Ok(joints)
}

fn mobility(name: &str, joint: &Element<'_, '_>) -> Result<Mobility, UrdfError> {
    let (kind, continuous) = match joint.needed("type")? {
        "revolute" => (JointKind::Revolute, false),
        "continuous" => (JointKind::Revolute, true),
        "prismatic" => (JointKind::Prismatic, false),
        // The axis is not read, because exporters give fixed joints axes of length zero.
        "fixed" => return Ok(Mobility::Fixed),
        other => {
            return Err(UrdfError::JointType {
                file: joint.file(),
                line: joint.line(),
                joint: name.to_owned(),
                found: other.to_owned(),
            });
        }
    };
    let freedom = Freedom {
        kind,
        continuous,
        axis: axis(name, joint)?,
        limits: limits(joint, continuous)?,
    };
    Ok(match joint.child("mimic")? {
        Some(mimic) => Mobility::Mimic {
            leader: mimic.needed("joint")?.to_owned(),
        },
        None => Mobility::Own(freedom),
    })
}

/// Returns the axis of a joint with unit length.
fn axis(name: &str, joint: &Element<'_, '_>) -> Result<[f64; 3], UrdfError> {
    const DEFAULT: [f64; 3] = [1.0, 0.0, 0.0];
    let Some(element) = joint.child("axis")? else {
        return Ok(DEFAULT);
    };
    let axis = element.triple("xyz")?.unwrap_or(DEFAULT);
    // Scaled first, because squares of tiny numbers underflow.
    let largest = axis.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest > 0.0 {
        let axis = axis.map(|x| x / largest);
        let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        return Ok(axis.map(|x| x / length));
    }
    Err(UrdfError::AxisLength {
        file: element.file(),
        line: element.line(),
        joint: name.to_owned(),
    })
}

fn limits(joint: &Element<'_, '_>, continuous: bool) -> Result<Limits, UrdfError> {
    let Some(limit) = joint.child("limit")? else {
        return Ok(Limits::default());
    };
    let position = |key| {
        if continuous {
            return Ok(None);
        }
        limit.limit(key)
    };
    Ok(Limits {
        lower: position("lower")?,
        upper: position("upper")?,
        effort: limit.limit("effort")?,
        velocity: limit.limit("velocity")?,
    })
}

/// State of a joint during the sort.
#[derive(Clone, Copy, PartialEq)]
enum Progress {
    Waiting,
    OnPath,
    Done,
}

/// Sorts parents before children; otherwise the order of the file remains.
///
/// # Errors
///
/// [`UrdfError`] if two joints move the same link or joints form a loop.
fn parents_first(file: &str, links: &[Link], joints: Vec<Joint>) -> Result<Vec<Joint>, UrdfError> {
    let mut movers: Vec<Option<usize>> = vec![None; links.len()];
    for (index, joint) in joints.iter().enumerate() {
        if let Some(first) = movers[joint.child].replace(index) {
            return Err(UrdfError::TwoParents {
                file: file.to_owned(),
                line: joint.line,
                link: links[joint.child].name.clone(),
                first: joints[first].name.clone(),
                second: joint.name.clone(),
            });
        }
    }
    let mut progress = vec![Progress::Waiting; joints.len()];
    let mut order = Vec::with_capacity(joints.len());
    for start in 0..joints.len() {
        let mut path = Vec::new();
        let mut next = Some(start);
        while let Some(index) = next.filter(|index| progress[*index] != Progress::Done) {
            if progress[index] == Progress::OnPath {
                // The path leads from child to parent; the error lists parents first.
                let from = path.iter().position(|on| *on == index).unwrap_or(0);
                return Err(UrdfError::Loop {
                    file: file.to_owned(),
                    line: joints[index].line,
                    joints: (path[from..].iter().rev())
                        .map(|on: &usize| joints[*on].name.clone())
                        .collect(),
                });
            }
            progress[index] = Progress::OnPath;
            path.push(index);
            next = movers[joints[index].parent];
        }
        for index in path.into_iter().rev() {
            progress[index] = Progress::Done;
            order.push(index);
        }
    }
    let mut joints: Vec<Option<Joint>> = joints.into_iter().map(Some).collect();
    Ok((order.into_iter())
        .filter_map(|index| joints[index].take())
        .collect())
}

/// Part of the sum of the moments of inertia by which rounding may contradict a body.
const ROUNDED: f64 = 1e-3;

/// A link is suspect that is this many times as heavy as each link that carries it, and heavier than this, kg.
const HEAVIER: f64 = 5.0;
const LIGHT_KG: f64 = 5.0;

/// Returns sentences about bodies that cannot be, or hardly.
///
/// - `joints`: parents before children.
fn about_bodies(links: &[Link], joints: &[Joint]) -> Vec<String> {
    let mut notes = Vec::new();
    for link in links {
        if let Some(body) = &link.body
            && !body.is_possible(ROUNDED)
        {
            notes.push(format!(
                "line {}: no body has the inertia of link \"{}\" about its centre of mass: each moment of inertia is at \
                 most the sum of the two others",
                link.line, link.name
            ));
        }
    }
    // The heaviest link that carries each link.
    let mut carriers = vec![0.0_f64; links.len()];
    for joint in joints {
        let mass = |link: usize| links[link].body.map_or(0.0, |body| body.mass);
        let carrier = carriers[joint.parent].max(mass(joint.parent));
        carriers[joint.child] = carrier;
        let (link, mass) = (&links[joint.child], mass(joint.child));
        if carrier > 0.0 && mass > HEAVIER * carrier && mass > LIGHT_KG {
            notes.push(format!(
                "line {}: link \"{}\" has {mass} kg, and the heaviest link that carries it {carrier} kg; is the mass right?",
                link.line, link.name
            ));
        }
    }
    notes
}

/// Checks that only one link has no parent joint.
fn one_root(file: &str, links: &[Link], joints: &[Joint]) -> Result<(), UrdfError> {
    let mut moved = vec![false; links.len()];
    for joint in joints {
        moved[joint.child] = true;
    }
    let mut roots = (links.iter().zip(moved)).filter_map(|(link, moved)| (!moved).then_some(link));
    match (roots.next(), roots.next()) {
        (Some(first), Some(second)) => Err(UrdfError::TwoRoots {
            file: file.to_owned(),
            line: second.line,
            first: first.name.clone(),
            second: second.name.clone(),
        }),
        _ => Ok(()),
    }
}

/// Returns the movable joints.
///
/// - `joints`: parents before children.
fn movable(joints: &[Joint], links: &[Link]) -> Vec<UrdfJoint> {
    let mut carries = vec![false; links.len()];
    for joint in joints.iter().rev() {
        let moves = matches!(joint.mobility, Mobility::Own(_));
        carries[joint.parent] |= moves || carries[joint.child];
    }
    let of = |joint: &Joint| {
        let Mobility::Own(freedom) = &joint.mobility else {
            return None;
        };
        Some(UrdfJoint {
            name: joint.name.clone(),
            child: links[joint.child].name.clone(),
            kind: freedom.kind,
            continuous: freedom.continuous,
            lower: freedom.limits.lower,
            upper: freedom.limits.upper,
            effort: freedom.limits.effort,
            velocity: freedom.limits.velocity,
            is_last: !carries[joint.child],
        })
    };
    joints.iter().filter_map(of).collect()
}
