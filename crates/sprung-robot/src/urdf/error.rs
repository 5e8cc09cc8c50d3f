//! Errors of robot descriptions, each with its remedy.

use super::super::known_words::{nearest, quoted};

/// Error of a robot description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UrdfError {
    /// The text is not XML.
    #[error("line {line} of {file}: the XML does not parse: {reason}")]
    Xml {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// The parser's message and the remedy.
        reason: String,
    },
    /// The file is larger than any robot.
    #[error(
        "{file} has {found}, and sprung reads a URDF with at most {most}; give the URDF of one robot"
    )]
    TooLarge {
        /// Name of the file.
        file: String,
        /// Size of the file, or its number of links.
        found: String,
        /// The limit.
        most: String,
    },
    /// The file does not describe a robot.
    #[error(
        "line {line} of {file}: the file begins with <{found}>, a URDF begins with <robot>; {}",
        of_root(found, file)
    )]
    Root {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Tag of the root element.
        found: String,
    },
    /// The file contains macros.
    #[error(
        "line {line} of {file}: {what} belongs to xacro, which must be expanded first: `{}`",
        expand(file)
    )]
    Xacro {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// The tag or the attribute.
        what: String,
    },
    /// An attribute is missing.
    #[error("line {line} of {file}: {element} has no {attribute}; write {attribute}=\"...\" in it")]
    NoAttribute {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// The element without the attribute.
        element: String,
        /// The attribute.
        attribute: &'static str,
    },
    /// An element is missing.
    #[error("line {line} of {file}: {owner} has no <{element}>; add one, such as {example}")]
    NoElement {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// The element that lacks it.
        owner: String,
        /// Tag of the missing element.
        element: &'static str,
        /// An example of the missing element.
        example: &'static str,
    },
    /// A single element occurs twice.
    #[error("line {line} of {file}: this is the second <{element}> of {owner}; keep one")]
    Repeated {
        /// Name of the file.
        file: String,
        /// Line of the second, from 1.
        line: usize,
        /// The element with two of them.
        owner: String,
        /// Tag of the element.
        element: &'static str,
    },
    /// An attribute is not a number.
    #[error(
        "line {line} of {file}: {attribute}=\"{value}\" in {element} is not a finite number; write \
         one with a decimal point, such as {attribute}=\"1.5\""
    )]
    NoNumber {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// The element.
        element: String,
        /// Its attribute.
        attribute: &'static str,
        /// The value.
        value: String,
    },
    /// An attribute is not three numbers.
    #[error(
        "line {line} of {file}: {attribute}=\"{value}\" in {element} is not three finite numbers; \
         write them with decimal points and spaces between, such as {attribute}=\"0 0 0.5\""
    )]
    NoTriple {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// The element.
        element: String,
        /// Its attribute.
        attribute: &'static str,
        /// The value.
        value: String,
    },
    /// The axis of a joint has length zero.
    #[error(
        "line {line} of {file}: the axis of joint \"{joint}\" has no length; write its direction, \
         such as xyz=\"0 0 1\""
    )]
    AxisLength {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Name of the joint.
        joint: String,
    },
    /// A joint is of a type that is not supported.
    #[error(
        "line {line} of {file}: joint \"{joint}\" is of type \"{found}\", which is not supported; \
         use \"revolute\", \"continuous\", \"prismatic\" or \"fixed\""
    )]
    JointType {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Name of the joint.
        joint: String,
        /// Its type.
        found: String,
    },
    /// A mass is negative.
    #[error(
        "line {line} of {file}: the mass of link \"{link}\" is {mass} kg; it must not be negative"
    )]
    NegativeMass {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Name of the link.
        link: String,
        /// The mass, kg.
        mass: f64,
    },
    /// Two links or two joints have the same name.
    #[error(
        "line {line} of {file}: another {what} is called \"{name}\" on line {first}; give one of \
         them another name"
    )]
    SameName {
        /// Name of the file.
        file: String,
        /// Line of the second, from 1.
        line: usize,
        /// `link` or `joint`.
        what: &'static str,
        /// The name.
        name: String,
        /// Line of the first, from 1.
        first: usize,
    },
    /// A joint names an unknown link.
    #[error(
        "line {line} of {file}: the {role} of joint \"{joint}\" is \"{link}\", but there is no \
         such link; {}", instead(nearest.as_ref(), "add it or name another")
    )]
    UnknownLink {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Name of the joint.
        joint: String,
        /// `parent` or `child`.
        role: &'static str,
        /// Name of the link.
        link: String,
        /// The nearest name, if any is near.
        nearest: Option<String>,
    },
    /// Two joints move the same link.
    #[error(
        "line {line} of {file}: link \"{link}\" is the child of joints \"{first}\" and \
         \"{second}\"; a link has one parent joint, and closed chains are not supported"
    )]
    TwoParents {
        /// Name of the file.
        file: String,
        /// Line of the second joint, from 1.
        line: usize,
        /// Name of the link.
        link: String,
        /// Name of the first joint.
        first: String,
        /// Name of the second joint.
        second: String,
    },
    /// The joints form a loop.
    #[error(
        "line {line} of {file}: {}; the joints of a URDF form a tree from one root link, \
         which has no parent joint",
        in_turn(joints)
    )]
    Loop {
        /// Name of the file.
        file: String,
        /// Line of one of the joints, from 1.
        line: usize,
        /// Names of the joints, each carried by the one before.
        joints: Vec<String>,
    },
    /// Two links have no parent joint.
    #[error(
        "line {line} of {file}: links \"{first}\" and \"{second}\" both have no parent joint, but \
         a robot has one root; connect them by a fixed joint or remove one"
    )]
    TwoRoots {
        /// Name of the file.
        file: String,
        /// Line of the second, from 1.
        line: usize,
        /// Name of the first link.
        first: String,
        /// Name of the second link.
        second: String,
    },
    /// The robot has no links.
    #[error("line {line} of {file}: the robot has no <link>; give a complete URDF")]
    NoLink {
        /// Name of the file.
        file: String,
        /// Line of the robot, from 1.
        line: usize,
    },
    /// No joint can move.
    #[error(
        "line {line} of {file}: no joint of the robot moves; at least one must be \"revolute\", \
         \"continuous\" or \"prismatic\" and have no <mimic>"
    )]
    NothingMoves {
        /// Name of the file.
        file: String,
        /// Line of the robot, from 1.
        line: usize,
    },
    /// The experiment names an unknown joint.
    #[error(
        "{file} has no joint \"{name}\"; {}",
        instead(near(name, movable.iter().map(String::as_str)).as_ref(), &joints_to_use(movable))
    )]
    UnknownJoint {
        /// Name of the file.
        file: String,
        /// Name of the joint.
        name: String,
        /// Names of the joints that can move.
        movable: Vec<String>,
    },
    /// The experiment names a fixed joint.
    #[error(
        "line {line} of {file}: joint \"{name}\" is fixed and cannot move; leave it out; its link \
         is merged into the link that carries it"
    )]
    FixedJoint {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Name of the joint.
        name: String,
    },
    /// The experiment names a joint that mimics another.
    #[error(
        "line {line} of {file}: joint \"{name}\" mimics \"{leader}\" and has no motor of its own; \
         leave it out; it is then fixed at zero"
    )]
    MimicJoint {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Name of the joint.
        name: String,
        /// Name of the joint that it mimics.
        leader: String,
    },
    /// A joint is listed twice.
    #[error("{file}: joint \"{name}\" is listed twice; list it once")]
    ListedTwice {
        /// Name of the file.
        file: String,
        /// Name of the joint.
        name: String,
    },
    /// A joint is listed before the joint that carries it.
    #[error(
        "{file}: joint \"{carrier}\" carries \"{carried}\"; list \"{carrier}\" before \"{carried}\""
    )]
    Order {
        /// Name of the file.
        file: String,
        /// Name of the joint that carries.
        carrier: String,
        /// Name of the joint that is carried.
        carried: String,
    },
}

