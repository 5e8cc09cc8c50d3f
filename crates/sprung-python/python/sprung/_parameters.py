"""Identified parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict, cast

from sprung._named import Named
from sprung._record import record

if TYPE_CHECKING:
    import pandas
    import pyarrow


class ParameterRow(TypedDict):
    """A parameter as a row of a table."""

    unit: str
    value: float | None
    standard_error: float | None
    ci95_low: float | None
    ci95_high: float | None
    one_sided: bool
    unconstrained: float | None
    nominal: float | None
    identifiable: bool
    fixed: bool


@dataclass(frozen=True)
class Parameter:
    """An identified parameter.

    Attributes:
        name: for example ``joint1.stiffness``.
        unit: unit of the numbers, for example ``N·m/rad``.
        value: estimate; ``None`` if the log does not determine it.
        standard_error: standard error of the estimate; ``None`` if there is none.
        ci95: interval that contains the true value in 95 % of experiments; ``None`` if there is none.
        one_sided: whether the interval ends at zero, the bound of the parameter: the log tells only how
            large it is at most.
        unconstrained: estimate without constraints, as diagnosis; ``None`` if there were no constraints.
        nominal: value of the maker; ``None`` if there is none.
        identifiable: whether the log determines it.
        fixed: whether its value was given and not estimated.
        sum_with: the other parameter of the sum that the value is, with its sign; ``None`` for a value of its own.
    """

    name: str
    unit: str
    value: float | None = None
    standard_error: float | None = None
    ci95: tuple[float, float] | None = None
    one_sided: bool = False
    unconstrained: float | None = None
    nominal: float | None = None
    identifiable: bool = True
    fixed: bool = False
    sum_with: str | None = None

    def __str__(self) -> str:
        name = self.name if self.sum_with is None else f"{self.name} {self.sum_with}"
        if self.value is None:
            return f"{name}: not determined"
        if self.one_sided and self.ci95 is not None:
            return f"{name} = {self.value:.6g} (< {self.ci95[1]:.2g}) {self.unit}".rstrip()
        error = "" if self.standard_error is None or self.fixed else f" ± {self.standard_error:.2g}"
        return f"{name} = {self.value:.6g}{error} {self.unit}".rstrip()


class Parameters(Named[Parameter]):
    """Parameters by name, in the order of the model.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> parameters = experiment.identify(experiment.simulate()).parameters
        >>> stiffness = parameters["joint1.stiffness"]
        >>> stiffness.unit, stiffness.ci95[0] < 9.3587 < stiffness.ci95[1]          # the twin's
        ('N·m/rad', True)
        >>> parameters.to_dict()["joint1.stiffness"]["identifiable"]
        True
        >>> parameters["joint1.stifness"]
        Traceback (most recent call last):
        KeyError: "there is no parameter 'joint1.stifness'; the nearest name is 'joint1.stiffness'; ..."
    """

    _kind = "parameter"

    def __init__(self, parameters: list[Parameter]) -> None:
        super().__init__({parameter.name: parameter for parameter in parameters})

    @classmethod
    def _of(cls, given: list[dict[str, Any]]) -> Parameters:
        return cls([record(Parameter, parameter) for parameter in given])

    def __hash__(self) -> int:
        return hash(tuple(self._all.values()))

    def __repr__(self) -> str:
        lines = "\n".join(f"  {parameter}" for parameter in self._all.values())
        return f"Parameters(\n{lines}\n)"

    def values_by_name(self) -> dict[str, float]:
        """Returns the values of all parameters that the log determines."""
        return {
            name: parameter.value
            for name, parameter in self._all.items()
            if parameter.value is not None
        }

    def _columns(self) -> dict[str, list[object]]:
        rows: list[Mapping[str, object]] = [_row(parameter) for parameter in self._all.values()]
        columns = {name: [row[name] for row in rows] for name in ParameterRow.__annotations__}
        return {"name": list(self._all), **columns}

    def to_pandas(self) -> pandas.DataFrame:
        """Returns a table with one row per parameter, with the names as index."""
        import pandas

        return pandas.DataFrame(self._columns()).set_index("name")

    def to_arrow(self) -> pyarrow.Table:
        """Returns a table of Arrow with one row per parameter."""
        import pyarrow

        return pyarrow.table(self._columns())

    def to_dict(self) -> dict[str, ParameterRow]:
        """Returns numbers by the names of parameters."""
        return {name: _row(parameter) for name, parameter in self._all.items()}


def _row(parameter: Parameter) -> ParameterRow:
    low, high = parameter.ci95 or (None, None)
    values: Any = {"ci95_low": low, "ci95_high": high, **vars(parameter)}
    return cast("ParameterRow", {name: values[name] for name in ParameterRow.__annotations__})
