//! Findings about sensors on links, by the motion of the motors and by the equations.

use std::f64::consts::TAU;

use sprung_core::parameters::JointParameter;
use sprung_core::spatial::{Vector, dot};

use super::excerpt::Excerpt;
use super::held_out::held_out;
use super::mounting::{Best, Compared, compare, mounted};
use super::noise::white_noise;
use super::springs::OPEN_STIFFNESS;
use crate::description::{Inertial, InertialFinding};
use crate::finding::{Finding, Severity};
use crate::fit::{fit, over_reference};
use crate::log::{Channels, InertialSensor};
use crate::numbers::Shown;
use crate::regression::Reading;

/// Error of the scale from which it is a finding.
const MIN_SCALE_ERROR: f64 = 0.1;

/// Part of the squared angular velocity that must remain unexplained before axes are tested, and its ratio to the rest
/// with the best rotation.
const MIN_UNEXPLAINED: f64 = 0.05;
const MIN_RATIO: f64 = 4.0;

/// Part of the samples at one extreme, and their number in a row, from which a sensor is saturated.
const SATURATED_SHARE: f64 = 1e-3;
const SATURATED_RUN: usize = 5;

/// Least bias that is reported, relative to the root mean square of the reading.
const MIN_BIAS_SHARE: f64 = 0.02;

/// Share of noise in the variance of a deflection from which its stiffness counts as open.
const MAX_NOISE_SHARE: f64 = 0.03;

/// Held-out error over that with the present reading, below which another sign or unit is right.
const MUCH_BETTER: f64 = 0.5;

/// Returns findings about the sensors on the links of a robot.
///
/// - `file`: name of the log.
pub(crate) fn inertial_findings(reading: &Reading, excerpt: &Excerpt, file: &str) -> Vec<Finding> {
    let (channels, joints) = (reading.channels(), reading.model().joints());
    let Some(sensors) = &channels.inertial else {
        return Vec::new();
    };
    (sensors.all.iter())
        .flat_map(|sensor| {
            let about = About {
                reading,
                excerpt,
                channels,
                kind: sensors.kind,
                sensor,
                file,
                name: &joints[sensor.joint],
            };
            let mut findings = about.saturated();
            findings.extend(about.low_corner());
            if let Some(compared) = compare(channels, sensor, excerpt) {
                findings.extend(about.judge(&compared));
            }
            findings
        })
        .collect()
}

/// A sensor, for findings.
struct About<'a> {
    reading: &'a Reading,
    excerpt: &'a Excerpt,
    channels: &'a Channels,
    kind: Inertial,
    sensor: &'a InertialSensor,
    file: &'a str,
    name: &'a str,
}

