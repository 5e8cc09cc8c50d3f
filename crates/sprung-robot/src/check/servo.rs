//! Checks of a position servo: its drive law, its robot and its logs.

use sprung_core::chain::JointKind;

use super::fault::{Fault, fault, refused};
use crate::capabilities::{Feature, together};
use crate::factor::Factor;
use crate::log::Log;
use crate::numbers::Shown;
use crate::quantities::{Key, Signal};
use crate::robot::Joint;
use crate::servo::ServoDrive;
use crate::types::ExperimentFile;

/// Longest period of a position loop, s.
const MAX_LOOP_PERIOD_S: f64 = 0.1;

/// Checks that targets and a drive law occur together, at a robot with one joint.
pub(super) fn check_servo(file: &ExperimentFile) -> Result<(), Fault> {
    let joints = &file.robot.joint;
    let Some(at) = joints.iter().position(|joint| joint.servo.is_some()) else {
        return without_servo(file);
    };
    let (joint, index) = (&joints[at], at.to_string());
    let path = ["robot", "joint", &index, "servo"];
    let with = |other: Feature, path: &[&str]| {
        together(Feature::Servo, &joint.name, other).map_err(|reason| refused(path, &reason))
    };
    if joints.len() > 1 {
        with(Feature::SeveralJoints, &path)?;
    }
    if joint.is_flexible() {
        with(Feature::FlexibleJoint, &path)?;
    }
    if file.robot.kind(at) != JointKind::Revolute {
        with(Feature::SlidingJoint, &path)?;
    }
    let elsewhere = [
        ("torque_constant_nm_per_a", joint.torque_constant_nm_per_a),
        ("amplifier_gain_a_per_v", joint.amplifier_gain_a_per_v),
        ("winding_resistance_ohm", joint.winding_resistance_ohm),
        ("back_emf_vs_per_rad", joint.back_emf_vs_per_rad),
        ("amplifier_gain_v_per_v", joint.amplifier_gain_v_per_v),
        ("amplifier_limit_v", joint.amplifier_limit_v),
    ];
    if let Some((key, _)) = elsewhere.iter().find(|(_, value)| value.is_some()) {
        return Err(fault(
            &["robot", "joint", &index, key],
            format!(
                "{}: {key} has no effect beside servo; its constants are torque_nm_per_v, \
                 torque_nm_per_a and back_emf_vs_per_rad of servo",
                joint.name
            ),
        ));
    }
    if joint.friction_covariates.is_some() {
        let path = ["robot", "joint", &index, "friction_covariates"];
        with(Feature::Covariates, &path)?;
    }
    if let Some(drive) = &joint.servo {
        drive_law(drive, joint, &path)?;
    }
    if let Some((table, name)) = file.log.as_ref().and_then(estimates) {
        with(Feature::OpenColumns, &["log", table, &name])?;
    }
    Ok(())
}

/// Returns the first delay, or sign or gain that is to be estimated: its table and its column.
fn estimates(log: &Log) -> Option<(&'static str, String)> {
    let open =
        |(name, factor): (&String, &Factor)| (*factor == Factor::Estimate).then(|| name.clone());
    let all = || (log.delay_s.estimates_all()).then(String::new);
    let tables = [
        ("delay_s", (log.delay_s.keys().next().cloned()).or_else(all)),
        ("sign", log.sign.iter().find_map(open)),
        ("gain", log.gain.iter().find_map(open)),
    ];
    tables
        .into_iter()
        .find_map(|(table, name)| Some((table, name?)))
}

/// Checks an experiment without servo: it has no targets.
fn without_servo(file: &ExperimentFile) -> Result<(), Fault> {
    let logs = file.validate.iter().filter_map(|run| run.log.as_ref());
    for log in file.log.iter().chain(logs) {
        if let Some(key) = Key::of(Signal::Target).find(|key| key.is_given(log)) {
            return Err(fault(
                &["log", key.name],
                format!(
                    "{} needs the drive law of the servo; add [robot.joint.servo] with \
                     gain_duty_per_rad and supply_v, or gain_a_per_rad",
                    key.name
                ),
            ));
        }
    }
    Ok(())
}

