//! Logs of an arm from a URDF whose units, sides, order or directions differ from the description, and descriptions of
//! another robot.

use std::fmt::Write as _;
use std::sync::OnceLock;

use serde_json::Value;

use crate::arm;
use crate::common::{Case, contains, list_of, str_of};

/// Ranges of the joints: the wrist turns twice.
const AMPLITUDES_DEG: [f64; 4] = [40.0, 25.0, 35.0, 180.0];
const JOINTS: [&str; 4] = ["pan", "lift", "elbow", "wrist"];
const AXES: [&str; 2] = ["0 1 0", "0 1 0"];
const GEARS: [f64; 4] = [100.0, 100.0, 80.0, 50.0];

/// A URDF of the arm.
///
/// - `masses`: factor of its masses; `axes`: axes of its second and third joint.
fn urdf(masses: f64, axes: [&str; 2]) -> String {
    let mut text = "<robot name=\"arm\"><link name=\"base\"/>".to_owned();
    let links = [
        ("post", 3.7, "0 0 0", 0.01),
        ("upper", 8.4, "0 0 0.28", 0.2),
        ("fore", 2.3, "0 0 0.25", 0.05),
        ("hand", 1.2, "0.05 0.03 0.08", 0.01),
    ];
    for (name, mass, centre, inertia) in links {
        write!(
            text,
            "<link name=\"{name}\"><inertial><origin xyz=\"{centre}\"/><mass value=\"{}\"/><inertia ixx=\"{inertia}\" \
             ixy=\"0\" ixz=\"0\" iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\"/></inertial></link>",
            mass * masses
        )
        .unwrap();
    }
    let joints = [
        ("pan", "base", "post", "0 0 0.09", "0 0 1"),
        ("lift", "post", "upper", "0 0.136 0", axes[0]),
        ("elbow", "upper", "fore", "0 -0.12 0.425", axes[1]),
        ("wrist", "fore", "hand", "0 0.1 0.39", "0 0 1"),
    ];
    for (name, parent, child, origin, axis) in joints {
        write!(
            text,
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin \
             xyz=\"{origin}\"/><axis xyz=\"{axis}\"/><limit lower=\"-6.3\" upper=\"6.3\" effort=\"150\" \
             velocity=\"3\"/></joint>"
        )
        .unwrap();
    }
    text + "</robot>"
}

fn experiment() -> String {
    let mut text = "format = 1\n[robot]\nname = \"arm\"\nurdf = \"arm.urdf\"\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\n"
        .to_owned();
    for ((name, rotor), gear) in JOINTS.iter().zip([0.6, 0.9, 0.4, 0.08]).zip(GEARS) {
        write!(
            text,
            "[[robot.joint]]\nname = \"{name}\"\ntransmission = \"rigid\"\ngear_ratio = {gear:?}\nnominal = \
             {{ rotor_inertia = {rotor}, motor_viscous = {}, motor_coulomb = {}, motor_offset = 0.05 }}\n",
            10.0 * rotor,
            8.0 * rotor
        )
        .unwrap();
    }
    text.push_str(
        "[log]\nfile = \"run.csv\"\ntime_s = \"t\"\nmotor_position_rad = [\"q1\", \"q2\", \"q3\", \"q4\"]\n\
         motor_torque_nm = [\"tau1\", \"tau2\", \"tau3\", \"tau4\"]\n[identify]\nestimator = \"least-squares\"\n\
         [controller]\nkind = \"pd\"\nkp_nm_per_rad = [2000.0, 2500.0, 1200.0, 100.0]\n\
         kd_nms_per_rad = [60.0, 80.0, 40.0, 3.0]\n[controller.reference]\ncentre_deg = [0.0, -60.0, 60.0, -40.0]\n\
         sines = [\n",
    );
    for ((name, amplitude), k) in JOINTS.iter().zip(AMPLITUDES_DEG).zip(0..) {
        let frequency = 0.2 + 0.07 * f64::from(k);
        for (frequency, phase) in [(frequency, 90.0), (2.7 * frequency, -90.0)] {
            writeln!(
                text,
                "{{ joint = \"{name}\", amplitude_deg = {amplitude:?}, frequency_hz = {frequency:?}, phase_deg = \
                 {phase:?} }},"
            )
            .unwrap();
        }
    }
    text.push_str(
        "]\n[simulate]\nduration_s = 12.0\nperiod_s = 0.002\ntorque_noise_nm = [0.5, 0.5, 0.3, 0.1]\n",
    );
    text
}

