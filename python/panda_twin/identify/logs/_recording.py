"""A log of any robot or program in the twin's own columns, read in blocks so that an hour of it never is in memory."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import os
import pathlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ...scenario import Scenario
from ._formats import of_arrays, of_file
from ._mapping import MAY_BE_NAN, TEXTS, load, missing, shortened
from ._readers import Chunk, Source
from ._timing import Intervals, Runs, Success, Timing

Values = npt.NDArray[Any]
Floats = npt.NDArray[np.float64]
MappingLike = str | os.PathLike[str] | Mapping[str, Any]

_COMMANDS = ("q_c", "dq_c", "tau_J_c")
_PERIODS = (100e-6, 0.5)  # s; a robot's log has one between


@dataclasses.dataclass(frozen=True)
class Block:
    """Some rows of a log.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s from the log's begin, rising strictly; never at equal intervals.
    columns : dict of str to ndarray
        (n,) or (n, width), SI units and radians.
    """

    t: Floats
    columns: dict[str, Values]


class _Unsorted(ValueError):
    """Time goes back."""


class Recording:
    """A log, opened: what it has, what is missing, and its times.

    Attributes
    ----------
    path : pathlib.Path or None
        None of a dict.
    kind : str
        "panda-twin", "libfranka", "panda-py", "rosbag2" or "table".
    rows : int
        Without repeated ones.
    seconds : float
        From the first row to the last.
    columns : frozenset of str
        Canonical columns: those of the table `cycles` of our logs, and the commands q_c, dq_c, tau_J_c. A row's command is the
        newest that its state can show: the answer to the state before.
    by_id : bool
        Times are the robot's own ms (message_id), not stamps.
    missing : list of (str, str)
        Columns that are not there, with what cannot be judged without them.
    notes : list of str
        What was noticed.
    timing : Timing
    scenario : Scenario or None
        Of a log of the twin.
    """

    def __init__(self, source: Source, path: pathlib.Path | None, name: str) -> None:
        self.path = path
        self.kind = source.kind
        self.scenario: Scenario | None = source.scenario
        self.columns = source.columns
        self.notes: list[str] = []
        self._name = name
        self._source = source
        self.by_id = "message_id" in source.columns
        if not self.by_id and not source.has_time:
            raise ValueError(f"{name} has neither times nor message ids; without them its rows cannot be placed")
        try:
            self._scan()
        except _Unsorted as error:
            if not (self.by_id and source.has_time):
                raise
            self._by_stamps(f"{error}; the stamps count instead")
        self.missing = missing(self.columns)
        self.notes += source.notes

    @classmethod
    def open(cls, path: str | os.PathLike[str] | Mapping[str, Any], mapping: MappingLike | None = None) -> Recording:
        """Open a log.

        Parameters
        ----------
        path : path or dict
            run.mcap or a folder of results; libfranka's CSV; what panda_py's get_log() returned, as a dict or by ``numpy.savez``;
            a bag of ROS 2 (folder, .mcap, .db3); any CSV, Parquet or NPZ file.
        mapping : path or dict, optional
            Which columns are which, with units: docs/reference/robot-logs.md. For tables whose columns do not have the twin's names.

        Raises
        ------
        ValueError
            For what is no log, or a bad one: says what, where and what to do.
        OSError
            When it cannot be read.
        ImportError
            Naming what must be installed.
        """
        wanted = None if mapping is None else load(mapping)
        if isinstance(path, Mapping):
            return cls(of_arrays(path, wanted), None, "the dict")
        file = pathlib.Path(path)
        if file.exists() and not file.is_file() and not file.is_dir():
            raise ValueError(f"{file} is neither a file nor a folder; save the log as a file first")
        return cls(of_file(file, wanted), file, str(file))

    @property
    def name(self) -> str:
        """What messages call the log."""
        return self._name

    @functools.cached_property
    def sha256(self) -> str:
        """Of the file, or of a folder's files in order of their names; empty of a dict."""
        if self.path is None:
            return ""
        file = getattr(self._source, "path", self.path)  # of a folder of results its log
        digest = hashlib.sha256()
        for one in sorted(p for p in file.rglob("*") if p.is_file()) if file.is_dir() else [file]:
            with open(one, "rb") as data:
                while part := data.read(1 << 20):
                    digest.update(part)
        return digest.hexdigest()

    def blocks(self, *names: str, seconds: float = 20.0, overlap: float = 0.0) -> Iterator[Block]:
        """Yield the log in blocks.

        Parameters
        ----------
        *names : str
            Columns; all without names.
        seconds : float
            Of a block, at most; where a gap is longer, the next block begins behind it.
        overlap : float
            Seconds of a block's end with which the next begins again.

        Raises
        ------
        ValueError
            For a column that is not there, or that has a value that is no number.
        """
        if not 0 <= overlap < seconds:
            raise ValueError(f"overlap is {overlap} s; it must be from 0 to below the {seconds} s of a block")
        held: list[tuple[Floats, dict[str, Values]]] = []
        new = False
        for t, columns in self._rows(self._checked(names)):
            held.append((t, columns))
            new = True
            while held and held[-1][0][-1] >= held[0][0][0] + seconds:
                times, whole = _joined(held)
                end = int(np.searchsorted(times, times[0] + seconds))
                yield Block(times[:end], {name: values[:end] for name, values in whole.items()})
                start = max(1, int(np.searchsorted(times, times[0] + seconds - overlap)))
                start = min(start, end)
                held = [(times[start:], {name: values[start:] for name, values in whole.items()})]
                new = len(times) > end
        if held and new:
            yield Block(*_joined(held))

    def head(self, seconds: float, *names: str) -> Block:
        """Return the rows of the first seconds; as `blocks`."""
        return next(self.blocks(*names, seconds=seconds))

    def _checked(self, names: Sequence[str]) -> list[str]:
        for name in names:
            if name not in self.columns:
                raise ValueError(f"{self._name} has no column {name}; it has {shortened(sorted(self.columns), 60)}")
        return list(dict.fromkeys(names)) or sorted(self.columns)

    def _rows(self, names: Sequence[str]) -> Iterator[tuple[Floats, dict[str, Values]]]:
        """Rows by chunks, checked, without repeated ones."""
        key = "message_id" if self.by_id else "time"
        clock = _Clock(self._name, key, 1e-3 if self.by_id else self._source.time_unit)
        for chunk in self._source.chunks(list(dict.fromkeys([*names, key]))):
            t, keep = clock.of(chunk)
            for name in names:
                self._check_finite(name, chunk)
            if len(t):
                yield t, {name: _finished(name, chunk.values[name][keep]) for name in names}

    def _check_finite(self, name: str, chunk: Chunk) -> None:
        values = chunk.values[name]
        if name in TEXTS or name in MAY_BE_NAN or values.dtype.kind != "f" or np.isfinite(values).all():
            return
        bad = np.argwhere(~np.isfinite(values))[0]
        where = f"{name}[{bad[1]}]" if values.ndim == 2 else name
        raise ValueError(
            f"{self._name}: {where} is {values[tuple(bad)]} in row {chunk.first_row + bad[0]}; remove the row, or leave {name} "
            f"out of the comparison"
        )

    def _scan(self) -> None:
        source = self._source
        key = "message_id" if self.by_id else "time"
        clock = _Clock(self._name, key, 1e-3 if self.by_id else source.time_unit)
        stamps = _Stamps(source.time_unit) if self.by_id and source.has_time else None
        intervals, runs, success, used = Intervals(), Runs(), Success(), dict.fromkeys(set(_COMMANDS) & source.columns, False)
        names = [key, *(["time"] if stamps else []), *used, *({"fate", "control_command_success_rate"} & source.columns)]
        self.rows, begin = 0, None
        for chunk in source.chunks(names):
            t, keep = clock.of(chunk)
            if len(t) == 0:
                continue
            intervals.add(t, None if begin is None else self.seconds)
            begin = 0.0
            self.rows, self.seconds = self.rows + len(t), float(t[-1])
            if stamps:
                stamps.add(t, chunk.values["time"][keep])
            if "fate" in chunk.values:
                runs.add(chunk.values["fate"][keep] == "held")
            if "control_command_success_rate" in chunk.values:
                success.add(chunk.values["control_command_success_rate"][keep])
            for name in used:
                used[name] = used[name] or bool(np.any(np.nan_to_num(chunk.values[name]) != 0))
        runs.end()
        if self.rows < 2:
            raise ValueError(f"{self._name} has {self.rows} rows at different times; at least two are needed")
        if stamps and not stamps.agree(self.seconds):
            self._by_stamps(
                f"message_id rises by one in {stamps.seconds / self.seconds:.3g} ms of the stamps, so it does not count the "
                f"robot's ms; the stamps count"
            )
            return
        self.columns = source.columns - {name for name, there in used.items() if not there}
        self._judge(intervals, runs, success, stamps, clock.repeated)

    def _by_stamps(self, note: str) -> None:
        self.by_id = False
        self.notes.append(note)
        self._scan()

    def _judge(self, intervals: Intervals, runs: Runs, success: Success, stamps: _Stamps | None, repeated: int) -> None:
        period = intervals.median()
        if not _PERIODS[0] <= period <= _PERIODS[1]:
            unit = "message_id" if self.by_id else f"time read with a unit of {self._source.time_unit:g} s"
            factor = next((f"; it looks as if the unit were "
                           f"{f * self._source.time_unit:g} s" for f in (1e-3, 1e-6, 1e-9, 1e3, 1e6, 1e9)
                           if _PERIODS[0] <= period * f <= _PERIODS[1] and not self.by_id), "")  # fmt: skip
            raise ValueError(
                f"{self._name}: {unit} rises by {period:g} s from row to row, and a robot's log has 0.1 ms to 0.5 s{factor}; "
                f"name the unit in the mapping"
            )
        cycle = 1e-3 if self.by_id else period
        late = stamps.intervals.late(stamps.intervals.median()) if stamps else intervals.late(cycle)
        self.timing = Timing(
            by="message_id" if self.by_id else "time", median=period * 1e3, mean=intervals.mean * 1e3, sd=intervals.sd * 1e3,
            longest=intervals.longest * 1e3, longest_at=intervals.longest_at, lost=intervals.lost(cycle), late=late,
            repeated=repeated, sorted=not getattr(self._source, "reordered", 0), intervals=intervals.histogram(period),
            held=runs.counts, success=success.histogram(),
        )  # fmt: skip
        timing = self.timing
        if repeated:
            self.notes.append(f"{repeated} rows have the time of the row before and are left out")
        if timing.lost:
            self.notes.append(
                f"{timing.lost} cycles are not in the log, the longest gap is {timing.longest:.1f} ms at "
                f"{timing.longest_at:.3f} s"
            )
        if timing.late:
            self.notes.append(f"{timing.late} rows came late, by more than a quarter of the period of {timing.median:.3f} ms")


