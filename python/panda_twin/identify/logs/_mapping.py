"""Columns of any log as the twin's own: names, units, and what cannot be judged without them."""

from __future__ import annotations

import dataclasses
import difflib
import math
import os
import re
from collections.abc import Mapping, Sequence
from typing import Any

from ... import _core
from .._yaml import read_yaml

_TEXTS = ("fate", "robot_mode", "motion_generator_mode", "controller_mode", "errors", "reflex_reason", "violation")

WIDTHS: dict[str, int] = {
    name: len(elements) if is_vector else 1
    for table, _, _, columns in _core.log_tables() if table == "cycles"
    for name, _, is_vector, _, _, elements in columns if name != "at_ns"
} | {"q_c": 7, "dq_c": 7, "tau_J_c": 7}  # fmt: skip
"""Numbers in a row of each column: those of our table `cycles`, and the commands q_c, dq_c, tau_J_c."""

TEXTS = frozenset(_TEXTS)
"""Columns of texts; all others hold numbers."""

MAY_BE_NAN = frozenset({"q_c", "dq_c", "tau_J_c", "O_T_EE_c", "O_dP_EE_c", "O_ddP_EE_c", "elbow_c", "delbow_c", "ddelbow_c"})
"""Columns that have no value where nothing was commanded."""

FR3 = "the log is of a Franka Research 3, whose kinematics are the Panda's but not its dynamics, friction and limits"

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}

_ANGLE = {"rad": 1.0, "deg": math.pi / 180, "mrad": 1e-3}
_UNITS: dict[str, dict[str, float]] = {
    **dict.fromkeys(["q", "q_d", "q_c", "theta"], _ANGLE),
    **{
        name: {f"{unit}/{per}": factor for unit, factor in _ANGLE.items()}
        for names, per in ((("dq", "dq_d", "dq_c", "dtheta"), "s"), (("ddq_d",), "s^2"), (("dddq_d",), "s^3"))
        for name in names
    },
    **dict.fromkeys(["tau_J", "tau_J_d", "tau_J_c", "tau_ext_hat_filtered"], {"Nm": 1.0, "mNm": 1e-3, "Ncm": 1e-2}),
    "dtau_J": {"Nm/s": 1.0, "mNm/s": 1e-3},
    **dict.fromkeys(["O_T_EE", "O_T_EE_d", "O_T_EE_c"], {"m": 1.0, "mm": 1e-3}),
    "message_id": {"ms": 1.0},
    "control_command_success_rate": {"1": 1.0, "%": 1e-2},
}

_NEEDS = (
    ("q", "anything: every comparison begins with the joint positions"),
    ("tau_J", "the open comparison, and so friction, load, inertia and gravity"),
    ("dq", "friction directly: velocities are then the slope of q, which is noisier"),
    ("q_c", "the closed comparison with joint commands: tracking, and the delay between command and motion"),
    ("tau_J_c", "the closed comparison with torque commands"),
    ("q_d", "what the robot's own controller was to follow: its tracking error, and the delay of the link apart from the arm's"),
    ("dq_d", "the robot's own reference velocity: friction and tracking error during reversals are then less sharp"),
    ("tau_J_d", "what the robot's controller asked of its motors: the delay of the torque"),
    ("tau_ext_hat_filtered", "the robot's own estimate of external torques against the twin's"),
    ("O_F_ext_hat_K", "the robot's own estimate of the external wrench against the twin's"),
    ("message_id", "lost cycles for certain: without ids they are judged by gaps between stamps"),
    ("control_command_success_rate", "the share of commands that arrived"),
    ("fate", "which cycles had to hold the last command"),
    ("errors", "errors of the robot at the same cycle"),
)


def missing(columns: frozenset[str]) -> list[tuple[str, str]]:
    """What a log lacks, each with what cannot be judged without it."""
    return [(name, f"without {name} one cannot judge {what}") for name, what in _NEEDS if name not in columns]


@dataclasses.dataclass(frozen=True)
class Column:
    """Where a column comes from: places in the file's own list of names, and the factor to SI."""

    places: tuple[int, ...]
    factor: float


@dataclasses.dataclass(frozen=True)
class Wanted:
    """A line of a mapping: names or numbers of columns, or one name that is a vector's or a prefix; and a unit."""

    source: str | int | tuple[str | int, ...]
    unit: str


@dataclasses.dataclass(frozen=True)
class ColumnMap:
    """A column mapping, checked by itself; what the file has decides the rest."""

    name: str
    columns: dict[str, Wanted]
    robot: str = "panda"
    separator: str | None = None
    decimal: str | None = None


