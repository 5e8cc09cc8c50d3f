//! Findings about gyroscopes, by the motion of the motors and by the equations.

use sprung_core::parameters::JointParameter;
use sprung_core::spatial::Vector;

use super::excerpt::Excerpt;
use super::gyroscopes::{Best, Compared, compare, dot, mounted};
use super::held_out::held_out;
use super::noise::white_noise;
use super::springs::OPEN_STIFFNESS;
use crate::finding::{Finding, Severity};
use crate::fit::{fit, over_reference};
use crate::log::{Channels, Gyroscope};
use crate::numbers::Shown;
use crate::regression::Reading;

/// Error of the scale from which it is a finding.
const MIN_SCALE_ERROR: f64 = 0.1;

/// Part of the squared angular velocity that must remain unexplained before axes are suspected, and the
/// ratio to what the best rotation leaves.
const MIN_UNEXPLAINED: f64 = 0.05;
const MIN_RATIO: f64 = 4.0;

/// Limits of the scale of a sensor in degrees per second that is declared as radians.
const DEGREES: std::ops::Range<f64> = 40.0..80.0;

/// Part of the samples at one extreme, and their number in a row, from which a sensor is saturated.
const SATURATED_SHARE: f64 = 1e-3;
const SATURATED_RUN: usize = 5;

/// Least bias that is reported, relative to the root mean square of the reading.
const MIN_BIAS_SHARE: f64 = 0.02;

/// Part of the squared angular velocity that may remain unexplained if the links follow their motors.
const CLEAR: f64 = 0.5;

/// Share of noise in the variance of a deflection from which its stiffness counts as open.
const MAX_NOISE_SHARE: f64 = 0.03;

/// Held-out error over that with the present reading, below which another sign or unit is right.
const MUCH_BETTER: f64 = 0.5;

