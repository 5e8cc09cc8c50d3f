"""Identified parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sprung._errors import no_parameter

if TYPE_CHECKING:
    import pandas
    import pyarrow

_COLUMNS = (
    "unit",
    "value",
    "standard_error",
    "ci95_low",
    "ci95_high",
    "one_sided",
    "unconstrained",
    "nominal",
    "identifiable",
    "fixed",
)


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
    """

    name: str
    unit: str
    value: float | None
    standard_error: float | None = None
    ci95: tuple[float, float] | None = None
    one_sided: bool = False
    unconstrained: float | None = None
    nominal: float | None = None
    identifiable: bool = True
    fixed: bool = False

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Parameter:
        """Returns a parameter from its JSON."""
        ci95 = given.get("ci95")
        return cls(
            name=given["name"],
            unit=given["unit"],
            value=given.get("value"),
            standard_error=given.get("standard_error"),
            ci95=(ci95[0], ci95[1]) if ci95 else None,
            one_sided=given.get("one_sided", False),
            unconstrained=given.get("unconstrained"),
            nominal=given.get("nominal"),
            identifiable=given["identifiable"],
            fixed=given.get("fixed", False),
        )

    def __str__(self) -> str:
        if self.value is None:
            return f"{self.name}: not determined"
        if self.one_sided and self.ci95 is not None:
            return f"{self.name} = {self.value:.6g} (< {self.ci95[1]:.2g}) {self.unit}".rstrip()
        error = "" if self.standard_error is None else f" ± {self.standard_error:.2g}"
        return f"{self.name} = {self.value:.6g}{error} {self.unit}".rstrip()


class Parameters(Mapping[str, Parameter]):
    """Parameters by name, in the order of the model."""

    def __init__(self, parameters: list[Parameter]) -> None:
        self._all = {parameter.name: parameter for parameter in parameters}

    def __getitem__(self, name: str) -> Parameter:
        try:
            return self._all[name]
        except KeyError:
            raise no_parameter(name, self._all) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Parameters) and self._all == other._all

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

    def _columns(self) -> dict[str, list[Any]]:
        rows = [_row(parameter) for parameter in self._all.values()]
        return {"name": list(self._all)} | {
            name: [row[name] for row in rows] for name in _COLUMNS
        }

    def to_pandas(self) -> pandas.DataFrame:
        """Returns a table with one row per parameter, with the names as index."""
        import pandas

        return pandas.DataFrame(self._columns()).set_index("name")

    def to_arrow(self) -> pyarrow.Table:
        """Returns a table of Arrow with one row per parameter."""
        import pyarrow

        return pyarrow.table(self._columns())

    def to_dict(self) -> dict[str, dict[str, Any]]:
        """Returns numbers by the names of parameters."""
        return {name: _row(parameter) for name, parameter in self._all.items()}


def _row(parameter: Parameter) -> dict[str, Any]:
    low, high = parameter.ci95 or (None, None)
    return {
        "unit": parameter.unit,
        "value": parameter.value,
        "standard_error": parameter.standard_error,
        "ci95_low": low,
        "ci95_high": high,
        "one_sided": parameter.one_sided,
        "unconstrained": parameter.unconstrained,
        "nominal": parameter.nominal,
        "identifiable": parameter.identifiable,
        "fixed": parameter.fixed,
    }
