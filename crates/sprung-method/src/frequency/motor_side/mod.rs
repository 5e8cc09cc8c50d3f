//! Springs of joints without link sensor, by the vibrations of the motors.
//!
//! About a pose, links and motors obey linear equations. The link positions are unknown, so the
//! response from torques to motor positions gives the matrices:
//!
//! ```text
//! (M s² + D_l s + K) q − K φ = a + b s
//! (J s² + D_m s + K) φ − K q = τ − F σ + c + d s
//! ```
//!
//! σ is the spectrum of the directions of motion with the size F of dry friction. a to d belong to the
//! states at both ends of the log; with them the equations hold exactly for a log of finite duration.
//!
//! # Source
//!
//! Pintelon and Schoukens, "System Identification: A Frequency Domain Approach", 2nd edition, 2012,
//! Sections 6.3 (transients) and 9.4 (weighted nonlinear least squares).

mod descent;
mod equations;
mod inverse;
mod lines;
mod search;
mod springs;
mod start;

pub use springs::SpringFromMotor;
pub(crate) use springs::{about_springs, springs_from_motor};
