//! What a channel measures.

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Link position q, rad.
    LinkPosition,
    /// Deflection q - phi, rad.
    LinkDeflection,
    /// Motor position phi after the gearbox, rad.
    MotorPosition,
    /// Motor torque tau after the gearbox, N·m.
    MotorTorque,
}

impl Quantity {
    /// Returns whether it is a position or a difference of positions.
    #[must_use]
    pub fn is_position(self) -> bool {
        self != Self::MotorTorque
    }

    /// Returns the name of its key in `[log]`, without unit.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::LinkPosition => "link_position",
            Self::LinkDeflection => "link_deflection",
            Self::MotorPosition => "motor_position",
            Self::MotorTorque => "motor_torque",
        }
    }

    /// Returns its unit.
    ///
    /// - `turns`: whether the joint turns; otherwise it slides.
    #[must_use]
    pub fn unit(self, turns: bool) -> &'static str {
        match (self.is_position(), turns) {
            (true, true) => "rad",
            (true, false) => "m",
            (false, true) => "N·m",
            (false, false) => "N",
        }
    }
}
