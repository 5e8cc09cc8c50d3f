//! Effects that the model lacks, by the equation of each motor: a torque that saturates, and an encoder of the link that is
//! not centred.
//!
//! An encoder with an eccentric disc reads `q + e sin(q + a)`, so the torque of the spring, computed from the reading,
//! lacks `k e sin(q + a)`.

use sprung_core::parameters::JointParameter;

use crate::finding::{Finding, Severity};
use crate::log::{Channels, Quantity};
use crate::model::{Model, Theta};
use crate::numbers::{in_ms, in_percent};
use crate::regression::{Probe, SystemPart, Triangle, solve_quickly};

/// Limits for a torque that saturates: smallest third power of the torque, as part of the torque (root mean squares),
/// and largest remaining part of the squared residuals of its equation. Measured in `benches/verdicts`, seeds 3100 to
/// 3199: 0.02 or more and 0.55 or less for torques that saturate, 0.05 or less and 0.81 or more for models that match.
const SATURATING_PART: f64 = 0.02;
const LEFT_WITH_SATURATION: f64 = 0.6;

/// Smallest part of the third power that is independent of the other columns, and largest unexplained part of the
/// torque. Measured in the same cases: 0.05 and 0.3 for motions that hardly excite the joint, 0.2 or more and 0.03 or
/// less for torques that saturate.
const OWN_PART: f64 = 0.12;
const UNEXPLAINED: f64 = 0.1;

/// Largest remaining part of the squared residuals for an encoder that is not centred, and largest eccentricity, rad.
/// Measured in the same cases: 0.29 or less for eccentricities of 0.0002 to 0.002, and 0.62 or more for models that
/// match, most of them with impossible eccentricities.
const LEFT_WITH_ECCENTRICITY: f64 = 0.45;
const LARGEST_ECCENTRICITY: f64 = 0.02;

/// An effect that the model lacks.
pub(in crate::estimate) struct Lacking {
    joint: usize,
    effect: Effect,
    /// Unexplained part of the torque without and with this effect, root mean squares.
    left: [f64; 2],
}

enum Effect {
    /// The missing torque as part of the logged one, root mean squares; negative if the torque grows more.
    Saturation(f64),
    /// e, rad.
    Eccentricity(f64),
}

/// The equation of a motor with the columns of probes.
pub(super) struct MotorEquation<'a> {
    pub(super) joint: usize,
    /// Without the columns of known parameters.
    pub(super) factor: Triangle,
    /// Its probes, in the order of their columns after those of the model.
    pub(super) probes: Vec<&'a Probe>,
}

impl MotorEquation<'_> {
    /// Returns the unexplained part of the torque (root mean square), and the values of all probes.
    ///
    /// - `is_closed`: of probes without effect.
    fn fit(&self, is_closed: impl Fn(&Probe) -> bool) -> (f64, Option<Vec<f64>>) {
        let of_model = self.factor.unknowns() - self.probes.len();
        let mut known = vec![None; of_model];
        known.extend(
            self.probes
                .iter()
                .map(|probe| is_closed(probe).then_some(0.0)),
        );
        let open = self.factor.with_known(&known);
        let m = open.unknowns();
        let columns: Vec<usize> = (0..m).collect();
        let part = SystemPart {
            columns: &columns,
            factor: &open,
        };
        let values = solve_quickly(&[part], m).map(|x| {
            let mut estimates = x[of_model..].iter();
            (known[of_model..].iter())
                .filter_map(|known| known.or_else(|| estimates.next().copied()))
                .collect()
        });
        (open.entry(m, m).abs() / self.factor.rhs_norm(), values)
    }

    /// Returns the saturation of the torque, if it explains much of the residual.
    fn saturation(&self) -> Option<Lacking> {
        let at = self.probes.iter().position(|probe| is_cube(probe))?;
        let (without, _) = self.fit(|probe| is_cube(probe) || is_turn(probe));
        let (with, values) = self.fit(is_turn);
        let column = self.factor.unknowns() - self.probes.len() + at;
        let part = values?[at] * self.factor.column_norm(column) / self.factor.rhs_norm();
        let independent = without.mul_add(without, -with * with).max(0.0).sqrt();
        let is_large = part.abs() >= SATURATING_PART
            && independent >= OWN_PART * part.abs()
            && with <= UNEXPLAINED
            && with.powi(2) <= LEFT_WITH_SATURATION * without.powi(2);
        is_large.then_some(Lacking {
            joint: self.joint,
            effect: Effect::Saturation(part),
            left: [without, with],
        })
    }

    /// Returns the eccentricity of the encoder of the link, if it explains much of the residual.
    ///
    /// - `stiffness`: of the joint, N·m/rad.
    fn eccentricity(&self, stiffness: f64) -> Option<Lacking> {
        let at = self.probes.iter().position(|probe| is_turn(probe))?;
        let (without, _) = self.fit(is_turn);
        let (with, values) = self.fit(|_| false);
        let values = values?;
        let size = values[at].hypot(values[at + 1]) / stiffness.abs();
        let is_large = size <= LARGEST_ECCENTRICITY
            && with.powi(2) <= LEFT_WITH_ECCENTRICITY * without.powi(2);
        is_large.then_some(Lacking {
            joint: self.joint,
            effect: Effect::Eccentricity(size),
            left: [without, with],
        })
    }
}

