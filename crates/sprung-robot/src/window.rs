//! Windows of logs.

use std::fmt;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::{Deserialize, Deserializer, Serialize};

use super::payload::Payload;
use crate::numbers::Shown;

/// A window of a log; an absent bound is that of the log.
///
/// A sample at time t with index i belongs to it if `from_s` ≤ t < `to_s` and
/// `from_index` ≤ i < `to_index`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(default)]
pub struct Window {
    /// Time of its beginning, s, on the axis of the log's own time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// Time of its end, s; a sample at this time lies outside.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to_s: Option<f64>,
    /// Index of its first sample, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_index: Option<u64>,
    /// Index of the first sample after it, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to_index: Option<u64>,
}

impl Window {
    /// Returns whether it is the whole log.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the name of a log with its window, for messages.
    #[must_use]
    pub fn of(&self, log: &str) -> String {
        if self.is_whole() {
            log.to_owned()
        } else {
            format!("{log} ({self})")
        }
    }

    /// Returns the name of a log without its window: the inverse of [`of`](Self::of).
    #[must_use]
    pub fn without(&self, name: &str) -> String {
        let suffix = self.of("");
        name.strip_suffix(&suffix).unwrap_or(name).to_owned()
    }

    /// Returns whether no sample can lie in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let times = self.from_s.zip(self.to_s);
        let indices = self.from_index.zip(self.to_index);
        times.is_some_and(|(from, to)| from >= to)
            || indices.is_some_and(|(from, to)| from >= to)
            || self.to_index == Some(0)
    }

    /// Returns whether a sample may lie in both windows. A bound by time and a bound by index
    /// cannot be compared, so they count as overlapping.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        let apart = |one: &Self, two: &Self| {
            (one.to_s.zip(two.from_s)).is_some_and(|(to, from)| to <= from)
                || (one.to_index.zip(two.from_index)).is_some_and(|(to, from)| to <= from)
        };
        !apart(self, other) && !apart(other, self)
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mut words, mut between) = (Vec::new(), "");
        words.extend(self.from_s.map(|time| format!("from {} s", Shown(time))));
        words.extend(self.from_index.map(|index| format!("from sample {index}")));
        words.extend(self.to_s.map(|time| format!("to {} s", Shown(time))));
        words.extend(self.to_index.map(|index| format!("to sample {index}")));
        for word in words {
            write!(f, "{between}{word}")?;
            between = " ";
        }
        Ok(())
    }
}

/// A file of a log, or a window of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilePart {
    /// Path, relative to the experiment file.
    pub path: PathBuf,
    /// The samples that belong to the log.
    pub window: Window,
    /// The body that the robot carried.
    pub payload: Option<Payload>,
}

impl From<PathBuf> for FilePart {
    fn from(path: PathBuf) -> Self {
        Self {
            path,
            window: Window::default(),
            payload: None,
        }
    }
}

impl fmt::Display for FilePart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.window.of(&self.path.display().to_string()))
    }
}

/// A window of a file.
#[derive(Deserialize, JsonSchema)]
pub(super) struct FileWindow {
    /// The file, relative to the experiment file.
    path: PathBuf,
    /// Beginning of the window, s: the time in the log's own time column. Times since 1970 (dates,
    /// stamps in ns, messages of a bag) may also count from the first sample, as in reports.
    from_s: Option<f64>,
    /// End of the window, s; a sample at this time lies outside.
    to_s: Option<f64>,
    /// Index of the first sample of the window, from 0.
    from_index: Option<u64>,
    /// Index of the first sample after the window, from 0.
    to_index: Option<u64>,
    /// Body that a link carried while the file was recorded.
    payload: Option<Payload>,
}

#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "describes the schema of a file")]
pub(super) enum OneFile {
    Whole(PathBuf),
    Part(Box<FileWindow>),
}

#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "describes the schema of one file or several")]
pub(super) enum OneOrManyFiles {
    One(OneFile),
    Many(Vec<OneFile>),
}

impl<'de> Deserialize<'de> for FilePart {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut all = files(deserializer)?.unwrap_or_default();
        match (all.pop(), all.is_empty()) {
            (Some(one), true) => Ok(one),
            _ => Err(serde::de::Error::custom("a list of files within another")),
        }
    }
}

/// Reads a file or a list of files.
pub(super) fn files<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Vec<FilePart>>, D::Error> {
    struct Visitor;
    impl<'de> serde::de::Visitor<'de> for Visitor {
        type Value = Option<Vec<FilePart>>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str(
                "the name of a file, a window { path = \"…\", from_s = …, to_s = … }, or a list of them",
            )
        }

        fn visit_str<E>(self, word: &str) -> Result<Self::Value, E> {
            Ok(Some(vec![PathBuf::from(word).into()]))
        }

        fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
            let part = FileWindow::deserialize(MapAccessDeserializer::new(map))?;
            Ok(Some(vec![FilePart {
                path: part.path,
                window: Window {
                    from_s: part.from_s,
                    to_s: part.to_s,
                    from_index: part.from_index,
                    to_index: part.to_index,
                },
                payload: part.payload,
            }]))
        }

        fn visit_seq<A: serde::de::SeqAccess<'de>>(
            self,
            mut list: A,
        ) -> Result<Self::Value, A::Error> {
            let mut all = Vec::new();
            while let Some(one) = list.next_element::<FilePart>()? {
                all.push(one);
            }
            if all.is_empty() {
                return Err(serde::de::Error::custom("the list of files is empty"));
            }
            Ok(Some(all))
        }
    }
    deserializer.deserialize_any(Visitor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(from_s: Option<f64>, to_s: Option<f64>) -> Window {
        Window {
            from_s,
            to_s,
            ..Window::default()
        }
    }

    #[test]
    fn windows_are_named_in_words() {
        let part = FilePart {
            path: "run.csv".into(),
            window: window(Some(12.0), Some(60.5)),
            payload: None,
        };
        assert_eq!(part.to_string(), "run.csv (from 12 s to 60.5 s)");
        let by_index = Window {
            from_index: Some(100),
            ..Window::default()
        };
        assert_eq!(by_index.of("run.csv"), "run.csv (from sample 100)");
        assert_eq!(Window::default().of("run.csv"), "run.csv");
    }

    #[test]
    fn windows_that_touch_do_not_overlap() {
        let first = window(None, Some(30.0));
        assert!(!first.overlaps(&window(Some(30.0), None)));
        assert!(first.overlaps(&window(Some(29.0), None)));
        assert!(first.overlaps(&Window::default()));
    }

    #[test]
    fn a_window_without_length_is_empty() {
        assert!(window(Some(1.0), Some(1.0)).is_empty());
        assert!(!window(Some(1.0), None).is_empty());
    }
}
