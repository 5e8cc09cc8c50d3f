//! Messages about a wrong robot: exit code 2, the line of the file, the remedy.

use crate::arm::{URDF, described, robot, urdf};
use crate::common::{Case, messages, replacement, sprung};

/// Text of the URDF file, and what stands there instead.
const WRONG_URDF: &[(&str, &str)] = &[
    ("</robot>", ""),
    ("<link name=\"base\"/>", "<link name=\"base\">"),
    ("mass value=\"3\"", "mass value=\"3,5\""),
    ("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"floating\""),
    ("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"fixed\""),
    (
        "<origin xyz=\"0.4 0 0\"/>",
        "<origin xyz=\"0.4 0 0\"/><mimic joint=\"shoulder\"/>",
    ),
    ("</robot>", "<link name=\"table\"/></robot>"),
    ("<parent link=\"base\"/>", "<parent link=\"fore\"/>"),
    (
        "<origin xyz=\"0.4 0 0\"/><axis xyz=\"0 1 0\"/>",
        "<origin xyz=\"0.4 0 0\"/><axis xyz=\"0 0 0\"/>",
    ),
];

/// Text of the experiment, and what stands there instead.
const WRONG_TEXTS: &[(&str, &str)] = &[
    ("\"elbow\"", "\"elbo\""),
    ("\"elbow\"", "\"j7\""),
    ("name = \"elbow\"", "name = \"shoulder\""),
    ("urdf = \"arm.urdf\"\n", ""),
    ("urdf = \"arm.urdf\"", "dh_classic = [{}, {}, {}]"),
    ("urdf = \"arm.urdf\"", "dh_modified = [{}, { a_m = nan }]"),
    ("urdf = \"arm.urdf\"", "dh_modified = [{}, { a_m = 400.0 }]"),
    ("urdf = \"arm.urdf\"", "dh_modified = [{}, { a = 0.4 }]"),
    ("urdf = \"arm.urdf\"", "kinematics = \"planar-2r\""),
    ("[0.0, 0.0, -9.81]", "[0.0, 0.0, nan]"),
    ("[0.0, 0.0, -9.81]", "[0.0, 0.0, 9810.0]"),
];

/// Further keys of `[robot]`, beside `urdf`.
const WRONG_KEYS: &[&str] = &[
    "dh_modified = [{}, {}]",
    "kinematics = \"planar-2r\"",
    "transmission_matrix = [[1.0, 2.0], [2.0, 4.0]]",
    "transmission_matrix = [[1e-200, 1e-200], [1e-200, 1e-200]]",
    "transmission_matrix = []",
    "transmission_matrix = [[1.0, 2.0]]",
    "transmission_matrix = [[1.0, 2.0], [1.0]]",
    "transmission_matrix = [[nan, 0.0], [0.0, 1.0]]",
    "transmission_matrix = [[0.0, 2.0], [2.0, 4.0]]",
    "transmission_matrix = [[1.0, 0.0], [2.0, 4.0]]",
];

#[test]
fn wrong_urdf_files() {
    let mut messages = messages("wrong_urdf_files");
    for (text, wrong) in WRONG_URDF {
        let case = replacement(text, wrong);
        messages.note(&case, &urdf(text, wrong).refused(2, &[]));
    }
    let case = described();
    case.remove("arm.urdf");
    messages.note("no file", &case.refused(4, &[]));
    messages.compare();
}

#[test]
fn wrong_robots() {
    let mut messages = messages("wrong_robots");
    for (text, wrong) in WRONG_TEXTS {
        let case = replacement(text, wrong);
        messages.note(&case, &described().replace(text, wrong).refused(2, &[]));
    }
    for keys in WRONG_KEYS {
        messages.note(keys, &robot(keys).refused(2, &[]));
    }
    let twice = robot("transmission_matrix = [[1.0, 0.0], [0.0, 4.0]]")
        .replace("name = \"elbow\"\n", "name = \"elbow\"\ngear_ratio = 4.0\n");
    messages.note("a gear ratio said twice", &twice.refused(2, &[]));
    messages.compare();
}

#[test]
fn joints_in_the_wrong_order_and_no_joints() {
    let mut messages = messages("joints_in_the_wrong_order_and_no_joints");
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
    let case = |text: &str| Case::of(&[("experiment.toml", text), ("arm.urdf", URDF)]);
    messages.note(
        "elbow before shoulder",
        &case(&turned.concat()).refused(2, &[]),
    );
    let none = [&text[..first], &text[log..]].concat();
    messages.note("no joints", &case(&none).refused(2, &[]));
    let empty = none.replace("urdf = \"arm.urdf\"", "dh_modified = []");
    messages.note("no joints and no rows", &case(&empty).refused(2, &[]));
    messages.compare();
    sprung(&["simulate", case(&empty).path("").to_str().unwrap()]).ends(2);
}
