"""Parts of results. `SPRUNG_WRITE_DOCS=1 pytest tests/test_interface.py` writes this file."""

from dataclasses import dataclass

from sprung._named import Named

__all__ = ["AddedLaw", "Applied", "CheckedColumn", "CheckedLog", "Combined", "CombinedParameter", "ComparedResult", "CompetingUnknown", "CutoffChoice", "CutoffPoint", "Delay", "Disturbance", "DriftOfParameter", "DriftOverTime", "EncoderOffset", "ErrorParts", "Evidence", "Finding", "GainUsed", "HeldOutResidual", "JointErrors", "LimitUsed", "LogUsed", "LoopErrors", "LoopMargins", "Mode", "More", "Moves", "Payload", "PayloadParameter", "PreslidingPrior", "Promised", "PromisedErrors", "RefinedDelay", "RefinedSharpness", "RefinedVelocity", "Refinement", "RigidByHoldOut", "RigidJoint", "Rung", "SensedSpring", "SensorNoise", "ServoErrors", "ServoLog", "SettingsUsed", "ShapedMode", "SignUsed", "StandardParameter", "Tracking", "Unknown", "ValidatedSet", "ValidationRun", "Vibration", "WatchEvent", "WatchedJoint", "WatchedLog", "Window", "WithDraws"]

@dataclass(frozen=True)
class AddedLaw:
    """A law of a joint beyond those of its description.

    Attributes:
        of: The key that it concerns: ``link_friction``, ``motor_friction``, ``spring``, or words for an effect
            that no key describes.
        law: The law, by its name in the description; empty without a key.
        play_centre: Deflection in the middle of the play, rad (m).
        play_half_width: Half of the play of a spring, rad (m).
        stribeck_velocity: Velocity at which Stribeck friction has fallen to 1/e, rad/s (m/s).
        stribeck_velocity_error: Standard error of this velocity, rad/s (m/s); absent unless the likelihood gave
            it.
    """

    of: str
    law: str
    play_centre: float | None = ...
    play_half_width: float | None = ...
    stribeck_velocity: float | None = ...
    stribeck_velocity_error: float | None = ...

@dataclass(frozen=True)
class Applied:
    """A change beyond the description, which the log requires.

    Attributes:
        kind: Kind of change: ``samples`` (corrected ones), ``timing`` (of the torques), ``sharpness`` (of Coulomb
            friction) or ``law``.
        what: The change with its size, as a part of a sentence.
        forbidden_by: Setting that forbids the change.
        held_out: Held-out error of the filtered torque without and with the change, relative to the torque;
            absent if it was not compared.
    """

    kind: str
    what: str
    forbidden_by: str
    held_out: tuple[float, float] | None = ...

@dataclass(frozen=True)
class CheckedColumn:
    """Figures of one column.

    Attributes:
        column: Name of the column.
        quantity: Quantity, as a key of ``[log]``.
        joint: Name of the joint.
        unit: Unit of the following values.
        min: Smallest value.
        max: Largest value.
        mean: Mean.
        deviation: Standard deviation about the mean.
        noise: Standard deviation of the noise, from the beginning of the log.
        step: Step between values, if the column is quantised.
        effective_bits: Bits of an ideal converter with the same range and noise.
        longest_still_s: Longest time with a constant value, s.
        matched: Name of the column in the file, if a pattern matched it.
    """

    column: str
    quantity: str
    joint: str
    unit: str
    min: float
    max: float
    mean: float
    deviation: float
    longest_still_s: float
    noise: float | None = ...
    step: float | None = ...
    effective_bits: float | None = ...
    matched: str | None = ...

@dataclass(frozen=True)
class CheckedLog:
    """Figures of one log.

    Attributes:
        file: File as opened.
        samples: Number of samples.
        period_s: Sampling period, s.
        rate_hz: Sampling rate, Hz.
        duration_s: Time between the first and the last sample, s.
        jitter_percent: Largest deviation of a step from the period, percent.
        sampling: Times of the samples: ``even``, ``on-cycle`` or ``as-stamped``.
        interpolated: Number of samples that were interpolated onto even times.
        dropped: Number of missing samples, outside gaps.
        repeated: Number of duplicate samples.
        without_value: Number of samples left out because a column has no value.
        frozen: Number of samples that repeat all values of the previous one although a joint moves.
        gaps: Number of gaps.
        gap_duration_s: Duration of all gaps, s.
        columns: Columns, in the order of the joints: links, motors, torques.
        window: Window of the file; absent for the whole file.
    """

    file: str
    samples: int
    period_s: float
    rate_hz: float
    duration_s: float
    jitter_percent: float
    sampling: str
    interpolated: int
    dropped: int
    repeated: int
    without_value: int
    frozen: int
    gaps: int
    gap_duration_s: float
    columns: list[CheckedColumn]
    window: Window | None = ...

@dataclass(frozen=True)
class Combined:
    """Results of one estimator from different logs of one robot, combined.

    Attributes:
        estimator: Name of the estimator.
        results: Labels of the combined results.
        parameters: Parameters that at least two results determine with an interval.
    """

    estimator: str
    results: list[str]
    parameters: list[CombinedParameter]

