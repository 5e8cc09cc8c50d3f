//! Estimators: from the regression of the logs to parameters, standard errors, findings and a
//! verdict. `identify` makes the steps of `steps`.

mod errors;
mod estimators;
mod identify;
mod judge;
mod laws;
mod nuisances;
mod payload;
mod physical;
mod possible;
mod posterior;
mod refined_unknowns;
mod result;
mod springs;
mod statistics;
mod steps;
mod sums;

pub use errors::{IdentifyError, LsffError};
pub use estimators::lsff::Lsff;
pub use estimators::prediction_error::{Bound, KnownNoise, KnownTruth, information_bound};
pub use identify::{identify, identify_and_tell};
pub use judge::{percent, predictions};
pub use posterior::{Body, DrawMethod, Posterior, PosteriorError, Samples};
pub(crate) use result::GENERATOR;
pub use result::{
    Applied, CovarianceOfErrors, CrossCheckResult, CutoffChoice, CutoffPoint, Decided, Decision,
    DelayUsed, EncoderOffsetResult, ErrorParts, EstimateResult, GainUsed, HeldOutResidual,
    IDENTIFICATION_FORMAT, Identification, JointPrediction, LogInfo, ModelDependence,
    MotorRowResult, ParameterEstimate, PayloadParameter, PayloadResult, PhysicalResult,
    PreslidingPrior, RefinedDelay, RefinedOffset, RefinedSharpness, RefinedVelocity, Refinement,
    RigidByHoldOut, RigidJoint, RowDisturbance, RungResult, SensedSpring, SensorNoise,
    SettingsUsed, SignUsed, StandardParameter, Verdict, parameters_csv,
};
pub use springs::with_rigid_joints;
pub use statistics::NORMAL_95;
pub(crate) use statistics::{between_parts, both_tails};
pub use steps::Identified;

pub use crate::fit::{fit, residual, torques, trace};
pub use crate::frequency::SpringFromMotor;