def _nearest(name: str, names: Sequence[str]) -> str:
    found = difflib.get_close_matches(name, names, 1, 0.5)
    return f"; did you mean {found[0]}?" if found else ""


def load(mapping: str | os.PathLike[str] | Mapping[str, Any]) -> ColumnMap:
    """Read a mapping: a YAML file, or the same keys as a dict.

    Raises
    ------
    ImportError
        Without ruamel.yaml.
    OSError
        When there is no such file.
    ValueError
        Saying what is wrong with which key.
    """
    if isinstance(mapping, Mapping):
        return _checked("the mapping", mapping)
    return _checked(str(mapping), read_yaml(mapping))


def _checked(name: str, keys: Any) -> ColumnMap:
    known = ("columns", "robot", "message_id", "time", "separator", "decimal")
    if not isinstance(keys, Mapping) or not isinstance(keys.get("columns", {}), Mapping):
        raise ValueError(
            f"{name} must have a section 'columns', such as columns: {{time: {{from: t, unit: s}}, q: q_, tau_J: tau_}}"
        )
    for key in keys:
        if key not in known:
            raise ValueError(f"{name}: {key} is not one of {', '.join(known)}{_nearest(str(key), known)}")
    robot = keys.get("robot", "panda")
    if robot not in ("panda", "fr3"):
        raise ValueError(
            f"{name}: robot is {robot}; the twin is a Panda, and only logs of a panda (or, by the Panda's dynamics, of an fr3) "
            f"can be compared"
        )
    for key in ("separator", "decimal"):
        if (value := keys.get(key)) is not None and not (isinstance(value, str) and len(value) == 1):
            raise ValueError(f"{name}: {key} is {value!r}; one character belongs there, such as ';'")
    lines = dict(keys.get("columns", {}))
    lines |= {key: keys[key] for key in ("time", "message_id") if key in keys}
    columns = {str(column): _wanted(name, str(column), line) for column, line in lines.items()}
    if "time" not in columns and "message_id" not in columns:
        raise ValueError(f"{name} names neither time nor message_id; one of them is needed, such as time: {{from: t, unit: s}}")
    if columns.keys() <= {"time", "message_id"}:
        raise ValueError(f"{name} names no column but the time; q and tau_J are the least")
    return ColumnMap(name, columns, robot, keys.get("separator"), keys.get("decimal"))


def _wanted(name: str, column: str, line: Any) -> Wanted:
    if column != "time" and column not in WIDTHS:
        names = ["time", *WIDTHS]
        raise ValueError(f"{name}: {column} is no column of the twin{_nearest(column, names)}; it has {', '.join(names)}")
    if not isinstance(line, Mapping):
        line = {"from": line}
    for key in line:
        if key not in ("from", "unit"):
            raise ValueError(f"{name}: {column} has a key {key}; only 'from' and 'unit' are known")
    source = line.get("from", column)
    one = isinstance(source, (str, int)) and not isinstance(source, bool)
    if not one and not (isinstance(source, (list, tuple)) and source and all(isinstance(s, (str, int)) for s in source)):
        raise ValueError(f"{name}: {column} comes from {source!r}; a column's name, a prefix or a list of names belongs there")
    units = TIME_UNITS if column == "time" else _UNITS.get(column, {"": 1.0})
    unit = line.get("unit")
    if unit is None and column == "time":
        raise ValueError(
            f"{name}: time has no unit; say which of {', '.join(TIME_UNITS)} it is, such as time: {{from: t, unit: ms}}"
        )
    unit = next(iter(units)) if unit is None else str(unit)
    if unit not in units:
        allowed = f"one of {', '.join(units)}" if "" not in units else "none: it is in SI units"
        raise ValueError(f"{name}: {column} has unit {unit}; it must be {allowed}")
    return Wanted(source if one else tuple(source), unit)


def automatic(names: Sequence[str], vectors: Mapping[str, int]) -> ColumnMap | None:
    """The mapping of a table whose columns have the twin's own names, as `panda-twin export` writes them; else None."""
    columns = {}
    for column in WIDTHS:
        if column not in TEXTS and (column in vectors or column in names or _by_prefix(column, names, WIDTHS[column])):
            columns[column] = Wanted(column, next(iter(_UNITS.get(column, {"": 1.0}))))
    for time, unit in (
        ("at_ns", "ns"),
        ("time_ns", "ns"),
        ("time_us", "us"),
        ("time_ms", "ms"),
        ("time_s", "s"),
        ("t_ns", "ns"),
        ("t_ms", "ms"),
        ("t_s", "s"),
    ):
        if time in names and "time" not in columns:
            columns["time"] = Wanted(time, unit)
    if "q" not in columns or not columns.keys() & {"time", "message_id"}:
        return None
    return ColumnMap("its own names", columns)