@dataclass(frozen=True)
class CombinedParameter:
    """One parameter from several results.

    Attributes:
        name: Name of the parameter.
        unit: Unit.
        results: Number of results with an interval.
        value: Mean, weighted by the information of each result.
        standard_error: Standard error of the mean.
        ci95: 95 % confidence interval.
        error_parts: Contributions to the standard error: the independent errors of the results, the deviation
            between the results beyond their errors, and the bias, which combining does not reduce.
        chi_square: Sum of the squared distances from the mean over the squared standard errors, chi-square if the
            results agree.
        freedom: Its degrees of freedom.
        probability: Probability of at least this sum if the results agree.
        i_squared_percent: Part of the scatter that the standard errors do not explain (I²), percent.
    """

    name: str
    unit: str
    results: int
    value: float
    standard_error: float
    ci95: tuple[float, float]
    error_parts: ErrorParts
    chi_square: float
    freedom: int
    probability: float
    i_squared_percent: float

@dataclass(frozen=True)
class ComparedResult:
    """Origin of the values in one column.

    Attributes:
        label: A short, unique name.
        file: The file that was read.
        robot: Name of the robot.
        log: Names of the logs.
        samples: Number of samples of all logs.
        duration_s: Duration of all logs, s.
        generator: Program and version that made the identification.
        settings: Settings of the identification.
        laws: Laws beyond the description, as ``joint1: motor_friction "stribeck"``.
        estimator: Name of the estimator.
        verdict: Trustworthiness of the result.
        condition_number_scaled: Condition number with columns scaled to unit length; absent if infinite.
        residual_rms: Residual of each row, root mean square, N·m (N).
        relative_residual: Residual over torque in each row with a torque, root mean squares.
        findings: Codes of the result's warnings and serious findings.
        elapsed_s: Duration of the estimation, s.
        date_s: Beginning of the first log, s since 1970; absent if its times are not dates.
    """

    label: str
    file: str
    robot: str
    log: str
    samples: int
    duration_s: float
    generator: str
    settings: SettingsUsed
    estimator: str
    verdict: str
    residual_rms: Named[float]
    relative_residual: Named[float]
    findings: list[str]
    elapsed_s: float
    laws: list[str] = ...
    condition_number_scaled: float | None = ...
    date_s: float | None = ...

@dataclass(frozen=True)
class CompetingUnknown:
    """An unknown that may stand for another one.

    Attributes:
        id: Its name.
        correlation: Correlation of both effects beyond those of parameters and other unknowns.
    """

    id: str
    correlation: float

@dataclass(frozen=True)
class CutoffChoice:
    """A cut-off that was chosen from the data.

    Attributes:
        reason: Reason of the choice.
        sweep: Estimates with other cut-offs, from the beginning of the log.
    """

    reason: str
    sweep: list[CutoffPoint]

@dataclass(frozen=True)
class CutoffPoint:
    """Estimates with one cut-off.

    Attributes:
        cutoff_hz: Cut-off, Hz.
        values: Parameter values in the order of theta.
        held_out_residual: Residual of the filtered torque of each eighth of the samples with the parameters of
            the other eighths, relative to the torque (root mean square over the joints).
    """

    cutoff_hz: float
    values: list[float]
    held_out_residual: float | None = ...

@dataclass(frozen=True)
class Delay:
    """A delay that was compensated.

    Attributes:
        value: Value, s.
        standard_error: Standard error, s, if it was estimated.
    """

    value: float
    standard_error: float | None = ...

@dataclass(frozen=True)
class Disturbance:
    """Noise and disturbance of a row of the regressor.

    Attributes:
        row: Name of the row, for example ``joint1.motor_nm``.
        torque_noise_nm: Standard deviation of the torque's white noise, N·m (N).
        reversal_noise_nm: Standard deviation of further white noise while Coulomb friction reverses, N·m (N).
        disturbance_nm: Standard deviation of the disturbance, N·m (N).
        torque_nm: Standard deviation of the joint's motor torque, N·m (N).
        at_bound: Whether the disturbance ended at its upper bound.
    """

    row: str
    torque_noise_nm: float
    disturbance_nm: float
    torque_nm: float
    at_bound: bool
    reversal_noise_nm: float = ...

@dataclass(frozen=True)
class DriftOfParameter:
    """A line through the estimates of one parameter over time.

    Attributes:
        name: Name of the parameter.
        unit: Unit.
        results: Number of results with an interval.
        span: Times of the first and the last of them, in the unit of the times.
        first: Value of the line at the first of them.
        change: Change of the line from the first to the last of them.
        standard_error: Standard error of the change, by the scatter of the results and their errors without the
            bias that all share.
        change_percent: Change in percent of the value at the first; absent if this value is not significant.
        standard_error_percent: Standard error of the change in percent of the value at the first.
        change_per_day: Change per day; absent without dates.
        between_runs: Standard deviation of the results about the line beyond these errors.
        freedom: Degrees of freedom of Student's t.
        probability: Probability of at least this change if the parameter does not drift.
        adjusted_probability: The same, adjusted for the number of tested parameters.
        drifts: Whether the parameter drifts: the adjusted probability is below 1 %.
    """

    name: str
    unit: str
    results: int
    span: tuple[float, float]
    first: float
    change: float
    standard_error: float
    between_runs: float
    freedom: int
    probability: float
    adjusted_probability: float
    drifts: bool
    change_percent: float | None = ...
    standard_error_percent: float | None = ...
    change_per_day: float | None = ...

