"""Bags of ROS 2: the state of an arm, with what other topics say at the same time."""

from __future__ import annotations

import contextlib
import dataclasses
import pathlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._foreign_logs import import_rosbags
from ...scenario import Scenario
from . import _ros
from ._cdr import Messages, layout
from ._mapping import FR3, TEXTS, WIDTHS, shortened
from ._readers import Chunk

Values = npt.NDArray[Any]

_BATCH = 4096  # messages of the arm's topic that are read at once
_HELD_BACK = 100_000_000  # ns; messages may come in another order of stamps by so much
_KEPT = 128 << 20  # bytes of values that are kept when a bag is small


@dataclasses.dataclass
class _Topic:
    """A topic that is read, and what of it is not yet given out."""

    connections: list[Any]
    read: Callable[[Any, Any], dict[str, Values]]
    columns: dict[str, int]
    messages: Messages
    raw: list[bytes] = dataclasses.field(default_factory=list)
    times: list[int] = dataclasses.field(default_factory=list)
    at: Values = dataclasses.field(default_factory=lambda: np.zeros(0, np.int64))
    values: dict[str, Values] = dataclasses.field(default_factory=dict)

    @property
    def name(self) -> str:
        return str(self.connections[0].topic)

    def decode(self) -> int:
        """Turn raw messages into rows, sorted by stamps. Returns how many were out of order."""
        if not self.raw:
            return 0
        at, values = _ros.read_all(self.messages, self.raw, self.times, self.read)
        self.raw, self.times = [], []
        rows = len(at)
        for name, width in self.columns.items():
            if name not in values:
                empty = np.full(
                    (rows, width) if width > 1 else rows, "" if name in TEXTS else np.nan, object if name in TEXTS else np.float64
                )
                values[name] = empty
        if len(self.at):
            at = np.concatenate([self.at, at])
            values = {name: np.concatenate([self.values[name], values[name]]) for name in self.columns}
        late = int(np.count_nonzero(np.diff(at) < 0))
        order = np.argsort(at, kind="stable") if late else slice(None)
        self.at, self.values = at[order], {name: values[name][order] for name in self.columns}
        return late

    def nearest(self, at: Values) -> dict[str, Values]:
        """Rows whose stamps are nearest."""
        after = np.clip(np.searchsorted(self.at, at), 0, len(self.at) - 1)
        before = np.maximum(after - 1, 0)
        place = np.where(at - self.at[before] < self.at[after] - at, before, after)
        return {name: values[place] for name, values in self.values.items()}

    def drop(self, rows: int) -> None:
        """Forget rows."""
        self.at, self.values = self.at[rows:], {name: values[rows:] for name, values in self.values.items()}


