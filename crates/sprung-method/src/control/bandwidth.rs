//! Gains for a bandwidth, and the largest bandwidth that keeps the margins.

use super::gains::{Aim, gains, held_hz};
use super::judge::{Case, drawn, identified, keeps, stabilities};
use super::margins::Stability;
use super::pose::linear;
use super::refusal::ControlRefusal;
use super::result::Bandwidth;
use super::sampled::Sampled;
use super::task::ControlTask;
use crate::description::Controller;

/// Factors of the proportions that are tried, from the largest: steps per factor of ten, and range.
const PER_DECADE: f64 = 12.0;
const LARGEST: f64 = 10.0;
const SMALLEST: f64 = 0.02;

/// Halvings of the last step.
const HALVINGS: usize = 4;

/// Highest bandwidth, part of the sampling rate.
const HIGHEST: f64 = 0.1;

/// Bandwidth of a robot without springs of which nothing else is known, Hz.
const RIGID_HZ: f64 = 10.0;

/// Reduction where the margins of a robot of the posterior do not hold, and most of them.
const LESS: f64 = 0.93;
const REDUCTIONS: usize = 30;

/// A feedback with its bandwidths.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) controller: Controller,
    pub(super) bandwidth: Bandwidth,
}

/// The search over factors of the bandwidths.
struct Search<'t, 'a> {
    task: &'t ControlTask<'a>,
    /// Bandwidths for the factor one, Hz, \[n\].
    base: Vec<f64>,
    /// Poses at which gains are computed.
    centres: Vec<usize>,
    identified: Vec<Case<'a>>,
    drawn: Vec<Case<'a>>,
    speed: Option<f64>,
}

/// Designs the feedback.
///
/// - `speed`: velocity within which the compensation of friction changes its direction.
///
/// # Errors
///
/// [`ControlRefusal`] if the bandwidth that was asked for does not keep the margins, or none does.
pub(super) fn feedback(
    task: &ControlTask<'_>,
    speed: Option<f64>,
) -> Result<Found, ControlRefusal> {
    let n = task.model.joint_count();
    let centre = linear(task.model, task.theta, &task.poses[0]).ok_or(ControlRefusal::Impossible)?;
    let asked = &task.settings.bandwidth_hz;
    let base = match asked.as_slice() {
        [] => {
            let held = held_hz(task.model, &centre);
            let highest = held.iter().copied().fold(0.0, f64::max);
            let other = if highest > 0.0 { highest } else { RIGID_HZ };
            (held.into_iter())
                .map(|own| if own > 0.0 { own } else { other })
                .collect()
        }
        [one] => vec![*one; n],
        all => all.to_vec(),
    };
    let search = Search {
        task,
        base,
        centres: vec![0, heaviest(task)],
        identified: identified(task),
        drawn: drawn(task),
        speed,
    };
    search.run(!asked.is_empty())
}

/// Returns the pose in which the identified robot has the largest inertias.
fn heaviest(task: &ControlTask<'_>) -> usize {
    let inertia = |q: &Vec<f64>| {
        let own = linear(task.model, task.theta, q)?;
        Some((0..task.model.joint_count()).map(|i| own.mass[(i, i)].ln()).sum::<f64>())
    };
    let all = task.poses.iter().map(|q| inertia(q).unwrap_or(f64::NEG_INFINITY));
    (all.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))).map_or(0, |(pose, _)| pose)
}

impl Search<'_, '_> {
    fn run(&self, is_asked: bool) -> Result<Found, ControlRefusal> {
        let (mut factor, mut broken) = self.largest()?;
        let mut reductions = 0;
        let largest = loop {
            let own = self.at(factor).ok_or(ControlRefusal::Impossible)?;
            match self.first_broken(&own, &self.drawn) {
                None => break own,
                Some(_) if reductions == REDUCTIONS => return Err(self.none(factor)),
                Some(what) => {
                    broken = Some(what);
                    factor *= LESS;
                    reductions += 1;
                }
            }
        };
        let limited_by = broken.unwrap_or_else(|| {
            format!("a tenth of the sampling rate, {:.3} Hz", HIGHEST / self.task.period)
        });
        let hz = |factor: f64| self.base.iter().map(|own| factor * own).collect::<Vec<f64>>();
        let bandwidth = |used: f64| Bandwidth {
            used_hz: hz(used),
            largest_hz: hz(factor),
            limited_by: limited_by.clone(),
        };
        if !is_asked {
            return Ok(Found {
                controller: largest,
                bandwidth: bandwidth(factor),
            });
        }
        let wanted = self.at(1.0).filter(|own| {
            let cases = [&self.identified[..], &self.drawn[..]];
            cases.iter().all(|cases| self.first_broken(own, cases).is_none())
        });
        match wanted {
            Some(controller) => Ok(Found {
                controller,
                bandwidth: bandwidth(1.0),
            }),
            None => Err(ControlRefusal::TooFast {
                asked_hz: hz(1.0),
                largest_hz: hz(factor),
                because: limited_by,
            }),
        }
    }