/// The arm with a log of its twin.
fn recorded() -> Case {
    static LOG: OnceLock<String> = OnceLock::new();
    let described = || {
        Case::of(&[
            ("experiment.toml", &experiment()),
            ("arm.urdf", &urdf(1.0, AXES)),
        ])
    };
    let log = LOG.get_or_init(|| {
        let case = described();
        case.record("run.csv", &[]);
        case.read("run.csv")
    });
    let case = described();
    case.write("run.csv", log);
    case
}

/// Runs a check. Returns the exit code and the findings above notes.
fn check(case: &Case, more: &[&str]) -> (i32, Vec<Value>) {
    let output = case.run("check", &[&["--json"][..], more].concat());
    let json = output.json();
    let findings = list_of(&json["findings"]).iter();
    (
        output.code.unwrap(),
        (findings.filter(|finding| finding["severity"] != "info"))
            .cloned()
            .collect(),
    )
}

/// Checks that the log has one finding with a severity, a code, words of its text and a line, which may be empty.
#[track_caller]
fn says(case: &Case, [severity, code, words]: [&str; 3], line: &str) {
    let (exit, findings) = check(case, &[]);
    let [finding] = &findings[..] else {
        panic!("{findings:#?}")
    };
    assert_eq!(finding["severity"], severity, "{finding:#}");
    assert_eq!(finding["code"], code, "{finding:#}");
    let text = str_of(&finding["text"]);
    contains(text, &[words]);
    let bare = |setting: &str| {
        let lines = setting.lines();
        let lines = lines.map(|line| line.split("  # in place of").next().unwrap_or_default());
        lines.collect::<Vec<&str>>().join("; ")
    };
    let setting = finding["setting"].as_str().map(bare);
    assert_eq!(setting.unwrap_or_default(), line, "{finding:#}");
    let expected = match severity {
        "error" => 3,
        "serious" => 1,
        _ => 0,
    };
    assert_eq!(exit, expected);
    case.identify(&["-q"]).ends(expected);
}

/// Checks that the log has no finding.
fn says_nothing(case: &Case, more: &[&str]) {
    let (exit, findings) = check(case, more);
    assert!(findings.is_empty(), "{findings:#?}");
    assert_eq!(exit, 0);
}

fn scaled(case: Case, columns: &[usize], by: f64) -> Case {
    (columns.iter()).fold(case, |case, &column| {
        case.column_of("run.csv", column, |x| by * x)
    })
}

/// Multiplies the torques, and divides them by the gear ratios.
fn before_gears(case: Case, by: f64) -> Case {
    (TORQUES.iter().zip(GEARS)).fold(case, |case, (&column, gear)| {
        scaled(case, &[column], by / gear)
    })
}

const POSITIONS: [usize; 4] = [1, 2, 3, 4];
const TORQUES: [usize; 4] = [5, 6, 7, 8];
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

#[test]
fn a_wrist_that_turns_twice_is_no_degree() {
    let case = recorded();
    says_nothing(&case, &[]);
    // Without masses the URDF still has axes and lengths.
    says_nothing(&case, &["--set", "robot.nominal={}"]);
}

#[test]
fn degrees_are_refused_with_the_line_that_mends_them() {
    let case = scaled(recorded(), &POSITIONS, DEGREES);
    let line = "[log] motor_position_deg = [\"q1\", \"q2\", \"q3\", \"q4\"]";
    let words = "pan, lift, elbow and wrist: the positions are degrees, not radians";
    says(&case, ["error", "looks-like-degrees", words], line);
    let mended = case.replace("motor_position_rad", "motor_position_deg");
    says_nothing(&mended, &[]);
    let one = scaled(recorded(), &[2], DEGREES);
    let line = "[log] motor_position = [{ column = \"q1\", unit = \"rad\" }, { column = \"q2\", unit = \"deg\" }, \
                { column = \"q3\", unit = \"rad\" }, { column = \"q4\", unit = \"rad\" }]";
    let words = "lift: the positions are degrees";
    says(&one, ["error", "looks-like-degrees", words], line);
}

#[test]
fn radians_that_are_said_to_be_degrees_are_refused() {
    let case = recorded().replace("motor_position_rad", "motor_position_deg");
    let line = "[log] motor_position_rad = [\"q1\", \"q2\", \"q3\", \"q4\"]";
    let words = "the positions are radians, not degrees";
    says(&case, ["error", "looks-like-radians", words], line);
}

