//! Checks of a column: its unit, its source, and lists with one value per joint.

use sprung_core::chain::JointKind;

use super::fault::{Fault, fault};
use crate::columns::{Column, Columns, PerJoint};
use crate::known_words::quoted;
use crate::numbers::Shown;
use crate::quantities::{KEYS, Key, KeyUnit};
use crate::robot::Robot;
use crate::units::Unit;

/// Checks the entries of a quantity's columns.
///
/// - `joints`: indices of the joints with this quantity.
pub(crate) fn check_columns(
    key: &Key,
    list: &Columns,
    joints: &[usize],
    path: &[&str],
    robot: &Robot,
) -> Result<(), Fault> {
    let spread = list.spread().is_some();
    for (i, column) in list.0.iter().enumerate() {
        let joints = if spread { joints } else { &joints[i..=i] };
        let place = i.to_string();
        let path = if list.0.len() > 1 {
            [path, &[&place]].concat()
        } else {
            path.to_vec()
        };
        check_source(key, column, &path)?;
        check_lists(key.name, column, joints.len(), &path)?;
        for &joint in joints {
            check_unit(key, column, robot.kind(joint), &path)?;
        }
        check_numbers(key, column, &path)?;
    }
    Ok(())
}

fn check_source(key: &Key, column: &Column, path: &[&str]) -> Result<(), Fault> {
    let (side_key, key) = (key.side_key(), key.name);
    let wrong = |message: String| Err(fault(path, message));
    match (&column.column, &column.topic) {
        (Some(_), Some(_)) => {
            return wrong(format!(
                "{key} names a column and a topic; files have columns, bags have topics"
            ));
        }
        (None, None) => {
            return wrong(format!(
                "{key} names neither a column nor a topic; add column = \"…\""
            ));
        }
        (Some(_), None) if column.field.is_some() || column.joint_names.is_some() => {
            return wrong(format!(
                "{key} names a field of messages but no topic; add topic = \"…\", or rename it to column"
            ));
        }
        _ => {}
    }
    let patterns = column.column.iter().any(|columns| match columns {
        PerJoint::One(_) => false,
        PerJoint::Each(list) => list.iter().any(crate::columns::ColumnName::is_pattern),
    });
    if patterns {
        return wrong(format!(
            "{key} has a list that contains a pattern; give the pattern alone, for all joints"
        ));
    }
    if column.side.is_some() && side_key.is_none() {
        let with_side = KEYS.iter().filter(|key| key.side_key().is_some());
        let with_side: Vec<&str> = with_side.map(|key| key.name).collect();
        return wrong(format!(
            "{key} must not have side; only {} may be recorded before the gearbox",
            with_side.join(" and ")
        ));
    }
    Ok(())
}

/// Checks that lists have one value per joint.
fn check_lists(key: &str, column: &Column, joints: usize, path: &[&str]) -> Result<(), Fault> {
    let names = column.joint_names.as_ref().map(Vec::len);
    for (inner, length) in [
        ("column", column.column.as_ref().and_then(PerJoint::count)),
        ("field", column.field.as_ref().and_then(PerJoint::count)),
        ("joint_names", names),
        (
            "counts_per_turn",
            column.counts_per_turn.as_ref().and_then(PerJoint::count),
        ),
        ("sign", column.sign.as_ref().and_then(PerJoint::count)),
        ("offset", column.offset.as_ref().and_then(PerJoint::count)),
        ("gain", column.gain.as_ref().and_then(PerJoint::count)),
        ("wrap", column.wrap.as_ref().and_then(PerJoint::count)),
        (
            "starts_at_rad",
            column.starts_at_rad.as_ref().and_then(PerJoint::count),
        ),
    ] {
        if let Some(length) = length
            && length != joints
        {
            return Err(fault(
                path,
                format!("{inner} of {key} has {length} entries for {joints} joints"),
            ));
        }
    }
    Ok(())
}

fn check_unit(key: &Key, column: &Column, kind: JointKind, path: &[&str]) -> Result<(), Fault> {
    let (unit_of_key, key) = (key.unit, key.name);
    let dimension = match unit_of_key {
        KeyUnit::InName(_) => {
            return match column.unit {
                None => Ok(()),
                Some(unit) => Err(fault(
                    path,
                    format!(
                        "{key} has its unit in its name, and also unit = \"{}\"; remove one of them",
                        unit.name()
                    ),
                )),
            };
        }
        KeyUnit::Said { turning, sliding } => match kind {
            JointKind::Revolute => turning,
            JointKind::Prismatic => sliding,
        },
    };
    let units = quoted(&Unit::names_of(dimension));
    match column.unit {
        None => Err(fault(
            path,
            format!("{key} has no unit; add unit = one of {units}"),
        )),
        Some(unit) if unit.dimension() != dimension => Err(fault(
            path,
            format!(
                "{key} cannot be measured in \"{}\"; its units are {units}",
                unit.name()
            ),
        )),
        Some(unit) if unit.is_counts() && column.counts_per_turn.is_none() => Err(fault(
            path,
            format!("{key} is in counts; add counts_per_turn = …"),
        )),
        Some(_) => Ok(()),
    }
}

/// Returns whether a number is allowed.
type IsAllowed = fn(f64) -> bool;

fn check_numbers(key: &Key, column: &Column, path: &[&str]) -> Result<(), Fault> {
    let (may_start_anywhere, key) = (key.may_start_anywhere(), key.name);
    let is_counts = column.unit.is_some_and(Unit::is_counts);
    if column.counts_per_turn.is_some() && !is_counts {
        return Err(fault(
            path,
            format!("{key} has counts_per_turn but is not in counts; add unit = \"counts\""),
        ));
    }
    if column.starts_at_rad.is_some() && !may_start_anywhere {
        return Err(fault(
            path,
            format!("{key} must not have starts_at_rad; only absolute angles may have it"),
        ));
    }
    let positive: IsAllowed = |value| value.is_finite() && value > 0.0;
    let checks: [(&str, &Option<PerJoint<f64>>, IsAllowed, &str); 5] = [
        (
            "counts_per_turn",
            &column.counts_per_turn,
            positive,
            "must be positive",
        ),
        ("wrap", &column.wrap, positive, "must be positive"),
        ("offset", &column.offset, f64::is_finite, "must be finite"),
        (
            "gain",
            &column.gain,
            |value| value.is_finite() && value != 0.0,
            "must be finite and not 0",
        ),
        (
            "sign",
            &column.sign,
            |value| value.abs().to_bits() == 1.0_f64.to_bits(),
            "must be 1 or -1",
        ),
    ];
    for (inner, values, is_allowed, must) in checks {
        let values = match values {
            None => continue,
            Some(PerJoint::One(value)) => std::slice::from_ref(value),
            Some(PerJoint::Each(values)) => values,
        };
        if let Some(value) = values.iter().find(|value| !is_allowed(**value)) {
            return Err(fault(
                path,
                format!("{inner} of {key} is {}; it {must}", Shown(*value)),
            ));
        }
    }
    Ok(())
}
