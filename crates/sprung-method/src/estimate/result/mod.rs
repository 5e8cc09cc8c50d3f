//! Types that are written to JSON.

mod applied;
mod identification;
mod log_info;
mod payload;
mod physical;
mod promise;
mod refinement;
mod shown;
mod springs;
mod verdict;

pub use applied::Applied;
pub(crate) use identification::GENERATOR;
pub(super) use identification::PartResult;
pub use identification::{
    CrossCheckResult, CutoffChoice, CutoffPoint, EncoderOffsetResult, ErrorParts, EstimateResult,
    IDENTIFICATION_FORMAT, Identification, ModelDependence, MotorRowResult, ParameterEstimate,
    SettingsUsed, parameters_csv,
};
pub use log_info::{DelayUsed, GainUsed, LogInfo, SignUsed};
pub use payload::{PayloadParameter, PayloadResult};
pub use physical::{CovarianceOfErrors, Decided, PhysicalResult, StandardParameter};
pub use promise::JointPrediction;
pub use refinement::{
    HeldOutResidual, PreslidingPrior, RefinedDelay, RefinedOffset, RefinedSharpness,
    RefinedVelocity, Refinement, RowDisturbance, RungResult, SensorNoise,
};
pub use springs::{RigidByHoldOut, RigidJoint, SensedSpring};
pub use verdict::{Decision, Verdict};
