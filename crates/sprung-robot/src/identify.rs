//! `[identify]`: estimators and filters.

use schemars::JsonSchema;
use serde::Deserialize;

use super::known_words::choose;
use super::physical::Physical;

/// Settings of the identification.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Identify {
    /// One estimator or several: `"prediction-error"`, `"least-squares"`, `"lsff"`. Without this key
    /// sprung takes `"prediction-error"` if least squares leave less than 20 % of the torque of every motor, or 1.5 % if the
    /// logs show no spring; else, with a gyroscope or an accelerometer on a link, and where the log shows a wrong gain or time
    /// scale, `"least-squares"`.
    #[serde(deserialize_with = "one_or_many")]
    #[schemars(with = "OneOrManyEstimators")]
    pub estimator: Vec<Estimator>,
    /// Start values of the refinement: `"least-squares"` (the default), or `"nominal"`, which needs
    /// nominal values.
    pub start: StartName,
    /// Corner λ of the filter pair, rad/s; if absent 30, and below 100 samples per second 0.3 times their rate.
    pub filter_cutoff_rad_per_s: Option<f64>,
    /// Discretisation of the filter pair: `"matched"` (the default) or `"paper"`. `"paper"` with
    /// `weights = "none"` and a number for the cut-off is the published method.
    pub discretization: DiscretizationName,
    /// Cut-off of the zero-phase Butterworth filter of the positions, Hz. With `"auto"` (the default)
    /// the noise of the positions gives the highest cut-off; a lower one replaces it if it predicts
    /// held-out parts of the log better.
    pub position_cutoff_hz: Cutoff,
    /// Order of the position filter.
    pub position_filter_order: usize,
    /// Weights of the samples in least squares: with `"transition"` (the default) samples count less
    /// where velocity noise disturbs Coulomb friction; with `"none"` all samples count the same.
    pub weights: Weights,
    /// Constant offset between the two encoders of a joint: `"none"` (the default for `planar-2r`) or
    /// `"estimate"` (the default for other robots). An offset that the log shows is estimated.
    pub encoder_offset: Option<EncoderOffset>,
    /// Action if the check finds an error in a log: `"refuse"` (the default), or `"go-on"`, which
    /// identifies and lists the error among the findings.
    pub on_check_error: OnCheckError,
    /// Laws of friction and springs beyond those of the joints. With `"auto"` (the default) sprung adds those that predict
    /// held-out parts of the log better; with `"declared"` the finding `laws-missing` names them.
    pub laws: Laws,
    /// Memory that the refinement may use, MiB. Of longer logs it uses pieces that are spread evenly.
    pub refinement_memory_mib: usize,
    /// Whether to find springs of rigid joints from the vibrations that their motors see. All joints must
    /// be rigid, without coupled transmission.
    pub springs_from_motor: bool,
    /// Robots among which least squares and the refinement search: with `"possible"` (the default) those that can exist,
    /// with possible bodies, positive stiffnesses and friction that takes energy; with `"none"` all, as in the paper.
    pub constraints: Constraints,
    /// How sprung finds inertial parameters of single links that bodies can have.
    pub physical: Physical,
}

impl Default for Identify {
    fn default() -> Self {
        Self {
            estimator: Vec::new(),
            start: StartName::LeastSquares,
            filter_cutoff_rad_per_s: None,
            discretization: DiscretizationName::Matched,
            position_cutoff_hz: Cutoff::Auto,
            position_filter_order: 2,
            weights: Weights::Transition,
            encoder_offset: None,
            on_check_error: OnCheckError::Refuse,
            laws: Laws::Auto,
            refinement_memory_mib: 256,
            springs_from_motor: false,
            constraints: Constraints::Possible,
            physical: Physical::default(),
        }
    }
}

/// Corner of the filter pair without a key, rad/s: above the motion of arms, below the noise.
const FILTER_CUTOFF: f64 = 30.0;

/// Largest corner of the filter pair without a key, over the sampling rate.
const MAX_FILTER_SHARE_OF_RATE: f64 = 0.3;

impl Identify {
    /// Returns the corner λ of the filter pair, rad/s: that of the file, or the one that suits a sampling period, s.
    #[must_use]
    pub fn filter_cutoff(&self, period: f64) -> f64 {
        let suited = || FILTER_CUTOFF.min(MAX_FILTER_SHARE_OF_RATE / period);
        self.filter_cutoff_rad_per_s.unwrap_or_else(suited)
    }

    /// Returns the estimators that the file names, or those by default.
    ///
    /// - `refines`: whether a joint has a spring, or the equations of rigid joints explain the torques. Otherwise laws of
    ///   friction limit the result, which no refinement mends.
    #[must_use]
    pub fn estimators(&self, refines: bool) -> &[Estimator] {
        match (self.estimator.is_empty(), refines) {
            (false, _) => &self.estimator,
            (true, true) => &[Estimator::PredictionError],
            (true, false) => &[Estimator::LeastSquares],
        }
    }
}

/// An estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["prediction-error", "least-squares", "lsff"]))]
pub enum Estimator {
    /// Maximum likelihood on the innovations of an extended Kalman filter, started from least
    /// squares.
    PredictionError,
    /// Least squares on the filtered regression.
    LeastSquares,
    /// Recursive least squares with forgetting factor, sample by sample.
    Lsff,
}

impl Estimator {
    /// Returns the name in files and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PredictionError => "prediction-error",
            Self::LeastSquares => "least-squares",
            Self::Lsff => "lsff",
        }
    }
}