/// Returns what makes a URDF of a file with another root.
fn of_root(found: &str, file: &str) -> String {
    match found {
        "mujoco" => {
            let stem = file.strip_suffix(".xml").unwrap_or(file);
            format!(
                "it is MJCF, the format of MuJoCo; convert it first: `pip install mjcf-urdf-simple-converter`, then \
                 `python -m mjcf_urdf_simple_converter.mjcf_urdf_simple_converter {file} {stem}.urdf`"
            )
        }
        "sdf" => "it is SDF, the format of Gazebo; give the URDF from which it was made".to_owned(),
        _ => format!(
            "give the robot's URDF, and expand a xacro file first: `{}`",
            expand(file)
        ),
    }
}

/// Returns the command that expands a xacro file.
fn expand(file: &str) -> String {
    let (stem, ending) = match file.strip_suffix(".xacro") {
        Some(stem) => (stem.strip_suffix(".urdf").unwrap_or(stem), "urdf"),
        None => (file.strip_suffix(".urdf").unwrap_or(file), "expanded.urdf"),
    };
    format!("xacro {file} > {stem}.{ending}")
}

/// Returns the question for the nearest name, or other advice.
fn instead(nearest: Option<&String>, otherwise: &str) -> String {
    nearest.map_or_else(
        || otherwise.to_owned(),
        |name| format!("did you mean \"{name}\"?"),
    )
}

fn joints_to_use(movable: &[String]) -> String {
    let names: Vec<&str> = movable.iter().map(String::as_str).collect();
    format!("use {}", quoted(&names))
}

fn in_turn(joints: &[String]) -> String {
    match joints {
        [one] => format!("joint \"{one}\" carries itself"),
        several => format!("joints \"{}\" form a loop", several.join("\", \"")),
    }
}

/// Returns the nearest name, if its edit distance is small. Names beyond 200 bytes are not compared,
/// so the time is bounded.
pub(super) fn near<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> Option<String> {
    const MAX_NAME_BYTES: usize = 200;
    let names = names.filter(|name| name.len() <= MAX_NAME_BYTES);
    let word = Some(word).filter(|word| !word.is_empty() && word.len() <= MAX_NAME_BYTES)?;
    nearest(word, names).map(str::to_owned)
}
