//! Profiles of recorders: what they mean by names that say little or something else.

use super::words::{Meaning, Sort};

/// Side of the spring on which a quantity is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Motor,
    Link,
    /// The words of the name decide.
    Open,
}

/// What a recorder means by a name.
#[derive(Debug)]
struct Profile {
    /// Words of the name in their order; others may stand between them.
    words: &'static [&'static str],
    /// Words of other names of the log, one of which must be there; nothing if the words alone are clear.
    beside: &'static [&'static str],
    sort: Sort,
    side: Side,
    /// Whether it is commanded or computed.
    is_reference: bool,
    /// Its unit, if the recorder has one.
    unit: Option<&'static str>,
    /// The recorder and the quantity.
    why: &'static str,
}

const FRANKA: &str = "libfranka: tau_J is the torque sensor of the joint, behind the gearbox";
const FRANKA_STATES: &str =
    "franka_ros2: the efforts of the measured joint states are those of the torque sensors";
const HEBI: &str = "HEBI: the effort is that of the spring, behind the gearbox";
const KINOVA: &str = "Kortex of Kinova: the torque is that of the sensor of the joint";
const KINOVA_POSITION: &str = "Kortex of Kinova: positions are in degrees";
const LBR: &str = "KUKA LBR: the measured torque is that of the sensor of the joint";
const FRI: &str = "KUKA FRI: mp and mt are measured positions and torques of the joints, ip and ct commands, et external torques";
const ANYDRIVE: &str =
    "ANYdrive: gear is the motor behind its gearbox, joint is the link behind the spring";
const SENSOR: &str = "the name says a sensor of the torque of the joint";

const fn measured(
    words: &'static [&'static str],
    beside: &'static [&'static str],
    sort: Sort,
    side: Side,
    why: &'static str,
) -> Profile {
    Profile {
        words,
        beside,
        sort,
        side,
        is_reference: false,
        unit: None,
        why,
    }
}

const fn torque_sensor(
    words: &'static [&'static str],
    beside: &'static [&'static str],
    why: &'static str,
) -> Profile {
    measured(words, beside, Sort::JointTorque, Side::Link, why)
}

const fn command(
    words: &'static [&'static str],
    beside: &'static [&'static str],
    sort: Sort,
    why: &'static str,
) -> Profile {
    Profile {
        is_reference: true,
        ..measured(words, beside, sort, Side::Open, why)
    }
}

/// The profiles; the first that fits counts.
#[rustfmt::skip]
const PROFILES: &[Profile] = &[
    measured(&["dtau"], &[], Sort::Other, Side::Open, FRANKA),
    command(&["tau", "j", "d"], &[], Sort::Torque, FRANKA),
    torque_sensor(&["tau", "j"], &["hat", "dtau", "dtheta", "theta", "franka", "fr3", "panda", "ee"], FRANKA),
    torque_sensor(&["measured", "joint", "states", "effort"], &[], FRANKA_STATES),
    torque_sensor(&["measured", "joint", "state", "effort"], &[], FRANKA_STATES),
    torque_sensor(&["effort"], &["hebi", "hw"], HEBI),
    torque_sensor(&["actuators", "torque"], &["current"], KINOVA),
    torque_sensor(&["actuator", "torque"], &["kinova", "kortex", "gen"], KINOVA),
    Profile { unit: Some("deg"), ..measured(&["actuators", "position"], &["current"], Sort::Position, Side::Open, KINOVA_POSITION) },
    torque_sensor(&["measured", "torque"], &["lbr", "iiwa", "kuka", "external", "commanded"], LBR),
    torque_sensor(&["tau", "msr"], &[], LBR),
    measured(&["measured", "joint", "position"], &["lbr", "iiwa", "kuka"], Sort::Position, Side::Link, LBR),
    measured(&["mp"], &["mt", "ip"], Sort::Position, Side::Link, FRI),
    command(&["ip"], &["mp"], Sort::Position, FRI),
    torque_sensor(&["mt"], &["mp"], FRI),
    measured(&["et"], &["mp", "mt"], Sort::Other, Side::Open, FRI),
    command(&["ct"], &["mp", "mt"], Sort::Torque, FRI),
    measured(&["gear", "position"], &[], Sort::Position, Side::Motor, ANYDRIVE),
    measured(&["gear", "velocity"], &[], Sort::Velocity, Side::Motor, ANYDRIVE),
    measured(&["joint", "position"], &["gear"], Sort::Position, Side::Link, ANYDRIVE),
    torque_sensor(&["joint", "torque"], &["gear"], ANYDRIVE),
    torque_sensor(&["torque", "sensor"], &[], SENSOR),
    torque_sensor(&["sensor", "torque"], &[], SENSOR),
    torque_sensor(&["tau", "sensor"], &[], SENSOR),
    torque_sensor(&["sensor", "tau"], &[], SENSOR),
    torque_sensor(&["sensed", "torque"], &[], SENSOR),
    torque_sensor(&["torque", "sensed"], &[], SENSOR),
    torque_sensor(&["strain"], &[], SENSOR),
    torque_sensor(&["spring", "torque"], &[], SENSOR),
    torque_sensor(&["elastic", "torque"], &[], SENSOR),
    torque_sensor(&["link", "torque"], &[], SENSOR),
    torque_sensor(&["output", "torque"], &[], SENSOR),
];

