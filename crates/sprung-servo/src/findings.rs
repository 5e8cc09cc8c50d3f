//! Findings about a servo.

use super::bench::Bench;
use super::result::{Scale, ServoEstimate, ServoFit};
use crate::finding::{Finding, Severity};

/// Residuals relative to the noise of the sensor: above the first a warning, above the second the result is unusable.
const POOR_FIT: [f64; 2] = [3.0, 10.0];

/// Part of the windows without a fit: above the first a warning, above the second the result is
/// unusable.
const NOT_FOLLOWED: [f64; 2] = [0.1, 0.5];

/// Half width of a 95 % interval, relative to the value, beyond which a parameter counts as open.
const OPEN: f64 = 0.5;

/// Returns the findings about a result.
pub(super) fn findings(
    bench: &Bench,
    parameters: &[ServoEstimate],
    braking: &ServoEstimate,
    fit: &ServoFit,
) -> Vec<Finding> {
    let mut all = Vec::new();
    all.extend(of_scale(bench));
    all.extend(of_fit(fit));
    all.extend(of_back_emf(bench, parameters, braking));
    all.extend(of_open(bench, parameters));
    all
}

/// Returns the finding that only ratios of torques follow from the logs.
pub(super) fn of_scale(bench: &Bench) -> Option<Finding> {
    (bench.scale == Scale::None).then(|| {
        let (command, key) = if bench.is_voltage {
            ("volt", "torque_nm_per_v")
        } else {
            ("ampere", "torque_nm_per_a")
        };
        Finding::new(
            Severity::Info,
            "servo-without-scale",
            format!(
                "no log has a load of known mass and {key} is not given, so only ratios of torques follow \
                 from the logs: inertia and friction are in units of the torque per {command}"
            ),
            &format!(
                "record a log with a known mass on an arm and give it as payload of the file, or give \
                 {key}"
            ),
        )
    })
}

/// Returns how severe a figure is; `None` up to the limit of a warning.
///
/// - limits of a warning, and of a serious finding.
fn severity(figure: f64, [warning, serious]: [f64; 2]) -> Option<Severity> {
    (figure > warning).then_some(if figure > serious {
        Severity::Serious
    } else {
        Severity::Warning
    })
}

fn of_fit(fit: &ServoFit) -> Vec<Finding> {
    let mut all = Vec::new();
    let ratio = fit.position_rms_over_noise;
    if let Some(severity) = severity(ratio, POOR_FIT) {
        all.push(Finding::new(
            severity,
            "servo-poor-fit",
            format!(
                "the simulated positions differ from the logged ones by {ratio:.1} times the noise of the \
                 sensor ({:.2} mrad)",
                1e3 * fit.position_rms_rad
            ),
            "check the gain, the supply voltage, the limits and the period of the position loop, the masses \
             and arms of the payloads, and that target and position of a row are of the same instant",
        ));
    }
    if let Some(severity) = severity(fit.windows_not_followed, NOT_FOLLOWED) {
        all.push(Finding::new(
            severity,
            "servo-windows-not-followed",
            format!(
                "the simulation does not follow {:.0} % of the windows of the logs, so they count little",
                100.0 * fit.windows_not_followed
            ),
            "check gain, supply voltage and limits of the drive law; look for contacts, cables that pull, or a \
             drive that was off while drive_on was 1",
        ));
    }
    all
}

fn half_width(parameter: &ServoEstimate) -> Option<f64> {
    parameter.ci95.map(|[low, high]| 0.5 * (high - low))
}

/// Returns whether a parameter is open: its interval is wide, or it has none.
fn is_open(parameter: &ServoEstimate) -> bool {
    !parameter.fixed && half_width(parameter).is_none_or(|half| half > OPEN * parameter.value.abs())
}

fn of_back_emf(
    bench: &Bench,
    parameters: &[ServoEstimate],
    braking: &ServoEstimate,
) -> Option<Finding> {
    let named = |name: &str| {
        let name = format!("{}.{name}", bench.joint);
        parameters
            .iter()
            .find(move |parameter| parameter.name == name)
    };
    let (viscous, back_emf) = (named("viscous")?, named("back_emf")?);
    if back_emf.fixed || !(is_open(viscous) || is_open(back_emf)) {
        return None;
    }
    let error = half_width(braking).unwrap_or(f64::INFINITY);
    Some(
        Finding::new(
            Severity::Warning,
            "servo-back-emf-open",
            format!(
                "viscous friction and back-EMF brake the servo alike, and the logs hardly tell them apart; \
                 together they brake with {:.3} ± {error:.3} {}",
                braking.value, braking.unit
            ),
            "give back_emf_vs_per_rad of the motor, or add drive_on and let the pendulum fall with the \
             drive off, where only friction brakes it",
        )
        .about([viscous.name.clone(), back_emf.name.clone()]),
    )
}

fn of_open(bench: &Bench, parameters: &[ServoEstimate]) -> Option<Finding> {
    let offset = format!("{}.zero_offset", bench.joint);
    let open: Vec<String> = (parameters.iter())
        .filter(|parameter| is_open(parameter) && parameter.name != offset)
        .map(|parameter| parameter.name.clone())
        .collect();
    if open.is_empty() {
        return None;
    }
    let text = format!(
        "the logs do not determine {}: half of the 95 % interval is more than {:.0} % of the value",
        open.join(", "),
        100.0 * OPEN
    );
    let remedy =
        "add logs with another known mass, with slow and fast targets, and with the drive off";
    Some(Finding::new(Severity::Info, "servo-parameters-open", text, remedy).about(open))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(ratio: f64, lost: f64) -> ServoFit {
        ServoFit {
            position_rms_rad: 1e-3,
            position_rms_over_noise: ratio,
            windows_not_followed: lost,
        }
    }

    #[test]
    fn a_poor_fit_is_told_and_a_good_one_is_not() {
        let codes = |fit: ServoFit| -> Vec<(String, Severity)> {
            of_fit(&fit)
                .into_iter()
                .map(|f| (f.code, f.severity))
                .collect()
        };
        assert!(codes(fit(1.1, 0.02)).is_empty());
        assert_eq!(
            codes(fit(4.0, 0.0)),
            [("servo-poor-fit".to_owned(), Severity::Warning)]
        );
        assert_eq!(
            codes(fit(40.0, 0.0)),
            [("servo-poor-fit".to_owned(), Severity::Serious)]
        );
        let lost = ("servo-windows-not-followed".to_owned(), Severity::Warning);
        assert_eq!(codes(fit(1.0, 0.3)), [lost]);
        let most = ("servo-windows-not-followed".to_owned(), Severity::Serious);
        assert_eq!(codes(fit(1.0, 0.9)), [most]);
    }
}
