//! Friction columns, one function per law.
//!
//! A law that is linear in its parameter is a column: the friction torque is
//! the column times the parameter.

/// Returns the column of viscous friction at `velocity`, in rad/s.
///
/// # Source
///
/// Eq. (1), `F_v`.
#[must_use]
pub fn viscous(velocity: f64) -> f64 {
    velocity
}

/// Returns the column of Coulomb friction, dimensionless, between -1 and 1.
///
/// - `velocity`: rad/s.
/// - `sharpness`: beta, s/rad, positive; the transition is about 2/beta wide.
///
/// # Source
///
/// Eq. (2): `tanh(beta v)`. The paper's `Y_b4` prints positions where
/// velocities belong.
#[must_use]
pub fn coulomb(velocity: f64, sharpness: f64) -> f64 {
    libm::tanh(sharpness * velocity)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_takes_power_at_any_velocity() {
        for velocity in [-3.0, -1e-3, 0.0, 1e-3, 3.0] {
            assert!(velocity * viscous(velocity) >= 0.0);
            assert!(velocity * coulomb(velocity, 100.0) >= 0.0);
            assert!(coulomb(velocity, 100.0).abs() <= 1.0);
        }
    }
}