@dataclass(frozen=True)
class DriftOverTime:
    """The results of one estimator from different logs of one robot over time.

    Attributes:
        estimator: Name of the estimator.
        results: Labels of the results, from the first to the last.
        times: Time of each result: days since the first log, or the number of the run, from 1.
        time_unit: Unit of the times: ``d``, or ``run`` if the order is that in which the results were given.
        parameters: The tested parameters: those that at least four results determine with an interval.
        from_date_s: Date of the first log, s since 1970; absent if the order is that in which the results were
            given.
        without_date: Label of a result whose logs have no date, the reason for that order.
    """

    estimator: str
    results: list[str]
    times: list[float]
    time_unit: str
    parameters: list[DriftOfParameter]
    from_date_s: float | None = ...
    without_date: str | None = ...

@dataclass(frozen=True)
class EncoderOffset:
    """Offset of a position sensor.

    Attributes:
        joint: Name of the joint.
        column: The column.
        offset_rad: Value, rad (m).
        standard_error_rad: Its standard error, rad (m).
    """

    joint: str
    column: str
    offset_rad: float
    standard_error_rad: float

@dataclass(frozen=True)
class ErrorParts:
    """Contributions to the standard error of a parameter by least squares or by the refinement; the standard error
    is the root of the sum of their squares.

    Attributes:
        sampling: Disagreement of segments of the logs. That of the refinement is at least the standard error by
            the information.
        between_parts: Deviation between parts of the logs beyond their sampling errors.
        bias: Size of the bias that all segments share. Least squares: from cross-checks and from other cut-offs.
            Refinement: the largest change by a missing law, delay or saturation of a torque that the likelihood
            shows; on a lower rung at least the difference from least squares beyond both standard errors.
    """

    sampling: float
    between_parts: float
    bias: float

@dataclass(frozen=True)
class Evidence:
    """Place in a log that shows a finding, and its value.

    Attributes:
        file: Name of the log.
        value: Measured value, in ``unit``.
        unit: Unit of the value; empty for counts and ratios.
        column: Name of the column, if the finding concerns one.
        time_s: Time of the sample, s, if the finding concerns one.
    """

    file: str
    value: float
    unit: str
    column: str | None = ...
    time_s: float | None = ...

@dataclass(frozen=True)
class Finding:
    """A finding.

    Attributes:
        code: Stable name for scripts, for example ``impossible-robot``.
        severity: Severity.
        parameters: Names of the parameters concerned.
        text: Observation with values and units, and its likely cause.
        remedy: Remedy.
        evidence: Evidence in a log.
        setting: Table and line of ``experiment.toml`` that correct the cause.
    """

    code: str
    severity: str
    text: str
    remedy: str
    parameters: tuple[str, ...] = ...
    evidence: Evidence | None = ...
    setting: str | None = ...

@dataclass(frozen=True)
class GainUsed:
    """A gain that was estimated.

    Attributes:
        value: Factor by which the column was multiplied.
        standard_error: Standard error of the value.
    """

    value: float
    standard_error: float

@dataclass(frozen=True)
class HeldOutResidual:
    """Residual of estimates without a block of the logs in the filtered torque of this block, relative to that
    torque: root mean square over the torque rows and over all blocks, which are eighths of the logs (quarters of
    short logs).

    Attributes:
        refined: Residual of the refinement.
        linear: Residual of least squares.
    """

    refined: float
    linear: float

@dataclass(frozen=True)
class JointErrors:
    """Prediction errors of a joint on a log, filtered by the filter pair, and the promised errors; root mean
    squares. If the log has larger torques (deflections) than the logs of the identification, the promised error
    grows in proportion. Promised errors are absent without an identification.

    Attributes:
        joint: Name of the joint.
        torque_nm: Motor torque, N·m (N).
        torque_error_nm: Error of the motor torque, N·m (N).
        deflection_error_rad: Error of the deflection, rad (m).
        deflection_promised_rad: Promised error of the deflection, rad (m).
        deflection_rad: Deflection of the spring, rad (m); absent without a spring of positive stiffness.
        deflection_ratio: Error of the deflection over its promised error.
        torque_promised_nm: Promised error of the motor torque, N·m (N).
        torque_ratio: Error of the motor torque over its promised error.
    """

    joint: str
    torque_nm: float
    torque_error_nm: float
    deflection_error_rad: float | None = ...
    deflection_promised_rad: float | None = ...
    deflection_rad: float | None = ...
    deflection_ratio: float | None = ...
    torque_promised_nm: float | None = ...
    torque_ratio: float | None = ...

