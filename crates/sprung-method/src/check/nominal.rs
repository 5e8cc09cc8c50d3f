//! What the nominal values say of the torques: another scale, or joints in another order.

use super::context::CheckContext;
use super::scale::{Explanation, explanations};
use super::trial::Group;
use crate::finding::{Finding, Severity};
use crate::log::{Quantity, rounded};
use crate::prepare::RowFit;

/// Ratio to the nominal parameters, for all of them in one direction, at which the scale of the
/// torque is doubtful.
const SUSPICIOUS_SCALE: f64 = 6.0;

/// Largest factor between this ratio and that of an explanation. Neighbours among the powers of ten are
/// 10 apart.
const NEAR_SCALE: f64 = 3.0;

/// Factor between the ratio of each parameter and that of an explanation, up to which its line is printed.
const SAME_UNIT: f64 = 5.0;

/// Values of a joint over nominal values, in ascending order; at least two, all positive.
struct Ratios(Vec<f64>);

impl Ratios {
    fn middle(&self) -> f64 {
        let all = &self.0;
        all[all.len() / 2].min(all[(all.len() - 1) / 2])
    }

    fn range(&self) -> [f64; 2] {
        [self.0[0], self.0[self.0.len() - 1]]
    }

    /// Returns whether they indicate a wrong scale instead of a wrong parameter: all lie on one side of 1.
    fn are_suspicious(&self) -> bool {
        let ([least, most], middle) = (self.range(), self.middle());
        middle.max(middle.recip()) >= SUSPICIOUS_SCALE && !(least < 1.0 && most > 1.0)
    }

    /// Returns the mean distance of the logarithms from that of a factor.
    fn off(&self, factor: f64) -> f64 {
        let sum: f64 = self.0.iter().map(|ratio| (ratio / factor).ln().abs()).sum();
        sum / self.0.len() as f64
    }
}

impl CheckContext<'_> {
    /// Returns the values of a joint over the nominal values of another; `None` with less than two.
    fn over_nominal(&self, joint: usize, of: usize, fit: &RowFit) -> Option<Ratios> {
        let model = self.reading.model();
        let mut ratios: Vec<f64> = (fit.values())
            .filter_map(|(column, value)| {
                let at = match model.parameters()[column].joint {
                    Some((kind, _)) if of != joint => model.index(kind, of)?,
                    _ => column,
                };
                Some(value / model.parameters()[at].nominal?)
            })
            .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
            .collect();
        ratios.sort_by(f64::total_cmp);
        (ratios.len() >= 2).then_some(Ratios(ratios))
    }

    /// Finding: the values of two joints are the nominal values of each other.
    pub(super) fn exchanged_by_nominal(
        &self,
        joints: &[usize],
        fits: &[RowFit],
    ) -> Option<([usize; 2], Finding)> {
        let ratios = |joint: usize, of: usize| self.over_nominal(joint, of, &fits[joint]);
        let are_exchanged = |one: usize, two: usize| {
            let own = [ratios(one, one)?, ratios(two, two)?];
            let exchanged = [ratios(one, two)?, ratios(two, one)?];
            // Another unit of each torque competes.
            let scaled: f64 = own.iter().map(|own| own.off(own.middle())).sum();
            let left: f64 = exchanged.iter().map(|exchanged| exchanged.off(1.0)).sum();
            Some(own.iter().all(Ratios::are_suspicious) && left < scaled)
        };
        let mut pairs = (joints.iter()).flat_map(|&one| joints.iter().map(move |&two| [one, two]));
        let [one, two] =
            pairs.find(|[one, two]| one < two && are_exchanged(*one, *two) == Some(true))?;
        let [own, exchanged] = [ratios(one, one)?.middle(), ratios(one, two)?.middle()];
        let channels = (Quantity::all()).fold(self.reading.channels().clone(), |all, quantity| {
            all.swapped(quantity, one, two).unwrap_or(all)
        });
        let column = self.column(&[Quantity::MotorTorque], one);
        let finding = Finding::new(
            // The nominal values may be in the wrong order instead.
            Severity::Warning,
            "swapped-joints",
            format!(
                "{} of {one} and {two} look swapped: stiffness, inertia and friction of {one} are about {own:.3} times \
                 their nominal values and {exchanged:.3} times those of {two}, and the opposite holds for {two}",
                Group::All.words(),
                one = self.name(one),
                two = self.name(two),
            ),
            "give the columns in the order of the [[robot.joint]] blocks, or correct the nominal values",
        )
        .seen(self.file, column, own, "");
        // The equations of known bodies show exchanged joints themselves, and here they do not.
        let finding = if self.reading.model().tree().is_none() {
            finding.mended_by("[log]", &self.column_lines(&channels))
        } else {
            finding
        };
        Some(([one, two], finding))
    }

    /// Finding: the scale of the torque disagrees with the nominal values.
    pub(super) fn scale(&self, joint: usize, fit: &RowFit) -> Option<Finding> {
        let ratios = self
            .over_nominal(joint, joint, fit)
            .filter(Ratios::are_suspicious)?;
        let ([least, most], middle) = (ratios.range(), ratios.middle());
        let torque = self.column(&[Quantity::MotorTorque], joint);
        let off = |explanation: &Explanation| (middle / explanation.factors[0]).ln().abs();
        let are_near = |factor: f64| least * SAME_UNIT > factor && most < SAME_UNIT * factor;
        let mut possible = explanations(self, &[joint]);
        possible.retain(|explanation| off(explanation) < NEAR_SCALE.ln());
        possible.sort_by(|a, b| off(a).total_cmp(&off(b)));
        let likely = if possible.is_empty() {
            "It may have another unit, be of the other side of the gearbox, or hold raw counts"
                .to_owned()
        } else {
            let words = possible.iter().map(|explanation| {
                format!(
                    "{} (factor {})",
                    explanation.cause,
                    rounded(explanation.factors[0])
                )
            });
            words.collect::<Vec<String>>().join("; or: ")
        };
        Some(
            Finding::new(
                // The nominal values may be wrong instead of the torque.
                Severity::Warning,
                "torque-scale",
                format!(
                    "{}: stiffness, inertia and friction are about {middle:.3} times their nominal \
                     values, all in one direction ({least:.3} to {most:.3}). \"{torque}\" does not fit: \
                     {likely}, or the positions have another unit",
                    self.name(joint)
                ),
                "give the unit and the side of the torque, or correct the nominal values",
            )
            .seen(self.file, torque, middle, ""),
        )
        .map(|finding| match possible.first() {
            // A unit multiplies all of them.
            Some(explanation) if are_near(explanation.factors[0]) => {
                finding.mended_by(explanation.table, &explanation.line)
            }
            _ => finding,
        })
    }
}
