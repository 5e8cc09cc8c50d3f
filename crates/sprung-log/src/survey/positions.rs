//! Assignment of positions to motors and links.

use super::families::{Family, Place};
use super::read::Survey;
use super::slopes::{Slope, slope};
use super::words::Sort;
use crate::description::Unit;

/// Slope from which on one of two positions is that before the gearbox.
const MIN_GEAR: f64 = 1.5;

/// Largest difference of two columns with the same readings, as a part of their range.
const MAX_DIFFERENCE_OF_SAME: f64 = 1e-9;

/// The positions of a log.
#[derive(Clone, Debug, Default)]
pub(super) struct Positions {
    /// Indices of the families.
    pub(super) motor: Option<usize>,
    pub(super) link: Option<usize>,
    pub(super) deflection: Option<usize>,
    /// Why these; or why the choice is not clear, with the candidates.
    pub(super) why: String,
    pub(super) is_open: bool,
    /// Whether the user must also fill in the link positions: the log has several positions.
    pub(super) are_links_open: bool,
}

/// Chooses the families of positions.
pub(super) fn positions(survey: &Survey, families: &[Family], torque: Option<usize>) -> Positions {
    let measured = |sort: Sort| -> Vec<usize> {
        (0..families.len())
            .filter(|&k| families[k].meaning.sort == Some(sort))
            .filter(|&k| !families[k].meaning.is_reference && moves(survey, &families[k]))
            .collect()
    };
    let candidates = distinct(survey, families, measured(Sort::Position));
    let deflection = match measured(Sort::Deflection)[..] {
        [one] => Some(one),
        _ => None,
    };
    let name = |k: usize| &families[k].name;
    match candidates[..] {
        [] => Positions {
            why: "FILL IN the motor positions: no column of the log looks like the positions of the joints"
                .to_owned(),
            is_open: true,
            ..Positions::default()
        },
        [one] => Positions {
            motor: Some(one),
            deflection,
            why: format!("\"{}\" are the only positions of the log", name(one)),
            ..Positions::default()
        },
        [first, second] => of_two(survey, families, (first, second), torque),
        _ => of_many(families, &candidates),
    }
}

/// Returns whether a family belongs to joints and some of its columns change.
pub(super) fn moves(survey: &Survey, family: &Family) -> bool {
    (family.of.iter().flatten())
        .any(|&(source, column)| !survey.sources[source].columns[column].figures.is_constant())
}

/// Leaves out families with the same readings as one before them.
pub(super) fn distinct(survey: &Survey, families: &[Family], all: Vec<usize>) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    for k in all {
        if !kept
            .iter()
            .any(|&other| same(survey, &families[k], &families[other]))
        {
            kept.push(k);
        }
    }
    kept
}

fn same(survey: &Survey, one: &Family, two: &Family) -> bool {
    let values = |(source, column): Place| &survey.sources[source].columns[column];
    one.of.iter().zip(&two.of).all(|pair| match pair {
        (Some(a), Some(b)) => {
            let (a, b) = (values(*a), values(*b));
            let limit = MAX_DIFFERENCE_OF_SAME * a.figures.range();
            a.values.len() == b.values.len()
                && (a.values.iter().zip(&b.values)).all(|(x, y)| (x - y).abs() <= limit)
        }
        (None, None) => true,
        _ => false,
    })
}

/// Evidence that a family belongs to the motors: above 0 for motors, below for links.
pub(super) fn side(family: &Family) -> i16 {
    i16::from(family.meaning.motor) - i16::from(family.meaning.link)
}

/// Returns the slopes of the first position over the second, of the joints that both have.
///
/// The slopes are in SI units if the names give the units.
pub(super) fn slopes(
    survey: &Survey,
    (one, two): (&Family, &Family),
    torque: Option<&Family>,
) -> Vec<Option<Slope>> {
    (one.of.iter().zip(&two.of).enumerate())
        .map(|(joint, places)| {
            let (Some(one), Some(two)) = places else {
                return None;
            };
            let torque = torque.and_then(|torque| torque.of[joint]);
            slope(survey, *one, *two, torque)
        })
        .collect()
}

/// Size of a unit in SI units.
pub(super) fn size(unit: Option<&str>) -> f64 {
    unit.and_then(|unit| Unit::try_from(unit.to_owned()).ok())
        .filter(|unit| !unit.is_counts())
        .map_or(1.0, Unit::size)
}

fn of_two(
    survey: &Survey,
    families: &[Family],
    (first, second): (usize, usize),
    torque: Option<usize>,
) -> Positions {
    let found = |motor: usize, link: usize, why: String| Positions {
        motor: Some(motor),
        link: Some(link),
        why,
        ..Positions::default()
    };
    let (one, two) = (&families[first], &families[second]);
    if side(one) != side(two) {
        let (motor, link) = if side(one) > side(two) {
            (first, second)
        } else {
            (second, first)
        };
        let why = format!(
            "By their names, \"{}\" are the motors and \"{}\" the links",
            families[motor].name, families[link].name
        );
        return found(motor, link, why);
    }
    let all = slopes(survey, (one, two), torque.map(|torque| &families[torque]));
    let units = size(one.meaning.unit) / size(two.meaning.unit);
    let gears: Vec<f64> = (all.iter().flatten())
        .map(|slope| (slope.value * units).abs())
        .collect();
    if !gears.is_empty() && gears.iter().all(|gear| *gear > MIN_GEAR) {
        let why = format!(
            "\"{}\" turn up to {:.3} times as far as \"{}\", so they are the motors",
            one.name,
            super::write::Short(gears.iter().copied().fold(0.0, f64::max)),
            two.name
        );
        return found(first, second, why);
    }
    if !gears.is_empty() && gears.iter().all(|gear| *gear < MIN_GEAR.recip()) {
        let least = gears.iter().copied().fold(f64::INFINITY, f64::min);
        let why = format!(
            "\"{}\" turn up to {:.3} times as far as \"{}\", so they are the motors",
            two.name,
            super::write::Short(least.recip()),
            one.name
        );
        return found(second, first, why);
    }
    Positions {
        why: format!(
            "FILL IN which positions are the motors and which the links: names and slopes do not tell \
             \"{}\" from \"{}\"",
            one.name, two.name
        ),
        is_open: true,
        are_links_open: true,
        ..Positions::default()
    }
}

fn of_many(families: &[Family], candidates: &[usize]) -> Positions {
    let clear = |is: &dyn Fn(&Family) -> bool| -> Option<usize> {
        let found: Vec<usize> = (candidates.iter().copied())
            .filter(|&k| is(&families[k]))
            .collect();
        match found[..] {
            [one] => Some(one),
            _ => None,
        }
    };
    let motor = clear(&|family| side(family) > 1).or_else(|| clear(&|family| side(family) > 0));
    let link = clear(&|family| side(family) < -1).or_else(|| clear(&|family| side(family) < 0));
    if let (Some(motor), Some(link)) = (motor, link) {
        return Positions {
            motor: Some(motor),
            link: Some(link),
            why: format!(
                "By their names, \"{}\" are the motors and \"{}\" the links",
                families[motor].name, families[link].name
            ),
            ..Positions::default()
        };
    }
    let names: Vec<String> = (candidates.iter())
        .map(|&k| format!("\"{}\"", families[k].name))
        .collect();
    Positions {
        why: format!(
            "FILL IN which positions are the motors and which the links: the log has {} positions of the \
             joints, {}",
            names.len(),
            names.join(", ")
        ),
        is_open: true,
        are_links_open: true,
        ..Positions::default()
    }
}
