//! Laws of the joints, fitted without each part of a log and judged on it. The excerpt is reduced once with the columns of all laws
//! that are judged.

use sprung_core::friction::Scale;
use sprung_core::parameters::JointParameter;

use super::added_law::with_laws;
use super::evidence::{PARTS, mean_and_error};
use super::result::AddedLaw;
use crate::description::Experiment;
use crate::fit::{HoldOut, Missed, fit_values, row_weights};
use crate::model::{Model, Theta};
use crate::prepare::{Excerpt, Prepared};
use crate::regression::{Reading, System};

/// The excerpt of a log with the columns of all laws that are judged.
#[derive(Clone, Debug)]
pub(super) struct LawColumns {
    prepared: Prepared,
    /// Without these laws.
    reading: Reading,
    widest: Model,
    system: System,
}

impl LawColumns {
    /// - `laws`: beyond the description.
    pub(super) fn new(
        prepared: &Prepared,
        reading: &Reading,
        laws: &[(usize, AddedLaw)],
    ) -> Option<Self> {
        let widest = with_laws_of(prepared.experiment(), reading, laws)?;
        Some(Self {
            system: prepared.excerpt().reduce_thinned(&widest)?,
            widest: widest.model().clone(),
            prepared: prepared.clone(),
            reading: reading.clone(),
        })
    }

    /// Returns whether the columns are those of a reading.
    pub(super) fn are_of(&self, reading: &Reading) -> bool {
        let sharpness = |of: &Reading| -> Vec<f64> {
            let joints = 0..of.model().joint_count();
            joints.map(|joint| of.model().sharpness(joint)).collect()
        };
        let cutoff = |of: &Reading| of.position_cutoff_hz().to_bits();
        reading.channels() == self.reading.channels()
            && reading.delays() == self.reading.delays()
            && cutoff(reading) == cutoff(&self.reading)
            && reading.model().parameters() == self.reading.model().parameters()
            && sharpness(reading) == sharpness(&self.reading)
    }

    /// Judges some of the laws.
    pub(super) fn judged(&self, laws: &[(usize, AddedLaw)]) -> Option<Judged> {
        let reading = with_laws_of(self.prepared.experiment(), &self.reading, laws)?;
        match left_out(&self.widest, reading.model()) {
            Some(left_out) => {
                Judged::fitted(reading.model(), &self.system.without(&left_out, PARTS))
            }
            None => Judged::of(self.prepared.excerpt(), &reading),
        }
    }
}

/// Returns which columns of each row of a model another one does not have; `None` if it has others: a law may take the place of
/// another, and a play changes the column of the stiffness.
fn left_out(widest: &Model, model: &Model) -> Option<Vec<Vec<bool>>> {
    let plays_differ = |joint: usize| model.play(joint) != widest.play(joint);
    if (0..model.joint_count()).any(plays_differ) {
        return None;
    }
    let names = |of: &Model, row: usize| -> Vec<String> {
        let columns = of.row_columns(row).iter();
        let names = columns.map(|&column| of.parameters()[column].name.clone());
        names.collect()
    };
    let of_row = |row: usize| {
        let mut wanted = names(model, row).into_iter().peekable();
        let is_absent = |name: String| wanted.next_if_eq(&name).is_none();
        let absent: Vec<bool> = (names(widest, row).into_iter()).map(is_absent).collect();
        wanted.next().is_none().then_some(absent)
    };
    (0..model.rows()).map(of_row).collect()
}

/// A model with the laws of some joints on the excerpt of a log.
pub(super) struct Judged {
    model: Model,
    /// Fit without each part.
    fits: Vec<Theta>,
    /// What it misses of this part.
    missed: Vec<Missed>,
}

impl Judged {
    pub(super) fn of(excerpt: &Excerpt, reading: &Reading) -> Option<Self> {
        Self::fitted(reading.model(), &excerpt.reduce_thinned(reading)?)
    }