impl TryFrom<String> for Estimator {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        if word == "output-error" {
            return Err(
                "the estimator \"output-error\" is no longer part of sprung; use \"prediction-error\", which needs no \
                 controller"
                    .to_owned(),
            );
        }
        let all = [Self::PredictionError, Self::LeastSquares, Self::Lsff];
        let index = choose("estimator", &word, &all.map(Self::name))?;
        Ok(all[index])
    }
}

/// Start values of the refinement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["least-squares", "nominal"]))]
pub enum StartName {
    /// The estimates of least squares.
    LeastSquares,
    /// The nominal values of the file.
    Nominal,
}

impl TryFrom<String> for StartName {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("start", &word, &["least-squares", "nominal"])?;
        Ok([Self::LeastSquares, Self::Nominal][index])
    }
}

#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "describes the schema of one estimator or several")]
enum OneOrManyEstimators {
    One(Estimator),
    Many(Vec<Estimator>),
}

fn one_or_many<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<Estimator>, D::Error> {
    struct Visitor;
    impl<'de> serde::de::Visitor<'de> for Visitor {
        type Value = Vec<Estimator>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("the name of an estimator or a list of names")
        }

        fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Self::Value, E> {
            Estimator::try_from(word.to_owned())
                .map(|one| vec![one])
                .map_err(E::custom)
        }

        fn visit_seq<A: serde::de::SeqAccess<'de>>(
            self,
            mut list: A,
        ) -> Result<Self::Value, A::Error> {
            let mut all = Vec::new();
            while let Some(one) = list.next_element()? {
                all.push(one);
            }
            if all.is_empty() {
                return Err(serde::de::Error::custom("the list of estimators is empty"));
            }
            Ok(all)
        }
    }
    deserializer.deserialize_any(Visitor)
}

/// Cut-off of the position filter: a number, or `"auto"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cutoff {
    /// Given, Hz.
    Fixed(f64),
    /// Chosen by sprung from the noise of the positions.
    Auto,
}

impl<'de> Deserialize<'de> for Cutoff {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Cutoff;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a frequency in Hz or \"auto\"")
            }

            fn visit_f64<E>(self, value: f64) -> Result<Cutoff, E> {
                Ok(Cutoff::Fixed(value))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Cutoff, E> {
                Ok(Cutoff::Fixed(value as f64))
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Cutoff, E> {
                choose("position cut-off", word, &["auto"])
                    .map(|_| Cutoff::Auto)
                    .map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl JsonSchema for Cutoff {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Cutoff".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "Hz, or \"auto\"",
            "anyOf": [{ "type": "number" }, { "const": "auto" }],
        })
    }
}

/// Discretisation of the filter pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["matched", "paper"]))]
pub enum DiscretizationName {
    /// Tustin for the regressor, zero-order hold for the torque, which the amplifier holds.
    Matched,
    /// Zero-order hold for both, as in the paper.
    Paper,
}

impl DiscretizationName {
    /// Returns the name in files and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Matched => "matched",
            Self::Paper => "paper",
        }
    }
}

impl TryFrom<String> for DiscretizationName {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("discretization", &word, &["matched", "paper"])?;
        Ok([Self::Matched, Self::Paper][index])
    }
}

/// Robots among which least squares searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["possible", "none"]))]
pub enum Constraints {
    /// Robots that can exist.
    Possible,
    /// All robots, as in the paper.
    None,
}

impl Constraints {
    /// Returns the name in files and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Possible => "possible",
            Self::None => "none",
        }
    }
}

impl TryFrom<String> for Constraints {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("constraints", &word, &["possible", "none"])?;
        Ok([Self::Possible, Self::None][index])
    }
}

/// Weights of the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["transition", "none"]))]
pub enum Weights {
    /// Samples count less if velocity noise disturbs Coulomb friction, near a reversal.
    Transition,
    /// All samples have weight 1, as in the paper.
    None,
}

impl Weights {
    /// Returns the name in files and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Transition => "transition",
            Self::None => "none",
        }
    }
}

impl TryFrom<String> for Weights {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("weights", &word, &["transition", "none"])?;
        Ok([Self::Transition, Self::None][index])
    }
}

/// Constant offset between the two encoders of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["none", "estimate"]))]
pub enum EncoderOffset {
    /// Assumed to be zero.
    None,
    /// Estimated with the parameters.
    Estimate,
}

impl TryFrom<String> for EncoderOffset {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("encoder_offset", &word, &["none", "estimate"])?;
        Ok([Self::None, Self::Estimate][index])
    }
}

/// Action if the check finds that a log contradicts the experiment file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["refuse", "go-on"]))]
pub enum OnCheckError {
    /// Refuse to identify.
    Refuse,
    /// Identify, and list the error among the findings.
    GoOn,
}

impl TryFrom<String> for OnCheckError {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("on_check_error", &word, &["refuse", "go-on"])?;
        Ok([Self::Refuse, Self::GoOn][index])
    }
}

/// Laws of friction and springs beyond those that a joint declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["declared", "auto"]))]
pub enum Laws {
    /// The declared laws alone; a finding names the laws that predict held-out parts of the log
    /// better.
    Declared,
    /// Laws that predict held-out parts of the log better are added.
    Auto,
}

impl TryFrom<String> for Laws {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("laws", &word, &["declared", "auto"])?;
        Ok([Self::Declared, Self::Auto][index])
    }
}
