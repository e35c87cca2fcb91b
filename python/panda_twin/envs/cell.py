"""Robots with one task: actions in, rows of reports out. Both the environment and the vector of them stand on it."""

import json
import math
import operator
import os
import pathlib
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from . import tasks
from .tasks import Array, Flags

Distribution = tuple[float, float] | tuple[str, float, float] | Callable[[np.random.Generator], float]

_INTERFACES = ("cartesian_pose", "joint_position", "joint_velocity", "torque")
_RANDOM = ("load.mass", "object.mass", "friction", "delay", "loss", "q_start")
_Q_MIN = np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]) + 0.05
_Q_MAX = np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]) - 0.05
_TORQUE = np.array([20.0, 20.0, 20.0, 20.0, 5.0, 5.0, 5.0])
_SPEED = 0.5  # of a full action on the interface cartesian_pose, m/s
_TURN_SPEED = 1.0  # of a joint, rad/s
_MOST_SEED = 2**63
_MOST_ROBOTS = 10_000


def _number(distribution: Distribution, rng: np.random.Generator) -> float:
    """Draws a number of a distribution as environments take them."""
    if callable(distribution):
        return float(distribution(rng))
    if len(distribution) == 2:
        return float(rng.uniform(distribution[0], distribution[1]))
    law, a, b = distribution
    if law == "uniform":
        return float(rng.uniform(a, b))
    if law == "normal":
        return float(rng.normal(a, b))
    if law == "log_uniform":
        return float(np.exp(rng.uniform(np.log(a), np.log(b))))
    raise ValueError(f"randomize: the law {law!r} is unknown; say uniform, normal, log_uniform, or give a function")


def _is_number(value: Any) -> bool:
    return isinstance(value, Real)


def _check(key: str, distribution: Any) -> None:
    """Refuses what `_number` cannot draw from."""
    if callable(distribution):
        return
    laws = {"uniform", "normal", "log_uniform"}
    parts = tuple(distribution) if hasattr(distribution, "__len__") else ()
    law, *values = ("uniform", *parts) if len(parts) == 2 else parts or ("",)
    if not isinstance(law, str) or law not in laws or len(values) != 2 or not all(_is_number(x) and abs(x) < 1e300 for x in values):
        raise ValueError(
            f"randomize: {key} is {distribution!r}; give (low, high), (law, a, b) with law uniform, normal or log_uniform, "
            "or a function"
        )
    a, b = values
    if b < 0 if law == "normal" else not (a <= b and (a > 0 or law == "uniform")):
        raise ValueError(f"randomize: {key} is {distribution!r}; it must rise, log_uniform from above 0, normal with b >= 0")


def _loss_law(losses: float | Mapping[str, Any]) -> Any:
    if isinstance(losses, Mapping):
        return dict(losses)
    if not 0 <= losses <= 1:
        raise ValueError(f"losses: {losses} is no share of messages; give one in [0, 1], or a law as in scenarios")
    return f"{losses * 100:.12g} %"


def _scenario(
    task: tasks.Task,
    link: Mapping[str, Any] | None,
    losses: float | Mapping[str, Any] | None,
    viability: int | None,
    has_load: bool,
) -> str:
    sections: dict[str, Any] = {"link": dict(link) if link else {}}
    if losses is not None:
        sections["link"] |= {"state_loss": _loss_law(losses), "command_loss": _loss_law(losses)}
    robot: dict[str, Any] = {"q_start": {"unit": "rad", "values": list(task.q_start)}}
    if has_load:
        robot["load"] = {"mass": "0.001 kg", "position": ["0 m", "0 m", "0.1 m"]}
    sections["robot"] = robot
    sections["controller"] = {"rate": "200 Hz"}
    sections["tick"] = {"viability": "off" if viability is None else operator.index(viability)}
    text = f"name: {type(task).__name__.lower()}\n{task.scenario}"
    # JSON is YAML, too.
    return text + "".join(f"{key}: {json.dumps(value)}\n" for key, value in sections.items() if value)


