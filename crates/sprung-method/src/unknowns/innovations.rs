//! What the innovations of a refinement show: the same catalogue and the same selection.

use faer::Mat;

use super::evidence::{Evidence, PARTS, Prior, Pull};
use super::found::{Found, amplitude};
use super::gauge::TIMING;
use super::kinds::catalogue;
use super::rows::{Rows, Wanted};
use super::search::Search;
use super::select::Selection;
use super::unknown::{JointScales, Kind, Place, ShownBy, Unknown};
use crate::description::Experiment;
use crate::log::Signal;
use crate::prepare::Excerpt;
use crate::regression::Reading;

/// Most unknowns that are found.
const MOST: usize = 10;

/// Number of consecutive parts whose products are asked for.
pub(crate) const PARTS_OF_INNOVATIONS: usize = PARTS;

/// The part of the catalogue that innovations show.
pub(crate) struct OfLikelihood {
    pub(crate) unknowns: Vec<Unknown>,
    /// Usual size of each; of a law the coefficient that makes its torque as large as that of its joint.
    pub(crate) scales: Vec<f64>,
    /// Figures of each joint.
    pub(crate) joints: Vec<JointScales>,
}

/// Whitened innovations of consecutive parts with their derivatives.
pub(crate) struct Innovations {
    /// Products of the derivatives by what follows every unknown, by the unknowns, and of the innovations, \[(columns + 1)²\].
    pub(crate) parts: Vec<Mat<f64>>,
    /// Priors of what follows.
    pub(crate) priors: Vec<Pull>,
}

/// An unknown that innovations show.
pub(crate) struct Shown {
    /// Index in the catalogue, of a wave that of its first phase.
    pub(crate) unknown: usize,
    /// The value of a wave is its amplitude.
    pub(crate) found: Found,
    /// Changes of what follows by it.
    pub(crate) moves: Vec<f64>,
}

impl OfLikelihood {
    /// - `theta`: parameters, \[p\].
    pub(crate) fn new(
        experiment: &Experiment,
        reading: &Reading,
        excerpt: &Excerpt,
        theta: &[f64],
    ) -> Self {
        let (channels, model) = (reading.channels(), reading.model());
        let mut search = Search::new((experiment, reading), channels, model, excerpt);
        search.unknowns = catalogue(&search.catalogued);
        (search.unknowns).retain(|unknown| unknown.shown_by != ShownBy::Rows);
        let laws: Vec<usize> = (0..search.unknowns.len())
            .filter(|&k| search.unknowns[k].scale.is_infinite())
            .collect();
        let smoothed = search.signals(excerpt);
        let rows = smoothed.as_ref().and_then(|smoothed| {
            let former = Rows {
                wanted: Wanted::These(&laws),
                ..search.former(model, smoothed.period())
            };
            former.form(smoothed.segments(), theta, &search.unknowns, &[])
        });
        let segments = smoothed
            .as_ref()
            .map_or(&[][..], |smoothed| smoothed.segments());
        let joints = search.former(model, excerpt.period()).scales(segments);
        Self {
            scales: search.scales(&rows.unwrap_or_default()),
            joints,
            unknowns: search.unknowns,
        }
    }

    /// Keeps some unknowns.
    pub(crate) fn retain(&mut self, keep: impl FnMut(&Unknown) -> bool) {
        let kept: Vec<bool> = self.unknowns.iter().map(keep).collect();
        let mut of_scale = kept.iter();
        self.scales.retain(|_| *of_scale.next().unwrap_or(&false));
        let mut of_unknown = kept.iter();
        self.unknowns
            .retain(|_| *of_unknown.next().unwrap_or(&false));
    }

    /// Returns what the innovations show, what explains most first.
    ///
    /// - `joint_of`: joint of a channel.
    pub(crate) fn shown(
        &self,
        innovations: Innovations,
        joint_of: &(dyn Fn(usize) -> usize + Sync),
    ) -> Vec<Shown> {
        let priors: Vec<Prior> = (self.unknowns.iter().zip(&self.scales))
            .map(|(unknown, &scale)| Prior {
                scale,
                applied: 0.0,
                is_positive: unknown.is_positive,
            })
            .collect();
        let evidence = Evidence::of_innovations(innovations.parts, &innovations.priors, &priors);
        let selection = Selection {
            evidence: &evidence,
            unknowns: &self.unknowns,
            scales: &self.scales,
            begins: &vec![None; self.unknowns.len()],
        };
        let mut chosen = Vec::new();
        while chosen.len() < MOST
            && let Some(best) = selection.best(&chosen, joint_of)
        {
            chosen.push(best.unknown);
        }
        let waves: Vec<Vec<usize>> = self.waves(&chosen);
        let all: Vec<usize> = waves.concat();
        (waves.iter())
            .map(|wave| self.described(&selection, wave, &all))
            .collect()
    }

    /// Returns the chosen unknowns, with both phases of each wave.
    fn waves(&self, chosen: &[usize]) -> Vec<Vec<usize>> {
        let mut waves: Vec<Vec<usize>> = Vec::new();
        for &one in chosen {
            if waves.iter().any(|wave| wave.contains(&one)) {
                continue;
            }
            let of = self.unknowns[one].wave();
            let is_phase =
                |other: &usize| *other == one || of.is_some() && self.unknowns[*other].wave() == of;
            waves.push((0..self.unknowns.len()).filter(is_phase).collect());
        }
        waves
    }

