"""What the twin makes of a log: its commands through INT and plant, its measurements through INT's observer."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _core
from .._log import Log

if TYPE_CHECKING:
    from ..scenario import Scenario
    from ._recording import Recording

Floats: TypeAlias = npt.NDArray[np.float64]
Values: TypeAlias = npt.NDArray[Any]

_COMMAND = {"q_c": slice(0, 7), "dq_c": slice(7, 14), "tau_J_d": slice(14, 21), "O_T_EE_c": slice(21, 37), "O_dP_EE_c": slice(37, 43),
            "elbow_c": slice(43, 45), "valid_elbow": slice(45, 46), "motion_generation_finished": slice(46, 47)}  # fmt: skip
_STATE = {"q": slice(0, 7), "dq": slice(7, 14), "tau_J": slice(14, 21), "q_d": slice(21, 28), "dq_d": slice(28, 35),
          "tau_ext_hat_filtered": slice(35, 42), "O_F_ext_hat_K": slice(42, 48)}  # fmt: skip
_START, _STOP, _RECOVER = 1, 2, 3  # requests
_MOVE, _REFLEX, _RECOVERY = 2, 4, 6  # robot_mode
_SERVED = 1  # fate
_MODES = np.array(["Other", "Idle", "Move", "Guiding", "Reflex", "User stopped", "Automatic error recovery"], object)
_FATES = np.array(["none", "served", "held"], object)
_ERRORS = _core.error_names()

_T = 1e-3  # s, a cycle
_LEAD = 200  # cycles at rest before the first row of a robot's log
_LOST = 20  # cycles without a command that end a motion
_SAME = 1e-10  # rad: a reference that follows its command, or holds its acceleration
_AT_REST = 0.02  # rad/s


@dataclasses.dataclass
class _Cycles:
    """Cycles after each other, with what is given to the robot for each."""

    ids: npt.NDArray[np.int64]
    logged: npt.NDArray[np.bool_]
    """Whether the log has a row of the cycle."""
    requests: npt.NDArray[np.uint8]
    """(n, 3): request, motion generator mode, controller mode."""
    present: npt.NDArray[np.bool_]
    commands: Floats

    @classmethod
    def none(cls, begin: int, end: int) -> _Cycles:
        """Cycles begin, ..., end - 1, of which the log has none."""
        n = max(0, end - begin)
        return cls(np.arange(begin, begin + n), np.zeros(n, bool), np.zeros((n, 3), np.uint8), np.zeros(n, bool), np.zeros((n, 47)))


def replay(log: Recording | Log, scenario: Scenario, *, cycles_of_delay: int = 0) -> Iterator[dict[str, Values]]:
    """Give a log's commands to the INT and plant of a scenario, cycle by cycle, without workstation and link.

    A lockstep log of the twin under its own scenario gives its states to the bit: what was requested and served in which cycle is in
    the log. The arm begins where the log's first q_d is (q, where there is none), with the log's seed.

    Of a robot's log:

    - The commands are tau_J_c (torques, with dq_c where the log has it), else q_c, else dq_c, else q_d: INT's own reference, which
      then is commanded as joint positions. The latter is right for Cartesian motions as well.
    - A row's command is that of its cycle. The motion begins with the first one; it ends by a stop where 20 cycles have none.
    - A command counts as lost, so that the twin holds its acceleration, where the robot's q_d is not q_c to 1e-10 rad although it is
      in most rows; and in rows that are not in the log if q_d says that the robot held its acceleration there. Other rows that are
      not in the log take commands from a cubic through their neighbours (torques: a line).
    - The arm rests for 200 cycles before the first row.

    Parameters
    ----------
    log : Recording or Log
        The log, which is read in blocks.
    scenario : Scenario
        The twin.
    cycles_of_delay : int
        By how many cycles commands come later than in the log.

    Yields
    ------
    dict of str to ndarray
        Of each of the log's rows, in their order: message_id (of a robot's log: its cycle since the first row), fate,
        robot_mode, errors (as in the log), q, dq, tau_J, q_d, dq_d, tau_ext_hat_filtered, O_F_ext_hat_K.

    Raises
    ------
    ValueError
        For a log without q, or one that begins in a motion.
    """
    if not 0 <= cycles_of_delay < 1000:
        raise ValueError(f"cycles_of_delay is {cycles_of_delay}; it must be from 0 to 999")
    own = _own_file(log)
    if own is not None:
        seed, first, cycles = own.seed, _own_start(own), _own_cycles(own)
    elif isinstance(log, Log):
        raise ValueError("the log has no commands of the twin's own; open it by Recording.open()")
    else:
        seed, first, cycles = scenario.seed, _start(log), _cycles(log, cycles_of_delay)
        cycles_of_delay = 0  # is in
    twin = _core.CommandReplay(scenario._loaded, seed, first.tolist())
    shift = _Shift(cycles_of_delay)
    for block in cycles:
        if len(block.ids) == 0:
            continue
        n = len(block.ids)
        states, codes = np.empty((n, 48)), np.empty((n, 4), np.uint64)
        twin.advance(block.requests, np.ascontiguousarray(shift(block.present)), np.ascontiguousarray(shift(block.commands)), states, codes)
        if block.logged.any():
            yield _named(block.ids[block.logged], states[block.logged], codes[block.logged])


def can_replay(recording: Recording) -> bool:
    """Whether a log has what `replay` needs: q, commands or q_d, and a begin at rest."""
    if "q" not in recording.columns or not recording.columns & {interface.column for interface in _INTERFACES}:
        return False
    if _own_file(recording) is not None:
        return True
    try:
        _start(recording)
    except ValueError:
        return False
    return True


def _named(ids: npt.NDArray[np.int64], states: Floats, codes: npt.NDArray[np.uint64]) -> dict[str, Values]:
    result: dict[str, Values] = {"message_id": ids, "fate": _FATES[codes[:, 3].astype(int)], "robot_mode": _MODES[codes[:, 2].astype(int)]}
    sets, places = np.unique(codes[:, 1], return_inverse=True)
    texts = ["|".join(name for bit, name in enumerate(_ERRORS) if int(errors) >> bit & 1) for errors in sets]
    result["errors"] = np.array(texts, object)[places.reshape(-1)]
    return result | {name: states[:, place] for name, place in _STATE.items()}


class _Shift:
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


# Logs of the twin


def _own_file(log: Recording | Log) -> _core.LogFile | None:
    """The file of a log of the twin that has ticks."""
    source: Any = log if isinstance(log, Log) else log._source
    if not isinstance(log, Log) and log.kind != "panda-twin":
        return None
    file = getattr(getattr(source, "_log", source)._source, "file", None)
    if file is None or not isinstance(file, _core.LogFile):
        return None
    return file if file.read("ticks", ["message_id"], file.first_ns, file.first_ns + 3 * 10**9, 1).rows else None


def _own_start(file: _core.LogFile) -> Floats:
    end = file.first_ns + 10**8
    table = file.read("cycles", ["q_d"], file.first_ns - 1, end, 1)
    if table.rows == 0:
        raise ValueError("the log has no cycle in its first 0.1 s")
    first: Floats = table.array("q_d")[0]
    return first


def _own_cycles(file: _core.LogFile) -> Iterator[_Cycles]:
    step = max(10**9, (file.last_ns - file.first_ns) * (16 << 20) // max(1, file.bytes_in(file.first_ns - 1, file.last_ns + 1)))
    next_id, mode = 1, 0
    stops = _own_stops(file)
    for begin in range(file.first_ns - 1, file.last_ns + 1, step):
        table = file.read("cycles", ["message_id", "fate", "robot_mode", "motion_generator_mode", "controller_mode"], begin, begin + step, 1)
        if table.rows == 0:
            continue
        ids = table.array("message_id").astype(np.int64)
        cycles = _Cycles.none(next_id, int(ids[-1]) + 1)
        at = ids - next_id
        next_id = int(ids[-1]) + 1
        cycles.logged[at] = True
        modes = table.array("robot_mode")
        before = np.concatenate([[mode], modes[:-1]])
        starts = (modes == _MOVE) & (before != _MOVE)
        cycles.requests[at[starts]] = np.stack([np.full(starts.sum(), _START), table.array("motion_generator_mode")[starts],
                                                table.array("controller_mode")[starts]], axis=1)  # fmt: skip
        cycles.requests[at[(modes == _RECOVERY) & (before == _REFLEX)], 0] = _RECOVER
        mode = int(modes[-1])
        times = table.array("at_ns")
        for stop in stops[(stops >= begin) & (stops < begin + step)]:
            place = int(np.searchsorted(times, stop, side="right"))
            if place < len(at):
                cycles.requests[at[place], 0] = _STOP
        answered, commands = _own_commands(file, begin, begin + step)
        place = np.searchsorted(answered, cycles.ids - 1)
        there = place < len(answered)
        there[there] = answered[place[there]] == cycles.ids[there] - 1
        cycles.present = there.copy()
        cycles.present[at] &= table.array("fate") == _SERVED
        cycles.commands[there] = commands[place[there]]
        yield cycles


def _own_stops(file: _core.LogFile) -> npt.NDArray[np.int64]:
    """When the workstation stopped a motion, ns."""
    events = file.read("events", ["at_ns", "kind"], file.first_ns - 1, file.last_ns + 1, 1)
    kinds = [kind for kind, text in enumerate(events.texts("kind")) if text in ("stop", "limit")]
    times: npt.NDArray[np.int64] = events.array("at_ns")[np.isin(events.array("kind"), kinds)]
    return times


def _own_commands(file: _core.LogFile, begin: int, end: int) -> tuple[npt.NDArray[np.int64], Floats]:
    """States that commands answer, rising, and the commands."""
    ticks = file.read("ticks", [*_COMMAND, "command_message_id"], begin - 10**9, end + 10**9, 1)
    answered = ticks.array("command_message_id").astype(np.int64)
    order = np.argsort(answered, kind="stable")
    order = order[answered[order] > 0]
    commands = np.empty((len(order), 47))
    for name, place in _COMMAND.items():
        commands[:, place] = ticks.array(name)[order].reshape(len(order), -1)
    return answered[order], commands


# Logs of robots


def _start(recording: Recording) -> Floats:
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


_INTERFACES = (_Interface("tau_J_d", "tau_J_c", 2, 2), _Interface("q_c", "q_c", 1, 0), _Interface("dq_c", "dq_c", 2, 0), _Interface("q_c", "q_d", 1, 0))


def _interface(columns: frozenset[str]) -> _Interface:
    for interface in _INTERFACES:
        if interface.column in columns:
            return interface
    raise ValueError("the log has neither q_c nor dq_c, tau_J_c or q_d: there are no commands to replay")


def _cycles(recording: Recording, delay: int) -> Iterator[_Cycles]:
    """Cycles of a robot's log; those at the end of a block wait until it is known what follows."""
    interface = _interface(recording.columns)
    return _requested(_gridded(recording, interface, delay), interface)


