//! Families of columns: one quantity of all joints.

use std::collections::BTreeMap;

use super::read::{Column, Survey};
use super::recorders;
use super::words::{Meaning, Token, tokens, words};
use crate::description::JointOfStart;
use crate::formats::table::ElementPlace;

/// Words that mean a joint or its motor and do not distinguish joints.
const ANY_JOINT: &[&str] = &[
    "joint",
    "jnt",
    "axis",
    "motor",
    "mot",
    "j",
    "link",
    "drive",
    "achse",
    "gelenk",
    "axe",
    "eje",
    "asse",
    "giunto",
    "articulation",
    "articulacion",
    "关节",
    "轴",
];

/// Source and column of a survey.
pub(super) type Place = (usize, usize);

/// Columns of one quantity, one for each joint.
#[derive(Clone, Debug)]
pub(super) struct Family {
    /// Its name for messages, with `*` for the joint.
    pub(super) name: String,
    /// Reason for the joints of its columns, in words, if their names do not contain them.
    pub(super) joints_by: Option<&'static str>,
    pub(super) meaning: Meaning,
    /// What its recorder means by the name, if the recorder is known.
    pub(super) by_recorder: Option<&'static str>,
    /// Column of each joint of the robot, if it has one.
    pub(super) of: Vec<Option<Place>>,
    /// Why its columns do not belong to joints; the columns are then in `columns`.
    pub(super) problem: Option<Problem>,
    pub(super) columns: Vec<Place>,
}

/// Why columns do not belong to joints.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    /// A sentence without its end.
    pub(super) text: String,
    /// Whether a name matches several joints.
    pub(super) is_ambiguous: bool,
    /// Whether a name has neither joint nor number.
    pub(super) is_without_joint: bool,
}

impl From<String> for Problem {
    fn from(text: String) -> Self {
        Self {
            text,
            is_ambiguous: false,
            is_without_joint: false,
        }
    }
}

/// The part of a name that identifies the joint.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    /// Indices of the joints with this name: more than one if two joints have the same words.
    Joint(Vec<usize>),
    Number(u64),
    /// A name in messages that is not the name of a joint.
    Stranger(String),
    Alone,
}

/// Name of a group of columns: its words with a gap for the joint.
type Stem = Vec<Option<Token>>;

/// A group of columns: the first column of its field in a topic, if it is a list, and its name.
type Group = (Option<Place>, Stem);

/// Columns of groups with the joints of their names.
type Groups = BTreeMap<Group, Vec<(Key, Place)>>;

/// Joints by their numbers, of names that differ in the number alone.
type Numbered = BTreeMap<u64, usize>;

/// Returns the families of columns of a log.
///
/// - `mimics`: names of joints that follow others.
pub(super) fn families(survey: &Survey, joints: &[JointOfStart], mimics: &[String]) -> Vec<Family> {
    let names = Names::of(joints, mimics);
    let mut groups = Groups::new();
    let mut choices: Vec<(Place, Vec<(Group, Key)>)> = Vec::new();
    for (s, source) in survey.sources.iter().enumerate() {
        let fields: Vec<&str> = source.columns.iter().map(|column| &*column.name).collect();
        let is_exact = |column: &Column| matches!(&column.place, ElementPlace::Named(name) if names.is_known(name));
        // If one name is exact, another name belongs to another joint.
        let has_exact = source.columns.iter().any(is_exact);
        for (c, column) in source.columns.iter().enumerate() {
            let place = (s, c);
            let first = fields.iter().position(|field| *field == column.name);
            let in_field = Some((s, first.unwrap_or(c)));
            let stem: Stem = tokens(&column.name).into_iter().map(Some).collect();
            let ways = match &column.place {
                ElementPlace::Named(name) if has_exact && !names.is_known(name) => {
                    vec![((in_field, stem), Key::Stranger(name.clone()))]
                }
                ElementPlace::Named(name) => vec![((in_field, stem), names.key(name))],
                ElementPlace::Index(k) => {
                    vec![((in_field, stem), Key::Number(*k as u64))]
                }
                ElementPlace::Alone => {
                    let topic = source.prefix();
                    let whole = tokens(&format!("{topic} {}", column.name));
                    (names.ways(&whole).into_iter())
                        .map(|(stem, key)| ((None, stem), key))
                        .collect()
                }
            };
            for (group, key) in &ways {
                let members = groups.entry(group.clone()).or_default();
                if !members.iter().any(|(known, _)| known == key) {
                    members.push((key.clone(), place));
                }
            }
            choices.push((place, ways));
        }
    }
    // A column with several numbers belongs to its largest group.
    let mut chosen = Groups::new();
    for (place, ways) in choices {
        let size = |(group, _): &&(Group, Key)| groups[group].len();
        let largest = ways.iter().rev().max_by_key(size);
        if let Some((group, key)) = largest {
            chosen
                .entry(group.clone())
                .or_default()
                .push((key.clone(), place));
        }
    }
    let log: Vec<String> = (survey.all_names().iter())
        .flat_map(|name| {
            let all = tokens(name);
            words(&all)
                .into_iter()
                .map(str::to_owned)
                .collect::<Vec<_>>()
        })
        .collect();
    (chosen.into_iter())
        .map(|((_, stem), members)| family((survey, &log), joints.len(), &names, &stem, &members))
        .collect()
}

