//! Composes the summary of all joints, and one page per joint.

use super::contents::Contents;
use super::document::{
    Block, Column, Figure, Fold, Layout, Line, Panel, Row, Section, Series, Style, Table, Tone,
};
use super::groups::Joints;
use super::intervals::half_width;
use super::numbers::significant;
use super::plots::slug;
use super::section::{folded, section, shown};
use super::spectrum::spectrum;
use super::tables;
use crate::curves::{CurveSet, Curves};
use crate::estimate::{EstimateResult, FeatureKind, Identification, Verdict};
use crate::finding::Finding;

/// Largest number of points of a cloud.
const CLOUD_POINTS: usize = 600;

/// Number of places at which a curve of the model stands in a cloud.
const CURVE_POINTS: usize = 60;

/// Codes of findings about joints whose motion does not determine their parameters.
const HARDLY_MOVES: [&str; 2] = ["hardly-moves", "at-rest"];

/// Composes the table of all joints for a reader who decides; `None` without a result.
pub(super) fn summary(identification: &Identification) -> Option<Section> {
    let result = identification.results.first()?;
    let joints = Joints::of(identification);
    let column = |heading: &str| Column {
        heading: heading.to_owned(),
        numeric: false,
    };
    let rows: Vec<Row> = (joints.names().iter())
        .map(|joint| {
            let (tone, word) = rating(identification, result, &joints, joint);
            let value = |parameter: &str| with_interval(result, &format!("{joint}.{parameter}"));
            let torque = result.promise.iter().find(|own| own.joint == *joint);
            let error = torque.map(|own| 100.0 * own.torque_error_nm / own.torque_nm);
            Row {
                cells: vec![
                    joint.clone(),
                    word.to_owned(),
                    value("stiffness"),
                    resonance(identification, joint),
                    value("motor_coulomb"),
                    value("motor_viscous"),
                    error.map_or_else(dash, |error| format!("{} %", significant(error, 2))),
                ],
                tone,
            }
        })
        .collect();
    let table = Table {
        caption: "One row per joint, with 95 % intervals. The resonance is that with free motors in the mean pose of the \
                  log. The last column is the promised error of the motor torque."
            .to_owned(),
        columns: [
            "Joint", "Verdict", "Stiffness", "Resonance", "Coulomb friction, motor", "Viscous friction, motor",
            "Torque error",
        ]
        .map(column)
        .to_vec(),
        rows,
        headings: Vec::new(),
    };
    (!table.rows.is_empty()).then(|| section("joints", "Joints", "", vec![Block::Table(table)]))
}

/// Returns the colour and the word of a joint.
fn rating(
    identification: &Identification,
    result: &EstimateResult,
    joints: &Joints,
    joint: &str,
) -> (Tone, &'static str) {
    let is_still =
        |own: &Finding| HARDLY_MOVES.contains(&own.code.as_str()) && is_about(own, joints, joint);
    let doubted = &result.decision.parameters;
    let is_doubted = doubted.is_empty() || doubted.iter().any(|own| joints.group(own) == joint);
    match result.verdict {
        _ if identification.findings.iter().any(is_still) => (Tone::Doubtful, "hardly moves"),
        Verdict::Unusable => (Tone::Bad, "unusable"),
        Verdict::Doubtful if is_doubted => (Tone::Doubtful, "doubtful"),
        Verdict::Good | Verdict::Doubtful => (Tone::Good, "good"),
    }
}

/// Returns a parameter with its unit and interval.
fn with_interval(result: &EstimateResult, name: &str) -> String {
    let found = result.parameters.iter().find(|own| own.name == name);
    let Some((own, value)) = found.and_then(|own| Some((own, own.value?))) else {
        return dash();
    };
    let half = half_width(own).map_or_else(String::new, |half| {
        format!(" ± {} %", significant(100.0 * half, 2))
    });
    format!("{} {}{half}", significant(value, 3), own.unit)
}

fn resonance(identification: &Identification, joint: &str) -> String {
    let lines = vibrations(identification, joint);
    lines
        .first()
        .map_or_else(dash, |own| format!("{} Hz", significant(own.at, 3)))
}

