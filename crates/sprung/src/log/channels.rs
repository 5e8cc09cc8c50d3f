//! Which columns hold what, and how they become SI units on the output side.

use sprung_core::chain::JointKind;

use crate::description::{Delay, Joint, Log, Robot, Side};

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

/// One column of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name of the column.
    pub column: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Joint, from 0.
    pub joint: usize,
    /// The cell times this is the quantity in SI units.
    pub factor: f64,
    /// How much later than the others it was recorded.
    pub delay: Option<Delay>,
}

/// The channels of a log: links, motors and torques, joint by joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Name of the column of the time.
    pub time: String,
    /// The cell times this is the time in s.
    pub time_factor: f64,
    /// Link, motor and torque channels.
    pub all: Vec<Channel>,
    /// Whether the torques are those that acted, as commands are, without noise.
    pub exact_torque: bool,
    /// Whether each joint is rigid: its motor's position is its link's.
    pub rigid: Vec<bool>,
    /// Whether each joint turns; otherwise it slides.
    pub turns: Vec<bool>,
    /// What is added to positions of links and motors, rad, \[n\].
    pub offsets: Vec<f64>,
    /// From positions of the motors to those of the joints, if they are
    /// recorded before a coupled transmission.
    pub position_mix: Option<Mix>,
    /// From torques of the motors to those of the joints, likewise.
    pub torque_mix: Option<Mix>,
}

/// A linear change of coordinates, and back.
#[derive(Clone, Debug, PartialEq)]
pub struct Mix {
    /// From the log to the joints, \[n × n\], row by row.
    pub forward: Vec<Vec<f64>>,
    /// From the joints to the log.
    pub back: Vec<Vec<f64>>,
}

impl Mix {
    /// Returns a matrix times a vector.
    #[must_use]
    pub fn apply(matrix: &[Vec<f64>], values: &[f64]) -> Vec<f64> {
        let product = |row: &Vec<f64>| row.iter().zip(values).map(|(a, x)| a * x).sum();
        matrix.iter().map(product).collect()
    }
}

/// What a description leaves open about a log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ChannelError {
    /// A quantity has no columns.
    #[error("[log] does not say which columns hold {what}; add {keys}")]
    NotSaid {
        /// The quantity.
        what: &'static str,
        /// The keys that say it.
        keys: &'static str,
    },
    /// Currents or voltages cannot become torques.
    #[error("{joint}: {key} is needed to turn the log's {unit} into motor torque")]
    NoConstant {
        /// Name of the joint.
        joint: String,
        /// The key that is missing.
        key: &'static str,
        /// What the log holds.
        unit: &'static str,
    },
}

impl Channels {
    /// Returns the channels that a description names.
    ///
    /// # Errors
    ///
    /// [`ChannelError`] if a quantity is not named or not convertible.
    pub fn new(robot: &Robot, log: &Log) -> Result<Self, ChannelError> {
        let (time, time_factor) = match (&log.time_s, &log.time_ms) {
            (Some(column), _) => (column.clone(), 1.0),
            (None, Some(column)) => (column.clone(), 1e-3),
            (None, None) => {
                return Err(ChannelError::NotSaid {
                    what: "the time",
                    keys: "time_s or time_ms",
                });
            }
        };
        let mut all = Vec::new();
        for columns in [link(robot, log)?, motor(robot, log)?, torque(robot, log)?] {
            for (quantity, joint, column, factor) in columns {
                let sign = log.sign.get(column).copied().unwrap_or(1.0);
                all.push(Channel {
                    column: column.clone(),
                    quantity,
                    joint,
                    factor: factor * sign,
                    delay: log.delay_s.get(column).copied(),
                });
            }
        }
        Ok(Self {
            time,
            time_factor,
            all,
            exact_torque: log.motor_torque_exact,
            rigid: robot
                .joint
                .iter()
                .map(|joint| !joint.is_flexible())
                .collect(),
            turns: (0..robot.joint.len())
                .map(|i| robot.kind(i) == JointKind::Revolute)
                .collect(),
            offsets: (robot.joint.iter())
                .map(|joint| joint.position_offset_deg.to_radians())
                .collect(),
            position_mix: mixed(robot, log.motor_position_side).map(|(ratios, inverse)| Mix {
                forward: inverse,
                back: ratios,
            }),
            torque_mix: mixed(robot, torque_side(robot, log)).map(|(ratios, inverse)| Mix {
                forward: transposed(&ratios),
                back: transposed(&inverse),
            }),
        })
    }