class Bag:
    """A bag, read by rosbags."""

    kind = "rosbag2"
    has_time = True
    time_unit = 1e-9
    scenario: Scenario | None = None

    def __init__(self, path: pathlib.Path) -> None:
        self.path = path
        self.notes: list[str] = []
        self.reordered = 0
        self._rosbags = import_rosbags()
        self._kept: list[dict[str, Values]] | None = None
        with self._opened() as reader:
            self._chosen = self._choose(reader)
            self._main_columns = self._chosen[0].columns
            self.columns = frozenset(name for topic in self._chosen for name in topic.columns)
            rows = sum(one.msgcount for one in self._chosen[0].connections)
        if rows * 8 * sum(WIDTHS[name] for name in self.columns) <= _KEPT:
            self._kept = list(self._read(sorted(self.columns)))

    @contextlib.contextmanager
    def _opened(self) -> Iterator[Any]:
        rosbags = self._rosbags
        try:
            store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.ROS2_JAZZY)
            with rosbags.highlevel.AnyReader([self.path], default_typestore=store) as reader:
                yield reader
        except (OSError, _ros.WrongRobot, _Said):
            raise
        except Exception as error:  # the library's own, and what damaged bytes make of it
            text = " ".join(str(error).split())[:200] or type(error).__name__
            raise ValueError(
                f"{self.path} is a damaged bag of ROS 2, such as one whose recording was cut ({text}); try ros2 bag reindex, "
                f"or mcap recover"
            ) from None

    def _choose(self, reader: Any) -> list[_Topic]:
        """The topic of the arm's state first, then those that add columns."""
        topics: dict[str, list[Any]] = {}
        for one in reader.connections:
            topics.setdefault(one.topic, []).append(one)
        self._robots: set[str] = set()
        refused: list[str] = []
        found: list[tuple[tuple[bool, bool, bool, int], _Topic]] = []
        for connections in topics.values():
            try:
                if topic := self._topic(reader, connections):
                    state = connections[0].msgtype in _ros.STATES
                    rank = state, "q" in topic.columns, "tau_J" in topic.columns, sum(one.msgcount for one in connections)
                    found.append((rank, topic))
            except _ros.WrongRobot as error:
                refused.append(f"{connections[0].topic} {error}")
        found.sort(key=lambda one: one[0], reverse=True)
        if not found or "q" not in found[0][1].columns:
            there = shortened(sorted(f"{name} ({connections[0].msgtype})" for name, connections in topics.items()))
            reason = f": {'; '.join(refused)}" if refused else ", which FrankaRobotState and JointState hold"
            raise _Said(f"{self.path} has no joint positions of a Panda{reason}; its topics are {there}")
        chosen = [found[0][1]]
        have = set(chosen[0].columns)
        for _, topic in found[1:]:
            if new := {name: width for name, width in topic.columns.items() if name not in have and name != "message_id"}:
                topic.columns = new
                chosen.append(topic)
                have |= new.keys()
            else:
                self.notes.append(f"{topic.name} is not read: {chosen[0].name} says the same")
        self._note_sides(chosen)
        self.notes += [f"{text}; it is not read" for text in refused]
        if any("fr3" in prefix for prefix in self._robots):
            self.notes.append(f"joints are called fr3_joint1 and so on: {FR3}")
        return chosen

    def _note_sides(self, chosen: list[_Topic]) -> None:
        rows = [sum(one.msgcount for one in topic.connections) for topic in chosen]
        for topic, count in zip(chosen[1:], rows[1:]):
            if count < 0.9 * rows[0]:
                self.notes.append(
                    f"{', '.join(topic.columns)} of {topic.name}: {count} messages for {rows[0]} rows, so that each row has "
                    f"the nearest in time"
                )

    def _topic(self, reader: Any, connections: list[Any]) -> _Topic | None:
        """A topic that says something of the arm; None for others."""
        kind, name = connections[0].msgtype, connections[0].topic
        if not (kind in _ros.STATES or kind in (_ros.JOINTS, _ros.WRENCH, _ros.POSE)):
            return None
        if (first := next(iter(reader.messages(connections)), None)) is None:
            return None
        types = reader.typestore.fielddefs
        if kind not in types:
            self.notes.append(f"{name} is not read: the bag does not say what {kind} is; record it as MCAP, which does")
            return None
        one = layout(bytes(first[2]), kind, types)
        read = self._reading(name, kind, one)
        if read is None:
            return None
        for field, names in one.texts.items():
            if field in ("name", "measured_joint_state.name"):
                self._robots.add(_ros.arm_of(names)[1])
        values = read(one, np.frombuffer(bytes(first[2]), np.uint8).reshape(1, -1))
        columns = {column: WIDTHS[column] for column in values}
        return _Topic(connections, read, columns, Messages(kind, types)) if columns else None

    def _reading(self, name: str, kind: str, first: Any) -> Callable[[Any, Any], dict[str, Values]] | None:
        """How a topic is read, by its type and name."""
        if kind in _ros.STATES:
            return _ros.franka_state
        if kind == _ros.JOINTS:
            if "command" in name:
                return None
            return _ros.joint_states("desired" if "desired" in name else "external" if "external" in name else "measured")
        frame = first.texts.get("header.frame_id", ("",))[0]
        if kind == _ros.POSE:
            column = "O_T_EE" if name.endswith("current_pose") else "O_T_EE_d" if "desired_pose" in name else ""
            return _ros.poses(column) if column else None
        if "base_frame" in name or "O_F_ext" in name or frame.endswith("link0"):
            return _ros.wrenches("O_F_ext_hat_K")
        if "stiffness_frame" in name or "K_F_ext" in name or frame.endswith("_K"):
            return _ros.wrenches("K_F_ext_hat_K")
        self.notes.append(
            f"{name} is not read: its frame {frame or '(none)'} is neither the base nor the stiffness frame of the arm"
        )
        return None

    def chunks(self, names: Sequence[str]) -> Iterator[Chunk]:
        row = 1
        for values in self._read(names) if self._kept is None else self._kept:
            yield Chunk(row, {name: values[name] for name in names})
            row += len(values["time"])

    def _read(self, names: Sequence[str]) -> Iterator[dict[str, Values]]:
        """Rows with time and at least these columns."""
        self.reordered = 0
        with self._opened() as reader:
            main, *others = (
                dataclasses.replace(topic, raw=[], times=[], at=np.zeros(0, np.int64), values={}) for topic in self._chosen
            )
            others = [topic for topic in others if topic.columns.keys() & set(names)]
            by_topic = {topic.name: topic for topic in (main, *others)}
            for connection, time, data in reader.messages([one for one in reader.connections if one.topic in by_topic]):
                topic = by_topic[connection.topic]
                topic.raw.append(bytes(data))
                topic.times.append(time)
                if len(topic.raw) >= (_BATCH if topic is main else 4 * _BATCH):
                    yield from self._given(main, others, False)
            yield from self._given(main, others, True)

    def _given(self, main: _Topic, others: Sequence[_Topic], last: bool) -> Iterator[dict[str, Values]]:
        """Decode what there is, and give out all rows, or those of which all is known."""
        self.reordered += main.decode()
        for topic in others:
            topic.decode()
        rows = len(main.at) if last else int(np.searchsorted(main.at, main.at[-1] - _HELD_BACK)) if len(main.at) else 0
        if rows == 0:
            return
        at = main.at[:rows]
        values = {"time": at, **{name: array[:rows] for name, array in main.values.items()}}
        for topic in others:
            if not len(topic.at):
                raise _Said(f"{self.path}: {topic.name} begins later than 4 s behind {main.name}; cut the bag to where both are")
            values |= topic.nearest(at)
            topic.drop(max(0, int(np.searchsorted(topic.at, at[-1])) - 2))
        main.drop(rows)
        yield values


class _Said(ValueError):
    """A sentence of ours, which is not the bag's damage."""