/// Returns the resonance and the antiresonance of a joint by the model, Hz.
fn vibrations(identification: &Identification, joint: &str) -> Vec<Line> {
    let responses = identification
        .frequency_response
        .iter()
        .flat_map(|own| &own.joints);
    let mut features: Vec<_> = (responses.filter(|own| own.joint == joint))
        .flat_map(|own| &own.features)
        .collect();
    features.sort_by_key(|own| own.kind != FeatureKind::Resonance);
    (features.into_iter())
        .map(|own| Line {
            at: own.model_hz,
            text: own.kind.word().to_owned(),
        })
        .collect()
}

fn dash() -> String {
    "–".to_owned()
}

/// Composes a page per joint: friction, spring, residual and its spectrum, parameters and findings.
pub(super) fn pages(identification: &Identification, contents: &Contents<'_>) -> Vec<Section> {
    let Some(result) = identification.results.first() else {
        return Vec::new();
    };
    let joints = Joints::of(identification);
    let page = |joint: &String| {
        let mut blocks: Vec<Block> = Vec::new();
        if let Some(fit) = contents.fit {
            let figures = figures(identification, result, fit, joint);
            blocks.extend(figures.into_iter().map(Block::Figure));
        }
        blocks.extend(
            tables::parameters(identification, contents.truth, Some(joint)).map(Block::Table),
        );
        let findings: Vec<_> = (identification.findings.iter().chain(&result.warnings))
            .filter(|own| is_about(own, &joints, joint))
            .map(shown)
            .collect();
        if !findings.is_empty() {
            blocks.push(Block::Findings(findings));
        }
        let (_, word) = rating(identification, result, &joints, joint);
        folded(
            Fold::Screen,
            &format!("joint-{}", slug(joint)),
            &format!("Joint {joint}"),
            &format!("{word}: friction, spring, residual, parameters and findings of this joint."),
            blocks,
        )
    };
    joints.names().iter().map(page).collect()
}

/// Returns whether a finding concerns a parameter of a joint, or names the joint.
fn is_about(finding: &Finding, joints: &Joints, joint: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let is_named = |(at, found): (usize, &str)| {
        let before = finding.text[..at].chars().next_back();
        let after = finding.text[at + found.len()..].chars().next();
        !before.is_some_and(is_part) && !after.is_some_and(is_part)
    };
    (finding.parameters.iter()).any(|own| joints.group(own) == joint)
        || finding.text.match_indices(joint).any(is_named)
}

fn figures(
    identification: &Identification,
    result: &EstimateResult,
    fit: &Curves,
    joint: &str,
) -> Vec<Figure> {
    let Some((set, measured)) = fit.set(&result.estimator).zip(fit.set("measured")) else {
        return Vec::new();
    };
    let curves = JointCurves {
        fit,
        set,
        measured,
        joint,
    };
    [
        curves.friction(),
        curves.spring(),
        curves.residual(),
        curves.spectrum(identification),
    ]
    .into_iter()
    .flatten()
    .collect()
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
            let index = self.fit.columns.iter().position(|own| *own == name)?;
            Some((of.values.get(index)?.as_slice(), unit))
        })
    }

    fn figure(&self, what: &str, caption: String, x_label: String, panel: Panel) -> Figure {
        Figure {
            id: format!("{what}-{}", slug(self.joint)),
            caption,
            x_label,
            layout: Layout::Half,
            panels: vec![panel],
        }
    }

    /// Returns the friction of the motor against its velocity.
    fn friction(&self) -> Option<Figure> {
        let (velocity, speed) = self.column(self.set, "friction_velocity")?;
        let (model, unit) = self.column(self.set, "friction")?;
        let (measured, _) = self.column(self.set, "friction_measured")?;
        let (half, _) = self.column(self.set, "friction_half_width")?;
        let cloud = Cloud::new(velocity, [measured, model, half]);
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
        let cloud = Cloud::new(deflection, [measured, model, &none]);
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

    fn spectrum(&self, identification: &Identification) -> Option<Figure> {
        let (values, unit) = self.difference()?;
        let found = spectrum(&self.measured.time, &values)?;
        let highest = found.frequency_hz.last().copied()?;
        let mut marks = vibrations(identification, self.joint);
        marks.retain(|own| own.at <= highest);
        let decibels = |density: &f64| Some(10.0 * density.log10()).filter(|own| own.is_finite());
        Some(self.figure(
            "spectrum",
            format!(
                "Spectrum of the residual of {}. A peak at a vibration of the model says that its frequency or damping is \
                 wrong, other peaks belong to effects that the model lacks.",
                self.joint
            ),
            "frequency [Hz]".to_owned(),
            Panel {
                y_label: format!("power density [dB of ({unit})²/Hz]"),
                series: vec![line(&self.set.label, found.density.iter().map(decibels).collect())],
                x: found.frequency_hz,
                marks,
                ..Panel::default()
            },
        ))
    }
}