def _gridded(recording: Recording, interface: _Interface, delay: int) -> Iterator[_Cycles]:
    """The log's rows on cycles of 1 ms, with commands in all that have one; a row that is NaN has none."""
    others = [name for name in ("q_d", "dq_d", "dq_c") if name in recording.columns]
    if interface.command == "q_c" and "dq_c" in others:
        others.remove("dq_c")
    last = -1
    shift = _Shift(delay)
    known: dict[str, Values] = {}
    yield _Cycles.none(-_LEAD, 0)
    for block in recording.blocks(*{interface.column, *others}):
        at = np.rint(block.t / _T).astype(np.int64)
        at = np.maximum.accumulate(np.maximum(at, last + 1) - np.arange(len(at))) + np.arange(len(at))  # stamps jitter; each row has a cycle
        known = {name: np.concatenate([known[name][-3:], values]) if known else values for name, values in {**block.columns, "at": at}.items()}
        begin, last = last + 1, int(at[-1])
        cycles = _Cycles.none(begin, last + 1)
        cycles.logged[at - begin] = True
        command = _filled(known["at"], known[interface.column], cycles.ids, interface.command != "tau_J_d")
        command[_held_in_gaps(known, cycles.ids, interface)] = np.nan
        command = shift(command)
        cycles.present = np.isfinite(command).all(axis=1)
        if interface.column == "q_c" and "q_d" in known:
            cycles.present[at - begin] &= ~_unfollowed(block.columns["q_d"], command[at - begin])
        cycles.commands[:, _COMMAND[interface.command]] = np.nan_to_num(command)
        if interface.command == "tau_J_d" and "dq_c" in others:
            cycles.commands[:, _COMMAND["dq_c"]] = np.nan_to_num(_filled(known["at"], known["dq_c"], cycles.ids, True))
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
    exact = np.isin(ids, at)
    line[exact] = values[np.searchsorted(at, ids[exact])]
    return line