fn family(
    (survey, log): (&Survey, &[String]),
    joints: usize,
    names: &Names,
    stem: &Stem,
    members: &[(Key, Place)],
) -> Family {
    let (source, column) = members[0].1;
    let source = &survey.sources[source];
    let topic = source.prefix();
    let mut of_stem: Vec<Token> = stem.iter().flatten().cloned().collect();
    let unit = |&(_, (source, column)): &(Key, Place)| &survey.sources[source].columns[column].unit;
    let of_first = unit(&members[0]);
    if members.iter().all(|member| unit(member) == of_first) {
        of_stem.extend(tokens(of_first));
    }
    let of_topic = tokens(topic);
    let in_list = source.columns[column].place != ElementPlace::Alone;
    let topic_words: Vec<&str> = words(&of_topic);
    let meaning = Meaning::of(&of_stem, if in_list { &topic_words } else { &[] });
    let of_name = words(&of_stem);
    let both = if in_list {
        [&topic_words[..], &of_name].concat()
    } else {
        of_name
    };
    let raw = &source.columns[column].name;
    let (meaning, by_recorder) = recorders::by_recorder(meaning, (raw, &both), log);
    let name = if in_list {
        match topic {
            "" => source.columns[column].name.clone(),
            topic => format!("{topic}.{}", source.columns[column].name),
        }
    } else {
        shown(survey, members.iter().map(|(_, place)| *place))
    };
    let columns: Vec<Place> = members.iter().map(|(_, place)| *place).collect();
    let (of, problem) = match names.assign(members, joints) {
        Ok(of) => (of, None),
        Err(problem) => (vec![None; joints], Some(problem)),
    };
    Family {
        name,
        joints_by: None,
        meaning,
        by_recorder,
        of,
        problem,
        columns,
    }
}

/// Returns the names of the columns of a family, shortened.
pub(super) fn shown(survey: &Survey, columns: impl Iterator<Item = Place>) -> String {
    let name = |&(s, c): &Place| {
        let source = &survey.sources[s];
        let column = source.columns[c].label();
        match source.prefix() {
            "" => column,
            prefix => format!("{prefix}.{column}"),
        }
    };
    match &columns.collect::<Vec<Place>>()[..] {
        [] => String::new(),
        [one] => name(one),
        [first, second] => format!("{}, {}", name(first), name(second)),
        [first, .., last] => format!("{} … {}", name(first), name(last)),
    }
}

/// Names of the joints.
struct Names {
    /// Tokens of each name, and the same without words that every joint may have.
    all: Vec<(Vec<Token>, Vec<Token>)>,
    /// Names as they are written.
    written: Vec<String>,
    /// Number of the joints; the names of mimic joints come after the joints that they follow.
    count: usize,
    /// Whether a joint is one of a gripper.
    of_gripper: Vec<bool>,
}

impl Names {
    fn of(joints: &[JointOfStart], mimics: &[String]) -> Self {
        let written: Vec<String> = (joints.iter().map(|joint| &joint.name))
            .chain(mimics)
            .cloned()
            .collect();
        let all: Vec<(Vec<Token>, Vec<Token>)> = (written.iter())
            .map(|name| {
                let full = tokens(name);
                let short = (full.iter())
                    .filter(|token| !matches!(token, Token::Word(word) if ANY_JOINT.contains(&word.as_str())))
                    .cloned()
                    .collect();
                (full, short)
            })
            .collect();
        Self {
            all,
            written,
            count: joints.len(),
            of_gripper: joints.iter().map(|joint| joint.gripper.is_some()).collect(),
        }
    }