fn line(name: &str, values: Vec<Option<f64>>) -> Series {
    Series {
        name: name.to_owned(),
        values,
        style: Style::First,
        clipped: false,
    }
}

/// Points in ascending order of their abscissa, with curves of the model.
struct Cloud {
    x: Vec<f64>,
    measured: Vec<Option<f64>>,
    model: Vec<f64>,
    half_width: Vec<Option<f64>>,
}

impl Cloud {
    /// - `[measured, model, half_width]`: one value per abscissa. Points without one of the first two are left out.
    fn new(x: &[Option<f64>], [measured, model, half_width]: [&[Option<f64>]; 3]) -> Self {
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
        Self {
            x: points.iter().map(|own| own.0).collect(),
            measured: points.iter().map(|own| Some(own.1)).collect(),
            model: points.iter().map(|own| own.2).collect(),
            half_width: points.iter().map(|own| own.3).collect(),
        }
    }

    fn points(&self) -> Series {
        Series {
            name: "measured".to_owned(),
            values: self.measured.clone(),
            style: Style::Cloud,
            clipped: false,
        }
    }

    /// Returns a curve whose values are means over neighbouring points, at the middle of them.
    fn curve(&self, of: impl Fn(usize) -> Option<f64>) -> Option<Vec<Option<f64>>> {
        let size = self.x.len().div_ceil(CURVE_POINTS).max(1);
        let mut values = vec![None; self.x.len()];
        for start in (0..self.x.len()).step_by(size) {
            let end = (start + size).min(self.x.len());
            let own: Option<Vec<f64>> = (start..end).map(&of).collect();
            values[usize::midpoint(start, end)] =
                own.map(|own| own.iter().sum::<f64>() / own.len() as f64);
        }
        values.iter().any(Option::is_some).then_some(values)
    }

    fn model(&self, name: &str) -> Option<Series> {
        Some(line(name, self.curve(|k| Some(self.model[k]))?))
    }

    fn bounds(&self) -> Vec<Series> {
        let bound = |name: &str, sign: f64| {
            let of = |k: usize| Some(self.model[k] + sign * self.half_width[k]?);
            Some(Series {
                name: name.to_owned(),
                style: Style::Reference,
                ..line("", self.curve(of)?)
            })
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
    use crate::finding::Severity;
    use crate::named::Named;

    #[test]
    fn a_finding_is_about_the_joint_that_it_names_or_whose_parameter_it_concerns() {
        let rows = ["joint1.motor_nm", "joint10.motor_nm"];
        let rows: Named = rows.iter().map(|row| ((*row).to_owned(), 0.0)).collect();
        let joints = Joints::of_rows(&rows);
        let finding = |text: &str| Finding::new(Severity::Warning, "code", text.to_owned(), "");
        let about =
            |own: &Finding| ["joint1", "joint10"].map(|joint| is_about(own, &joints, joint));
        assert_eq!(about(&finding("joint10: late")), [false, true]);
        assert_eq!(about(&finding("joint1.stiffness is weak")), [true, false]);
        assert_eq!(about(&finding("subjoint1 is another")), [false, false]);
        let of_link = finding("weak").about(["link2.izz".to_owned()]);
        assert_eq!(about(&of_link), [false, true]);
    }

    #[test]
    fn points_are_sorted_and_curves_have_fewer_values() {
        let x: Vec<Option<f64>> = (0..3000).map(|k| Some(f64::from(3000 - k))).collect();
        let none = vec![None; x.len()];
        let cloud = Cloud::new(&x, [&x, &x, &none]);
        assert!(cloud.x.len() <= CLOUD_POINTS && cloud.x.is_sorted());
        let model = cloud.model("model").unwrap();
        let shown = model.values.iter().flatten().count();
        assert!((1..=CURVE_POINTS).contains(&shown), "{shown}");
        assert!(cloud.bounds().is_empty());
        let gap = Cloud::new(&[Some(1.0), Some(2.0)], [&[None, Some(3.0)], &x, &none]);
        assert_eq!((gap.x, gap.measured), (vec![2.0], vec![Some(3.0)]));
    }
}
