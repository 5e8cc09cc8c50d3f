//! Errors about a log that `identify` refuses.

use crate::finding::Finding;

/// Errors about a refused log.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal(pub Vec<Finding>);

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (k, finding) in self.0.iter().enumerate() {
            let separator = if k == 0 { "" } else { "\n" };
            write!(f, "{separator}{} ({})", finding.text, finding.code)?;
            if let Some(setting) = &finding.setting {
                let lines = setting.replace('\n', "\n    ");
                write!(f, "; in the experiment file: {lines}")?;
            }
        }
        Ok(())
    }
}
