//! Curves of a designed controller for its report.

/// A curve of the identified robot, and the band of the simulated robots.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Banded {
    /// Of the identified robot.
    pub identified: Vec<f64>,
    /// The lowest over all robots.
    pub low: Vec<f64>,
    /// The highest over all robots.
    pub high: Vec<f64>,
}

impl Banded {
    /// Returns the band of curves of equal length; the first is that of the identified robot.
    #[must_use]
    pub(super) fn of(curves: &[&[f64]]) -> Self {
        let identified = curves.first().map_or_else(Vec::new, |curve| curve.to_vec());
        let at = |k: usize, start: f64, pick: fn(f64, f64) -> f64| {
            curves.iter().map(|curve| curve[k]).fold(start, pick)
        };
        let all = 0..identified.len();
        Self {
            low: all
                .clone()
                .map(|k| at(k, f64::INFINITY, f64::min))
                .collect(),
            high: all.map(|k| at(k, f64::NEG_INFINITY, f64::max)).collect(),
            identified,
        }
    }
}

/// The open loop of one motor with the others closed, in the middle of the workspace.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopCurve {
    /// Name of the joint.
    pub joint: String,
    /// Frequencies, Hz.
    pub hz: Vec<f64>,
    /// Gain, dB.
    pub gain_db: Banded,
    /// Phase, degrees.
    pub phase_deg: Banded,
}

/// A motion of one link in a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkCurves {
    /// Name of the joint.
    pub joint: String,
    /// One curve for each of the labels, rad (m).
    pub curves: Vec<(String, Banded)>,
}

/// Curves over a common time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timed {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Curves of each joint.
    pub joints: Vec<LinkCurves>,
}

/// A vibration of the loop in one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleInPose {
    /// Natural frequency, Hz.
    pub hz: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Whether it is one of the identified robot, not of a robot from the posterior.
    pub is_identified: bool,
}

/// Curves of a designed controller.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControlPictures {
    /// Bode plots.
    pub loops: Vec<LoopCurve>,
    /// Vibrations of the loop over poses.
    pub poles: Vec<PoleInPose>,
    /// A step of all joints: deviation from the end.
    pub step: Timed,
    /// A move from rest to rest: deviation from the desired motion's end.
    pub moves: Timed,
    /// Errors of the links on the reference.
    pub tracking: Timed,
}
