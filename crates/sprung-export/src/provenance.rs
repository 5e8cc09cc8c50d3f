//! Origin of an exported robot, written into its file, and whether the file was edited since.

use std::fmt::Write;

use serde::Serialize;

use super::exactness::Said;
use crate::finding::GENERATOR;
use crate::sha256::sha256;

/// Precedes the hash of the contents.
const MARK: &str = "contents sha256 ";

/// Placeholder of the hash during its computation.
const BLANK: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// Origin of an exported robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Origin {
    /// The experiment file.
    pub experiment: String,
    /// The file of parameters.
    pub parameters: String,
    /// Estimator; absent for given values.
    pub estimator: Option<String>,
    /// Verdict on the result, in words; absent for given values.
    pub verdict: Option<String>,
    /// The draw from the posterior that the values are; absent for the estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub draw: Option<DrawOrigin>,
    /// The logs.
    pub logs: Vec<LogOrigin>,
    /// Identified parameters with standard errors.
    pub values: Vec<ValueOrigin>,
}

/// One of several robots that were drawn from the posterior of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct DrawOrigin {
    /// Number of the robot, from 0.
    pub robot: usize,
    /// Number of robots.
    pub count: usize,
    /// Random seed of all.
    pub seed: u64,
}

/// A log of the identification.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LogOrigin {
    /// Its file.
    pub file: String,
    /// SHA-256 of the file at the time of the export; absent if it could not be read.
    pub sha256: Option<String>,
}

/// A parameter with its standard error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValueOrigin {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value in the file.
    pub value: f64,
    /// Value beside the laws that the format lacks; absent if the file holds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beside_laws: Option<f64>,
    /// Standard error; absent if unknown.
    pub standard_error: Option<f64>,
}

impl Origin {
    /// Returns the origin as a comment of XML, without the hash of the contents.
    pub(super) fn comment(&self, robot: &str, said: &[Said]) -> String {
        let mut text = String::new();
        for words in self.lines(robot, said) {
            // A comment must not contain two hyphens in a row; three need a second pass.
            let words = words.replace("--", "- -").replace("--", "- -");
            let _ = writeln!(text, "  {words}");
        }
        format!("<!--\n{text}-->\n")
    }

    /// Returns the origin as lines of text, without the hash of the contents.
    pub(super) fn lines(&self, robot: &str, said: &[Said]) -> Vec<String> {
        let mut lines = vec![
            format!("Exported by {GENERATOR}; {MARK}{BLANK}"),
            format!("robot: {robot}"),
            format!("experiment: {}", self.experiment),
            format!("parameters: {}", self.parameters),
        ];
        lines.extend((self.estimator.iter()).map(|estimator| format!("estimator: {estimator}")));
        lines.extend((self.verdict.iter()).map(|verdict| format!("verdict: {verdict}")));
        if let Some(DrawOrigin { robot, count, seed }) = self.draw {
            lines.push(format!(
                "draw: robot {robot} of {count} from the posterior, counted from 0, seed {seed}; not the estimate"
            ));
        }
        for log in &self.logs {
            let hash = log
                .sha256
                .as_deref()
                .unwrap_or("not readable at the export");
            lines.push(format!("log: {}, sha256 {hash}", log.file));
        }
        lines.push("What this file says:".to_owned());
        for row in said {
            lines.push(format!("  {}: {}: {}", row.how.word(), row.what, row.note));
        }
        lines.push(match self.draw {
            Some(_) => "Values of this robot:".to_owned(),
            None => "Values and standard errors:".to_owned(),
        });
        for value in &self.values {
            let error =
                (value.standard_error).map_or_else(String::new, |error| format!(" ± {error:.2e}"));
            let beside = value.beside_laws.map_or_else(String::new, |beside_laws| {
                format!(" ({beside_laws:.6e} beside the laws that the format lacks)")
            });
            lines.push(format!(
                "  {} = {:.6e}{error} {}{beside}",
                value.name, value.value, value.unit
            ));
        }
        lines
    }

    /// Returns the text that JSON holds in place of the comment.
    #[must_use]
    pub(super) fn mark() -> String {
        format!("{MARK}{BLANK}")
    }
}

/// Writes the hash of the contents into a text that contains the mark of [`Origin::comment`].
pub(super) fn sealed(text: &str) -> String {
    text.replacen(BLANK, &hash(text), 1)
}

fn hash(text: &str) -> String {
    // A slice of memory can always be read.
    sha256(text.as_bytes()).unwrap_or_default()
}

/// State of a file that an export would replace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// As an export wrote it.
    Unchanged,
    /// Edited since an export.
    Edited,
    /// No export wrote it.
    Foreign,
}

/// Returns whether a file is as an export wrote it.
#[must_use]
pub fn earlier(text: &str) -> Earlier {
    let Some((before, after)) = text.split_once(MARK) else {
        return Earlier::Foreign;
    };
    let Some((stated, rest)) = after.split_at_checked(BLANK.len()) else {
        return Earlier::Edited;
    };
    if hash(&format!("{before}{MARK}{BLANK}{rest}")) == stated {
        Earlier::Unchanged
    } else {
        Earlier::Edited
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_seen() {
        let text = sealed(&format!("<!-- {} -->\n<robot/>\n", Origin::mark()));
        assert!(!text.contains(BLANK));
        assert_eq!(earlier(&text), Earlier::Unchanged);
        assert_eq!(
            earlier(&text.replace("<robot/>", "<robot />")),
            Earlier::Edited
        );
        assert_eq!(earlier("<robot/>"), Earlier::Foreign);
        assert_eq!(earlier(&text[..text.len() / 2]), Earlier::Edited);
    }
}