    /// Returns whether a name is exactly that of a joint.
    fn is_known(&self, name: &str) -> bool {
        self.written.iter().any(|known| known == name)
    }

    /// Returns the key of joints with these names: those that follow others are unknown.
    fn key_of(&self, mut named: Vec<usize>) -> Key {
        let follower = named.first().map_or("", |&first| &self.written[first]);
        let follower = follower.to_owned();
        named.retain(|&index| index < self.count);
        if named.is_empty() {
            Key::Stranger(follower)
        } else {
            Key::Joint(named)
        }
    }

    /// Returns the joint that a name in messages means.
    fn key(&self, name: &str) -> Key {
        let exact: Vec<usize> = (0..self.written.len())
            .filter(|&i| self.written[i] == name)
            .collect();
        if !exact.is_empty() {
            return self.key_of(exact);
        }
        let ways = self.ways(&tokens(name));
        match ways.into_iter().next_back() {
            Some((_, Key::Alone)) | None => Key::Stranger(name.to_owned()),
            Some((_, key)) => key,
        }
    }

    /// Returns the ways to read a name: as that of a joint, or by each of its numbers.
    fn ways(&self, name: &[Token]) -> Vec<(Stem, Key)> {
        // The longest name wins: "left_shoulder" before "shoulder".
        let mut best: Option<(usize, usize, Vec<usize>)> = None;
        for (i, (full, short)) in self.all.iter().enumerate() {
            let is_word = |token: &Token| matches!(token, Token::Word(_));
            let short_names = short.iter().any(is_word).then_some(short);
            for wanted in [Some(full), short_names].into_iter().flatten() {
                let Some(start) = find(name, wanted) else {
                    continue;
                };
                let length = wanted.len();
                match &mut best {
                    Some((_, most, all)) if *most == length => {
                        if !all.contains(&i) {
                            all.push(i);
                        }
                    }
                    Some((_, most, _)) if *most > length => {}
                    _ => best = Some((start, length, vec![i])),
                }
            }
        }
        let stem = |start: usize, length: usize| -> Stem {
            let before = name[..start].iter().cloned().map(Some);
            let after = name[start + length..].iter().cloned().map(Some);
            before.chain([None]).chain(after).collect()
        };
        if let Some((start, length, joints)) = best {
            return vec![(stem(start, length), self.key_of(joints))];
        }
        let numbers: Vec<(Stem, Key)> = (name.iter().enumerate())
            .filter_map(|(k, token)| match token {
                Token::Number(number) => Some((stem(k, 1), Key::Number(*number))),
                Token::Word(_) => None,
            })
            .collect();
        if numbers.is_empty() {
            return vec![(name.iter().cloned().map(Some).collect(), Key::Alone)];
        }
        numbers
    }

    /// Assigns the members of a family to joints.
    ///
    /// # Errors
    ///
    /// Why this is not possible.
    fn assign(
        &self,
        members: &[(Key, Place)],
        joints: usize,
    ) -> Result<Vec<Option<Place>>, Problem> {
        let mut of = vec![None; joints];
        let mut numbers: Vec<(u64, Place)> = Vec::new();
        for (key, place) in members {
            match key {
                Key::Joint(indices) if indices.len() > 1 => {
                    let names: Vec<&str> = indices.iter().map(|&i| &*self.written[i]).collect();
                    return Err(Problem {
                        text: format!(
                            "one column matches {} joints, {}",
                            indices.len(),
                            names.join(" and ")
                        ),
                        is_ambiguous: true,
                        is_without_joint: false,
                    });
                }
                Key::Joint(indices) => {
                    let joint = indices[0];
                    if of[joint].replace(*place).is_some() {
                        return Err(
                            format!("two columns match the joint {}", self.written[joint]).into(),
                        );
                    }
                }
                Key::Number(number) => numbers.push((*number, *place)),
                // A recorder may name more joints than those of the robot.
                Key::Stranger(_) => {}
                Key::Alone if joints == 1 => of[0] = Some(*place),
                Key::Alone => {
                    return Err(Problem {
                        text: "its name has neither joint nor number".to_owned(),
                        is_ambiguous: false,
                        is_without_joint: true,
                    });
                }
            }
        }
        if numbers.is_empty() {
            if of.iter().all(Option::is_none) {
                let names = members.iter().filter_map(|(key, _)| match key {
                    Key::Stranger(name) => Some(name.as_str()),
                    Key::Joint(_) | Key::Number(_) | Key::Alone => None,
                });
                let names: Vec<&str> = names.collect();
                return Err(format!(
                    "the joints of the log, {}, are not those of the robot",
                    names.join(", ")
                )
                .into());
            }
            return Ok(of);
        }
        numbers.sort_unstable();
        let values: Vec<u64> = numbers.iter().map(|(number, _)| *number).collect();
        let order = self.numbered(&values)?;
        for (joint, (_, place)) in order.into_iter().zip(numbers) {
            of[joint] = Some(place);
        }
        Ok(of)
    }

