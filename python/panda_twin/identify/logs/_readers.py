"""Sources of a log: our MCAP, and tables whose columns are known or mapped; each gives canonical columns by chunks."""

from __future__ import annotations

import dataclasses
import pathlib
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..._foreign_logs import _LIBFRANKA_COMMANDS
from ..._log import Log
from ...scenario import Scenario
from ._mapping import FR3, TEXTS, WIDTHS, Column, ColumnMap, resolve, shortened
from ._tables import Table

Values = npt.NDArray[Any]

_SECOND = 10**9
_OTHER_ROBOTS = re.compile(
    r"(?<![a-z])(iiwa|lbr|kuka|ur(3|5|10)e?|xarm\d?|kinova|gen3|sawyer|baxter|yumi)(?![a-z])", re.IGNORECASE
)
_LIBFRANKA = {**_LIBFRANKA_COMMANDS, "cmd.tau_J_d": "tau_J_c"}
_COMMANDS = {"q_c": "q_c", "dq_c": "dq_c", "tau_J_c": "tau_J_d"}  # column: of our table of ticks


@dataclasses.dataclass(frozen=True)
class Chunk:
    """Some rows in the order of the file; stamps are "time", in the source's `time_unit`."""

    first_row: int
    values: dict[str, Values]


class Source(Protocol):
    """A log, opened."""

    kind: str
    columns: frozenset[str]
    has_time: bool
    time_unit: float  # s
    notes: list[str]

    @property
    def scenario(self) -> Scenario | None:
        """Of a log of the twin."""
        ...

    def chunks(self, names: Sequence[str]) -> Iterator[Chunk]:
        """Yield these columns, of which "time" is one, chunk by chunk."""
        ...


class TableSource:
    """A table of which one knows where the canonical columns are."""

    scenario: Scenario | None = None

    def __init__(self, kind: str, table: Table, columns: Mapping[str, Column], row: str = "row") -> None:
        self.kind = kind
        self._table = table
        self._places = dict(columns)
        self.columns = frozenset(columns) - {"time"}
        self.has_time = "time" in columns
        self.time_unit = columns["time"].factor if self.has_time else 1.0
        self.notes = table.notes

    def chunks(self, names: Sequence[str]) -> Iterator[Chunk]:
        places = sorted({place for name in names for place in self._places[name].places})
        row = 1
        for block in self._table.blocks(places):
            values = {name: self._canonical(name, block) for name in names}
            rows = len(next(iter(block.values())))
            yield Chunk(row, values)
            row += rows

    def _canonical(self, name: str, block: dict[int, Values]) -> Values:
        column = self._places[name]
        parts = [block[place] for place in column.places]
        if name == "time":
            return parts[0].reshape(-1)
        if name == "message_id":
            return parts[0].reshape(-1)
        if len(parts) > 1:
            values = np.stack([np.asarray(part, np.float64) for part in parts], axis=1)
        else:
            values = np.asarray(parts[0], np.float64)
        if column.factor != 1:
            if WIDTHS[name] == 16:  # a unit of length is that of the position
                values = values.copy()
                values[:, 12:15] *= column.factor
            else:
                values = values * column.factor
        return values.reshape(-1) if WIDTHS[name] == 1 else values.reshape(-1, WIDTHS[name])


def mapped(table: Table, mapping: ColumnMap) -> TableSource:
    """A table by a mapping."""
    columns = resolve(mapping, table.file, table.names, table.vectors)
    for name in columns:
        if name in TEXTS:
            raise ValueError(
                f"{table.file}: {name} is of texts, which only the twin's own logs have; leave it out of the mapping"
            )
    used = [table.names[place] for column in columns.values() for place in column.places]
    if other := next((name for name in used if _OTHER_ROBOTS.search(name)), None):
        raise ValueError(f"{table.file}: column {other} is named after another robot; only logs of a Panda can be compared")
    if mapping.robot == "fr3" or any("fr3" in name.lower() for name in used):
        table.notes.append(FR3)
    return TableSource("table", table, columns)


def is_libfranka(table: Table) -> bool:
    """Whether a CSV has the heading of libfranka's logToCSV()."""
    return table.names[:2] in (["time", "success_rate"], ["duration", "success_rate"])


def libfranka(table: Table) -> TableSource:
    """The CSV of libfranka's logToCSV(), whose time is the robot's, in ms.

    A row has a state and the command that was sent before it came, so that the command is the newest that the state may show.
    """
    places: dict[str, list[int]] = {}
    for place, name in enumerate(table.names):
        places.setdefault(name.partition("[")[0], []).append(place)
    columns = {"message_id": Column((0,), 1.0), "control_command_success_rate": Column((1,), 1.0)}
    for name, found in list(places.items())[2:]:
        column = _LIBFRANKA.get(name, name.removeprefix("state."))
        if column == name or column not in WIDTHS:
            raise ValueError(f"{table.file}: column {name} is not one of libfranka's logToCSV(); give a column mapping")
        if len(found) != WIDTHS[column]:
            raise ValueError(
                f"{table.file}: {name} has {len(found)} of {WIDTHS[column]} columns; write the log anew with logToCSV()"
            )
        columns[column] = Column(tuple(found), 1.0)
    return TableSource("libfranka", table, columns)


