//! Changes of the parameters by the nuisance parameters that the regression takes as known: the delay that all torques
//! have together, the saturation of each torque, and the sharpness of Coulomb friction.

use crate::estimate::nuisances::{SHARPER, sharpness_columns};
use crate::finding::{Finding, Severity};
use crate::fit::Free;
use crate::log::{Channels, Quantity};
use crate::model::{Model, Theta};
use crate::numbers::in_percent;
use crate::prepare::Prepared;
use crate::regression::{Probe, Reduction, SystemPart, Triangle, solve_quickly};

/// Smallest third power of a torque, as part of the torque (root mean squares), and largest part of its equation's
/// squared residuals that stays, for a torque that saturates. Measured in `benches/verdicts`, seeds 3100 to 3199:
/// torques that saturate 0.02 or more and 0.55 or less, torques of models that match with that part 0.05 or less and 0.81
/// or more.
const SATURATING_PART: f64 = 0.02;
const LEFT_WITH_SATURATION: f64 = 0.6;

/// What the nuisance parameters do to the estimate.
pub(in crate::estimate) struct Nuisances {
    /// Torques that saturate, which the model lacks.
    pub(in crate::estimate) saturations: Vec<Saturation>,
    /// Change of each parameter if they are estimated with it, \[p\].
    pub(super) changes: Theta,
    /// Time by which all torques act later than the regression takes them, s; `None` if the description gives it.
    pub(in crate::estimate) torques_delay: Option<f64>,
}

/// A torque that grows less or more than the log says.
pub(in crate::estimate) struct Saturation {
    /// Joint of the torque.
    pub(in crate::estimate) joint: usize,
    /// Missing torque as part of the logged one, root mean squares; negative if it grows more.
    pub(in crate::estimate) part: f64,
    /// Part of the torque that stays unexplained without and with this effect, root mean squares.
    pub(in crate::estimate) left: [f64; 2],
}

impl Saturation {
    /// Returns the finding about the saturation.
    ///
    /// - `column`: of the torque.
    pub(in crate::estimate) fn finding(&self, file: &str, column: &str) -> Finding {
        let percent = in_percent(self.part);
        let [without, with] = self.left.map(in_percent);
        Finding::new(
            Severity::Warning,
            "torque-saturates",
            format!(
                "the acting torque grows {} than \"{column}\": by a part of the third power that is {:.1} % of the \
                 torque (root mean square). The equation leaves {without:.2} % of the torque unexplained, and {with:.2} % \
                 with this part. Larger torques are predicted worse than promised",
                if percent > 0.0 { "less" } else { "more" },
                percent.abs(),
            ),
            "use estimator = \"prediction-error\", whose intervals contain the effect, measure the torque constant at several \
             currents, or record a motion with smaller torques",
        )
        .seen(file, column, percent, "%")
    }
}

/// Estimates the nuisance parameters with the others from the beginning of the first log; `None` if there are
/// none, or the log does not determine them.
///
/// - `weights`: of rows, \[rows\].
pub(super) fn nuisances(prepared: &Prepared, weights: &[f64]) -> Option<Nuisances> {
    let reading = prepared.reading();
    // The beginning of a log hardly shows slow covariates.
    let none = vec![0.0; reading.model().parameters().len()];
    let model = &reading.model().with_known_changes(&none);
    let is_coupled = prepared.experiment().robot.transmission_matrix.is_some();
    let columns = Columns::new(model, reading.channels(), is_coupled);
    if columns.count == 0 {
        return None;
    }
    let rows: Vec<usize> = (0..model.rows()).collect();
    let probes: Vec<Probe> = columns.probes.iter().map(|(probe, _)| *probe).collect();
    let empty = Reduction::with_probes(model, &rows, &probes).without_samples();
    let signals = prepared.excerpt().smoothed(reading)?.thinned(reading);
    let whole = signals.reduce_by(empty, reading)?.whole()?;
    let free = Free::new(model);
    let with = columns.fit((model, &free), &whole, weights, true)?;
    let without = columns.fit((model, &free), &whole, weights, false)?;
    let changes: Vec<f64> = (with.iter().zip(&without))
        .map(|(with, without)| with - without)
        .collect();
    Some(Nuisances {
        saturations: columns.saturations(model, &whole, &with[free.unknowns.len()..]),
        changes: free.whole(&changes, |_| 0.0),
        torques_delay: columns
            .torques_delay
            .map(|at| with[free.unknowns.len() + at]),
    })
}

