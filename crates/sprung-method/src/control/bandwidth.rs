//! Gains for a bandwidth, and the largest bandwidth that keeps the margins.

use super::gains::{Aim, gains, held_hz, of_joints};
use super::judge::{Case, drawn, identified, keeps, stabilities};
use super::linear::Linear;
use super::margins::Stability;
use super::pose::linear;
use super::refusal::ControlRefusal;
use super::result::Bandwidth;
use super::sampled::Sampled;
use super::task::ControlTask;
use crate::description::{Controller, Feedback};

/// Tried factors of the proportions, from the largest: steps per factor of ten, and range.
const PER_DECADE: f64 = 12.0;
const LARGEST: f64 = 10.0;
const SMALLEST: f64 = 0.02;

/// Halvings of the last step.
const HALVINGS: usize = 4;

/// Highest bandwidth, part of the sampling rate.
const HIGHEST: f64 = 0.1;

/// Default bandwidth of a robot without springs, Hz.
const RIGID_HZ: f64 = 10.0;

/// Reduction if the margins of a robot of the posterior do not hold, and largest number of
/// reductions.
const LESS: f64 = 0.93;
const REDUCTIONS: usize = 30;

/// A feedback with its bandwidths.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) controller: Controller,
    pub(super) bandwidth: Bandwidth,
}

/// Cases that are looked at together.
const BLOCK: usize = 8;

/// Robots whose margins count.
#[derive(Clone, Copy, Debug)]
enum Robots {
    Identified,
    Drawn,
}

/// A feedback that keeps the margins of the identified robot, or the broken margin.
enum Tried {
    Kept(Controller),
    Broken(String),
}

/// The search over factors of the bandwidths.
struct BandwidthSearch<'t, 'a> {
    task: &'t ControlTask<'a>,
    /// Bandwidths for the factor one, Hz, \[n\].
    base: Vec<f64>,
    /// Equations in the poses at which gains are computed.
    centres: Vec<Linear>,
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
/// [`ControlRefusal`] if the requested bandwidth does not keep the margins, or none does.
pub(super) fn feedback(
    task: &ControlTask<'_>,
    speed: Option<f64>,
) -> Result<Found, ControlRefusal> {
    let n = task.model.joint_count();
    let centre =
        linear(task.model, task.theta, &task.poses[0]).ok_or(ControlRefusal::Impossible)?;
    let asked = &task.settings.bandwidth_hz;
    let base = match asked.as_slice() {
        [] => {
            let held = held_hz(task.model, &centre);
            let highest = held.iter().copied().fold(0.0, f64::max);
            let other = if highest > 0.0 { highest } else { RIGID_HZ };
            (held.into_iter())
                .map(|frequency| if frequency > 0.0 { frequency } else { other })
                .collect()
        }
        [one] => vec![*one; n],
        all => all.to_vec(),
    };
    let heaviest = linear(task.model, task.theta, &task.poses[heaviest(task)]);
    let centres = std::iter::once(centre).chain(heaviest).collect();
    let mut search = BandwidthSearch {
        task,
        base,
        centres,
        identified: identified(task),
        drawn: drawn(task),
        speed,
    };
    search.run(!asked.is_empty())
}

/// Returns the pose in which the identified robot has the largest inertias.
fn heaviest(task: &ControlTask<'_>) -> usize {
    let inertia = |q: &Vec<f64>| {
        let linear = linear(task.model, task.theta, q)?;
        Some(
            (0..task.model.joint_count())
                .map(|i| linear.mass[(i, i)].ln())
                .sum::<f64>(),
        )
    };
    let all = task
        .poses
        .iter()
        .map(|q| inertia(q).unwrap_or(f64::NEG_INFINITY));
    (all.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))).map_or(0, |(pose, _)| pose)
}

impl BandwidthSearch<'_, '_> {
    fn run(&mut self, is_asked: bool) -> Result<Found, ControlRefusal> {
        let (mut factor, mut broken) = self.largest()?;
        let mut reductions = 0;
        let largest = loop {
            let broke = match self.at(factor) {
                Tried::Kept(controller) => match self.first_broken(&controller, Robots::Drawn) {
                    None => break controller,
                    Some(what) => what,
                },
                Tried::Broken(what) => what,
            };
            if reductions == REDUCTIONS {
                return Err(ControlRefusal::NoBandwidth { because: broke });
            }
            broken = Some(broke);
            factor *= LESS;
            reductions += 1;
        };
        let limited_by = broken.unwrap_or_else(|| {
            format!(
                "a tenth of the sampling rate, {:.3} Hz",
                HIGHEST / self.task.period
            )
        });
        let base = self.base.clone();
        let hz = |factor: f64| {
            base.iter()
                .map(|bandwidth| factor * bandwidth)
                .collect::<Vec<f64>>()
        };
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
        if let Tried::Kept(controller) = self.at(1.0)
            && self.first_broken(&controller, Robots::Drawn).is_none()
        {
            return Ok(Found {
                controller,
                bandwidth: bandwidth(1.0),
            });
        }
        Err(ControlRefusal::TooFast {
            asked_hz: hz(1.0),
            largest_hz: hz(factor),
            because: limited_by,
        })
    }