@dataclass(frozen=True)
class LimitUsed:
    """How near the motion comes to one limit.

    Attributes:
        joint: Joint; ``None`` for the tool.
        quantity: The limited quantity.
        unit: Unit of the limits.
        lowest: Lowest allowed value; ``None`` without one.
        highest: Highest allowed value; ``None`` without one.
        used_percent: Largest part of the limit that the motion uses, percent.
        time_s: Time of its largest value, s.
        shown: How it was shown: ``between samples`` or ``simulated``.
    """

    quantity: str
    unit: str
    used_percent: float
    time_s: float
    shown: str
    joint: str | None = ...
    lowest: float | None = ...
    highest: float | None = ...

@dataclass(frozen=True)
class LogUsed:
    """Figures of one log: timing, faulty samples, delays, signs and gains.

    Attributes:
        file: File name as the experiment gives it.
        samples: Number of samples.
        period_s: Sampling period, s.
        duration_s: Time between the first and the last sample, s.
        jitter_percent: Largest deviation of a time step from the period, percent.
        jitter_rms_percent: Root mean square of these deviations, percent.
        sampling: Kind of the sampling times: ``even``, ``on-cycle`` or ``as-stamped``.
        recorded: Number of samples in the file, or in its window.
        interpolated: Number of used samples that were interpolated.
        dropped: Number of missing samples. More than three missing samples in a row count as a gap instead.
        repeated: Number of samples left out because they repeat the time of the previous sample.
        without_value: Number of samples left out because a column has no value.
        frozen: Number of samples that repeat all values of the previous sample although a joint moves.
        gaps: Number of gaps. The filters restart after each gap.
        delay_s: Delays that were compensated, by column.
        cycle_s: Cycle at whose multiples the samples were taken, s; ``None`` if there is no cycle.
        date_s: Time of the first sample since 1970, s; ``None`` if the times of the log are not dates.
        digest: Digits that logs with the same samples share; empty in results of earlier versions.
        gain: Gains that were estimated, by column.
        sign: Signs that were estimated, by column.
        torque_constant_side: Side of the gearbox of the torque constants, if the motion determined it.
        torques_delay_s: Common delay of all motor torques that the refinement found, against torques that are
            held until the next sample.
        window: Window of the file; absent for the whole file.
    """

    file: str
    samples: int
    period_s: float
    duration_s: float
    jitter_percent: float
    jitter_rms_percent: float = ...
    sampling: str = ...
    recorded: int = ...
    interpolated: int = ...
    dropped: int = ...
    repeated: int = ...
    without_value: int = ...
    frozen: int = ...
    gaps: int = ...
    delay_s: Named[Delay] = ...
    cycle_s: float | None = ...
    date_s: float | None = ...
    digest: str = ...
    gain: Named[GainUsed] = ...
    sign: Named[SignUsed] = ...
    torque_constant_side: str | None = ...
    torques_delay_s: Delay | None = ...
    window: Window | None = ...

@dataclass(frozen=True)
class LoopErrors:
    """Root mean squares of measured minus simulated signals, by joint.

    Attributes:
        tau_nm: Motor torque, N·m.
        q_rad: Link position, rad.
        phi_rad: Motor position, rad.
    """

    tau_nm: Named[float]
    q_rad: Named[float]
    phi_rad: Named[float]

@dataclass(frozen=True)
class LoopMargins:
    """The margins of the loop of one motor, opened there while the others are closed.

    Attributes:
        joint: Name of the joint.
        gain_margin_db: Least factor by which the gain may change, dB; ``None`` if every gain keeps the loop
            stable.
        phase_margin_deg: Least phase that may change, degrees.
        crossover_hz: Highest frequency at which the open loop of the identified robot has the gain one in the
            first pose, Hz; 0 if it has none.
    """

    joint: str
    phase_margin_deg: WithDraws
    crossover_hz: float
    gain_margin_db: WithDraws | None = ...

@dataclass(frozen=True)
class Mode:
    """Natural frequency and damping ratio with intervals that hold 95 % of the robots.

    Attributes:
        hz: Natural frequency of the identified robot, Hz; over poses the median.
        hz_95: Ends of its interval, Hz.
        damping: Damping ratio of the identified robot; over poses the median.
        damping_95: Ends of its interval.
    """

    hz: float
    hz_95: tuple[float, float]
    damping: float
    damping_95: tuple[float, float]

@dataclass(frozen=True)
class More:
    """Standard errors after more experiments.

    Attributes:
        what: The experiments.
        factor: Standard errors relative to those of the promise, geometric mean.
        undetermined: Number of parameters that stay undetermined.
    """

    what: str
    factor: float
    undetermined: int

@dataclass(frozen=True)
class Moves:
    """Residual vibration of moves: the largest deviation of a link from its rest after the end of the command.

    Attributes:
        duration_s: Length of a move, s.
        way_rad: Way of each joint, rad (m), [n].
        unshaped_rad: Without shaper, rad (m): the largest over the links.
        shaped_rad: With the shaper, or the same without one.
        largest_percent: The largest shaped residual in percent of the unshaped one of the same robot and pose;
            ``None`` if moves without shaper leave less than 1 % of the way.
        limit_cycles: Number of robots that still move long after the end: a limit cycle.
    """

    duration_s: float
    way_rad: list[float]
    unshaped_rad: WithDraws
    shaped_rad: WithDraws
    limit_cycles: int
    largest_percent: float | None = ...

