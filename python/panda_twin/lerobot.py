"""Writes logs as a LeRobot dataset, format v3.0: python3 -m panda_twin.lerobot {write,demonstrate} ... --out DATASET.

A frame, ``fps`` times a second of the run's clock, has

``observation.state``
    Columns of the log when the frame begins: by default the measured joint positions ``q``, rad, and the gripper's width, m.
``action``
    What was commanded until the frame ends, 1/``fps`` later: by default the robot's desired joint positions ``q_d``, rad, and the
    gripper's width, m. The robot follows its reference within milliseconds, so a command of the frame's beginning would repeat
    the state.
``observation.images.CAMERA``
    The scene when the frame begins, drawn by the twin's renderer: the first that was recorded at or after that instant.

``q_d`` is in every log; ``q_ext``, the target before the reference generator, or ``q_c`` are in those of a workstation's ticks and
hold between motions. A pose such as ``O_T_EE_d`` becomes nine numbers: position, m, and the first two columns of its rotation.
The width commanded by an action is the one that the hand reached before its next command, since logs have commands to the hand
without widths; without any command it is the measured width.
"""

from __future__ import annotations

import argparse
import collections
import dataclasses
import logging
import operator
import os
import pathlib
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence

from ._command import exit_code_of
from ._errors import RobotFault
from ._lerobot_files import Picture, Shape, Writer
from ._lerobot_frames import GRIPPER, Frames, Times, names_of
from ._log import Log
from ._run import run
from .scenario import Scenario, ScenarioLike, as_scenario

OWN_CAMERA = "scenario"
"""Stands for the camera of the scenario's film."""

STATE = ("q", GRIPPER)
ACTION = ("q_d", GRIPPER)
CAMERAS = (OWN_CAMERA,)
SIZE = (320, 240)

_logger = logging.getLogger("panda_twin")


class _Dataset:
    """Logs become episodes of a dataset."""

    def __init__(
        self,
        folder: str | os.PathLike[str],
        fps: int,
        cameras: Sequence[str],
        state: Sequence[str],
        action: Sequence[str],
        size: tuple[int, int],
    ) -> None:
        if not 1 <= operator.index(fps) <= 240:
            raise ValueError(f"fps is {fps}; it must be a whole number from 1 to 240")
        if len(size) != 2 or any(operator.index(one) % 2 or not 16 <= one <= 4096 for one in size):
            raise ValueError(f"size is {size}; it must be an even width and height from 16 to 4096")
        if isinstance(cameras, str):
            raise TypeError(f"cameras is of type str; a tuple of names belongs here: ({cameras!r},)")
        self._cameras = {f"observation.images.{camera.replace(':', '_').replace('/', '_')}": camera for camera in cameras}
        if len(self._cameras) < len(cameras) or not all(cameras):
            raise ValueError(f"cameras are {', '.join(map(repr, cameras))}; each must have a name of its own")
        self._columns = {"observation.state": tuple(state), "action": tuple(action)}
        self._fps = fps
        self._size = size
        names = {"observation.state": names_of("state", state), "action": names_of("action", action)}
        if not os.fspath(folder):
            raise ValueError("the folder's name is empty")
        self.writer = Writer(pathlib.Path(folder).absolute(), Shape(fps, names, tuple(self._cameras), size))

    def add(self, log: Log, task: str) -> None:
        frames = Frames(log, self._fps, bool(self._cameras) or any(GRIPPER in one for one in self._columns.values()))
        vectors = {name: frames.vector(columns, name == "action") for name, columns in self._columns.items()}
        self.writer.add(task, vectors, {key: self._drawn(log, camera, frames.at) for key, camera in self._cameras.items()})

    def _drawn(self, log: Log, camera: str, at: Times) -> Iterator[Picture]:
        for time in at.tolist():
            yield log.picture(time * 1e-9, camera=None if camera == OWN_CAMERA else camera, size=self._size)


