//! Topics of several robots in one bag.

use std::collections::BTreeSet;

use super::error::ChooseError;
use super::families::shortened;
use super::read::{Source, Survey};
use super::words::{Meaning, tokens};
use crate::formats::table::ElementPlace;

/// Returns the beginnings of the topics of each robot if a bag has several: topics with the same end and the same
/// joints, without a word that distinguishes motors from links.
pub(super) fn several(survey: &Survey) -> Vec<String> {
    let all: Vec<(Vec<&str>, BTreeSet<&str>)> = (survey.sources.iter())
        .filter_map(|source| {
            Some((
                source.topic.as_deref()?.split('/').collect(),
                joints(source),
            ))
        })
        .filter(|(_, joints): &(_, BTreeSet<&str>)| !joints.is_empty())
        .collect();
    for (topic, joints) in &all {
        let alike: Vec<&Vec<&str>> = (all.iter())
            .filter(|(other, other_joints)| {
                other.last() == topic.last() && !other_joints.is_disjoint(joints)
            })
            .map(|(other, _)| other)
            .collect();
        let first =
            (0..topic.len()).find(|&k| alike.iter().any(|other| other.get(k) != topic.get(k)));
        let Some(first) = first.filter(|first| first + 1 < topic.len()) else {
            continue;
        };
        let has_side = |words: &Vec<&str>| {
            words.iter().any(|word| {
                let meaning = Meaning::of(&tokens(word), &[]);
                meaning.motor != meaning.link
            })
        };
        if alike.iter().any(|words| has_side(words)) {
            continue;
        }
        let beginnings: BTreeSet<String> = (alike.iter())
            .map(|words| words[..=first.min(words.len() - 1)].join("/"))
            .collect();
        if beginnings.len() > 1 {
            return beginnings.into_iter().collect();
        }
    }
    Vec::new()
}

/// Returns the names of the joints in the messages of a topic.
fn joints(source: &Source) -> BTreeSet<&str> {
    (source.columns.iter())
        .filter_map(|column| match &column.place {
            ElementPlace::Named(name) => Some(name.as_str()),
            ElementPlace::Alone | ElementPlace::Index(_) => None,
        })
        .collect()
}

impl Survey {
    /// Returns the survey with the topics that begin with some letters only.
    ///
    /// # Errors
    ///
    /// [`ChooseError::NoTopic`] if the log has no such topic.
    pub fn with_topics(mut self, beginning: &str) -> Result<Self, ChooseError> {
        let all: Vec<String> = (self.sources.iter())
            .filter_map(|source| source.topic.clone())
            .collect();
        let is_of_robot = |source: &Source| {
            (source.topic.as_ref()).is_some_and(|topic| topic.starts_with(beginning))
        };
        self.sources.retain(is_of_robot);
        if self.sources.is_empty() {
            return Err(ChooseError::NoTopic {
                file: self.file,
                beginning: beginning.to_owned(),
                topics: if all.is_empty() {
                    "it is a table without topics".to_owned()
                } else {
                    format!("its topics are {}", shortened(&all))
                },
            });
        }
        Ok(self)
    }
}