def is_panda_py(table: Table) -> bool:
    """Whether arrays are those of panda_py's get_log(): "time" in whole ms beside columns of the robot's state."""
    return (
        "time" in table.names
        and "q" in table.names
        and {"tau_J", "O_T_EE", "control_command_success_rate", "tau_ext_hat_filtered"} & set(table.names) != set()
    )


def panda_py(table: Table) -> TableSource:
    """What panda_py's get_log() returned, whose time is the robot's, in ms."""
    columns = {"message_id": Column((table.names.index("time"),), 1.0)}
    for place, name in enumerate(table.names):
        if name in WIDTHS and name not in TEXTS and name != "message_id":
            if (has := table.vectors.get(name, 1)) != WIDTHS[name]:
                raise ValueError(
                    f"{table.file}: {name} has {has} of {WIDTHS[name]} numbers in a row; give what panda_py's get_log() returns"
                )
            columns[name] = Column((place,), 1.0)
    first = next(table.blocks([columns["message_id"].places[0]]), None)
    if first is None:
        raise ValueError(f"{table.file} has columns ({shortened(table.names)}) and no row")
    times = np.asarray(next(iter(first.values())), np.float64)
    if not np.all((times == np.rint(times)) | np.isnan(times)):
        raise ValueError(f"{table.file}: time is not in whole ms, as panda_py's get_log() has it; name its unit by a mapping: "
                         "columns: {time: {from: time, unit: s}, q: q, tau_J: tau_J}")  # fmt: skip
    return TableSource("panda-py", table, columns)


class OwnLog:
    """A run.mcap of the twin, by intervals."""

    kind = "panda-twin"
    has_time = True
    time_unit = 1e-9

    def __init__(self, path: pathlib.Path) -> None:
        self._log = Log(path, threads=1)
        self.path = path
        meta = self._log.meta
        assert meta is not None
        self._from, self._until = round(meta.first * 1e9) - 1, round(meta.last * 1e9) + 2
        self.notes: list[str] = []
        if meta.truncated:
            self.notes.append("the run was killed, so the log's last part is missing")
        self._step = self._interval()
        commanded = any(len(ticks) for _, ticks in zip(range(3), self._ticks(["action"])))
        self.columns = frozenset(WIDTHS) - (frozenset() if commanded else frozenset(_COMMANDS))
        self.scenario = self._scenario()

    def _scenario(self) -> Scenario | None:
        text = self._log.scenario
        if not text:
            return None
        try:
            return Scenario.from_yaml(text, self.path)
        except ValueError as error:
            self.notes.append(f"the log's scenario cannot be read by this version: {error}")
            return None

    def _interval(self) -> int:
        """Time of which about 16 MB of the file are, ns."""
        size = max(1, int(self._log._source.file.bytes_in(self._from, self._until)))  # type: ignore[attr-defined]
        return max(_SECOND, (self._until - self._from) * (16 << 20) // size)

    def _ticks(self, names: list[str]) -> Iterator[Values]:
        for begin in range(self._from, self._until, self._step):
            yield self._log._source.read("ticks", names, begin, min(begin + self._step, self._until)).array("read_ns")

    def chunks(self, names: Sequence[str]) -> Iterator[Chunk]:
        row = 1
        commands = [name for name in names if name in _COMMANDS]
        own = [name for name in names if name not in _COMMANDS and name != "time"]
        for begin in range(self._from, self._until, self._step):
            end = min(begin + self._step, self._until)
            table = self._log._source.read("cycles", [*own, *(["message_id"] if commands else [])], begin, end)
            if table.rows == 0:
                continue
            values: dict[str, Values] = {"time": table.array("at_ns")} if "time" in names else {}
            for name in own:
                array = table.array(name)
                texts = table.texts(name)
                values[name] = np.array(texts, dtype=object)[array] if texts else array
            if commands:
                values |= self._commands(commands, table.array("message_id"), begin, end)
            yield Chunk(row, values)
            row += table.rows

    def _commands(self, names: Sequence[str], ids: Values, begin: int, end: int) -> dict[str, Values]:
        """Of each cycle the command that answers the state before it; NaN where none was written."""
        ticks = self._log._source.read(
            "ticks", [*(_COMMANDS[name] for name in names), "action", "command_message_id"], begin - _SECOND, end + _SECOND
        )
        texts = ticks.texts("action")
        wrote = np.isin(
            ticks.array("action"), [texts.index(text) for text in ("written", "finished", "limited") if text in texts]
        )
        answered = ticks.array("command_message_id")
        wrote &= answered > 0
        order = np.flatnonzero(wrote)[np.argsort(answered[wrote], kind="stable")]
        place = np.searchsorted(answered[order], ids - 1)
        there = place < len(order)
        there[there] = answered[order][place[there]] == ids[there] - 1
        result = {}
        for name in names:
            values = np.full((len(ids), 7), np.nan)
            values[there] = ticks.array(_COMMANDS[name])[order][place[there]]
            result[name] = values
        return result
