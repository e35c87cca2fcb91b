"""What a run leaves, and why it ended as it did."""

from __future__ import annotations

import functools
import json
import os
import pathlib
import shutil
import typing
import weakref

from . import _core
from .scenario import Scenario


class Explanation:
    """How a run ended, and why.

    Attributes
    ----------
    aborted : bool
        Whether an error of the robot ended a motion. Without one, the attributes of the error are None.
    text : str
        The explanation in lines of at most 100 columns: error, place, value and limit, fate of the last commands, usual cause and
        cure; of a run without an error, how close it came to each limit.
    error : str or None
        Name of the error, as libfranka prints it.
    joint : int or None
        Joint that broke a limit, 1 to 7.
    axis : str or None
        What broke a limit, in words: "joint 4", "rotation", "z of K".
    value, limit : float or None
        The value and the limit that it broke, both in `unit`; None for a log that does not tell them.
    unit : str or None
        SI: "rad/s^2"; empty for what has none.
    cycle : int or None
        Message id of the robot state of the cycle that raised the error.
    time : float or None
        Of that cycle since the run began, s.
    motion : int or None
        Motion that the error ended, counted from 1 over the log.
    """

    def __init__(self, log: pathlib.Path, motion: int | None) -> None:
        told = _core.explain(log, motion, False)
        error = told.error
        self._log = log
        self._motion = motion
        self.aborted: bool = told.aborted
        self.text: str = told.text
        self.error: str | None = error.name if error else None
        self.joint: int | None = error.joint if error else None
        self.axis: str | None = (error.axis or None) if error else None
        self.value: float | None = error.value if error else None
        self.limit: float | None = error.limit if error else None
        self.unit: str | None = error.unit if error else None
        self.cycle: int | None = error.cycle if error else None
        self.time: float | None = error.time if error else None
        self.motion: int | None = error.motion if error else None

    @functools.cached_property
    def page(self) -> str:
        """All errors of the log as one self-contained HTML page with plots; empty unless `aborted`.

        Drawn by gnuplot when first asked for, out of the log, which must still be there.
        """
        return _core.explain(self._log, self._motion, True).page

    def __str__(self) -> str:
        return self.text.rstrip("\n")

    def __repr__(self) -> str:
        return f"<Explanation: {self.text.splitlines()[0]}>"


def explain(source: str | os.PathLike[str] | RunResult, motion: int | None = None) -> Explanation:
    """Say how a run ended, and why, as `panda-twin explain` does.

    Parameters
    ----------
    source : path or RunResult
        A log, or a run's folder of results.
    motion : int, optional
        The errors of this motion, counted from 1 over the log; absent: the first error.

    Raises
    ------
    ValueError
        For a folder without a log, a damaged log, and a motion that no error ended.
    OSError
        When the log cannot be read.
    """
    if motion is not None and (isinstance(motion, bool) or not isinstance(motion, int)):
        raise TypeError(f"motion is {motion!r}; a whole number belongs here")
    if motion is not None and motion < 1:
        raise ValueError(f"motion is {motion}; motions are counted from 1")
    named = source.folder if isinstance(source, RunResult) else pathlib.Path(source)
    return Explanation(_core.find_log(named), motion)


def _remove(folder: pathlib.Path, owner: int) -> None:
    """Not from a fork of the process that made it."""
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)


class RunResult:
    """What a run left.

    Attributes
    ----------
    summary : dict
        The contents of `summary.json`: in lockstep they repeat with scenario and seed.
    failure : str
        Why the run is a failure; empty: it succeeded.
    text : str
        The summary that `panda-twin run` prints.
    folder : pathlib.Path
        Folder of results. That of a run without `out` is temporary: it lasts as long as this object.
    """

    def __init__(self, folder: pathlib.Path, end: _core.RunEnd, is_temporary: bool) -> None:
        self.folder = folder
        self.failure: str = end.failure
        self.text: str = end.text
        self.summary: dict[str, typing.Any] = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        if is_temporary:
            weakref.finalize(self, _remove, folder, os.getpid())

    @functools.cached_property
    def scenario(self) -> Scenario:
        """The scenario that was run, with the lab and the seed that were given."""
        return Scenario.load(self.folder / "scenario.yaml")

    @property
    def succeeded(self) -> bool:
        """Whether the run went well: no error, all demands of an application met; with `strict` also on its path."""
        return not self.failure

    @property
    def states_hash(self) -> str:
        """Fingerprint of all states that the robot sent, 16 hexadecimal digits: the physics, without the log's format.

        In lockstep the same scenario and seed give the same. Empty when no motion began.
        """
        return str(self.summary.get("states_hash", ""))

    @property
    def log(self) -> pathlib.Path | None:
        """The log, an MCAP file; None for a scenario with `record: false`."""
        return self._file("run.mcap")

    @property
    def video(self) -> pathlib.Path | None:
        """The video; None when none was made."""
        return self._file("video.mp4")

    @property
    def report(self) -> pathlib.Path | None:
        """An application's report, an HTML page; None when none was made."""
        return self._file("report.html")

    def explain(self, motion: int | None = None) -> Explanation:
        """As `panda_twin.explain` of this run's log."""
        return explain(self, motion)

    def _file(self, name: str) -> pathlib.Path | None:
        file = self.folder / name
        return file if file.is_file() else None

    def __repr__(self) -> str:
        return f"<RunResult of {self.summary['scenario']}, seed {self.summary['seed']}: {self.summary['outcome']}>"