class Cell:
    """``count`` robots that do one task, and what their actions mean.

    Parameters are those of :class:`~panda_twin.envs.env.PandaEnv`.
    """

    def __init__(
        self,
        task: str | type[tasks.Task],
        count: int,
        threads: int,
        *,
        control_hz: float,
        interface: str,
        delays: str | os.PathLike[str] | Mapping[str, Any] | None,
        losses: float | Mapping[str, Any] | None,
        viability: int | None,
        randomize: Mapping[str, Distribution] | None,
    ) -> None:
        if not 1 <= operator.index(count) <= _MOST_ROBOTS:
            raise ValueError(f"num_envs: {count!r} is no whole number from 1 to {_MOST_ROBOTS}")
        if not 5 <= control_hz <= 100:
            raise ValueError(f"control_hz: {control_hz} is not in [5, 100]")
        if interface not in _INTERFACES:
            raise ValueError(f"interface: {interface!r} is unknown; say one of {', '.join(_INTERFACES)}")
        self.task = tasks.make_task(task)
        title = type(self.task).__name__
        self.interface = interface
        self.randomize = dict(randomize or {})
        for key in self.randomize:
            if key not in _RANDOM:
                raise ValueError(f"randomize: {key!r} is unknown; say one of {', '.join(_RANDOM)}")
            _check(key, self.randomize[key])
            if key in ("object.mass", "friction") and self.task.object is None:
                raise ValueError(f"randomize: {key} needs an object, and {title} has none")
        self.cycles = round(1000 / control_hz)
        link = delays if isinstance(delays, Mapping) else None
        site = None if delays is None or isinstance(delays, Mapping) else pathlib.Path(delays)
        self.robots = _core.SteppedRobots(
            scenario=_scenario(self.task, link, losses, viability, "load.mass" in self.randomize),
            name=f"PandaTwin/{title}",
            interface=interface,
            cartesian_impedance=self.task.is_compliant,
            delays=site,
            count=count,
            threads=threads,
            grasp_force=self.task.grasp_force,
        )
        self.count = count
        self.rows: Array = np.zeros((count, self.robots.row_size))
        self.targets: Array = np.zeros((count, 8))
        self.goals: Array = np.zeros((count, 3))
        self._everyone: Flags = np.ones(count, dtype=np.bool_)
        self._low, self._high = np.array(self.task.low), np.array(self.task.high)
        self._period = self.cycles * 1e-3
        self.action_size = (3 if interface == "cartesian_pose" else 7) + int(self.task.has_fingers)
        self._lead = slice(0, 3 if interface == "cartesian_pose" else 7)
        self._observed = self._columns(with_object=True)
        self._felt = self._columns(with_object=False)
        if self.task.closes:
            self._close()

    def _columns(self, with_object: bool) -> npt.NDArray[np.intp]:
        names = ("position", "turn", "twist", "q", "dq", "width", "wrench")
        columns = [np.arange(s.start, s.stop) for s in map(tasks.field, names)]
        if with_object and self.task.object is not None:
            found = tasks.of_object(self.task.object_number, 0, tasks.OBJECT_SIZE)
            columns.append(np.arange(found.start, found.stop))
        return np.concatenate(columns)

    def _close(self) -> None:
        """Closes the hands, with the arms at rest, and keeps that as the start of episodes."""
        everyone = list(range(self.count))
        self.robots.reset(everyone, [self._start(0, {}, {}) for _ in everyone], self.rows)
        self._aim(everyone)
        self.targets[:, 7] = -1.0
        for _ in range(30):
            self.robots.step(self.targets, self._everyone, 50, self.rows)
        self.robots.keep_as_start()

    @staticmethod
    def _start(
        seed: int, places: Mapping[str, tasks.Place], drawn: Mapping[str, float], **more: Any
    ) -> _core.EpisodeStart:
        return _core.EpisodeStart(
            seed=seed,
            q=more.get("q"),
            places=dict(places),
            masses=more.get("masses", {}),
            frictions=more.get("frictions", {}),
            delay_s=drawn.get("delay"),
            loss=drawn.get("loss"),
        )

    def _aim(self, which: Sequence[int]) -> None:
        """Lets the targets begin where the robots' references are."""
        for i in which:
            self.targets[i] = 0.0
            if self.interface == "cartesian_pose":
                self.targets[i, :3] = self.rows[i, tasks.field("position_d")]
                self.targets[i, 3:7] = self.rows[i, tasks.field("turn_d")]
            elif self.interface == "joint_position":
                self.targets[i, :7] = self.rows[i, tasks.field("q_d")]

    def reset(self, which: Sequence[int], rngs: Sequence[np.random.Generator]) -> list[dict[str, float]]:
        """Begins episodes of the robots ``which``; ``rngs`` has one generator for each of them.

        Returns
        -------
        list of dict
            What domain randomisation drew, per robot.
        """
        starts: list[_core.EpisodeStart] = []
        all_drawn: list[dict[str, float]] = []
        for i, rng in zip(which, rngs, strict=True):
            draw = self.task.draw(rng)
            self.goals[i] = draw.goal
            drawn = {key: _number(law, rng) for key, law in self.randomize.items() if key != "q_start"}
            q = None
            if "q_start" in self.randomize:
                law = self.randomize["q_start"]
                q = [at + _number(law, rng) for at in self.task.q_start]
                if not np.all((_Q_MIN - 0.05 < q) & (q < _Q_MAX + 0.05)):
                    raise ValueError(f"randomize: q_start gives {np.round(q, 3)} rad, not inside the joints' limits")
            masses: dict[str, float] = {}
            frictions: dict[str, float] = {}
            if "load.mass" in drawn:
                masses["load"] = max(drawn["load.mass"], 0.001)
            if self.task.object is not None:
                if "object.mass" in drawn:
                    masses[self.task.object] = drawn["object.mass"]
                if "friction" in drawn:
                    frictions[self.task.object] = drawn["friction"]
            seed = int(rng.integers(_MOST_SEED))
            starts.append(self._start(seed, draw.places, drawn, q=q, masses=masses, frictions=frictions))
            all_drawn.append(drawn)
        self.robots.reset(list(which), starts, self.rows)
        self._aim(which)
        return all_drawn

    def step(self, actions: Array, mask: Flags | None = None) -> None:
        """Leads the robots in ``mask`` (default: all) by ``actions``, (count, action_size) in [-1, 1]."""
        actions = np.minimum(np.maximum(actions, -1.0), 1.0)  # several times faster than np.clip on a few numbers
        if not math.isfinite(actions.sum()):
            raise ValueError("action: it must be finite")
        led = self._led(actions)
        if mask is None:
            mask = self._everyone
            self.targets[:, self._lead] = led
        else:
            self.targets[mask, self._lead] = led[mask]
        if self.task.has_fingers:
            self.targets[mask, 7] = actions[mask, -1]
        self.robots.step(self.targets, mask, self.cycles, self.rows)

    def _led(self, actions: Array) -> Array:
        """The targets that actions lead to."""
        if self.interface == "cartesian_pose":
            led: Array = self.targets[:, :3] + actions[:, :3] * (_SPEED * self._period)
            led = np.minimum(np.maximum(led, self._low), self._high)
        elif self.interface == "joint_position":
            led = self.targets[:, :7] + actions[:, :7] * (_TURN_SPEED * self._period)
            led = np.minimum(np.maximum(led, _Q_MIN), _Q_MAX)
        else:
            led = actions[:, :7] * (_TURN_SPEED if self.interface == "joint_velocity" else _TORQUE)
        return led

    def observe(self, with_object: bool = True) -> Array:
        """What agents see of the robots, (count, observation_size): a copy.

        Pose and twist of the end effector, q, dq, the fingers' width and the estimated wrench; how far the target
        leads the end effector (or the joints; velocities and torques: the target itself); of an object its place from
        the end effector, pose and twist.
        """
        columns = self._observed if with_object else self._felt
        parts = [self.rows[:, columns], self.targets[:, self._lead]]
        if self.interface == "cartesian_pose":
            parts[1] = parts[1] - self.rows[:, tasks.field("position")]
        elif self.interface == "joint_position":
            parts[1] = parts[1] - self.rows[:, tasks.field("q")]
        if with_object and self.task.object is not None:
            place = tasks.of_object(self.task.object_number, 0, 3)
            parts.append(self.rows[:, place] - self.rows[:, tasks.field("position")])
        return np.concatenate(parts, axis=1)

    def observation_size(self, with_object: bool = True) -> int:
        """Columns of :meth:`observe`."""
        has_object = with_object and self.task.object is not None
        columns = self._observed if with_object else self._felt
        return len(columns) + (self._lead.stop - self._lead.start) + (3 if has_object else 0)

    def ended(self) -> Flags:
        """Robots whose motion the robot itself has ended, by a reflex or another error."""
        return np.asarray(self.rows[:, tasks.field("is_moving").start] == 0.0)

    def info(self, i: int) -> dict[str, Any]:
        """What a step came to, of robot ``i``: copies."""
        row = self.rows[i]

        def value(name: str) -> float:
            return float(row[tasks.field(name).start])

        info: dict[str, Any] = {
            "cycles_served": int(value("served")),
            "cycles_held": int(value("held")),
            "margin": value("margin"),
            "errors": tasks.names_of(value("errors")),
            "contact_wrench": row[tasks.field("contact")].copy(),
            "estimated_wrench": row[tasks.field("wrench")].copy(),
        }
        if value("is_moving") == 0:
            info["reflex"] = self.robots.describe_errors(i)
        return info

