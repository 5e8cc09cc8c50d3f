//! Reasons for a verdict in words.

/// Codes of findings that decide on a result, and the reason that each of them gives, as a clause.
const REASONS: &[(&str, &str)] = &[
    ("at-rest", "the joint rests nearly always"),
    ("bias-dominates", "a bias exceeds the sampling error"),
    ("channel-gain", "a column reads too much or too little"),
    ("collinear", "two parameters act alike in this motion"),
    (
        "cutoff-drift",
        "the values depend on the filter: the model lacks an effect, or positions are noisy",
    ),
    ("dropped-samples", "samples are missing"),
    ("eccentric-encoder", "an encoder deviates with the angle"),
    (
        "exchanged-columns",
        "columns of link and motor are exchanged",
    ),
    ("friction-drifts", "the friction changed during the log"),
    ("frozen-samples", "samples repeat although the robot moves"),
    ("gaps", "the log has gaps"),
    (
        "gravity-tilted",
        "gravity has another direction than the file says",
    ),
    ("hardly-moves", "the joint hardly moves"),
    (
        "impossible-nominal-bodies",
        "the nominal bodies cannot exist",
    ),
    (
        "impossible-robot",
        "without constraints the values are those of a robot that cannot exist",
    ),
    ("jitter", "time stamps are uneven"),
    (
        "joint-torque-crosstalk",
        "a torque sensor also reads another joint",
    ),
    ("joint-torque-offset", "a torque sensor has an offset"),
    (
        "joint-torque-scale",
        "torque sensor and motor torque have different scales",
    ),
    (
        "joint-torque-sign",
        "the sign of a torque sensor is reversed",
    ),
    ("known-together", "only a combination is known well"),
    ("late-channel", "a column is late"),
    (
        "law-by-likelihood",
        "friction or spring follow a law that the model lacks",
    ),
    (
        "laws-missing",
        "friction or spring follow a law that the model lacks",
    ),
    (
        "little-torque",
        "the torque behind it is hardly above the residual",
    ),
    (
        "logs-disagree",
        "the logs are of different states of the robot",
    ),
    ("looks-like-degrees", "the positions look like degrees"),
    ("looks-like-radians", "the positions look like radians"),
    (
        "mass-limits-contradicted",
        "the limits of the masses contradict the torques",
    ),
    (
        "motor-side-positions",
        "the positions are those before the gearbox",
    ),
    ("no-possible-bodies", "no possible bodies have these values"),
    ("no-promise", "a part of the log alone contains the motion"),
    ("noisy-signal", "a signal is mostly noise"),
    ("not-identifiable", "the motion excites only combinations"),
    (
        "not-predicted",
        "the promised error exceeds half of a torque or deflection",
    ),
    ("one-frequency", "the joint moves with one frequency only"),
    ("only-friction", "the joint hardly accelerates"),
    (
        "opposite-signs",
        "two encoders of a joint count in opposite directions",
    ),
    ("other-robot", "the description is that of another robot"),
    ("parts-disagree", "parts of the log give different values"),
    ("poor-fit", "the model does not explain the torque"),
    (
        "position-cutoff-high",
        "the position filter passes much noise",
    ),
    ("position-cutoff-low", "the position filter removes motion"),
    ("position-drifts", "the zero of a position moves"),
    ("position-jumps", "a position jumps"),
    ("presliding", "the friction deforms before it slides"),
    (
        "refinement-failed",
        "the refinement failed, so the values are those of least squares",
    ),
    ("refinement-rung", "the model lacks an effect"),
    (
        "reversed-joint",
        "the joint turns in the other direction than in the model",
    ),
    ("reversed-torque", "the sign of a torque is reversed"),
    (
        "routes-disagree",
        "refinement and least squares contradict each other",
    ),
    (
        "sampled-slowly",
        "the log has few samples for each period of the motion",
    ),
    (
        "scale-collapse",
        "the torque of the spring is small beside the residual",
    ),
    ("slope-not-one", "a gear ratio or a unit is wrong"),
    ("spikes", "single samples are wrong"),
    (
        "spring-not-shown",
        "the log does not show the spring of a stiff joint",
    ),
    (
        "stacked-below-motor-rows",
        "noise or a delay of a link position shrinks the values",
    ),
    (
        "standard-error-is-wandering",
        "the intervals are the scatter of a trace",
    ),
    (
        "stiffness-disagrees",
        "two estimates of the stiffness contradict each other",
    ),
    (
        "stiffness-open",
        "the motion hardly depends on the stiffness",
    ),
    (
        "stuck-samples",
        "a column stands still although its joint moves",
    ),
    ("swapped-joints", "columns of two joints are exchanged"),
    ("time-scale", "the clock of the log is wrong"),
    ("torque-ripple", "the motor torque has a ripple"),
    ("torque-saturated", "the torque reached a limit"),
    (
        "torque-saturates",
        "the torque that acts grows less than the logged one",
    ),
    ("torque-scale", "the torque has another scale"),
    (
        "torque-timing-contradicted",
        "the torques act at another time than the file says",
    ),
    (
        "torque-unexplained",
        "the model does not explain the torque",
    ),
    (
        "transmission-error",
        "the gear has an error that repeats with each turn",
    ),
    ("uneven-sampling", "samples were not taken evenly"),
    ("unexcited-joint", "the joint stands still"),
    (
        "unexplained-torque",
        "slow torques remain that the model does not explain",
    ),
    (
        "units-disagree",
        "two encoders of a joint have different units",
    ),
    ("weakly-excited", "the excitation is weak"),
    ("wind-up", "the log does not excite all directions"),
    ("window-beyond-log", "the window lies outside the log"),
    ("zero-off", "the zero of a joint is off by a right angle"),
    ("zeros-apart", "an encoder lost its zero"),
];

/// Returns the reason that a finding gives, as a clause; the code itself for a code without one.
pub(super) fn reason(code: &str) -> &str {
    let at = REASONS.binary_search_by(|(known, _)| (*known).cmp(code));
    at.map_or(code, |at| REASONS[at].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_codes_are_sorted() {
        assert!(REASONS.is_sorted_by(|a, b| a.0 < b.0));
    }
}
