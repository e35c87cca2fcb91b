"""Serves a simulated robot to programs made for the real one, and controls served robots."""

from __future__ import annotations

import abc
import contextlib
import dataclasses
import json
import os
import pathlib
import socket
import warnings
import weakref
from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _core
from ._closing import Closing
from .scenario import RobotLike, as_robot, checked_seed

_Path: TypeAlias = str | os.PathLike[str]


@dataclasses.dataclass(frozen=True, slots=True)
class Status:
    """A served robot between two cycles.

    Attributes
    ----------
    cycle : int
        Number of the robot's cycle, of 1 ms.
    time_s : float
        Time of that cycle, s.
    mode : str
        "Idle", "Move", "Guiding", "Reflex", "User stopped", ...
    paused : bool
        Whether time stands still.
    lockstep : bool
        Whether the robot runs in lockstep; else on the wall clock.
    errors : tuple of str
        Names of the errors that are set.
    q : ndarray, shape (7,)
        Measured joint positions, rad.
    """

    cycle: int
    time_s: float
    mode: str
    paused: bool
    lockstep: bool
    errors: tuple[str, ...]
    q: npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True)
class Event:
    """What a served robot told.

    Attributes
    ----------
    time_s : float
        Wall-clock time since the robot is served, s.
    kind : str
        "motion" for motions of the arm, "client" for connections, "control" for requests of a control channel, else
        "arm", "hand" or "server".
    text : str
        The event, in words.
    """

    time_s: float
    kind: str
    text: str


def _status_of(line: str) -> Status:
    try:
        answer = json.loads(line)
        refusal = None if answer["ok"] else str(answer["error"])
        if refusal is None:
            return Status(answer["cycle"], answer["time_s"], answer["mode"], answer["paused"], answer["lockstep"],
                          tuple(answer["errors"]), np.array(answer["q"]))
    except (ValueError, KeyError, TypeError):
        raise OSError(f"{line[:40]!r} is no answer of a control channel; another program listens there") from None
    raise ValueError(refusal)


