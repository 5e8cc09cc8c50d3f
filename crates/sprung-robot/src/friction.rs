//! Friction laws by their names in the core's table.

use schemars::JsonSchema;
use serde::Deserialize;
use sprung_core::friction::{Family, Law};

use super::known_words::choose;

/// A friction law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(with = "String", extend("enum" = words()))]
pub struct FrictionLaw(pub Family);

impl FrictionLaw {
    /// Returns the name in the file.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.0.word()
    }

    /// Returns the regressor columns of the law.
    #[must_use]
    pub fn columns(self) -> &'static [Law] {
        self.0.laws()
    }
}

impl TryFrom<String> for FrictionLaw {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        if word == "residual" {
            return Err(
                "the law \"residual\" is no longer part of sprung; use \"presliding\" for friction near reversals, or \"stribeck\" and \"quadratic\" for its \
                 dependence on the velocity"
                    .to_owned(),
            );
        }
        let index = choose("friction law", &word, &words())?;
        Ok(Self(Family::ALL[index]))
    }
}

fn words() -> Vec<&'static str> {
    Family::ALL.iter().map(|family| family.word()).collect()
}
