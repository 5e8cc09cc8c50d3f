//! Messages about a wrong robot: exit code 2, the line of the file, the remedy.

use crate::arm::{URDF, described, robot, urdf};
use crate::common::{Case, sprung, stderr};

#[test]
fn urdf_that_does_not_parse() {
    urdf("</robot>", "").fails(
        2,
        &[
            "line 16 of",
            "arm.urdf: the XML does not parse: the text ends before all tags are closed",
        ],
    );
    urdf("<link name=\"base\"/>", "<link name=\"base\">").fails(
        2,
        &[
            "line 17 of",
            "arm.urdf: the XML does not parse: expected 'link' tag",
        ],
    );
    urdf("mass value=\"3\"", "mass value=\"3,5\"").fails(
        2,
        &[
            "line 4 of",
            "value=\"3,5\"",
            "link \"upper\"",
            "decimal point",
        ],
    );
}

#[test]
fn urdf_that_is_missing() {
    let case = described();
    std::fs::remove_file(case.path("arm.urdf")).unwrap();
    let path = case.path("arm.urdf");
    let cannot = format!("cannot read {}, the urdf of [robot]", path.display());
    case.fails(
        4,
        &[&cannot, "No such file", "relative to the experiment file"],
    );
}

#[test]
fn joints_that_cannot_be_moved() {
    described().replace("\"elbow\"", "\"elbo\"").fails(
        2,
        &[
            "line 12 of",
            "has no joint \"elbo\"; did you mean \"elbow\"?",
        ],
    );
    described().replace("\"elbow\"", "\"j7\"").fails(
        2,
        &[
            "line 12 of",
            "has no joint \"j7\"; use \"shoulder\" or \"elbow\"",
        ],
    );
    described()
        .replace("name = \"elbow\"", "name = \"shoulder\"")
        .fails(2, &["line 12 of", "joint \"shoulder\" is listed twice"]);
    urdf("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"floating\"").fails(
        2,
        &[
            "line 14 of",
            "joint \"elbow\" is of type \"floating\"",
            "use \"revolute\", \"continuous\", \"prismatic\" or \"fixed\"",
        ],
    );
    urdf("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"fixed\"").fails(
        2,
        &[
            "line 14 of",
            "joint \"elbow\" is fixed and cannot move; leave it out",
        ],
    );
    let mimic = "<origin xyz=\"0.4 0 0\"/><mimic joint=\"shoulder\"/>";
    urdf("<origin xyz=\"0.4 0 0\"/>", mimic).fails(
        2,
        &[
            "line 14 of",
            "joint \"elbow\" mimics \"shoulder\" and has no motor of its own",
        ],
    );
}

#[test]
fn joints_in_the_wrong_order() {
    let text = std::fs::read_to_string(described().path("experiment.toml")).unwrap();
    let first = text.find("[[robot.joint]]").unwrap();
    let second = text.rfind("[[robot.joint]]").unwrap();
    let log = text.find("[log]").unwrap();
    let turned = [
        &text[..first],
        &text[second..log],
        &text[first..second],
        &text[log..],
    ];
    Case::of(&[("experiment.toml", &turned.concat()), ("arm.urdf", URDF)]).fails(
        2,
        &[
            "line 11 of",
            "joint \"shoulder\" carries \"elbow\"; list \"shoulder\" before \"elbow\"",
        ],
    );
}

#[test]
fn joints_that_form_no_tree() {
    urdf("</robot>", "<link name=\"table\"/></robot>").fails(
        2,
        &[
            "line 17 of",
            "links \"base\" and \"table\" both have no parent joint",
            "one root",
        ],
    );
    urdf("<parent link=\"base\"/>", "<parent link=\"fore\"/>").fails(
        2,
        &["line 11 of", "joints \"elbow\", \"shoulder\" form a loop"],
    );
    urdf(
        "<origin xyz=\"0.4 0 0\"/><axis xyz=\"0 1 0\"/>",
        "<origin xyz=\"0.4 0 0\"/><axis xyz=\"0 0 0\"/>",
    )
    .fails(
        2,
        &[
            "line 15 of",
            "the axis of joint \"elbow\" has no length",
            "xyz=\"0 0 1\"",
        ],
    );
}

