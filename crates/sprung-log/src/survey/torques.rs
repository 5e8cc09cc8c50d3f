//! Which columns are the torques, currents or voltages of the motors.

use sprung_core::chain::JointKind;

use super::families::{Family, Place};
use super::positions::{distinct, moves};
use super::read::Survey;
use super::slopes::similarity;
use super::words::Sort;
use crate::description::JointOfStart;

/// The torques of a log.
#[derive(Clone, Debug, Default)]
pub(super) struct Torques {
    /// Index of the family.
    pub(super) family: Option<usize>,
    /// Index of the family of the joints of the other kind: forces beside torques or currents.
    pub(super) beside: Option<usize>,
    pub(super) why: String,
    /// Whether no column can be a torque of a motor.
    pub(super) are_absent: bool,
}

/// Smallest squared correlation of the torque of a motor with its current. Friction and inertia of the motor lie between
/// its current and the torque of a sensor behind the gearbox.
const FOLLOWS_CURRENT: f64 = 0.97;

/// Recognises the torques of joint torque sensors that their names do not tell: they stand beside currents, or beside
/// other torques, and do not follow the currents.
pub(super) fn with_sensors(survey: &Survey, mut families: Vec<Family>) -> Vec<Family> {
    let measured = |families: &[Family], sort: Sort| -> Vec<usize> {
        (0..families.len())
            .filter(|&k| families[k].meaning.sort == Some(sort) && families[k].problem.is_none())
            .filter(|&k| !families[k].meaning.is_reference && moves(survey, &families[k]))
            .collect()
    };
    let [current] = measured(&families, Sort::Current)[..] else {
        return families;
    };
    let torques = distinct(survey, &families, measured(&families, Sort::Torque));
    let follows = |k: usize| -> Option<bool> {
        let pairs = families[k].of.iter().zip(&families[current].of);
        let both: Vec<f64> = pairs
            .filter_map(|(torque, current)| Some(similarity(survey, (*torque)?, (*current)?)))
            .collect();
        let all = |is: fn(&f64) -> bool| !both.is_empty() && both.iter().all(is);
        if all(|r| *r >= FOLLOWS_CURRENT) {
            Some(true)
        } else if all(|r| *r < FOLLOWS_CURRENT) {
            Some(false)
        } else {
            None
        }
    };
    let of_sensor: Vec<usize> = (torques.iter().copied())
        .filter(|&k| families[k].meaning.motor <= families[k].meaning.link)
        .filter(|&k| follows(k) == Some(false))
        .collect();
    // Several such torques are not one of each joint.
    if let [one] = of_sensor[..] {
        let family = &mut families[one];
        family.meaning.sort = Some(Sort::JointTorque);
        family.by_recorder = Some(
            "they do not follow the motor currents beside them, so friction and inertia of the motors lie between",
        );
    }
    families
}

/// Returns the torques of joint torque sensors, if the log has one for each joint.
pub(super) fn joint_torques(survey: &Survey, families: &[Family]) -> Option<usize> {
    let all: Vec<usize> = (0..families.len())
        .filter(|&k| {
            families[k].meaning.sort == Some(Sort::JointTorque) && families[k].problem.is_none()
        })
        .filter(|&k| !families[k].meaning.is_reference && moves(survey, &families[k]))
        .collect();
    match distinct(survey, families, all)[..] {
        [one] => Some(one),
        _ => None,
    }
}

/// Part of the runs of equal values that have the usual length, if the values are held for it.
const USUAL_RUNS: f64 = 0.8;

/// Returns the number of samples for which a column keeps each value; `None` if it varies.
pub(super) fn held(survey: &Survey, (source, column): Place) -> Option<usize> {
    let source = &survey.sources[source];
    let values = &source.columns[column].values;
    let mut runs: Vec<usize> = Vec::new();
    for part in source.parts(values.len()) {
        let equal = values[part].chunk_by(|a, b| a.to_bits() == b.to_bits());
        let lengths: Vec<usize> = equal.map(<[f64]>::len).collect();
        // The first and the last value may have begun before the part, or end after it.
        runs.extend(lengths.iter().skip(1).take(lengths.len().saturating_sub(2)));
    }
    runs.sort_unstable();
    let usual = *runs.get(runs.len() / 2)?;
    let of_usual = runs.iter().filter(|run| **run == usual).count();
    (of_usual as f64 >= USUAL_RUNS * runs.len() as f64).then_some(usual)
}

