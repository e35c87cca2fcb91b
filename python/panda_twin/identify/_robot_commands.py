"""What a robot's log gives to each cycle of the twin: commands, those that were lost, and requests."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from .logs._recording import Recording

Floats: TypeAlias = npt.NDArray[np.float64]
Mask: TypeAlias = npt.NDArray[np.bool_]
Values: TypeAlias = npt.NDArray[Any]

COMMAND = {"q_c": slice(0, 7), "dq_c": slice(7, 14), "tau_J_d": slice(14, 21), "O_T_EE_c": slice(21, 37), "O_dP_EE_c": slice(37, 43),
           "elbow_c": slice(43, 45), "valid_elbow": slice(45, 46), "motion_generation_finished": slice(46, 47)}  # fmt: skip
"""Columns of a command."""
COMMAND_SIZE = 47
START, STOP, RECOVER = 1, 2, 3
"""Requests before a cycle."""

_T = 1e-3  # s, a cycle
_LEAD = 200  # cycles at rest before the first row of a robot's log
_LOST = 20  # cycles without a command that end a motion
_SAME = 1e-10  # rad: a reference that follows its command, or holds its acceleration
_AT_REST = 0.02  # rad/s
_JUMP = 1.0  # Nm in a cycle: 1000 Nm/s
_ANSWERED = 6  # cycles


@dataclasses.dataclass
class Cycles:
    """Cycles after each other, with what is given to the robot for each."""

    ids: npt.NDArray[np.int64]
    logged: Mask
    """Whether the log has a row of the cycle."""
    requests: npt.NDArray[np.uint8]
    """(n, 3): request, motion generator mode, controller mode."""
    present: Mask
    commands: Floats
    lost: Mask
    """Whether a command is absent because it was lost, not because the motion has ended."""

    @classmethod
    def none(cls, begin: int, end: int) -> Cycles:
        """Cycles begin, ..., end - 1, of which the log has none."""
        n = max(0, end - begin)
        return cls(np.arange(begin, begin + n), np.zeros(n, bool), np.zeros((n, 3), np.uint8), np.zeros(n, bool), np.zeros((n, COMMAND_SIZE)), np.zeros(n, bool))


class Shift:
    """Moves rows down, from one block into the next."""

    def __init__(self, rows: int) -> None:
        self._rows = rows
        self._kept: dict[int, Values] = {}

    def __call__(self, values: Values) -> Values:
        if self._rows == 0:
            return values
        key = values.ndim
        kept = self._kept.get(key)
        if kept is None:
            kept = np.zeros((self._rows, *values.shape[1:]), values.dtype) if values.dtype == bool else np.full((self._rows, *values.shape[1:]), np.nan)
        whole = np.concatenate([kept, values])
        self._kept[key] = whole[len(values):]
        return whole[: len(values)]


def start_of(recording: Recording) -> Floats:
    name = "q_d" if "q_d" in recording.columns else "q"
    if name not in recording.columns:
        raise ValueError(f"{recording.name} has neither q_d nor q; without them nothing tells where the arm begins")
    head = recording.head(0.05, name)
    speed = np.abs(head.columns[name][1] - head.columns[name][0]) / (head.t[1] - head.t[0])
    if speed.max() > (_AT_REST if name == "q_d" else 5 * _AT_REST):
        raise ValueError(f"{recording.name} begins in a motion: joint {speed.argmax() + 1} moves at {speed.max():.3f} rad/s; cut it so that it begins at rest")
    first: Floats = head.columns[name][0]
    return first


@dataclasses.dataclass(frozen=True)
class _Interface:
    """What is commanded: our column, the log's, and the modes."""

    command: str
    column: str
    generator: int
    controller: int


INTERFACES = (_Interface("tau_J_d", "tau_J_c", 2, 2), _Interface("q_c", "q_c", 1, 0), _Interface("dq_c", "dq_c", 2, 0), _Interface("q_c", "q_d", 1, 0))


def interface_of(columns: frozenset[str]) -> _Interface:
    """Choose what is commanded."""
    for interface in INTERFACES:
        if interface.column in columns:
            return interface
    raise ValueError("the log has neither q_c nor dq_c, tau_J_c or q_d: there are no commands to replay")


