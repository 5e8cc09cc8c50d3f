//! Joints of columns whose names contain a quantity and no joint: by the words that they share, by the slope between
//! two positions, and by the torque that a motion explains.

use std::collections::BTreeSet;

use super::families::{Family, Place, shown};
use super::positions::{moves, side};
use super::read::Survey;
use super::slopes::{explained_torque, similarity};
use super::words::{Meaning, Sort, Token, tokens};

/// Largest unexplained part with the best match, relative to the second best.
const CLEARLY_BETTER: f64 = 0.7;

/// Smallest squared correlation of two positions of one joint.
const OF_ONE_JOINT: f64 = 0.9;

/// Columns of one quantity without joints.
struct Group {
    meaning: Meaning,
    columns: Vec<Place>,
}

/// Joins families of one column each, whose names have neither joint nor number, to families with a column for each joint.
/// Returns all families.
///
/// - `joints`: number of joints of the robot.
pub(super) fn joined(survey: &Survey, families: Vec<Family>, joints: usize) -> Vec<Family> {
    if joints < 2 {
        return families;
    }
    let named = (families.iter())
        .filter(|family| family.problem.is_none() && is_measured_position(&family.meaning))
        .filter(|family| family.of.iter().all(Option::is_some) && moves(survey, family))
        .max_by_key(|family| side(family));
    let named = named.map(|family| family.of.iter().copied().flatten().collect::<Vec<Place>>());
    let mut order = named.map(|columns| Order { columns });
    let mut found: Vec<Family> = Vec::new();
    for group in groups(survey, &families, joints) {
        let placed = match &order {
            Some(order) => order.place(survey, &group),
            None if is_measured_position(&group.meaning) => {
                order = Order::by_letters(survey, &group);
                (order.as_ref()).map(|order| (order.columns.clone(), "the letters of the names"))
            }
            None => None,
        };
        let Some((columns, by)) = placed else {
            continue;
        };
        found.push(Family {
            name: shown(survey, columns.iter().copied()),
            joints_by: Some(by),
            meaning: group.meaning,
            by_recorder: None,
            of: columns.iter().copied().map(Some).collect(),
            problem: None,
            columns,
        });
    }
    let taken: BTreeSet<Place> = found
        .iter()
        .flat_map(|family| family.columns.clone())
        .collect();
    let rest = families.into_iter().filter(|family| {
        family.problem.is_none() || !family.columns.iter().all(|column| taken.contains(column))
    });
    rest.chain(found).collect()
}

/// Returns the number of joints of columns whose names contain none: their largest group of positions, or half of it if
/// its columns move in pairs. `None` if there is no group.
pub(super) fn count(survey: &Survey, families: &[Family]) -> Option<usize> {
    let all = ungrouped(families);
    let positions = all
        .iter()
        .filter(|family| is_measured_position(&family.meaning));
    let largest = positions.max_by_key(|family| family.columns.len())?;
    let whole = largest.columns.len();
    match pairs(survey, &largest.columns) {
        Some(pairs) => Some(pairs.len()),
        None => (whole > 1).then_some(whole),
    }
}

fn is_measured_position(meaning: &Meaning) -> bool {
    meaning.sort == Some(Sort::Position) && !meaning.is_reference
}

/// Returns the columns without joints by quantity and side, positions of the motors first.
fn ungrouped(families: &[Family]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let is_ungrouped = |family: &&Family| {
        let is_alone = family
            .problem
            .as_ref()
            .is_some_and(|problem| problem.is_without_joint);
        let sort = family.meaning.sort;
        is_alone && sort.is_some_and(|sort| !matches!(sort, Sort::Time | Sort::Other))
    };
    for family in families.iter().filter(is_ungrouped) {
        let meaning = &family.meaning;
        match groups.iter_mut().find(|group| group.meaning == *meaning) {
            Some(group) => group.columns.extend(&family.columns),
            None => groups.push(Group {
                meaning: meaning.clone(),
                columns: family.columns.clone(),
            }),
        }
    }
    for group in &mut groups {
        group.columns.sort_unstable();
    }
    let rank = |group: &Group| {
        let of_motor = i16::from(group.meaning.motor) - i16::from(group.meaning.link);
        (!is_measured_position(&group.meaning), -of_motor)
    };
    groups.sort_by_key(rank);
    groups
}

/// Returns the groups with one column for each joint. Positions whose names contain no side are two groups if they move
/// in pairs: those with the larger range of each pair, and the others.
fn groups(survey: &Survey, families: &[Family], joints: usize) -> Vec<Group> {
    let range = |(source, column): Place| survey.sources[source].columns[column].figures.range();
    let split = |group: Group| -> Vec<Group> {
        let is_double = is_measured_position(&group.meaning) && group.columns.len() == 2 * joints;
        let pairs = is_double.then(|| pairs(survey, &group.columns)).flatten();
        let Some(pairs) = pairs else {
            return vec![group];
        };
        let sorted = pairs.into_iter().map(|(one, two)| {
            if range(one) < range(two) {
                (two, one)
            } else {
                (one, two)
            }
        });
        let (large, small): (Vec<Place>, Vec<Place>) = sorted.unzip();
        [large, small]
            .map(|columns| Group {
                meaning: group.meaning.clone(),
                columns,
            })
            .into()
    };
    (ungrouped(families).into_iter())
        .flat_map(split)
        .filter(|group| group.columns.len() == joints)
        .collect()
}

