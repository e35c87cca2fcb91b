"""Logs of other programs, and our own CSV, as tables of the same columns."""

from __future__ import annotations

import csv
import pathlib
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core

_TYPES: dict[str, Any] = {
    "float64": np.float64,
    "int64": np.int64,
    "uint64": np.uint64,
    "uint32": np.uint32,
    "bool": np.bool_,
    "text": np.int32,
}
_TABLES = {
    table: {name: (kind, is_vector, elements) for name, kind, is_vector, _, _, elements in columns}
    for table, _, _, columns in _core.log_tables()
}


def element_names(table: str) -> dict[str, list[str]]:
    """Returns the names of the values of each column; empty where the log decides how many there are."""
    return {name: elements for name, (_, _, elements) in _TABLES[table].items()}


def _number(table: str, name: str, values: npt.ArrayLike) -> tuple[str, bytes, list[str]]:
    kind = _TYPES[_TABLES[table][name][0]]
    return name, np.ascontiguousarray(values, dtype=kind).tobytes(), []


def _make(table: str, rows: int, columns: list[tuple[str, bytes, list[str]]]) -> _core.LogTable:
    times = np.frombuffer(columns[0][1], dtype=np.int64)
    if np.any(np.diff(times) < 0):
        row = int(np.flatnonzero(np.diff(times) < 0)[0]) + 1
        raise ValueError(f"time goes back in row {row} of {table}, from {times[row - 1]} to {times[row]} ns")
    return _core.make_log_table(table, rows, columns)


def from_panda_py(log: Mapping[str, Sequence[Any]]) -> dict[str, _core.LogTable]:
    if "time" not in log:
        raise ValueError(f"the log has no 'time', but {', '.join(log)}; give what panda_py's get_log() returns")
    milliseconds = np.asarray(log["time"], dtype=np.float64).reshape(-1)
    columns = [
        _number("cycles", "at_ns", np.rint(milliseconds * 1e6)),
        _number("cycles", "message_id", np.rint(milliseconds)),
    ]
    for name, values in log.items():
        if name == "time":
            continue
        _core.check_log_column("cycles", name)
        width = len(_TABLES["cycles"][name][2])
        array = np.asarray(values, dtype=np.float64).reshape(len(values), -1)
        if array.shape != (len(milliseconds), width):
            raise ValueError(f"{name} has shape {array.shape}; it must have {(len(milliseconds), width)}")
        columns.append(_number("cycles", name, array))
    return {"cycles": _make("cycles", len(milliseconds), columns)}


_LIBFRANKA_COMMANDS = {
    "cmd.q_d": "q_c",
    "cmd.dq_d": "dq_c",
    "cmd.O_T_EE_d": "O_T_EE_c",
    "cmd.O_dP_EE_d": "O_dP_EE_c",
    "cmd.tau_J_d": "tau_J_d",
}


def from_libfranka_csv(path: pathlib.Path) -> dict[str, _core.LogTable]:
    heading, rows = _read(path)
    if heading[:2] != ["time", "success_rate"]:
        raise ValueError(f"{path} is no log of libfranka's logToCSV(): its first columns are not time, success_rate")
    values = _floats(path, heading, rows)
    places: dict[str, list[int]] = {}
    for i, name in enumerate(heading):
        places.setdefault(name.partition("[")[0], []).append(i)
    milliseconds = values[:, 0]
    cycles = [
        _number("cycles", "at_ns", np.rint(milliseconds * 1e6)),
        _number("cycles", "message_id", np.rint(milliseconds)),
        _number("cycles", "control_command_success_rate", values[:, 1]),
    ]
    ticks = [
        _number("ticks", "read_ns", np.rint(milliseconds * 1e6)),
        _number("ticks", "message_id", np.rint(milliseconds)),
    ]
    for name, columns in places.items():
        if name.startswith("state."):
            cycles.append(_number("cycles", name.removeprefix("state."), values[:, columns]))
        elif name in _LIBFRANKA_COMMANDS:
            ticks.append(_number("ticks", _LIBFRANKA_COMMANDS[name], values[:, columns]))
        elif name not in ("time", "success_rate"):
            raise ValueError(f"{path}: column {name} is not one of libfranka's logToCSV()")
    return {"cycles": _make("cycles", len(rows), cycles), "ticks": _make("ticks", len(rows), ticks)}


def import_rosbags() -> Any:
    """The package rosbags. Raises ImportError saying what to install."""
    try:
        import rosbags.highlevel
        import rosbags.rosbag2
        import rosbags.typesys
    except ImportError as error:
        raise ImportError(f"a bag of ROS 2 needs rosbags ({error}): pip install 'panda-twin[ros]'") from None
    return rosbags


