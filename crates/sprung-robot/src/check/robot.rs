//! Checks of a robot: numbers in range, names that exist, keys that exclude each other.

use sprung_core::chain::JointKind;
use sprung_core::spatial::BODY_NAMES;

use super::fault::{Fault, fault};
use super::laws::laws;
use super::name::check_name;
use crate::input_limits::JOINTS;
use crate::known_words::nearest;
use crate::numbers::Shown;
use crate::robot::{Joint, Robot, Side};
use crate::types::ExperimentFile;

/// Largest length in a Denavit-Hartenberg table, m; larger numbers are probably millimetres.
const MAX_LINK_LENGTH_M: f64 = 100.0;

pub(crate) fn robot(file: &ExperimentFile) -> Result<(), Fault> {
    let robot = &file.robot;
    let joints = &robot.joint;
    for (name, value) in &robot.fixed {
        if !value.is_finite() {
            return Err(fault(
                &["robot", "fixed", name],
                format!("the fixed {name} must be finite"),
            ));
        }
    }
    if let Some((name, _)) = file.robot.nominal.iter().find(|(_, v)| !v.is_finite()) {
        return Err(fault(
            &["robot", "nominal", name],
            format!("the nominal {name} must be finite"),
        ));
    }
    for (i, joint) in joints.iter().enumerate() {
        let at = i.to_string();
        let path = |key| ["robot", "joint", &at, key].map(str::to_owned).to_vec();
        check_name(&joint.name, &["robot", "joint", &at, "name"])?;
        for (key, value) in joint.nominal.all() {
            if !value.is_finite() {
                return Err(fault(
                    &["robot", "joint", &at, "nominal", key],
                    format!("{}: the nominal {key} must be finite", joint.name),
                ));
            }
        }
        laws(joint, &at)?;
        if joints[..i].iter().any(|other| other.name == joint.name) {
            return Err(Fault {
                code: None,
                path: path("name"),
                message: format!("two joints are called \"{}\"", joint.name),
            });
        }
        let numbers = [
            ("torque_constant_nm_per_a", joint.torque_constant_nm_per_a),
            ("gear_ratio", joint.gear_ratio),
            ("amplifier_gain_a_per_v", joint.amplifier_gain_a_per_v),
            ("back_emf_vs_per_rad", joint.back_emf_vs_per_rad),
            ("amplifier_gain_v_per_v", joint.amplifier_gain_v_per_v),
        ];
        for (key, value) in numbers {
            if let Some(value) = value.filter(|v| !v.is_finite() || *v == 0.0) {
                return Err(Fault {
                    code: None,
                    path: path(key),
                    message: format!(
                        "{}: {key} = {} must be finite and not zero",
                        joint.name,
                        Shown(value)
                    ),
                });
            }
        }
        if !joint.position_offset_deg.is_finite() {
            return Err(Fault {
                code: None,
                path: path("position_offset_deg"),
                message: format!("{}: position_offset_deg must be finite", joint.name),
            });
        }
        if joint.position_offset_deg != 0.0 && robot.kind(i) == JointKind::Prismatic {
            return Err(Fault {
                code: None,
                path: path("position_offset_deg"),
                message: format!(
                    "{} is prismatic, and position_offset_deg is for revolute joints; remove it",
                    joint.name
                ),
            });
        }
        if joint.amplifier_limit_v.is_some() && joint.torque_per_volt().is_none() {
            return Err(Fault {
                code: None,
                path: path("amplifier_limit_v"),
                message: format!(
                    "{}: a voltage limit needs torque_constant_nm_per_a and amplifier_gain_a_per_v, or \
                     winding_resistance_ohm for a voltage drive",
                    joint.name
                ),
            });
        }
        positive(joint, &at)?;
        voltage_drive(robot, joint, &at)?;
        side_of_voltages(robot, i, &at)?;
    }
    zeros(robot)?;
    transmission(robot)
}

