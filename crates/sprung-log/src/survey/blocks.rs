//! Quantities of columns without names: blocks of one column for each joint, such as positions, velocities, torques.

use super::families::{Family, Place, shown};
use super::period::ratio;
use super::read::Survey;
use super::slopes::similarity;
use super::words::{Meaning, Sort};

/// Smallest squared correlation of two positions of one joint.
const OF_ONE_JOINT: f64 = 0.9;

/// Largest ratio of the sampling periods by two joints.
const SAME_PERIOD: f64 = 1.05;

/// Most blocks.
const MAX_BLOCKS: usize = 8;

/// Returns the families of a table without names whose columns are blocks; `None` if no division into blocks fits.
///
/// - `joints`: number of joints, if it is known.
///
/// A velocity is the derivative of a position. One block must be neither position nor derivative: that of the torques.
pub(super) fn blocks(survey: &Survey, joints: Option<usize>) -> Option<Vec<Family>> {
    let [source] = &survey.sources[..] else {
        return None;
    };
    if survey.has_names || source.topic.is_some() {
        return None;
    }
    let is_clock = |c: &usize| {
        let figures = &source.columns[*c].figures;
        figures.rises && figures.even
    };
    let all: Vec<Place> = (0..source.columns.len())
        .filter(|c| !is_clock(c))
        .map(|c| (0, c))
        .collect();
    let counts = match joints {
        Some(joints) => joints..=joints,
        None => 1..=all.len(),
    };
    counts
        .filter(|&joints| joints > 0 && all.len().is_multiple_of(joints))
        .map(|joints| (joints, all.len() / joints))
        .filter(|(_, blocks)| (3..=MAX_BLOCKS).contains(blocks))
        .flat_map(|(joints, blocks)| {
            let by_quantity = all.chunks(joints).map(<[Place]>::to_vec).collect();
            let by_joint =
                (0..blocks).map(|b| all.iter().copied().skip(b).step_by(blocks).collect());
            [by_quantity, by_joint.collect()]
        })
        .find_map(|blocks: Vec<Vec<Place>>| families(survey, &blocks))
}

fn families(survey: &Survey, blocks: &[Vec<Place>]) -> Option<Vec<Family>> {
    let is_derivative =
        |b: usize| (0..blocks.len()).any(|a| a != b && is_rate(survey, &blocks[a], &blocks[b]));
    let rates: Vec<bool> = (0..blocks.len()).map(is_derivative).collect();
    let has_rate =
        |a: usize| (0..blocks.len()).any(|b| rates[b] && is_rate(survey, &blocks[a], &blocks[b]));
    let first = (0..blocks.len()).find(|&a| !rates[a] && has_rate(a))?;
    let is_position = |b: usize| is_same_joint(survey, &blocks[first], &blocks[b]);
    let sort = |b: usize| match (rates[b], is_position(b)) {
        (true, _) if is_rate(survey, &blocks[first], &blocks[b]) => Sort::Velocity,
        (true, _) => Sort::Other,
        (false, true) => Sort::Position,
        (false, false) => Sort::Torque,
    };
    let sorts: Vec<Sort> = (0..blocks.len()).map(sort).collect();
    let torques = sorts.iter().filter(|sort| **sort == Sort::Torque).count();
    (torques == 1).then(|| {
        (blocks.iter().zip(sorts))
            .map(|(columns, sort)| Family {
                name: shown(survey, columns.iter().copied()),
                joints_by: Some("the blocks of the columns, which their contents show"),
                meaning: Meaning {
                    sort: Some(sort),
                    ..Meaning::of(&[], &[])
                },
                by_recorder: None,
                of: columns.iter().copied().map(Some).collect(),
                problem: None,
                columns: columns.clone(),
            })
            .collect()
    })
}

/// Returns whether the columns of a block are the derivatives of those of another, with one sampling period.
fn is_rate(survey: &Survey, positions: &[Place], velocities: &[Place]) -> bool {
    let pairs = positions.iter().zip(velocities);
    let periods: Option<Vec<f64>> = pairs
        .map(|(&position, &velocity)| ratio(survey, position, velocity))
        .collect();
    periods.is_some_and(|periods| {
        let largest = periods.iter().copied().fold(0.0, f64::max);
        periods.iter().all(|period| largest < SAME_PERIOD * period)
    })
}

/// Returns whether each column of a block is a position of the joint of the same column of another.
fn is_same_joint(survey: &Survey, one: &[Place], two: &[Place]) -> bool {
    let mut pairs = one.iter().zip(two);
    pairs.all(|(&one, &two)| one == two || similarity(survey, one, two) >= OF_ONE_JOINT)
}