def cycles_of(recording: Recording, delay: int) -> Iterator[Cycles]:
    """Cycles of a robot's log, with commands as `replay` says; those at the end of a block wait until it is known what follows."""
    interface = interface_of(recording.columns)
    return _requested(_gridded(recording, interface, delay), interface)


def _gridded(recording: Recording, interface: _Interface, delay: int) -> Iterator[Cycles]:
    """The log's rows on cycles of 1 ms, with commands in all that have one; a row that is NaN has none."""
    others = [name for name in ("q_d", "dq_d", "dq_c") if name in recording.columns]
    if interface.command == "q_c" and "dq_c" in others:
        others.remove("dq_c")
    last = -1
    shift = Shift(delay)
    known: dict[str, Values] = {}
    yield Cycles.none(-_LEAD, 0)
    for block in recording.blocks(*{interface.column, *others}):
        at = np.rint(block.t / _T).astype(np.int64)
        at = np.maximum.accumulate(np.maximum(at, last + 1) - np.arange(len(at))) + np.arange(len(at))  # stamps jitter; each row has a cycle
        known = {name: np.concatenate([known[name][-3:], values]) if known else values for name, values in {**block.columns, "at": at}.items()}
        begin, last = last + 1, int(at[-1])
        cycles = Cycles.none(begin, last + 1)
        cycles.logged[at - begin] = True
        commanded = _without_idle(known[interface.column]) if interface.command == "tau_J_d" else known[interface.column]
        command = _filled(known["at"], commanded, cycles.ids, interface.command != "tau_J_d")
        command[_held_in_gaps(known, cycles.ids, interface)] = np.nan
        command = shift(command)
        cycles.present = _there(command)
        if interface.column == "q_c" and "q_d" in known:
            cycles.lost[at - begin] = _unfollowed(block.columns["q_d"], command[at - begin])
            cycles.present &= ~cycles.lost
        cycles.commands[:, COMMAND[interface.command]] = np.nan_to_num(command)
        if interface.command == "tau_J_d" and "dq_c" in others:
            cycles.commands[:, COMMAND["dq_c"]] = np.nan_to_num(_filled(known["at"], known["dq_c"], cycles.ids, True))
        yield cycles


def _filled(at: Values, values: Floats, ids: Values, is_smooth: bool) -> Floats:
    """Values at cycles `ids`: the rows' own, and between rows by a cubic with their slopes, or by a line."""
    if len(at) < 2:
        return np.repeat(values[-1:], len(ids), axis=0)
    after = np.clip(np.searchsorted(at, ids), 1, len(at) - 1)
    a, b = after - 1, after
    span = (at[b] - at[a])[:, None]
    u = (ids - at[a])[:, None] / span
    line: Floats = values[a] + u * (values[b] - values[a])
    if is_smooth:
        slope = np.gradient(values, at.astype(float), axis=0)
        bend = slope[a] * span - (values[b] - values[a]), slope[b] * span - (values[b] - values[a])
        line = line + u * (1 - u) * ((1 - u) * bend[0] - u * bend[1])
    exact: Mask = np.asarray(np.isin(ids, at), dtype=np.bool_)
    line[exact] = values[np.searchsorted(at, ids[exact])]
    return line


def _held_in_gaps(known: dict[str, Values], ids: Values, interface: _Interface) -> Mask:
    """Cycles that are not in the log in which the robot held its acceleration: its q_d after them is what that comes to."""
    held = np.zeros(len(ids), bool)
    if interface.command == "tau_J_d" or interface.column == "q_d" or not {"q_d", "dq_d"} <= known.keys():
        return held
    at, q_d, dq_d = known["at"], known["q_d"], known["dq_d"]
    for a in np.flatnonzero(np.diff(at) > 1):
        if a == 0 or at[a] - at[a - 1] > 1 or at[a + 1] - at[a] > _LOST:
            continue
        m = int(at[a + 1] - at[a] - 1)
        ddq = (dq_d[a] - dq_d[a - 1]) / _T
        expected = q_d[a] + m * _T * dq_d[a] + m * (m + 1) / 2 * _T**2 * ddq
        if np.abs(q_d[a + 1] - _T * dq_d[a + 1] - expected).max() < _SAME:
            held |= (ids > at[a]) & (ids < at[a + 1])
    return held


