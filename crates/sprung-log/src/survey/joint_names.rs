//! Names of joints by the names of columns, for a robot that no file describes.

use std::collections::BTreeSet;

use super::read::Survey;
use super::words::{Meaning, Sort, tokens};

/// Signs at which a name is split into words that may be a quantity.
const SPLITS: [char; 7] = ['/', '.', '_', ' ', '-', '[', ']'];

/// Returns the names of the joints of a log whose columns are named by a joint and a quantity, as in `LF_HFE/position` or
/// `effort_elbow`; `None` for names with numbers, and if no position and torque name the same joint.
#[must_use]
pub fn joint_names(survey: &Survey) -> Option<Vec<String>> {
    let names = survey.all_names();
    [true, false]
        .into_iter()
        .find_map(|is_last| named(&names, is_last))
}

/// - `is_last`: whether the quantity stands behind the joint, or before it.
fn named(names: &[String], is_last: bool) -> Option<Vec<String>> {
    let mut joints: Vec<(String, Vec<Sort>)> = Vec::new();
    for (joint, sort) in names.iter().filter_map(|name| split(name, is_last)) {
        match joints.iter_mut().find(|(known, _)| *known == joint) {
            Some((_, sorts)) => sorts.push(sort),
            None => joints.push((joint, vec![sort])),
        }
    }
    let is_torque = |sort: &Sort| {
        matches!(
            sort,
            Sort::Torque | Sort::JointTorque | Sort::Current | Sort::Voltage
        )
    };
    let mut found: Vec<String> = (joints.into_iter())
        .filter(|(_, sorts)| sorts.contains(&Sort::Position) && sorts.iter().any(is_torque))
        .map(|(joint, _)| joint)
        .collect();
    // Parts that all names begin with belong to the robot.
    let of_robot = |names: &[String]| {
        let first = names.first()?.split_once('/')?.0.to_owned();
        let has = |name: &String| {
            name.split_once('/')
                .is_some_and(|(begin, _)| *begin == first)
        };
        names.iter().all(has).then_some(first.len() + 1)
    };
    while let Some(length) = of_robot(&found) {
        for name in &mut found {
            *name = name[length..].to_owned();
        }
    }
    let is_usual = |name: &String| {
        let mut letters = name.chars();
        letters.all(|c| c.is_alphabetic() || c == '_')
    };
    let unique: BTreeSet<&String> = found.iter().collect();
    let is_clear = unique.len() == found.len() && found.iter().all(is_usual);
    (is_clear && !found.is_empty()).then_some(found)
}

/// Splits a name into that of a joint and a quantity, which is the shortest end, or beginning, with a meaning.
fn split(name: &str, is_last: bool) -> Option<(String, Sort)> {
    let trimmed = |part: &str| part.trim_matches(SPLITS).to_owned();
    let mut rest = String::new();
    // In a path the joint is a whole part.
    let has_path = name.contains('/');
    let mut places: Vec<usize> = (name.char_indices())
        .filter(|(place, c)| {
            *place > 0
                && if has_path {
                    *c == '/'
                } else {
                    SPLITS.contains(c)
                }
        })
        .map(|(place, _)| place)
        .collect();
    if is_last {
        places.reverse();
    }
    let mut found = None;
    for place in places {
        let (begin, end) = name.split_at(place);
        let (joint, quantity) = if is_last { (begin, end) } else { (end, begin) };
        let sort = Meaning::of(&tokens(quantity), &[]).sort;
        let further = found.map_or(quantity, |(known, _): (&str, Sort)| {
            let added = quantity.len() - known.len();
            let (first, last) = if is_last {
                (0, added)
            } else {
                (known.len(), quantity.len())
            };
            &quantity[first..last]
        });
        // Words for the side belong to the quantity.
        if found.is_some() && !says_quantity(further) {
            break;
        }
        if let Some(sort) = sort {
            found = Some((quantity, sort));
            rest = trimmed(joint);
        }
    }
    let (_, sort) = found?;
    (!rest.is_empty() && sort != Sort::Time).then_some((rest, sort))
}

/// Returns whether a word says a quantity or a side.
fn says_quantity(word: &str) -> bool {
    let meaning = Meaning::of(&tokens(word), &[]);
    meaning.sort.is_some() || meaning.motor > 0 || meaning.link > 0 || meaning.is_reference
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_have_the_names_that_their_quantities_share() {
        let names = |list: &[&str]| {
            let all: Vec<String> = list.iter().map(|name| (*name).to_owned()).collect();
            [true, false].into_iter().find_map(|last| named(&all, last))
        };
        for (list, joints) in [
            (
                &[
                    "time",
                    "/drives/LF_HFE/gear_position",
                    "/drives/LF_HFE/current",
                    "/drives/LF_KFE/gear_position",
                    "/drives/LF_KFE/current",
                ][..],
                Some(vec!["LF_HFE", "LF_KFE"]),
            ),
            (
                &[
                    "t",
                    "position_pan",
                    "position_elbow",
                    "effort_pan",
                    "effort_elbow",
                ],
                Some(vec!["pan", "elbow"]),
            ),
            (&["t", "elbow_position", "wrist_effort"], None),
            (&["t", "position", "torque"], None),
        ] {
            let joints = joints.map(|all| all.into_iter().map(str::to_owned).collect());
            assert_eq!(names(list), joints, "{list:?}");
        }
    }
}
