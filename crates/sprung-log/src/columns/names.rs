//! Finds columns by exact name, number or pattern, and suggests the nearest name.

use std::fmt;

use super::origin::Pick;
use crate::description::ColumnName;
use crate::error::LogError;
use crate::named::edits;

/// Maximum number of names in a message.
const MAX_NAMES_IN_MESSAGE: usize = 30;

/// The columns of a file.
pub(crate) struct Names<'a> {
    /// Name of the file.
    pub(crate) file: &'a str,
    /// Names of the columns.
    pub(crate) all: &'a [String],
    /// Whether the file names its columns; otherwise they only have numbers.
    pub(crate) given: bool,
}

impl Names<'_> {
    /// Returns the index of a column, from 0.
    ///
    /// # Errors
    ///
    /// [`LogError`] if no column or more than one column matches.
    pub(crate) fn find(&self, pick: &Pick) -> Result<usize, LogError> {
        match pick {
            Pick::Column(ColumnName::Number(number)) => self.by_number(*number),
            Pick::Column(ColumnName::Name(name)) => self.by_name(name),
            Pick::Matching {
                pattern,
                joint,
                index,
                of,
            } => self.by_pattern(pattern, joint, *index, *of),
            Pick::Field { field, .. } => Err(LogError::format(
                self.file,
                format!(
                    " has columns and no messages; name a column instead of the field \"{field}\""
                ),
            )),
        }
    }

    fn by_number(&self, number: usize) -> Result<usize, LogError> {
        if number <= self.all.len() {
            return Ok(number - 1);
        }
        Err(LogError::NoColumn {
            file: self.file.to_owned(),
            column: number.to_string(),
            hint: format!("; it has {} columns", self.all.len()),
        })
    }

    fn by_name(&self, name: &str) -> Result<usize, LogError> {
        let mut places = (self.all.iter().enumerate()).filter(|(_, column)| *column == name);
        match (places.next(), places.next()) {
            (Some((place, _)), None) => Ok(place),
            (None, _) => Err(self.no_column(name)),
            (Some(_), Some(_)) => Err(LogError::TwoColumns {
                file: self.file.to_owned(),
                column: name.to_owned(),
            }),
        }
    }

    fn by_pattern(
        &self,
        pattern: &str,
        joint: &str,
        index: usize,
        of: usize,
    ) -> Result<usize, LogError> {
        let Some((before, after)) = pattern.split_once('*') else {
            return self.by_name(pattern);
        };
        let mut found: Vec<(usize, &str)> = (self.all.iter().enumerate())
            .filter_map(|(place, name)| {
                let star = name.strip_prefix(before)?.strip_suffix(after)?;
                (!star.is_empty()).then_some((place, star))
            })
            .collect();
        if let Some((place, _)) = found.iter().find(|(_, star)| *star == joint) {
            return Ok(*place);
        }
        let names: Vec<&str> = (found.iter())
            .map(|(place, _)| self.all[*place].as_str())
            .collect();
        if found.is_empty() {
            return Err(self.no_column(pattern));
        }
        let numbered: Vec<(usize, &str)> = (found.iter().copied())
            .filter(|(_, star)| star.bytes().all(|byte| byte.is_ascii_digit()))
            .collect();
        if numbered.len() == of {
            found = numbered;
        }
        if found.len() != of {
            return Err(LogError::format(
                self.file,
                format!(
                    ": \"{pattern}\" matches {} columns ({}) for {of} joints; list those that are meant",
                    found.len(),
                    listed(&names)
                ),
            ));
        }
        let numbers: Option<Vec<u64>> = found.iter().map(|(_, star)| star.parse().ok()).collect();
        let Some(numbers) = numbers else {
            return Err(LogError::format(
                self.file,
                format!(
                    ": \"{pattern}\" matches {}, which are neither numbered nor named as the joints; \
                     list them in the order of the joints",
                    listed(&names)
                ),
            ));
        };
        let mut order: Vec<usize> = (0..of).collect();
        order.sort_by_key(|&k| numbers[k]);
        found = order.into_iter().map(|k| found[k]).collect();
        Ok(found[index].0)
    }

    fn no_column(&self, column: &str) -> LogError {
        let near = |name: &String| edits(column, name);
        let nearest = (self.all.iter())
            .map(|name| (near(name), name))
            .min_by_key(|&(distance, _)| distance)
            .filter(|&(distance, name)| distance <= 1 + name.chars().count() / 2);
        let hint = match nearest {
            _ if !self.given => format!(
                "; it has no names, only {} numbered columns: give a number from 1, without quotes",
                self.all.len()
            ),
            Some((_, name)) => format!("; did you mean \"{name}\"?"),
            None => {
                let names: Vec<&str> = self.all.iter().map(String::as_str).collect();
                format!("; its columns are {}", listed(&names))
            }
        };
        LogError::NoColumn {
            file: self.file.to_owned(),
            column: column.to_owned(),
            hint,
        }
    }
}

