//! From a system to parameters, and how far to trust them.

mod delay;
mod describe;
mod identify;
mod judge;
mod least_squares;
mod lsff;
mod result;
mod second_look;

pub use delay::{DelayEstimate, Excerpt, MotorRowFit, estimate_delays, fit_motor_rows};
pub use identify::{Identified, IdentifyError, identify};
pub use judge::{Suspicion, UNEXPLAINED, Verdict, judge, suspect};
pub use least_squares::{Fitted, MotorRow, fit, residual, torques, trace};
pub use lsff::{Lsff, LsffError};
pub use result::{
    DelayUsed, EstimateResult, GENERATOR, Identification, LogInfo, MotorRowResult,
    ParameterEstimate, SettingsUsed, parameters_csv,
};
