//! What types cannot say: lengths, signs, names that must exist.

use super::choice::{nearest, quoted};
use super::log::{Delay, Log};
use super::run::{Controller, ControllerKind, Simulate};
use super::types::ExperimentFile;

/// Longest delay of a channel, s.
const LONGEST_DELAY: f64 = 60.0;

/// A fault and the path of keys to it.
pub(super) struct Fault {
    pub(super) path: Vec<String>,
    pub(super) message: String,
}

fn fault(path: &[&str], message: impl Into<String>) -> Fault {
    Fault {
        path: path.iter().map(|&part| part.to_owned()).collect(),
        message: message.into(),
    }
}

/// Checks what the types do not say.
pub(super) fn check(file: &ExperimentFile) -> Result<(), Fault> {
    if file.format != 1 {
        return Err(fault(
            &["format"],
            format!(
                "format {} is not known; this version reads format 1",
                file.format
            ),
        ));
    }
    robot(file)?;
    identify(file)?;
    let joints: Vec<&str> = file.robot.joint.iter().map(|j| j.name.as_str()).collect();
    if let Some(log) = &file.log {
        check_log(log, &["log"], &joints)?;
    }
    for (i, run) in file.validate.iter().enumerate() {
        check_name(&run.name, &["validate", &i.to_string(), "name"])?;
        if file.validate[..i]
            .iter()
            .any(|other| other.name == run.name)
        {
            return Err(fault(
                &["validate", &i.to_string(), "name"],
                format!("two validation runs are called \"{}\"", run.name),
            ));
        }
    }
    if let Some(controller) = &file.controller {
        check_controller(controller, &["controller"], &joints)?;
    }
    for (i, run) in file.validate.iter().enumerate() {
        let i = i.to_string();
        if let Some(over) = &run.log {
            let log = file
                .log
                .as_ref()
                .map_or_else(|| over.clone(), |log| log.overlaid(over));
            check_log(&log, &["validate", &i, "log"], &joints)?;
        }
        if let Some(controller) = &run.controller {
            check_controller(controller, &["validate", &i, "controller"], &joints)?;
        }
    }
    if let Some(twin) = &file.simulate {
        check_twin(twin, &joints)?;
    }
    Ok(())
}

/// Names stand in files and in column titles.
fn check_name(name: &str, path: &[&str]) -> Result<(), Fault> {
    let allowed = |c: char| c.is_alphanumeric() || "_-. ".contains(c);
    if !name.trim().is_empty() && name.chars().all(allowed) {
        return Ok(());
    }
    Err(fault(
        path,
        format!(
            "the name \"{name}\" must consist of letters, digits, spaces, \"_\", \"-\" and \".\""
        ),
    ))
}

fn robot(file: &ExperimentFile) -> Result<(), Fault> {
    let joints = &file.robot.joint;
    if joints.len() != 2 {
        return Err(fault(
            &["robot"],
            format!(
                "kinematics \"planar-2r\" has 2 joints, the file has {}; write one [[robot.joint]] \
                 block for each",
                joints.len()
            ),
        ));
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
        let nominal = &joint.nominal;
        for (key, value) in [
            ("rotor_inertia", nominal.rotor_inertia),
            ("link_viscous", nominal.link_viscous),
            ("motor_viscous", nominal.motor_viscous),
            ("stiffness", nominal.stiffness),
            ("link_coulomb", nominal.link_coulomb),
            ("motor_coulomb", nominal.motor_coulomb),
        ] {
            if value.is_some_and(|v| !v.is_finite()) {
                return Err(fault(
                    &["robot", "joint", &at, "nominal", key],
                    format!("{}: the nominal {key} must be finite", joint.name),
                ));
            }
        }
        if joints[..i].iter().any(|other| other.name == joint.name) {
            return Err(Fault {
                path: path("name"),
                message: format!("two joints are called \"{}\"", joint.name),
            });
        }
        let numbers = [
            ("torque_constant_nm_per_a", joint.torque_constant_nm_per_a),
            ("gear_ratio", Some(joint.gear_ratio)),
            ("amplifier_gain_a_per_v", joint.amplifier_gain_a_per_v),
        ];
        for (key, value) in numbers {
            if value.is_some_and(|v| !v.is_finite() || v == 0.0) {
                return Err(Fault {
                    path: path(key),
                    message: format!("{}: {key} must be finite and not zero", joint.name),
                });
            }
        }
        if joint.amplifier_limit_v.is_some() && joint.torque_per_volt().is_none() {
            return Err(Fault {
                path: path("amplifier_limit_v"),
                message: format!(
                    "{}: a voltage limit needs torque_constant_nm_per_a and amplifier_gain_a_per_v",
                    joint.name
                ),
            });
        }
        let positive = [
            ("amplifier_limit_v", joint.amplifier_limit_v),
            (
                "coulomb_sharpness_s_per_rad",
                Some(joint.coulomb_sharpness_s_per_rad),
            ),
        ];
        for (key, value) in positive {
            if value.is_some_and(|v| !(v.is_finite() && v > 0.0)) {
                return Err(Fault {
                    path: path(key),
                    message: format!("{}: {key} must be positive", joint.name),
                });
            }
        }
    }
    Ok(())
}