    /// Returns the index in [`Channels::all`] of a joint's channel.
    #[must_use]
    pub fn index(&self, quantity: Quantity, joint: usize) -> Option<usize> {
        self.all
            .iter()
            .position(|c| c.quantity == quantity && c.joint == joint)
    }

    /// Returns the channels with the meanings of a joint's link and motor
    /// columns exchanged, for testing that suspicion; nothing if the link is
    /// logged as deflection. Blocks keep their order.
    #[must_use]
    pub fn exchanged(&self, joint: usize) -> Option<Self> {
        let link = self.index(Quantity::LinkPosition, joint)?;
        let motor = self.index(Quantity::MotorPosition, joint)?;
        let mut exchanged = self.clone();
        exchanged.all[link].quantity = Quantity::MotorPosition;
        exchanged.all[motor].quantity = Quantity::LinkPosition;
        Some(exchanged)
    }
}

/// Quantity, joint, column and factor to SI units of each channel.
type Columns<'a> = Vec<(Quantity, usize, &'a String, f64)>;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Joins the columns of a list with the joints of a kind that they speak of.
fn of_kind<'a>(
    robot: &Robot,
    (kind, quantity): (JointKind, Quantity),
    wanted: impl Fn(&Joint) -> bool,
    columns: Option<&'a [String]>,
    factor: impl Fn(&Joint) -> f64,
) -> Columns<'a> {
    (robot.joint.iter().enumerate())
        .filter(|(i, joint)| robot.kind(*i) == kind && wanted(joint))
        .zip(columns.unwrap_or_default())
        .map(|((i, joint), column)| (quantity, i, column, factor(joint)))
        .collect()
}

fn link<'a>(robot: &Robot, log: &'a Log) -> Result<Columns<'a>, ChannelError> {
    let turning = [
        (&log.link_position_rad, Quantity::LinkPosition, 1.0),
        (&log.link_position_deg, Quantity::LinkPosition, DEGREE),
        (&log.link_deflection_rad, Quantity::LinkDeflection, 1.0),
        (&log.link_deflection_deg, Quantity::LinkDeflection, DEGREE),
    ]
    .into_iter()
    .find_map(|(columns, quantity, unit)| Some((Some(columns.as_deref()?), quantity, unit)));
    let (columns, quantity, unit) = turning.unwrap_or((None, Quantity::LinkPosition, 1.0));
    let sliding = log.link_position_m.as_deref();
    let flexible = Joint::is_flexible;
    let mut all = of_kind(
        robot,
        (JointKind::Revolute, quantity),
        flexible,
        columns,
        |_| unit,
    );
    let of_sliding = (JointKind::Prismatic, Quantity::LinkPosition);
    all.extend(of_kind(robot, of_sliding, flexible, sliding, |_| 1.0));
    let keys = [
        "link_position_rad or link_deflection_rad",
        "link_position_m",
    ];
    complete(robot, flexible, &all, "the link positions", keys)?;
    Ok(all)
}

fn motor<'a>(robot: &Robot, log: &'a Log) -> Result<Columns<'a>, ChannelError> {
    let scale = |joint: &Joint| match log.motor_position_side.unwrap_or_default() {
        Side::Output => 1.0,
        Side::Motor => 1.0 / joint.ratio(),
    };
    let own = [
        (&log.motor_position_rad, 1.0),
        (&log.motor_position_deg, DEGREE),
        // A rigid robot may call its only positions those of the links.
        (&log.link_position_rad, 1.0),
        (&log.link_position_deg, DEGREE),
    ];
    let rigid = robot.joint.iter().all(|joint| !joint.is_flexible());
    let given = if rigid { &own[..] } else { &own[..2] };
    let (columns, unit) = (given.iter())
        .find_map(|(columns, unit)| Some((Some(columns.as_deref()?), *unit)))
        .unwrap_or((None, 1.0));
    let sliding =
        (log.motor_position_m.as_deref()).or(log.link_position_m.as_deref().filter(|_| rigid));
    let every = |_: &Joint| true;
    let of = |kind| (kind, Quantity::MotorPosition);
    let mut all = of_kind(robot, of(JointKind::Revolute), every, columns, |joint| {
        unit * scale(joint)
    });
    all.extend(of_kind(
        robot,
        of(JointKind::Prismatic),
        every,
        sliding,
        scale,
    ));
    let keys = ["motor_position_rad", "motor_position_m"];
    complete(robot, every, &all, "the motor positions", keys)?;
    Ok(all)
}