def _held_in_gaps(known: dict[str, Values], ids: Values, interface: _Interface) -> npt.NDArray[np.bool_]:
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


def _unfollowed(q_d: Floats, command: Floats) -> npt.NDArray[np.bool_]:
    """Rows whose reference is not their command, where most are; more than a motion survives are another matter than losses."""
    there = np.isfinite(command).all(axis=1)
    differs = there & (np.abs(q_d - np.nan_to_num(command)).max(axis=1) > _SAME)
    if differs.sum() * 2 >= there.sum():
        return np.zeros(len(q_d), bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], differs, [False]]).astype(int)))
    for begin, end in zip(edges[::2], edges[1::2]):
        if end - begin >= _LOST:
            differs[begin:end] = False
    return differs


def _requested(grid: Iterator[_Cycles], interface: _Interface) -> Iterator[_Cycles]:
    """Requests a start two cycles before a first command, and a stop where no more come. Holds back what depends on later cycles."""
    waiting: _Cycles | None = None
    moving = False
    for block in grid:
        waiting = block if waiting is None else _joined(waiting, block)
        moving, waiting, ready = _passed(waiting, moving, interface, len(waiting.ids) - _LOST - 2)
        yield ready
    if waiting is not None:
        yield _passed(waiting, moving, interface, len(waiting.ids))[2]


