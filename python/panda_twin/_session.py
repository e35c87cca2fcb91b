"""Motions, one after another, of a twin in this process."""

from __future__ import annotations

import os
import pathlib

from . import _core
from ._closing import Closing
from ._robot import Robot
from .scenario import RobotLike, as_robot, checked_seed


class Session(Robot, Closing):
    """A twin in this process, on which motions follow each other in simulated time.

    Time stands still between two calls, and the same scenario, seed and calls give the same bits. The
    first motion gives the same as `panda-twin run` of it. Ctrl-C stops the arm and raises
    KeyboardInterrupt from any call, and the session can go on.

    Use one session from one thread at a time (RuntimeError else); sessions in different threads run
    in parallel.

    Parameters
    ----------
    scenario
        A Scenario, the keys of one, its text, or the name of its file. Motion and application may be missing;
        the arm then rests at robot.q_start, which of keys is `model.Q_READY` by default. None: no keys at all.
    seed
        Of every random number, instead of the scenario's.
    lab
        Laid over the scenario: a name in models/labs, or a file.
    log
        MCAP file to write: cycles, ticks, events, and scenes for videos.

    Raises
    ------
    ValueError
        When something of the scenario is wrong: file, line, key and cure.
    OSError
        When a file cannot be read or written.

    Examples
    --------
    >>> with Session({"plant": {"kind": "ideal"}}) as session:
    ...     session.wait(0.1)
    ...     session.state.robot_mode
    'Idle'
    """

    def __init__(
        self,
        scenario: RobotLike | None = None,
        seed: int | None = None,
        lab: str | None = None,
        log: str | os.PathLike[str] | None = None,
    ) -> None:
        text, file = as_robot({} if scenario is None else scenario, "session")
        path = None if log is None else pathlib.Path(log)
        twin = _core.TwinSession(text, file, checked_seed(seed), lab, path)
        super().__init__(twin, twin.name)

    def close(self) -> None:
        """End the session and complete its log. Once is enough; `with` does it."""
        self._twin.close()

    @property
    def closed(self) -> bool:
        """Whether the session has ended."""
        return self._twin.closed
