//! Figures of one joint: friction, spring, residual and its spectrum.

use super::document::{Figure, Layout, Panel, Series, Style};
use super::plots::slug;
use super::spectrum::spectrum;
use crate::curves::{CurveSet, Curves};
use crate::estimate::EstimateResult;

/// Largest number of points of a cloud.
const CLOUD_POINTS: usize = 600;

/// Number of points of a model curve in a cloud.
const CURVE_POINTS: usize = 60;

/// The figures of one joint by one estimate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointFigures {
    /// Friction against velocity of the motor; `None` without viscous friction. Only the first estimate of an identification
    /// has the curves of this figure and of the spring.
    pub friction: Option<Figure>,
    /// Torque of the spring against its deflection; `None` for a rigid joint.
    pub spring: Option<Figure>,
    /// Measured minus predicted torque of the motor over time.
    pub residual: Option<Figure>,
    /// Power density of the residual; `None` for a short log.
    pub spectrum: Option<Figure>,
}

impl JointFigures {
    /// Composes the figures of a joint. All are `None` if the curves do not contain the joint or the estimate.
    ///
    /// - `fit`: curves of the identification.
    /// - `joint`: name of the joint.
    #[must_use]
    pub fn of(result: &EstimateResult, fit: &Curves, joint: &str) -> Self {
        let Some((set, measured)) = fit.set(&result.estimator).zip(fit.set("measured")) else {
            return Self::default();
        };
        let curves = JointCurves {
            fit,
            set,
            measured,
            joint,
        };
        Self {
            friction: curves.friction(),
            spring: curves.spring(),
            residual: curves.residual(),
            spectrum: curves.spectrum(),
        }
    }
}

/// The curves of one joint.
struct JointCurves<'a> {
    fit: &'a Curves,
    set: &'a CurveSet,
    measured: &'a CurveSet,
    joint: &'a str,
}

impl JointCurves<'_> {
    /// Returns the values of a column of the joint and its unit, as text.
    fn column<'s>(
        &self,
        of: &'s CurveSet,
        what: &str,
    ) -> Option<(&'s [Option<f64>], &'static str)> {
        let units = [
            ("_nm", "N·m"),
            ("_n", "N"),
            ("_rad_per_s", "rad/s"),
            ("_m_per_s", "m/s"),
            ("_rad", "rad"),
            ("_m", "m"),
        ];
        units.into_iter().find_map(|(end, unit)| {
            let name = format!("{}.{what}{end}", self.joint);
            let index = self.fit.columns.iter().position(|column| *column == name)?;
            Some((of.values.get(index)?.as_slice(), unit))
        })
    }

    fn figure(&self, what: &str, caption: String, x_label: String, panel: Panel) -> Figure {
        Figure {
            x_label,
            ..Figure::over_time(
                format!("{what}-{}", slug(self.joint)),
                caption,
                Layout::Half,
                [panel],
            )
        }
    }

    /// Returns the friction of the motor against its velocity.
    fn friction(&self) -> Option<Figure> {
        let (velocity, speed) = self.column(self.set, "friction_velocity")?;
        let (model, unit) = self.column(self.set, "friction")?;
        let (measured, _) = self.column(self.set, "friction_measured")?;
        let (half, _) = self.column(self.set, "friction_half_width")?;
        let cloud = Cloud::new(velocity, [measured, model, half])?;
        let mut series = vec![cloud.points()];
        series.extend(cloud.model(&self.set.label));
        series.extend(cloud.bounds());
        Some(self.figure(
            "friction",
            format!(
                "Friction of the motor of {}: what the measured torque leaves for it, the model, and its 95 % interval.",
                self.joint
            ),
            format!("velocity [{speed}]"),
            Panel {
                y_label: format!("friction [{unit}]"),
                x: cloud.x,
                series,
                ..Panel::default()
            },
        ))
    }

    /// Returns the torque of the spring against its deflection.
    fn spring(&self) -> Option<Figure> {
        let (deflection, angle) = self.column(self.measured, "deflection")?;
        let (model, unit) = self.column(self.set, "spring")?;
        let (measured, _) = self.column(self.set, "spring_measured")?;
        let none = vec![None; model.len()];
        let cloud = Cloud::new(deflection, [measured, model, &none])?;
        let mut series = vec![cloud.points()];
        series.extend(cloud.model(&self.set.label));
        Some(self.figure(
            "spring",
            format!(
                "Spring of {}: what the measured torque leaves for it, and the model. A loop of the points is \
                 hysteresis.",
                self.joint
            ),
            format!("deflection [{angle}]"),
            Panel {
                y_label: format!("torque of the spring [{unit}]"),
                x: cloud.x,
                series,
                ..Panel::default()
            },
        ))
    }

    /// Returns the difference of measured and predicted torque; absent values are gaps.
    fn difference(&self) -> Option<(Vec<Option<f64>>, &'static str)> {
        let (measured, unit) = self.column(self.measured, "motor")?;
        let (model, _) = self.column(self.set, "motor")?;
        let pairs = measured.iter().zip(model);
        Some((pairs.map(|(a, b)| Some((*a)? - (*b)?)).collect(), unit))
    }

    fn residual(&self) -> Option<Figure> {
        let (values, unit) = self.difference()?;
        Some(self.figure(
            "residual",
            format!(
                "Torque of the motor of {} that the model does not explain: measured minus predicted.",
                self.joint
            ),
            "time [s]".to_owned(),
            Panel {
                y_label: format!("residual [{unit}]"),
                x: self.measured.time.clone(),
                series: vec![line(&self.set.label, values)],
                ..Panel::default()
            },
        ))
    }

    fn spectrum(&self) -> Option<Figure> {
        let (values, unit) = self.difference()?;
        let found = spectrum(&self.measured.time, &values)?;
        let decibels =
            |density: &f64| Some(10.0 * density.log10()).filter(|level| level.is_finite());
        Some(self.figure(
            "spectrum",
            format!(
                "Spectrum of the residual of {}. A peak at a vibration of the spring says that its frequency or damping is \
                 wrong, other peaks belong to effects that the model lacks.",
                self.joint
            ),
            "frequency [Hz]".to_owned(),
            Panel {
                y_label: format!("power density [dB of ({unit})²/Hz]"),
                series: vec![line(&self.set.label, found.density.iter().map(decibels).collect())],
                x: found.frequency_hz,
                ..Panel::default()
            },
        ))
    }
}

