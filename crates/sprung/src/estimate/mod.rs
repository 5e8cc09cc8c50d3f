//! Estimators: from the regression of the logs to parameters, standard errors, findings and a
//! verdict.

mod about_effects;
mod about_logs;
mod at_rest;
mod between_parts;
mod chi_square;
mod confirmed;
mod decide;
mod delay_test;
mod describe;
mod error;
mod estimators;
mod found;
mod identify;
mod in_frequency;
mod inputs;
mod judge;
mod kind_of_change;
mod late_channels;
mod laws;
mod least_squares;
mod lsff;
mod many_logs;
mod on_line;
mod output_error;
mod payload;
mod physical;
mod prediction_error;
mod promise;
mod read_logs;
mod refinement_result;
mod result;
mod start;
mod verdict;

pub use about_logs::{DelayUsed, GainUsed, LogInfo, SignUsed};
pub(crate) use between_parts::between_parts;
pub use error::IdentifyError;
pub(crate) use found::NORMAL_95;
pub use identify::{Identified, identify, identify_and_tell};
pub use late_channels::late_channels;
pub(crate) use laws::with_found_laws;
pub use laws::{LawDelay, LawRung, LawsByHoldOut};
pub use lsff::{Lsff, LsffError};
pub use many_logs::{Choices, FactorsError, LogFactors};
pub(crate) use many_logs::{choices, factors, identify_factors};
pub use payload::{PayloadParameter, PayloadResult};
pub use physical::{CovarianceOfErrors, Decided, PhysicalResult, StandardParameter};
pub use prediction_error::{KnownNoise, KnownTruth, information_bound};
pub use promise::JointPrediction;
pub(crate) use promise::{percent, predictions};
pub use refinement_result::{
    HeldOutResidual, RefinedDelay, RefinedEccentricity, RefinedOffset, RefinedSaturation,
    RefinedVelocity, Refinement, ResidualPrior, RowDisturbance, RungResult, SensorNoise,
};
pub(crate) use result::GENERATOR;
pub use result::{
    CrossCheckResult, CutoffChoice, CutoffPoint, EncoderOffsetResult, ErrorParts, EstimateResult,
    Identification, ModelDependence, MotorRowResult, ParameterEstimate, SettingsUsed,
    SimulationFit, parameters_csv,
};
pub use verdict::{Decision, Verdict};

pub use crate::fit::{fit, residual, torques, trace};
pub use crate::frequency::{
    Feature, FeatureKind, FrequencyResponse, JointResponse, ResponseCurves, SpringFromMotor, Unseen,
};