@dataclass(frozen=True)
class Payload:
    """Inertial parameters of a payload.

    Attributes:
        name: Name of the payload.
        link: The link that carried it.
        estimator: Estimator of the parameters of the robot.
        logs: Logs with the payload.
        parameters: Mass, first moments and inertia about the origin of the link's joint, in the axes of this
            joint.
        centre_of_mass_m: Centre of mass in the frame of the link's joint with its standard error, m; absent where
            the logs do not determine it.
        residual_rms: Residual of each row of the loaded logs, N·m.
    """

    name: str
    link: str
    estimator: str
    logs: list[str]
    parameters: list[PayloadParameter]
    centre_of_mass_m: list[tuple[float, float] | None]
    residual_rms: Named[float]

@dataclass(frozen=True)
class PayloadParameter:
    """One inertial parameter of a payload.

    Attributes:
        name: Name, as in ``gripper.izz``.
        unit: Unit.
        value: Estimate; absent if the logs do not determine it.
        standard_error: Standard error by the loaded logs and by the errors of the robot's parameters.
        ci95: 95 % confidence interval.
        physical: Value of the nearest body that can exist; absent if none was found.
    """

    name: str
    unit: str
    value: float | None = ...
    standard_error: float | None = ...
    ci95: tuple[float, float] | None = ...
    physical: float | None = ...

@dataclass(frozen=True)
class PreslidingPrior:
    """Prior of presliding friction on one side of a joint, or of the hysteresis of its spring.

    Attributes:
        joint: Name of the joint.
        side: ``link``, ``motor`` or ``spring``.
        level_nm: Standard deviation of the coefficients, N·m (N).
    """

    joint: str
    side: str
    level_nm: float

@dataclass(frozen=True)
class Promised:
    """The standard error of one parameter for the motion.

    Attributes:
        name: Name of the parameter.
        unit: SI unit.
        value: Value for which the experiment was designed.
        standard_error: Standard error, the bound of Cramér and Rao.
        relative_percent: Relative standard error, percent; ``None`` for a value of zero.
        determined: Whether the standard error is smaller than the value.
        cure: The change that determines the parameter, if this motion does not.
    """

    name: str
    unit: str
    value: float
    standard_error: float
    determined: bool
    relative_percent: float | None = ...
    cure: str | None = ...

@dataclass(frozen=True)
class PromisedErrors:
    """Prediction errors of a joint along a measured motion, filtered by the filter pair, root mean squares.

    Attributes:
        joint: Name of the joint.
        torque_nm: Motor torque, N·m (N).
        torque_error_nm: Error of the motor torque, N·m (N).
        deflection_error_rad: Error of the deflection that moves the link, rad (m): residual of the link's
            equation over the stiffness.
        deflection_rad: Deflection of the spring, rad (m); absent without a spring of positive stiffness.
    """

    joint: str
    torque_nm: float
    torque_error_nm: float
    deflection_error_rad: float | None = ...
    deflection_rad: float | None = ...

@dataclass(frozen=True)
class RefinedDelay:
    """Delay of a column relative to the other columns, by likelihood.

    Attributes:
        column: The column.
        delay_s: Time from the event to its record, s.
        standard_error_s: Its standard error, s; absent if the log does not determine the delay.
        used_s: Delay that the parameter values assume, s.
    """

    column: str
    delay_s: float
    used_s: float
    standard_error_s: float | None = ...

@dataclass(frozen=True)
class RefinedSharpness:
    """Sharpness of the Coulomb friction of a joint, by likelihood.

    Attributes:
        joint: Name of the joint.
        sharpness: Beta of ``tanh(beta * velocity)``, s/rad (s/m).
        standard_error: Its standard error, s/rad (s/m).
    """

    joint: str
    sharpness: float
    standard_error: float

@dataclass(frozen=True)
class RefinedVelocity:
    """Stribeck velocity of a joint, by likelihood.

    Attributes:
        joint: Name of the joint.
        velocity: Velocity at which the friction has fallen to 1/e, rad/s (m/s).
        standard_error: Its standard error, rad/s (m/s).
    """

    joint: str
    velocity: float
    standard_error: float