#[test]
fn torques_of_the_other_side_are_refused() {
    let case = before_gears(recorded(), 1.0);
    let line = "[log] motor_torque_side = \"motor\"";
    let words = "those of the motors before the gearbox";
    says(&case, ["error", "torque-scale", words], line);
    says_nothing(&case, &["--set", "log.motor_torque_side=motor"]);
    let twice = recorded().replace("time_s", "motor_torque_side = \"motor\"\ntime_s");
    let line = "[log] motor_torque_side = \"output\"";
    let words = "those after the gearbox already";
    says(&twice, ["error", "torque-scale", words], line);
}

#[test]
fn currents_and_other_units_of_torques_are_named() {
    let constants = |text: &str| {
        recorded().replace(
            "transmission = \"rigid\"",
            &format!("transmission = \"rigid\"\n{text}"),
        )
    };
    // The constant holds for the motor, and the file states that it contains the gear ratio.
    let case = scaled(
        constants("torque_constant_side = \"output\"\ntorque_constant_nm_per_a = 0.1")
            .replace("motor_torque_nm", "motor_current_a"),
        &TORQUES,
        10.0,
    );
    let case = before_gears(case, 1.0);
    let line = "[[robot.joint]] torque_constant_side = \"motor\"";
    says(&case, ["error", "torque-scale", "before the gearbox"], line);
    let case = scaled(recorded(), &TORQUES, 1e3);
    let line = "[log] motor_torque = { column = [\"tau1\", \"tau2\", \"tau3\", \"tau4\"], unit = \"mN·m\" }";
    says(&case, ["error", "torque-scale", "millinewton metres"], line);
    let case = scaled(constants("torque_constant_nm_per_a = 8.0"), &TORQUES, 0.125);
    let line =
        "[log] motor_current = { column = [\"tau1\", \"tau2\", \"tau3\", \"tau4\"], unit = \"A\" }";
    says(&case, ["serious", "torque-scale", "currents"], line);
    // A factor that nothing explains.
    let case = scaled(recorded(), &TORQUES, 0.2);
    let words = "similar in all joints";
    says(&case, ["warning", "torque-scale", words], "");
}

#[test]
fn the_masses_tell_the_side_of_a_torque_constant() {
    let constant = |value: f64| {
        let key = format!("transmission = \"rigid\"\ntorque_constant_nm_per_a = {value:?}");
        recorded()
            .replace("transmission = \"rigid\"", &key)
            .replace("motor_torque_nm", "motor_current_a")
    };
    let amperes = || before_gears(constant(0.1), 10.0);
    let found = amperes();
    let given = amperes().replace(
        "[log]",
        "[robot.joint_defaults]\ntorque_constant_side = \"motor\"\n[log]",
    );
    for case in [&found, &given, &scaled(constant(8.0), &TORQUES, 0.125)] {
        case.identify(&[]).ends(0);
    }
    let side = |case: &Case| {
        let json = case.json("sprung-out/identification.json");
        (
            json["log"]["torque_constant_side"].clone(),
            json["results"][0]["parameters"].clone(),
        )
    };
    // The motors' constants, found and given, have the same result.
    assert_eq!(side(&found).0, "motor");
    assert_eq!(side(&given), (Value::Null, side(&found).1));
    let text = found.run("check", &[]).out;
    contains(
        &text,
        &[
            "torque-side-found",
            "torque_constant_side = \"motor\"",
            "hold for the motors",
        ],
    );
    // A simulation has no log that could determine the side.
    let out = found.at("again");
    found
        .run("simulate", &["--out", &out])
        .ends(2)
        .tells(&["pan: the gear ratio is not 1, and the side"]);
    // Without masses the log does not determine the side.
    let with_masses = found.read("arm.urdf");
    let parts = with_masses.split("<inertial>").map(|part| {
        part.split_once("</inertial>")
            .map_or(part, |(_, rest)| rest)
    });
    found.write("arm.urdf", parts.collect::<String>());
    let output = found.identify(&[]);
    let text = &output.err;
    println!("{text}");
    output.ends(2);
    contains(
        text,
        &[
            "pan: the side of torque_constant_nm_per_a",
            "N·m; if",
            "no nominal masses",
            "[robot.joint_defaults]",
        ],
    );
}

#[test]
fn masses_that_are_twice_too_large_alarm_nobody() {
    let case = recorded();
    case.write("arm.urdf", urdf(2.0, AXES));
    says_nothing(&case, &[]);
    case.write("arm.urdf", urdf(6.0, AXES));
    let words = "a lighter or heavier robot";
    says(&case, ["warning", "torque-scale", words], "");
}

