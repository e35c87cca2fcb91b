"""One robot as a Gymnasium environment."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, cast

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from .. import _core
from .cell import Cell, Distribution
from .tasks import Array, Task

Observation = dict[str, npt.NDArray[Any]]

CAMERAS = ("overview", "panda_hand")


def check_choice(name: str, value: str, choices: Sequence[str]) -> None:
    """Refuses a value that is not among the choices."""
    if value not in choices:
        raise ValueError(f"{name}: {value!r} is unknown; say one of {', '.join(choices)}")


def spaces_of(cell: Cell, cameras: Sequence[str], size: tuple[int, int], depth: bool) -> tuple[spaces.Space[Observation], spaces.Space[Any]]:
    """Spaces of one robot's observations and actions."""
    numbers = cell.observation_size(with_object=not cameras)
    goal = spaces.Box(-np.inf, np.inf, (3,), np.float64)
    parts: dict[str, spaces.Space[Any]] = {
        "observation": spaces.Box(-np.inf, np.inf, (numbers,), np.float64),
        "achieved_goal": goal,
        "desired_goal": spaces.Box(-np.inf, np.inf, (3,), np.float64),
    }
    width, height = size
    for camera in cameras:
        parts[camera] = spaces.Box(0, 255, (height, width, 3), np.uint8)
        if depth:
            parts[f"{camera}_depth"] = spaces.Box(0, np.inf, (height, width, 1), np.float32)
    return cast(spaces.Space[Observation], spaces.Dict(parts)), spaces.Box(-1.0, 1.0, (cell.action_size,), np.float32)


class Pictures:
    """The cameras of one robot."""

    def __init__(self, cell: Cell, robot: int, cameras: Sequence[str], size: tuple[int, int]) -> None:
        self._size = size
        self._cameras = {
            name: _core.SteppedCamera(robots=cell.robots, robot=robot, view=name, width=size[0], height=size[1])
            for name in cameras
        }

    def colour(self, camera: str, marks: list[tuple[float, float, float]]) -> npt.NDArray[np.uint8]:
        """A picture (height, width, 3) with small balls at ``marks``."""
        picture = np.empty((self._size[1], self._size[0], 3), dtype=np.uint8)
        self._cameras[camera].draw(marks, picture)
        return picture

    def depth(self, camera: str) -> npt.NDArray[np.float32]:
        """Distances along the camera's axis, m, (height, width, 1); 0 where nothing is."""
        picture = np.empty((self._size[1], self._size[0], 1), dtype=np.float32)
        self._cameras[camera].depth(picture)
        return picture


class CommonEnv:
    """What an environment of one robot and one of several have in common: options, spaces, reward."""

    metadata: dict[str, Any]
    _count = 1
    _threads = 1

    def __init__(
        self,
        task: str | type[Task] = "Reach",
        *,
        reward: str = "sparse",
        control_hz: float = 20,
        interface: str = "cartesian_pose",
        observation: str = "state",
        delays: str | os.PathLike[str] | Mapping[str, Any] | None = None,
        losses: float | Mapping[str, Any] | None = None,
        viability: int | None = 19,
        randomize: Mapping[str, Distribution] | None = None,
        cameras: Sequence[str] = CAMERAS,
        size: tuple[int, int] = (84, 84),
        depth: bool = False,
        render_mode: str | None = None,
    ) -> None:
        check_choice("reward", reward, ("sparse", "dense"))
        check_choice("observation", observation, ("state", "pixels"))
        if render_mode is not None:
            check_choice("render_mode", render_mode, self.metadata["render_modes"])
        self._cell = Cell(
            task,
            self._count,
            self._threads,
            control_hz=control_hz,
            interface=interface,
            delays=delays,
            losses=losses,
            viability=viability,
            randomize=randomize,
        )
        self.metadata = {**self.metadata, "render_fps": round(1000 / self._cell.cycles)}
        self.render_mode: str | None = render_mode
        self._is_sparse = reward == "sparse"
        self._depth = depth
        self._cameras = tuple(cameras) if observation == "pixels" else ()
        self._eyes = [Pictures(self._cell, i, self._cameras, size) for i in range(self._count) if self._cameras]
        self._films: list[Pictures] = []
        self.observation_space, self.action_space = spaces_of(self._cell, self._cameras, size, depth)

    def compute_reward(self, achieved_goal: Array, desired_goal: Array, info: object) -> Any:
        """Reward of goals (..., 3); a number per goal. ``info`` has no effect."""
        task = self._cell.task
        return task.reward(np.asarray(achieved_goal), np.asarray(desired_goal), self._is_sparse)

    def _overviews(self) -> tuple[npt.NDArray[np.uint8], ...]:
        """A picture (480, 640, 3) of each robot with its goal as a ball."""
        if not self._films:
            self._films = [Pictures(self._cell, i, ["overview"], (640, 480)) for i in range(self._count)]
        marks = self._cell.task.marks
        return tuple(film.colour("overview", marks(self._cell.goals[i])) for i, film in enumerate(self._films))