fn is_cube(probe: &Probe) -> bool {
    matches!(probe, Probe::TorqueCube { .. })
}

fn is_turn(probe: &Probe) -> bool {
    matches!(probe, Probe::LinkTurn { .. })
}

/// Returns the probes of eccentric encoders: of flexible joints whose link has an encoder that turns.
pub(super) fn probes_of_encoders(model: &Model, channels: &Channels) -> Vec<Probe> {
    let has_encoder = |joint: &usize| {
        channels.turns[*joint] && channels.index(Quantity::LinkPosition, *joint).is_some()
    };
    (0..model.joint_count())
        .filter(|&joint| model.is_flexible(joint))
        .filter(has_encoder)
        .flat_map(|joint| {
            let row = model.torque_row(joint);
            [false, true].map(|is_cosine| Probe::LinkTurn {
                row,
                joint,
                is_cosine,
            })
        })
        .collect()
}

/// Returns the effects that the model lacks.
///
/// - `theta`: estimates, \[p\].
pub(super) fn lacking(
    model: &Model,
    equations: &[MotorEquation<'_>],
    theta: &Theta,
) -> Vec<Lacking> {
    (equations.iter())
        .flat_map(|equation| {
            let stiffness = model.index(JointParameter::Stiffness, equation.joint);
            let eccentricity = stiffness.and_then(|index| equation.eccentricity(theta[index]));
            equation.saturation().into_iter().chain(eccentricity)
        })
        .collect()
}

impl Lacking {
    /// Returns the finding about the effect; `None` if the joint lacks the column.
    pub(in crate::estimate) fn finding(&self, file: &str, channels: &Channels) -> Option<Finding> {
        let quantity = match self.effect {
            Effect::Saturation(_) => Quantity::MotorTorque,
            Effect::Eccentricity(_) => Quantity::LinkPosition,
        };
        let column = &channels.all[channels.index(quantity, self.joint)?].column;
        let [without, with] = self.left.map(in_percent);
        let (code, effect, remedy, value, unit) = match self.effect {
            Effect::Saturation(part) => (
                "torque-saturates",
                format!(
                    "the acting torque grows {} than \"{column}\", or the spring of the joint is not linear: by a part of the \
                     third power that is {:.1} % of the torque (root mean square). Larger torques are predicted worse than \
                     promised",
                    if part > 0.0 { "less" } else { "more" },
                    in_percent(part.abs()),
                ),
                "measure the torque constant at several currents, try spring = [\"linear\", \"cubic\"], or record a motion with \
                 smaller torques",
                in_percent(part),
                "%",
            ),
            Effect::Eccentricity(size) => (
                "eccentric-encoder",
                format!(
                    "\"{column}\" deviates from the angle of the link by {:.3} mrad once a turn, as an encoder does whose \
                     disc is not centred",
                    in_ms(size)
                ),
                "calibrate the encoder over a turn and correct its readings, or use two reading heads",
                size,
                "rad",
            ),
        };
        let finding = Finding::new(
            Severity::Warning,
            code,
            format!(
                "{effect}. The equation of the motor leaves {without:.2} % of the torque unexplained, and {with:.2} % with \
                 this effect. Least squares does not estimate it"
            ),
            &format!(
                "{remedy}; the intervals of estimator = \"prediction-error\" contain the effect"
            ),
        );
        Some(finding.seen(file, column, value, unit))
    }
}