fn identify(file: &ExperimentFile) -> Result<(), Fault> {
    let settings = &file.identify;
    if settings.estimator.is_empty() {
        return Err(fault(
            &["identify", "estimator"],
            "the list of estimators is empty",
        ));
    }
    for (i, one) in settings.estimator.iter().enumerate() {
        if settings.estimator[..i].contains(one) {
            return Err(fault(
                &["identify", "estimator"],
                format!("estimator \"{}\" is listed twice", one.name()),
            ));
        }
    }
    for (key, value) in [
        ("filter_cutoff_rad_per_s", settings.filter_cutoff_rad_per_s),
        ("position_cutoff_hz", settings.position_cutoff_hz),
        ("lsff_forgetting_per_s", settings.lsff_forgetting_per_s),
        ("lsff_initial_gain", settings.lsff_initial_gain),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(fault(
                &["identify", key],
                format!("{key} = {value} must be positive"),
            ));
        }
    }
    if !(1..=10).contains(&settings.position_filter_order) {
        return Err(fault(
            &["identify", "position_filter_order"],
            format!(
                "position_filter_order = {} must be between 1 and 10",
                settings.position_filter_order
            ),
        ));
    }
    check_window(
        settings.lsff_velocity_window,
        &["identify", "lsff_velocity_window"],
    )
}

fn check_window(window: [usize; 2], path: &[&str]) -> Result<(), Fault> {
    let limit = sprung_core::velocity::LONGEST_WINDOW;
    match window.iter().find(|&&p| p >= limit) {
        Some(p) => Err(fault(
            path,
            format!(
                "a velocity window of {p} is too long; the longest is {}",
                limit - 1
            ),
        )),
        None => Ok(()),
    }
}

fn check_log(log: &Log, path: &[&str], joints: &[&str]) -> Result<(), Fault> {
    let lists = [
        ("link_position_rad", &log.link_position_rad),
        ("link_position_deg", &log.link_position_deg),
        ("link_deflection_rad", &log.link_deflection_rad),
        ("link_deflection_deg", &log.link_deflection_deg),
        ("motor_position_rad", &log.motor_position_rad),
        ("motor_position_deg", &log.motor_position_deg),
        ("motor_torque_nm", &log.motor_torque_nm),
        ("motor_current_a", &log.motor_current_a),
        ("drive_voltage_v", &log.drive_voltage_v),
    ];
    let at = |key| [path, &[key]].concat();
    for (key, list) in lists {
        if let Some(list) = list
            && list.len() != joints.len()
        {
            return Err(fault(
                &at(key),
                format!(
                    "{key} names {} columns, the robot has {} joints ({})",
                    list.len(),
                    joints.len(),
                    joints.join(", ")
                ),
            ));
        }
    }
    if log.time_s.is_some() && log.time_ms.is_some() {
        return Err(fault(
            &at("time_ms"),
            "time_s and time_ms say the same thing twice; keep one",
        ));
    }
    for group in [&lists[0..4], &lists[4..6], &lists[6..9]] {
        let given: Vec<&str> = group
            .iter()
            .filter(|(_, list)| list.is_some())
            .map(|&(key, _)| key)
            .collect();
        if let [first, second, ..] = given[..] {
            return Err(fault(
                &at(second),
                format!("{first} and {second} say the same thing twice; keep one"),
            ));
        }
    }
    let columns: Vec<&str> = lists
        .iter()
        .filter_map(|(_, list)| list.as_ref())
        .flatten()
        .map(String::as_str)
        .collect();
    if let Some(twice) = (1..columns.len()).find(|&i| columns[..i].contains(&columns[i])) {
        return Err(fault(
            path,
            format!(
                "the column \"{}\" is named twice; each holds one quantity",
                columns[twice]
            ),
        ));
    }
    for (key, name) in (log.delay_s.keys().map(|name| ("delay_s", name)))
        .chain(log.sign.keys().map(|name| ("sign", name)))
    {
        if !columns.contains(&name.as_str()) {
            let hint = nearest(name, columns.iter().copied())
                .map_or_else(String::new, |known| format!("; did you mean \"{known}\"?"));
            return Err(fault(
                &[path, &[key, name]].concat(),
                format!("{key} speaks of \"{name}\", which is not a column of this log{hint}"),
            ));
        }
    }
    for (name, delay) in &log.delay_s {
        if let Delay::Known(value) = delay
            && (value.is_nan() || value.abs() > LONGEST_DELAY)
        {
            return Err(fault(
                &[path, &["delay_s", name]].concat(),
                format!(
                    "the delay of \"{name}\" is {value} s; it must be within ±{LONGEST_DELAY} s"
                ),
            ));
        }
    }
    for (name, sign) in &log.sign {
        if sign.abs().to_bits() != 1.0_f64.to_bits() {
            return Err(fault(
                &[path, &["sign", name]].concat(),
                format!("the sign of \"{name}\" is {sign}; it must be 1 or -1"),
            ));
        }
    }
    Ok(())
}