    /// Returns the largest factor that keeps the margins of the identified robot at all poses, and the margin that
    /// breaks above it.
    fn largest(&mut self) -> Result<(f64, Option<String>), ControlRefusal> {
        let fastest = self.base.iter().copied().fold(0.0, f64::max);
        let top = LARGEST.min(HIGHEST / self.task.period / fastest);
        let steps = (PER_DECADE * (top / SMALLEST).log10()).ceil().max(1.0);
        let factors = (0..=steps as usize).map(|k| top * (SMALLEST / top).powf(k as f64 / steps));
        let mut above: Option<(f64, String)> = None;
        for factor in factors {
            if let Tried::Broken(what) = self.at(factor) {
                above = Some((factor, what));
                continue;
            }
            let Some((mut high, mut what)) = above else {
                return Ok((factor, None));
            };
            let mut low = factor;
            for _ in 0..HALVINGS {
                let middle = (low * high).sqrt();
                match self.at(middle) {
                    Tried::Kept(_) => low = middle,
                    Tried::Broken(reason) => (high, what) = (middle, reason),
                }
            }
            return Ok((low, Some(what)));
        }
        let because = above.map_or_else(String::new, |(_, what)| what);
        Err(ControlRefusal::NoBandwidth { because })
    }

    /// Returns the feedback for a factor: the first that keeps the margins at all poses, or the margin that the first
    /// one breaks. Gains for the coupled arm come first, then those for each joint alone.
    fn at(&mut self, factor: f64) -> Tried {
        let task = self.task;
        let aim = Aim {
            feedback: task.settings.feedback,
            bandwidth_hz: self
                .base
                .iter()
                .map(|bandwidth| factor * bandwidth)
                .collect(),
            damping: task.settings.damping,
        };
        let coupled = self.centres.iter().map(|centre| {
            let plant = Sampled::new(task.model, centre, task.period);
            gains(task.model, centre, &plant, &aim)
        });
        let is_quadratic = aim.feedback == Feedback::StateFeedback;
        let alone = (self.centres.iter().filter(|_| is_quadratic))
            .map(|centre| of_joints(task.model, centre, task.period, &aim));
        let all: Vec<Vec<Vec<f64>>> = coupled.chain(alone).flatten().collect();
        let mut first = None;
        for gain in all {
            let controller = task.feedback(gain, self.speed);
            match self.first_broken(&controller, Robots::Identified) {
                None => return Tried::Kept(controller),
                Some(what) => {
                    first.get_or_insert(what);
                }
            }
        }
        Tried::Broken(first.unwrap_or_else(|| "no gain stabilises the equations".to_owned()))
    }

    /// Returns the first margin that does not hold, in a sentence. The case in which a margin broke last comes first.
    fn first_broken(&mut self, controller: &Controller, robots: Robots) -> Option<String> {
        let cases = match robots {
            Robots::Identified => &mut self.identified,
            Robots::Drawn => &mut self.drawn,
        };
        let blocks = std::iter::once(0..1).chain(
            (1..cases.len())
                .step_by(BLOCK)
                .map(|from| from..(from + BLOCK).min(cases.len())),
        );
        for block in blocks {
            let block_cases = cases.get(block.clone()).unwrap_or_default();
            let all = stabilities(self.task, controller, block_cases);
            let broken = all.iter().position(|stability| {
                stability
                    .as_ref()
                    .is_none_or(|stability| !keeps(stability, self.task.settings))
            });
            if let Some(k) = broken {
                let case = block_cases[k];
                cases.swap(0, block.start + k);
                return Some(match &all[k] {
                    None => "no robot has these values".to_owned(),
                    Some(stability) => self.words(stability, &case),
                });
            }
        }
        None
    }

    fn words(&self, stability: &Stability, case: &Case<'_>) -> String {
        let pose: Vec<String> = (self.task.poses[case.pose].iter())
            .map(|q| format!("{q:.2}"))
            .collect();
        let whose = if case.robot == 0 {
            String::new()
        } else {
            format!(" of robot {} of the posterior", case.robot)
        };
        let pose = format!("in the pose [{}] rad{whose}", pose.join(", "));
        let light = (stability.vibrations.iter()).min_by(|a, b| a.damping.total_cmp(&b.damping));
        let resonance = light.map_or_else(String::new, |pole| {
            format!(
                "; its least damped vibration has {:.3} Hz and the damping ratio {:.2}",
                pole.hz, pole.damping
            )
        });
        if stability.growth_per_s.is_some() {
            return format!("{pose} the loop is unstable{resonance}");
        }
        let settings = self.task.settings;
        let lacking = stability.margins.iter().zip(self.task.model.joints());
        let broken = lacking.flat_map(|(margin, joint)| {
            let gain = (margin.gain_db, settings.gain_margin_db, "gain", " dB");
            let phase = (margin.phase_deg, settings.phase_margin_deg, "phase", "°");
            [gain, phase].map(|(margin, least, what, unit)| {
                (margin / least, margin, least, what, unit, joint)
            })
        });
        let worst = broken.min_by(|a, b| a.0.total_cmp(&b.0));
        worst.map_or(pose.clone(), |(_, margin, least, what, unit, joint)| {
            // A search ends at the limit, so the margin often has the digits of the limit.
            let margin = if (10.0 * (least - margin)).round() < 1.0 {
                format!("just below {least}{unit}")
            } else {
                format!("of {margin:.1}{unit}, less than {least}{unit}")
            };
            format!("{pose} the loop of {joint} keeps a {what} margin {margin}{resonance}")
        })
    }
}