def write(
    logs: Iterable[Log | str | os.PathLike[str]],
    folder: str | os.PathLike[str],
    *,
    fps: int = 25,
    task: str | None = None,
    cameras: Sequence[str] = CAMERAS,
    state: Sequence[str] = STATE,
    action: Sequence[str] = ACTION,
    size: tuple[int, int] = SIZE,
) -> pathlib.Path:
    """Write logs as a LeRobot dataset, an episode each.

    Parameters
    ----------
    logs : iterable of Log or path
        Read one after the other; also parts of logs, such as those of `Log.motions`.
    folder : path
        Of the dataset; must not exist. It is there whole, or not at all.
    fps : int
        Frames per second, from 1 to 240. Pictures are as recorded, `render.fps` a second: best the same.
    task : str, optional
        What is done, for policies that read it; absent: each scenario's description.
    cameras : sequence of str
        As of `Log.picture`; "scenario" is the one of the scenario's film. None: no videos. The video of camera C is
        ``observation.images.C``; ":" and "/" in its name become "_".
    state, action : sequence of str
        Columns of ``cycles``, else ``ticks``, and ``"gripper_width"``, which needs recorded scenes.
    size : (int, int)
        Width and height of pictures, pixels, even.

    Returns
    -------
    pathlib.Path
        The folder.

    Raises
    ------
    ValueError
        For an invalid argument or log, and a log without scenes if pictures or the gripper's width are wanted.
    ImportError
        Without pyarrow and pandas: pip install 'panda-twin[log]'.
    OSError
        When the folder exists or cannot be written, or ffmpeg is missing.
    """
    if isinstance(logs, (str, os.PathLike, Log)):
        raise TypeError(f"logs is of type {type(logs).__name__}; a list of logs belongs here")
    dataset = _Dataset(folder, fps, cameras, state, action, size)
    with dataset.writer as writer:
        for one in logs:
            log = one if isinstance(one, Log) else Log(one)
            scenario = Scenario.from_yaml(log.scenario) if log.scenario else None
            if task is None and not (scenario and scenario.description):
                raise ValueError(f"{log!r} does not say what is done; give the task")
            dataset.add(log, task if task is not None else scenario.description if scenario else "")
            if scenario and cameras and scenario.to_dict().get("render", {}).get("overlays"):
                _logger.warning("pictures of %r carry the texts of render.overlays; record with overlays: [] for training", log)
        if writer.episodes == 0:
            raise ValueError("there are no logs; a dataset has at least one episode")
        writer.finish()
    return pathlib.Path(folder)


@dataclasses.dataclass(frozen=True)
class Demonstrations:
    """What became of the runs of `demonstrate`."""

    folder: pathlib.Path
    """Of the dataset."""
    seeds: tuple[int, ...]
    """Of the episodes, in their order."""
    left_out: dict[int, str]
    """Why runs are no episodes, by seed."""
    frames: int
    """Of all episodes."""

    def __str__(self) -> str:
        return f"{self.folder}: {len(self.seeds)} episodes, {self.frames} frames; {_told(len(self.seeds), self.left_out)}"


def _told(kept: int, left_out: dict[int, str]) -> str:
    causes = collections.Counter(left_out.values())
    return f"{kept + len(left_out)} runs" + "".join(
        f"\n  left out {count}, {cause} (seeds {', '.join(str(seed) for seed, one in left_out.items() if one == cause)})"
        for cause, count in causes.most_common()
    )


