//! The text of the template, from top to bottom.

use std::fmt::Write;

use sprung_core::chain::JointKind::{Prismatic, Revolute};

use super::decisions::{Chosen, ChosenJoint, ChosenLine};
use super::{Joint, Kinematics, Start};
use crate::foreign::escaped;
use crate::quantities::{InTemplate, KEYS};

/// Returns the text of an `experiment.toml` for a robot.
///
/// sprung accepts the text without changes. `FILL IN` marks the values that only the user knows.
/// Optional keys follow a `#` without a space, with an example and an explanation.
#[must_use]
pub fn template(robot: &Start) -> String {
    let mut text = HEADER.to_owned();
    kinematics(&mut text, robot);
    joints(&mut text, robot);
    log(&mut text, robot);
    text.push_str(IDENTIFY);
    text.push_str(VALIDATE);
    twin(&mut text, robot);
    // Strings are escaped already; a comment of TOML has no control characters.
    escaped(&text).into_owned()
}

const HEADER: &str = "\
# An experiment for your own robot: complete the parts marked FILL IN, then run `sprung identify` on
# the folder of this file. Keys end in their units. A key directly after a # is an example: remove
# the # to use it. `sprung schema` prints all keys, for completion in editors.
format = 1
";

/// Largest width of a line, in characters.
const WIDTH: usize = 100;

const IDENTIFY: &str = "
[identify]
#estimator = \"least-squares\"                # faster, without refinement; or a list of several
#filter_cutoff_rad_per_s = 30.0             # lambda: above the motion, below the noise
#position_cutoff_hz = 40.0                  # zero-phase, for positions; \"auto\" if absent
#weights = \"none\"                           # all samples have weight 1, as in the paper
#encoder_offset = \"none\"                    # no offset between encoders; \"estimate\" if absent
";

const VALIDATE: &str = "
# The runs on which `sprung validate` tests the identified model.
[[validate]]
name = \"same log\"                           # without a log: the log of [log]

# A second log tests the prediction of the model. Its columns are those of [log] by default.
#[[validate]]
#name = \"second log\"
#log = { file = \"second.csv\" }
";

fn kinematics(text: &mut String, robot: &Start) {
    text.push_str("\n[robot]\n");
    line(
        text,
        &format!("name = {}", quoted(&robot.name)),
        "for reports",
    );
    match &robot.kinematics {
        Kinematics::Urdf(file) => {
            let comment = "relative to this file, or absolute";
            line(text, &format!("urdf = {}", quoted(file)), comment);
        }
        Kinematics::Table => table(text, robot.joints.len()),
    }
    text.push_str(
        "
# Acceleration of free fall in the base frame: [0.0, 0.0, 9.81] if the robot hangs from a ceiling,
# along another axis if its base is on a wall.
gravity_m_per_s2 = [0.0, 0.0, -9.81]

# Inertial parameters that are zero by symmetry, and known values. sprung does not estimate them.
",
    );
    let blocks = robot.blocks();
    if let Some((joint, _)) = blocks.last() {
        let zero = quoted(&format!("{}.my", joint.link));
        let known = quoted(&format!("{}.stiffness", joint.name));
        let value = joint.example().stiffness;
        line(text, &format!("#assume_zero = [{zero}]"), "");
        line(text, &format!("#fixed = {{ {known} = {value} }}"), "");
    }
    if blocks.len() > 1 {
        text.push_str(
            "
# A coupled transmission, instead of gear_ratio: motor turns per joint turn, a row per motor and a
# column per joint. In this example of two joints, the second motor turns with both joints:
#transmission_matrix = [[100.0, 0.0], [50.0, 100.0]]
",
        );
    }
}

fn table(text: &mut String, joints: usize) {
    text.push_str(
        "
# FILL IN the modified Denavit-Hartenberg table (Craig): row i contains twist and length of the link
# before joint i, then offset and angle of joint i. The values of the example are an arm in a
# horizontal plane. A prismatic joint has prismatic = true; its columns are link_position_m,
# motor_position_m and motor_force_n. Instead of this table, dh_classic or urdf = \"FILE\" describe
# the robot.
dh_modified = \"FILL IN\"
#dh_modified = [
",
    );
    for i in 1..=joints {
        let length = if i == 1 { "0.0" } else { "0.3" };
        let row = format!(
            "#  {{ alpha_deg = 0.0, a_m = {length}, d_m = 0.0, theta_deg = 0.0 }},   # joint{i}\n"
        );
        text.push_str(&row);
    }
    text.push_str("#]\n");
}

