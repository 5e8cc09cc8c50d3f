//! `[robot]`: kinematics, joints, drives, nominal values.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sprung_core::chain::{ChainJoint, DhRow, JointKind};
use sprung_core::covariate::Covariate;
use sprung_core::friction::Family;
use sprung_core::parameters::JointParameter;
use sprung_core::spatial::BODY;

use super::friction::FrictionLaw;
use super::friction_covariates::FrictionCovariates;
use super::identify::Laws;
use super::known_words::choose;
use super::limits::Limits;
use super::nominal::Nominal;
use super::servo::ServoDrive;
use super::urdf::{NoShape, Shape};

/// The robot: its kinematics, joints and drives.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Robot {
    /// Name for reports.
    #[serde(default = "unnamed")]
    pub name: String,
    /// Kinematics in closed form: `planar-2r`, the paper's arm with two joints
    /// in a horizontal plane.
    pub kinematics: Option<Kinematics>,
    /// URDF file of the robot; relative to the experiment file.
    pub urdf: Option<PathBuf>,
    /// Modified Denavit-Hartenberg table (Craig), one row per joint: twist and length are those of
    /// the link before the joint.
    pub dh_modified: Option<Vec<DhJoint>>,
    /// Classic Denavit-Hartenberg table, one row per joint.
    pub dh_classic: Option<Vec<DhJoint>>,
    /// Acceleration of free fall in the base frame; [0, 0, -9.81] if absent.
    pub gravity_m_per_s2: Option<[f64; 3]>,
    /// Motor turns per joint turn of a coupled transmission, one row per motor and one column per
    /// joint, for wrists in which a motor turns several joints; replaces `gear_ratio`.
    pub transmission_matrix: Option<Vec<Vec<f64>>>,
    /// Inertial parameters that are zero, for example by symmetry: `link2.my`.
    #[serde(default)]
    pub assume_zero: Vec<String>,
    /// Known values by name, SI units; they are not estimated.
    #[serde(default)]
    pub fixed: BTreeMap<String, f64>,
    /// Keys of `[[robot.joint]]` for all joints that do not give them, such as `gear_ratio`.
    #[serde(default, rename = "joint_defaults")]
    #[schemars(schema_with = "super::defaults::schema")]
    pub(super) _joint_defaults: toml::Table,
    /// Joints that moved in the log, base first; sprung treats all other joints of a URDF as fixed.
    #[serde(default)]
    pub joint: Vec<Joint>,
    /// Nominal values of link inertial parameters, by name, SI units.
    #[serde(default)]
    pub nominal: BTreeMap<String, f64>,
    /// The tree of joints that the URDF file or the table describes.
    #[serde(skip)]
    pub tree: Option<Tree>,
}

impl Robot {
    /// Returns whether any joint has a spring.
    #[must_use]
    pub fn has_springs(&self) -> bool {
        self.joint.iter().any(Joint::is_flexible)
    }

    /// Returns the kind of a joint by its index.
    #[must_use]
    pub fn kind(&self, joint: usize) -> JointKind {
        let table = self.dh_modified.as_ref().or(self.dh_classic.as_ref());
        match (&self.tree, table) {
            (Some(tree), _) => (tree.joints.get(joint)).map_or(JointKind::Revolute, |j| j.kind),
            (None, Some(rows)) if rows.get(joint).is_some_and(|row| row.prismatic) => {
                JointKind::Prismatic
            }
            _ => JointKind::Revolute,
        }
    }

    /// Returns the torque that the back-EMF of a joint's voltage drive takes from the motor, over the
    /// velocity of the motor after its gear, N·m·s/rad (N·s/m): `K_t K_e / R`, reduced to the output
    /// by the square of the gear ratio. `None` if the joint has no voltage drive.
    #[must_use]
    pub fn back_emf(&self, joint: usize) -> Option<f64> {
        let of = &self.joint[joint];
        let ratio = match (&self.transmission_matrix, of.side_of_constant()) {
            (_, Side::Output) => 1.0,
            (Some(matrix), Side::Motor) => matrix[joint][joint],
            (None, Side::Motor) => of.ratio(),
        };
        let constant = of.torque_constant_nm_per_a? * of.back_emf_vs_per_rad?;
        Some(ratio * ratio * constant / of.winding_resistance_ohm?)
    }

