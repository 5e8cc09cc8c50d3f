"""Results of an identification beside its parameters."""

from __future__ import annotations

from dataclasses import dataclass, field

from sprung._named import Named


@dataclass(frozen=True)
class Delay:
    """A delay that was compensated.

    Attributes:
        value: delay, s.
        standard_error: its standard error, s; ``None`` if the experiment gives the delay.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> experiment.identify(experiment.simulate()).logs[0].delay_s
        {}
    """

    value: float
    standard_error: float | None = None


@dataclass(frozen=True)
class LogUsed:
    """Figures of one log.

    Attributes:
        file: path or digest of the log.
        samples: number of samples.
        period_s: sampling period, s.
        duration_s: time between the first and the last sample, s.
        date_s: time of the first sample since 1970, s; ``None`` if the times are no dates.
        sampling: ``even``, ``on-cycle`` or ``as-stamped``.
        jitter_percent: largest deviation of a time step from the period, %.
        interpolated: number of used samples that were interpolated.
        dropped: number of missing samples.
        repeated: number of samples left out because they repeat a time.
        without_value: number of samples left out because a column has no value.
        frozen: number of samples that repeat all values although a joint moves.
        gaps: number of gaps.
        delay_s: delays that were compensated, by column.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> log = experiment.identify(experiment.simulate()).logs[0]
        >>> log.samples, log.period_s, log.sampling, log.gaps
        (10000, 0.001, 'even', 0)
    """

    file: str
    samples: int
    period_s: float
    duration_s: float
    date_s: float | None = None
    sampling: str = ""
    jitter_percent: float = 0.0
    interpolated: int = 0
    dropped: int = 0
    repeated: int = 0
    without_value: int = 0
    frozen: int = 0
    gaps: int = 0
    delay_s: Named[Delay] = field(default_factory=lambda: Named({}))


@dataclass(frozen=True)
class Applied:
    """A change beyond the experiment that the log asked for.

    Attributes:
        kind: ``samples`` that were mended, ``timing`` of the torques, ``sharpness`` of Coulomb friction, or
            ``law``.
        what: the change with its size.
        held_out: held-out error of the torque without and with the change, relative to the torque;
            ``None`` if it was not compared.
        forbidden_by: setting that forbids the change.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> experiment.identify(experiment.simulate()).applied      # the demo's model is complete
        []
    """

    kind: str
    what: str
    forbidden_by: str
    held_out: tuple[float, float] | None = None

    def __str__(self) -> str:
        gain = ""
        if self.held_out is not None:
            without, beside = (100.0 * error for error in self.held_out)
            gain = f"; held-out error {without:.2f} → {beside:.2f} %"
        return f"{self.what}{gain} (forbidden by {self.forbidden_by})"


@dataclass(frozen=True)
class AddedLaw:
    """A law of friction or springs beyond those of the experiment file.

    Attributes:
        of: key of the joint, such as ``motor_friction``, or words for an effect that no key describes.
        law: its name in the file; empty without a key.
        stribeck_velocity: velocity at which Stribeck friction has fallen to 1/e, rad/s (m/s); ``None`` for other laws.
        stribeck_velocity_error: its standard error; ``None`` unless the likelihood gave it.
        play_half_width: half of the play of a spring, rad (m); ``None`` for other laws.
        play_centre: deflection in the middle of the play, rad (m); ``None`` for other laws.

    Example:
        >>> import sprung
        >>> sprung.AddedLaw("motor_friction", "quadratic").law
        'quadratic'
    """

    of: str
    law: str
    stribeck_velocity: float | None = None
    stribeck_velocity_error: float | None = None
    play_half_width: float | None = None
    play_centre: float | None = None


@dataclass(frozen=True)
class CompetingUnknown:
    """Another unknown that explains a log nearly as well.

    Attributes:
        id: its name, as in ``gain q1_rad``.
        correlation: correlation of both effects beyond those of parameters and other unknowns.

    Example:
        >>> import sprung
        >>> sprung.CompetingUnknown("gain q1_rad", -0.91).id
        'gain q1_rad'
    """

    id: str
    correlation: float