fn joints(text: &mut String, robot: &Start) {
    text.push_str(match robot.kinematics {
        Kinematics::Urdf(_) if robot.chosen.is_some() => {
            "
# A block for each joint that is in the log, after the joint that carries it. A joint without a
# block is fixed at zero.
"
        }
        Kinematics::Urdf(_) => {
            "
# A block for each joint that moves in the log, after the joint that carries it. Remove the other
# blocks: a joint without a block is fixed at zero.
"
        }
        Kinematics::Table => "\n# A block for each row of the table.\n",
    });
    text.push_str(
        "\
# Friction laws: \"viscous\", \"coulomb\", \"offset\", \"stribeck\", \"viscous-asymmetric\",
# \"coulomb-asymmetric\", \"quadratic\", \"load\" and \"residual\". The examples show the default of
# a flexible joint. The default of a rigid joint is [] for the link, and \"viscous\", \"coulomb\",
# \"offset\" for the motor.
",
    );
    let left_out = robot.chosen.iter().flat_map(|chosen| &chosen.left_out);
    let left_out: Vec<&str> = left_out.map(String::as_str).collect();
    if !left_out.is_empty() {
        let shown = left_out[..left_out.len().min(MAX_LEFT_OUT)].join(", ");
        let more = match left_out.len().saturating_sub(MAX_LEFT_OUT) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        wrapped(
            text,
            &format!("Not in the log, so fixed at zero: {shown}{more}"),
        );
    }
    let grippers = robot.chosen.iter().flat_map(|chosen| &chosen.grippers);
    for (name, why) in grippers {
        let sentence = format!(
            "Left out, so fixed at zero: {name}, a joint of a gripper {why}. A block for it identifies it as well"
        );
        wrapped(text, &sentence);
    }
    for sentence in robot.remarks() {
        wrapped(text, &sentence);
    }
    let blocks = robot.blocks();
    defaults(text, &blocks);
    for (joint, chosen) in &blocks {
        text.push('\n');
        let lines = chosen.iter().flat_map(|chosen| &chosen.lines);
        let separate: Vec<&ChosenLine> = lines
            .filter(|line| common(&blocks, &line.key).is_none())
            .collect();
        joint.write(text, &robot.kinematics, &separate);
    }
}

/// Most joints without a block that a comment names.
const MAX_LEFT_OUT: usize = 20;

/// Comments and example values for a kind of joint.
struct Example {
    stiffness: &'static str,
    gear: (&'static str, &'static str),
    constant: (&'static str, &'static str),
    sharpness: (&'static str, &'static str),
    nominal: &'static str,
    units: &'static str,
}

impl Joint {
    fn example(&self) -> Example {
        match self.kind {
            Revolute => Example {
                stiffness: "1000.0",
                gear: ("100.0", "motor turns per joint turn"),
                constant: ("0.1", "N·m/A, for logs of the current"),
                sharpness: ("100.0", "beta of tanh(beta v), s/rad; 100 if absent"),
                nominal: "stiffness = 1000.0, rotor_inertia = 0.1, motor_viscous = 1.0, \
                          motor_coulomb = 1.0",
                units: "N·m/rad, kg·m², N·m·s/rad, N·m",
            },
            Prismatic => Example {
                stiffness: "1e5",
                gear: ("600.0", "motor rad per m of travel"),
                constant: ("10.0", "N/A here, for logs of the current"),
                sharpness: ("1000.0", "beta of tanh(beta v), s/m here; 100 if absent"),
                nominal: "stiffness = 1e5, rotor_inertia = 10.0, motor_viscous = 100.0, \
                          motor_coulomb = 10.0",
                units: "N/m, kg, N·s/m, N",
            },
        }
    }

    /// Writes its block.
    ///
    /// - `chosen`: its lines that the defaults lack.
    fn write(&self, text: &mut String, kinematics: &Kinematics, chosen: &[&ChosenLine]) {
        let Example { nominal, units, .. } = self.example();
        let (origin, zero) = match kinematics {
            Kinematics::Urdf(_) => ("as in the URDF", "the URDF's zero"),
            Kinematics::Table => ("your choice", "the table's zero"),
        };
        text.push_str("[[robot.joint]]\n");
        line(text, &format!("name = {}", quoted(&self.name)), origin);
        if let Some(limits) = &self.limits {
            line(text, &format!("# The URDF allows {limits}."), "");
        }
        for chosen in chosen {
            chosen_line(text, chosen);
        }
        if self.kind == Revolute {
            let comment = format!("added to the log's positions to reach {zero}");
            line(text, "#position_offset_deg = 90.0", &comment);
        }
        let comment = format!("# Nominal values on the output side, {units}:");
        line(text, &comment, "");
        line(text, &format!("#nominal = {{ {nominal} }}"), "");
    }
}

