"""Runs of a scenario."""

from __future__ import annotations

import logging
import os
import pathlib
import shutil
import tempfile
import typing
from collections.abc import Callable

from . import _core
from ._errors import RobotFault
from ._results import Explanation, RunResult
from .scenario import ScenarioLike, as_scenario, checked_seed

_LEVELS = {"info": logging.INFO, "warning": logging.WARNING}
_logger = logging.getLogger("panda_twin")


def run(
    scenario: ScenarioLike,
    *,
    seed: int | None = None,
    out: str | os.PathLike[str] | None = None,
    video: bool = True,
    plots: bool = True,
    lab: str | os.PathLike[str] | None = None,
    drive: typing.Literal["lockstep", "realtime"] | None = None,
    strict: bool = False,
    quality: typing.Literal["draft", "fine"] = "draft",
    check: bool = True,
    progress: Callable[[str, float], None] | None = None,
) -> RunResult:
    """Run a scenario as `panda-twin run` does, with the same bytes for the same seed.

    Other threads of Python go on meanwhile. Ctrl-C stops the arm, ends the run and raises KeyboardInterrupt; results of a run
    that had begun stay in `out`, with the outcome "interrupted". Python handles signals on its main thread: a run on another
    thread goes on. What the run notes goes to the logger "panda_twin".

    Parameters
    ----------
    scenario : Scenario, dict or path
        A scenario, its keys, or the name of its file (see `Scenario.load`).
    seed : int, optional
        Of every random number, from 0 to 2**64 - 1; absent: the scenario's.
    out : path, optional
        Folder of results, as the program writes it. Absent: only summary and log are made, without video and plots, in a
        temporary folder that lasts as long as the result.
    video, plots : bool
        Make the video that the scenario asks for; the plots, and an application's report. With `out` only.
    lab : str or path, optional
        Site laid over the scenario: "a" or "b" of the installed models, or a file.
    drive : {"lockstep", "realtime"}, optional
        Who advances time; absent: the scenario's.
    strict : bool
        Whether an arm that was further off its path than `max_deviation` is a failure; else a warning.
    quality : {"draft", "fine"}
        Of the video.
    check : bool
        Raise RobotFault when the run is a failure; else look at `succeeded`.
    progress : callable, optional
        Called with the piece of work ("run", "video") and its done share in [0, 1], at most 20 times a second. What it raises
        ends the run as Ctrl-C does.

    Returns
    -------
    RunResult

    Raises
    ------
    ValueError
        For an invalid scenario or argument, and for backend fci: `panda-twin run` moves real robots.
    OSError
        When the folder cannot be written, or ffmpeg or gnuplot are missing.
    RobotFault
        With `check`: when the run is a failure. Text and attributes say why.
    """
    if progress is not None and not callable(progress):
        raise TypeError(f"progress is of type {type(progress).__name__}; a callable of work and share belongs here")
    if out is not None and not os.fspath(out):
        raise ValueError("out is empty; name a folder, or leave it out")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_")) if out is None else pathlib.Path(out).absolute()
    try:
        end = _core.run(
            as_scenario(scenario)._loaded,
            out=folder,
            seed=checked_seed(seed),
            drive=drive,
            lab=None if lab is None else os.fspath(lab),
            quality=quality,
            video=video and out is not None,
            plots=plots and out is not None,
            strict=strict,
            is_kept=out is not None,
            progress=progress,
        )
        for level, line in end.lines:
            _logger.log(_LEVELS[level], "%s", line)
        result = RunResult(folder, end, is_temporary=out is None)
    except BaseException:
        if out is None:
            shutil.rmtree(folder, ignore_errors=True)
        raise
    if check and not result.succeeded:
        raise _fault_of(result)
    return result


def _fault_of(result: RunResult) -> RobotFault:
    """The exception that tells why a run failed."""
    explanation: Explanation | None = None
    if result.log:
        told = result.explain()
        explanation = told if told.aborted else None
    text = f"{result.summary['failure']}\n{explanation}" if explanation else result.failure
    fault = RobotFault(text)
    fault.explanation = explanation
    fault.result = result
    return fault