/// Returns whether a torque has the unit of a force although its joints turn, or the other way round.
fn has_unit_of_other_kind(family: &Family, joints: &[JointOfStart]) -> bool {
    let other = match family.meaning.unit {
        Some("N" | "kN") => JointKind::Revolute,
        Some("N·m" | "mN·m") => JointKind::Prismatic,
        _ => return false,
    };
    let of_family = joints
        .iter()
        .zip(&family.of)
        .filter(|(_, place)| place.is_some());
    family.meaning.sort == Some(Sort::Torque)
        && of_family
            .map(|(joint, _)| joint)
            .all(|joint| joint.kind == other)
}

/// Returns the measured torques, currents or voltages of the joints of the other kind than those of a family, if one
/// family has them.
fn beside(
    survey: &Survey,
    (families, joints): (&[Family], &[JointOfStart]),
    one: usize,
) -> Option<usize> {
    let kind = |family: &Family| {
        let mut kinds = (joints.iter().zip(&family.of)).filter(|(_, place)| place.is_some());
        let first = kinds.next().map(|(joint, _)| joint.kind)?;
        kinds.all(|(joint, _)| joint.kind == first).then_some(first)
    };
    let of_one = kind(&families[one])?;
    let is_drive = |family: &Family| {
        let sort = family.meaning.sort;
        let is_torque =
            sort.is_some_and(|sort| matches!(sort, Sort::Torque | Sort::Current | Sort::Voltage));
        is_torque
            && !family.meaning.is_reference
            && !family.meaning.is_computed
            && !family.meaning.is_input
    };
    let all = (0..families.len()).filter(|&k| {
        let family = &families[k];
        is_drive(family) && moves(survey, family) && kind(family).is_some_and(|kind| kind != of_one)
    });
    match distinct(survey, families, all.collect())[..] {
        [other] => Some(other),
        _ => None,
    }
}

/// Chooses the torques: measured torques before currents, currents before voltages and commands.
pub(super) fn torques(survey: &Survey, families: &[Family], joints: &[JointOfStart]) -> Torques {
    let ranks = [
        (Sort::Torque, false),
        (Sort::Current, false),
        (Sort::Torque, true),
        (Sort::Voltage, false),
        (Sort::Current, true),
        (Sort::Voltage, true),
    ];
    // Beside torque sensors a command is not what moved the links: a controller adds to it.
    let has_sensors = joint_torques(survey, families).is_some();
    for (sort, is_reference) in ranks {
        if is_reference && has_sensors {
            continue;
        }
        let all: Vec<usize> = (0..families.len())
            .filter(|&k| families[k].meaning.sort == Some(sort))
            .filter(|&k| families[k].meaning.is_reference == is_reference)
            .filter(|&k| !families[k].meaning.is_computed)
            .filter(|&k| {
                moves(survey, &families[k]) && !has_unit_of_other_kind(&families[k], joints)
            })
            .collect();
        let all = distinct(survey, families, all);
        let of_motor: Vec<usize> = (all.iter().copied())
            .filter(|&k| families[k].meaning.motor > families[k].meaning.link)
            .collect();
        let chosen = if all.len() > 1 && of_motor.len() == 1 {
            &of_motor
        } else {
            &all
        };
        // Those of the other kind of joints are beside the first.
        let chosen = match chosen[..] {
            [first, second] if beside(survey, (families, joints), first) == Some(second) => {
                &chosen[..1]
            }
            _ => &chosen[..],
        };
        match chosen[..] {
            [] => {}
            [one] if families[one].meaning.is_input => {
                return Torques {
                    family: None,
                    beside: None,
                    are_absent: false,
                    why: format!(
                        "FILL IN what \"{}\" is: motor_torque_nm, or motor_current_a or drive_voltage_v in place of this \
                         key; the name says the input of the motor and no quantity",
                        families[one].name
                    ),
                };
            }
            [one] => {
                let why = if is_reference {
                    format!(
                        "\"{}\" are commands or computed; the log has no measured torques",
                        families[one].name
                    )
                } else {
                    String::new()
                };
                return Torques {
                    family: Some(one),
                    beside: beside(survey, (families, joints), one),
                    are_absent: false,
                    why,
                };
            }
            _ => {
                let names: Vec<String> = (chosen.iter())
                    .map(|&k| format!("\"{}\"", families[k].name))
                    .collect();
                return Torques {
                    family: None,
                    beside: None,
                    are_absent: false,
                    why: format!(
                        "FILL IN which columns are the torques of the motors: {}",
                        names.join(" or ")
                    ),
                };
            }
        }
    }
    let sensor = joint_torques(survey, families).map_or_else(String::new, |k| {
        format!(
            "; \"{}\" are the torques of sensors behind the gearbox, and friction and inertia of the motors lie between",
            families[k].name
        )
    });
    Torques {
        family: None,
        beside: None,
        why: format!(
            "FILL IN the torques, currents or voltages of the motors: no column looks like them{sensor}"
        ),
        are_absent: true,
    }
}