impl About<'_> {
    /// Returns the name of the column of an axis.
    fn column(&self, axis: usize) -> &str {
        self.sensor.channels[axis].map_or("", |i| &self.channels.all[i].column)
    }

    fn columns(&self) -> Vec<&str> {
        let given = (0..3).filter(|&axis| self.sensor.channels[axis].is_some());
        given.map(|axis| self.column(axis)).collect()
    }

    fn names(&self) -> String {
        let quoted: Vec<String> = (self.columns().iter())
            .map(|column| format!("\"{column}\""))
            .collect();
        quoted.join(", ")
    }

    fn finding(
        &self,
        severity: Severity,
        about: InertialFinding,
        text: &str,
        remedy: &str,
    ) -> Finding {
        let word = self.kind.word();
        let text = format!("{}: the {word} ({}) {text}", self.name, self.names());
        Finding::new(severity, self.kind.code(about), text, remedy)
    }

    fn judge(&self, compared: &Compared) -> Vec<Finding> {
        let first = self.columns().first().copied().unwrap_or_default();
        let (scale, left) = compared.fit(&self.sensor.mounting);
        let size = scale.abs();
        let is_clear = left < self.kind.clear();
        let motion = self.kind.motion();
        if self.kind.other_unit().scales.contains(&size) && is_clear {
            let text = format!("reads {size:.1} times the {motion} by the motors");
            return vec![self.in_other_unit(&text, scale)];
        }
        let best = compared.best_rotation();
        let best_left = best.as_ref().map(|best| compared.fit(&best.rotation).1);
        let is_wrong =
            |best: f64| left > MIN_UNEXPLAINED.max(MIN_RATIO * best) || is_clear && scale < 0.0;
        if self.columns().len() == 1 {
            if scale < 0.0 && is_clear {
                let text = format!("reads {scale:.3} times the {motion} by the motors");
                return vec![self.reversed(&text, scale)];
            }
            // The sign of an open mounting is part of it.
            let may_be_wrong = !is_clear && self.sensor.is_mounted;
            if let Some(finding) = may_be_wrong.then(|| self.by_equations()).flatten() {
                return vec![finding];
            }
        } else if self.is_left_handed(compared, best.as_ref()) || best_left.is_some_and(is_wrong) {
            return vec![self.wrong_axes(compared, best.as_ref(), left)];
        }
        let mut findings = Vec::new();
        if (size - 1.0).abs() > MIN_SCALE_ERROR && is_clear {
            findings.push(
                self.finding(
                    Severity::Warning,
                    InertialFinding::Scale,
                    &format!("reads {scale:.3} times the {motion} by the motors"),
                    "give gain of the sensor, or correct counts and gear ratio of the motor",
                )
                .seen(self.file, first, scale, ""),
            );
        }
        findings.extend(self.biased(compared));
        if !self.sensor.is_mounted {
            findings.push(self.found_mounting(left));
        }
        findings
    }

    fn in_other_unit(&self, text: &str, scale: f64) -> Finding {
        let unit = self.kind.other_unit();
        let first = self.columns().first().copied().unwrap_or_default();
        self.finding(
            Severity::Error,
            InertialFinding::Scale,
            &format!("{text}: {}", unit.name),
            &format!("use the keys {}", unit.keys),
        )
        .seen(self.file, first, scale, "")
    }

    fn reversed(&self, text: &str, scale: f64) -> Finding {
        let first = self.columns().first().copied().unwrap_or_default();
        self.finding(
            Severity::Error,
            InertialFinding::Sign,
            text,
            "reverse its sign",
        )
        .seen(self.file, first, scale, "")
        .mended_by("[log]", &format!("sign = {{ \"{first}\" = -1 }}"))
    }

    /// Finding: with the other sign or in the other unit the reading explains the torques much better. The links of
    /// soft joints do not follow their motors, so the motion alone does not decide.
    fn by_equations(&self) -> Option<Finding> {
        let channel = self.sensor.channels.into_iter().flatten().next()?;
        let error = |factor: f64| {
            let scaled = self.excerpt.scaled(channel, factor);
            let channels = mounted(self.channels, &scaled);
            held_out(&scaled, &self.reading.with_channels(channels))
        };
        let unscaled = error(1.0)?;
        let unit = self.kind.other_unit();
        let factors = [-1.0, unit.size].into_iter();
        let (factor, other) = factors
            .filter_map(|factor| Some((factor, error(factor)?)))
            .filter(|(factor, other)| *factor < 0.0 || *other < self.kind.largest_error_of_unit())
            .filter(|(_, other)| over_reference(*other, unscaled) < MUCH_BETTER)
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        let errors = format!(
            "leaves {:.1} % of the torques unexplained",
            100.0 * unscaled
        );
        let with = format!("{:.1} %", 100.0 * other);
        Some(if factor < 0.0 {
            self.reversed(&format!("{errors}, with the other sign {with}"), -1.0)
        } else {
            let scale = (10.0 / unit.size).round() / 10.0;
            let text = format!("{errors}, {} {with}", unit.conversion);
            self.in_other_unit(&text, scale)
        })
    }

    /// Returns whether a reflection explains the motion much better than any rotation.
    fn is_left_handed(&self, compared: &Compared, best: Option<&Best>) -> bool {
        let fits = best.and_then(|best| {
            let reflected = compared.fit(&best.reflection?).1;
            Some((reflected, compared.fit(&best.rotation).1))
        });
        self.columns().len() > 1
            && fits.is_some_and(|(reflected, rotated)| {
                reflected < self.kind.clear()
                    && rotated > MIN_UNEXPLAINED.max(MIN_RATIO * reflected)
            })
    }

    /// Finding: the axes of the sensor are exchanged or reversed, or its mounting is another one.
    fn wrong_axes(&self, compared: &Compared, best: Option<&Best>, left: f64) -> Finding {
        let percent = 100.0 * left;
        if self.is_left_handed(compared, best) {
            let text = "is left-handed by the motion of the motors: two axes are exchanged, or one has the \
                        wrong sign";
            let word = self.kind.word();
            let remedy =
                format!("check the order of {word}_x, {word}_y and {word}_z and their signs");
            let finding = self.finding(Severity::Error, InertialFinding::Axes, text, &remedy);
            return finding.seen(self.file, self.column(0), percent, "%");
        }
        let keys = self.kind.mounting_keys();
        let rpy = best.map(|best| rpy_deg(&best.rotation)).unwrap_or_default();
        let after = best.map_or(100.0, |best| 100.0 * compared.fit(&best.rotation).1);
        self.finding(
            Severity::Error,
            InertialFinding::Axes,
            &format!(
                "contradicts the motion of the motors: its given mounting leaves {percent:.0} % of the \
                 squared {} unexplained, the mounting {} leaves {after:.1} %",
                self.kind.motion(),
                self.shown(rpy)
            ),
            &format!(
                "check {keys}, the order of the axes and their signs; without {keys} sprung finds the mounting"
            ),
        )
        .seen(self.file, self.column(0), percent, "%")
    }

    fn found_mounting(&self, left: f64) -> Finding {
        // A wrong place adds a part of the motors' motion to the much smaller deflections.
        let (severity, remedy) = match self.kind.place_key() {
            Some(_) => (Severity::Error, "measure the place on the link, and give"),
            None if left > MIN_UNEXPLAINED => (Severity::Warning, "if you know it, give"),
            None => (Severity::Info, "if you know it, give"),
        };
        self.finding(
            severity,
            InertialFinding::Mounting,
            &format!(
                "has no given mounting; by the motion of the motors it is {}, and {:.2} % of the squared \
                 {} remain unexplained. The part of the rotation about an axis is arbitrary if the link \
                 turns about this axis only",
                self.shown(rpy_deg(&self.sensor.mounting)),
                100.0 * left,
                self.kind.motion()
            ),
            &format!(
                "{remedy} {}; its error times the motion of the other joints must be small \
                 against the deflections",
                self.kind.mounting_keys()
            ),
        )
        .seen(self.file, self.column(0), 100.0 * left, "%")
    }

    /// Returns the lines of a mounting.
    fn shown(&self, rpy: [f64; 3]) -> String {
        let [roll, pitch, yaw] = rpy.map(|angle| (10.0 * angle).round() / 10.0);
        let word = self.kind.word();
        let rotation = format!("{word}_rpy_deg = [{roll:.1}, {pitch:.1}, {yaw:.1}]");
        match self.kind.place_key() {
            Some(key) => {
                let [x, y, z] = self.sensor.position;
                format!("{rotation}, {key} = [{x:.3}, {y:.3}, {z:.3}]")
            }
            None => rotation,
        }
    }

    /// Finding: the link position diverges with the corner of the filter.
    fn low_corner(&self) -> Option<Finding> {
        let code = self.kind.corner_code()?;
        let filter = (self.channels.instruments).row_filter(self.sensor.joint)?;
        let least = (self.channels.inertial.as_ref()?).least_corner(self.sensor);
        let [corner, least] = [filter.corner, least].map(|corner| corner / TAU);
        let needed = (10.0 * least).ceil() / 10.0;
        (corner < least).then(|| {
            Finding::new(
                Severity::Error,
                code,
                format!(
                    "{}: gravity acts across the axis of the joint, so the reading of the {} ({}) also changes \
                     with the link position. With a corner of {corner:.2} Hz this position diverges; \
                     {needed:.1} Hz is enough",
                    self.name,
                    self.kind.word(),
                    self.names()
                ),
                &format!("set {} = {needed:.1} in [log]", self.kind.corner_key()),
            )
            .seen(self.file, self.column(0), corner, "Hz")
        })
    }

    fn biased(&self, compared: &Compared) -> Option<Finding> {
        let square: f64 = compared.centred().map(|(y, _)| dot(&y, &y)).sum();
        let rms = (square / compared.readings.len() as f64).sqrt();
        let size = dot(&self.sensor.bias, &self.sensor.bias).sqrt();
        (size > MIN_BIAS_SHARE * rms).then(|| {
            self.finding(
                Severity::Info,
                InertialFinding::Bias,
                &format!(
                    "reads {} {} without motion",
                    rounded(size),
                    self.kind.unit()
                ),
                "nothing: sprung subtracts it, and its slow changes have no effect",
            )
            .seen(self.file, self.column(0), size, self.kind.unit())
        })
    }

    fn saturated(&self) -> Vec<Finding> {
        let channels = self.sensor.channels.iter().flatten();
        let found = channels.filter_map(|&channel| {
            let values: Vec<f64> = self.excerpt.channel(channel).collect();
            let largest = values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let at_limit = |x: &&f64| x.abs().to_bits() == largest.to_bits();
            let count = values.iter().filter(at_limit).count();
            let runs = values.split(|x| x.abs().to_bits() != largest.to_bits());
            let longest = runs.map(<[f64]>::len).max()?;
            let share = count as f64 / values.len().max(1) as f64;
            let column = &self.channels.all[channel].column;
            (longest >= SATURATED_RUN && share > SATURATED_SHARE && largest > 0.0).then(|| {
                let word = self.kind.word();
                Finding::new(
                    Severity::Error,
                    self.kind.code(InertialFinding::Saturated),
                    format!(
                        "{}: \"{column}\" lies at its extreme, {} {}, in {:.2} % of the samples, up to \
                         {longest} in a row: the {word} is saturated",
                        self.name,
                        rounded(largest),
                        self.kind.unit(),
                        100.0 * share
                    ),
                    "choose a larger range of the sensor, or move more slowly",
                )
                .seen(self.file, column, largest, self.kind.unit())
            })
        });
        found.collect()
    }
}