/// A part of a file that is not a column of numbers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refused {
    pub(crate) name: String,
    /// Why sprung does not read it, and the remedy.
    pub(crate) why: String,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\" {}", self.name, self.why)
    }
}

/// Returns the error for a column that was not found. If the name belongs to a part of the file
/// that is not a column of numbers, the error explains this.
///
/// - `error`: the error in all other cases.
pub(crate) fn instead(file: &str, refused: &[Refused], pick: &Pick, error: LogError) -> LogError {
    let (Pick::Column(ColumnName::Name(name)) | Pick::Matching { pattern: name, .. }) = pick else {
        return error;
    };
    let is_meant = |refused: &&Refused| {
        let index = name.strip_prefix(&refused.name);
        index.is_some_and(|index| index.is_empty() || index.starts_with(['[', '(', '.']))
    };
    match refused.iter().find(is_meant) {
        Some(refused) => LogError::format(file, format!(": {refused}")),
        None => error,
    }
}

/// Returns the first names as a list, and the number of the others.
pub(crate) fn listed(names: &[&str]) -> String {
    let shown = names[..names.len().min(MAX_NAMES_IN_MESSAGE)].join(", ");
    match names.len().saturating_sub(MAX_NAMES_IN_MESSAGE) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(pattern: &str, joint: &str, index: usize, of: usize) -> Pick {
        Pick::Matching {
            pattern: pattern.to_owned(),
            joint: joint.to_owned(),
            index,
            of,
        }
    }

    fn find(all: &[&str], pick: &Pick) -> Result<usize, String> {
        let all: Vec<String> = all.iter().map(|&name| name.to_owned()).collect();
        let names = Names {
            file: "a.csv",
            all: &all,
            given: true,
        };
        names.find(pick).map_err(|error| error.to_string())
    }

    #[test]
    fn patterns_go_by_joint_or_by_number() {
        let numbered = ["q10", "q2", "t", "q1"];
        assert_eq!(find(&numbered, &pattern("q*", "a", 0, 3)), Ok(3));
        assert_eq!(find(&numbered, &pattern("q*", "a", 2, 3)), Ok(0));
        let named = ["elbow_pos", "shoulder_pos"];
        assert_eq!(find(&named, &pattern("*_pos", "shoulder", 0, 2)), Ok(1));
    }

    #[test]
    fn ambiguous_patterns_are_refused() {
        let error = find(&["q1", "q2", "q3"], &pattern("q*", "a", 0, 2)).unwrap_err();
        assert!(
            error.contains("matches 3 columns (q1, q2, q3) for 2 joints"),
            "{error}"
        );
        let error = find(&["qa", "qb"], &pattern("q*", "x", 0, 2)).unwrap_err();
        assert!(error.contains("neither numbered nor named"), "{error}");
        let error = find(&["a", "b"], &pattern("q*_rad", "x", 0, 2)).unwrap_err();
        assert!(
            error.contains("has no column \"q*_rad\"; its columns are a, b"),
            "{error}"
        );
    }

    #[test]
    fn thousands_of_names_are_not_listed() {
        let all: Vec<String> = (0..10_000).map(|k| format!("channel{k}")).collect();
        let names = Names {
            file: "a.csv",
            all: &all,
            given: true,
        };
        let pick = Pick::Column(ColumnName::Name("x".to_owned()));
        let error = names.find(&pick).unwrap_err().to_string();
        assert!(error.ends_with("and 9970 more"), "{error}");
    }
}