fn check_controller(controller: &Controller, path: &[&str], joints: &[&str]) -> Result<(), Fault> {
    let at = |key| [path, &[key]].concat();
    let n = joints.len();
    match controller.kind {
        ControllerKind::Pd => {
            for (key, list) in [
                ("kp_nm_per_rad", &controller.kp_nm_per_rad),
                ("kd_nms_per_rad", &controller.kd_nms_per_rad),
            ] {
                if list.len() != n {
                    return Err(fault(
                        &at(key),
                        format!("controller \"pd\" needs {n} numbers in {key}, one per joint"),
                    ));
                }
            }
        }
        ControllerKind::StateFeedback => {
            if controller.gain.len() != n || controller.gain.iter().any(|row| row.len() != 4 * n) {
                return Err(fault(
                    &at("gain"),
                    format!(
                        "controller \"state-feedback\" needs gain with {n} rows of {} numbers: on \
                         the errors of link positions, motor positions, link velocities and motor \
                         velocities",
                        4 * n
                    ),
                ));
            }
        }
    }
    let rows = controller.gain.iter().flatten();
    let gains = [
        (
            "kp_nm_per_rad",
            controller.kp_nm_per_rad.iter().all(|g| g.is_finite()),
        ),
        (
            "kd_nms_per_rad",
            controller.kd_nms_per_rad.iter().all(|g| g.is_finite()),
        ),
        ("gain", rows.copied().all(f64::is_finite)),
    ];
    if let Some((key, _)) = gains.iter().find(|(_, finite)| !finite) {
        return Err(fault(
            &at(key),
            format!("every number of {key} must be finite"),
        ));
    }
    check_window(controller.velocity_window, &at("velocity_window"))?;
    for (i, sine) in controller.reference.sines.iter().enumerate() {
        let i = i.to_string();
        let at = |key| [path, &["reference", "sines", &i, key]].concat();
        if !joints.contains(&sine.joint.as_str()) {
            let hint = nearest(&sine.joint, joints.iter().copied())
                .map_or_else(|| quoted(joints), |known| format!("\"{known}\""));
            return Err(fault(
                &at("joint"),
                format!(
                    "the robot has no joint \"{}\"; did you mean {hint}?",
                    sine.joint
                ),
            ));
        }
        for (key, value) in [
            ("amplitude_deg", sine.amplitude_deg),
            ("frequency_hz", sine.frequency_hz),
            ("phase_deg", sine.phase_deg),
        ] {
            if !value.is_finite() {
                return Err(fault(&at(key), format!("{key} must be finite")));
            }
        }
    }
    Ok(())
}

fn check_twin(twin: &Simulate, joints: &[&str]) -> Result<(), Fault> {
    for (key, value) in [
        ("duration_s", twin.duration_s),
        ("period_s", twin.period_s),
        ("torque_disturbance_hz", twin.torque_disturbance_hz),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(fault(
                &["simulate", key],
                format!("{key} = {value} must be positive"),
            ));
        }
    }
    if twin.duration_s / twin.period_s > 1e9 {
        return Err(fault(
            &["simulate", "duration_s"],
            "the log would have more than 1e9 samples",
        ));
    }
    let lengths = [
        (
            "link_encoder_counts_per_turn",
            twin.link_encoder_counts_per_turn.len(),
        ),
        (
            "motor_encoder_counts_per_turn",
            twin.motor_encoder_counts_per_turn.len(),
        ),
        ("torque_noise_nm", twin.torque_noise_nm.len()),
        ("torque_disturbance_nm", twin.torque_disturbance_nm.len()),
    ];
    for (key, length) in lengths {
        if length != 0 && length != joints.len() {
            return Err(fault(
                &["simulate", key],
                format!(
                    "{key} has {length} numbers, the robot has {} joints",
                    joints.len()
                ),
            ));
        }
    }
    for (key, list) in [
        ("torque_noise_nm", &twin.torque_noise_nm),
        ("torque_disturbance_nm", &twin.torque_disturbance_nm),
    ] {
        if let Some(value) = list.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
            return Err(fault(
                &["simulate", key],
                format!("{key} holds {value}; a standard deviation is zero or positive"),
            ));
        }
    }
    Ok(())
}