/// Swaps two columns of the log.
fn swapped(case: Case, pairs: &[(usize, usize)]) -> Case {
    let text = case.read("run.csv");
    let mut rows = text.lines();
    let mut changed = format!("{}\n", rows.next().unwrap());
    for row in rows {
        let mut cells: Vec<&str> = row.split(',').collect();
        for &(a, b) in pairs {
            cells.swap(a, b);
        }
        writeln!(changed, "{}", cells.join(",")).unwrap();
    }
    case.write("run.csv", changed);
    case
}

#[test]
fn joints_in_the_order_of_the_alphabet_are_refused() {
    // Elbow, lift and pan, as a joint state of ROS lists them.
    let case = swapped(recorded(), &[(1, 3), (5, 7)]);
    let line = "[log] motor_position_rad = [\"q3\", \"q2\", \"q1\", \"q4\"]; motor_torque_nm = [\"tau3\", \"tau2\", \
                \"tau1\", \"tau4\"]";
    let words = "the columns of pan and elbow are swapped";
    says(&case, ["error", "swapped-joints", words], line);
    let mended = case
        .replace(
            "\"tau1\", \"tau2\", \"tau3\"",
            "\"tau3\", \"tau2\", \"tau1\"",
        )
        .replace("\"q1\", \"q2\", \"q3\"", "\"q3\", \"q2\", \"q1\"");
    says_nothing(&mended, &[]);
    let case = swapped(recorded(), &[(6, 7)]);
    let line = "[log] motor_torque_nm = [\"tau1\", \"tau3\", \"tau2\", \"tau4\"]";
    let words = "the torques of lift and elbow are swapped";
    says(&case, ["error", "swapped-joints", words], line);
}

#[test]
fn joints_with_the_nominal_values_of_each_other_are_swapped() {
    let demo = || (Case::new()).replace("[identify]", "[identify]\non_check_error = \"go-on\"");
    let exchange = |case: Case, names: [&str; 2]| {
        let [one, two] = names.map(|name| format!("\"{name}\""));
        case.replace(&format!("[{one}, {two}]"), &format!("[{two}, {one}]"))
    };
    let pairs = [
        ["q1_rad", "q2_rad"],
        ["phi1_rad", "phi2_rad"],
        ["tau1_nm", "tau2_nm"],
    ];
    let (_, findings) = check(&pairs.into_iter().fold(demo(), exchange), &[]);
    assert_eq!(findings[0]["code"], "swapped-joints", "{findings:#?}");
    contains(
        str_of(&findings[0]["setting"]),
        &pairs
            .map(|[one, two]| format!("[\"{one}\", \"{two}\"]"))
            .each_ref()
            .map(String::as_str),
    );
    // Torques of other units are no swap.
    for by in [1000.0, 0.01] {
        let case = demo().replace(
            "[log]",
            &format!(
                "[log]\ngain = {{ \"tau1_nm\" = {by:?}, \"tau2_nm\" = {:?} }}",
                1.0 / by
            ),
        );
        let (_, findings) = check(&case, &[]);
        let codes: Vec<&str> = (findings.iter())
            .map(|finding| str_of(&finding["code"]))
            .collect();
        assert_eq!(codes, ["torque-scale"; 2], "{findings:#?}");
    }
}

#[test]
fn one_torque_in_another_unit_is_no_swap() {
    for (column, by, gain) in [(6, 100.0, "0.01"), (7, 1e3, "0.001"), (7, 0.01, "100")] {
        let case = scaled(recorded(), &[column], by);
        let line = format!("[log] gain = {{ \"tau{}\" = {gain} }}", column - 4);
        let (_, findings) = check(&case, &[]);
        assert_eq!(findings[0]["code"], "torque-scale", "{findings:#?}");
        let settings: Vec<&Value> = findings.iter().map(|finding| &finding["setting"]).collect();
        assert_eq!(settings[0].as_str(), Some(&*line), "{findings:#?}");
        let set = format!("log.gain={{tau{}={gain}}}", column - 4);
        says_nothing(&case, &["--set", &set]);
    }
}

#[test]
fn a_missing_gear_ratio_is_no_degrees() {
    let of_gears = |gears: [f64; 4]| {
        (POSITIONS.iter().zip(gears)).fold(recorded(), |case, (&column, gear)| {
            scaled(case, &[column], gear)
        })
    };
    let case = of_gears(GEARS);
    let line = "[log] motor_position_side = \"motor\"";
    let words = "the positions are those of the motors before the gearbox";
    says(&case, ["error", "motor-side-positions", words], line);
    says_nothing(&case, &["--set", "log.motor_position_side=motor"]);
}