#[test]
fn transmission_matrices() {
    let matrix = |rows: &str| robot(&format!("transmission_matrix = {rows}"));
    for rows in [
        "[[1.0, 2.0], [2.0, 4.0]]",
        "[[1e-200, 1e-200], [1e-200, 1e-200]]",
    ] {
        matrix(rows).fails(2, &["line 5 of", "transmission_matrix is singular"]);
    }
    for rows in ["[]", "[[1.0, 2.0]]", "[[1.0, 2.0], [1.0]]"] {
        matrix(rows).fails(
            2,
            &["line 5 of", "transmission_matrix needs 2 rows of 2 numbers"],
        );
    }
    matrix("[[nan, 0.0], [0.0, 1.0]]").fails(
        2,
        &[
            "line 5 of",
            "every number of transmission_matrix must be finite",
        ],
    );
    matrix("[[0.0, 2.0], [2.0, 4.0]]").fails(
        2,
        &[
            "line 5 of",
            "motor 1 does not turn shoulder (the diagonal contains 0)",
            "order the motors",
        ],
    );
    matrix("[[1.0, 0.0], [2.0, 4.0]]").fails(
        2,
        &[
            "line 5 of",
            "elbow is coupled to shoulder, but only one of them is flexible",
            "the same transmission",
        ],
    );
    matrix("[[1.0, 0.0], [0.0, 4.0]]")
        .replace("name = \"elbow\"\n", "name = \"elbow\"\ngear_ratio = 4.0\n")
        .fails(
            2,
            &[
                "line 5 of",
                "elbow: gear_ratio and transmission_matrix both give the gear ratio",
            ],
        );
}

#[test]
fn kinematics_said_never_twice_or_wrong() {
    described().replace("urdf = \"arm.urdf\"\n", "").fails(
        2,
        &["line 2 of", "does not describe its kinematics", "give urdf"],
    );
    for (other, both) in [
        (
            "dh_modified = [{}, {}]",
            "urdf and dh_modified both describe",
        ),
        (
            "kinematics = \"planar-2r\"",
            "kinematics and urdf both describe",
        ),
    ] {
        robot(other).fails(2, &["line", both, "keep one"]);
    }
    let dh = |rows: &str| described().replace("urdf = \"arm.urdf\"", rows);
    dh("dh_classic = [{}, {}, {}]").fails(
        2,
        &[
            "line 4 of",
            "dh_classic has 3 rows, the file has 2 [[robot.joint]] blocks",
        ],
    );
    dh("dh_modified = [{}, { a_m = nan }]").fails(
        2,
        &[
            "line 4 of",
            "every number of row 2 of dh_modified must be finite",
        ],
    );
    dh("dh_modified = [{}, { a_m = 400.0 }]").fails(
        2,
        &[
            "line 4 of",
            "row 2 of dh_modified: a_m = 400.0 is longer than 100 m; lengths are in",
        ],
    );
    dh("dh_modified = [{}, { a = 0.4 }]").fails(
        2,
        &[
            "line 4 of",
            "unknown key \"a\" in [robot.dh_modified]; did you mean \"a_m\"?",
        ],
    );
    dh("kinematics = \"planar-2r\"").fails(
        2,
        &[
            "line 5 of",
            "\"planar-2r\" moves in a horizontal plane, in which gravity does no work",
        ],
    );
    for gravity in ["[0.0, 0.0, nan]", "[0.0, 0.0, 9810.0]"] {
        described()
            .replace("[0.0, 0.0, -9.81]", gravity)
            .fails(2, &["line 5 of", "must be three numbers below 1000 m/s²"]);
    }
}

#[test]
fn a_robot_without_joints() {
    let text = std::fs::read_to_string(described().path("experiment.toml")).unwrap();
    let (first, log) = (
        text.find("[[robot.joint]]").unwrap(),
        text.find("[log]").unwrap(),
    );
    let none = [&text[..first], &text[log..]].concat();
    let case = |text: &str| Case::of(&[("experiment.toml", text), ("arm.urdf", URDF)]);
    case(&none).fails(
        2,
        &[
            "line 2 of",
            "names no joints; write a [[robot.joint]] block",
            "of shoulder, elbow",
        ],
    );
    let empty = none.replace("urdf = \"arm.urdf\"", "dh_modified = []");
    case(&empty).fails(2, &["line 4 of", "dh_modified has no rows; write one"]);
    let output = sprung(&["simulate", case(&empty).path("").to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}
