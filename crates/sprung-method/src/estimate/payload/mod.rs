//! The inertial parameters of a body that the robot carried in some of its logs.
//!
//! A body at a link adds its parameters to those of the link. So the parameters of a loaded robot are `θ + C π`: C is
//! the change of theta by the inertial parameters of the link. The equations of the loaded logs and the information
//! about theta of the other logs together give θ and π by least squares. Friction, offsets and preloads of the loaded
//! logs are separate unknowns, because a load changes friction and encoders may have been switched on again.

mod findings;
mod fit;

pub(super) use fit::{Loaded, payload_of};