/// Returns the chosen line with a key, if all blocks have the same one.
fn common<'a>(blocks: &[(&Joint, Option<&'a ChosenJoint>)], key: &str) -> Option<&'a ChosenLine> {
    let mut lines = blocks.iter().map(|(_, chosen)| chosen.as_ref()?.line(key));
    let first = lines.next()??;
    lines.all(|line| line == Some(first)).then_some(first)
}

/// Writes the keys of all joints.
fn defaults(text: &mut String, blocks: &[(&Joint, Option<&ChosenJoint>)]) {
    let Some((first, _)) = blocks.first() else {
        return;
    };
    let Example {
        gear,
        constant,
        sharpness,
        ..
    } = first.example();
    text.push_str(
        "
# Keys of all joints; a block below may give its own value.
[robot.joint_defaults]
",
    );
    let examples = [
        (
            "transmission = \"flexible\"".to_owned(),
            "a spring; \"rigid\": no spring",
        ),
        (format!("#gear_ratio = {}", gear.0), gear.1),
        (
            format!("#torque_constant_nm_per_a = {}", constant.0),
            constant.1,
        ),
        (
            "#torque_constant_side = \"motor\"".to_owned(),
            "\"output\": the constant includes gear_ratio",
        ),
        (
            format!("#coulomb_sharpness_s_per_rad = {}", sharpness.0),
            sharpness.1,
        ),
        (
            "#link_friction = [\"viscous\", \"coulomb\"]".to_owned(),
            "of the link's bearing; [] for no friction",
        ),
        (
            "#motor_friction = [\"viscous\", \"coulomb\"]".to_owned(),
            "of motor and gearbox",
        ),
    ];
    for (example, comment) in &examples {
        let key = example.trim_start_matches('#').split(' ').next();
        match key.and_then(|key| common(blocks, key)) {
            Some(chosen) => chosen_line(text, chosen),
            None => line(text, example, comment),
        }
    }
}

/// Writes the lines of `[log]` that were chosen by the log itself.
fn chosen_log(text: &mut String, chosen: &Chosen) {
    text.push_str(
        "
# `sprung new` chose these columns by their names and by what they hold. The comments say why.
# docs/reference/logs.md describes all forms. A part of a log: file = { path = \"log.csv\",
# from_s = 12.0, to_s = 60.0 }.
[log]
",
    );
    for line in &chosen.lines {
        chosen_line(text, line);
    }
    if chosen.line("torque").is_none() {
        hold(text, chosen.held.as_deref());
    }
    for remark in &chosen.remarks {
        text.push('\n');
        wrapped(text, remark);
    }
}

/// Writes the keys of the time for which a logged torque acts.
///
/// - `found`: what the log shows, as a sentence without its last full stop.
fn hold(text: &mut String, found: Option<&str>) {
    text.push('\n');
    let sentence =
        "If the controller held each logged torque for one of its periods, from its time stamp on";
    wrapped(
        text,
        &found.map_or_else(
            || sentence.to_owned(),
            |found| format!("{sentence}. {found}"),
        ),
    );
    line(
        text,
        "#torque = \"held\"",
        "\"mean\" or \"instantaneous\"; found if absent",
    );
    line(
        text,
        "#controller_period_s = 0.001",
        "that of the log if absent",
    );
}

fn chosen_line(text: &mut String, chosen: &ChosenLine) {
    if !chosen.why.is_empty() {
        wrapped(text, &chosen.why);
    }
    line(text, &format!("{} = {}", chosen.key, chosen.value), "");
}

/// Writes sentences as comments that fit a terminal.
///
/// - `sentences`: without the last full stop.
fn wrapped(text: &mut String, sentences: &str) {
    let mut width = WIDTH;
    for word in format!("{sentences}.").split_whitespace() {
        let length = word.chars().count();
        if width + 1 + length > WIDTH {
            if !text.is_empty() && !text.ends_with('\n') {
                text.push('\n');
            }
            text.push('#');
            width = 1;
        }
        text.push(' ');
        text.push_str(word);
        width += 1 + length;
    }
    text.push('\n');
}

