"""What the twin makes of a log's commands: INT and plant, cycle by cycle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _core
from .._log import Log
from ._robot_commands import COMMAND, COMMAND_SIZE, INTERFACES, RECOVER, START, STOP, Cycles, Floats, Shift, Values, cycles_of, interface_of, start_of

if TYPE_CHECKING:
    from ..scenario import Scenario
    from .logs._recording import Recording

_STATE = {"q": slice(0, 7), "dq": slice(7, 14), "tau_J": slice(14, 21), "q_d": slice(21, 28), "dq_d": slice(28, 35),
          "tau_ext_hat_filtered": slice(35, 42), "O_F_ext_hat_K": slice(42, 48)}  # fmt: skip
_MOVE, _REFLEX, _RECOVERY = 2, 4, 6  # robot_mode
_SERVED = 1  # fate
_MODES = np.array(["Other", "Idle", "Move", "Guiding", "Reflex", "User stopped", "Automatic error recovery"], object)
_FATES = np.array(["none", "served", "held"], object)
_ERRORS = _core.error_names()


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
    - Torques that are all zero at once, after more than 1 Nm, end the motion.
    - The arm rests for 200 cycles before the first row, so what the scenario has happen at a time (pushes, buttons) comes 0.2 s
      earlier in the log's time.
    - Of torque motions without tau_J_c nothing can be replayed: their q_d stands still.

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
        seed, first, cycles = own.seed, _ownstart_of(own), _own_cycles(own)
    elif isinstance(log, Log):
        raise ValueError("the log has no commands with their fates; open it by Recording.open()")
    else:
        seed, first, cycles = scenario.seed, start_of(log), cycles_of(log, cycles_of_delay)
        cycles_of_delay = 0  # is in
    twin = _core.CommandReplay(scenario._loaded, seed, first.tolist())
    shift = Shift(cycles_of_delay)
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
    if "q" not in recording.columns or not recording.columns & {interface.column for interface in INTERFACES}:
        return False
    if _own_file(recording) is not None:
        return True
    try:
        start_of(recording)
    except ValueError:
        return False
    return True


def is_by_reference(recording: Recording) -> bool:
    """Whether `replay` has no commands but the robot's q_d."""
    return _own_file(recording) is None and interface_of(recording.columns).column == "q_d"


def _named(ids: npt.NDArray[np.int64], states: Floats, codes: npt.NDArray[np.uint64]) -> dict[str, Values]:
    result: dict[str, Values] = {"message_id": ids, "fate": _FATES[codes[:, 3].astype(int)], "robot_mode": _MODES[codes[:, 2].astype(int)]}
    sets, places = np.unique(codes[:, 1], return_inverse=True)
    texts = ["|".join(name for bit, name in enumerate(_ERRORS) if int(errors) >> bit & 1) for errors in sets]
    result["errors"] = np.array(texts, object)[places.reshape(-1)]
    return result | {name: states[:, place] for name, place in _STATE.items()}


def _own_file(log: Recording | Log) -> _core.LogFile | None:
    """The file of a log that the twin's own robot wrote, with ticks. Of a robot on the network a log does not know fates."""
    source: Any = log if isinstance(log, Log) else log._source
    if not isinstance(log, Log) and log.kind != "panda-twin":
        return None
    file = getattr(getattr(source, "_log", source)._source, "file", None)
    if not isinstance(file, _core.LogFile) or file.drive == "remote":
        return None
    return file if file.read("ticks", ["message_id"], file.first_ns, file.first_ns + 3 * 10**9, 1).rows else None


def _ownstart_of(file: _core.LogFile) -> Floats:
    end = file.first_ns + 10**8
    table = file.read("cycles", ["q_d"], file.first_ns - 1, end, 1)
    if table.rows == 0:
        raise ValueError("the log has no cycle in its first 0.1 s")
    first: Floats = table.array("q_d")[0]
    return first


def _own_cycles(file: _core.LogFile) -> Iterator[Cycles]:
    step = max(10**9, (file.last_ns - file.first_ns) * (16 << 20) // max(1, file.bytes_in(file.first_ns - 1, file.last_ns + 1)))
    next_id, mode = 1, 0
    stops = _own_stops(file)
    for begin in range(file.first_ns - 1, file.last_ns + 1, step):
        table = file.read("cycles", ["message_id", "fate", "robot_mode", "motion_generator_mode", "controller_mode"], begin, begin + step, 1)
        if table.rows == 0:
            continue
        ids = table.array("message_id").astype(np.int64)
        cycles = Cycles.none(next_id, int(ids[-1]) + 1)
        at = ids - next_id
        next_id = int(ids[-1]) + 1
        cycles.logged[at] = True
        modes = table.array("robot_mode")
        before = np.concatenate([[mode], modes[:-1]])
        starts = (modes == _MOVE) & (before != _MOVE)
        cycles.requests[at[starts]] = np.stack([np.full(starts.sum(), START), table.array("motion_generator_mode")[starts],
                                                table.array("controller_mode")[starts]], axis=1)  # fmt: skip
        cycles.requests[at[(modes == _RECOVERY) & (before == _REFLEX)], 0] = RECOVER
        mode = int(modes[-1])
        times = table.array("at_ns")
        for stop in stops[(stops >= begin) & (stops < begin + step)]:
            place = int(np.searchsorted(times, stop, side="right"))
            if place < len(at):
                cycles.requests[at[place], 0] = STOP
        answered, commands = _own_commands(file, begin, begin + step)
        places = np.searchsorted(answered, cycles.ids - 1)
        cycles.present = places < len(answered)
        cycles.present[cycles.present] = answered[places[cycles.present]] == cycles.ids[cycles.present] - 1
        cycles.commands[cycles.present] = commands[places[cycles.present]]
        cycles.present[at] &= table.array("fate") == _SERVED
        yield cycles


def _own_stops(file: _core.LogFile) -> npt.NDArray[np.int64]:
    """When the workstation stopped a motion, ns."""
    events = file.read("events", ["at_ns", "kind"], file.first_ns - 1, file.last_ns + 1, 1)
    kinds = [kind for kind, text in enumerate(events.texts("kind")) if text in ("stop", "limit")]
    times: npt.NDArray[np.int64] = events.array("at_ns")[np.isin(events.array("kind"), kinds)]
    return times


def _own_commands(file: _core.LogFile, begin: int, end: int) -> tuple[npt.NDArray[np.int64], Floats]:
    """States that commands answer, rising, and the commands."""
    ticks = file.read("ticks", [*COMMAND, "command_message_id"], begin - 10**9, end + 10**9, 1)
    answered = ticks.array("command_message_id").astype(np.int64)
    order = np.argsort(answered, kind="stable")
    order = order[answered[order] > 0]
    commands = np.empty((len(order), COMMAND_SIZE))
    for name, place in COMMAND.items():
        commands[:, place] = ticks.array(name)[order].reshape(len(order), -1)
    return answered[order], commands
