//! Every error with its text.

use super::Urdf;

/// A valid robot on five lines; the tests insert faults into it.
const GOOD: &str = "<robot name='r'>
<link name='base'/><link name='arm'/><link name='hand'/>
<joint name='turn' type='revolute'><parent link='base'/><child link='arm'/></joint>
<joint name='grip' type='prismatic'><parent link='arm'/><child link='hand'/></joint>
</robot>";

/// Asserts the error message of a file.
#[track_caller]
fn refused(text: &str, message: &str) {
    let error = Urdf::parse("r.urdf", text).unwrap_err();
    assert_eq!(error.to_string(), message);
}

/// Asserts the error message of the valid robot after the replacement of `old` by `new`.
#[track_caller]
fn refused_with(old: &str, new: &str, message: &str) {
    assert!(GOOD.contains(old), "{old}");
    refused(&GOOD.replacen(old, new, 1), message);
}

/// Asserts the error message of the valid robot with additional text inside its joint `turn`.
#[track_caller]
fn refused_in_turn(inside: &str, message: &str) {
    let end = "<child link='arm'/>";
    refused_with(end, &format!("{end}{inside}"), message);
}

/// Asserts the error message of the valid robot with an `<inertial>` of the base.
#[track_caller]
fn refused_body(inertial: &str, message: &str) {
    let link = format!("<link name='base'>\n<inertial>\n{inertial}</inertial></link>");
    refused_with("<link name='base'/>", &link, message);
}

#[track_caller]
fn refused_tree(text: &str, moving: &[&str], message: &str) {
    let error = Urdf::parse("r.urdf", text)
        .unwrap()
        .tree(moving)
        .unwrap_err();
    assert_eq!(error.to_string(), message);
}

#[test]
fn xml_that_does_not_parse() {
    refused_with(
        "<link name='hand'/>",
        "<link name='hand'>",
        "line 5 of r.urdf: the XML does not parse: expected 'link' tag, not 'robot' at 5:1; correct \
         it or export the file again",
    );
    let early = "the text ends before all tags are closed; is the file complete?";
    refused(
        "",
        &format!("line 1 of r.urdf: the XML does not parse: {EMPTY}"),
    );
    let cut = &GOOD[..GOOD.len() - "</robot>".len()];
    refused(
        cut,
        &format!("line 4 of r.urdf: the XML does not parse: {early}"),
    );
    refused_with(
        "<robot",
        "\n<!DOCTYPE robot [<!ENTITY a 'b'>]>\n<robot",
        "line 2 of r.urdf: the XML does not parse: a <!DOCTYPE ...> is not supported; remove it",
    );
    refused_with(
        "</robot>",
        "<gazebo><sensor:camera/></gazebo></robot>",
        "line 5 of r.urdf: the XML does not parse: the prefix \"sensor:\" is not declared; remove \
         its elements, or declare it in the first tag: <robot xmlns:sensor=\"sensor\" ...>",
    );
}

const EMPTY: &str = "the document does not have a root node; correct it or export the file again";

#[test]
fn files_of_another_kind() {
    refused(
        "<?xml version='1.0'?>\n<sdf version='1.7'><model name='r'/></sdf>",
        "line 2 of r.urdf: the file begins with <sdf>, a URDF begins with <robot>; it is SDF, the format of Gazebo; give \
         the URDF from which it was made",
    );
    refused(
        "<mujoco/>",
        "line 1 of r.urdf: the file begins with <mujoco>, a URDF begins with <robot>; it is MJCF, the format of MuJoCo; \
         convert it first: `pip install mjcf-urdf-simple-converter`, then \
         `python -m mjcf_urdf_simple_converter.mjcf_urdf_simple_converter r.urdf r.urdf.urdf`",
    );
    refused(
        "<COLLADA/>",
        "line 1 of r.urdf: the file begins with <COLLADA>, a URDF begins with <robot>; give the robot's \
         URDF, and expand a xacro file first: `xacro r.urdf > r.expanded.urdf`",
    );
    refused(
        "<robot name='r'/>",
        "line 1 of r.urdf: the robot has no <link>; give a complete URDF",
    );
    refused_with(
        " name='r'",
        "",
        "line 1 of r.urdf: <robot> has no name; write name=\"...\" in it",
    );
}

