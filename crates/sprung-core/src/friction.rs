//! Friction columns, one function per law.
//!
//! A law that is linear in its parameter is a column: the friction torque is
//! the column times the parameter. Stribeck friction is linear in its height
//! but not in its velocity, which stands in [`Shape`].

/// What a law needs to know besides the velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// beta of `tanh(beta v)`, s/rad (s/m), positive.
    pub sharpness: f64,
    /// Velocity at which Stribeck friction has fallen to 1/e, rad/s (m/s),
    /// positive.
    pub stribeck_velocity: f64,
}

/// A friction law with one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Law {
    /// In proportion to the velocity.
    Viscous,
    /// Of one size, against the motion.
    Coulomb,
    /// Of one size and one direction: no friction, but found with it.
    Offset,
    /// Viscous in the positive direction only.
    ViscousPositive,
    /// Viscous in the negative direction only.
    ViscousNegative,
    /// Coulomb in the positive direction only.
    CoulombPositive,
    /// Coulomb in the negative direction only.
    CoulombNegative,
    /// What the friction of a slow joint has beyond Coulomb's.
    Stribeck,
}

impl Law {
    /// Returns the column of the law.
    ///
    /// - `velocity`: rad/s or m/s.
    #[must_use]
    pub fn column(self, velocity: f64, shape: &Shape) -> f64 {
        match self {
            Self::Viscous => viscous(velocity),
            Self::Coulomb => coulomb(velocity, shape.sharpness),
            Self::Offset => 1.0,
            Self::ViscousPositive => viscous(velocity).max(0.0),
            Self::ViscousNegative => viscous(velocity).min(0.0),
            Self::CoulombPositive => coulomb(velocity, shape.sharpness).max(0.0),
            Self::CoulombNegative => coulomb(velocity, shape.sharpness).min(0.0),
            Self::Stribeck => stribeck(velocity, shape),
        }
    }
}

impl Law {
    /// Returns the column of the law and its derivative with respect to the
    /// velocity.
    ///
    /// - `velocity`: rad/s or m/s.
    ///
    /// At zero, where a half begins, the derivative is that of the side where it
    /// acts.
    #[must_use]
    pub fn column_and_slope(self, velocity: f64, shape: &Shape) -> (f64, f64) {
        let transition = || {
            let tanh = coulomb(velocity, shape.sharpness);
            (tanh, shape.sharpness * (1.0 - tanh * tanh))
        };
        let half = |(column, slope): (f64, f64), acts: bool| {
            if acts { (column, slope) } else { (0.0, 0.0) }
        };
        match self {
            Self::Viscous => (velocity, 1.0),
            Self::Coulomb => transition(),
            Self::Offset => (1.0, 0.0),
            Self::ViscousPositive => half((velocity, 1.0), velocity >= 0.0),
            Self::ViscousNegative => half((velocity, 1.0), velocity <= 0.0),
            Self::CoulombPositive => half(transition(), velocity >= 0.0),
            Self::CoulombNegative => half(transition(), velocity <= 0.0),
            Self::Stribeck => {
                let (tanh, slope) = transition();
                let part = velocity / shape.stribeck_velocity;
                let bell = libm::exp(-part * part);
                let falling = -2.0 * part / shape.stribeck_velocity;
                (tanh * bell, bell * (slope + tanh * falling))
            }
        }
    }
}

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

/// Returns the column of Stribeck friction, dimensionless, between -1 and 1:
/// Coulomb's times a bell about zero.
///
/// - `velocity`: rad/s.
///
/// # Source
///
/// Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 1994:
/// `exp(-(v / v_s)²)`.
#[must_use]
pub fn stribeck(velocity: f64, shape: &Shape) -> f64 {
    let part = velocity / shape.stribeck_velocity;
    coulomb(velocity, shape.sharpness) * libm::exp(-part * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape = Shape {
        sharpness: 100.0,
        stribeck_velocity: 0.1,
    };

    const ALL: [Law; 8] = [
        Law::Viscous,
        Law::Coulomb,
        Law::Offset,
        Law::ViscousPositive,
        Law::ViscousNegative,
        Law::CoulombPositive,
        Law::CoulombNegative,
        Law::Stribeck,
    ];

    #[test]
    fn friction_takes_power_at_any_velocity() {
        for velocity in [-3.0, -1e-3, 0.0, 1e-3, 3.0] {
            for law in ALL.into_iter().filter(|law| *law != Law::Offset) {
                assert!(velocity * law.column(velocity, &SHAPE) >= 0.0, "{law:?}");
            }
            assert!(coulomb(velocity, 100.0).abs() <= 1.0);
        }
    }

    #[test]
    fn slopes_are_those_of_the_columns() {
        let h = 1e-6;
        for velocity in [-0.7, -0.02, 0.003, 0.05, 0.4] {
            for law in ALL {
                let (column, slope) = law.column_and_slope(velocity, &SHAPE);
                assert_eq!(
                    column.to_bits(),
                    law.column(velocity, &SHAPE).to_bits(),
                    "{law:?}"
                );
                let ahead = law.column(velocity + h, &SHAPE);
                let behind = law.column(velocity - h, &SHAPE);
                let difference = (ahead - behind) / (2.0 * h);
                assert!((slope - difference).abs() < 1e-5, "{law:?} at {velocity}");
            }
        }
    }

    #[test]
    fn halves_make_a_whole_and_the_bell_is_gone_at_speed() {
        for velocity in [-0.7, -0.02, 0.0, 0.005, 0.4] {
            let column = |law: Law| law.column(velocity, &SHAPE);
            let sum = |a: Law, b: Law| column(a) + column(b);
            let viscous = sum(Law::ViscousPositive, Law::ViscousNegative);
            assert!((viscous - column(Law::Viscous)).abs() < 1e-15);
            let coulomb = sum(Law::CoulombPositive, Law::CoulombNegative);
            assert!((coulomb - column(Law::Coulomb)).abs() < 1e-15);
        }
        let bell = |v: f64| Law::Stribeck.column(v, &SHAPE) / Law::Coulomb.column(v, &SHAPE);
        assert!((bell(0.1) - libm::exp(-1.0)).abs() < 1e-15);
        assert!(bell(1.0) < 1e-40);
    }
}