def from_rosbag2(path: pathlib.Path, topic: str) -> dict[str, _core.LogTable]:
    times: list[int] = []
    rows: dict[str, list[npt.ArrayLike]] = {"q": [], "dq": [], "tau_J": []}
    rosbags = import_rosbags()
    try:
        store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.ROS2_JAZZY)
        with rosbags.highlevel.AnyReader([path], default_typestore=store) as reader:
            wanted = [one for one in reader.connections if one.topic == topic and one.msgtype == "sensor_msgs/msg/JointState"]
            for connection, _, data in reader.messages(wanted) if wanted else ():
                message = reader.deserialize(data, connection.msgtype)
                if not (joints := _arm_of(message.name)):
                    continue  # of a gripper, which has messages of its own
                times.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)
                for name, values in (("q", message.position), ("dq", message.velocity), ("tau_J", message.effort)):
                    rows[name].append(values[joints] if len(values) == len(message.name) else np.full(7, np.nan))
            there = sorted({f"{one.topic} ({one.msgtype})" for one in reader.connections})
    except OSError:
        raise
    except Exception as error:  # the library's own, and what damaged bytes make of it
        raise ValueError(f"{path} is no bag of ROS 2: {error}") from None
    if not times:
        raise ValueError(f"{path} has no joint states of an arm on {topic}; its topics are {', '.join(there)}")
    at = np.asarray(times) - times[0]
    table = [_number("cycles", "at_ns", at), _number("cycles", "message_id", np.rint(at / 1e6))]
    table += [_number("cycles", name, np.asarray(values)) for name, values in rows.items()]
    return {"cycles": _make("cycles", len(times), table)}


def _arm_of(names: list[str]) -> list[int]:
    """Places of the joints 1 to 7, such as panda_joint1; empty unless all are there."""
    places = {match[1]: i for i, name in enumerate(names) if (match := re.fullmatch(r"(?:.*_)?joint([1-7])", name)) and "finger" not in name}
    return [places[number] for number in "1234567"] if len(places) == 7 else []


def from_csv(path: pathlib.Path) -> dict[str, _core.LogTable]:
    if path.is_dir():
        files = [path / f"{table}.csv" for table in _TABLES if (path / f"{table}.csv").is_file()]
        if not files:
            raise ValueError(f"{path} has no table of a log, such as cycles.csv; name what panda-twin export wrote")
    else:
        files = [path]
    return {file.stem: _table_of(file) for file in files}


def _table_of(file: pathlib.Path) -> _core.LogTable:
    table = file.stem
    if table not in _TABLES:
        raise ValueError(f"{file} is not named like a table of a log: one of {', '.join(_TABLES)}")
    heading, rows = _read(file)
    columns: list[tuple[str, bytes, list[str]]] = []
    place = 0
    while place < len(heading):
        name, count = _column_at(table, heading, place)
        if not columns and name != next(iter(_TABLES[table])):
            raise ValueError(f"{file} begins with column {name}, not with the time {next(iter(_TABLES[table]))}")
        kind = _TABLES[table][name][0]
        if kind == "text":
            texts: dict[str, int] = {"": 0}
            codes = [texts.setdefault(row[place], len(texts)) for row in rows]
            columns.append((name, np.asarray(codes, dtype=np.int32).tobytes(), list(texts)))
        elif kind == "float64":
            part = [[value or "nan" for value in row[place : place + count]] for row in rows]
            columns.append(_number(table, name, _floats(file, heading[place : place + count], part)))
        else:
            columns.append(_number(table, name, _integers(file, name, [row[place] for row in rows])))
        place += count
    return _make(table, len(rows), columns)


def _column_at(table: str, heading: list[str], place: int) -> tuple[str, int]:
    """Returns the column that begins at a place of the heading, and how many places it takes."""
    for name, (_, _, elements) in _TABLES[table].items():
        count = len(elements)
        if elements and heading[place : place + count] == elements:
            return name, count
    name = heading[place].partition("[")[0]
    if name in _TABLES[table] and not _TABLES[table][name][2]:  # the log decides
        count = sum(1 for other in heading[place:] if other.partition("[")[0] == name)
        return name, count
    _core.check_log_column(table, name)
    raise ValueError(f"column {name} of {table} is not whole: its columns are {', '.join(_TABLES[table][name][2])}")


def _read(path: pathlib.Path) -> tuple[list[str], list[list[str]]]:
    with open(path, newline="", encoding="utf-8") as file:
        try:
            heading = [name.strip() for name in next(csv.reader([file.readline()]), [])]
            rows = list(csv.reader(file))
        except (UnicodeDecodeError, csv.Error) as error:
            raise ValueError(f"{path} is not a CSV file: {error}") from error
    for number, row in enumerate(rows, start=2):
        if len(row) != len(heading):
            raise ValueError(f"{path}: record {number} has {len(row)} values; its heading has {len(heading)}")
    return heading, rows


def _floats(path: pathlib.Path, names: list[str], rows: list[list[str]]) -> npt.NDArray[np.float64]:
    try:
        return np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    except ValueError as error:
        raise ValueError(f"{path}: {error}, in {names[0]}") from error


def _integers(path: pathlib.Path, name: str, values: list[str]) -> list[int]:
    try:
        return [int(value) for value in values]
    except ValueError as error:
        raise ValueError(f"{path}: {error}, in {name}") from error