/// Returns findings about the gyroscopes of a robot.
///
/// - `file`: name of the log.
pub(crate) fn gyroscope_findings(reading: &Reading, excerpt: &Excerpt, file: &str) -> Vec<Finding> {
    let (channels, joints) = (reading.channels(), reading.model().joints());
    let sensors = channels.gyroscopes.iter().flat_map(|own| &own.all);
    sensors
        .flat_map(|sensor| {
            let about = About {
                reading,
                excerpt,
                channels,
                sensor,
                file,
                name: &joints[sensor.joint],
            };
            let mut findings = about.saturated();
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
    sensor: &'a Gyroscope,
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

    fn finding(&self, severity: Severity, code: &str, text: &str, remedy: &str) -> Finding {
        let text = format!("{}: the gyroscope ({}) {text}", self.name, self.names());
        Finding::new(severity, code, text, remedy)
    }

    fn judge(&self, compared: &Compared) -> Vec<Finding> {
        let first = self.columns().first().copied().unwrap_or_default();
        let (scale, left) = compared.fit(&self.sensor.mounting);
        let size = scale.abs();
        let is_clear = left < CLEAR;
        if DEGREES.contains(&size) && is_clear {
            let text = format!("reads {size:.1} times the velocity by the motors");
            return vec![self.in_degrees(&text, scale)];
        }
        let best = compared.best_rotation();
        let best_left = best.as_ref().map(|best| compared.fit(&best.rotation).1);
        let is_wrong =
            |best: f64| left > MIN_UNEXPLAINED.max(MIN_RATIO * best) || is_clear && scale < 0.0;
        if self.columns().len() == 1 {
            if scale < 0.0 && is_clear {
                let text = format!("reads {scale:.3} times the velocity by the motors");
                return vec![self.reversed(&text, scale)];
            }
            if let Some(finding) = (!is_clear).then(|| self.by_equations()).flatten() {
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
                    "gyroscope-scale",
                    &format!("reads {scale:.3} times the velocity by the motors"),
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

    fn in_degrees(&self, text: &str, scale: f64) -> Finding {
        let first = self.columns().first().copied().unwrap_or_default();
        self.finding(
            Severity::Error,
            "gyroscope-scale",
            &format!("{text}: degrees per second"),
            "use the keys gyroscope_…_deg_per_s",
        )
        .seen(self.file, first, scale, "")
    }

    fn reversed(&self, text: &str, scale: f64) -> Finding {
        let first = self.columns().first().copied().unwrap_or_default();
        self.finding(Severity::Error, "gyroscope-sign", text, "reverse its sign")
            .seen(self.file, first, scale, "")
            .mended_by("[log]", &format!("sign = {{ \"{first}\" = -1 }}"))
    }

    /// Finding: with the other sign or in degrees the reading explains the torques much better. The links
    /// of soft joints do not follow their motors, so the motion alone does not tell.
    fn by_equations(&self) -> Option<Finding> {
        let channel = self.sensor.channels.into_iter().flatten().next()?;
        let error = |factor: f64| {
            let scaled = self.excerpt.scaled(channel, factor);
            let channels = mounted(self.channels, &scaled);
            held_out(&scaled, &self.reading.with_channels(channels))
        };
        let own = error(1.0)?;
        let factors = [-1.0, 1.0_f64.to_radians()].into_iter();
        let (factor, other) = factors
            .filter_map(|factor| Some((factor, error(factor)?)))
            .filter(|(_, other)| over_reference(*other, own) < MUCH_BETTER)
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        let errors = format!("leaves {:.1} % of the torques unexplained", 100.0 * own);
        let with = format!("{:.1} %", 100.0 * other);
        Some(if factor < 0.0 {
            self.reversed(&format!("{errors}, with the other sign {with}"), -1.0)
        } else {
            self.in_degrees(&format!("{errors}, divided by 57.3 {with}"), 57.3)
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
                reflected < CLEAR && rotated > MIN_UNEXPLAINED.max(MIN_RATIO * reflected)
            })
    }

    /// Finding: the axes of the sensor are exchanged or reversed, or its mounting is another one.
    fn wrong_axes(&self, compared: &Compared, best: Option<&Best>, left: f64) -> Finding {
        let percent = 100.0 * left;
        if self.is_left_handed(compared, best) {
            let text = "is left-handed by the motion of the motors: two axes are exchanged, or one has the \
                        wrong sign";
            let remedy =
                "check the order of gyroscope_x, gyroscope_y and gyroscope_z and their signs";
            let finding = self.finding(Severity::Error, "gyroscope-axes", text, remedy);
            return finding.seen(self.file, self.column(0), percent, "%");
        }
        let rpy = best.map(|best| rpy_deg(&best.rotation)).unwrap_or_default();
        let after = best.map_or(100.0, |best| 100.0 * compared.fit(&best.rotation).1);
        self.finding(
            Severity::Error,
            "gyroscope-axes",
            &format!(
                "contradicts the motion of the motors: its given mounting leaves {percent:.0} % of the \
                 squared velocity unexplained, the mounting {} leaves {after:.1} %",
                shown(rpy)
            ),
            "check gyroscope_rpy_deg, the order of the axes and their signs; without gyroscope_rpy_deg sprung \
             finds the mounting",
        )
        .seen(self.file, self.column(0), percent, "%")
    }

    fn found_mounting(&self, left: f64) -> Finding {
        let severity = if left > MIN_UNEXPLAINED {
            Severity::Warning
        } else {
            Severity::Info
        };
        self.finding(
            severity,
            "gyroscope-mounting",
            &format!(
                "has no given mounting; by the motion of the motors it is {}, and {:.2} % of the squared \
                 velocity remain unexplained. The part of the rotation about an axis is arbitrary if the link \
                 turns about this axis only",
                shown(rpy_deg(&self.sensor.mounting)),
                100.0 * left
            ),
            "give gyroscope_rpy_deg if you know it; its error times the motion of the other joints must be small \
             against the deflections",
        )
        .seen(self.file, self.column(0), 100.0 * left, "%")
    }

    fn biased(&self, compared: &Compared) -> Option<Finding> {
        let square: f64 = compared.centred().map(|(y, _)| dot(&y, &y)).sum();
        let rms = (square / compared.readings.len() as f64).sqrt();
        let size = dot(&self.sensor.bias, &self.sensor.bias).sqrt();
        (size > MIN_BIAS_SHARE * rms).then(|| {
            self.finding(
                Severity::Info,
                "gyroscope-bias",
                &format!("reads {} rad/s without motion", rounded(size)),
                "nothing: sprung subtracts it, and its slow changes have no effect",
            )
            .seen(self.file, self.column(0), size, "rad/s")
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
                Finding::new(
                    Severity::Error,
                    "gyroscope-saturated",
                    format!(
                        "{}: \"{column}\" lies at its extreme, {} rad/s, in {:.2} % of the samples, up to \
                         {longest} in a row: the gyroscope is saturated",
                        self.name,
                        rounded(largest),
                        100.0 * share
                    ),
                    "choose a larger range of the sensor, or move more slowly",
                )
                .seen(self.file, column, largest, "rad/s")
            })
        });
        found.collect()
    }
}

/// Returns a note about the joints with gyroscope: how well the beginning of the log determines their
/// stiffnesses, and what it leaves open.
pub(super) fn about_stiffnesses(reading: &Reading, excerpt: &Excerpt) -> Vec<Finding> {
    let model = reading.model();
    let joints: Vec<usize> = (0..model.joint_count())
        .filter(|&joint| model.has_gyroscope(joint))
        .collect();
    if joints.is_empty() {
        return Vec::new();
    }
    let fitted = (excerpt.smoothed(reading))
        .and_then(|signals| signals.thinned(reading).reduce(reading))
        .and_then(|system| fit(model, &system, reading.memory()));
    let (mut known, mut open, mut parameters) = (Vec::new(), Vec::new(), Vec::new());
    let noise = noise_shares(reading, excerpt);
    for joint in joints {
        let Some(index) = model.index(JointParameter::Stiffness, joint) else {
            continue;
        };
        parameters.push(model.parameters()[index].name.clone());
        let name = &model.joints()[joint];
        let share = (fitted.as_ref()).filter(|own| own.identifiable[index]);
        let share = share.map(|own| own.standard_error[index] / own.theta[index]);
        match share.filter(|share| (0.0..OPEN_STIFFNESS).contains(share)) {
            _ if noise
                .get(joint)
                .is_some_and(|noise| *noise > MAX_NOISE_SHARE) =>
            {
                let percent = Shown((100.0 * noise[joint].sqrt()).round());
                open.push(format!(
                    "{name}, whose deflection contains {percent} % noise of the gyroscopes"
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
        "the link positions follow from gyroscopes, which show changes of the deflections and no constant \
         ones: preloads of springs stay open, and slow motion shows little{of_known}{of_open}"
    );
    vec![
        Finding::new(
            severity,
            "link-by-gyroscope",
            text,
            "nothing if the errors are small enough; otherwise record higher accelerations or a longer log",
        )
        .about(parameters),
    ]
}

/// Returns the variance of the filtered deflection by the noise of the gyroscopes over its whole variance,
/// \[n\]; zero for joints without gyroscope.
///
/// White noise of variance s² and period T becomes `s² T / (4 w)` behind `s/(s + w)²`. A share of it lowers
/// the stiffness by the same share.
fn noise_shares(reading: &Reading, excerpt: &Excerpt) -> Vec<f64> {
    let mut shares = vec![0.0; reading.model().joint_count()];
    let channels = reading.channels();
    let (Some(own), Some(signals)) = (&channels.gyroscopes, excerpt.smoothed(reading)) else {
        return shares;
    };
    let levels: Vec<[f64; 3]> = (0..shares.len())
        .map(|joint| {
            let of = own.of(joint).map(|own| own.channels).unwrap_or_default();
            of.map(|channel| {
                channel.map_or(0.0, |i| {
                    white_noise(&excerpt.channel(i).collect::<Vec<f64>>())
                })
            })
        })
        .collect();
    for sensor in &own.all {
        let variance: f64 = (own.rate(sensor).0.iter())
            .map(|(place, weight)| (weight * levels[place / 3][place % 3]).powi(2))
            .sum();
        let joint = sensor.joint;
        let (mut squares, mut count) = (0.0, 0.0);
        for stretch in signals.stretches() {
            for (phi, q) in stretch.phi[joint].iter().zip(&stretch.q[joint]) {
                squares += (phi - q).powi(2);
                count += 1.0;
            }
        }
        let noise = variance * excerpt.period() / (4.0 * own.corner);
        shares[joint] = noise / (squares / f64::max(count, 1.0)).max(f64::MIN_POSITIVE);
    }
    shares
}

fn rounded(value: f64) -> Shown {
    Shown((1e4 * value).round() / 1e4)
}

fn shown(rpy: [f64; 3]) -> String {
    let [roll, pitch, yaw] = rpy.map(|angle| (10.0 * angle).round() / 10.0);
    format!("gyroscope_rpy_deg = [{roll:.1}, {pitch:.1}, {yaw:.1}]")
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