class _Controlled(abc.ABC):
    """The verbs with which a served robot is controlled. Each returns the robot's status afterwards, and raises ValueError
    when the robot refuses it."""

    @abc.abstractmethod
    def _ask(self, line: str) -> str:
        """Sends a request, a line of JSON; returns the answer."""

    def _do(self, verb: str, **arguments: Any) -> Status:
        try:
            request = json.dumps({"do": verb} | arguments, allow_nan=False)
        except ValueError:
            raise ValueError(f"{verb}: every number must be finite") from None
        return _status_of(self._ask(request))

    @property
    def status(self) -> Status:
        """The robot as it is now."""
        return self._do("status")

    def pause(self) -> Status:
        """Lets the time of a robot in lockstep stand still, in a motion too."""
        return self._do("pause")

    def resume(self) -> Status:
        """Lets time run again."""
        return self._do("resume")

    def step(self, cycles: int = 1) -> Status:
        """Lets time run for some cycles, and stand still again.

        In a motion, each cycle waits for the program's command. Ctrl-C ends the wait, not the step.

        Parameters
        ----------
        cycles : int
            Number of cycles of 1 ms, 1 to 86,400,000.
        """
        return self._do("step", cycles=cycles)

    def reset(self, q: npt.ArrayLike | None = None) -> Status:
        """Begins anew, in lockstep, between motions: the arm at rest, objects and hand as in the scenario.

        Parameters
        ----------
        q : array_like, shape (7,), optional
            Joint positions, rad. Default: the scenario's start.
        """
        return self._do("reset") if q is None else self._do("reset", q=np.asarray(q, float).tolist())

    def place(self, name: str, position: npt.ArrayLike, rpy: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Status:
        """Puts an object of the scene somewhere, at rest.

        Parameters
        ----------
        name : str
            Name of the object.
        position : array_like, shape (3,)
            Position of the object's frame in the world, m.
        rpy : array_like, shape (3,)
            Roll, pitch and yaw in the world, R = Rz Ry Rx, rad.
        """
        return self._do("place", name=name, position=np.asarray(position, float).tolist(),
                        rpy=np.asarray(rpy, float).tolist())

    def snapshot(self, name: str = "last") -> Status:
        """Keeps a copy of the whole robot and its scene, in lockstep, between motions; up to 16 names."""
        return self._do("snapshot", name=name)

    def restore(self, name: str = "last") -> Status:
        """Goes back to a snapshot: from there the same commands give the same states, each time."""
        return self._do("restore", name=name)

    def user_stop(self, on: bool) -> Status:
        """Presses (True) or releases (False) the user stop."""
        return self._do("user-stop", on=on)

    def guiding(self, on: bool) -> Status:
        """Presses (True) or releases (False) the guiding button."""
        return self._do("guiding", on=on)

    def recover(self) -> Status:
        """Recovers from errors, as a client's automatic error recovery."""
        return self._do("recover")


class ServedRobot(_Controlled, Closing):
    """A robot that this process serves; made by `serve`.

    Its threads are the robot's own and never take the GIL: programs of the same process can use the robot, whatever they hold
    while they wait. Use it as a context manager, or call `close`.

    Attributes
    ----------
    hostname : str
        Address at which programs find the robot.
    port : int
        TCP port of the arm; the hand has the next one.
    drive : str
        "lockstep" or "realtime".
    """

    def __init__(self, served: _core.Served) -> None:
        self._served = served
        self._finalizer = weakref.finalize(self, served.close)  # at exit too: the robot's threads must end first
        self.hostname: str = served.hostname
        self.port: int = served.port
        self.drive: str = served.drive

    def _ask(self, line: str) -> str:
        return self._served.ask(line)

    @property
    def closed(self) -> bool:
        """Whether `close` was called."""
        return self._served.closed

    @property
    def events(self) -> list[Event]:
        """What the robot told so far, the newest 100,000: connections, motions and their ends, refusals with their reason."""
        return [Event(*event) for event in self._served.events]

    def close(self) -> None:
        """Disconnects programs and ends the robot; writes log, capture and results. A second call has no effect.

        Raises
        ------
        OSError
            When a file cannot be completed.
        RobotFault
            When the simulation became unsound.
        """
        self._finalizer.detach()
        for text in self._served.close():
            warnings.warn(text, RuntimeWarning, stacklevel=2)

    def __repr__(self) -> str:
        state = "closed" if self.closed else f"drive {self.drive}"
        return f"<panda_twin.ServedRobot at {self.hostname}:{self.port}, {state}>"


class ControlChannel(_Controlled):
    """A robot that another process serves, `panda-twin serve --control FILE`; made by `control_channel`.

    Each request has a connection of its own, so there is nothing to close.
    """

    def __init__(self, path: _Path) -> None:
        self.path = pathlib.Path(path)
        self.status  # noqa: B018: raises when there is no robot

    def _ask(self, line: str) -> str:
        with socket.socket(socket.AF_UNIX) as connection:
            try:
                connection.connect(os.fspath(self.path))
                with contextlib.suppress(BrokenPipeError):  # refused already: the answer says why
                    connection.sendall(line.encode() + b"\n")
                answer = connection.makefile("rb").readline()
            except OSError as error:
                raise OSError(f"{self.path}: no served robot has its control channel there ({error.strerror or error}); start "
                              f"one with panda-twin serve --control {self.path}") from error
        if not answer.endswith(b"\n"):
            raise OSError(f"{self.path}: the served robot ended before it answered")
        return answer.decode(errors="replace")

    def __repr__(self) -> str:
        return f"<panda_twin.ControlChannel at {self.path}>"


def serve(
    scenario: RobotLike | None = None,
    *,
    drive: Literal["lockstep", "realtime"] | None = "lockstep",
    pace: float | None = None,
    seed: int | None = None,
    lab: _Path | None = None,
    model: str | None = None,
    scene: _Path | None = None,
    reset: Literal["never", "on-connect", "on-command"] = "never",
    idle: Literal["run", "freeze"] = "run",
    guard: bool = False,
    viability: int | None = None,
    clock_ppm: float | None = None,
    session_timeout: float = 10.0,
    log: _Path | None = None,
    log_split: str | None = None,
    log_keep: int | None = None,
    capture: _Path | None = None,
    out: _Path | None = None,
    video: bool = True,
    control: _Path | None = None,
    hostname: str | None = None,
) -> ServedRobot:
    """Serves a simulated robot to programs made for the real one (FCI protocol 5; an FR3: 10).

    Parameters
    ----------
    scenario : Scenario, dict, text or path, optional
        Robot, scene and start, as of `Session`. Default: the ready pose, no scene.
    drive : {"lockstep", "realtime"}, optional
        Who advances time: the programs' answers, or the wall clock. None: the wall clock where this host keeps 1 kHz, which
        takes a second to measure, else lockstep at pace 1.
    pace : float, optional
        In lockstep, the largest ratio of robot time to wall-clock time, 0.01 to 100. Default: as fast as answers come.
        A program has 1000 cycles for a motion's first command: 10 ms of the wall clock at pace 100.
    seed : int, optional
        Seed of all random numbers, instead of the scenario's.
    lab : name or path, optional
        Properties of a site, which replace those of the scenario.
    model : str, optional
        Arm, instead of the scenario's: "panda", "fr3", or another folder below models/robots.
    scene : path, optional
        World around the robot (MJCF), instead of the scenario's.
    reset : {"never", "on-connect", "on-command"}
        In lockstep: whether programs make the robot begin anew: never, each client of the arm as it connects, or programs at
        the control channel. `ServedRobot.reset` works with all three.
    idle : {"run", "freeze"}
        In lockstep: time between motions.
    guard : bool
        Whether the robot keeps the limits of scenario and lab: it stops a motion before the motion breaks one.
    viability : int, optional
        Keeps programs' motions within the robot's limits while up to so many commands in a row are lost, 0 to 100.
    clock_ppm : float, optional
        On the wall clock: drift of the robot's clock, parts per million.
    session_timeout : float
        In lockstep: a motion without an answer for so long is stopped, s.
    log, capture : path, optional
        File of all cycles (MCAP); file of what goes over the wire (pcapng). Complete when the robot is closed.
    log_split : str, optional
        Robot time or size of a part of the log: "1 h", "512 MiB". Default: one file.
    log_keep : int, optional
        How many ended parts stay. Default: all.
    out : path, optional
        Folder of results, written when the robot is closed: log, report with a row per motion, plots, video.
    video : bool
        Whether `out` has a video.
    control : path, optional
        Unix socket at which other programs can pause, step and reset the robot: see `control_channel`.
    hostname : str, optional
        Address in 127.0.0.0/8. Default: the first of 127.0.0.1, 127.0.0.2, ... whose ports 1337 and 1338 are free.

    Returns
    -------
    ServedRobot
        Is served until it is closed.

    Raises
    ------
    ValueError
        For a value or a file that is wrong.
    OSError
        When a port, a file or a program is not to be had.

    Examples
    --------
    >>> with panda_twin.serve() as robot:  # doctest: +SKIP
    ...     panda_py.Panda(robot.hostname).move_to_start()
    """
    options = _core.ServeOptions()
    if scenario is not None:
        text, file = as_robot(scenario, "served")
        if text is None:
            options.scenario = file
        else:
            options.yaml = text
    options.drive = drive
    options.pace = pace
    options.seed = checked_seed(seed)
    options.lab = None if lab is None else os.fspath(lab)
    options.model = model
    options.scene = None if scene is None else pathlib.Path(scene)
    options.reset = reset
    options.idle = idle
    options.guard = guard
    options.viability = viability
    options.clock_ppm = clock_ppm
    options.session_timeout = session_timeout
    options.log = None if log is None else pathlib.Path(log)
    options.log_split = log_split
    options.log_keep = log_keep
    options.capture = None if capture is None else pathlib.Path(capture)
    options.out = None if out is None else pathlib.Path(out)
    options.no_video = out is not None and not video
    return ServedRobot(_core.serve(options, hostname, None if control is None else pathlib.Path(control)))


def control_channel(path: _Path) -> ControlChannel:
    """Controls a robot that another process serves with `panda-twin serve --control FILE`, or `serve(control=FILE)`.

    Parameters
    ----------
    path : path
        The Unix socket.

    Raises
    ------
    OSError
        When no robot is served there.
    """
    return ControlChannel(path)