    /// Returns whether the side of the torque constant of a joint is relevant and not given.
    #[must_use]
    pub fn is_torque_side_open(&self, joint: usize) -> bool {
        let of = &self.joint[joint];
        let has_gear = self.transmission_matrix.is_some()
            || (of.gear_ratio).is_some_and(|ratio| (ratio - 1.0).abs() > f64::EPSILON);
        of.torque_constant_side.is_none() && has_gear && of.torque_constant_nm_per_a.is_some()
    }

    /// Writes the side of the gearbox of the torque constants into joints for which it is open.
    pub fn settle_torque_side(&mut self, side: Side) {
        for joint in 0..self.joint.len() {
            if self.is_torque_side_open(joint) {
                self.joint[joint].torque_constant_side = Some(side);
            }
        }
    }

    /// Returns the limits of a joint: its own, those of its amplifier, then those of the URDF.
    #[must_use]
    pub fn limits(&self, joint: usize) -> Limits {
        let of = &self.joint[joint];
        let amplifier = Limits {
            torque_nm: of.torque_limit(),
            ..Limits::default()
        };
        let tree = self.tree.as_ref().and_then(|tree| tree.limits.get(joint));
        let limits = of.limits.unwrap_or_default().or(amplifier);
        limits.or(tree.copied().unwrap_or_default())
    }

    /// Returns the acceleration of free fall in the base frame, m/s².
    #[must_use]
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity_m_per_s2.unwrap_or([0.0, 0.0, -9.81])
    }
}

/// A tree of joints, and the links that its file describes.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The joints, in the order of [`Robot::joint`].
    pub joints: Vec<ChainJoint>,
    /// Names of their links.
    pub links: Vec<String>,
    /// Inertial parameters of the links in their joints' frames, if given.
    pub inertial: Vec<Option<[f64; BODY]>>,
    /// Shapes of the links in their joints' frames, or why they are not known.
    pub shapes: Vec<Result<Shape, NoShape>>,
    /// Limits of the joints that the file gives.
    pub limits: Vec<Limits>,
}

/// One row of a Denavit-Hartenberg table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(default)]
pub struct DhJoint {
    /// Twist alpha, degrees.
    pub alpha_deg: f64,
    /// Length a, m.
    pub a_m: f64,
    /// Offset d, m.
    pub d_m: f64,
    /// Angle theta at position zero, degrees.
    pub theta_deg: f64,
    /// Whether the joint is prismatic.
    pub prismatic: bool,
}

impl DhJoint {
    /// Returns the row in radians.
    #[must_use]
    pub fn row(&self) -> DhRow {
        DhRow {
            alpha: self.alpha_deg.to_radians(),
            a: self.a_m,
            d: self.d_m,
            theta: self.theta_deg.to_radians(),
        }
    }
}

fn unnamed() -> String {
    "unnamed robot".to_owned()
}

/// Kinematics in closed form.
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
        choose("kinematics", &word, &["planar-2r"]).map(|_| Self::Planar2R)
    }
}