@dataclass(frozen=True)
class Refinement:
    """Figures of a prediction-error refinement besides the parameters.

    Attributes:
        used: Whether the values are those of the refinement. If not, they are those of least squares, and a
            finding gives the reason.
        rung: Rung of the ladder that these figures belong to: ``free``, ``cap10``, ``cap3`` or ``flat``. It is
            the one that is used, or else the one that predicts held-out blocks best.
        converged: Whether the search converged.
        runs: Number of runs of the filter.
        samples: Number of samples used.
        duration_s: Time spanned by the samples, s.
        measurements: Number of position measurements used. An incremental encoder gives one at each edge.
        minus_log_likelihood: Minus the logarithm of the likelihood, without its constant.
        disturbances: Noise and disturbance of each row of the regressor.
        disturbance_corner_hz: Corner frequency of the disturbances' spectrum, Hz.
        cost_per_measurement: Mean squared whitened innovation. It is well below 1 for encoders, whose edges lie
            within their bounds, and above 2 if the model does not follow the log.
        held_out_residual: Residual on held-out blocks of the logs.
        encoder_offsets: Constant offsets of sensors.
        delays: Delays estimated by likelihood.
        correlations: Pairs of parameters with the most strongly correlated errors, and their correlation.
        each_log: Estimate from each of several logs alone: value and standard error, in the order of
            ``parameters``; ``None`` for a parameter that was not refined.
        presliding_levels: Prior levels of presliding friction.
        rungs: The rungs that were tried, in their order.
        sensor_noise: Noise of sensors beyond the noise that their samples show, where it was estimated.
        sharpnesses: Sharpness of the Coulomb friction of joints whose description gives none, estimated with the
            parameters.
        stribeck_velocities: Stribeck velocities that the description leaves open, estimated with the parameters.
        torques_delay_s: Common delay of all motor torques, s, and its standard error, if it is an unknown of the
            refinement.
        values: Refined value and standard error of each parameter, in the order of ``parameters``, whether they
            are used or not; ``None`` for a parameter that was not refined.
    """

    converged: bool
    runs: int
    samples: int
    duration_s: float
    measurements: int
    minus_log_likelihood: float
    disturbances: list[Disturbance]
    disturbance_corner_hz: float
    encoder_offsets: list[EncoderOffset]
    delays: list[RefinedDelay]
    correlations: list[tuple[str, str, float]]
    used: bool = ...
    rung: str = ...
    cost_per_measurement: float = ...
    held_out_residual: HeldOutResidual | None = ...
    each_log: list[list[tuple[float, float] | None]] = ...
    presliding_levels: list[PreslidingPrior] = ...
    rungs: list[Rung] = ...
    sensor_noise: list[SensorNoise] = ...
    sharpnesses: list[RefinedSharpness] = ...
    stribeck_velocities: list[RefinedVelocity] = ...
    torques_delay_s: tuple[float, float] | None = ...
    values: list[tuple[float, float] | None] = ...

@dataclass(frozen=True)
class RigidByHoldOut:
    """Residuals of the filtered torque of a joint in eighths of the beginning of the first log, each predicted by a
    fit of the other eighths, relative to the torque.

    Attributes:
        flexible: With a spring; absent if an eighth does not determine the parameters.
        rigid: As a rigid joint.
    """

    flexible: float | None = ...
    rigid: float | None = ...

@dataclass(frozen=True)
class RigidJoint:
    """A joint whose spring the logs do not determine; it is taken as rigid.

    Attributes:
        joint: Name of the joint.
        stiffness_above_nm_per_rad: Lower bound of the stiffness at 95 %, N·m/rad (N/m).
        compliance_rad_per_nm: Estimate of the compliance, rad/(N·m) (m/N); noise may make it negative.
        compliance_standard_error_rad_per_nm: Its standard error, rad/(N·m) (m/N).
        hold_out: Cross-validation by which one equation of a rigid joint replaced those of link and motor; absent
            if a torque sensor separates link and motor.
    """

    joint: str
    stiffness_above_nm_per_rad: float
    compliance_rad_per_nm: float
    compliance_standard_error_rad_per_nm: float
    hold_out: RigidByHoldOut | None = ...

@dataclass(frozen=True)
class Rung:
    """A rung of the ladder: a refinement that allows slow disturbances up to some level.

    Attributes:
        name: Name: ``free``, ``cap10``, ``cap3`` or ``flat``.
        used: Whether its values are used.
        outcome: Reason why it is used or not.
        held_out_residual: Residual on blocks that the estimates had not used; absent if the search failed.
    """

    name: str
    used: bool
    outcome: str
    held_out_residual: HeldOutResidual | None = ...

@dataclass(frozen=True)
class SensedSpring:
    """The spring of a joint by its deflection and its torque sensor, of a robot without motor torques.

    Attributes:
        joint: Name of the joint.
        stiffness_nm_per_rad: Stiffness, N·m/rad (N/m).
        standard_error_nm_per_rad: Its standard error, N·m/rad (N/m).
        ci95_nm_per_rad: 95 % confidence interval, N·m/rad (N/m).
    """

    joint: str
    stiffness_nm_per_rad: float
    standard_error_nm_per_rad: float
    ci95_nm_per_rad: tuple[float, float]

@dataclass(frozen=True)
class SensorNoise:
    """Noise of a position sensor.

    Attributes:
        column: The column.
        noise_rad: Standard deviation of white noise, rad (m).
        deviation_rad: Standard deviation of the sensor's readings, rad (m).
    """

    column: str
    noise_rad: float
    deviation_rad: float

@dataclass(frozen=True)
class ServoErrors:
    """Distance of the simulated from the logged positions.

    Attributes:
        position_rms_rad: Root mean square over the windows that the model follows, rad.
        position_rms_over_noise: The same relative to the noise of the sensor.
        windows_not_followed: Part of the windows that the model does not follow.
    """

    position_rms_rad: float
    position_rms_over_noise: float
    windows_not_followed: float

