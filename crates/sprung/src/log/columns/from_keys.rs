//! From the keys of a description to channels, quantity by quantity.

use std::collections::BTreeMap;

use sprung_core::chain::JointKind::{self, Prismatic, Revolute};

use super::channel::{Channel, ChannelError};
use super::origin::{Origin, Pick, Start, Stream, TimeOrigin};
use super::quantity::Quantity;
use crate::description::{
    Column, Columns, Factor, Joint, Log, PerJoint, Robot, SamplingTimes, Side, Unit,
};
use crate::log::clock::timing::Sampling;

/// Returns origin, stream and factor of the time.
pub(in crate::log) fn time(log: &Log) -> Option<(TimeOrigin, Option<Stream>, f64)> {
    let named = [
        (&log.time_s, 1.0),
        (&log.time_ms, 1e-3),
        (&log.time_us, 1e-6),
        (&log.time_ns, 1e-9),
    ];
    if let Some((name, factor)) = (named.into_iter()).find_map(|(key, f)| Some((key.as_ref()?, f)))
    {
        return Some((TimeOrigin::Column(name.clone()), None, factor));
    }
    let Some(column) = &log.time else {
        let period = log.period_s?;
        return Some((TimeOrigin::Period(period), None, 1.0));
    };
    let stream = stream(column);
    let stream = (stream != Stream::default()).then_some(stream);
    let factor = column.unit.map_or(1.0, Unit::size);
    match column.column.as_ref().and_then(|column| column.get(0)) {
        Some(name) => Some((TimeOrigin::Column(name), stream, factor)),
        None => Some((TimeOrigin::Messages, stream, 1.0)),
    }
}

/// Returns when samples were taken, if that is said.
pub(in crate::log) fn sampling(log: &Log) -> Option<Sampling> {
    match (log.period_s, log.sampling.unwrap_or_default()) {
        (Some(period), _) if log.has_time() => Some(Sampling::OnCycle(period)),
        (_, SamplingTimes::Auto) => None,
        (_, SamplingTimes::Even) => Some(Sampling::Even),
        (_, SamplingTimes::AsStamped) => Some(Sampling::AsStamped),
    }
}

fn stream(column: &Column) -> Stream {
    Stream {
        file: column.file.clone(),
        topic: column.topic.clone(),
        time: column.time.clone(),
    }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Columns of a quantity: their key, the kind of joints that they speak of,
/// and the unit in the key's name.
type Key<'a> = (
    &'static str,
    &'a Option<Columns>,
    Option<JointKind>,
    Quantity,
    f64,
);