/// Columns of nuisance parameters.
struct Columns {
    /// Each with the index of its nuisance parameter.
    probes: Vec<(Probe, usize)>,
    count: usize,
    /// Index of the delay of all torques, if it is open.
    torques_delay: Option<usize>,
}

impl Columns {
    fn new(model: &Model, channels: &Channels, is_coupled: bool) -> Self {
        let (mut probes, mut count) = (Vec::new(), 0);
        let torques = (channels.all.iter()).filter(|own| own.quantity == Quantity::MotorTorque);
        let torques_delay = is_timing_open(channels).then_some(count);
        if torques_delay.is_some() {
            probes.extend(torques.clone().map(|own| {
                let row = model.torque_row(own.joint);
                (Probe::TorqueRate { row }, count)
            }));
            count += 1;
        }
        if !is_coupled {
            for own in torques {
                let (row, joint) = (model.torque_row(own.joint), own.joint);
                probes.push((Probe::TorqueCube { row, joint }, count));
                count += 1;
            }
        }
        for &joint in model.open_sharpness() {
            for own in sharpness_columns(model, joint, model.robot().terms, SHARPER) {
                probes.extend(own.into_iter().map(|probe| (probe, count)));
                count += 1;
            }
        }
        Self {
            probes,
            count,
            torques_delay,
        }
    }

    /// Returns the torques whose third power explains much of the residuals of their equation.
    ///
    /// - `values`: of the nuisance parameters.
    fn saturations(&self, model: &Model, whole: &[Triangle], values: &[f64]) -> Vec<Saturation> {
        let of_torque = |(probe, index): &(Probe, usize)| -> Option<Saturation> {
            let &Probe::TorqueCube { row, joint } = probe else {
                return None;
            };
            let before = self.probes.iter().take_while(|(_, i)| i < index);
            let in_row = before.filter(|(other, _)| other.row() == row).count();
            let at = model.row_columns(row).len() + in_row;
            let factor = &whole[row];
            let mut known = vec![None; factor.unknowns()];
            known[at] = Some(0.0);
            let left = [&factor.with_known(&known), factor]
                .map(|own| own.entry(own.unknowns(), own.unknowns()).abs() / factor.rhs_norm());
            let part = values[*index] * factor.column_norm(at) / factor.rhs_norm();
            let saturates = part.abs() >= SATURATING_PART
                && left[1].powi(2) <= LEFT_WITH_SATURATION * left[0].powi(2);
            saturates.then_some(Saturation { joint, part, left })
        };
        self.probes.iter().filter_map(of_torque).collect()
    }

    /// Returns the unknowns of the model, followed by the nuisance parameters if they are estimated with them.
    fn fit(
        &self,
        (model, free): (&Model, &Free),
        whole: &[Triangle],
        weights: &[f64],
        with: bool,
    ) -> Option<Vec<f64>> {
        let of_model = free.unknowns.len();
        let mut columns = free.columns.clone();
        let factors: Vec<Triangle> = (whole.iter().enumerate())
            .map(|(row, factor)| {
                let mut known: Vec<Option<f64>> = (model.row_columns(row).iter())
                    .map(|&c| model.known(c))
                    .collect();
                for (_, index) in self.probes.iter().filter(|(probe, _)| probe.row() == row) {
                    known.push((!with).then_some(0.0));
                    if with {
                        columns[row].push(of_model + index);
                    }
                }
                factor.with_known(&known).scaled(weights[row])
            })
            .collect();
        let parts: Vec<SystemPart<'_>> = (columns.iter().zip(&factors))
            .map(|(columns, factor)| SystemPart { columns, factor })
            .collect();
        let unknowns = of_model + if with { self.count } else { 0 };
        solve_quickly(&parts, unknowns)
    }
}

/// Returns whether the description leaves the timing of the torques open.
fn is_timing_open(channels: &Channels) -> bool {
    let mut torques = (channels.all.iter()).filter(|own| own.quantity == Quantity::MotorTorque);
    channels.torque_hold.is_none() && torques.all(|own| own.delay.is_none())
}