/// Checks that the side of a torque constant is given if no log determines it.
fn side_of_voltages(robot: &Robot, index: usize, at: &str) -> Result<(), Fault> {
    let joint = &robot.joint[index];
    let needed_by = if joint.back_emf_vs_per_rad.is_some() {
        "a voltage drive"
    } else if joint.amplifier_limit_v.is_some() {
        "a voltage limit"
    } else {
        return Ok(());
    };
    let Some(constant) =
        (joint.torque_constant_nm_per_a).filter(|_| robot.is_torque_side_open(index))
    else {
        return Ok(());
    };
    Err(fault(
        &["robot", "joint", at, "torque_constant_nm_per_a"],
        format!(
            "{}: {needed_by} needs torque_constant_side, because the gear ratio {} is not 1; \
             torque_constant_nm_per_a = {constant} is {constant} N·m/A at the output with \"output\", \
             and {:.4} N·m/A with \"motor\"",
            joint.name,
            joint.ratio(),
            constant * joint.ratio()
        ),
    ))
}

/// Checks the numbers of a joint that must be positive.
fn positive(joint: &Joint, at: &str) -> Result<(), Fault> {
    let values = [
        ("amplifier_limit_v", joint.amplifier_limit_v),
        ("winding_resistance_ohm", joint.winding_resistance_ohm),
        (
            "coulomb_sharpness_s_per_rad",
            joint.coulomb_sharpness_s_per_rad,
        ),
        (
            "stribeck_velocity_rad_per_s",
            joint.stribeck_velocity_rad_per_s,
        ),
        ("presliding_width_rad", joint.presliding_width_rad),
        ("hysteresis_width_rad", joint.hysteresis_width_rad),
        ("play_half_width_rad", joint.play_half_width_rad),
    ];
    for (key, value) in values {
        if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(Fault {
                code: None,
                path: ["robot", "joint", at, key].map(str::to_owned).to_vec(),
                message: format!("{}: {key} = {} must be positive", joint.name, Shown(value)),
            });
        }
    }
    Ok(())
}

/// Checks the constants of a voltage drive.
fn voltage_drive(robot: &Robot, joint: &Joint, at: &str) -> Result<(), Fault> {
    let name = &joint.name;
    let wrong = |key: &str, message: String| {
        Err(fault(
            &["robot", "joint", at, key],
            format!("{name}: {message}"),
        ))
    };
    let constants = (joint.winding_resistance_ohm, joint.back_emf_vs_per_rad);
    let (_, back_emf) = match constants {
        (None, None) if joint.amplifier_gain_v_per_v.is_some() => {
            return wrong(
                "amplifier_gain_v_per_v",
                "amplifier_gain_v_per_v belongs to a voltage drive; add winding_resistance_ohm and \
                 back_emf_vs_per_rad, or give amplifier_gain_a_per_v for an amplifier that controls \
                 the current"
                    .to_owned(),
            );
        }
        (None, None) => return Ok(()),
        (None, Some(_)) => {
            return wrong(
                "back_emf_vs_per_rad",
                "back_emf_vs_per_rad has no effect without the resistance of the winding; add \
                 winding_resistance_ohm"
                    .to_owned(),
            );
        }
        (Some(_), None) => {
            let same = (joint.torque_constant_nm_per_a)
                .map_or_else(String::new, |constant| format!(" = {constant}"));
            return wrong(
                "winding_resistance_ohm",
                format!(
                    "winding_resistance_ohm makes a voltage drive, which needs its back-EMF; add \
                     back_emf_vs_per_rad{same}, the torque constant in N·m/A, if the maker gives no \
                     other value"
                ),
            );
        }
        (Some(resistance), Some(back_emf)) => (resistance, back_emf),
    };
    if joint.amplifier_gain_a_per_v.is_some() {
        return wrong(
            "amplifier_gain_a_per_v",
            "amplifier_gain_a_per_v is that of an amplifier that controls the current, \
             winding_resistance_ohm that of one that applies a voltage; keep one"
                .to_owned(),
        );
    }
    let Some(constant) = joint.torque_constant_nm_per_a else {
        return wrong(
            "back_emf_vs_per_rad",
            "a voltage drive needs torque_constant_nm_per_a".to_owned(),
        );
    };
    if constant * back_emf < 0.0 {
        return wrong(
            "back_emf_vs_per_rad",
            format!(
                "back_emf_vs_per_rad = {back_emf} and torque_constant_nm_per_a = {constant} have \
                 opposite signs, so the back-EMF would accelerate the motor"
            ),
        );
    }
    if robot.transmission_matrix.is_some() && joint.side_of_constant() == Side::Output {
        return wrong(
            "back_emf_vs_per_rad",
            "with a transmission_matrix, the constants of a voltage drive hold for the motor; set \
             torque_constant_side = \"motor\""
                .to_owned(),
        );
    }
    Ok(())
}

