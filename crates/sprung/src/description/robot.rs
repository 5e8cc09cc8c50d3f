//! `[robot]`: joints, drives, nominal values.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::choice::choose;

/// The robot.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Robot {
    /// Name for reports.
    #[serde(default = "unnamed")]
    pub name: String,
    /// Kinematics: `planar-2r`, the paper's arm with two joints in a
    /// horizontal plane.
    pub kinematics: Kinematics,
    /// Joints, base first.
    #[serde(default)]
    pub joint: Vec<Joint>,
    /// Nominal values of link inertial parameters, by name.
    #[serde(default)]
    pub nominal: BTreeMap<String, f64>,
}

fn unnamed() -> String {
    "unnamed robot".to_owned()
}

/// How the links are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["planar-2r"]))]
pub enum Kinematics {
    /// Two revolute joints with parallel vertical axes.
    Planar2R,
}

impl TryFrom<String> for Kinematics {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        choose("kinematics", &word, &["planar-2r"], &[]).map(|_| Self::Planar2R)
    }
}

/// One joint.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Joint {
    /// Name, unique.
    pub name: String,
    /// Torque of the motor per current, on the side that
    /// `torque_constant_side` says.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Side of the gearbox on which the torque constant holds; `output` when
    /// it already contains the gear ratio.
    #[serde(default)]
    pub torque_constant_side: Side,
    /// Motor turns per output turn.
    #[serde(default = "one")]
    pub gear_ratio: f64,
    /// Current of the amplifier per command voltage.
    pub amplifier_gain_a_per_v: Option<f64>,
    /// Largest command voltage that the amplifier takes; no limit if absent.
    pub amplifier_limit_v: Option<f64>,
    /// beta of the Coulomb friction `tanh(beta * velocity)`.
    #[serde(default = "default_sharpness")]
    pub coulomb_sharpness_s_per_rad: f64,
    /// Values that the maker gives.
    #[serde(default)]
    pub nominal: Nominal,
}

impl Joint {
    /// Returns the motor torque per current on the output side, N·m/A, if the
    /// torque constant is given.
    ///
    /// # Source
    ///
    /// Eq. (3); the paper does not say on which side of the gearbox its `K_m`
    /// holds.
    #[must_use]
    pub fn torque_per_ampere(&self) -> Option<f64> {
        let ratio = match self.torque_constant_side {
            Side::Output => 1.0,
            Side::Motor => self.gear_ratio,
        };
        Some(ratio * self.torque_constant_nm_per_a?)
    }

    /// Returns the motor torque per command voltage on the output side, N·m/V,
    /// if both constants are given.
    ///
    /// # Source
    ///
    /// Eq. (5).
    #[must_use]
    pub fn torque_per_volt(&self) -> Option<f64> {
        Some(self.torque_per_ampere()? * self.amplifier_gain_a_per_v?)
    }

    /// Returns the torque that the amplifier lets through, N·m, if its command
    /// voltage is limited.
    #[must_use]
    pub fn torque_limit(&self) -> Option<f64> {
        Some((self.amplifier_limit_v? * self.torque_per_volt()?).abs())
    }
}

fn one() -> f64 {
    1.0
}

fn default_sharpness() -> f64 {
    100.0
}

/// A side of the gearbox.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["output", "motor"]))]
pub enum Side {
    /// After the gearbox.
    #[default]
    Output,
    /// Before the gearbox.
    Motor,
}

impl TryFrom<String> for Side {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("side", &word, &["output", "motor"], &[])?;
        Ok([Self::Output, Self::Motor][index])
    }
}

/// Values that the maker gives for a joint, SI units.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct Nominal {
    /// Rotor inertia at the output side, kg·m².
    pub rotor_inertia: Option<f64>,
    /// Viscous friction on the link side, N·m·s/rad.
    pub link_viscous: Option<f64>,
    /// Viscous friction on the motor side, N·m·s/rad.
    pub motor_viscous: Option<f64>,
    /// Stiffness, N·m/rad.
    pub stiffness: Option<f64>,
    /// Coulomb friction on the link side, N·m.
    pub link_coulomb: Option<f64>,
    /// Coulomb friction on the motor side, N·m.
    pub motor_coulomb: Option<f64>,
}