/// One joint.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Joint {
    /// Name, unique; with `urdf` the name of the joint in that file.
    pub name: String,
    /// Motor torque `K_t` per current, on the side of `torque_constant_side`, N·m/A.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Side of the gearbox for which the torque constant holds; `output` if it contains the gear
    /// ratio. It may be absent if the gear ratio is 1, or if the masses of the links tell the side.
    pub torque_constant_side: Option<Side>,
    /// Motor turns per output turn; 1 if absent.
    pub gear_ratio: Option<f64>,
    /// Current per command voltage of an amplifier that controls the current, A/V.
    pub amplifier_gain_a_per_v: Option<f64>,
    /// Resistance of the winding of a voltage drive, ohm: the amplifier applies a voltage, and the
    /// current is the voltage without the back-EMF over the resistance.
    pub winding_resistance_ohm: Option<f64>,
    /// Back-EMF of a voltage drive per velocity of the motor, on the side of
    /// `torque_constant_side`, V·s/rad; in these units it equals the torque constant of a motor
    /// without losses.
    pub back_emf_vs_per_rad: Option<f64>,
    /// Voltage that the amplifier of a voltage drive applies, per command voltage; 1 if absent.
    pub amplifier_gain_v_per_v: Option<f64>,
    /// Limit of the amplifier's command voltage, V; no limit if absent.
    pub amplifier_limit_v: Option<f64>,
    /// Added to the logged positions of a revolute joint to reach the model's zero, degrees.
    #[serde(default)]
    pub position_offset_deg: f64,
    /// `flexible`: a spring between motor and link; `rigid`: no spring.
    #[serde(default)]
    pub transmission: Transmission,
    /// Terms of the spring; `["linear"]` if absent.
    pub spring: Option<Vec<SpringTerm>>,
    /// Friction of the link's bearing; if absent `["viscous", "coulomb"]`, and `[]` for a rigid
    /// joint.
    pub link_friction: Option<Vec<FrictionLaw>>,
    /// Friction of motor and gear; if absent `["viscous", "coulomb"]`, and also `"offset"` for a
    /// rigid joint.
    pub motor_friction: Option<Vec<FrictionLaw>>,
    /// Velocity at which Stribeck friction has fallen to 1/e, rad/s (m/s). If absent, a search in the
    /// log determines it, and the refinement estimates it with the parameters.
    pub stribeck_velocity_rad_per_s: Option<f64>,
    /// Width of the widest of the six elements of presliding friction, rad (m). If absent, 0.2 s times the root mean
    /// square of the velocity of the joint in the log.
    pub presliding_width_rad: Option<f64>,
    /// Width of the widest of the six elements of the spring's hysteresis, rad (m): the deflection from the middle until it
    /// slides. If absent, twice the standard deviation of the deflection in the log, at most a quarter of its range.
    pub hysteresis_width_rad: Option<f64>,
    /// Half of the play in series with the spring, rad (m); a search in the log determines it if absent.
    pub play_half_width_rad: Option<f64>,
    /// Deflection in the middle of the play, rad (m). If absent, a search finds it with the half width; with a given half width it
    /// is zero.
    pub play_centre_rad: Option<f64>,
    /// Beta of the Coulomb friction `tanh(beta * velocity)`, s/rad (s/m). If absent, 100, and the refinement estimates
    /// it with the parameters.
    pub coulomb_sharpness_s_per_rad: Option<f64>,
    /// Rotation of the gyroscope in the frame of the link: roll, pitch and yaw, degrees, as in a URDF. If absent,
    /// sprung finds it.
    pub gyroscope_rpy_deg: Option<[f64; 3]>,
    /// Rotation of the accelerometer in the frame of the link: roll, pitch and yaw, degrees, as in a URDF. If absent,
    /// `sprung check` shows the one that fits the motion of the motors best, and `identify` refuses the log.
    pub accelerometer_rpy_deg: Option<[f64; 3]>,
    /// Place of the accelerometer in the frame of the link, m; shown with its rotation if absent.
    pub accelerometer_xyz_m: Option<[f64; 3]>,
    /// Drive law of a position servo, for logs with targets and no torque.
    pub servo: Option<ServoDrive>,
    /// Quantities on which friction depends linearly.
    pub friction_covariates: Option<FrictionCovariates>,
    /// Laws beyond the declared ones; `laws` of `[identify]` if absent.
    pub laws: Option<Laws>,
    /// Limits for the design of experiments; those of the URDF if absent.
    pub limits: Option<Limits>,
    /// Nominal values.
    #[serde(default)]
    pub nominal: Nominal,
    /// What the log shows of it.
    #[serde(skip)]
    pub seen: Seen,
}

/// What a log shows of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Seen {
    /// What the file describes.
    #[default]
    AsDescribed,
    /// No spring. The joint is rigid then, and its columns of the link stay in the lists of columns without use.
    WithoutSpring,
    /// The torque of the spring and not that of the motor. The equations are those of the link then: its position and the
    /// torque of the spring take the places of the motor's.
    OnLinkSide,
}

impl Joint {
    /// Beta of a Coulomb friction for which the description gives none, s/rad (s/m).
    pub const USUAL_SHARPNESS: f64 = 100.0;

    /// Returns beta of the Coulomb friction: the given one or the usual one, s/rad (s/m).
    #[must_use]
    pub fn sharpness(&self) -> f64 {
        self.coulomb_sharpness_s_per_rad
            .unwrap_or(Self::USUAL_SHARPNESS)
    }