def demonstrate(
    scenario: ScenarioLike,
    folder: str | os.PathLike[str],
    *,
    episodes: int = 100,
    seed: int | None = None,
    fps: int = 20,
    task: str | None = None,
    cameras: Sequence[str] = CAMERAS,
    state: Sequence[str] = STATE,
    action: Sequence[str] = ACTION,
    size: tuple[int, int] = SIZE,
    most_runs: int | None = None,
    progress: Callable[[int, str], None] | None = None,
) -> Demonstrations:
    """Run a scenario or application for successive seeds, and write the runs that succeeded as a LeRobot dataset.

    Runs are in lockstep: the same arguments give the same data, byte for byte. Scenes are recorded at `fps` and drawn without text.

    Parameters
    ----------
    scenario : Scenario, dict or path
        As of `run`; its perturbations, losses and ``spread`` are drawn by the seed.
    folder, fps, task, cameras, state, action, size
        As of `write`.
    episodes : int
        Number of runs that must succeed.
    seed : int, optional
        The first seed; absent: the scenario's.
    most_runs : int, optional
        Runs after which it gives up; by default ten times `episodes`.
    progress : callable, optional
        Called after each run with its seed and why it is left out; empty if it is an episode.

    Raises
    ------
    ValueError, ImportError, OSError
        As of `write` and `run`.
    RobotFault
        When too few runs succeed; no dataset is written then.
    """
    if operator.index(episodes) < 1:
        raise ValueError(f"episodes is {episodes}; it must be at least 1")
    most_runs = 10 * episodes if most_runs is None else operator.index(most_runs)
    if most_runs < episodes:
        raise ValueError(f"most_runs is {most_runs}; it must be at least the {episodes} episodes")
    dataset = _Dataset(folder, fps, cameras, state, action, size)
    with dataset.writer as writer:
        filmed = as_scenario(scenario).replace(
            {"record": True, "render": {"enabled": True, "fps": f"{fps} Hz", "overlays": [], "insets": []}}
        )
        first = filmed.seed if seed is None else operator.index(seed)
        task = filmed.description or filmed.name if task is None else task
        seeds: list[int] = []
        left_out: dict[int, str] = {}
        while len(seeds) < episodes:
            if len(seeds) + len(left_out) >= most_runs:
                raise RobotFault(f"{len(seeds)} of the wanted {episodes} episodes: {_told(len(seeds), left_out)}")
            now = first + len(seeds) + len(left_out)
            result = run(filmed, seed=now, drive="lockstep", check=False)
            if result.succeeded and result.log:
                dataset.add(Log(result.log), task)
                seeds.append(now)
            else:
                left_out[now] = str(result.summary.get("failure") or result.failure).splitlines()[0]
            if progress is not None:
                progress(now, left_out.get(now, ""))
        writer.finish()
    return Demonstrations(pathlib.Path(folder), tuple(seeds), left_out, writer.frames)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python3 -m panda_twin.lerobot", description="Write LeRobot datasets, format v3.0.")
    commands = parser.add_subparsers(dest="command", required=True)
    demonstrating = commands.add_parser("demonstrate", help="run a scenario for successive seeds; runs that succeed are episodes")
    demonstrating.add_argument("scenario", help="a scenario's file, such as applications/pick_and_place.yaml")
    demonstrating.add_argument("--episodes", type=int, default=100, help="number of runs that must succeed (default: 100)")
    demonstrating.add_argument("--seed", type=int, help="the first seed (default: the scenario's)")
    demonstrating.add_argument("--most-runs", type=int, help="give up after so many (default: ten times the episodes)")
    writing = commands.add_parser("write", help="write logs of runs, an episode each")
    writing.add_argument("logs", nargs="+", metavar="LOG", type=pathlib.Path, help="log (run.mcap), or its folder of results")
    for one, fps in ((demonstrating, 20), (writing, 25)):
        one.add_argument("--out", type=pathlib.Path, required=True, metavar="DATASET", help="folder to write; must not exist")
        one.add_argument("--fps", type=int, default=fps, help=f"frames per second (default: {fps})")
        one.add_argument("--task", help="what is done (default: the scenario's description)")
        one.add_argument("--camera", action="append", default=[], help=f"repeatable; default: {OWN_CAMERA}, the scenario's own")
        one.add_argument("--no-video", action="store_true", help="states and actions alone")
        one.add_argument("--size", default="x".join(map(str, SIZE)), help="of pictures (default: %(default)s)")
        one.add_argument("--state", default=",".join(STATE), help="columns of the log (default: %(default)s)")
        one.add_argument("--action", default=",".join(ACTION), help="columns of the log (default: %(default)s)")
    return parser


def _size(text: str) -> tuple[int, int]:
    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ValueError(f"--size is {text}; write it as {SIZE[0]}x{SIZE[1]}")
    return int(width), int(height)


def _carry_out(options: argparse.Namespace) -> str:
    cameras = () if options.no_video else tuple(options.camera) or CAMERAS
    state, action = tuple(options.state.split(",")), tuple(options.action.split(","))
    size = _size(options.size)
    fps, task = options.fps, options.task
    if options.command == "write":
        return str(
            write(options.logs, options.out, fps=fps, task=task, cameras=cameras, state=state, action=action, size=size)
        )
    return str(
        demonstrate(
            options.scenario, options.out, episodes=options.episodes, seed=options.seed, most_runs=options.most_runs,
            fps=fps, task=task, cameras=cameras, state=state, action=action, size=size,
            progress=lambda seed, why: print(f"seed {seed}: {why or 'an episode'}", file=sys.stderr, flush=True),
        )
    )


def main(arguments: list[str]) -> int:
    logging.basicConfig(format="%(levelname)s: %(message)s")
    options = _parser().parse_args(arguments)
    return exit_code_of(lambda: print(_carry_out(options)), interrupted="interrupted; no dataset was written")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
