//! The information of a motion about the parameters: a surrogate for the bound of Cramér and Rao that has a gradient.
//!
//! The equations of motion `Y theta = tau` have errors with the spectrum of [`noise`](super::noise). With
//! the transforms of the entries of `Y` and the inverse root of the spectrum, least squares give the information.

use std::f64::consts::TAU;

use faer::Mat;
use sprung_core::parameters::JointParameter;

use super::noise::{Errors, whiteners};
use crate::model::Model;

/// The weighted columns of one motion; [`Weighting::pull`] needs them.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    weighted: Mat<f64>,
    /// The information, \[p × p\]: free parameters, then nuisance parameters.
    pub(super) matrix: Mat<f64>,
}

/// Standard error of a parameter without any information, in its scale.
const UNKNOWN: f64 = 100.0;

/// The times and frequencies of a motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Number of even times.
    pub(super) samples: usize,
    /// Their length, s.
    pub(super) duration: f64,
    /// Number of frequencies, from zero on.
    pub(super) lines: usize,
}

/// From the entries of the regressor at even times to the information of the free parameters.
#[derive(Clone, Debug)]
pub(super) struct Weighting {
    /// Cosines and negative sines of each frequency at each time, \[2 lines × samples\].
    transform: Mat<f64>,
    whiteners: Vec<Mat<f64>>,
    /// Row and place of the parameter of each entry; `None` for known parameters.
    places: Vec<(usize, Option<usize>)>,
    rows: usize,
    /// Columns of nuisance parameters at frequency zero, with their rows and values.
    nuisances: Vec<[(usize, f64); 2]>,
    /// Indices in theta of the free parameters.
    pub(super) free: Vec<usize>,
    known: Mat<f64>,
}

impl Weighting {
    /// - `repeats`: how often the robot repeats the motion.
    pub(super) fn new(
        model: &Model,
        theta: &[f64],
        errors: &Errors,
        poses: &[Vec<f64>],
        grid: &Grid,
        repeats: f64,
    ) -> Self {
        let Grid {
            samples,
            duration,
            lines,
        } = *grid;
        let rows = model.coordinates();
        let rates: Vec<f64> = (0..lines).map(|k| TAU * k as f64 / duration).collect();
        let mut all = whiteners(model, theta, errors, poses, &rates);
        // Both signs of a frequency count; a sum over samples is an integral over the sampling period.
        let sample = duration / samples as f64;
        for (k, whitener) in all.iter_mut().enumerate() {
            let count: f64 = if k == 0 { 1.0 } else { 2.0 };
            *whitener *= faer::Scale(sample * (count * repeats / duration).sqrt());
        }
        let parameters = model.parameters().iter().enumerate();
        let free: Vec<usize> = parameters
            .filter(|(_, parameter)| parameter.fixed.is_none())
            .map(|(index, _)| index)
            .collect();
        let mut places = vec![(0, None); model.robot().entries];
        for row in 0..rows {
            let columns = model.equation_columns(row).iter();
            for (entry, column) in model.equation_entries(row).zip(columns) {
                places[entry] = (row, free.iter().position(|other| other == column));
            }
        }
        let mut nuisances = Vec::new();
        let mut levels = Vec::new();
        for joint in (0..model.joint_count()).filter(|&joint| model.is_flexible(joint)) {
            let preload = model.index(JointParameter::Preload, joint);
            let is_free = preload.is_some_and(|index| free.contains(&index));
            let stiffness = model.index(JointParameter::Stiffness, joint);
            if let (false, Some(stiffness)) = (is_free, stiffness) {
                let k = theta[stiffness];
                let sum = samples as f64;
                nuisances.push([(joint, -k * sum), (model.torque_row(joint), k * sum)]);
                levels.push(errors.steps.iter().map(|step| step[joint]).sum::<f64>());
            }
        }
        let count = free.len() + nuisances.len();
        let mut known = Mat::zeros(count, count);
        for (k, level) in levels.into_iter().enumerate() {
            known[(free.len() + k, free.len() + k)] = level.powi(-2);
        }
        Self {
            transform: Mat::from_fn(2 * lines, samples, |i, t| {
                let angle = TAU * ((i % lines) * t % samples) as f64 / samples as f64;
                if i < lines { angle.cos() } else { -angle.sin() }
            }),
            whiteners: all,
            places,
            rows,
            nuisances,
            free,
            known,
        }
    }

    /// Returns the weighting with the information of earlier logs, \[free × free\], and a weak prior of each parameter,
    /// so that the objective of a motion without any information is finite.
    ///
    /// - `scales`: of the free parameters.
    pub(super) fn with_known(mut self, information: Option<&Mat<f64>>, scales: &[f64]) -> Self {
        for (i, scale) in scales.iter().enumerate() {
            self.known[(i, i)] += (UNKNOWN * scale).powi(-2);
        }
        if let Some(information) = information {
            for i in 0..information.nrows() {
                for j in 0..information.ncols() {
                    self.known[(i, j)] += information[(i, j)];
                }
            }
        }
        self
    }

    /// Returns the number of frequencies.
    fn lines(&self) -> usize {
        self.whiteners.len()
    }

    /// Returns the information of a motion.
    ///
    /// - `entries`: of the regressor, \[samples × entries\].
    pub(super) fn columns(&self, entries: &Mat<f64>) -> Columns {
        let (lines, rows) = (self.lines(), self.rows);
        let count = self.known.nrows();
        let spectra = &self.transform * entries;
        let mut weighted = Mat::zeros(2 * rows * lines, count);
        let mut line_columns = Mat::zeros(2 * rows, count);
        for (k, whitener) in self.whiteners.iter().enumerate() {
            line_columns.fill(0.0);
            for (entry, &(row, place)) in self.places.iter().enumerate() {
                if let Some(place) = place {
                    line_columns[(row, place)] += spectra[(k, entry)];
                    line_columns[(rows + row, place)] += spectra[(lines + k, entry)];
                }
            }
            if k == 0 {
                for (index, nuisance) in self.nuisances.iter().enumerate() {
                    for &(row, value) in nuisance {
                        line_columns[(row, self.free.len() + index)] += value;
                    }
                }
            }
            let turned = whitener * &line_columns;
            (weighted.as_mut())
                .subrows_mut(2 * rows * k, 2 * rows)
                .copy_from(&turned);
        }
        let matrix = weighted.transpose() * &weighted + &self.known;
        Columns { weighted, matrix }
    }

    /// Returns the derivatives of a function by the entries from those by the information.
    ///
    /// - `by_matrix`: symmetric, \[p × p\].
    pub(super) fn pull(&self, columns: &Columns, by_matrix: &Mat<f64>) -> Mat<f64> {
        let (lines, rows) = (self.lines(), self.rows);
        let by_weighted = (&columns.weighted * by_matrix) * faer::Scale(2.0);
        let mut by_spectra = Mat::zeros(2 * lines, self.places.len());
        for (k, whitener) in self.whiteners.iter().enumerate() {
            let by_rows = by_weighted.as_ref().subrows(2 * rows * k, 2 * rows);
            let by_columns = whitener.transpose() * by_rows;
            for (entry, &(row, place)) in self.places.iter().enumerate() {
                if let Some(place) = place {
                    by_spectra[(k, entry)] = by_columns[(row, place)];
                    by_spectra[(lines + k, entry)] = by_columns[(rows + row, place)];
                }
            }
        }
        self.transform.transpose() * by_spectra
    }
}