def _by_prefix(prefix: str, names: Sequence[str], width: int) -> list[int]:
    """Places of the columns that are the prefix and a number from 0 or 1, in order of the number; [] unless they are `width`."""
    found = _numbered(prefix, names)
    numbers = sorted(found)
    if len(numbers) == width and numbers in ([*range(width)], [*range(1, width + 1)]):
        return [found[number] for number in numbers]
    return []


def _numbered(prefix: str, names: Sequence[str]) -> dict[int, int]:
    pattern = re.compile(re.escape(prefix) + r"[\[_.\s(]*(\d{1,2})[\])]*")
    return {int(match[1]): place for place, name in enumerate(names) if (match := pattern.fullmatch(name))}


def resolve(mapping: ColumnMap, file: str, names: Sequence[str], vectors: Mapping[str, int]) -> dict[str, Column]:
    """Find a mapping's columns among those of a file.

    `vectors`: the columns of the file that hold more than one number in a row, with how many. Raises ValueError for what the file
    has not.
    """
    return {column: _resolved(mapping.name, column, wanted, file, names, vectors) for column, wanted in mapping.columns.items()}


def _resolved(mapping: str, column: str, wanted: Wanted, file: str, names: Sequence[str], vectors: Mapping[str, int]) -> Column:
    width = 1 if column == "time" else WIDTHS[column]
    units = TIME_UNITS if column == "time" else _UNITS.get(column, {"": 1.0})
    factor = units[wanted.unit]
    if isinstance(wanted.source, tuple):
        places = tuple(_place(mapping, column, source, file, names) for source in wanted.source)
        return Column(_of_width(mapping, column, places, file, width), factor)
    if wanted.source in names or isinstance(wanted.source, int):
        place = _place(mapping, column, wanted.source, file, names)
        has = vectors.get(names[place], 1)
        if has == width:
            return Column((place,), factor)
        if not (found := _by_prefix(str(wanted.source), names, width)):
            raise ValueError(_wrong_width(f"{file}: {names[place]}, which {mapping} names for {column},", has, width))
        return Column(tuple(found), factor)
    found = _by_prefix(wanted.source, names, width)
    if not found:
        some = _numbered(wanted.source, names)
        if some:
            raise ValueError(_wrong_width(f"{file}: {wanted.source}..., which {mapping} names for {column},", len(some), width))
        raise ValueError(f"{file} has no column {wanted.source}, nor {width} that begin so and end with a number, which "
                         f"{mapping} names for {column}"
                         f"{_nearest(wanted.source, names)}; it has {shortened(names)}")  # fmt: skip
    return Column(tuple(found), factor)


def _place(mapping: str, column: str, source: str | int, file: str, names: Sequence[str]) -> int:
    if isinstance(source, int):
        if not 0 <= source < len(names):
            raise ValueError(f"{file} has {len(names)} columns; {mapping} names number {source} for {column}, counted from 0")
        return source
    if source not in names:
        raise ValueError(
            f"{file} has no column {source}, which {mapping} names for {column}{_nearest(source, names)}; it has "
            f"{shortened(names)}"
        )
    if names.count(source) > 1:
        raise ValueError(
            f"{file} has {names.count(source)} columns called {source}, which {mapping} names for {column}; name it by its "
            f"number, counted from 0"
        )
    return names.index(source)


def _of_width(mapping: str, column: str, places: tuple[int, ...], file: str, width: int) -> tuple[int, ...]:
    if len(places) != width:
        raise ValueError(_wrong_width(f"{file}: {mapping} names for {column} what", len(places), width))
    if len(set(places)) != len(places):
        raise ValueError(f"{file}: {mapping} names a column twice for {column}")
    return places


def _wrong_width(what: str, has: int, width: int) -> str:
    cure = "all seven joints of a Panda are needed" if width == 7 else f"{width} are needed"
    return f"{what} has {has} of {width} numbers in a row; {cure}"


def shortened(names: Sequence[str], most: int = 12) -> str:
    """Names for a sentence."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "") if names else "none"