    /// Returns the joints that sorted numbers mean.
    ///
    /// # Errors
    ///
    /// Why this is not clear.
    fn numbered(&self, numbers: &[u64]) -> Result<Vec<usize>, Problem> {
        let count = numbers.len();
        let mut stems: BTreeMap<Vec<Token>, Numbered> = BTreeMap::new();
        for (i, (full, _)) in self.all[..self.count].iter().enumerate() {
            if let Some(k) = full
                .iter()
                .rposition(|token| matches!(token, Token::Number(_)))
                && let Token::Number(number) = full[k]
            {
                let stem: Vec<Token> = [&full[..k], &full[k + 1..]].concat();
                stems.entry(stem).or_default().insert(number, i);
            }
        }
        // Numbers mean joints only if all joints of the arm have one: the wrists of an arm may be
        // numbered and its shoulder not.
        let of_arm = self.of_gripper.iter().filter(|gripper| !**gripper).count();
        let of_stem = |stem: &Numbered| {
            stem.values()
                .filter(|&&joint| !self.of_gripper[joint])
                .count()
        };
        stems.retain(|_, stem| of_stem(stem) == of_arm);
        // Numbers of joints, the same counted from 0, and a part of the numbers.
        let from_1: Vec<u64> = numbers.iter().map(|number| number + 1).collect();
        let all_of =
            |stem: &Numbered, wanted: &[u64]| wanted.iter().all(|number| stem.contains_key(number));
        let starts_at_0 = numbers.first() == Some(&0);
        let is_whole = |stem: &Numbered| stem.len() == count && all_of(stem, numbers);
        let is_from_0 =
            |stem: &Numbered| starts_at_0 && stem.len() == count && all_of(stem, &from_1);
        let is_part = |stem: &Numbered| !starts_at_0 && all_of(stem, numbers);
        let one = |is: &dyn Fn(&Numbered) -> bool, wanted: &[u64]| -> Option<Vec<usize>> {
            let found: Vec<&Numbered> = stems.values().filter(|stem| is(stem)).collect();
            let [stem] = found[..] else { return None };
            Some(wanted.iter().map(|number| stem[number]).collect())
        };
        let by_number = one(&is_whole, numbers)
            .or_else(|| one(&is_from_0, &from_1))
            .or_else(|| one(&is_part, numbers));
        if let Some(joints) = by_number {
            return Ok(joints);
        }
        let arm: Vec<usize> = (0..self.count).filter(|&i| !self.of_gripper[i]).collect();
        for candidates in [(0..self.count).collect(), arm] {
            if candidates.len() == count {
                return Ok(candidates);
            }
        }
        Err(format!(
            "it has {count} columns, and the robot has {} joints ({})",
            self.count,
            shortened(&self.written[..self.count])
        )
        .into())
    }
}

/// Returns the first names of a list.
pub(super) fn shortened(names: &[String]) -> String {
    const SHOWN: usize = 12;
    let shown = names[..names.len().min(SHOWN)].join(", ");
    match names.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Returns the first place of a sequence in another.
fn find(all: &[Token], wanted: &[Token]) -> Option<usize> {
    (!wanted.is_empty())
        .then(|| {
            all.windows(wanted.len())
                .position(|window| window == wanted)
        })
        .flatten()
}