/// Checks that `assume_zero` names inertial parameters of links that have no fixed value.
fn zeros(robot: &Robot) -> Result<(), Fault> {
    let links = robot.tree.iter().flat_map(|tree| &tree.links);
    let known: Vec<String> = links
        .flat_map(|link| BODY_NAMES.map(|name| format!("{link}.{name}")))
        .collect();
    for name in &robot.assume_zero {
        if !known.contains(name) {
            let near = nearest(name, known.iter().map(String::as_str));
            let hint = near.map_or_else(
                || format!("they are called {} and so on", known[..3].join(", ")),
                |near| format!("did you mean \"{near}\"?"),
            );
            return Err(fault(
                &["robot", "assume_zero"],
                format!("no link has the inertial parameter \"{name}\" to assume zero; {hint}"),
            ));
        }
        if let Some(value) = robot.fixed.get(name) {
            return Err(fault(
                &["robot", "fixed", name],
                format!(
                    "{name} is fixed to {} and assumed zero; keep one",
                    Shown(*value)
                ),
            ));
        }
    }
    Ok(())
}

/// Checks that exactly one key describes the kinematics.
pub(crate) fn kinematics(robot: &Robot) -> Result<(), Fault> {
    let rows =
        [&robot.dh_modified, &robot.dh_classic].map(|rows| rows.as_ref().map_or(0, Vec::len));
    let most = rows.into_iter().fold(robot.joint.len(), usize::max);
    if most > JOINTS {
        return Err(fault(
            &["robot"],
            format!(
                "the file describes {most} joints, and sprung reads at most {JOINTS}; write blocks for those that moved in the log"
            ),
        ));
    }
    let given: Vec<&str> = [
        ("kinematics", robot.kinematics.is_some()),
        ("urdf", robot.urdf.is_some()),
        ("dh_modified", robot.dh_modified.is_some()),
        ("dh_classic", robot.dh_classic.is_some()),
    ]
    .into_iter()
    .filter(|(_, given)| *given)
    .map(|(key, _)| key)
    .collect();
    match given[..] {
        [] => {
            return Err(fault(
                &["robot"],
                "[robot] does not describe its kinematics; give urdf, dh_modified, dh_classic, or \
                 kinematics = \"planar-2r\"",
            ));
        }
        [first, second, ..] => {
            return Err(fault(
                &["robot", second],
                format!("{first} and {second} both describe the kinematics; keep one"),
            ));
        }
        [_] => {}
    }
    let joints = robot.joint.len();
    if robot.kinematics.is_some() {
        if joints != 2 {
            return Err(fault(
                &["robot"],
                format!(
                    "kinematics \"planar-2r\" has 2 joints, the file has {joints}; write one \
                     [[robot.joint]] block for each"
                ),
            ));
        }
        if robot.gravity_m_per_s2.is_some() {
            return Err(fault(
                &["robot", "gravity_m_per_s2"],
                "kinematics \"planar-2r\" moves in a horizontal plane, in which gravity does no \
                 work; describe an arm under gravity by urdf or dh_modified",
            ));
        }
        if let Some(name) = robot.assume_zero.first() {
            return Err(fault(
                &["robot", "assume_zero"],
                format!(
                    "kinematics \"planar-2r\" has no parameter \"{name}\" to assume zero; its \
                     three link parameters already assume that link 2 is symmetric"
                ),
            ));
        }
    }
    tables(robot)?;
    match robot.gravity_m_per_s2 {
        Some(gravity) if !gravity.iter().all(|g| g.is_finite() && g.abs() < 1e3) => Err(fault(
            &["robot", "gravity_m_per_s2"],
            format!(
                "gravity_m_per_s2 = {gravity:?} must be three numbers below 1000 m/s², as in [0.0, \
                 0.0, -9.81]"
            ),
        )),
        _ => Ok(()),
    }
}