#[test]
fn joints_that_turn_the_other_way_are_refused() {
    let case = scaled(recorded(), &[3, 7], -1.0);
    let line = "[log] sign = { \"q3\" = -1, \"tau3\" = -1 }";
    let words = "elbow: positive is the other direction";
    says(&case, ["error", "reversed-joint", words], line);
    says_nothing(&case, &["--set", "log.sign={q3=-1,tau3=-1}"]);
}

#[test]
fn the_description_of_another_robot_is_named() {
    let case = recorded();
    case.write("arm.urdf", urdf(1.0, ["0 0 1", "0 1 0"]));
    let (exit, findings) = check(&case, &[]);
    let found = (findings.iter()).find(|finding| finding["code"] == "other-robot");
    let found = found.unwrap_or_else(|| panic!("{findings:#?}"));
    println!("{}", found["text"]);
    assert_eq!((exit, &found["severity"]), (1, &Value::from("serious")));
    contains(str_of(&found["text"]), &["\"arm.urdf\""]);
    contains(str_of(&found["remedy"]), &["urdf = "]);
}

/// A wheel that turns several times and has no gravity.
fn wheel(nominal: &str) -> Case {
    let text = "format = 1
[robot]
name = \"wheel\"
dh_modified = [{}]
[robot.nominal]
\"link1.izz\" = 0.5
[[robot.joint]]
name = \"wheel\"
transmission = \"rigid\"
nominal = { rotor_inertia = 0.1, motor_viscous = 1.0, motor_coulomb = 1.0, motor_offset = 0.0 }
[log]
file = \"run.csv\"
time_s = \"t\"
motor_position_rad = [\"phi\"]
motor_torque_nm = [\"tau\"]
[identify]
estimator = \"least-squares\"
position_cutoff_hz = 40.0
[controller]
kind = \"pd\"
kp_nm_per_rad = [100.0]
kd_nms_per_rad = [5.0]
[controller.reference]
sines = [
  { joint = \"wheel\", amplitude_deg = 500.0, frequency_hz = 0.4, phase_deg = 90.0 },
  { joint = \"wheel\", amplitude_deg = 500.0, frequency_hz = 0.1, phase_deg = -90.0 },
]
[simulate]
duration_s = 10.0
period_s = 0.001
torque_noise_nm = [0.05]
";
    let case = Case::of(&[("experiment.toml", text)]);
    case.record("run.csv", &[]);
    if nominal.is_empty() {
        return case;
    }
    case.replace("\"link1.izz\" = 0.5\n", "").replace(
        "nominal = { rotor_inertia = 0.1, motor_viscous = 1.0, motor_coulomb = 1.0, motor_offset = 0.0 }",
        nominal,
    )
}

#[test]
fn nominal_values_tell_the_unit_of_a_wheel() {
    says_nothing(&wheel(""), &[]);
    let case = scaled(wheel(""), &[1], DEGREES);
    let line = "[log] motor_position_deg = [\"phi\"]";
    let words = "57.3 is expected for degrees";
    says(&case, ["error", "looks-like-degrees", words], line);
    // Without nominal values and gravity only the speed shows it: a question without a line.
    let case = wheel("# no nominal values");
    says_nothing(&case, &[]);
    let case = scaled(case, &[1], DEGREES);
    says(&case, ["warning", "looks-like-degrees", "rad/s"], "");
}

#[test]
fn a_slope_gives_the_right_gear_ratio() {
    // The motor has gears of 100.7, and the file contains 51.
    let case = scaled(arm::recorded(), &[2], 100.7)
        .replace("time_s", "motor_position_side = \"motor\"\ntime_s")
        .replace(
            "link_friction = [\"viscous\"]",
            "gear_ratio = 51.0\nlink_friction = [\"viscous\"]",
        );
    let (exit, findings) = check(&case, &[]);
    let found = (findings.iter()).find(|finding| finding["code"] == "slope-not-one");
    let setting = found.unwrap()["setting"].as_str().unwrap();
    let ratio: f64 = (setting.split("gear_ratio = ").nth(1).unwrap())
        .parse()
        .unwrap();
    println!("{setting}");
    // The spring changes the slope by some percent.
    assert!((ratio / 100.7 - 1.0).abs() < 0.1, "{setting}");
    assert_eq!(exit, 3);
}