    fn fitted(model: &Model, system: &System) -> Option<Self> {
        let values = fit_values(model, system)?;
        let weights = row_weights(model, system, &values);
        let hold_out = HoldOut::new(model, system, PARTS);
        let hold_out = hold_out.weighted(&weights).with_signs();
        let fits: Option<Vec<Theta>> = hold_out.fits_without_each().into_iter().collect();
        let fits = fits?;
        Some(Self {
            missed: (fits.iter().enumerate())
                .map(|(part, theta)| hold_out.missed(part, theta))
                .collect(),
            fits,
            model: model.clone(),
        })
    }

    /// Returns the relative squared residual of a joint in each part.
    pub(super) fn left(&self, joint: usize) -> Vec<f64> {
        let rows = [joint, self.model.torque_row(joint)];
        let torque = |row: usize| -> f64 {
            let all = self.missed.iter().map(|missed| missed.torque[row]);
            all.sum::<f64>().max(f64::MIN_POSITIVE)
        };
        let torques = rows.map(torque);
        let of_part = |missed: &Missed| {
            (rows.iter().zip(torques))
                .map(|(&row, torque)| missed.residual[row] / torque)
                .sum()
        };
        self.missed.iter().map(of_part).collect()
    }

    /// Returns the index of a parameter.
    pub(super) fn index(&self, kind: JointParameter, joint: usize) -> Option<usize> {
        self.model.index(kind, joint)
    }

    /// Returns mean and jackknife error of the sum of some parameters.
    pub(super) fn sum(&self, parameters: &[usize]) -> (f64, f64) {
        let sums = self.fits.iter().map(|theta| -> f64 {
            let values = parameters.iter().map(|&parameter| theta[parameter]);
            values.sum()
        });
        mean_and_error(&sums.collect::<Vec<f64>>())
    }
}

/// Returns a reading whose model has further laws of joints; `None` if no model has them.
pub(super) fn with_laws_of(
    experiment: &Experiment,
    reading: &Reading,
    laws: &[(usize, AddedLaw)],
) -> Option<Reading> {
    let names = reading.model().joints();
    let laws = laws.iter();
    let laws = laws.map(|(joint, law)| (names[*joint].as_str(), law));
    let model = Model::new(&with_laws(experiment, laws)).ok()?;
    let mut model = model.with_velocities_of(reading.model());
    for joint in 0..model.joint_count() {
        model.set_scale(joint, Scale::Sharpness, reading.model().sharpness(joint));
    }
    Some(reading.with_model(model))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{self, no_files};
    use crate::fit::system_of;

    /// Returns the demo's robot with laws, and its system of signals that obey no equation.
    fn with(laws: &[(&str, &str)]) -> (Model, System) {
        let experiment =
            description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let laws: Vec<(&str, AddedLaw)> = (laws.iter())
            .map(|(of, law)| {
                let law = AddedLaw {
                    of: (*of).to_owned(),
                    law: (*law).to_owned(),
                    ..AddedLaw::default()
                };
                ("joint1", law)
            })
            .collect();
        let laws = laws.iter().map(|(joint, law)| (*joint, law));
        let model = Model::new(&with_laws(&experiment, laws)).unwrap();
        let system = system_of(&model);
        (model, system)
    }

    #[test]
    fn columns_of_all_laws_give_each_model_its_own_fit() {
        let cubic = ("spring", "cubic");
        let presliding = ("motor_friction", "presliding");
        let (widest, all) = with(&[("spring", "hysteresis"), cubic, presliding]);
        let left = |of: &Judged| -> Vec<f64> { (0..2).flat_map(|joint| of.left(joint)).collect() };
        for laws in [&[][..], &[cubic], &[presliding], &[cubic, presliding]] {
            let (model, alone) = with(laws);
            let absent = left_out(&widest, &model).unwrap();
            let shared = Judged::fitted(&model, &all.without(&absent, PARTS)).unwrap();
            let alone = Judged::fitted(&model, &alone).unwrap();
            assert_eq!(shared.fits.len(), PARTS);
            for (shared, alone) in left(&shared).into_iter().zip(left(&alone)) {
                assert!(
                    (shared / alone - 1.0).abs() < 1e-7,
                    "{laws:?}: {shared} {alone}"
                );
            }
        }
        let narrow = with(&[]).0;
        assert!(left_out(&narrow, &widest).is_none());
    }
}