@dataclass(frozen=True)
class ServoLog:
    """A log of a servo.

    Attributes:
        log: Name, with its window.
        samples: Number of samples that were used.
        duration_s: Duration of these samples, s.
        load_inertia_kgm2: Inertia of the known load about the axis, kg·m².
        load_torque_nm: Largest torque of gravity on the known load, N·m.
    """

    log: str
    samples: int
    duration_s: float
    load_inertia_kgm2: float
    load_torque_nm: float

@dataclass(frozen=True)
class SettingsUsed:
    """Settings of an identification.

    Attributes:
        filter_cutoff_rad_per_s: λ of the filter pair, rad/s.
        discretization: Discretisation of the filter pair.
        weights: Kind of sample weights.
        constraints: Robots among which least squares and the refinement searched: ``possible`` or ``none``.
            Results of format 1 do not contain it; theirs are ``none``.
        position_cutoff_hz: Cut-off of the zero-phase filter, Hz.
        position_cutoff_choice: Reason and sweep of the cut-off, if it was chosen from the data.
        position_filter_order: Order of the zero-phase filter.
    """

    filter_cutoff_rad_per_s: float
    discretization: str
    position_cutoff_hz: float
    position_filter_order: int
    weights: str = ...
    constraints: str = ...
    position_cutoff_choice: CutoffChoice | None = ...

@dataclass(frozen=True)
class ShapedMode:
    """The part of a shaper for one mode.

    Attributes:
        impulses: Number of impulses of the sequence, one more than the frequencies without residual vibration;
            absent in designs of earlier versions.
        centre_hz: Natural frequency for which the sequence is designed, Hz.
        damping: Damping ratio for which it is designed.
        largest_percent: Largest residual vibration of the mode under the whole sampled sequence, percent.
        median_percent: Median over its region, percent.
        hump_percent: Residual vibration at the maxima between these frequencies, percent; absent for two
            impulses.
    """

    centre_hz: float
    damping: float
    largest_percent: float
    median_percent: float
    impulses: int = ...
    hump_percent: float | None = ...

@dataclass(frozen=True)
class SignUsed:
    """A sign that was estimated.

    Attributes:
        value: 1 or -1.
        log_likelihood: Logarithm of the likelihood with this sign minus that with the opposite sign.
    """

    value: float
    log_likelihood: float

@dataclass(frozen=True)
class StandardParameter:
    """One inertial parameter of a single link, or the inertia of a rotor.

    Attributes:
        name: Name, as in ``link1.izz``.
        unit: Unit.
        value: Value, of a body that can exist.
        standard_error: Standard error by the log and by the error of the nominal values; absent for a given
            value.
        nominal: Nominal value.
        decided: What decided the value.
        share_of_log: Part of the prior's variance that the log removed, 0 to 1.
    """

    name: str
    unit: str
    value: float
    decided: str
    standard_error: float | None = ...
    nominal: float | None = ...
    share_of_log: float = ...

@dataclass(frozen=True)
class Tracking:
    """Tracking error of a link, root mean square, rad (m).

    Attributes:
        joint: Name of the joint.
        declared_rad: With ``[controller]``, on the identified robot; ``None`` without one, or if its loop runs
            away.
        designed_rad: With the designed controller.
    """

    joint: str
    designed_rad: WithDraws
    declared_rad: float | None = ...

@dataclass(frozen=True)
class Unknown:
    """An unknown of a log: what differs from the description by a size that the log shows.

    Attributes:
        id: Stable name, as in ``delay q1_rad``.
        kind: Kind: ``delay``, ``timing``, ``offset``, ``gain``, ``drift``, ``lost-counts``, ``eccentricity``,
            ``saturation``, ``sharpness``, ``time-scale``, ``torque-ripple``, ``transmission-error``, ``warm-up``
            or ``law``.
        place: Column, or joint of a law or a sharpness; the columns of one signal of all joints are separated by
            commas.
        value: Size, in ``unit``: the time by which a delayed column is late; otherwise what a correction adds to
            the column, for a gain relative to it.
        standard_error: Standard error, in ``unit``.
        unit: Unit; empty for ratios.
        status: What sprung did with it.
        effect: Fall of the squared error of the torques on held-out parts of the log, relative to it; of an
            unknown that only the refinement shows, of its squared innovations.
        begins_s: Time at which it begins, s; absent if it acts during the whole log.
        competing: Other unknowns that explain the log nearly as well.
        law: Law that it adds to the joint of its place; absent for other kinds.
    """

    id: str
    kind: str
    place: str
    value: float
    standard_error: float
    unit: str
    status: str
    effect: float
    begins_s: float | None = ...
    competing: list[CompetingUnknown] = ...
    law: AddedLaw | None = ...