/// Returns the meaning of a name by the profile of its recorder, and what the recorder means.
///
/// - `raw`: the name as it is written; `words`: its words; `log`: words of all names of the log.
pub(super) fn by_recorder(
    meaning: Meaning,
    (raw, words): (&str, &[&str]),
    log: &[String],
) -> (Meaning, Option<&'static str>) {
    let stands = |wanted: &&str| log.iter().any(|word| word == wanted);
    let fits = |profile: &&Profile| {
        let mut rest = words.iter();
        let in_order = profile
            .words
            .iter()
            .all(|wanted| rest.any(|word| word == wanted));
        in_order
            && (profile.beside.is_empty() || profile.beside.iter().any(stands))
            && !(profile.words == ["tau", "j"] && is_numbered_joint(raw))
    };
    // Words such as "commanded" or "ext" beside those of a sensor say that it is none.
    let profile = PROFILES.iter().find(fits);
    let Some(profile) = profile.filter(|profile| profile.is_reference || !meaning.is_reference)
    else {
        return (meaning, None);
    };
    let (motor, link) = match profile.side {
        Side::Motor => (2, 0),
        Side::Link => (0, 2),
        Side::Open => (meaning.motor, meaning.link),
    };
    let found = Meaning {
        sort: Some(profile.sort),
        motor,
        link,
        is_reference: profile.is_reference,
        is_computed: meaning.is_computed,
        is_input: false,
        unit: meaning.unit.or(profile.unit),
    };
    (found, Some(profile.why))
}

/// Returns whether the letter after `tau` numbers a joint, as in `tau_J1`; a list of libfranka is `tau_J[0]`.
fn is_numbered_joint(raw: &str) -> bool {
    let raw = raw.to_lowercase();
    let mut rest = raw.split("tau_j").skip(1);
    !raw.contains("tau_j") || rest.any(|after| after.starts_with(|c: char| c.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::words::{tokens, words};

    #[test]
    fn names_of_recorders_mean_what_their_makers_say() {
        use Sort::{Current, JointTorque, Other, Position, Torque, Velocity};
        // Names that the table does not contain: other joints, prefixes, and numbers from 0 and from 1.
        for (name, beside, sort, motor, link, is_reference) in [
            ("tau_J[0]", "theta[0]", JointTorque, 0, 2, false),
            (
                "robot/tau_J_7",
                "tau_ext_hat_filtered_7",
                JointTorque,
                0,
                2,
                false,
            ),
            ("tau_J1", "theta_J1", Torque, 0, 0, false),
            ("tau_J_d[3]", "theta[3]", Torque, 0, 0, true),
            ("dtau_J[3]", "theta[3]", Other, 0, 0, false),
            (
                "/fr3/measured_joint_states/effort[2]",
                "",
                JointTorque,
                0,
                2,
                false,
            ),
            ("/joint_states/effort[2]", "", Torque, 0, 0, false),
            ("left.effort[1]", "hw_rx_time", JointTorque, 0, 2, false),
            (
                "base.actuators[6].torque",
                "base.actuators[6].current_motor",
                JointTorque,
                0,
                2,
                false,
            ),
            ("base.actuators[6].current_motor", "", Current, 2, 0, false),
            ("cell/measured_torque_A7", "", Torque, 0, 0, false),
            (
                "measured_torque_A7",
                "/iiwa/state",
                JointTorque,
                0,
                2,
                false,
            ),
            ("commanded_torque_A7", "/iiwa/state", Torque, 0, 0, true),
            ("external_torque_A7", "/iiwa/state", Torque, 0, 0, true),
            ("axisTauMsr_3", "", JointTorque, 0, 2, false),
            ("mp7", "mt7", Position, 0, 2, false),
            ("ip7", "mp7", Position, 0, 0, true),
            ("mt0", "mp0", JointTorque, 0, 2, false),
            ("et0", "mp0", Other, 0, 0, false),
            ("/drives/RH_KFE/gear_position", "", Position, 2, 0, false),
            ("/drives/RH_KFE/gear_velocity", "", Velocity, 2, 0, false),
            (
                "/drives/RH_KFE/joint_position",
                "gear_position",
                Position,
                0,
                2,
                false,
            ),
            (
                "/drives/RH_KFE/joint_torque",
                "gear_position",
                JointTorque,
                0,
                2,
                false,
            ),
            ("joint_torque_3", "", Torque, 0, 0, false),
            ("elbow_torque_sensor", "", JointTorque, 0, 2, false),
            ("strainGauge2_Nm", "", JointTorque, 0, 2, false),
            ("torque_sensor_command_2", "", Torque, 0, 0, true),
        ] {
            let of = tokens(name);
            let of = words(&of);
            let log = tokens(&format!("{name} {beside}"));
            let log: Vec<String> = words(&log).into_iter().map(str::to_owned).collect();
            let meaning = Meaning::of(&tokens(name), &[]);
            let (found, _) = by_recorder(meaning, (name, &of), &log);
            let found = (found.sort, found.motor, found.link, found.is_reference);
            assert_eq!(
                found,
                (Some(sort), motor, link, is_reference),
                "{name} beside {beside}"
            );
        }
    }
}