/// Returns a note about the joints with a sensor on the link: how well the beginning of the log determines their
/// stiffnesses, and the undetermined ones.
pub(super) fn about_stiffnesses(reading: &Reading, excerpt: &Excerpt) -> Vec<Finding> {
    let model = reading.model();
    let Some(sensors) = &reading.channels().inertial else {
        return Vec::new();
    };
    let word = sensors.kind.word();
    let joints = sensors.all.iter().map(|sensor| sensor.joint);
    let fitted =
        (excerpt.reduce_thinned(reading)).and_then(|system| fit(model, &system, reading.memory()));
    let (mut known, mut open, mut parameters) = (Vec::new(), Vec::new(), Vec::new());
    let noise = noise_shares(reading, excerpt);
    for joint in joints {
        let Some(index) = model.index(JointParameter::Stiffness, joint) else {
            continue;
        };
        parameters.push(model.parameters()[index].name.clone());
        let name = &model.joints()[joint];
        let share = (fitted.as_ref()).filter(|fitted| fitted.identifiable[index]);
        let share = share.map(|fitted| fitted.standard_error[index] / fitted.theta[index]);
        match share.filter(|share| (0.0..OPEN_STIFFNESS).contains(share)) {
            _ if noise
                .get(joint)
                .is_some_and(|noise| *noise > MAX_NOISE_SHARE) =>
            {
                let percent = Shown((100.0 * noise[joint].sqrt()).round());
                open.push(format!(
                    "{name}, whose deflection contains {percent} % noise of the {word}s"
                ));
            }
            Some(share) => {
                let percent = Shown((1000.0 * share).round() / 10.0);
                known.push(format!("{name} within {percent} %"));
            }
            None => open.push(name.clone()),
        }
    }
    let of_known = if known.is_empty() {
        String::new()
    } else {
        format!(
            ". The beginning of the log determines the stiffness of {} (one standard error)",
            known.join(", ")
        )
    };
    let (severity, of_open) = if open.is_empty() {
        (Severity::Info, String::new())
    } else {
        let text = format!(". It leaves open that of {}", open.join(", "));
        (Severity::Warning, text)
    };
    let text = format!(
        "the link positions follow from {word}s, which show changes of the deflections and no constant \
         ones: preloads of springs stay open, and slow motion shows little{of_known}{of_open}"
    );
    vec![
        Finding::new(
            severity,
            sensors.kind.code(InertialFinding::Link),
            text,
            "nothing if the errors are small enough; otherwise record higher accelerations or a longer log",
        )
        .about(parameters),
    ]
}

