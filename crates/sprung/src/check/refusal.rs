//! Why a log is refused.

use crate::finding::Finding;

/// Errors about a log, for which it is refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal(pub Vec<Finding>);

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (k, finding) in self.0.iter().enumerate() {
            let separator = if k == 0 { "" } else { "\n" };
            write!(f, "{separator}{} ({})", finding.text, finding.code)?;
            if let Some(setting) = &finding.setting {
                write!(f, "; in the experiment file: {setting}")?;
            }
        }
        Ok(())
    }
}