@dataclass(frozen=True)
class Unknown:
    """What differs from the description of a log by a size that the log shows.

    Attributes:
        id: stable name, as in ``delay q1_rad``.
        kind: ``delay``, ``timing``, ``offset``, ``gain``, ``drift``, ``lost-counts``, ``eccentricity``,
            ``saturation``, ``sharpness`` or ``law``.
        place: column, or joint of a law or a sharpness; the columns of one signal of all joints are separated by commas.
        value: size, in ``unit``: the time by which a delayed column is late; otherwise what a correction adds to the
            column, for a gain relative to it.
        standard_error: its standard error, in ``unit``.
        unit: ``s``, ``rad``, ``m``, empty for ratios, or that of the coefficient of a law.
        status: ``given`` or ``estimated`` as the experiment says, ``applied`` to all results, or only ``found``.
        effect: fall of the squared error of the torques on held-out parts of the log, relative to it.
        begins_s: time at which it begins, s; ``None`` if it acts during the whole log.
        competing: other unknowns that explain the log nearly as well.
        law: the law that it adds to the joint; ``None`` for other kinds.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo()
        >>> experiment.check(experiment.simulate()).unknowns        # the twin's log is complete
        []
        >>> print(sprung.Unknown("delay q1_rad", "delay", "q1_rad", 0.005, 1e-5, "s", "applied", 0.42))
        delay q1_rad: 0.005 ± 1e-05 s (applied), error falls by 42 %
    """

    id: str
    kind: str
    place: str
    value: float
    standard_error: float
    unit: str
    status: str
    effect: float
    begins_s: float | None = None
    competing: list[CompetingUnknown] = field(default_factory=list)
    law: AddedLaw | None = None

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        size = f"{self.value:.4g} ± {self.standard_error:.2g}{unit}"
        return f"{self.id}: {size} ({self.status}), error falls by {100.0 * self.effect:.0f} %"


@dataclass(frozen=True)
class PromisedErrors:
    """Errors that a result promises for a new experiment of the same kind, root mean squares.

    Attributes:
        joint: name of the joint.
        torque_nm: motor torque in the logs, N·m (N).
        torque_error_nm: promised error of the motor torque, N·m (N).
        deflection_rad: deflection of the spring in the logs, rad (m); ``None`` without a spring.
        deflection_error_rad: promised error of the deflection, rad (m).

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> promise = experiment.identify(experiment.simulate()).promise
        >>> [f"{100 * joint.torque_error_nm / joint.torque_nm:.0f} %" for joint in promise]
        ['7 %', '13 %']
    """

    joint: str
    torque_nm: float
    torque_error_nm: float
    deflection_rad: float | None = None
    deflection_error_rad: float | None = None


@dataclass(frozen=True)
class PayloadParameter:
    """An inertial parameter of a payload, about the origin of the link's joint, in its axes.

    Attributes:
        name: for example ``gripper.izz``.
        unit: unit of the numbers.
        value: estimate; ``None`` if the logs do not determine it.
        standard_error: its standard error.
        ci95: 95 % confidence interval.
        physical: value of the nearest body that can exist; ``None`` if none was found.
    """

    name: str
    unit: str
    value: float | None = None
    standard_error: float | None = None
    ci95: tuple[float, float] | None = None
    physical: float | None = None


@dataclass(frozen=True)
class Payload:
    """A payload that the logs determine.

    Attributes:
        name: name of the payload.
        link: link that carried it.
        estimator: estimator of the robot's own parameters.
        logs: logs with the payload.
        parameters: mass, first moments and inertia.
        centre_of_mass_m: centre of mass in the frame of the link's joint and its standard error, m, one entry
            per axis; ``None`` where the logs do not determine it.
        residual_rms: residual of each row of these logs, N·m (N).

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> for payload in experiment.identify(experiment.simulate()).payloads:     # the demo has none
        ...     print(payload.name, payload.parameters[0].value)
    """

    name: str
    link: str
    estimator: str
    logs: list[str]
    parameters: list[PayloadParameter]
    centre_of_mass_m: list[tuple[float, float] | None]
    residual_rms: Named[float]


@dataclass(frozen=True)
class RigidJoint:
    """A joint whose spring the logs do not determine.

    Attributes:
        joint: name of the joint.
        stiffness_above_nm_per_rad: lower bound of the stiffness at 95 %, N·m/rad (N/m).
        compliance_rad_per_nm: estimate of the compliance, rad/(N·m) (m/N); noise may make it negative.
        compliance_standard_error_rad_per_nm: its standard error, rad/(N·m) (m/N).

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> experiment.identify(experiment.simulate()).rigid_joints     # the log shows both springs
        []
    """

    joint: str
    stiffness_above_nm_per_rad: float
    compliance_rad_per_nm: float
    compliance_standard_error_rad_per_nm: float


@dataclass(frozen=True)
class StandardParameter:
    """An inertial parameter of a single link, or the inertia of a rotor, of bodies that can exist.

    Attributes:
        name: for example ``link1.izz``.
        unit: unit of the numbers.
        value: value.
        decided: what decided it: ``log``, ``both``, ``nominal``, ``nothing`` or ``given``.
        share_of_log: part of the nominal value's variance that the log removed, 0 to 1.
        standard_error: by the errors of the log and of the nominal values; ``None`` for a given value.
        nominal: nominal value; ``None`` if there is none.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> list(result.standard_parameters)            # planar-2r has no single links
        []
    """

    name: str
    unit: str
    value: float
    decided: str
    share_of_log: float = 0.0
    standard_error: float | None = None
    nominal: float | None = None

    def __str__(self) -> str:
        error = "" if self.standard_error is None else f" ± {self.standard_error:.2g}"
        return f"{self.name} = {self.value:.6g}{error} {self.unit}, by {self.decided}"