def _there(command: Floats) -> Mask:
    there: Mask = np.asarray(np.isfinite(command).all(axis=1), dtype=np.bool_)
    return there


def _unfollowed(q_d: Floats, command: Floats) -> Mask:
    """Rows whose reference is not their command, where most are; 20 in a row only where the acceleration was held."""
    there = _there(command)
    differs: Mask = np.asarray(there & (np.abs(q_d - np.nan_to_num(command)).max(axis=1) > _SAME), dtype=np.bool_)
    if differs.sum() * 2 >= there.sum():
        return np.zeros(len(q_d), bool)
    for begin, end in _runs(differs):
        if end - begin >= _LOST and not _is_held(q_d[max(0, begin - 3) : begin + _LOST - 4]):
            differs[begin:end] = False
    return differs


def _runs(mask: Mask) -> list[tuple[int, int]]:
    """Begins and ends of the rows in which it holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int))).tolist()
    return list(zip(edges[::2], edges[1::2]))


def _is_held(q_d: Floats) -> bool:
    """Whether a reference moves with one acceleration."""
    return len(q_d) > 3 and bool(np.abs(np.diff(q_d, 3, axis=0)).max() < 10 * _SAME and np.abs(np.diff(q_d[:2], axis=0)).max() > 1e-6)


def _without_idle(torque: Floats) -> Floats:
    """Torques, NaN where the motion has ended: all are zero at once, or they jump shortly before they end, more than a robot lets them."""
    zero: Mask = np.asarray(np.abs(torque).max(axis=1) == 0, dtype=np.bool_)
    result = torque.copy()
    for begin, end in _runs(zero):
        if begin == 0 or np.abs(torque[begin - 1]).max() > _JUMP:
            result[begin:end] = np.nan
    for begin, end in _runs(_there(result)):  # a client answers some states of a motion that it has ended
        last = max(begin, end - _ANSWERED)
        jumps = np.flatnonzero(np.abs(np.diff(result[last:end], axis=0)).max(axis=1) > _JUMP)
        if end < len(result) and len(jumps):
            result[last + jumps[0] + 1 : end] = np.nan
    return result


def _requested(grid: Iterator[Cycles], interface: _Interface) -> Iterator[Cycles]:
    """Requests a start two cycles before a first command, and a stop where no more come. Holds back what depends on later cycles."""
    waiting: Cycles | None = None
    moving = False
    for block in grid:
        waiting = block if waiting is None else _joined(waiting, block)
        moving, waiting, ready = _passed(waiting, moving, interface, len(waiting.ids) - _LOST - 2)
        yield ready
    if waiting is not None:
        yield _passed(waiting, moving, interface, len(waiting.ids))[2]


def _passed(cycles: Cycles, moving: bool, interface: _Interface, count: int) -> tuple[bool, Cycles, Cycles]:
    """The first `count` cycles with their requests, and those that wait."""
    count = max(0, count)
    coming = np.flatnonzero(cycles.present | cycles.lost)
    i = 0
    while i < count:
        place = np.searchsorted(coming, i)
        following = int(coming[place]) if place < len(coming) else len(cycles.ids) + _LOST
        if not moving:
            start = max(i, following - 2)
            if start >= count:
                break
            cycles.requests[start] = START, interface.generator, interface.controller
            moving, i = True, following
        elif following == i:
            gaps = np.flatnonzero(np.diff(coming[place:]) > _LOST)
            i = int(coming[place + gaps[0]] if len(gaps) else coming[-1]) + 1
        elif following - i > _LOST:
            cycles.requests[i, 0] = STOP
            moving = False
            i += 1
        else:
            i = following
    return moving, _part(cycles, count, len(cycles.ids)), _part(cycles, 0, count)


def _part(cycles: Cycles, begin: int, end: int) -> Cycles:
    return Cycles(*(getattr(cycles, field.name)[begin:end] for field in dataclasses.fields(Cycles)))


def _joined(one: Cycles, other: Cycles) -> Cycles:
    return Cycles(*(np.concatenate([getattr(one, field.name), getattr(other, field.name)]) for field in dataclasses.fields(Cycles)))