/// Checks the keys of a drive law.
fn drive_law(drive: &ServoDrive, joint: &Joint, path: &[&str; 4]) -> Result<(), Fault> {
    let wrong = |key: &str, message: String| {
        Err(fault(
            &[path, &[key][..]].concat(),
            format!("{}: {message}", joint.name),
        ))
    };
    let of_voltage = [
        ("damping_duty_s_per_rad", drive.damping_duty_s_per_rad),
        ("supply_v", drive.supply_v),
        ("duty_limit", drive.duty_limit),
        ("torque_nm_per_v", drive.torque_nm_per_v),
        ("back_emf_vs_per_rad", drive.back_emf_vs_per_rad),
    ];
    let of_current = [
        ("damping_as_per_rad", drive.damping_as_per_rad),
        ("current_limit_a", drive.current_limit_a),
        ("torque_nm_per_a", drive.torque_nm_per_a),
    ];
    let (gain, foreign) = match (drive.gain_duty_per_rad, drive.gain_a_per_rad) {
        (Some(_), Some(_)) => {
            return wrong(
                "gain_a_per_rad",
                "a servo has gain_duty_per_rad if it applies a voltage, or gain_a_per_rad if it \
                 controls the current; keep one"
                    .to_owned(),
            );
        }
        (None, None) => {
            return wrong(
                "gain_duty_per_rad",
                "servo needs the gain of its position loop; add gain_duty_per_rad, or \
                 gain_a_per_rad if it controls the current"
                    .to_owned(),
            );
        }
        (Some(_), None) => ("gain_duty_per_rad", &of_current[..]),
        (None, Some(_)) => ("gain_a_per_rad", &of_voltage[..]),
    };
    if let Some((key, _)) = foreign.iter().find(|(_, value)| value.is_some()) {
        return wrong(
            key,
            format!("{key} does not belong to a servo with {gain}; remove it"),
        );
    }
    if drive.applies_voltage() && drive.supply_v.is_none() {
        return wrong(
            "gain_duty_per_rad",
            "a duty cycle needs the supply voltage; add supply_v".to_owned(),
        );
    }
    let gains = [
        ("gain_duty_per_rad", drive.gain_duty_per_rad),
        ("gain_a_per_rad", drive.gain_a_per_rad),
    ];
    let positive = (of_voltage.iter().chain(&of_current).chain(&gains))
        .filter(|(key, _)| !key.starts_with("damping"));
    if let Some((key, value)) = positive.clone().find_map(|(key, value)| {
        let value = value.filter(|value| !(value.is_finite() && *value > 0.0))?;
        Some((key, value))
    }) {
        return wrong(key, format!("{key} = {} must be positive", Shown(value)));
    }
    let damping = [of_voltage[0], of_current[0]];
    if let Some((key, value)) = (damping.iter()).find_map(|(key, value)| {
        let value = value.filter(|value| !(value.is_finite() && *value >= 0.0))?;
        Some((key, value))
    }) {
        return wrong(
            key,
            format!("{key} = {} must be 0 or positive", Shown(value)),
        );
    }
    if let Some(limit) = drive.duty_limit.filter(|limit| *limit > 1.0) {
        return wrong(
            "duty_limit",
            format!("duty_limit = {} must be at most 1", Shown(limit)),
        );
    }
    match drive.loop_period_s {
        Some(period) if !(period > 0.0 && period <= MAX_LOOP_PERIOD_S) => wrong(
            "loop_period_s",
            format!(
                "loop_period_s = {} must be positive and at most {MAX_LOOP_PERIOD_S} s",
                Shown(period)
            ),
        ),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use sprung_testing::Messages;

    use crate::{Experiment, no_files, read};

    fn experiment(drive: &str, file: &str) -> Result<Experiment, String> {
        let text = format!(
            "format = 1\n[robot]\ndh_modified = [{{ alpha_deg = 90, theta_deg = -90 }}]\n\
             [[robot.joint]]\nname = \"servo\"\ntransmission = \"rigid\"\n{drive}\n\
             [log]\nfile = {file}\nperiod_s = 0.005\nmotor_target_rad = [\"target\"]\n\
             motor_position_rad = [\"position\"]\n"
        );
        read("experiment.toml", &text, &[], &mut no_files).map_err(|error| error.to_string())
    }

    #[test]
    fn a_servo_with_a_payload_is_read() {
        let found = experiment(
            "servo = { gain_duty_per_rad = 5.0, supply_v = 12.0 }",
            "[{ path = \"a.csv\", payload = { mass_kg = 0.5, com_m = [0.1, 0, 0] } }]",
        )
        .unwrap();
        let log = found.log.unwrap();
        let payload = log.file.unwrap()[0].payload.clone().unwrap();
        assert_eq!(payload.mass_kg, Some(0.5));
        assert!(
            found.robot.joint[0]
                .servo
                .as_ref()
                .unwrap()
                .applies_voltage()
        );
    }

    #[test]
    fn faults_name_the_key_and_the_remedy() {
        let file = "\"a.csv\"";
        let heavy = "[{ path = \"a.csv\", payload = { mass_kg = -1.0, com_m = [0.1, 0, 0] } }]";
        let servo = "servo = { gain_duty_per_rad = 5.0, supply_v = 12.0 }";
        let mut messages = Messages::new(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/messages/servo.txt"
        ));
        for drive in [
            "servo = { supply_v = 12.0 }",
            "servo = { gain_duty_per_rad = 5.0 }",
            "servo = { gain_a_per_rad = 5.0, supply_v = 12.0 }",
            "servo = { gain_duty_per_rad = 5.0, gain_a_per_rad = 5.0 }",
            "servo = { gain_duty_per_rad = -5.0, supply_v = 12.0 }",
            "servo = { gain_duty_per_rad = 5.0, supply_v = 12.0, duty_limit = 96.0 }",
            "servo = { gain_duty_per_rad = 5.0, supply_v = 12.0, loop_period_s = 5.0 }",
        ] {
            messages.note(drive, &experiment(drive, file).unwrap_err());
        }
        messages.note("no servo", &experiment("", file).unwrap_err());
        let constant = format!("{servo}\ntorque_constant_nm_per_a = 1.0");
        messages.note(
            "a torque constant",
            &experiment(&constant, file).unwrap_err(),
        );
        messages.note("a negative mass", &experiment(servo, heavy).unwrap_err());
        messages.compare();
    }
}
