//! Least squares over the robots that can exist.

use std::collections::BTreeMap;

use faer::Mat;
use rayon::prelude::*;

use crate::description::Physical;
use crate::estimate::possible::{
    Beside, MassLimit, Normal, Possible, Robots, Tool, known, squared_distance,
};
use crate::estimate::statistics::CERTAIN_SIGMAS;
use crate::fit::{Fitted, HoldOut};
use crate::model::{Model, NoSolution, Theta};
use crate::regression::System;

/// Distance below which the unconstrained estimate counts as possible, in standard errors.
const MAX_DISTANCE_OF_POSSIBLE: f64 = 1e-3;

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

/// Limits of masses that a log contradicts.
pub(in crate::estimate) struct Contradicted {
    /// The limits, with the masses of the robot that fits the log best without them, kg.
    pub(in crate::estimate) limits: Vec<(MassLimit, f64)>,
    /// Distance of the robot within the limits from that robot, in standard errors of the equations.
    pub(in crate::estimate) standard_errors: f64,
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

    /// Returns the parameters of the robot that has the least squared residuals, \[p\].
    ///
    /// # Errors
    ///
    /// The reason why no robot can exist with the given values and limits.
    pub(super) fn best(&self) -> Result<Theta, String> {
        let (found, squares) = self.found().map_err(|reason| self.robots.why(reason))?;
        Ok(
            if squares < MAX_DISTANCE_OF_POSSIBLE * MAX_DISTANCE_OF_POSSIBLE {
                self.unconstrained.clone()
            } else {
                found.theta
            },
        )
    }

    /// Returns the robot that has the least squared residuals, and its squared distance from the estimate without
    /// constraints.
    fn found(&self) -> Result<(Possible, f64), NoSolution> {
        let normal = self.normal.clone().divided(self.scale);
        let near = &self.unconstrained;
        let found = self
            .robots
            .best(&normal.information, &normal.gradient, near)?;
        let squares = squared_distance(&normal.information, &found.theta, near);
        Ok((found, squares))
    }

    /// Returns the limits of masses that the log contradicts.
    ///
    /// - `settings`: with these limits; `motion`: as of [`PossibleFit::new`].
    pub(super) fn contradicted(
        &self,
        settings: &Physical,
        (speeds, tool): (&[f64], Tool),
    ) -> Option<Contradicted> {
        if settings.total_mass_kg.is_none() && settings.mass_kg.is_empty() {
            return None;
        }
        let without = Physical {
            total_mass_kg: None,
            mass_kg: BTreeMap::new(),
            ..settings.clone()
        };
        let (model, near) = (self.robots.model, &self.unconstrained);
        let free = Self {
            robots: Robots::new(model, &without, near, Beside::Log(speeds, tool)),
            unconstrained: near.clone(),
            weights: self.weights.clone(),
            normal: self.normal.clone(),
            scale: self.scale,
        };
        let (with, without) = (self.found().ok()?, free.found().ok()?);
        let standard_errors = (with.1 - without.1).max(0.0).sqrt();
        (standard_errors > CERTAIN_SIGMAS).then(|| Contradicted {
            limits: free.robots.exceeded(settings, &without.0.x),
            standard_errors,
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
