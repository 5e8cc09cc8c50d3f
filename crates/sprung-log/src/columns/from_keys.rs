//! Makes channels from the keys of a description, signal by signal.

use std::collections::BTreeMap;

use super::channel::{Channel, ChannelError};
use super::origin::{Origin, Pick, Start, Stream};
use crate::description::{
    Columns, Factor, Instrument, Joint, Joints, Key, KeyUnit, LinkPosition, Log, PerJoint,
    Quantity, Robot, Scaling, Seen, Side, Signal, Unit,
};

/// Returns the channels of some signals that a description names, signal by signal, joint by joint.
///
/// # Errors
///
/// [`ChannelError`] if a joint lacks a signal or a signal cannot be converted.
pub(super) fn channels(
    signals: &[Signal],
    robot: &Robot,
    log: &Log,
) -> Result<Vec<Channel>, ChannelError> {
    let mut all = Vec::new();
    for &signal in signals {
        let mut channels = Vec::new();
        if robot.joint.iter().any(Joint::is_on_link_side) {
            all.extend(of_links(signal, robot, log)?);
            continue;
        }
        for (key, columns) in log.given().filter(|(key, _)| key.signal() == signal) {
            let joints = key.joints_in(log, Joints::ThatHaveIt, robot);
            channels.extend(of_key(key, columns, &joints, key.scaling, (robot, log))?);
        }
        if signal == Signal::Motor && channels.is_empty() {
            channels = lone_positions(robot, log)?;
        }
        complete((robot, log), signal, &channels)?;
        all.extend(channels);
    }
    Ok(all)
}

/// Returns the motor positions of a rigid robot whose only positions are declared as link
/// positions.
fn lone_positions(robot: &Robot, log: &Log) -> Result<Vec<Channel>, ChannelError> {
    let mut all = Vec::new();
    if robot.has_springs() {
        return Ok(all);
    }
    for (key, columns) in log.given() {
        if key.quantity == Quantity::LinkPosition {
            let joints = key.joints_in(log, Joints::Rigid, robot);
            let scaling = Scaling::PositionSide;
            all.extend(of_key(key, columns, &joints, scaling, (robot, log))?);
        }
    }
    Ok(as_positions_of_motors(all, log))
}

/// Returns link positions that take the place of motor positions.
fn as_positions_of_motors(mut channels: Vec<Channel>, log: &Log) -> Vec<Channel> {
    for channel in &mut channels {
        channel.quantity = Quantity::MotorPosition;
        if log.delay_s.estimates_all() {
            channel.delay = None;
        }
    }
    channels
}

/// Returns the channels of a signal of a robot on whose links alone a log is taken: positions of links and torques of
/// springs in the places of positions and torques of motors.
fn of_links(signal: Signal, robot: &Robot, log: &Log) -> Result<Vec<Channel>, ChannelError> {
    let source = match signal {
        Signal::Motor => Signal::Link,
        Signal::Torque => Signal::Spring,
        Signal::Link | Signal::Spring | Signal::Inertial(..) => return Ok(Vec::new()),
        Signal::Target | Signal::Switch | Signal::Covariate(_) => signal,
    };
    let mut all = Vec::new();
    for (key, columns) in log.given().filter(|(key, _)| key.signal() == source) {
        let joints = key.joints_in(log, Joints::ThatHaveIt, robot);
        all.extend(of_key(key, columns, &joints, key.scaling, (robot, log))?);
    }
    complete((robot, log), signal, &all)?;
    if signal == Signal::Torque {
        for channel in &mut all {
            channel.quantity = Quantity::MotorTorque;
        }
    }
    Ok(match signal {
        Signal::Motor => as_positions_of_motors(all, log),
        _ => all,
    })
}

/// Returns the channels of a key's columns.
///
/// - `joints`: the joints to which the key applies.
fn of_key(
    key: &Key,
    columns: &Columns,
    joints: &[usize],
    scaling: Scaling,
    (robot, log): (&Robot, &Log),
) -> Result<Vec<Channel>, ChannelError> {
    let mut all = Vec::new();
    let unit = match key.unit {
        KeyUnit::InName(size) => size,
        KeyUnit::Said { .. } => 1.0,
    };
    for (k, &joint) in joints.iter().enumerate() {
        if robot.joint[joint].seen == Seen::WithoutSpring && key.signal().is_of_flexible_joints() {
            continue;
        }
        let name = &robot.joint[joint].name;
        let Some(mut channel) = channel(key, columns, (k, joints.len()), name, log) else {
            continue;
        };
        channel.joint = joint;
        channel.gear_ratio = robot.joint[joint].gear_ratio;
        channel.before_gear = match scaling {
            Scaling::TorqueConstant | Scaling::AmplifierGain => {
                channel.open_side = robot.is_torque_side_open(joint);
                robot.joint[joint].side_of_constant() == Side::Motor
            }
            Scaling::None | Scaling::PositionSide | Scaling::TorqueSide => {
                log.side(scaling) == Some(Side::Motor)
            }
        };
        channel.factor *= unit * scale(scaling, &robot.joint[joint], log)?;
        all.push(channel);
    }
    Ok(all)
}

