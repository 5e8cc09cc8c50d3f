//! Least squares over the robots that can exist.

use faer::Mat;
use rayon::prelude::*;

use crate::description::Physical;
use crate::estimate::possible::{Beside, Normal, Robots, Tool, known, squared_distance};
use crate::fit::{Fitted, HoldOut};
use crate::model::{Model, Theta};
use crate::regression::System;

/// Distance below which the unconstrained estimate counts as that of a robot that can exist, in standard errors.
const SAME: f64 = 1e-3;

/// The robots that can exist, with the equations of a log.
pub(in crate::estimate) struct PossibleFit<'a> {
    pub(in crate::estimate) robots: Robots<'a>,
    /// Estimate of the equations without constraints, \[p\].
    pub(in crate::estimate) unconstrained: Theta,
    /// Weight of each row.
    weights: Vec<f64>,
    normal: Normal,
    scale: f64,
}

impl<'a> PossibleFit<'a> {
    /// - `fitted`: least squares without constraints, with weighted rows.
    /// - `speeds`: largest speed of each joint in the log, rad/s (m/s), \[n\]; `tool`: where a tool may be.
    pub(super) fn new(
        model: &'a Model,
        settings: &Physical,
        system: &System,
        fitted: &Fitted,
        (speeds, tool): (&[f64], Tool),
    ) -> Option<Self> {
        let errors = &fitted.standard_error;
        let known = known(model, &fitted.identifiable, errors);
        let normal = Normal::new(model, system, fitted.weights())?;
        Some(Self {
            scale: normal.scale(&known, errors)?,
            robots: Robots::new(model, settings, &fitted.theta, Beside::Log(speeds, tool)),
            unconstrained: fitted.theta.clone(),
            weights: fitted.weights().to_vec(),
            normal,
        })
    }

    /// Returns the information of the equations, \[p × p\]. Standard errors that follow from it have the median of those
    /// of the fit.
    pub(in crate::estimate) fn information(&self) -> Mat<f64> {
        self.normal.clone().divided(self.scale).information
    }

    /// Returns the parameters of the robot that has the least squared residuals, \[p\]; `None` if the limits contradict
    /// each other.
    pub(super) fn best(&self) -> Option<Theta> {
        let normal = self.normal.clone().divided(self.scale);
        let near = &self.unconstrained;
        let found = self
            .robots
            .best(&normal.information, &normal.gradient, near)
            .ok()?;
        let squares = squared_distance(&normal.information, &found.theta, near);
        Some(if squares < SAME * SAME {
            near.clone()
        } else {
            found.theta
        })
    }

    /// Returns the parameters without each part of a log, \[parts\].
    ///
    /// - `fits`: the fits without constraints, \[parts\]\[p\].
    pub(super) fn without_each(
        &self,
        hold_out: &HoldOut<'_>,
        fits: &[Theta],
    ) -> Option<Vec<Theta>> {
        let parts: Vec<_> = hold_out.parts().iter().zip(fits).collect();
        (parts.par_iter())
            .map(|(part, near)| {
                let part = Normal::of(self.robots.model, (*part).clone(), &self.weights);
                let normal = self.normal.without(&part).divided(self.scale);
                let found = self
                    .robots
                    .best(&normal.information, &normal.gradient, near);
                Some(found.ok()?.theta)
            })
            .collect()
    }

    /// Returns the parameters by chosen parts of a log, \[p\].
    pub(in crate::estimate) fn fit(
        &self,
        hold_out: &HoldOut<'_>,
        is_chosen: impl Fn(usize) -> bool,
    ) -> Option<Theta> {
        let parts = hold_out.parts().iter().enumerate();
        let normal = (parts.filter(|(part, _)| is_chosen(*part)))
            .map(|(_, part)| Normal::of(self.robots.model, part.clone(), &self.weights))
            .reduce(Normal::with)?;
        let normal = normal.divided(self.scale);
        let near = &self.unconstrained;
        let found = self
            .robots
            .best(&normal.information, &normal.gradient, near);
        Some(found.ok()?.theta)
    }
}