/// Checks the Denavit-Hartenberg tables.
fn tables(robot: &Robot) -> Result<(), Fault> {
    let joints = robot.joint.len();
    for (key, table) in [
        ("dh_modified", &robot.dh_modified),
        ("dh_classic", &robot.dh_classic),
    ] {
        let Some(table) = table else { continue };
        if table.is_empty() {
            return Err(fault(
                &["robot", key],
                format!(
                    "{key} has no rows; write one, and a [[robot.joint]] block, for each joint"
                ),
            ));
        }
        if table.len() != joints {
            return Err(fault(
                &["robot", key],
                format!(
                    "{key} has {} rows, the file has {joints} [[robot.joint]] blocks; write one for \
                     each row",
                    table.len()
                ),
            ));
        }
        for (i, row) in table.iter().enumerate() {
            let numbers = [row.alpha_deg, row.a_m, row.d_m, row.theta_deg];
            if numbers.iter().any(|x| !x.is_finite()) {
                return Err(fault(
                    &["robot", key, &i.to_string()],
                    format!("every number of row {} of {key} must be finite", i + 1),
                ));
            }
            let lengths = [("a_m", row.a_m), ("d_m", row.d_m)];
            if let Some((name, length)) = lengths.iter().find(|(_, x)| x.abs() > MAX_LINK_LENGTH_M)
            {
                return Err(fault(
                    &["robot", key, &i.to_string(), name],
                    format!(
                        "row {} of {key}: {name} = {length:?} is longer than {MAX_LINK_LENGTH_M} m; lengths \
                         are in metres",
                        i + 1
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Checks a coupled transmission.
fn transmission(robot: &Robot) -> Result<(), Fault> {
    let Some(matrix) = &robot.transmission_matrix else {
        return Ok(());
    };
    let path = ["robot", "transmission_matrix"];
    let n = robot.joint.len();
    if matrix.len() != n || matrix.iter().any(|row| row.len() != n) {
        return Err(fault(
            &path,
            format!(
                "transmission_matrix needs {n} rows of {n} numbers: motor turns per joint turn"
            ),
        ));
    }
    if matrix.iter().flatten().any(|x| !x.is_finite()) {
        return Err(fault(
            &path,
            "every number of transmission_matrix must be finite",
        ));
    }
    if let Some(i) = (0..n).find(|&i| matrix[i][i] == 0.0) {
        return Err(fault(
            &path,
            format!(
                "transmission_matrix: motor {} does not turn {} (the diagonal contains 0); \
                 order the motors as the joints that they turn most",
                i + 1,
                robot.joint[i].name
            ),
        ));
    }
    if determinant(matrix).abs() < 1e-12 {
        return Err(fault(
            &path,
            "transmission_matrix is singular: some motion of the joints turns no motor; check its \
             rows (motors) and columns (joints)",
        ));
    }
    if let Some(joint) = robot.joint.iter().find(|joint| joint.gear_ratio.is_some()) {
        return Err(fault(
            &path,
            format!(
                "{}: gear_ratio and transmission_matrix both give the gear ratio; keep the matrix",
                joint.name
            ),
        ));
    }
    for (motor, row) in matrix.iter().enumerate() {
        for (joint, ratio) in row.iter().enumerate() {
            let (a, b) = (&robot.joint[motor], &robot.joint[joint]);
            if *ratio != 0.0 && a.is_flexible() != b.is_flexible() {
                return Err(fault(
                    &path,
                    format!(
                        "{} is coupled to {}, but only one of them is flexible; give both the same \
                         transmission",
                        a.name, b.name
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Returns the determinant after division of each row by its largest number, by Gauss elimination
/// with row pivots.
fn determinant(matrix: &[Vec<f64>]) -> f64 {
    let scaled = |row: &Vec<f64>| -> Vec<f64> {
        let largest = row.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        row.iter().map(|x| x / largest).collect()
    };
    let mut rows: Vec<Vec<f64>> = matrix.iter().map(scaled).collect();
    let mut product = 1.0;
    for k in 0..rows.len() {
        let pivot = (k..rows.len())
            .max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))
            .unwrap_or(k);
        if pivot != k {
            rows.swap(k, pivot);
            product = -product;
        }
        let (above, below) = rows.split_at_mut(k + 1);
        let row = &above[k];
        product *= row[k];
        if row[k] == 0.0 {
            return 0.0;
        }
        for other in below {
            let factor = other[k] / row[k];
            for (x, y) in other.iter_mut().zip(row) {
                *x -= factor * y;
            }
        }
    }
    product
}
