"""Logs of runs as columns: numpy arrays that share the memory of the C++ columns."""

from __future__ import annotations

import dataclasses
import math
import os
import pathlib
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from . import _core, _foreign_logs
from ._results import RunResult

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import polars
    import pyarrow  # type: ignore[import-untyped]

_FIRST = -(2**63)
_LAST = 2**63 - 1
_SMALL = 256 << 20  # bytes of a log that is read whole at the first access


class _Source(Protocol):
    """Where tables come from."""

    def read(self, table: str, names: list[str], from_ns: int, until_ns: int) -> _core.LogTable:
        """Returns rows of a table with at least these columns and the time; without names, with all."""
        ...

    def names(self, table: str) -> tuple[str, ...]:
        """Returns the columns that a table has."""
        ...

    def is_small(self, from_ns: int, until_ns: int) -> bool:
        """Returns whether all columns are best read at once."""
        ...


_COLUMNS = {
    table: tuple(column[0] for column in columns) for table, _, _, columns in _core.log_tables()
}


class _File:
    """Tables of a log on disk."""

    def __init__(self, path: pathlib.Path, threads: int, result: RunResult | None) -> None:
        self.file = _core.LogFile(path)
        self._threads = threads
        self._result = result  # its folder may be temporary and must last

    def read(self, table: str, names: list[str], from_ns: int, until_ns: int) -> _core.LogTable:
        return self.file.read(table, names, from_ns, until_ns, self._threads)

    def names(self, table: str) -> tuple[str, ...]:
        return _COLUMNS[table]

    def is_small(self, from_ns: int, until_ns: int) -> bool:
        return self.file.bytes_in(from_ns, until_ns) <= _SMALL


class _Memory:
    """Tables that were made from another program's log."""

    def __init__(self, tables: Mapping[str, _core.LogTable]) -> None:
        self._tables = {table: _core.make_log_table(table, 0, _no_rows(table)) for table in _COLUMNS}
        self._tables.update(tables)

    def read(self, table: str, names: list[str], from_ns: int, until_ns: int) -> _core.LogTable:
        return self._tables[table].between(from_ns, until_ns)

    def names(self, table: str) -> tuple[str, ...]:
        return tuple(self._tables[table].names)

    def is_small(self, from_ns: int, until_ns: int) -> bool:
        return True


def _no_rows(table: str) -> list[tuple[str, bytes, list[str]]]:
    return [(_COLUMNS[table][0], b"", [])]


