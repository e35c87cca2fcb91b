"""Estimates of a comparison as tables: with 95 % intervals, by what they describe."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from .._regression import QUANTILE
from ._html import Cell, Cells, Html, folded, h2, h3, p, table
from ._summary import group_of, interval, number

if TYPE_CHECKING:
    from .._identify import Identified
    from .._regression import Estimate

Array: TypeAlias = npt.NDArray[np.float64]

_HEADS: list[str | Cell] = ["", *(f"joint {i + 1}" for i in range(7))]
_NOT_TOLD = Cell("not told", "untold")


def estimates_section(identified: Identified | None) -> list[Html]:
    """The section with everything that was identified."""
    parts = [h2("What was identified")]
    if identified is None:
        return [*parts, p("Nothing: no --identify was given, or the logs do not hold what it needs.")]
    tables = [part for estimate in identified.estimates for part in _tables(estimate)]
    if identified.stiffness is not None and np.all(np.isinf(identified.stiffness)):
        tables.append(p("Stiffness of the joints: motors and links move as one in this log (theta is q)."))
    if not tables:
        return [*parts, p("The logs tell none of what was asked for.")]
    return [*parts, p("With 95 % intervals.", "soft"), *tables]


def _tables(estimate: Estimate) -> list[Html]:
    groups: dict[str, list[int]] = {}
    for place, parameter in enumerate(estimate.parameters):
        groups.setdefault(group_of(estimate, parameter.key), []).append(place)
    parts: list[Html] = []
    for group, places in groups.items():
        if group == "friction":
            parts += [
                h3("Friction"),
                _by_joint(estimate, places),
                p("Where steepness and shift are empty, the step of Coulomb friction explains the log as well.", "soft"),
            ]
        elif group == "motor friction":
            parts.append(
                folded("Friction of motors and gears that the robot does not make up for", [_by_joint(estimate, places)])
            )
        elif group == "load":
            parts += [h3("Load on the flange, beside the hand"), _load(estimate, places)]
        elif group == "elasticity":
            parts += [h3("Stiffness of the joints"), _stiffness(estimate, places)]
        elif group == "armature":
            parts += [h3("Armature: inertia of the rotors behind their gears"), _by_joint(estimate, places)]
        elif group == "delay":
            parts += [h3("Delay"), _list(estimate, places)]
        elif group == "inertia":
            parts.append(
                folded(f"Base parameters of the links, as differences from the twin's ({len(places)})", [_list(estimate, places)])
            )
        else:
            parts.append(folded("Others", [_list(estimate, places)]))
    return parts


def _cell(value: float, sd: float) -> str | Cell:
    return interval(value, sd) if math.isfinite(value) else _NOT_TOLD


def _joint_of(key: str) -> int:
    """The index in "plant.friction.coulomb[2]"."""
    return int(key[key.index("[") + 1 : -1])


def _by_joint(estimate: Estimate, places: list[int]) -> Html:
    """A row for each kind of parameter, a column for each joint."""
    rows: dict[str, list[str | Cell]] = {}
    for place in places:
        parameter = estimate.parameters[place]
        name = f"{parameter.text.partition(' of joint')[0]}, {parameter.unit}"
        rows.setdefault(name, [""] * 7)[_joint_of(parameter.key)] = _cell(estimate.values[place], estimate.sd[place])
    return table([_HEADS], [[name, *cells] for name, cells in rows.items()])


def _list(estimate: Estimate, places: list[int]) -> Html:
    rows: list[Cells] = []
    for place in places:
        parameter = estimate.parameters[place]
        factor, unit = (1e3, "ms") if parameter.unit == "s" else (1.0, parameter.unit)
        rows.append([parameter.text, _cell(factor * estimate.values[place], factor * estimate.sd[place]), Cell(unit, "word")])
    return table([], rows)


def _mass_centre_inertia(body: Array) -> Array:
    """Of ten parameters: mass, centre, and the six numbers of the inertia about it; NaN where a parameter is not told."""
    mass = body[0]
    centre = body[1:4] / mass if mass > 0 else np.full(3, np.nan)
    about_centre = body[4:] - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))[np.triu_indices(3)]
    return np.concatenate([[mass], centre, about_centre])


def _carried(of: Callable[[Array], Array], values: Array, covariance: Array) -> tuple[Array, Array]:
    """Values of a function of estimates and their standard deviations, to first order."""
    sd = np.sqrt(np.maximum(np.diag(covariance), 0))
    told = np.flatnonzero(np.isfinite(values))
    found = of(values)
    slope = np.zeros((len(found), len(told)))
    for column, place in enumerate(told):
        step = np.zeros(len(values))
        step[place] = max(1e-3 * sd[place], 1e-9)
        slope[:, column] = (of(values + step) - of(values - step)) / (2 * step[place])
    return found, np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slope, covariance[np.ix_(told, told)], slope), 0))


def _load(estimate: Estimate, places: list[int]) -> Html:
    found, sd = _carried(_mass_centre_inertia, estimate.values[places], estimate.covariance[np.ix_(places, places)])
    names = [
        "mass, kg",
        *(f"centre {axis}, m" for axis in "xyz"),
        *(f"inertia about the centre {axes}, kg m^2" for axes in ("xx", "xy", "xz", "yy", "yz", "zz")),
    ]
    return table([], [[name, _cell(value, deviation)] for name, value, deviation in zip(names, found, sd)])


def _stiffness(estimate: Estimate, places: list[int]) -> Html:
    """Of compliance: its interval turned over, which is not symmetric."""
    rows: dict[str, list[str | Cell]] = {
        name: [_NOT_TOLD] * 7 for name in ("stiffness, Nm/rad", "from", "to", "offset of theta, mrad")
    }
    for place in places:
        key, value, half = estimate.parameters[place].key, estimate.values[place], QUANTILE * estimate.sd[place]
        joint = _joint_of(key)
        if key.startswith("theta"):
            rows["offset of theta, mrad"][joint] = _cell(1e3 * value, 1e3 * estimate.sd[place])
        elif value > 0:
            rows["stiffness, Nm/rad"][joint], rows["from"][joint] = number(1 / value), number(1 / (value + half))
            rows["to"][joint] = number(1 / (value - half)) if value > half else "stiff"
    return table([_HEADS], [[name, *cells] for name, cells in rows.items()])
