//! Motions that no search made.

use std::f64::consts::TAU;
use std::path::Path;

use sprung_base::finding::GENERATOR;
use sprung_base::progress::Listener;
use sprung_method::excite::{
    Bounds, Certificate, EXCITATION_FORMAT, Excitation, Excited, Frequencies, Limited, Refused,
    SearchResult, Series, Task, certify, more, value_of,
};
use sprung_robot::{MOST_SAMPLES, read_reference};

use super::task::Setup;
use crate::session::error::SessionError;
use crate::session::excite_error::ExciteError;
use crate::session::files::read_text;
use crate::session::load::Session;

/// Limits that are wider by this factor show the used part of the limits.
const WIDER: f64 = 1e6;

impl Session {
    /// Judges a motion that no search made.
    pub(super) fn judged(
        &self,
        method: &str,
        setup: &Setup,
        task: &Task<'_>,
        series: &Series,
        progress: &mut dyn Listener,
    ) -> Result<Excited, SessionError> {
        let frequencies = &Frequencies {
            rate: series.rate,
            harmonics: series.harmonics.clone(),
            periods: (task.settings.duration_s * series.rate / TAU + 1e-9)
                .floor()
                .max(1.0) as usize,
        };
        let wide = Bounds {
            floor: None,
            ..task.bounds.narrowed(&[WIDER; Limited::ALL.len()])
        };
        let wider = Task {
            bounds: &wide,
            ..task.clone()
        };
        let judged = certify(&wider, frequencies, &setup.runs, series);
        let Certificate {
            mut certified,
            mut simulated,
            simulation,
        } = judged.map_err(|broken| setup.refused(&Refused::Motion(broken)))?;
        for limit in certified.iter_mut().chain(&mut simulated) {
            limit.part *= WIDER;
        }
        let is_certified = certify(task, frequencies, &setup.runs, series).is_ok();
        let mut assumed = setup.assumed.clone();
        let bought = self.bought(setup, (frequencies, series), &mut assumed, progress)?;
        let full = match task.known {
            Some(known) => bought.with(known),
            None => bought,
        };
        let promised = setup.promised(task, (frequencies, series), &full);
        let objective = value_of(task, frequencies, series);
        let excitation = Excitation {
            format: EXCITATION_FORMAT,
            generator: GENERATOR.to_owned(),
            robot: setup.experiment.robot.name.clone(),
            method: method.to_owned(),
            objective: task.settings.objective.word().to_owned(),
            is_warm_up: false,
            is_certified,
            motion: setup.motion(series, frequencies, None),
            hold_out: None,
            slow: None,
            limits: setup.limits(&certified, &simulated),
            more: more(setup.robot(), &setup.bounds, &full, &[]),
            promise: promised,
            links_condition_number: setup.links_condition_number(&full),
            assumed,
            search: SearchResult {
                seed: task.settings.seed,
                steps: 0,
                objectives: Vec::new(),
                objective: objective.unwrap_or(f64::INFINITY),
            },
        };
        Ok(Excited {
            excitation,
            simulation,
            trajectory: setup.samples(series, frequencies, None),
            hold_out: None,
            slow: None,
            skeleton: None,
        })
    }

    /// Reads the series of a file's `[controller.reference]`.
    pub(super) fn given_reference(
        &self,
        setup: &Setup,
        file: &Path,
    ) -> Result<Series, SessionError> {
        let text = read_text(&*self.files, file)?;
        let wrong = |why: String| ExciteError::NoReference {
            file: file.display().to_string(),
            why,
        };
        let reference = read_reference(&text, &setup.experiment.robot).map_err(wrong)?;
        let series = Series::of_reference(&reference, &setup.model).map_err(wrong)?;
        if series.period() / setup.runs.period > MOST_SAMPLES {
            let why = format!(
                "one period lasts {:.4} s, which is more than {MOST_SAMPLES:e} samples",
                series.period()
            );
            return Err(wrong(why).into());
        }
        Ok(series)
    }
}

/// Returns the reference of the paper: alternately those of its first and of its second joint.
///
/// # Source
///
/// Eq. (29).
pub(super) fn paper_reference(joints: usize) -> Series {
    // Multiples of 0.1 Hz, amplitude 3°; phases of both joints, degrees.
    let harmonics = vec![2, 5, 10];
    let phases = [[45.0, 30.0, 0.0], [0.0, 90.0, 36.0]];
    let amplitude = 3.0_f64.to_radians();
    Series {
        rate: TAU * 0.1,
        joints: (0..joints)
            .map(|joint| {
                let waves = phases[joint % 2].map(|phase: f64| {
                    let (sin, cos) = phase.to_radians().sin_cos();
                    [amplitude * cos, amplitude * sin]
                });
                std::iter::once(0.0)
                    .chain(waves.into_iter().flatten())
                    .collect()
            })
            .collect(),
        harmonics,
    }
}