fn torque<'a>(robot: &Robot, log: &'a Log) -> Result<Columns<'a>, ChannelError> {
    let converted = |columns: &'a [String], unit, factor: fn(&Joint) -> Option<f64>| {
        (robot.joint.iter().zip(columns).enumerate())
            .map(|(i, (joint, column))| {
                let factor = factor(joint).ok_or_else(|| ChannelError::NoConstant {
                    joint: joint.name.clone(),
                    key: match joint.torque_constant_nm_per_a {
                        None => "torque_constant_nm_per_a",
                        Some(_) => "amplifier_gain_a_per_v",
                    },
                    unit,
                })?;
                Ok((Quantity::MotorTorque, i, column, factor))
            })
            .collect::<Result<Vec<_>, ChannelError>>()
    };
    let every = |_: &Joint| true;
    let scale = |joint: &Joint| match log.motor_torque_side.unwrap_or_default() {
        Side::Output => 1.0,
        Side::Motor => joint.ratio(),
    };
    let (turning, sliding) = (log.motor_torque_nm.as_deref(), log.motor_force_n.as_deref());
    let of = |kind| (kind, Quantity::MotorTorque);
    let all = if turning.is_some() || sliding.is_some() {
        let mut all = of_kind(robot, of(JointKind::Revolute), every, turning, scale);
        all.extend(of_kind(
            robot,
            of(JointKind::Prismatic),
            every,
            sliding,
            scale,
        ));
        all
    } else if let Some(columns) = &log.motor_current_a {
        converted(columns, "currents", Joint::torque_per_ampere)?
    } else if let Some(columns) = &log.drive_voltage_v {
        converted(columns, "voltages", Joint::torque_per_volt)?
    } else {
        Vec::new()
    };
    let keys = [
        "motor_torque_nm, motor_current_a or drive_voltage_v",
        "motor_force_n",
    ];
    complete(robot, every, &all, "the motor torques", keys)?;
    Ok(all)
}

/// Checks that every joint that needs a column has one.
fn complete(
    robot: &Robot,
    wanted: impl Fn(&Joint) -> bool,
    all: &Columns<'_>,
    what: &'static str,
    [turning, sliding]: [&'static str; 2],
) -> Result<(), ChannelError> {
    let missing = (robot.joint.iter().enumerate())
        .find(|(i, joint)| wanted(joint) && !all.iter().any(|(_, own, ..)| own == i));
    match missing {
        None => Ok(()),
        Some((i, _)) => Err(ChannelError::NotSaid {
            what,
            keys: match robot.kind(i) {
                JointKind::Revolute => turning,
                JointKind::Prismatic => sliding,
            },
        }),
    }
}

/// Returns the side on which torques were recorded, or that of the torque
/// constants which make them of currents.
fn torque_side(robot: &Robot, log: &Log) -> Option<Side> {
    if log.motor_torque_nm.is_some() || log.motor_force_n.is_some() {
        log.motor_torque_side
    } else {
        robot.joint.first().map(|joint| joint.torque_constant_side)
    }
}

/// Returns the ratios of a coupled transmission and their inverse, if a
/// quantity was recorded before it.
#[expect(clippy::type_complexity, reason = "a matrix and its inverse")]
fn mixed(robot: &Robot, side: Option<Side>) -> Option<(Vec<Vec<f64>>, Vec<Vec<f64>>)> {
    let ratios = robot.transmission_matrix.as_ref()?;
    if side.unwrap_or_default() == Side::Output {
        return None;
    }
    let n = ratios.len();
    let matrix = faer::Mat::from_fn(n, n, |i, j| ratios[i][j]);
    let inverse = {
        use faer::linalg::solvers::DenseSolveCore;
        matrix.partial_piv_lu().inverse()
    };
    let rows = (0..n).map(|i| (0..n).map(|j| inverse[(i, j)]).collect());
    Some((ratios.clone(), rows.collect()))
}

fn transposed(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..matrix.len())
        .map(|j| matrix.iter().map(|row| row[j]).collect())
        .collect()
}