/// Returns the factor from the recorded quantity to the quantity on the output side.
fn scale(scaling: Scaling, joint: &Joint, log: &Log) -> Result<f64, ChannelError> {
    let on_motor = log.side(scaling) == Some(Side::Motor);
    let converted = |factor: Option<f64>, unit| {
        factor.ok_or_else(|| ChannelError::NoConstant {
            joint: joint.name.clone(),
            key: match joint.torque_constant_nm_per_a {
                None => "torque_constant_nm_per_a",
                Some(_) => "amplifier_gain_a_per_v",
            },
            unit,
        })
    };
    match scaling {
        Scaling::PositionSide if on_motor => Ok(1.0 / joint.ratio()),
        Scaling::TorqueSide if on_motor => Ok(joint.ratio()),
        Scaling::None | Scaling::PositionSide | Scaling::TorqueSide => Ok(1.0),
        Scaling::TorqueConstant => converted(joint.torque_per_ampere(), "currents"),
        Scaling::AmplifierGain => converted(joint.torque_per_volt(), "voltages"),
    }
}

/// Returns the channel of the `k`th of `of` joints; `None` if the column has no entry for it.
fn channel(
    key: &Key,
    columns: &Columns,
    (k, of): (usize, usize),
    joint: &str,
    log: &Log,
) -> Option<Channel> {
    let (column, place) = columns.of(k)?;
    let spread = columns.spread().is_some();
    let default = key.default_field();
    let (label, common) = columns.labels(k, joint, default);
    let in_messages = (column.joint_names.as_ref())
        .and_then(|names| names.get(place))
        .map_or(joint, String::as_str);
    let pick = match (&column.topic, &column.column) {
        (Some(_), _) => {
            let field = (column.field.as_ref())
                .and_then(|field| field.get(place))
                .unwrap_or_else(|| default.to_owned());
            // A separate field for each joint holds one number.
            let is_separate = !spread || matches!(column.field, Some(PerJoint::Each(_)));
            let (index, of) = if is_separate { (0, 1) } else { (k, of) };
            Pick::Field {
                field,
                joint: in_messages.to_owned(),
                index,
                of,
            }
        }
        (None, name) => {
            let name = name.as_ref()?.get(place)?;
            Pick::named(&name, joint, k, of)
        }
    };
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
    // The motor positions are the reference.
    let may_be_open = matches!(key.signal(), Signal::Link | Signal::Spring | Signal::Torque);
    let delay = log.delay_s.of([&label, &common], may_be_open);
    Some(Channel {
        origin: Origin {
            stream: Stream::of(column),
            pick,
            offset: number(&column.offset).unwrap_or(0.0),
            wrap: number(&column.wrap),
            start: (column.starts_at_rad.as_ref())
                .and_then(|start| start.get(place))
                .map(|start| Start::new(&start, joint, k, of)),
        },
        column: label,
        quantity: key.quantity,
        joint: 0,
        factor,
        gear_ratio: None,
        before_gear: false,
        counts_per_turn: number(&column.counts_per_turn),
        delay,
        open_sign: sign == Factor::Estimate,
        open_gain: gain == Factor::Estimate,
        open_side: false,
    })
}

/// Checks that every joint that needs a signal has it.
fn complete(
    (robot, log): (&Robot, &Log),
    signal: Signal,
    all: &[Channel],
) -> Result<(), ChannelError> {
    let holds_for_all = matches!(signal, Signal::Covariate(_)) && all.len() == 1;
    let missing = (robot.joint.iter().enumerate())
        .filter(|(_, joint)| signal.is_needed_by(joint))
        .filter(|(i, _)| {
            signal != Signal::Link
                || Instrument::of(*i, log, robot).link_position() == LinkPosition::Column
        })
        .find(|(i, _)| {
            !all.iter()
                .any(|channel| channel.joint == *i || holds_for_all)
        });
    match missing {
        None => Ok(()),
        Some((_, joint)) if signal == Signal::Link => Err(ChannelError::NoLink {
            joint: joint.name.clone(),
            line: link_line(log),
        }),
        Some((i, _)) => Err(ChannelError::NotSaid {
            what: signal.words(),
            keys: signal.usual_keys(robot.kind(i)),
        }),
    }
}

/// Returns a line for link positions in the form of the line for the motor positions.
fn link_line(log: &Log) -> String {
    let motor = log.given().find(|(key, _)| key.signal() == Signal::Motor);
    let Some((key, columns)) = motor else {
        return "link_position_rad = [\"…\"]".to_owned();
    };
    let name = key.name.replace("motor_position", "link_position");
    let first = columns.0.first();
    match first.map(|column| (&column.topic, column.unit)) {
        Some((Some(_), unit)) => {
            let unit = unit.map_or("rad", Unit::name);
            format!("{name} = {{ topic = \"…\", unit = \"{unit}\" }}")
        }
        Some((None, Some(unit))) => {
            format!("{name} = {{ column = \"…\", unit = \"{}\" }}", unit.name())
        }
        _ => format!("{name} = [\"…\"]"),
    }
}