class _Clock:
    """Times of rows, from the first one on."""

    def __init__(self, name: str, key: str, unit: float) -> None:
        self._name, self._key, self._unit = name, key, unit
        self._first: Any = None
        self._last = -np.inf
        self.repeated = 0

    def of(self, chunk: Chunk) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Times of a chunk, s, without repeated rows, and which rows those are. Raises ValueError where time goes back."""
        raw = chunk.values[self._key]
        if raw.dtype.kind == "f" and not np.isfinite(raw).all():
            row = int(np.flatnonzero(~np.isfinite(raw))[0])
            raise ValueError(f"{self._name}: {self._key} is {raw[row]} in row {chunk.first_row + row}; remove the row")
        if raw.dtype.kind != "f":
            raw = raw.astype(np.int64)
        if len(raw) and self._first is None:
            self._first = raw[0]
        t = np.asarray(raw - self._first if len(raw) else raw, np.float64) * self._unit
        steps = np.diff(t, prepend=self._last)
        if np.any(steps < 0):
            row = int(np.flatnonzero(steps < 0)[0])
            before = float(t[row - 1]) if row else float(self._last)
            raise _Unsorted(f"{self._name}: {self._key} goes back in row {chunk.first_row + row}, from {before:.6f} to "
                            f"{t[row]:.6f} s after the first; "
                            "sort the rows by time, or cut the log where it begins anew")  # fmt: skip
        keep = np.asarray(steps > 0)
        self.repeated += int(len(keep) - keep.sum())
        if len(t):
            self._last = float(t[-1])
        return t[keep], keep


class _Stamps:
    """Stamps beside ids: whether both tell the same time, and how late cycles were."""

    def __init__(self, unit: float) -> None:
        self._unit = unit
        self._first: Any = None
        self._last: tuple[float, float] | None = None
        self.intervals = Intervals()
        self.seconds = 0.0

    def add(self, t: Floats, raw: Values) -> None:
        if self._first is None:
            self._first = raw[0]
        stamps = np.nan_to_num(np.asarray(raw - self._first, np.float64)) * self._unit
        if self._last is not None:
            t, stamps = np.append(self._last[0], t), np.append(self._last[1], stamps)
        single = np.diff(t) < 1.5e-3  # no cycle is lost between them
        self.intervals.add(np.append(0.0, np.cumsum(np.maximum(np.diff(stamps)[single], 0))), None)
        self._last = float(t[-1]), float(stamps[-1])
        self.seconds = float(stamps[-1])

    def agree(self, seconds: float) -> bool:
        """Whether ids count ms of the stamps, to 10 %."""
        return seconds < 0.5 or 0.9 <= self.seconds / seconds <= 1.1


def _finished(name: str, values: Values) -> Values:
    """Values as a block has them. Joint positions that are all zero were not commanded: joint 4 cannot be there."""
    if name == "message_id":
        return np.rint(values).astype(np.int64) if values.dtype.kind == "f" else values.astype(np.int64)
    if name == "q_c":
        return np.where(np.any(values != 0, axis=1, keepdims=True), values, np.nan)
    return values


def _joined(parts: list[tuple[Floats, dict[str, Values]]]) -> tuple[Floats, dict[str, Values]]:
    if len(parts) == 1:
        return parts[0]
    return np.concatenate([t for t, _ in parts]), {
        name: np.concatenate([columns[name] for _, columns in parts]) for name in parts[0][1]
    }
