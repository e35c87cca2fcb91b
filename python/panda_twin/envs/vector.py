"""Several robots as one Gymnasium vector environment, stepped by threads of C++ with the GIL released."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypedDict, Unpack

import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from .cell import Distribution
from .env import CommonEnv, Observation
from .tasks import Array, Flags, Task, field, names_of

Step = tuple[Observation, npt.NDArray[np.float64], Flags, Flags, dict[str, Any]]


class Options(TypedDict, total=False):
    """Parameters of PandaEnv beside its task."""

    reward: str
    control_hz: float
    interface: str
    observation: str
    delays: str | os.PathLike[str] | Mapping[str, Any] | None
    losses: float | Mapping[str, Any] | None
    viability: int | None
    randomize: Mapping[str, Distribution] | None
    cameras: Sequence[str]
    size: tuple[int, int]
    depth: bool
    render_mode: str | None


class PandaVectorEnv(CommonEnv, VectorEnv[Observation, npt.NDArray[np.float32], npt.NDArray[Any]]):
    """``num_envs`` robots with one task each; number i does what PandaEnv does with seed + i, to the bit.

    Results do not depend on the number of threads.

    Parameters
    ----------
    num_envs : int
        Number of robots.
    threads : int, optional
        Threads that step them, at most one per robot; default: one per processor that this process may use.
    max_episode_steps : int, optional
        Steps after which an episode is truncated.
    autoreset_mode : AutoresetMode or str
        NEXT_STEP (default), SAME_STEP or DISABLED, as Gymnasium defines them.

    The other parameters are those of :class:`~panda_twin.envs.env.PandaEnv`.
    """

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": 20,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        task: str | type[Task] = "Reach",
        num_envs: int = 1,
        *,
        threads: int | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **options: Unpack[Options],
    ) -> None:
        if threads is None:
            threads = max(1, min(num_envs, len(os.sched_getaffinity(0))))
        self.num_envs = self._count = num_envs
        self._threads = threads
        super().__init__(task, **options)
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata["autoreset_mode"] = self.autoreset_mode
        self.single_observation_space, self.single_action_space = self.observation_space, self.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._most_steps = max_episode_steps
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._is_over: Flags = np.zeros(num_envs, dtype=np.bool_)
        self._rngs: list[np.random.Generator] = []

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins episodes of all robots, or of those in ``options["reset_mask"]``; robot i has seed + i."""
        seeds: list[int | None]
        if seed is None:
            seeds = [None] * self.num_envs
        elif isinstance(seed, int):
            seeds = [seed + i for i in range(self.num_envs)]
        else:
            seeds = list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed: {len(seeds)} seeds for {self.num_envs} robots")
        mask = np.ones(self.num_envs, dtype=np.bool_)
        if options is not None and "reset_mask" in options:
            mask = np.asarray(options["reset_mask"], dtype=np.bool_)
            if mask.shape != (self.num_envs,):
                raise ValueError(f"reset_mask: its shape is {mask.shape}, not {(self.num_envs,)}")
            if not self._rngs and not mask.all():
                raise ValueError("reset_mask: the first reset begins episodes of all robots; leave the mask out")
        if not self._rngs:
            self._rngs = [seeding.np_random(one)[0] for one in seeds]
        else:
            for i, one in enumerate(seeds):
                if mask[i] and one is not None:
                    self._rngs[i] = seeding.np_random(one)[0]
        infos = self._begin(mask)
        observations = self._observations()
        return observations, self._infos(observations) | infos

    def step(self, actions: npt.NDArray[Any]) -> Step:
        """Steps all robots; those whose episode is over begin a new one, as ``autoreset_mode`` says."""
        if not self._rngs:
            raise ValueError("step: call reset() first")
        actions = np.asarray(actions, dtype=np.float64)
        if actions.shape != self.action_space.shape:
            raise ValueError(f"actions: their shape is {actions.shape}, not {self.action_space.shape}")
        next_step = self.autoreset_mode == AutoresetMode.NEXT_STEP
        fresh = self._is_over.copy() if next_step else np.zeros(self.num_envs, dtype=np.bool_)
        if not next_step and self.autoreset_mode == AutoresetMode.DISABLED and self._is_over.any():
            raise ValueError("step: episodes are over; reset them with options={'reset_mask': ...}")
        self._cell.step(actions, ~fresh)
        self._steps[~fresh] += 1
        infos = self._begin(fresh)
        observations = self._observations()
        goals = observations["achieved_goal"], observations["desired_goal"]
        rewards = self._cell.task.reward(*goals, self._is_sparse)
        rewards[fresh] = 0.0
        terminated = self._cell.ended()
        truncated = np.zeros(self.num_envs, dtype=np.bool_)
        if self._most_steps is not None:
            truncated = self._steps >= self._most_steps
        self._is_over = terminated | truncated
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._is_over.any():
            infos |= self._finals(observations)
            infos |= self._begin(self._is_over)
            observations = self._observations()
        return observations, rewards, terminated, truncated, self._infos(observations) | infos

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """The overview of every robot, (480, 640, 3); None without a render mode."""
        return self._overviews() if self.render_mode is not None else None

    def _begin(self, mask: Flags) -> dict[str, Any]:
        """Begins episodes of the robots in ``mask``. Returns what randomisation drew, as infos."""
        which = [int(i) for i in np.flatnonzero(mask)]
        if not which:
            return {}
        all_drawn = self._cell.reset(which, [self._rngs[i] for i in which])
        self._steps[mask] = 0
        self._is_over[mask] = False
        infos: dict[str, Any] = {}
        for i, drawn in zip(which, all_drawn, strict=True):
            if drawn:
                infos = self._add_info(infos, {"randomized": drawn}, i)
        return infos

    def _observations(self) -> Observation:
        cell = self._cell
        parts: Observation = {
            "observation": cell.observe(with_object=not self._cameras),
            "achieved_goal": cell.task.achieved(cell.rows),
            "desired_goal": cell.goals.copy(),
        }
        for camera in self._cameras:
            marks = [cell.task.marks(goal) for goal in cell.goals]
            parts[camera] = np.stack([eyes.colour(camera, at) for eyes, at in zip(self._eyes, marks, strict=True)])
            if self._depth:
                parts[f"{camera}_depth"] = np.stack([eyes.depth(camera) for eyes in self._eyes])
        return parts

    def _infos(self, observations: Observation) -> dict[str, Any]:
        rows, everyone = self._cell.rows, np.ones(self.num_envs, dtype=np.bool_)
        errors = np.empty(self.num_envs, dtype=object)
        errors[:] = [names_of(one) for one in rows[:, field("errors").start]]
        infos: dict[str, Any] = {
            "cycles_served": rows[:, field("served").start].astype(np.int64),
            "cycles_held": rows[:, field("held").start].astype(np.int64),
            "margin": rows[:, field("margin").start].copy(),
            "errors": errors,
            "contact_wrench": rows[:, field("contact")].copy(),
            "estimated_wrench": rows[:, field("wrench")].copy(),
            "is_success": self._cell.task.success(observations["achieved_goal"], observations["desired_goal"]),
        }
        infos |= {f"_{key}": everyone.copy() for key in infos}
        ended = self._cell.ended()
        if ended.any():
            reflexes = np.full(self.num_envs, None, dtype=object)
            for i in np.flatnonzero(ended):
                reflexes[i] = self._cell.robots.describe_errors(int(i))
            infos |= {"reflex": reflexes, "_reflex": ended}
        return infos

    def _finals(self, observations: Observation) -> dict[str, Any]:
        """Last observations and infos of the episodes that are over."""
        infos: dict[str, Any] = {}
        for i in map(int, np.flatnonzero(self._is_over)):
            last = {key: value[i].copy() for key, value in observations.items()}
            info = self._cell.info(i)
            info["is_success"] = bool(self._cell.task.success(last["achieved_goal"], last["desired_goal"]))
            infos = self._add_info(infos, {"final_obs": last, "final_info": info}, i)
        return infos