#[test]
fn macros_that_are_not_expanded() {
    let rest = "belongs to xacro, which must be expanded first: `xacro r.urdf > r.expanded.urdf`";
    refused_with(
        "<link name='base'/>",
        "<xacro:arm/>",
        &format!("line 2 of r.urdf: the prefix \"xacro:\" {rest}"),
    );
    for space in ["http://www.ros.org/wiki/xacro", "http://example.com"] {
        let declared = GOOD
            .replacen("<robot", &format!("<robot xmlns:xacro='{space}'"), 1)
            .replacen("</robot>", "<gazebo><xacro:arm/></gazebo></robot>", 1);
        refused(&declared, &format!("line 5 of r.urdf: <xacro:arm> {rest}"));
    }
    refused_in_turn(
        "\n<origin rpy='0 0 ${pi/2}'/>",
        &format!("line 4 of r.urdf: rpy=\"0 0 ${{pi/2}}\" {rest}"),
    );
    refused_with(
        "'turn'",
        "'$(arg side)_turn'",
        &format!("line 3 of r.urdf: name=\"$(arg side)_turn\" {rest}"),
    );
    // The command derives the name of the result from the name of the file.
    for (file, command) in [
        ("arm.xacro", "`xacro arm.xacro > arm.urdf`"),
        ("a/arm.urdf.xacro", "`xacro a/arm.urdf.xacro > a/arm.urdf`"),
        ("arm.xml", "`xacro arm.xml > arm.xml.expanded.urdf`"),
    ] {
        let error = Urdf::parse(file, "<COLLADA/>").unwrap_err().to_string();
        assert!(error.ends_with(command), "{error}");
    }
}

#[test]
fn missing_and_repeated_elements() {
    refused_with(
        " name='turn'",
        "",
        "line 3 of r.urdf: a <joint> has no name; write name=\"...\" in it",
    );
    refused_with(
        " type='revolute'",
        "",
        "line 3 of r.urdf: joint \"turn\" has no type; write type=\"...\" in it",
    );
    refused_with(
        "<parent link='base'/>",
        "",
        "line 3 of r.urdf: joint \"turn\" has no <parent>; add one, \
        such as <parent link=\"base\"/>",
    );
    refused_with(
        "<child link='arm'/>",
        "",
        "line 3 of r.urdf: joint \"turn\" has no <child>; add one, such as <child link=\"link1\"/>",
    );
    refused_with(
        "<child link='arm'/>",
        "\n<child link=' '/>",
        "line 4 of r.urdf: the <child> of joint \"turn\" has no link; write link=\"...\" in it",
    );
    refused_in_turn(
        "<mimic/>",
        "line 3 of r.urdf: the <mimic> of joint \"turn\" has no joint; write joint=\"...\" in it",
    );
    refused_in_turn(
        "<limit/>\n<limit/>",
        "line 4 of r.urdf: this is the second <limit> of joint \"turn\"; keep one",
    );
}

#[test]
fn invalid_numbers() {
    let rest = "is not three finite numbers; write them with decimal points and spaces between, \
                such as xyz=\"0 0 0.5\"";
    for xyz in [
        "1,2 0 0", "0, 0, 1", "0 0", "0 0 0 1", "", "nan 0 0", "inf 0 0", "1e31 0 0",
    ] {
        refused_in_turn(
            &format!("<origin xyz='{xyz}'/>"),
            &format!("line 3 of r.urdf: xyz=\"{xyz}\" in the <origin> of joint \"turn\" {rest}"),
        );
    }
    refused_in_turn(
        "\n<axis xyz='0 0 z'/>",
        &format!("line 4 of r.urdf: xyz=\"0 0 z\" in the <axis> of joint \"turn\" {rest}"),
    );
    for effort in ["1,5", "nan", ""] {
        refused_in_turn(
            &format!("<limit effort='{effort}'/>"),
            &format!(
                "line 3 of r.urdf: effort=\"{effort}\" in the <limit> of joint \"turn\" is not a \
                 finite number; write one with a decimal point, such as effort=\"1.5\""
            ),
        );
    }
    refused_in_turn(
        "<axis xyz='0 0.0 -0'/>",
        "line 3 of r.urdf: the axis of joint \"turn\" has no length; write its direction, such as \
         xyz=\"0 0 1\"",
    );
}

#[test]
fn invalid_bodies() {
    refused_body(
        "<inertia/>",
        "line 3 of r.urdf: the <inertial> of link \"base\" has no <mass>; add one, such as <mass \
         value=\"1.5\"/>",
    );
    refused_body(
        "<mass value='1'/>",
        "line 3 of r.urdf: the <inertial> of link \"base\" has no <inertia>; add one, such as \
         <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/>",
    );
    refused_body(
        "<mass value='1'/><inertia ixx='1'/>",
        "line 4 of r.urdf: the <inertia> of the <inertial> of link \"base\" has no ixy; write \
         ixy=\"...\" in it",
    );
    refused_body(
        "<mass value='1 kg'/>",
        "line 4 of r.urdf: value=\"1 kg\" in the <mass> of the <inertial> of link \"base\" is not \
         a finite number; write one with a decimal point, such as value=\"1.5\"",
    );
    refused_body(
        "<mass value='-2.5'/>",
        "line 4 of r.urdf: the mass of link \"base\" is -2.5 kg; it must not be negative",
    );
}

