"""What a lab demands of its twin, and the verdict of a comparison."""

from __future__ import annotations

import dataclasses
import os
import reprlib
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ._yaml import read_yaml

Array: TypeAlias = npt.NDArray[np.float64]

TORQUE_LIMITS: Array = np.array([87.0, 87, 87, 87, 12, 12, 12])
"""Largest torques of the joints, Nm (docs/reference/limits.md)."""

_UNITS = {"Nm": ("torque", 1.0), "mNm": ("torque", 1e-3), "rad": ("angle", 1.0), "mrad": ("angle", 1e-3), "deg": ("angle", np.pi / 180),
          "s": ("time", 1.0), "ms": ("time", 1e-3), "us": ("time", 1e-6), "%": ("share", 1e-2)}


@dataclasses.dataclass(frozen=True)
class _Kind:
    of: str
    unit: str
    factor: float
    per_joint: bool
    meaning: str
    default: float | None


KINDS = {
    "torque": _Kind("torque", "Nm", 1.0, True, "torque that the twin does not explain, root of the mean square", None),
    "torque_share": _Kind("share", "%", 1e-2, True, "the same as a share of the joint's rated torque", 0.02),
    "position": _Kind("angle", "mrad", 1e-3, True, "difference between robot and twin under the same commands, root of the mean square", 0.003),
    "external_torque": _Kind("torque", "Nm", 1.0, True, "difference between the robot's estimate of external torque and the twin's, root of the mean square", None),
    "delay": _Kind("time", "ms", 1e-3, False, "delay of the torques beyond the twin's, either way", 0.001),
    "lost": _Kind("share", "%", 1e-2, False, "cycles that are not in the log", None),
}
"""What can be demanded, with the unit in which a report shows it."""


@dataclasses.dataclass(frozen=True)
class Item:
    """One demand, and how the twin meets it."""

    kind: str
    joint: int | None
    """From 0; None: of the whole robot."""
    found: float
    """SI; NaN where the log cannot tell."""
    demanded: float
    is_met: bool | None
    """None where the log cannot tell."""

    @property
    def words(self) -> str:
        """In words: "joint 3: torque 0.62 Nm, demanded at most 0.5 Nm"."""
        kind = KINDS[self.kind]
        where = "" if self.joint is None else f"joint {self.joint + 1}: "
        found = "not told by this log" if self.is_met is None else f"{self.found / kind.factor:.3g} {kind.unit}"
        return f"{where}{self.kind.replace('_', ' ')} {found}, demanded at most {self.demanded / kind.factor:.3g} {kind.unit}"


def read_demand(source: str | os.PathLike[str] | Mapping[str, Any] | None) -> dict[str, Array]:
    """Read what is demanded: a file with a map `demand:`, such a map, or None for the default.

    Returns
    -------
    dict of str to ndarray
        For each kind its largest allowed values, SI: (7,) or (1,).

    Raises
    ------
    ValueError
        Naming file, key and what is allowed.
    """
    if source is None:
        return {name: np.full(7 if kind.per_joint else 1, kind.default) for name, kind in KINDS.items() if kind.default is not None}
    where = "demand"
    if not isinstance(source, Mapping):
        where = str(source)
        source = read_yaml(where)
    if not isinstance(source, Mapping):
        raise ValueError(f"{where}: it holds no map; write demand: {{torque: 0.5 Nm}}")
    keys = source.get("demand", source)
    if not isinstance(keys, Mapping) or not keys:
        raise ValueError(f"{where}: demand holds nothing; write demand: {{torque: 0.5 Nm}}")
    return {name: _values(f"{where}: {name}", name, value) for name, value in keys.items()}


def _values(where: str, name: str, value: Any) -> Array:
    if name not in KINDS:
        raise ValueError(f"{where}: there is no such demand; choose of {', '.join(KINDS)}")
    kind = KINDS[name]
    numbers: list[Any]
    if isinstance(value, Mapping):
        unit, numbers = value.get("unit"), value.get("values", [])
        if not kind.per_joint or not isinstance(numbers, list) or len(numbers) != 7:
            raise ValueError(f"{where}: give {'one value' if not kind.per_joint else 'seven values, one for each joint'}")
    else:
        number, _, unit = (value if isinstance(value, str) else reprlib.repr(value)).strip().partition(" ")
        numbers = [number] * (7 if kind.per_joint else 1)
    allowed = [text for text, (of, _) in _UNITS.items() if of == kind.of]
    if unit not in allowed:
        raise ValueError(f"{where}: {reprlib.repr(value)} has no unit of {', '.join(allowed)}; write for example {name}: 1 {kind.unit}")
    try:
        found = np.array(numbers, float) * _UNITS[unit][1]
    except (TypeError, ValueError):
        raise ValueError(f"{where}: {reprlib.repr(value)} is no number with a unit") from None
    if not np.all(np.isfinite(found) & (found > 0)):
        raise ValueError(f"{where}: {reprlib.repr(value)} must be above 0 and finite")
    return found


def judge(demand: Mapping[str, Array], found: Mapping[str, Array]) -> list[Item]:
    """Hold what was found (SI, NaN where a log cannot tell) against what is demanded."""
    items = []
    for name, allowed in demand.items():
        values = found.get(name, np.full(len(allowed), np.nan))
        for place, (value, most) in enumerate(zip(values, allowed)):
            is_met = None if np.isnan(value) else bool(abs(value) <= most)
            items.append(Item(name, place if KINDS[name].per_joint else None, float(abs(value)), float(most), is_met))
    return items