/// Returns the channels of the joints of which some keys speak.
///
/// - `scale`: from what was recorded to what is on the output side.
fn channels(
    robot: &Robot,
    log: &Log,
    keys: &[Key<'_>],
    wanted: impl Fn(&Joint) -> bool,
    scale: impl Fn(&Joint) -> Result<f64, ChannelError>,
) -> Result<Vec<Channel>, ChannelError> {
    let mut all = Vec::new();
    for (key, columns, kind, quantity, unit) in keys {
        let Some(columns) = columns else { continue };
        let joints: Vec<usize> = (0..robot.joint.len())
            .filter(|&i| wanted(&robot.joint[i]) && kind.is_none_or(|kind| robot.kind(i) == kind))
            .collect();
        for (k, &joint) in joints.iter().enumerate() {
            let name = &robot.joint[joint].name;
            let Some(mut channel) = channel(key, columns, (k, joints.len()), name, log) else {
                continue;
            };
            channel.quantity = *quantity;
            channel.joint = joint;
            channel.factor *= unit * scale(&robot.joint[joint])?;
            all.push(channel);
        }
    }
    Ok(all)
}

/// Returns the channel of the `k`th of `of` joints, as far as its column says.
fn channel(
    key: &str,
    columns: &Columns,
    (k, of): (usize, usize),
    joint: &str,
    log: &Log,
) -> Option<Channel> {
    let (column, place) = columns.of(k)?;
    let spread = columns.spread().is_some();
    let default = crate::description::default_field(key);
    let common = columns.label(k, default);
    let in_messages = (column.joint_names.as_ref())
        .and_then(|names| names.get(place))
        .map_or(joint, String::as_str);
    let (pick, joint_in_label) = match (&column.topic, &column.column) {
        (Some(_), _) => {
            let field = (column.field.as_ref())
                .and_then(|field| field.get(place))
                .unwrap_or_else(|| default.to_owned());
            let whole = field.contains('[');
            // A field of its own for each joint holds one number.
            let own = !spread || matches!(column.field, Some(PerJoint::Each(_)));
            let (index, of) = if own { (0, 1) } else { (k, of) };
            let pick = Pick::Field {
                field,
                joint: in_messages.to_owned(),
                index,
                of,
            };
            (pick, (!whole).then_some(in_messages))
        }
        (None, name) => {
            let name = name.as_ref()?.get(place)?;
            let pattern = spread && name.is_pattern();
            (Pick::named(&name, joint, k, of), pattern.then_some(joint))
        }
    };
    let label = joint_in_label.map_or_else(|| common.clone(), |name| format!("{common}[{name}]"));
    let number = |values: &Option<PerJoint<f64>>| values.as_ref().and_then(|v| v.get(place));
    let unit = column.unit.map_or(1.0, Unit::size);
    let of_log = |factors: &BTreeMap<String, Factor>| {
        let factor = factors.get(&label).or_else(|| factors.get(&common));
        factor.copied().unwrap_or(Factor::Known(1.0))
    };
    let (sign, gain) = (of_log(&log.sign), of_log(&log.gain));
    let factor = unit / number(&column.counts_per_turn).unwrap_or(1.0)
        * number(&column.gain).unwrap_or(1.0)
        * number(&column.sign).unwrap_or(1.0)
        * sign.known().unwrap_or(1.0)
        * gain.known().unwrap_or(1.0);
    let delay = log.delay_s.get(&label).or_else(|| log.delay_s.get(&common));
    Some(Channel {
        origin: Origin {
            stream: stream(column),
            pick,
            offset: number(&column.offset).unwrap_or(0.0),
            wrap: number(&column.wrap),
            start: (column.starts_at_rad.as_ref())
                .and_then(|start| start.get(place))
                .map(|start| Start::new(&start, joint, k, of)),
        },
        column: label,
        quantity: Quantity::LinkPosition,
        joint: 0,
        factor,
        delay: delay.copied(),
        open_sign: sign == Factor::Estimate,
        open_gain: gain == Factor::Estimate,
    })
}

/// Returns the channels of the link positions.
pub(in crate::log) fn link(robot: &Robot, log: &Log) -> Result<Vec<Channel>, ChannelError> {
    use Quantity::{LinkDeflection, LinkPosition};
    let keys: [Key<'_>; 7] = [
        (
            "link_position_rad",
            &log.link_position_rad,
            Some(Revolute),
            LinkPosition,
            1.0,
        ),
        (
            "link_position_deg",
            &log.link_position_deg,
            Some(Revolute),
            LinkPosition,
            DEGREE,
        ),
        (
            "link_deflection_rad",
            &log.link_deflection_rad,
            Some(Revolute),
            LinkDeflection,
            1.0,
        ),
        (
            "link_deflection_deg",
            &log.link_deflection_deg,
            Some(Revolute),
            LinkDeflection,
            DEGREE,
        ),
        (
            "link_position_m",
            &log.link_position_m,
            Some(Prismatic),
            LinkPosition,
            1.0,
        ),
        ("link_position", &log.link_position, None, LinkPosition, 1.0),
        (
            "link_deflection",
            &log.link_deflection,
            None,
            LinkDeflection,
            1.0,
        ),
    ];
    let flexible = Joint::is_flexible;
    let all = channels(robot, log, &keys, flexible, |_| Ok(1.0))?;
    let keys = [
        "link_position_rad or link_deflection_rad",
        "link_position_m",
    ];
    complete(robot, flexible, &all, "the link positions", keys)?;
    Ok(all)
}

/// Returns the channels of the motor positions.
pub(in crate::log) fn motor(robot: &Robot, log: &Log) -> Result<Vec<Channel>, ChannelError> {
    use Quantity::MotorPosition;
    let scale = |joint: &Joint| match log.position_side().unwrap_or_default() {
        Side::Output => Ok(1.0),
        Side::Motor => Ok(1.0 / joint.ratio()),
    };
    let every = |_: &Joint| true;
    let keys: [Key<'_>; 4] = [
        (
            "motor_position_rad",
            &log.motor_position_rad,
            Some(Revolute),
            MotorPosition,
            1.0,
        ),
        (
            "motor_position_deg",
            &log.motor_position_deg,
            Some(Revolute),
            MotorPosition,
            DEGREE,
        ),
        (
            "motor_position_m",
            &log.motor_position_m,
            Some(Prismatic),
            MotorPosition,
            1.0,
        ),
        (
            "motor_position",
            &log.motor_position,
            None,
            MotorPosition,
            1.0,
        ),
    ];
    let mut all = channels(robot, log, &keys, every, scale)?;
    let rigid = robot.joint.iter().all(|joint| !joint.is_flexible());
    if rigid && all.is_empty() {
        // A rigid robot may call its only positions those of the links.
        let keys: [Key<'_>; 4] = [
            (
                "link_position_rad",
                &log.link_position_rad,
                Some(Revolute),
                MotorPosition,
                1.0,
            ),
            (
                "link_position_deg",
                &log.link_position_deg,
                Some(Revolute),
                MotorPosition,
                DEGREE,
            ),
            (
                "link_position_m",
                &log.link_position_m,
                Some(Prismatic),
                MotorPosition,
                1.0,
            ),
            (
                "link_position",
                &log.link_position,
                None,
                MotorPosition,
                1.0,
            ),
        ];
        all = channels(robot, log, &keys, every, scale)?;
    }
    let keys = ["motor_position_rad", "motor_position_m"];
    complete(robot, every, &all, "the motor positions", keys)?;
    Ok(all)
}

/// Returns the channels of the motor torques.
pub(in crate::log) fn torque(robot: &Robot, log: &Log) -> Result<Vec<Channel>, ChannelError> {
    use Quantity::MotorTorque;
    let converted = |unit, factor: fn(&Joint) -> Option<f64>| {
        move |joint: &Joint| {
            factor(joint).ok_or_else(|| ChannelError::NoConstant {
                joint: joint.name.clone(),
                key: match joint.torque_constant_nm_per_a {
                    None => "torque_constant_nm_per_a",
                    Some(_) => "amplifier_gain_a_per_v",
                },
                unit,
            })
        }
    };
    let every = |_: &Joint| true;
    let scale = |joint: &Joint| match log.torque_side().unwrap_or_default() {
        Side::Output => Ok(1.0),
        Side::Motor => Ok(joint.ratio()),
    };
    let torques: [Key<'_>; 3] = [
        (
            "motor_torque_nm",
            &log.motor_torque_nm,
            Some(Revolute),
            MotorTorque,
            1.0,
        ),
        (
            "motor_force_n",
            &log.motor_force_n,
            Some(Prismatic),
            MotorTorque,
            1.0,
        ),
        ("motor_torque", &log.motor_torque, None, MotorTorque, 1.0),
    ];
    let currents: [Key<'_>; 2] = [
        (
            "motor_current_a",
            &log.motor_current_a,
            None,
            MotorTorque,
            1.0,
        ),
        ("motor_current", &log.motor_current, None, MotorTorque, 1.0),
    ];
    let voltages: [Key<'_>; 2] = [
        (
            "drive_voltage_v",
            &log.drive_voltage_v,
            None,
            MotorTorque,
            1.0,
        ),
        ("drive_voltage", &log.drive_voltage, None, MotorTorque, 1.0),
    ];
    let mut all = channels(robot, log, &torques, every, scale)?;
    let of_ampere = converted("currents", Joint::torque_per_ampere);
    all.extend(channels(robot, log, &currents, every, of_ampere)?);
    let of_volt = converted("voltages", Joint::torque_per_volt);
    all.extend(channels(robot, log, &voltages, every, of_volt)?);
    let keys = [
        "motor_torque_nm, motor_current_a or drive_voltage_v",
        "motor_force_n",
    ];
    complete(robot, every, &all, "the motor torques", keys)?;
    Ok(all)
}

/// Checks that every joint that needs a column has one.
fn complete(
    robot: &Robot,
    wanted: impl Fn(&Joint) -> bool,
    all: &[Channel],
    what: &'static str,
    [turning, sliding]: [&'static str; 2],
) -> Result<(), ChannelError> {
    let missing = (robot.joint.iter().enumerate())
        .find(|(i, joint)| wanted(joint) && !all.iter().any(|channel| channel.joint == *i));
    match missing {
        None => Ok(()),
        Some((i, _)) => Err(ChannelError::NotSaid {
            what,
            keys: match robot.kind(i) {
                JointKind::Revolute => turning,
                JointKind::Prismatic => sliding,
            },
        }),
    }
}
