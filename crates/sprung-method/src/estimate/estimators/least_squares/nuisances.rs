//! Changes of the parameters by the nuisance parameters that the regression assumes known: the common delay of all
//! torques, the saturation of each torque, and the sharpness of Coulomb friction.

use crate::estimate::nuisances::{SHARPER, sharpness_columns};
use crate::fit::Free;
use crate::log::{Channels, Quantity};
use crate::model::{Model, Theta};
use crate::prepare::Prepared;
use crate::regression::{Probe, Reduction, SystemPart, Triangle, solve_quickly};

/// Returns the change of each parameter if the nuisance parameters are estimated with it from the beginning of the first
/// log, \[p\]; `None` if there are none, or the log does not determine them.
///
/// - `weights`: of rows, \[rows\].
pub(super) fn nuisances(prepared: &Prepared, weights: &[f64]) -> Option<Theta> {
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
    let of_model = free.unknowns.len();
    let mut changes: Vec<f64> = (with.iter().zip(&without))
        .map(|(with, without)| with - without)
        .collect();
    // Friction of two sharpnesses is one friction: its Coulomb friction is the sum of both coefficients.
    for &(at, friction) in &columns.sharper {
        if let Ok(unknown) = free.unknowns.binary_search(&friction) {
            changes[unknown] += with[of_model + at];
        }
    }
    Some(free.whole(&changes, |_| 0.0))
}

/// Columns of nuisance parameters.
struct Columns {
    /// Each with the index of its nuisance parameter.
    probes: Vec<(Probe, usize)>,
    count: usize,
    /// Index of each nuisance parameter that is Coulomb friction of a sharper column, and in theta that of this friction.
    sharper: Vec<(usize, usize)>,
}

impl Columns {
    fn new(model: &Model, channels: &Channels, is_coupled: bool) -> Self {
        let (mut probes, mut count, mut sharper) = (Vec::new(), 0, Vec::new());
        let torques =
            (channels.all.iter()).filter(|channel| channel.quantity == Quantity::MotorTorque);
        if is_timing_open(channels) {
            probes.extend(torques.clone().map(|channel| {
                let row = model.torque_row(channel.joint);
                (Probe::TorqueRate { row }, count)
            }));
            count += 1;
        }
        if !is_coupled {
            for channel in torques {
                let (row, joint) = (model.torque_row(channel.joint), channel.joint);
                probes.push((Probe::TorqueCube { row, joint }, count));
                count += 1;
            }
        }
        for &joint in model.open_sharpness() {
            for column in sharpness_columns(model, joint, model.robot().terms, SHARPER) {
                let column_probes = column.probes.into_iter();
                probes.extend(column_probes.map(|probe| (probe, count)));
                sharper.push((count, column.friction));
                count += 1;
            }
        }
        Self {
            probes,
            count,
            sharper,
        }
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
                    let open = with.then_some(index);
                    known.push(open.is_none().then_some(0.0));
                    columns[row].extend(open.map(|index| of_model + index));
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
    let mut torques =
        (channels.all.iter()).filter(|channel| channel.quantity == Quantity::MotorTorque);
    channels.torque_hold.is_none() && torques.all(|channel| channel.delay.is_none())
}
