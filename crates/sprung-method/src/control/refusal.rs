//! Why no controller is designed.

/// Why no controller is designed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ControlRefusal {
    /// The requested bandwidth does not keep the margins.
    #[error(
        "a bandwidth of {} Hz does not keep the margins; the largest in these proportions is {} Hz, above which {because}",
        numbers(.asked_hz), numbers(.largest_hz)
    )]
    TooFast {
        /// Requested bandwidths, Hz, \[n\].
        asked_hz: Vec<f64>,
        /// The largest in the same proportions, Hz, \[n\].
        largest_hz: Vec<f64>,
        /// What breaks.
        because: String,
    },
    /// No bandwidth keeps the margins.
    #[error(
        "no bandwidth keeps the margins: {because}; allow smaller gain_margin_db and phase_margin_deg of [control], give a \
         shorter velocity_window or a shorter period_s, or feedback = \"pd\""
    )]
    NoBandwidth {
        /// What breaks.
        because: String,
    },
    /// The declared controller does not stabilise the robot.
    #[error(
        "the loop with [controller] is unstable in the pose [{}] rad: its motion grows by a factor of 2.7 within {time_s:.2} s; \
         check its gains, or let [control] design them",
        numbers(.pose_rad)
    )]
    Unstable {
        /// The pose, \[n\], rad (m).
        pose_rad: Vec<f64>,
        /// Time, s.
        time_s: f64,
    },
    /// A torque passes its limit.
    #[error(
        "the torque of {joint} reaches its limit of {limit_nm:.4} N·m {motion}, so the design would not hold; ask for a smaller \
         bandwidth_hz in [control], or a slower reference"
    )]
    Saturates {
        /// Name of the joint.
        joint: String,
        /// The limit, N·m (N).
        limit_nm: f64,
        /// The motion.
        motion: String,
    },
    /// A simulated loop runs away.
    #[error(
        "the simulated loop runs away {motion} although it is stable at rest; ask for a smaller bandwidth_hz in [control], or a \
         slower reference"
    )]
    RunsAway {
        /// The motion.
        motion: String,
    },
    /// No shaper exists.
    #[error("no input shaper: {0}; give shaper_modes = 0 in [control] for a design without one")]
    Shaper(#[from] super::shapers::ShaperDesignError),
    /// No robot can have the values.
    #[error(
        "no robot can have these values; identify the robot again, or correct the nominal values"
    )]
    Impossible,
    /// The user stopped the design.
    #[error("stopped on request before the end")]
    Stopped(#[from] sprung_base::progress::Stopped),
}

fn numbers(all: &[f64]) -> String {
    let all: Vec<String> = all.iter().map(|value| format!("{value:.3}")).collect();
    all.join(", ")
}