/// Returns the variance of the filtered deflection by the noise of the sensors over its whole variance,
/// \[n\]; zero for joints without sensor on the link. A share of it lowers the stiffness by the same share.
fn noise_shares(reading: &Reading, excerpt: &Excerpt) -> Vec<f64> {
    let mut shares = vec![0.0; reading.model().joint_count()];
    let channels = reading.channels();
    let (Some(sensors), Some(signals)) = (&channels.inertial, excerpt.smoothed(reading)) else {
        return shares;
    };
    let levels: Vec<[f64; 3]> = (0..shares.len())
        .map(|joint| {
            let of = sensors
                .of(joint)
                .map(|sensor| sensor.channels)
                .unwrap_or_default();
            of.map(|channel| {
                channel.map_or(0.0, |i| {
                    white_noise(&excerpt.channel(i).collect::<Vec<f64>>())
                })
            })
        })
        .collect();
    for sensor in &sensors.all {
        let joint = sensor.joint;
        let Some(filter) = channels.instruments.row_filter(joint) else {
            continue;
        };
        let (mut squares, mut count) = (0.0, 0.0);
        for segment in signals.segments() {
            for (phi, q) in segment.phi[joint].iter().zip(&segment.q[joint]) {
                squares += (phi - q).powi(2);
                count += 1.0;
            }
        }
        let noise = sensors.position_variance(sensor, &levels, (filter.corner, excerpt.period()));
        shares[joint] = noise / (squares / f64::max(count, 1.0)).max(f64::MIN_POSITIVE);
    }
    shares
}

fn rounded(value: f64) -> Shown {
    Shown((1e4 * value).round() / 1e4)
}

/// Returns roll, pitch and yaw of a rotation, degrees.
fn rpy_deg(r: &[Vector; 3]) -> [f64; 3] {
    let pitch = (-r[2][0]).clamp(-1.0, 1.0).asin();
    [
        r[2][1].atan2(r[2][2]).to_degrees(),
        pitch.to_degrees(),
        r[1][0].atan2(r[0][0]).to_degrees(),
    ]
}
