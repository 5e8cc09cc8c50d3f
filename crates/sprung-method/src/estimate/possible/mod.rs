//! Robots that can exist: possible bodies, springs and friction, as a convex set.
//!
//! The estimate minimises the squared residuals of the equations over this set. It has one unknown per inertial
//! parameter of a link, so the result is a full set of parameters. The log decides the base parameters; the nominal
//! values decide the rest.
//!
//! # Source
//!
//! Sousa and Cortesão, "Physical feasibility of robot base inertial parameter identification: a linear
//! matrix inequality approach", International Journal of Robotics Research, 2014. Lee, Wensing and Park,
//! "Geometric robot dynamic identification: a convex programming approach", IEEE Transactions on
//! Robotics, 2020, for the entropic distance.

mod information;
mod limits;
mod prior;
mod robots;
mod search;

pub(in crate::estimate) use information::{Normal, inverse, known, median, ratios};
pub(in crate::estimate) use limits::{Estimated, Limits};
pub(in crate::estimate) use prior::{Beside, Tool};
pub(in crate::estimate) use robots::{MassLimit, Robots, has_sum, must_be_positive};
pub(in crate::estimate) use search::{Possible, squared_distance};