def _passed(cycles: _Cycles, moving: bool, interface: _Interface, count: int) -> tuple[bool, _Cycles, _Cycles]:
    """The first `count` cycles with their requests, and those that wait."""
    count = max(0, count)
    coming = np.flatnonzero(cycles.present)
    i = 0
    while i < count:
        place = np.searchsorted(coming, i)
        following = int(coming[place]) if place < len(coming) else len(cycles.ids) + _LOST
        if not moving:
            start = max(i, following - 2)
            if start >= count:
                break
            cycles.requests[start] = _START, interface.generator, interface.controller
            moving, i = True, following
        elif following == i:
            gaps = np.flatnonzero(np.diff(coming[place:]) > _LOST)
            i = int(coming[place + gaps[0]] if len(gaps) else coming[-1]) + 1
        elif following - i > _LOST:
            cycles.requests[i, 0] = _STOP
            moving = False
            i += 1
        else:
            i = following
    return moving, _part(cycles, count, len(cycles.ids)), _part(cycles, 0, count)


def _part(cycles: _Cycles, begin: int, end: int) -> _Cycles:
    return _Cycles(*(getattr(cycles, field.name)[begin:end] for field in dataclasses.fields(_Cycles)))


def _joined(one: _Cycles, other: _Cycles) -> _Cycles:
    return _Cycles(*(np.concatenate([getattr(one, field.name), getattr(other, field.name)]) for field in dataclasses.fields(_Cycles)))


# INT's estimates


class ExternalTorque:
    """INT's estimates of external torque and wrench from measured rows of 1 kHz, block after block.

    End effector, load and frames are those that the scenario gives INT. On a lockstep log of the twin they are the log's own to
    rounding, but for times of closed brakes.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._observer = _core.ExternalTorque(scenario._loaded)
        self._last: float | None = None

    def advance(self, t: Floats, q: Floats, dq: Floats, tau_J: Floats) -> tuple[Floats, Floats]:
        """Take rows that follow the last ones; where rows are missing, the estimate begins anew at zero.

        Parameters
        ----------
        t : ndarray, shape (n,)
            s, rising.
        q, dq, tau_J : ndarray, shape (n, 7)
            rad, rad/s, Nm.

        Returns
        -------
        tau_ext_hat_filtered : ndarray, shape (n, 7)
            Nm, positive when the robot pushes.
        O_F_ext_hat_K : ndarray, shape (n, 6)
            [N; Nm] about K in the base's axes; zero near a singularity.
        """
        anew = np.diff(t, prepend=t[0] - 1 if self._last is None else self._last) > 1.5 * _T
        out = np.empty((len(t), 13))
        self._observer.advance(*(np.ascontiguousarray(x, float) for x in (q, dq, tau_J)), anew, out)
        if len(t):
            self._last = float(t[-1])
        return out[:, :7], out[:, 7:]


def external_torque(scenario: Scenario, q: Floats, dq: Floats, tau_J: Floats) -> tuple[Floats, Floats]:
    """Give rows of 1 kHz, without gaps, to INT's observer; as `ExternalTorque.advance`."""
    return ExternalTorque(scenario).advance(_T * np.arange(len(q)), q, dq, tau_J)