fn line(name: &str, values: Vec<Option<f64>>) -> Series {
    Series::new(name, Style::First, values)
}

/// Points in ascending order of their abscissa, with curves of the model.
struct Cloud {
    x: Vec<f64>,
    measured: Vec<Option<f64>>,
    model: Vec<f64>,
    half_width: Vec<Option<f64>>,
}

impl Cloud {
    /// - `[measured, model, half_width]`: one value per abscissa. Points without one of the first two are left out; `None`
    ///   if no point has both.
    fn new(x: &[Option<f64>], [measured, model, half_width]: [&[Option<f64>]; 3]) -> Option<Self> {
        let mut points: Vec<(f64, f64, f64, Option<f64>)> = (x.iter().enumerate())
            .filter_map(|(k, x)| {
                let half = half_width.get(k).copied().flatten();
                Some(((*x)?, (*measured.get(k)?)?, (*model.get(k)?)?, half))
            })
            .filter(|point| point.0.is_finite())
            .collect();
        let every = points.len().div_ceil(CLOUD_POINTS).max(1);
        points = points.into_iter().step_by(every).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        (!points.is_empty()).then(|| Self {
            x: points.iter().map(|point| point.0).collect(),
            measured: points.iter().map(|point| Some(point.1)).collect(),
            model: points.iter().map(|point| point.2).collect(),
            half_width: points.iter().map(|point| point.3).collect(),
        })
    }

    fn points(&self) -> Series {
        Series::new("measured", Style::Cloud, self.measured.clone())
    }

    /// Returns a curve whose values are medians over neighbouring points, at the middle of them: they lie on a rising
    /// law, also with a few deviating points at a reversal of the motion.
    fn curve(&self, of: impl Fn(usize) -> Option<f64>) -> Option<Vec<Option<f64>>> {
        let size = self.x.len().div_ceil(CURVE_POINTS).max(1);
        let mut values = vec![None; self.x.len()];
        for start in (0..self.x.len()).step_by(size) {
            let end = (start + size).min(self.x.len());
            let members: Option<Vec<f64>> = (start..end).map(&of).collect();
            values[usize::midpoint(start, end)] = members.map(|mut members| {
                members.sort_by(f64::total_cmp);
                members[members.len() / 2]
            });
        }
        values.iter().any(Option::is_some).then_some(values)
    }

    fn model(&self, name: &str) -> Option<Series> {
        Some(line(name, self.curve(|k| Some(self.model[k]))?))
    }

    fn bounds(&self) -> Vec<Series> {
        let bound = |name: &str, sign: f64| {
            let of = |k: usize| Some(self.model[k] + sign * self.half_width[k]?);
            Some(Series::new(name, Style::Reference, self.curve(of)?))
        };
        [bound("95 %, low", -1.0), bound("95 %, high", 1.0)]
            .into_iter()
            .flatten()
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_sorted_and_curves_have_fewer_values() {
        let x: Vec<Option<f64>> = (0..3000).map(|k| Some(f64::from(3000 - k))).collect();
        let none = vec![None; x.len()];
        let cloud = Cloud::new(&x, [&x, &x, &none]).unwrap();
        assert!(cloud.x.len() <= CLOUD_POINTS && cloud.x.is_sorted());
        let model = cloud.model("model").unwrap();
        let shown = model.values.iter().flatten().count();
        assert!((1..=CURVE_POINTS).contains(&shown), "{shown}");
        // The curve of this cloud is its own line.
        let on_line = |(x, y): (&f64, &Option<f64>)| y.is_none_or(|y| (y - x).abs() < 1e-12);
        assert!(cloud.x.iter().zip(&model.values).all(on_line));
        assert!(cloud.bounds().is_empty());
        let gap = Cloud::new(&[Some(1.0), Some(2.0)], [&[None, Some(3.0)], &x, &none]).unwrap();
        assert_eq!((gap.x, gap.measured), (vec![2.0], vec![Some(3.0)]));
        assert!(Cloud::new(&x, [&none, &x, &none]).is_none());
    }
}
