//! From a system to parameters, and how far to trust them.

mod about_logs;
mod beginning;
mod chi_square;
mod cross_check;
mod describe;
mod gravity;
mod held_out;
mod identify;
mod instrumental;
mod jackknife;
mod judge;
mod judge_parameters;
mod judge_scale;
mod late;
mod least_squares;
mod likely_delays;
mod lsff;
mod output_error;
mod prediction_error;
mod progress;
mod refine;
mod result;
mod standard;
mod start;
mod stribeck;
mod sweep;
mod watch;
mod weigh;

pub use about_logs::{DelayUsed, GainUsed, LogInfo, SignUsed};
pub use chi_square::upper_tail;
pub use cross_check::{Route, cross_checks};
pub use describe::NORMAL_95;
pub use gravity::{tilted, worth_a_look};
pub use identify::{Identified, IdentifyError, identify};
pub use judge::{Verdict, judge};
pub use late::late_channels;
pub use least_squares::{Fitted, MotorRow, TorqueOf, fit, fit_quickly, residual, torques, trace};
pub use lsff::{Lsff, LsffError};
pub use progress::Progress;
pub use refine::{KnownNoise, information_bound};
pub use result::{
    CrossCheckResult, CutoffChoice, CutoffPoint, Determined, EncoderOffsetResult, EstimateResult,
    GENERATOR, HeldOutResidual, Identification, MotorRowResult, ParameterEstimate, RefinedDelay,
    RefinedOffset, Refinement, RowDisturbance, SensorNoise, SettingsUsed, SimulationFit,
    StandardParameter, parameters_csv,
};
pub use standard::standard_parameters;
pub use stribeck::find_stribeck;
pub use sweep::sweep;
pub use weigh::find_weights;