    /// Returns the largest factor that keeps the margins of the identified robot at all poses, and what breaks above it.
    fn largest(&self) -> Result<(f64, Option<String>), ControlRefusal> {
        let fastest = self.base.iter().copied().fold(0.0, f64::max);
        let top = LARGEST.min(HIGHEST / self.task.period / fastest);
        let steps = (PER_DECADE * (top / SMALLEST).log10()).ceil().max(1.0);
        let factors = (0..=steps as usize).map(|k| top * (SMALLEST / top).powf(k as f64 / steps));
        let mut above: Option<(f64, Option<String>)> = None;
        for factor in factors {
            let broken = self.broken(factor);
            if broken.is_some() {
                above = Some((factor, broken));
                continue;
            }
            let Some((mut high, mut what)) = above else {
                return Ok((factor, None));
            };
            let mut low = factor;
            for _ in 0..HALVINGS {
                let middle = (low * high).sqrt();
                match self.broken(middle) {
                    None => low = middle,
                    Some(own) => (high, what) = (middle, Some(own)),
                }
            }
            return Ok((low, what));
        }
        Err(self.none(SMALLEST))
    }

    fn none(&self, factor: f64) -> ControlRefusal {
        ControlRefusal::NoBandwidth {
            because: self
                .broken(factor)
                .unwrap_or_else(|| "robots of the posterior do not keep them".to_owned()),
        }
    }

    /// Returns what breaks with a factor; `None` if the identified robot keeps the margins at all poses.
    fn broken(&self, factor: f64) -> Option<String> {
        match self.at(factor) {
            None => Some("no gain stabilises the equations".to_owned()),
            Some(own) => self.first_broken(&own, &self.identified),
        }
    }

    /// Returns the feedback for a factor: that of the first centre that keeps the margins at all poses, or of the first one.
    fn at(&self, factor: f64) -> Option<Controller> {
        let task = self.task;
        let aim = Aim {
            feedback: task.settings.feedback,
            bandwidth_hz: self.base.iter().map(|own| factor * own).collect(),
            damping: task.settings.damping,
        };
        let all: Vec<Controller> = (self.centres.iter())
            .filter_map(|pose| {
                let linear = linear(task.model, task.theta, &task.poses[*pose])?;
                let plant = Sampled::new(task.model, &linear, task.period);
                let gain = gains(task.model, &linear, &plant, &aim)?;
                Some(task.feedback(gain, self.speed))
            })
            .collect();
        let mut kept = all.iter();
        let kept = kept.find(|own| self.first_broken(own, &self.identified).is_none());
        kept.or(all.first()).cloned()
    }

    /// Returns the first margin that does not hold, in a sentence.
    fn first_broken(&self, controller: &Controller, cases: &[Case<'_>]) -> Option<String> {
        // In blocks, so that a loop without margins is seen early.
        cases.chunks(8).find_map(|block| {
            let all = stabilities(self.task, controller, block);
            let mut cases = block.iter().zip(&all);
            cases.find_map(|(case, own)| match own {
                None => Some("no robot has these values".to_owned()),
                Some(own) if keeps(own, self.task.settings) => None,
                Some(own) => Some(self.words(own, case)),
            })
        })
    }

    fn words(&self, own: &Stability, case: &Case<'_>) -> String {
        let pose: Vec<String> = (self.task.poses[case.pose].iter())
            .map(|q| format!("{q:.2}"))
            .collect();
        let whose = if case.robot == 0 {
            String::new()
        } else {
            format!(" of robot {} of the posterior", case.robot)
        };
        let pose = format!("in the pose [{}] rad{whose}", pose.join(", "));
        let light = (own.vibrations.iter()).min_by(|a, b| a.damping.total_cmp(&b.damping));
        let resonance = light.map_or_else(String::new, |pole| {
            format!(
                "; its least damped vibration has {:.3} Hz and the damping ratio {:.2}",
                pole.hz, pole.damping
            )
        });
        if own.growth_per_s.is_some() {
            return format!("{pose} the loop is unstable{resonance}");
        }
        let settings = self.task.settings;
        let excess = |k: &usize| {
            let margin = &own.margins[*k];
            (margin.gain_db - settings.gain_margin_db)
                .min((margin.phase_deg - settings.phase_margin_deg) / 5.0)
        };
        let worst = (0..own.margins.len())
            .min_by(|a, b| excess(a).total_cmp(&excess(b)))
            .unwrap_or(0);
        format!(
            "{pose} the loop of {} keeps {:.1} dB and {:.0}°, less than {} dB and {}°{resonance}",
            self.task.model.joints()[worst],
            own.margins[worst].gain_db,
            own.margins[worst].phase_deg,
            settings.gain_margin_db,
            settings.phase_margin_deg,
        )
    }
}
