"""Frames of a log at equal intervals: vectors of its columns, and the hand's width."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from . import _core
from ._lerobot_files import Floats
from ._log import Log, Table
from .scenario import Scenario

GRIPPER = "gripper_width"

Times = npt.NDArray[np.int64]
_Numbers = npt.NDArray[np.float64]

_ELEMENTS = {table: {column[0]: (column[1], column[5]) for column in columns} for table, _, _, columns in _core.log_tables()}
# Of a pose, column-major: position, and two columns of the rotation, which determine the third.
_POSE = (12, 13, 14, 0, 1, 2, 4, 5, 6)
_COMMANDS = ("closes the hand", "opens the hand")  # of an operator; other commands end with "started"
_TOLERANCE = 0.01  # rad, between the measured posture and the scene's


def names_of(kind: str, columns: Sequence[str]) -> list[str]:
    """Returns the names of a feature's elements; checks its columns."""
    if isinstance(columns, str) or not columns:
        raise ValueError(f"{kind} is {columns!r}; a tuple of at least one column belongs here, such as ('q', '{GRIPPER}')")
    names: list[str] = []
    for column in columns:
        if column == GRIPPER:
            names.append(column)
            continue
        table = _table_of(column)
        if table is None:
            _core.check_log_columns([column])
        kind_of, elements = _ELEMENTS[table or "cycles"].get(column, ("", []))
        if kind_of != "float64":
            raise ValueError(f"{kind} names {column}; a column of floating-point numbers of cycles or ticks belongs here")
        names += [elements[i] for i in _POSE] if len(elements) == 16 else elements
    if len(set(names)) < len(names):
        raise ValueError(f"{kind} names a column twice: {', '.join(columns)}")
    return names


def _table_of(column: str) -> str | None:
    return next((table for table in ("cycles", "ticks") if column in _ELEMENTS[table]), None)


def _last(times: Times, rows: _Numbers, at: Times) -> _Numbers:
    """The last row at or before each instant; before the first, the first."""
    values: _Numbers = rows[np.maximum(np.searchsorted(times, at, side="right") - 1, 0)]
    return values


class Frames:
    """Instants of a log at equal intervals, and what was then.

    Parameters
    ----------
    scenes
        Whether they must lie between the first and the last recorded scene: for pictures and the hand's width. Else between the
        first and the last cycle.
    """

    def __init__(self, log: Log, fps: int, scenes: bool) -> None:
        cycles = log.cycles["at_ns"]
        if len(cycles) == 0:
            raise ValueError(f"{log!r} has no cycles of the robot")
        begin, end = int(cycles[0]), int(cycles[-1])
        if scenes:
            at = log.table("scenes")["at_ns"]
            if len(at) == 0:
                raise ValueError(
                    f"{log!r} has no scenes: without them there are no pictures, and the width of the gripper is not known. "
                    f"Record a simulated run with render.enabled: true, or leave out cameras and {GRIPPER}"
                )
            begin, end = int(at[0]), min(end, int(at[-1]))
        count = max(0, end - begin) * fps // 10**9 + 1
        self._log = log
        k = np.arange(count + 1, dtype=np.int64)
        times = begin + (k * 10**9 + fps // 2) // fps
        self.at: Times = times[:-1]
        """When states and pictures are taken, ns on the run's clock."""
        self.ends: Times = times[1:]
        """When the frames end: actions are those commanded until then."""

    def vector(self, columns: Sequence[str], is_action: bool) -> Floats:
        """Returns the columns side by side, a row per frame."""
        at = self.ends if is_action else self.at
        parts = [
            self._width(at, is_action)[:, np.newaxis] if column == GRIPPER else self._column(column, at) for column in columns
        ]
        return np.concatenate(parts, axis=1).astype(np.float32)

    def _column(self, column: str, at: Times) -> _Numbers:
        name = _table_of(column)
        assert name
        table = self._log.table(name)
        times, rows = table[table.names[0]], table[column].reshape(len(table), -1)
        if name == "ticks":  # a tick without a target leaves it out
            there = rows.any(axis=1)
            times, rows = times[there], rows[there]
            if len(rows) == 0:
                raise ValueError(f"{self._log!r} has no {column}: no tick of the workstation has it")
        return _last(times, rows[:, _POSE] if rows.shape[1] == 16 else rows, at)

    def _width(self, at: Times, is_action: bool) -> _Numbers:
        """Of the gripper, m: measured, or commanded."""
        scenes = self._log.table("scenes")
        times, widths = scenes["at_ns"], self._widths(scenes)

        def measured(at: Times) -> _Numbers:
            return np.interp(at, times, widths)

        starts = self._commands() if is_action else np.zeros(0, dtype=np.int64)
        if len(starts) == 0:
            return measured(at)
        # Logs have no commanded widths: the one at which a command's fingers are, before the next one starts, stands for it.
        reached = measured(np.append(starts, times[-1]))
        commanded: _Numbers = reached[np.searchsorted(starts, at, side="right")]
        return commanded

    def _widths(self, scenes: Table) -> _Numbers:
        """At each scene: the two joints after those that are where the arm is."""
        if Scenario.from_yaml(self._log.scenario).to_dict().get("robot", {}).get("hand") == "none":
            raise ValueError(f"{self._log!r} is of an arm without a hand; leave out {GRIPPER}")
        qpos = scenes["qpos"]
        q = _last(self._log.cycles["at_ns"], self._log.cycles["q"], scenes["at_ns"])
        apart = [float(np.abs(qpos[:, k : k + 7] - q).mean()) for k in range(qpos.shape[1] - 8)]
        arm = int(np.argmin(apart)) if apart else 0
        if not apart or apart[arm] > _TOLERANCE:
            raise ValueError(f"{self._log!r} has scenes without the arm and its hand; leave out {GRIPPER}")
        widths: _Numbers = qpos[:, arm + 7] + qpos[:, arm + 8]
        return widths

    def _commands(self) -> Times:
        """When commands to the hand started."""
        events = self._log.events
        if len(events) == 0:
            return np.zeros(0, dtype=np.int64)
        starts = [
            at
            for at, kind, text in zip(events["at_ns"].tolist(), events["kind"], events["text"])
            if (kind == "hand" and text.endswith(" started")) or (kind == "operator" and text in _COMMANDS)
        ]
        return np.array(starts, dtype=np.int64)