    /// - `wave`: an unknown, or both phases of one; `all`: everything that was found.
    fn described(&self, selection: &Selection<'_>, wave: &[usize], all: &[usize]) -> Shown {
        let evidence = selection.evidence;
        let rest: Vec<usize> = (all.iter().copied())
            .filter(|other| !wave.contains(other))
            .collect();
        let (columns, others) = (selection.columns(all), selection.columns(&rest));
        let (with, without) = (evidence.fit(&columns), evidence.fit(&others));
        let held_out = evidence.held_out(&columns, None);
        let parts: Vec<usize> = (0..PARTS).collect();
        let of_phase = |phase: usize| {
            let column = selection.column(phase);
            let beyond: Vec<usize> = columns.iter().copied().filter(|c| *c != column).collect();
            let scatter = held_out.mean_and_error(column, &parts).1;
            let error = evidence.directions(&beyond).error(evidence, column);
            [with[column], error.hypot(scatter)]
        };
        let phases = wave.iter().map(|&phase| of_phase(phase));
        let [value, standard_error] = phases.reduce(amplitude).unwrap_or_default();
        let before = evidence.held_out(&others, None).sum(&[0], &parts);
        let gain = (before - held_out.sum(&[0], &parts)) / before.max(f64::MIN_POSITIVE);
        let unknown = &self.unknowns[wave[0]];
        let is_timing = unknown.kind == Kind::Delay && unknown.place == Place::All(Signal::Torque);
        Shown {
            unknown: wave[0],
            found: Found {
                id: match unknown.wave() {
                    _ if is_timing => TIMING.to_owned(),
                    Some(wave) => wave.to_owned(),
                    None => unknown.id.clone(),
                },
                kind: if is_timing {
                    Kind::Timing
                } else {
                    unknown.kind
                },
                place: unknown.place,
                value,
                standard_error,
                unit: unknown.unit,
                begins: None,
                law: unknown.added().cloned(),
                gain,
                own: 1.0,
                mimic: None,
                fall: gain,
                competing: Vec::new(),
            },
            moves: (0..evidence.free)
                .map(|at| with[at] - without[at])
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::unknowns::unknown::Effect;

    /// Innovations of 4000 samples with a parameter and three unknowns, of which the second resembles the first.
    fn shown(ids: [&str; 3], truth: [f64; 3]) -> Vec<Shown> {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        // A sum of twelve uniform numbers is nearly normal, with a variance of one.
        let mut normal = || -> f64 { (0..12).map(|_| random.random_range(-0.5..0.5)).sum() };
        let parts = (0..PARTS).map(|_| {
            let mut part = Mat::zeros(5, 5);
            for _ in 0..500 {
                let (first, second, third) = (normal(), normal(), normal());
                let by_unknowns = [first, 0.8 * first + 0.6 * second, third];
                let products = by_unknowns.iter().zip(truth).map(|(x, value)| x * value);
                let innovation = normal() + products.sum::<f64>();
                let row = [
                    1.0,
                    by_unknowns[0],
                    by_unknowns[1],
                    by_unknowns[2],
                    innovation,
                ];
                for i in 0..5 {
                    for j in 0..5 {
                        part[(i, j)] += row[i] * row[j];
                    }
                }
            }
            part
        });
        let unknown = |id: &str| Unknown {
            scale: 10.0,
            ..Unknown::new(
                id.to_owned(),
                Kind::Ripple,
                Place::Robot,
                "",
                Effect::Parameters(Vec::new()),
            )
        };
        let innovations = Innovations {
            parts: parts.collect(),
            priors: Vec::new(),
        };
        let catalogue = OfLikelihood {
            unknowns: ids.map(unknown).to_vec(),
            scales: vec![10.0; 3],
            joints: Vec::new(),
        };
        catalogue.shown(innovations, &|_| 0)
    }

    fn ids(shown: &[Shown]) -> Vec<&str> {
        shown.iter().map(|one| one.found.id.as_str()).collect()
    }

    const APART: [&str; 3] = ["a", "b", "c"];

    #[test]
    fn innovations_without_causes_show_nothing() {
        assert!(shown(APART, [0.0; 3]).is_empty());
    }

    #[test]
    fn a_cause_that_resembles_another_one_is_not_shown_beside_it() {
        let shown = shown(APART, [0.5, 0.0, 0.0]);
        assert_eq!(ids(&shown), ["a"]);
        // The standard error of 4000 samples is 0.016.
        let found = &shown[0].found;
        assert!((found.value - 0.5).abs() < 0.06 && found.standard_error < 0.03);
    }

    #[test]
    fn two_causes_are_shown_in_the_order_of_their_gains() {
        assert_eq!(ids(&shown(APART, [0.5, 0.0, 1.0])), ["c", "a"]);
    }

    #[test]
    fn both_phases_of_a_wave_are_one_cause_with_an_amplitude() {
        let shown = shown(["a", "wave sine", "wave cosine"], [0.0, 0.3, 0.4]);
        assert_eq!(ids(&shown), ["wave"]);
        let found = &shown[0].found;
        assert!((found.value - 0.5).abs() < 0.06 && found.standard_error < 0.04);
    }
}