@dataclass(frozen=True)
class ValidatedSet:
    """One parameter set on one experiment.

    Attributes:
        parameters: Origin of the parameters.
        modified: Changes of the parameters that make the loop stable, if there are any.
        outcome: Outcome of simulating the closed loop.
        e_rms: Errors of the simulated closed loop; absent unless it was simulated.
        torque_residual_nm: Residual of the filtered motor torque along the measured motion, root mean square, N·m
            (N), by joint.
        torque_relative_residual: Residual over torque, root mean squares, by joint.
        findings: Findings about this parameter set.
        predictions: Prediction errors of each joint and the promised ones; empty if a value of the set is
            missing.
        promise_kept: Whether no error exceeds 1.5 times the promised one; absent without a promise.
    """

    parameters: str
    outcome: str
    torque_residual_nm: Named[float]
    torque_relative_residual: Named[float]
    findings: list[Finding]
    modified: str | None = ...
    e_rms: LoopErrors | None = ...
    predictions: list[JointErrors] = ...
    promise_kept: bool | None = ...

@dataclass(frozen=True)
class ValidationRun:
    """One experiment and all parameter sets on it.

    Attributes:
        name: Name of the experiment.
        log: Log file.
        same_log: Whether the parameters come from this log, which is then no proof.
        samples: Number of samples.
        position_cutoff_hz: Cut-off of the position filter for the filtered torque, Hz: that of the identification
            if ``position_cutoff_hz`` is ``"auto"``.
        simulated: Whether the closed loop was simulated, which needs a controller.
        findings: Findings about the log.
        sets: One entry per parameter set.
    """

    name: str
    log: str
    samples: int
    simulated: bool
    sets: list[ValidatedSet]
    same_log: bool = ...
    position_cutoff_hz: float | None = ...
    findings: list[Finding] = ...

@dataclass(frozen=True)
class Vibration:
    """A vibration over all poses and robots.

    Attributes:
        motors: The motors.
        name: Joint whose spring has the largest part of its energy; of a closed loop its place from the lowest
            frequency.
        hz: Natural frequency of the identified robot, Hz; over poses the median.
        hz_95: Ends of its interval, Hz.
        damping: Damping ratio of the identified robot; over poses the median.
        damping_95: Ends of its interval.
        poses: At each pose; ``None`` where the identified robot does not vibrate so. [poses]
    """

    motors: str
    name: str
    hz: float
    hz_95: tuple[float, float]
    damping: float
    damping_95: tuple[float, float]
    poses: list[Mode | None]

@dataclass(frozen=True)
class WatchEvent:
    """Something that happened on a running robot.

    Attributes:
        log: Name of the log.
        begins_s: First time at which it was seen, s, on the time axis of the log.
        ends_s: Last time at which it was seen, s.
        finding: What happened.
        joint: Name of the joint; absent if it is of several joints.
        threshold_nm: Threshold at that time, N·m (N); absent for what is no contact.
        torque_nm: Largest torque from outside with its sign, N·m (N); absent for what is no contact.
    """

    log: str
    begins_s: float
    ends_s: float
    finding: Finding
    joint: str | None = ...
    threshold_nm: float | None = ...
    torque_nm: float | None = ...

@dataclass(frozen=True)
class WatchedJoint:
    """The thresholds of a joint.

    Attributes:
        joint: Name of the joint.
        motor_share: Share of the residual of the motor's equation in the torque from outside: 0 for link encoders
            alone, 1 for the sum of both equations, which does not need the spring.
        variance: Coefficients of the variance of the torque from outside, (N·m)²: of one, and of the squares of
            velocity (rad/s), torque (N·m), acceleration (rad/s²) and nearness of a reversal (0 to 1).
        zero_nm: Deviation of the torque from outside by another zero of an encoder, until the joint has moved in
            both directions and the zero is known, N·m (N).
        threshold_sigma: Threshold in standard deviations; absent if the healthy logs are too short to know it.
        typical_threshold_nm: Threshold in the typical state of the healthy logs, N·m (N); absent if it is not
            known.
    """

    joint: str
    motor_share: float
    variance: list[float]
    zero_nm: float = ...
    threshold_sigma: float | None = ...
    typical_threshold_nm: float | None = ...

@dataclass(frozen=True)
class WatchedLog:
    """A log that was watched.

    Attributes:
        log: Name of the log.
        duration_s: Duration, s.
        blind_s: Time without thresholds, because the filters settled or a channel showed nothing, s.
    """

    log: str
    duration_s: float
    blind_s: float

@dataclass(frozen=True)
class Window:
    """A window of a log; an absent bound is that of the log. A sample at time t with index i belongs to it if
    ``from_s`` ≤ t < ``to_s`` and ``from_index`` ≤ i < ``to_index``.

    Attributes:
        from_index: Index of its first sample, from 0.
        from_s: Time of its beginning, s, on the axis of the log's own time.
        to_index: Index of the first sample after it, from 0.
        to_s: Time of its end, s; a sample at this time lies outside.
    """

    from_index: int | None = ...
    from_s: float | None = ...
    to_index: int | None = ...
    to_s: float | None = ...

@dataclass(frozen=True)
class WithDraws:
    """A figure for the identified robot and the worst over all robots of the posterior, both at their worst pose.

    Attributes:
        identified: Of the identified robot.
        worst: The worst of the robots.
    """

    identified: float
    worst: float
