"""What the environments ask for: scenes, goals, rewards. All of it works on rows, one per robot."""

import dataclasses
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from .. import _core

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Place = tuple[float, ...]

_FIELDS: dict[str, tuple[int, int]] = _core.step_fields()
REPORT_SIZE = sum(size for _, size in _FIELDS.values())
OBJECT_SIZE = 13

# The tool points down, the fingers close along x; the point between their tips is at (0.5, 0, 0.475) m.
_HOME = (0.0, -0.19371, 0.0, -1.90879, 0.0, 1.71508, -0.7854)


# A compliant arm: stiff enough to lead a box, soft enough that touching it is no collision.
_SOFT = "onboard: {K_x: {translation: 800 N/m, rotation: 50 Nm/rad}}\n"


def field(name: str) -> slice:
    """Columns of a row that hold a member of the step's report (``StepReport`` of the C++ library)."""
    begin, size = _FIELDS[name]
    return slice(begin, begin + size)


def of_object(number: int, begin: int, end: int) -> slice:
    """Columns of an object: position 0-3, quaternion w x y z 3-7, twist 7-13."""
    first = REPORT_SIZE + number * OBJECT_SIZE
    return slice(first + begin, first + end)


def _far(achieved: Array, desired: Array) -> Array:
    """Distance of the first three columns, by sums that do not depend on the number of rows."""
    way = achieved - desired
    return np.sqrt(way[..., 0] ** 2 + way[..., 1] ** 2 + way[..., 2] ** 2)


@dataclasses.dataclass(frozen=True)
class Draw:
    """What is drawn for an episode."""

    goal: Array
    places: dict[str, Place]


class Task:
    """A task: its scene, and how well rows of reports do.

    Positions are in the base's frame O, in m. A task of your own is a class derived from this one, with `draw` and `achieved`:
    ``gymnasium.make("PandaTwin/Reach-v0", task=MyTask)``. Goals are 3 numbers. `field` says which columns of a row hold what.
    """

    scenario: ClassVar[str] = ""
    """Keys of the scenario besides name, robot, link and tick (``models/scenarios/KEYS.md``)."""
    q_start: ClassVar[tuple[float, ...]] = _HOME
    low: ClassVar[tuple[float, float, float]] = (0.3, -0.3, 0.2)
    """Least position that an action leads the end effector to."""
    high: ClassVar[tuple[float, float, float]] = (0.7, 0.3, 0.7)
    object: ClassVar[str | None] = None
    """Name of the body that the task is about."""
    object_number: ClassVar[int] = 0
    has_fingers: ClassVar[bool] = False
    """Whether actions command the hand."""
    closes: ClassVar[bool] = False
    """Whether the hand closes before the first episode."""
    is_compliant: ClassVar[bool] = False
    """Whether the robot controls by Cartesian impedance."""
    threshold: ClassVar[float] = 0.05
    grasp_force: ClassVar[float] = 30.0

    def draw(self, rng: np.random.Generator) -> Draw:
        """Draws goal and places of an episode."""
        raise NotImplementedError

    def achieved(self, rows: Array) -> Array:
        """What has been achieved: (n, goal size), a copy."""
        raise NotImplementedError

    def distance(self, achieved: Array, desired: Array) -> Array:
        """How far it is from the goal, m; of goals (..., size)."""
        return _far(achieved, desired)

    def success(self, achieved: Array, desired: Array) -> Flags:
        """Whether a goal is achieved."""
        return np.asarray(self.distance(achieved, desired) < self.threshold)

    def marks(self, goal: Array) -> list[tuple[float, float, float]]:
        """Points that pictures show of a goal."""
        return [(float(goal[0]), float(goal[1]), float(goal[2]))]

    def reward(self, achieved: Array, desired: Array, is_sparse: bool) -> Array:
        """0 at the goal and -1 elsewhere, or the negative distance."""
        if is_sparse:
            return np.asarray(self.success(achieved, desired), dtype=np.float64) - 1.0
        return -self.distance(achieved, desired)


class Reach(Task):
    """The point between the fingertips to a point in the air."""

    def draw(self, rng: np.random.Generator) -> Draw:
        return Draw(rng.uniform((0.35, -0.2, 0.3), (0.65, 0.2, 0.6)), {})

    def achieved(self, rows: Array) -> Array:
        return rows[:, field("position")].copy()