/// Returns the pairs of columns that are positions of one joint; `None` if a column has no partner, or several.
fn pairs(survey: &Survey, columns: &[Place]) -> Option<Vec<(Place, Place)>> {
    if columns.len() < 4 || !columns.len().is_multiple_of(2) {
        return None;
    }
    let partner = |place: Place| {
        let others = columns.iter().copied().filter(|other| *other != place);
        let mut near: Vec<(f64, Place)> = others
            .map(|other| (similarity(survey, place, other), other))
            .collect();
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        let [best, second, ..] = near[..] else {
            return None;
        };
        is_clear(best.0, second.0, OF_ONE_JOINT).then_some(best.1)
    };
    let mut all = Vec::new();
    for &column in columns {
        let other = partner(column)?;
        if partner(other)? != column {
            return None;
        }
        if column < other {
            all.push((column, other));
        }
    }
    Some(all)
}

/// Returns whether a match explains so much more than the second best that chance does not do it.
fn is_clear(best: f64, second: f64, least: f64) -> bool {
    best >= least && 1.0 - best < CLEARLY_BETTER * (1.0 - second)
}

/// The columns that give the order of the joints.
struct Order {
    columns: Vec<Place>,
}

impl Order {
    /// Returns the order of names that differ in one letter, as in `pos_a` and `pos_b`.
    fn by_letters(survey: &Survey, group: &Group) -> Option<Self> {
        let letter = |words: BTreeSet<Token>| match &words.into_iter().collect::<Vec<Token>>()[..] {
            [Token::Word(word)] if word.chars().count() == 1 => Some(word.clone()),
            _ => None,
        };
        let mut lettered: Vec<(String, Place)> = (distinct_words(survey, &group.columns)
            .into_iter())
        .zip(&group.columns)
        .map(|(words, place)| Some((letter(words)?, *place)))
        .collect::<Option<_>>()?;
        lettered.sort();
        lettered.dedup_by(|a, b| a.0 == b.0);
        (lettered.len() == group.columns.len()).then(|| Self {
            columns: lettered.into_iter().map(|(_, place)| place).collect(),
        })
    }

    /// Returns the columns of a group in the order of the joints, and the reason; `None` if neither names nor content
    /// show it.
    fn place(&self, survey: &Survey, group: &Group) -> Option<(Vec<Place>, &'static str)> {
        if let Some(columns) = self.by_words(survey, group) {
            return Some((columns, "the words that the names share"));
        }
        let is_position = matches!(group.meaning.sort, Some(Sort::Position | Sort::Deflection));
        let (least, by) = if is_position {
            (OF_ONE_JOINT, "the slope between the positions")
        } else {
            (0.0, "the torque that the motion of each joint explains")
        };
        let fit = |place: Place, of: Place| {
            if is_position {
                similarity(survey, place, of)
            } else {
                explained_torque(survey, place, of)
            }
        };
        let mut placed: Vec<Option<Place>> = vec![None; self.columns.len()];
        for &column in &group.columns {
            let mut fits: Vec<(f64, usize)> = (self.columns.iter().enumerate())
                .map(|(joint, &of)| (fit(column, of), joint))
                .collect();
            fits.sort_by(|a, b| b.0.total_cmp(&a.0));
            let [best, second, ..] = fits[..] else {
                return None;
            };
            if !is_clear(best.0, second.0, least) || placed[best.1].replace(column).is_some() {
                return None;
            }
        }
        Some((placed.into_iter().collect::<Option<_>>()?, by))
    }

    /// Returns the columns in the order of the joints by the words that each shares with one column of the order alone.
    fn by_words(&self, survey: &Survey, group: &Group) -> Option<Vec<Place>> {
        let wanted = distinct_words(survey, &self.columns);
        let words = distinct_words(survey, &group.columns);
        (wanted.iter())
            .map(|wanted| {
                let found = words
                    .iter()
                    .position(|other| other == wanted && !wanted.is_empty())?;
                Some(group.columns[found])
            })
            .collect()
    }
}

/// Returns the words of each name that not all of them have.
fn distinct_words(survey: &Survey, columns: &[Place]) -> Vec<BTreeSet<Token>> {
    let words = |&(source, column): &Place| -> BTreeSet<Token> {
        let name = &survey.sources[source].columns[column].name;
        tokens(name).into_iter().collect()
    };
    let mut all = columns.iter().map(words);
    let first = all.next().unwrap_or_default();
    let common = all.fold(first, |common, of_column| &common & &of_column);
    columns
        .iter()
        .map(|place| &words(place) - &common)
        .collect()
}