class PandaEnv(CommonEnv, gymnasium.Env[Observation, npt.NDArray[np.float32]]):
    """A Panda with a task, in lockstep: the same seed gives the same bytes.

    An action is deposited ``control_hz`` times a second where a controller's target would be, and goes through rate
    matching, reference generator, viability filter and the link to the robot's controller at 1 kHz, with its limits
    and reflexes. An error that ends the robot's motion terminates the episode.

    Parameters
    ----------
    task : str or class
        Reach, Push, PickAndPlace, Peg or Wipe, or a class derived from :class:`~panda_twin.envs.tasks.Task`.
    reward : str
        "sparse" (0 at the goal, else -1) or "dense" (negative distance, m).
    control_hz : float
        Steps per second of the robot's time, in [5, 100]; rounded so that a step is whole milliseconds.
    interface : str
        What actions in [-1, 1] lead: "cartesian_pose" (velocity of the end effector's target, x y z, 0.5 m/s; the
        orientation stays), "joint_position" (velocity of the joints' targets, 1 rad/s), "joint_velocity" (1 rad/s) or
        "torque" (20 Nm, wrist 5 Nm, beside gravity). Where a task needs the hand, one number more: > 0 opens, < 0
        grasps.
    observation : str
        "state", or "pixels": pictures of ``cameras`` instead of the object's state.
    delays : path or mapping, optional
        A calibrated scenario or calibration folder (``models/experiments``), or the keys of a scenario's section link.
    losses : float or mapping, optional
        Share of lost messages in each direction, or a law as in scenarios.
    viability : int or None
        Losses in a row under which the limits are kept; None: no filter, so that actions can end the motion. Of
        "cartesian_pose" it keeps the end effector's limits: fast actions far from the start can still break a joint's.
    randomize : mapping, optional
        Drawn anew at each reset from the environment's seed: "load.mass" (kg, on the flange), "object.mass" (kg),
        "friction" (of the object), "delay" (s, of each message), "loss" (share), "q_start" (rad, added to each joint).
        A distribution is (low, high), (law, a, b) with law "uniform", "normal" or "log_uniform", or a function of the
        generator.
    cameras : sequence of str
        Of pixels: "overview", "panda_hand", or another camera of the scene.
    size : tuple of int
        Width and height of the observed pictures.
    depth : bool
        Whether distances are observed with the pictures.
    render_mode : str, optional
        "rgb_array": :meth:`render` draws the overview, 640 x 480.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}

    _is_begun = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode from the kept start; ``seed`` fixes everything from then on."""
        super().reset(seed=seed, options=options)
        (drawn,) = self._cell.reset([0], [self.np_random])
        self._is_begun = True
        observation = self._observation()
        info = self._info(observation)
        if drawn:
            info["randomized"] = drawn
        return observation, info

    def step(self, action: npt.NDArray[Any]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Deposits an action and lets the robot's time pass by a period."""
        if not self._is_begun:
            raise ValueError("step: call reset() first")
        action = np.asarray(action, dtype=np.float64)
        if action.shape != self.action_space.shape:
            raise ValueError(f"action: its shape is {action.shape}, not {self.action_space.shape}")
        self._cell.step(action[np.newaxis])
        observation = self._observation()
        info = self._info(observation)
        reward = self.compute_reward(observation["achieved_goal"], observation["desired_goal"], info)
        return observation, float(reward), "reflex" in info, False, info

    def compute_terminated(self, achieved_goal: Array, desired_goal: Array, info: Mapping[str, Any]) -> bool:
        """Whether the episode ends: by a reflex alone, not by success."""
        return "reflex" in info

    def compute_truncated(self, achieved_goal: Array, desired_goal: Array, info: Mapping[str, Any]) -> bool:
        """Never; the wrapper TimeLimit does."""
        return False

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The overview with the goal as a ball, (480, 640, 3); None without a render mode."""
        return self._overviews()[0] if self.render_mode is not None else None

    def _observation(self) -> Observation:
        cell = self._cell
        parts: Observation = {
            "observation": cell.observe(with_object=not self._cameras)[0],
            "achieved_goal": cell.task.achieved(cell.rows)[0],
            "desired_goal": cell.goals[0].copy(),
        }
        for camera in self._cameras:
            parts[camera] = self._eyes[0].colour(camera, cell.task.marks(cell.goals[0]))
            if self._depth:
                parts[f"{camera}_depth"] = self._eyes[0].depth(camera)
        return parts

    def _info(self, observation: Observation) -> dict[str, Any]:
        info = self._cell.info(0)
        success = self._cell.task.success(observation["achieved_goal"], observation["desired_goal"])
        info["is_success"] = bool(success)
        return info
