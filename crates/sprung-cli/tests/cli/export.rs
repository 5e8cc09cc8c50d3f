//! Exported robots: the kept parts of a URDF, and refusals.

use crate::arm::{self, read, recorded};
use crate::common::{Case, Ran, contains, each, f64_of, list_of, str_of};

/// Values of single links and of joints of the small arm.
const VALUES: &str = r#"
"upper.m" = 3.1
"upper.mx" = 0.6
"upper.my" = 0.0
"upper.mz" = 0.0
"upper.ixx" = 0.02
"upper.ixy" = 0.0
"upper.iyy" = 0.2
"upper.ixz" = 0.0
"upper.iyz" = 0.0
"upper.izz" = 0.2
"fore.m" = 1.4
"fore.mx" = 0.2
"fore.my" = 0.01
"fore.mz" = 0.0
"fore.ixx" = 0.01
"fore.ixy" = 0.0
"fore.iyy" = 0.06
"fore.ixz" = 0.0
"fore.iyz" = 0.0
"fore.izz" = 0.06
"shoulder.rotor_inertia" = 0.3
"shoulder.stiffness" = 410.0
"shoulder.link_viscous" = 0.3
"shoulder.motor_viscous" = 2.0
"shoulder.motor_coulomb" = 1.0
"shoulder.spring_preload" = 0.2
"elbow.rotor_inertia" = 0.05
"elbow.motor_viscous" = 1.0
"elbow.motor_coulomb" = 0.5
"elbow.motor_offset" = 0.1
"#;

/// A URDF with everything that an export must keep.
const FULL: &str = r#"<?xml version="1.0"?>
<!-- the maker's -->
<robot name="arm">
  <link name="base"/>
  <link name="upper"> <!-- a comment -->
    <visual><geometry><mesh filename="meshes/upper.stl"/></geometry></visual>
    <inertial><origin xyz="0.2 0 0"/><mass value="3"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.04"/></inertial>
  </link>
  <link name="fore"/>
  <link name="tool">
    <inertial><mass value="0.2"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>
  </link>
  <joint name="flange" type="fixed">
    <parent link="fore"/><child link="tool"/><origin xyz="0.3 0 0"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="3"/>
    <dynamics damping="7.5"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
  </joint>
  <transmission name="old"><type>x</type><joint name="elbow"/></transmission>
  <gazebo reference="tool"><material>Gazebo/Orange</material></gazebo>
</robot>
"#;

pub(crate) fn known() -> Case {
    Case::of(&[
        ("experiment.toml", arm::EXPERIMENT),
        ("arm.urdf", FULL),
        ("values.toml", VALUES),
    ])
}

fn export(case: &Case, format: &str, more: &[&str]) -> Ran {
    case.run("export", &[&["--format", format][..], more].concat())
}

pub(crate) fn with_values(case: &Case, format: &str, more: &[&str]) -> Ran {
    let values = case.at("values.toml");
    let mut all = vec!["--parameters", &values];
    all.extend(more);
    export(case, format, &all)
}

/// Checks that an export is refused with a message.
fn refused(case: &Case, format: &str, fragments: &[&str]) {
    let text = with_values(case, format, &[]).ends(2).err.clone();
    for fragment in fragments {
        assert!(text.contains(fragment), "{text} lacks {fragment}");
    }
    assert!(!case.path("sprung-out").join("robot.urdf").exists());
}

#[test]
fn a_urdf_stays_as_it_is_but_for_inertials_dynamics_and_transmissions() {
    let case = known();
    let output = with_values(&case, "urdf", &[]);
    output.ends(0);
    let text = case.read("sprung-out/robot.urdf");
    for kept in [
        "<!-- the maker's -->",
        "<link name=\"upper\"> <!-- a comment -->\n    <visual><geometry><mesh filename=\"meshes/upper.stl\"/></geometry></visual>\n    <inertial>",
        // The body that is fixed to the forearm keeps its inertial, so the forearm has the rest.
        "  <link name=\"tool\">\n    <inertial><mass value=\"0.2\"/>\n    <inertia ixx=\"0.001\"",
        "<limit lower=\"-2\" upper=\"2\" effort=\"50\" velocity=\"3\"/>\n    <dynamics damping=\"0.3\" friction=\"0\"/>",
        "<gazebo reference=\"tool\"><material>Gazebo/Orange</material></gazebo>",
        "<joint name=\"shoulder_motor\" type=\"continuous\">",
        "<stiffness>410</stiffness>",
        "mass value=\"1.2\"",
    ] {
        assert!(text.contains(kept), "{kept}\n{text}");
    }
    assert!(
        !text.contains("transmission name=\"old\"") && !text.contains("7.5"),
        "{text}"
    );
    let printed = &output.out;
    contains(
        printed,
        &[
            "mesh meshes/upper.stl",
            "no such file",
            "shoulder.spring_preload",
            "read back",
        ],
    );
}

#[test]
fn a_light_link_takes_a_part_of_the_bodies_that_are_fixed_to_it() {
    let case = known().replace_in("values.toml", "\"fore.m\" = 1.4", "\"fore.m\" = 0.15");
    let case = case.replace_in("values.toml", "\"fore.mx\" = 0.2", "\"fore.mx\" = 0.02");
    with_values(&case, "urdf", &[])
        .ends(0)
        .prints(&["fixed body tool"]);
}

