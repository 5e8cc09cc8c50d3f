//! Which columns are the torques, currents or voltages of the motors.

use super::families::Family;
use super::positions::{distinct, moves};
use super::read::Survey;
use super::words::Sort;

/// The torques of a log.
#[derive(Clone, Debug, Default)]
pub(super) struct Torques {
    /// Index of the family.
    pub(super) family: Option<usize>,
    pub(super) why: String,
}

/// Chooses the torques: measured torques before currents, currents before voltages and commands.
pub(super) fn torques(survey: &Survey, families: &[Family]) -> Torques {
    let ranks = [
        (Sort::Torque, false),
        (Sort::Current, false),
        (Sort::Torque, true),
        (Sort::Voltage, false),
        (Sort::Current, true),
        (Sort::Voltage, true),
    ];
    for (sort, is_reference) in ranks {
        let all: Vec<usize> = (0..families.len())
            .filter(|&k| families[k].meaning.sort == Some(sort))
            .filter(|&k| families[k].meaning.is_reference == is_reference)
            .filter(|&k| moves(survey, &families[k]))
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
        match chosen[..] {
            [] => {}
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
                    why,
                };
            }
            _ => {
                let names: Vec<String> = (chosen.iter())
                    .map(|&k| format!("\"{}\"", families[k].name))
                    .collect();
                return Torques {
                    family: None,
                    why: format!(
                        "FILL IN which columns are the torques of the motors: {}",
                        names.join(" or ")
                    ),
                };
            }
        }
    }
    Torques {
        family: None,
        why: "FILL IN the torques, currents or voltages of the motors: no column looks like them"
            .to_owned(),
    }
}