#[test]
fn joints_that_are_not_supported() {
    for kind in ["planar", "spherical", "Revolute"] {
        refused_with(
            "revolute",
            kind,
            &format!(
                "line 3 of r.urdf: joint \"turn\" is of type \"{kind}\", which is not supported; \
                 use \"revolute\", \"continuous\", \"prismatic\" or \"fixed\""
            ),
        );
    }
    let still = GOOD.replacen("revolute", "fixed", 1).replacen(
        "<child link='hand'/>",
        "<child link='hand'/><mimic joint='turn'/>",
        1,
    );
    refused(
        &still,
        "line 1 of r.urdf: no joint of the robot moves; at least one must be \"revolute\", \
         \"continuous\" or \"prismatic\" and have no <mimic>",
    );
}

#[test]
fn names_that_do_not_fit() {
    refused_with(
        "<link name='hand'/>",
        "<link name='hand'/>\n<link name='arm'/>",
        "line 3 of r.urdf: another link is called \"arm\" on line 2; give one of them another name",
    );
    refused_with(
        "'grip'",
        "'turn'",
        "line 4 of r.urdf: another joint is called \"turn\" on line 3; give one of them another \
         name",
    );
    refused_with(
        "<parent link='base'/>",
        "<parent link='bass'/>",
        "line 3 of r.urdf: the parent of joint \"turn\" is \"bass\", but there is no such link; \
         did you mean \"base\"?",
    );
    refused_with(
        "<child link='hand'/>",
        "<child link='gripper_finger'/>",
        "line 4 of r.urdf: the child of joint \"grip\" is \"gripper_finger\", but there is no such \
         link; add it or name another",
    );
}

#[test]
fn joints_that_form_no_tree() {
    refused_with(
        "<child link='hand'/>",
        "<child link='arm'/>",
        "line 4 of r.urdf: link \"arm\" is the child of joints \"turn\" and \"grip\"; a link has \
         one parent joint, and closed chains are not supported",
    );
    let rest = "the joints of a URDF form a tree from one root link, which has no parent joint";
    refused_with(
        "<parent link='base'/>",
        "<parent link='hand'/>",
        &format!("line 3 of r.urdf: joints \"grip\", \"turn\" form a loop; {rest}"),
    );
    refused_with(
        "<parent link='arm'/>",
        "<parent link='hand'/>",
        &format!("line 4 of r.urdf: joint \"grip\" carries itself; {rest}"),
    );
    // A robot without a root link.
    let ring = GOOD.replacen("link='base'", "link='hand'", 1);
    refused(
        &ring.replacen("<link name='base'/>", "", 1),
        &format!("line 3 of r.urdf: joints \"grip\", \"turn\" form a loop; {rest}"),
    );
    refused_with(
        "</robot>",
        "<link name='table'/></robot>",
        "line 5 of r.urdf: links \"base\" and \"table\" both have no parent joint, but a robot \
         has one root; connect them by a fixed joint or remove one",
    );
}

#[test]
fn joints_that_cannot_move() {
    refused_tree(
        GOOD,
        &["turm"],
        "r.urdf has no joint \"turm\"; did you mean \"turn\"?",
    );
    for name in ["shoulder", ""] {
        refused_tree(
            GOOD,
            &[name],
            &format!("r.urdf has no joint \"{name}\"; use \"turn\" or \"grip\""),
        );
    }
    refused_tree(
        &GOOD.replacen("revolute", "fixed", 1),
        &["grip", "turn"],
        "line 3 of r.urdf: joint \"turn\" is fixed and cannot move; leave it out; its link is \
         merged into the link that carries it",
    );
    refused_tree(
        &GOOD.replacen(
            "<child link='hand'/>",
            "<child link='hand'/><mimic joint='turn'/>",
            1,
        ),
        &["turn", "grip"],
        "line 4 of r.urdf: joint \"grip\" mimics \"turn\" and has no motor of its own; leave it \
         out; it is then fixed at zero",
    );
    refused_tree(
        GOOD,
        &["turn", "turn"],
        "r.urdf: joint \"turn\" is listed twice; list it once",
    );
    refused_tree(
        GOOD,
        &["grip", "turn"],
        "r.urdf: joint \"turn\" carries \"grip\"; list \"turn\" before \"grip\"",
    );
}