    /// Returns whether a friction parameter changes with a covariate.
    #[must_use]
    pub fn changes(&self, friction: JointParameter, with: Covariate) -> bool {
        (self.friction_covariates.iter())
            .flat_map(|covariates| covariates.of(with).0)
            .any(|name| name == friction.name())
    }

    /// Returns whether a friction parameter changes with a covariate.
    #[must_use]
    pub fn depends_on(&self, covariate: Covariate) -> bool {
        (self.friction_covariates.iter()).any(|covariates| !covariates.of(covariate).0.is_empty())
    }

    /// Returns the references of all covariates; zero for those on which no friction depends.
    #[must_use]
    pub fn references(&self) -> [f64; Covariate::COUNT] {
        Covariate::ALL.map(|covariate| {
            let covariates = self.friction_covariates.as_ref();
            covariates
                .and_then(|covariates| covariates.of(covariate).1)
                .unwrap_or(0.0)
        })
    }

    /// Returns the motor turns per output turn.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.gear_ratio.unwrap_or(1.0)
    }

    /// Returns the side of the gearbox for which the torque constant holds; `Output` while it is open.
    #[must_use]
    pub fn side_of_constant(&self) -> Side {
        self.torque_constant_side.unwrap_or_default()
    }

    /// Returns the motor torque per current on the output side, N·m/A, if the
    /// torque constant is given.
    ///
    /// # Source
    ///
    /// Eq. (3); the paper does not state the side of the gearbox for its `K_m`.
    #[must_use]
    pub fn torque_per_ampere(&self) -> Option<f64> {
        let ratio = match self.side_of_constant() {
            Side::Output => 1.0,
            Side::Motor => self.ratio(),
        };
        Some(ratio * self.torque_constant_nm_per_a?)
    }

    /// Returns the motor torque per command voltage on the output side, N·m/V, if the constants are
    /// given. That of a voltage drive is the torque at standstill; its back-EMF is a parameter of
    /// the model.
    ///
    /// # Source
    ///
    /// Eq. (5) for an amplifier that controls the current. An amplifier that applies a voltage has
    /// `1/R` in place of `K_sa`.
    #[must_use]
    pub fn torque_per_volt(&self) -> Option<f64> {
        let current_per_volt = match self.winding_resistance_ohm {
            Some(resistance) => self.amplifier_gain_v_per_v.unwrap_or(1.0) / resistance,
            None => self.amplifier_gain_a_per_v?,
        };
        Some(self.torque_per_ampere()? * current_per_volt)
    }

    /// Returns the largest motor torque, N·m, if the command voltage of the amplifier is limited.
    #[must_use]
    pub fn torque_limit(&self) -> Option<f64> {
        Some((self.amplifier_limit_v? * self.torque_per_volt()?).abs())
    }
}

/// A side of the gearbox.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(extend("enum" = ["output", "motor"]))]
pub enum Side {
    /// After the gearbox.
    #[default]
    Output,
    /// Before the gearbox.
    Motor,
}

impl Side {
    /// Returns its word in an experiment file.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Output => "output",
            Self::Motor => "motor",
        }
    }
}

impl From<Side> for String {
    fn from(side: Side) -> Self {
        side.word().to_owned()
    }
}

impl TryFrom<String> for Side {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("side", &word, &["output", "motor"])?;
        Ok([Self::Output, Self::Motor][index])
    }
}

/// Transmission of a joint: with or without a spring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["flexible", "rigid"]))]
pub enum Transmission {
    /// A spring between motor and link, each with a position.
    #[default]
    Flexible,
    /// No spring: motor and link have one position.
    Rigid,
}

impl TryFrom<String> for Transmission {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("transmission", &word, &["flexible", "rigid"])?;
        Ok([Self::Flexible, Self::Rigid][index])
    }
}

/// A term of a joint's spring torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["linear", "cubic", "damping", "hysteresis", "play"]))]
pub enum SpringTerm {
    /// Torque proportional to the deflection.
    Linear,
    /// An added torque proportional to the third power of the deflection.
    Cubic,
    /// An added torque proportional to the rate of the deflection.
    Damping,
    /// An added torque that grows with the deflection after a reversal until it slides: elastic elements of six widths.
    Hysteresis,
    /// A play in series with the spring: no torque within it.
    Play,
}