fn log(text: &mut String, robot: &Start) {
    if let Some(chosen) = &robot.chosen {
        return chosen_log(text, chosen);
    }
    text.push_str(
        "
# FILL IN the log and its column names: in each list one per joint, in the order of the blocks. Link
# positions are those after the spring; a joint with transmission = \"rigid\" has no link position.
# Motor positions and torques are those after the gearbox. docs/reference/logs.md describes Parquet,
# Arrow, .npz, .mat, MCAP and .db3, other units, counts, and columns in several files. A part of a
# log: file = { path = \"log.csv\", from_s = 12.0, to_s = 60.0 }, or from_index and to_index.
# `sprung new` with --log LOG fills in these lines by itself.
[log]
",
    );
    let file = "relative to this file; or several: [\"1.csv\", \"2.csv\"]";
    line(text, "file = \"FILL IN\"", file);
    line(text, "time_s = \"t_s\"", "or time_ms, time_us, time_ns");
    for key in &KEYS {
        if let InTemplate::FillIn(stem) = key.template
            && let Some(columns) = robot.columns(key, stem)
        {
            line(text, &format!("{:18} = {columns}", key.name), "");
        }
    }
    text.push_str(
        "
# Alternatives: replace the line for the same signal. A deflection is link minus motor position; a
# current needs torque_constant_nm_per_a in every block.
",
    );
    for key in &KEYS {
        if let InTemplate::Instead(stem) = key.template
            && let Some(columns) = robot.columns(key, stem)
        {
            line(text, &format!("#{:19} = {columns}", key.name), "");
        }
    }
    let unit = match robot.joints.first().map(|joint| joint.kind) {
        Some(Prismatic) => "m",
        _ => "rad",
    };
    text.push_str(
        "
# If the motors were recorded before their gearboxes, with gear_ratio in every block:
#motor_position_side = \"motor\"
#motor_torque_side = \"motor\"

# For columns with reversed sign, and for columns that lag behind the others:
",
    );
    line(text, &format!("#sign = {{ phi1_{unit} = -1 }}"), "");
    let delay = format!("#delay_s = {{ q1_{unit} = 0.002 }}");
    line(text, &delay, "or \"estimate\"");
    hold(text, None);
}

fn twin(text: &mut String, robot: &Start) {
    text.push_str(
        "
# The controller that ran during the log, if known: `sprung validate` then simulates the loop.
",
    );
    line(text, "#[controller]", "");
    line(text, "#kind = \"pd\"", "on the motor positions");
    for (key, list) in [
        ("kp_nm_per_rad", robot.list("200.0", "2e4")),
        ("kd_nms_per_rad", robot.list("5.0", "500.0")),
    ] {
        line(text, &format!("#{key} = {list}"), "");
    }
    line(text, "#[controller.reference]", "of the motors");
    line(text, "#sines = [", "");
    for (i, (joint, _)) in robot.blocks().into_iter().enumerate() {
        let name = quoted(&joint.name);
        let (key, slow, fast) = match joint.kind {
            Revolute => ("amplitude_deg", "20.0", "5.0"),
            Prismatic => ("amplitude_m", "0.1", "0.02"),
        };
        // Different frequencies excite the joints independently.
        let step = (i % 8) as f64;
        for (amplitude, frequency) in [(slow, 0.2 + 0.05 * step), (fast, 1.0 + 0.1 * step)] {
            let sine = format!(
                "#  {{ joint = {name}, {key} = {amplitude}, frequency_hz = {frequency:.2} }},\n"
            );
            text.push_str(&sine);
        }
    }
    text.push_str(
        "#]

# The digital twin for `sprung simulate`. It needs the controller above, and nominal values of every
# inertia and stiffness. Encoder counts are per turn, or per m for a prismatic joint.
#[simulate]
#duration_s = 20.0
#period_s = 0.001
",
    );
    let counts = robot.list("16384", "1000000");
    for (key, list) in [
        ("link_encoder_counts_per_turn", &counts),
        ("motor_encoder_counts_per_turn", &counts),
        ("torque_noise_nm", &robot.list("0.05", "0.5")),
    ] {
        line(text, &format!("#{key} = {list}"), "");
    }
}

/// Column at which comments begin, from 0.
const COMMENT_COLUMN: usize = 44;

/// Writes a line with a comment; the comment goes on the line before if the content is long.
fn line(text: &mut String, content: &str, comment: &str) {
    // Writing to a string does not fail.
    let _ = match comment {
        "" => writeln!(text, "{content}"),
        _ if content.chars().count() < COMMENT_COLUMN => {
            writeln!(text, "{content:COMMENT_COLUMN$}# {comment}")
        }
        _ => writeln!(text, "# {comment}:\n{content}"),
    };
}

/// Returns a string in quotes, as TOML on one line.
#[must_use]
pub fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            _ if c.is_control() => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(c));
            }
            _ => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