@dataclass(frozen=True)
class HeldOutResidual:
    """Residual in blocks of the logs that estimates had not used, relative to the filtered torque.

    Attributes:
        refined: that of the refinement.
        linear: that of least squares.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "prediction-error"})
        >>> refinement = experiment.identify(experiment.simulate()).refinement
        >>> refinement.held_out_residual.refined < refinement.held_out_residual.linear
        True
    """

    refined: float
    linear: float


@dataclass(frozen=True)
class Disturbance:
    """Noise and disturbance of a row of the equations, standard deviations.

    Attributes:
        row: for example ``joint1.motor_nm``.
        torque_noise_nm: white noise of the torque, N·m (N).
        reversal_noise_nm: further white noise while Coulomb friction reverses, N·m (N).
        disturbance_nm: slow disturbance, N·m (N).
        torque_nm: motor torque of the joint, N·m (N).
        at_bound: whether the disturbance ended at its upper bound.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "prediction-error"})
        >>> refinement = experiment.identify(experiment.simulate()).refinement
        >>> [disturbance.row for disturbance in refinement.disturbances if disturbance.at_bound]
        []
    """

    row: str
    torque_noise_nm: float
    disturbance_nm: float
    torque_nm: float
    at_bound: bool
    reversal_noise_nm: float = 0.0


@dataclass(frozen=True)
class EncoderOffset:
    """Constant offset of a position sensor by likelihood.

    Attributes:
        joint: name of the joint.
        column: column of the log.
        offset_rad: value, rad (m).
        standard_error_rad: its standard error, rad (m).

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "prediction-error"})
        >>> refinement = experiment.identify(experiment.simulate()).refinement
        >>> [offset.joint for offset in refinement.encoder_offsets]
        ['joint1', 'joint2']
    """

    joint: str
    column: str
    offset_rad: float
    standard_error_rad: float


@dataclass(frozen=True)
class RefinedDelay:
    """Delay of a column relative to the other columns by likelihood.

    Attributes:
        column: column of the log.
        delay_s: time from the event to its record, s.
        used_s: delay that the parameters take into account, s.
        standard_error_s: standard error of the delay, s; ``None`` if the log does not determine it.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "prediction-error"})
        >>> refinement = experiment.identify(experiment.simulate()).refinement
        >>> max(abs(delay.delay_s) for delay in refinement.delays) < 1e-4    # the twin has no delay
        True
    """

    column: str
    delay_s: float
    used_s: float
    standard_error_s: float | None = None


@dataclass(frozen=True)
class Refinement:
    """Figures of the refinement by prediction errors.

    Attributes:
        used: whether the values are those of the refinement; otherwise those of least squares.
        rung: how much slow disturbance the values allow: ``free``, ``cap10``, ``cap3`` or ``flat``.
        converged: whether the search converged.
        runs: number of runs of the filter.
        samples: number of samples used.
        duration_s: time that they span, s.
        measurements: number of position measurements; an incremental encoder gives one at each edge.
        minus_log_likelihood: minus the logarithm of the likelihood, without its constant.
        cost_per_measurement: mean squared whitened innovation; above 2 if the model does not follow the log.
        disturbance_corner_hz: corner frequency of the disturbances, Hz.
        disturbances: noise and disturbance of each row.
        encoder_offsets: constant offsets of position sensors.
        delays: delays by likelihood.
        held_out_residual: residual in blocks that the estimates had not used; ``None`` if the log is too short.
        torques_delay_s: delay that all motor torques have together and its standard error, s; ``None`` if it
            is no unknown.
        correlations: pairs of parameters with the most correlated errors, and their correlation.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "prediction-error"})
        >>> refinement = experiment.identify(experiment.simulate()).refinement
        >>> refinement.used, refinement.converged, refinement.rung
        (True, True, 'free')
    """

    used: bool
    rung: str
    converged: bool
    runs: int
    samples: int
    duration_s: float
    measurements: int
    minus_log_likelihood: float
    cost_per_measurement: float
    disturbance_corner_hz: float
    disturbances: list[Disturbance]
    encoder_offsets: list[EncoderOffset]
    delays: list[RefinedDelay]
    held_out_residual: HeldOutResidual | None = None
    torques_delay_s: tuple[float, float] | None = None
    correlations: list[tuple[str, str, float]] = field(default_factory=list)