class Table:
    """Rows of a log as typed columns; values are read when they are asked for.

    ``table["q"]`` is a numpy array: ``(n,)`` of a scalar, ``(n, width)`` of a vector, read-only, sharing
    memory with the column and keeping it alive. A column of names or texts, such as ``fate``, is an
    array of `str`; `codes` has its numbers and `texts` what they number. ``docs/reference/logs.md`` lists
    columns, units and frames.

    A log of up to 256 MB is read whole at the first access. Of a longer one, each access reads the wanted
    columns: name several at once by `load`.
    """

    def __init__(self, source: _Source, name: str, from_ns: int, until_ns: int) -> None:
        self._source = source
        self._name = name
        self._bounds = (from_ns, until_ns)
        self._loaded: _core.LogTable | None = None
        self._texts: dict[str, npt.NDArray[np.object_]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self._source.names(self._name)

    def load(self, *names: str) -> Table:
        """Read columns at once, all without names.

        Returns
        -------
        Table
            This table.
        """
        self._load(names or self.names)
        return self

    def __len__(self) -> int:
        return self._load(self.names[:1]).rows

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return a column.

        Raises
        ------
        ValueError
            For an unknown name, with the nearest one.
        """
        loaded = self._load([name])
        if name in self._texts:
            return self._texts[name]
        values = loaded.array(name)
        texts = loaded.texts(name)
        if not texts:
            return values
        named: npt.NDArray[np.object_] = np.array(texts, dtype=object)[values]
        named.flags.writeable = False
        self._texts[name] = named
        return named

    @property
    def time(self) -> npt.NDArray[np.float64]:
        """Time of each row on the run's clock, shape (n,), s: the first column, which is in ns."""
        return 1e-9 * self[self.names[0]]

    def poses(self, name: str) -> npt.NDArray[np.float64]:
        """Return a column of poses such as ``O_T_EE``, shape (n, 4, 4); the log has their 16 numbers column by column."""
        values = self[name]
        if values.shape[1:] != (16,):
            raise ValueError(f"column {name} has no poses; read it as table[{name!r}]")
        return values.reshape(-1, 4, 4).swapaxes(1, 2)

    def codes(self, name: str) -> npt.NDArray[np.int32]:
        """Return the numbers of a column of texts, shape (n,), without copying."""
        if not self.texts(name):
            raise ValueError(f"column {name} has no texts; read it as table[{name!r}]")
        return self._load([name]).array(name)

    def texts(self, name: str) -> tuple[str, ...]:
        """Return the texts that `codes` number; none of a column of numbers."""
        return tuple(self._load([name]).texts(name))

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """Give all columns to any library that speaks the Arrow PyCapsule interface; nothing is copied
        but columns of bool. Vectors are fixed-size lists, texts dictionaries."""
        del requested_schema  # casting is optional
        return self._whole(()).arrow_stream()

    def to_arrow(self, *names: str) -> pyarrow.Table:
        """Return these columns, all without names, as an Arrow table that shares their memory."""
        import pyarrow

        return pyarrow.table(_Stream(self._whole(names)))

    def to_polars(self, *names: str) -> polars.DataFrame:
        """Return these columns, all without names, as a polars frame; vectors are of type Array."""
        import polars

        return polars.DataFrame(_Stream(self._whole(names)))

    def to_pandas(self, *names: str) -> pandas.DataFrame:
        """Return these columns, all without names, as a pandas frame: a column per element of a vector,
        ``q[0]``, as in the CSV; texts are categories."""
        import pandas

        whole = self._whole(names)
        elements = _foreign_logs.element_names(self._name)
        frame: dict[str, Any] = {}
        for name in whole.names:
            values = whole.array(name)
            texts = whole.texts(name)
            if texts:
                frame[name] = pandas.Categorical.from_codes(list(values), texts)
            elif values.ndim == 1:
                frame[name] = values
            else:
                for i in range(values.shape[1]):
                    frame[elements[name][i] if elements[name] else f"{name}[{i}]"] = values[:, i]
        return pandas.DataFrame(frame, copy=False)

    def _whole(self, names: Sequence[str]) -> _core.LogTable:
        """The chosen columns, all without names, in the table's order."""
        loaded = self._load(names or self.names)
        return loaded.chosen([name for name in self.names if not names or name in names])

    def _load(self, names: Sequence[str]) -> _core.LogTable:
        """What is loaded, which then has these columns."""
        for name in names:
            if name not in self.names:
                _core.check_log_column(self._name, name)
                raise ValueError(f"this log has no column {name} in its {self._name}: {', '.join(self.names)}")
        loaded = self._loaded
        known = set(loaded.names) if loaded else set()
        missing = [name for name in names if name not in known]
        if missing or loaded is None:
            read = self._source.read(
                self._name, [] if self._source.is_small(*self._bounds) else missing, *self._bounds
            )
            loaded = self._loaded = read if loaded is None else loaded.joined(read)
        return loaded

    def __repr__(self) -> str:
        return f"<panda_twin table {self._name}: {len(self)} rows of {len(self.names)} columns>"


class _Stream:
    """A chosen table, for libraries that take an Arrow stream."""

    def __init__(self, table: _core.LogTable) -> None:
        self._table = table

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        del requested_schema
        return self._table.arrow_stream()


@dataclasses.dataclass(frozen=True)
class LogMeta:
    """What a log says of its run."""

    scenario: str
    """Name of the scenario."""
    seed: int
    """Of all random numbers."""
    version: str
    """Of panda-twin."""
    drive: str
    """lockstep, realtime or remote."""
    truncated: bool
    """The run was killed; the log's last part is missing."""
    first: float
    """Time of the first message on the run's clock, s."""
    last: float
    """Time of the last message, s."""


class Log:
    """A log of a run: ``run.mcap``, or the folder of its results.

    Opening reads where things are, not what they are: tables, and of a long log its columns, are read
    when they are asked for.

    Parameters
    ----------
    path
        The log, complete or of a killed run; a folder of results, or the result of `run`.
    threads
        Of reading; all processors by default. No effect on results.

    Raises
    ------
    ValueError
        If it is no log, or damaged: says where.
    """

    def __init__(self, path: str | os.PathLike[str] | RunResult, *, threads: int | None = None) -> None:
        result = path if isinstance(path, RunResult) else None
        path = path.folder if isinstance(path, RunResult) else pathlib.Path(path)
        if path.is_dir():
            path = _core.find_log(path)
        file = _File(path, max(1, min(threads or os.cpu_count() or 1, 64)), result)
        self._open(file, _FIRST, _LAST, path, file.file)

    def _open(
        self,
        source: _Source,
        from_ns: int,
        until_ns: int,
        path: pathlib.Path | None = None,
        file: _core.LogFile | None = None,
    ) -> None:
        self._source = source
        self._bounds = (from_ns, until_ns)
        self._path = path
        self._file = file
        self._tables: dict[str, Table] = {}
        self._pictures: dict[tuple[str | None, tuple[int, int] | None], _core.LogPictures] = {}

    @classmethod
    def _of(cls, source: _Source) -> Log:
        log = cls.__new__(cls)
        log._open(source, _FIRST, _LAST)
        return log

    @classmethod
    def from_panda_py(cls, log: Mapping[str, Sequence[Any]]) -> Log:
        """Make a log of the dictionary that panda_py's ``Panda.get_log()`` returns.

        `cycles` then has its columns by the same names, with ``at_ns`` and ``message_id`` from ``time``.
        """
        return cls._of(_Memory(_foreign_logs.from_panda_py(log)))

    @classmethod
    def from_libfranka_csv(cls, path: str | os.PathLike[str]) -> Log:
        """Make a log of the text that libfranka's ``franka::logToCSV()`` returns, saved as a file.

        Columns ``state.q`` and so on are in `cycles`; ``cmd.q_d`` is ``ticks["q_c"]``, as the log calls
        what was commanded.
        """
        return cls._of(_Memory(_foreign_logs.from_libfranka_csv(pathlib.Path(path))))

    @classmethod
    def from_rosbag2(cls, path: str | os.PathLike[str], topic: str = "/joint_states") -> Log:
        """Make a log of the joint states in a bag of ROS 2: positions, velocities, efforts as `q`, `dq`, `tau_J` of `cycles`.

        Joints are those named joint1 to joint7 after a prefix such as ``panda_``; time counts from the first message's stamp.
        Needs rosbags: pip install 'panda-twin[ros]'.
        """
        return cls._of(_Memory(_foreign_logs.from_rosbag2(pathlib.Path(path), topic)))

    @classmethod
    def from_csv(cls, path: str | os.PathLike[str]) -> Log:
        """Read what ``panda-twin export`` wrote: a folder, or one of its tables such as ``cycles.csv``."""
        return cls._of(_Memory(_foreign_logs.from_csv(pathlib.Path(path))))

    def table(self, name: str) -> Table:
        """Return a table by its name: one of cycles, config, ticks, events, base, contacts, pushes,
        scenes, plans."""
        if name not in _COLUMNS:
            raise ValueError(f"there is no table {name}; choose one of {', '.join(_COLUMNS)}")
        if name not in self._tables:
            self._tables[name] = Table(self._source, name, *self._bounds)
        return self._tables[name]

    @property
    def cycles(self) -> Table:
        """Cycles of the robot's controller: state, fate of the command, errors."""
        return self.table("cycles")

    @property
    def ticks(self) -> Table:
        """Ticks of the workstation: times, targets, commands."""
        return self.table("ticks")

    @property
    def events(self) -> Table:
        """Mode changes, errors, recoveries, steps, as text."""
        return self.table("events")

    @property
    def contacts(self) -> Table:
        """Contact forces and their points at the instants of scenes."""
        return self.table("contacts")

    @property
    def scenario(self) -> str:
        """The scenario's file, YAML; empty for another program's log."""
        return self._file.scenario_yaml if self._file else ""

    @property
    def meta(self) -> LogMeta | None:
        """What the log says of its run; None for another program's log."""
        file = self._file
        if file is None:
            return None
        return LogMeta(
            file.scenario, file.seed, file.version, file.drive, file.truncated, file.first_ns * 1e-9, file.last_ns * 1e-9
        )

    def between(self, t0: float, t1: float) -> Log:
        """Return the part with t0 <= time < t1, s on the run's clock; it reads only that part."""
        if math.isnan(t0) or math.isnan(t1) or t0 > t1:
            raise ValueError(f"t0 is {t0} and t1 {t1}; t0 <= t1 is needed")
        return self._part(_nanoseconds(t0), _nanoseconds(t1))

    def _part(self, from_ns: int, until_ns: int) -> Log:
        part = Log.__new__(Log)
        bounds = max(from_ns, self._bounds[0]), min(until_ns, self._bounds[1])
        part._open(self._source, *bounds, self._path, self._file)
        return part

    @property
    def motions(self) -> tuple[Log, ...]:
        """The parts in which a motion ran: cycles in a row whose ``motion_generator_mode`` is the same
        and not idle."""
        modes = self.cycles.codes("motion_generator_mode")
        times = self.cycles["at_ns"]
        changes = np.flatnonzero(np.diff(modes)) + 1
        starts = [0, *changes.tolist()]
        ends = [*changes.tolist(), len(modes)]
        idle = self.cycles.texts("motion_generator_mode").index("idle")
        return tuple(
            self._part(int(times[start]), int(times[end]) if end < len(times) else int(times[end - 1]) + 1)
            for start, end in zip(starts, ends)
            if start < end and modes[start] != idle
        )

    def picture(
        self, time: float, *, camera: str | None = None, size: tuple[int, int] | None = None
    ) -> npt.NDArray[np.uint8]:
        """Draw the run at an instant, by the twin's own renderer.

        Parameters
        ----------
        time
            s on the run's clock: the first recorded scene at or after it is drawn.
        camera
            A camera of the scene by its name, ``orbit``, ``track:BODY`` or ``gripper``; that of the
            scenario by default.
        size
            Width and height, pixels.

        Returns
        -------
        numpy.ndarray
            Shape (height, width, 3), sRGB, rows from top to bottom, read-only.
        """
        return self._drawn(camera, size).draw(_nanoseconds(time))

    def frames(
        self, fps: float = 25.0, *, camera: str | None = None, size: tuple[int, int] | None = None
    ) -> Iterator[npt.NDArray[np.uint8]]:
        """Draw pictures at equal intervals from the first scene to the last; as `picture`."""
        if not 0 < fps <= 1000:
            raise ValueError(f"fps is {fps}; it must be above 0 and at most 1000")
        pictures = self._drawn(camera, size)
        first = max(pictures.first_ns, self._bounds[0])
        last = min(pictures.last_ns, self._bounds[1] - 1)
        k = 0
        while (time := first + round(k * 1e9 / fps)) <= last:
            yield pictures.draw(time)
            k += 1

    def _drawn(self, camera: str | None, size: tuple[int, int] | None) -> _core.LogPictures:
        if self._path is None:
            raise ValueError("a log of another program has no scenario, so there is nothing to draw")
        if (camera, size) not in self._pictures:
            self._pictures[camera, size] = _core.LogPictures(self._path, camera, size)
        return self._pictures[camera, size]

    def __repr__(self) -> str:
        return f"<panda_twin log {self._path or 'of another program'}>"


def _nanoseconds(time: float) -> int:
    """A time in s as ns, within 64 bits."""
    return max(_FIRST, min(_LAST, round(time * 1e9))) if math.isfinite(time) else (_LAST if time > 0 else _FIRST)