#[test]
fn every_format_says_the_identified_robot() {
    for case in [recorded(), Case::new()] {
        assert!(case.identify(&[]).code.is_some_and(|code| code < 2));
        for format in ["urdf", "mjcf", "sdf", "json"] {
            for more in [&[][..], &["--rigid"]] {
                let mut args = vec!["--json", "--force"];
                args.extend(more);
                let output = export(&case, format, &args);
                let code = output.code;
                assert!(
                    code.is_some_and(|code| code < 2),
                    "{format}: {}",
                    output.err
                );
                let json = output.json();
                for what in ["inverse_dynamics", "mass_matrix", "accelerations"] {
                    assert!(f64_of(&json["proof"][what]) < 1e-9, "{format} {json}");
                }
            }
        }
    }
}

#[test]
fn an_edited_file_is_replaced_only_by_force() {
    let case = known();
    with_values(&case, "mjcf", &[]).ends(0);
    with_values(&case, "mjcf", &[]).ends(0);
    let file = case.path("sprung-out/robot.xml");
    let edited = read(&file).replace("410", "300");
    std::fs::write(&file, &edited).unwrap();
    refused(&case, "mjcf", &["robot.xml was edited", "--force"]);
    assert_eq!(read(&file), edited);
    with_values(&case, "mjcf", &["--force"]).ends(0);
    assert!(read(&file).contains("stiffness=\"410\""));
    std::fs::write(&file, "<mujoco/>").unwrap();
    refused(&case, "mjcf", &["was not written by sprung export"]);
}

#[test]
fn values_that_are_not_physical_are_named() {
    let changed = |from: &str, to: &str| known().replace_in("values.toml", from, to);
    #[rustfmt::skip]
    let rows = [
        (
            changed("\"fore.m\" = 1.4", "\"fore.m\" = -0.4"),
            &[
                "not physical",
                "fore has the mass -0.4 kg",
                "standard_parameters",
            ][..],
        ),
        (changed("\"upper.iyy\" = 0.2", "\"upper.iyy\" = 0.9"), &["density", "upper"]),
        (changed("\"shoulder.stiffness\" = 410.0", "\"shoulder.stiffness\" = -410.0"), &["stiffness of shoulder is -410"]),
        (changed("\"upper.my\" = 0.0\n", ""), &["upper.my", "standard_parameters"]),
    ];
    each(rows, |(case, fragments)| {
        refused(&case, "urdf", fragments);
    });
}

#[test]
fn names_that_a_format_forbids_are_refused() {
    let taken = known().replace_in("arm.urdf", "\"flange\"", "\"shoulder_motor\"");
    refused(
        &taken,
        "urdf",
        &["already has a joint \"shoulder_motor\"", "--rigid"],
    );
    let nested = known().replace_in("arm.urdf", "\"fore\"", "\"arm::fore\"");
    let nested = nested.replace_in("values.toml", "\"fore.", "\"arm::fore.");
    refused(
        &nested,
        "sdf",
        &["SDF forbids the name \"arm::fore\"", "rename"],
    );
    with_values(&nested, "mjcf", &[]).ends(0);
}

#[test]
fn an_identification_of_another_robot_is_refused() {
    let case = recorded();
    case.identify(&[]);
    let other = case.replace("name = \"arm\"", "name = \"leg\"");
    export(&other, "urdf", &[])
        .ends(2)
        .tells(&["\"arm\"", "\"leg\""]);
    let fresh = recorded();
    export(&fresh, "urdf", &[]).tells(&["run sprung identify first"]);
}

#[test]
fn an_identification_without_possible_bodies_is_refused() {
    let limits = "[identify.physical]\ntotal_mass_kg = [1.0, 2.0]\nmass_kg = { upper = [5.0, 6.0] }\n\n[controller]\n";
    let case = (recorded().replace("[controller]\n", limits))
        .replace("[identify]\n", "[identify]\nconstraints = \"none\"\n");
    case.identify(&[]);
    export(&case, "mjcf", &[]).ends(2).tells(&[
        "upper.m",
        "no-possible-bodies",
        "[identify.physical]",
    ]);
}

#[test]
fn the_comment_the_table_and_the_file_show_one_number() {
    let laws = "name = \"joint1\"\nmotor_friction = [\"viscous-asymmetric\", \"coulomb\", \"quadratic\"]\n";
    let case =
        (Case::new().replace("name = \"joint1\"\n", laws)).replace(", motor_viscous = 4.5", "");
    let (code, result) = case.results(&["--set", "identify.laws=\"declared\""]);
    assert!(code < 2);
    let moved: Vec<(&str, f64)> = (list_of(&result["results"][0]["dependence"]).iter())
        .map(|moved| (str_of(&moved["name"]), moved))
        .map(|(name, moved)| (name, f64_of(&moved["projected"])))
        .collect();
    assert_eq!(moved.len(), 3, "{moved:?}");
    let json = export(&case, "mjcf", &["--json"]).json();
    let table = list_of(&json["said"]);
    let text = case.read("sprung-out/robot.xml");
    for (name, projected) in moved {
        let line = text
            .lines()
            .find_map(|line| line.trim().strip_prefix(&format!("{name} = ")));
        let shown: f64 = line.unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!(
            (shown / projected - 1.0).abs() < 1e-5,
            "{name}: {shown} in the comment, {projected} in the file"
        );
        assert!(
            line.unwrap()
                .ends_with("beside the laws that the format lacks)")
        );
        if name.contains("viscous") {
            let row = table.iter().find(|row| row["what"] == name);
            let note = row.unwrap()["note"].as_str().unwrap();
            let told: f64 = note.split(' ').next().unwrap().parse().unwrap();
            assert!((told / projected - 1.0).abs() < 1e-3, "{name}: {note}");
        }
    }
}