impl SpringTerm {
    /// All terms.
    pub const ALL: [Self; 5] = [
        Self::Linear,
        Self::Cubic,
        Self::Damping,
        Self::Hysteresis,
        Self::Play,
    ];

    /// Returns the word of the term in a description.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Cubic => "cubic",
            Self::Damping => "damping",
            Self::Hysteresis => "hysteresis",
            Self::Play => "play",
        }
    }
}

impl TryFrom<String> for SpringTerm {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let words = Self::ALL.map(Self::word);
        Ok(Self::ALL[choose("spring term", &word, &words)?])
    }
}

impl Joint {
    /// Returns whether the joint has a spring.
    #[must_use]
    pub fn is_flexible(&self) -> bool {
        self.is_described_flexible() && self.seen == Seen::AsDescribed
    }

    /// Returns whether the log has the torque of its spring and not that of its motor.
    #[must_use]
    pub fn is_on_link_side(&self) -> bool {
        self.seen == Seen::OnLinkSide
    }

    /// Returns whether the file describes a spring, also if a log does not show it.
    #[must_use]
    pub fn is_described_flexible(&self) -> bool {
        self.transmission == Transmission::Flexible
    }

    /// Returns the joint without its spring: motor and link have one position and one friction, that of the motor with
    /// the laws of the link that it lacks.
    #[must_use]
    pub fn made_rigid(&self) -> Self {
        let mut rigid = self.clone();
        (rigid.seen, rigid.spring, rigid.link_friction) = (Seen::WithoutSpring, None, None);
        if self.motor_friction.is_some() || self.link_friction.is_some() {
            let has_offset = self
                .motor_friction
                .is_none()
                .then_some(FrictionLaw(Family::Offset));
            let all = self.motor_laws().iter().chain(self.link_laws()).copied();
            let mut laws: Vec<FrictionLaw> = Vec::new();
            for law in all.chain(has_offset) {
                let contains = |other: &FrictionLaw| match law.0 {
                    Family::Viscous | Family::ViscousAsymmetric => {
                        matches!(other.0, Family::Viscous | Family::ViscousAsymmetric)
                    }
                    Family::Coulomb | Family::CoulombAsymmetric => {
                        matches!(other.0, Family::Coulomb | Family::CoulombAsymmetric)
                    }
                    Family::Offset
                    | Family::Stribeck
                    | Family::Quadratic
                    | Family::Load
                    | Family::Presliding => *other == law,
                };
                // No deflection measures the load of a rigid joint.
                if law.0 != Family::Load && !laws.iter().any(contains) {
                    laws.push(law);
                }
            }
            rigid.motor_friction = Some(laws);
        }
        rigid
    }

    /// Returns the joint without its motor, for a log with torques of its spring alone. An offset of their sensor has the
    /// column of a constant torque of the link.
    #[must_use]
    pub(crate) fn made_of_link(&self) -> Self {
        let offset = FrictionLaw(Family::Offset);
        let mut laws = self.link_laws().to_vec();
        if self.link_friction.is_none() {
            laws.push(offset);
        }
        Self {
            seen: Seen::OnLinkSide,
            link_friction: Some(laws),
            motor_friction: Some(Vec::new()),
            ..self.clone()
        }
    }

    /// Returns the friction laws of the link's bearing.
    #[must_use]
    pub fn link_laws(&self) -> &[FrictionLaw] {
        const USUAL: &[FrictionLaw] = &[FrictionLaw(Family::Viscous), FrictionLaw(Family::Coulomb)];
        match &self.link_friction {
            Some(laws) => laws,
            None if self.is_flexible() => USUAL,
            None => &[],
        }
    }

    /// Returns the friction laws of motor and gear.
    #[must_use]
    pub fn motor_laws(&self) -> &[FrictionLaw] {
        const USUAL: &[FrictionLaw] = &[
            FrictionLaw(Family::Viscous),
            FrictionLaw(Family::Coulomb),
            FrictionLaw(Family::Offset),
        ];
        match &self.motor_friction {
            Some(laws) => laws,
            None if self.is_flexible() => &USUAL[..2],
            None => USUAL,
        }
    }

    /// Returns the terms of the spring.
    #[must_use]
    pub fn spring_terms(&self) -> &[SpringTerm] {
        match &self.spring {
            Some(terms) => terms,
            None => &[SpringTerm::Linear],
        }
    }
}