class Push(Task):
    """A box of 50 mm and 100 g along a table to a place, by closed fingers."""

    scenario = "scene: scenes/table_push.xml\n" + _SOFT
    is_compliant = True
    low = (0.36, -0.28, 0.32)
    high = (0.64, 0.28, 0.5)
    grasp_force = 5.0
    object = "box"
    closes = True

    def draw(self, rng: np.random.Generator) -> Draw:
        box = rng.uniform((0.42, -0.15), (0.58, 0.15))
        goal = rng.uniform((0.42, -0.2), (0.58, 0.2))
        place = (float(box[0]), float(box[1]), 0.325, 1.0, 0.0, 0.0, 0.0)
        return Draw(np.array([goal[0], goal[1], 0.325]), {"box": place})

    def achieved(self, rows: Array) -> Array:
        return rows[:, of_object(0, 0, 3)].copy()


class PickAndPlace(Push):
    """The box to a place on the table or, every second time, in the air."""

    high = (0.64, 0.28, 0.6)
    scenario = "scene: scenes/table_box.xml\n"
    is_compliant = False
    closes = False
    has_fingers = True

    def draw(self, rng: np.random.Generator) -> Draw:
        draw = super().draw(rng)
        if rng.random() < 0.5:
            draw.goal[2] += rng.uniform(0.0, 0.2)
        return draw


class Peg(Task):
    """A square peg of 20 mm, held by the hand, into a hole with 1 mm of play on each side."""

    scenario = "scene: scenes/table_peg.xml\n"
    q_start = (0.0, -0.17269, 0.0, -2.14889, 0.0, 1.9762, -0.7854)
    low = (0.36, -0.28, 0.33)
    high = (0.64, 0.28, 0.55)
    object = "peg"
    object_number = 1
    closes = True
    threshold = 0.008
    grasp_force = 40.0

    def draw(self, rng: np.random.Generator) -> Draw:
        x, y = rng.uniform((0.46, 0.1), (0.54, 0.2))
        fixture = (float(x), float(y), 0.305, 1.0, 0.0, 0.0, 0.0)
        return Draw(np.array([x, y, 0.36]), {"fixture": fixture})

    def achieved(self, rows: Array) -> Array:
        return rows[:, of_object(1, 0, 3)].copy()


class Wipe(Task):
    """Closed fingers to a point of a table, pressing with a force: goals are x, y and newtons.

    The force is the robot's own estimate, along the table's normal.
    """

    scenario = (
        "objects: [{name: table, shape: box, size: [0.3 m, 0.6 m, 0.3 m], on: ground, position: [0.5 m, 0 m, 0 m]}]\n"
        "onboard: {K_x: {translation: 600 N/m, rotation: 30 Nm/rad}}\n"
    )
    low = (0.38, -0.25, 0.27)
    high = (0.62, 0.25, 0.48)
    closes = True
    is_compliant = True
    threshold = 0.02
    _M_PER_N: ClassVar[float] = 0.005

    def draw(self, rng: np.random.Generator) -> Draw:
        return Draw(rng.uniform((0.42, -0.2, 4.0), (0.58, 0.2, 9.0)), {})

    def achieved(self, rows: Array) -> Array:
        position, wrench = field("position").start, field("wrench").start
        goal = rows[:, [position, position + 1, wrench + 2]]
        goal[:, 2] *= -1.0
        return goal

    def distance(self, achieved: Array, desired: Array) -> Array:
        scale = np.array([1.0, 1.0, self._M_PER_N])
        return _far(achieved * scale, desired * scale)

    def marks(self, goal: Array) -> list[tuple[float, float, float]]:
        return [(float(goal[0]), float(goal[1]), 0.3)]


TASKS: dict[str, type[Task]] = {task.__name__: task for task in (Reach, Push, PickAndPlace, Peg, Wipe)}


def make_task(task: str | type[Task]) -> Task:
    """The task of that name or class."""
    if isinstance(task, type) and issubclass(task, Task):
        return task()
    if task not in TASKS:
        raise ValueError(f"task: {task!r} is unknown; say one of {', '.join(TASKS)}, or give a class derived from panda_twin.envs.Task")
    return TASKS[task]()


def names_of(errors: Any) -> list[str]:
    """Names of the errors in a row's column ``errors``."""
    return list(_core.error_names(int(errors)))
