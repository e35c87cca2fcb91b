"""Several robots in one scene, in this process."""

from __future__ import annotations

import os
import pathlib
import threading
import typing
from collections.abc import Callable, Iterator, Mapping

from . import _core
from ._closing import Closing
from ._robot import Robot
from .scenario import RobotLike, as_cell, checked_seed

T = typing.TypeVar("T")


class Robots(Mapping[str, Robot]):
    """The robots of a cell: name -> Robot, in the order of their names."""

    def __init__(self, robots: dict[str, Robot]) -> None:
        self._robots = robots

    def __getitem__(self, name: str) -> Robot:
        if name in self._robots:
            return self._robots[name]
        raise KeyError(f"unknown robot {name!r}; there are {', '.join(self._robots)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._robots)

    def __len__(self) -> int:
        return len(self._robots)

    def __repr__(self) -> str:
        return f"Robots({list(self)})"


class Cell(Closing):
    """Several robots in one scene, in this process and in lockstep: a scenario with the key `robots`.

    Each robot has the methods of a `Session`, but for `reset`, `snapshot` and `restore`. All have one
    time: while one moves, the others hold their position. Between two calls all have had the same number of cycles.
    `together` moves several at once. Robots that cannot reach each other, nor an object that another one reaches, move
    to the bit as each alone; the others touch each other and objects with real forces. A robot's `objects` are those that
    it, or a robot within its reach, can reach. `move_to` plans around the scene, but knows nothing of the other robots.

    Use one cell from one thread at a time (RuntimeError else).

    Parameters
    ----------
    scenario
        The name of its file, its keys, or its text. A robot's motion may be missing; it then rests at
        robot.q_start, which of keys is `model.Q_READY` by default.
    seed
        Of every random number, instead of the scenario's; a robot with a seed of its own keeps that.
    log
        Folder that gets, for each robot, a folder of its name with scenario.yaml and run.mcap, as `panda-twin run` leaves them.

    Raises
    ------
    ValueError
        When something of the scenario is wrong: file, line, key and cure.
    OSError
        When a file cannot be read or written.

    Examples
    --------
    >>> with Cell("cells/two_arms.yaml") as cell:
    ...     cell.robots["left"].wait(0.1)
    ...     cell.time
    0.1
    """

    def __init__(
        self,
        scenario: RobotLike,
        seed: int | None = None,
        log: str | os.PathLike[str] | None = None,
    ) -> None:
        text, file = as_cell(scenario)
        path = None if log is None else pathlib.Path(log)
        self._cell = _core.TwinCell(text, file, checked_seed(seed), path)
        self.robots: typing.Final = Robots({name: Robot(self._cell.robot(i), name) for i, name in enumerate(self._cell.names)})

    def __repr__(self) -> str:
        return f"Cell({self._cell.name!r}, {list(self.robots)}{', closed' if self.closed else ''})"

    if not typing.TYPE_CHECKING:

        def __getattr__(self, name: str) -> typing.Never:
            if hasattr(Robot, name) or name in ("hand", "objects"):
                raise AttributeError(f"a cell has no {name}; its robots have: cell.robots[{next(iter(self.robots))!r}].{name}")
            raise AttributeError(f"'Cell' object has no attribute {name!r}")

    @property
    def time(self) -> float:
        """Of all robots, s: a thousandth of the cycles that each has had."""
        return self._cell.now()

    def wait(self, seconds: float) -> None:
        """Let the time of all robots pass."""
        next(iter(self.robots.values())).wait(seconds)

    def together(self, /, **functions: Callable[[Robot], T]) -> dict[str, T]:
        """Call a function for each of several robots, all from one instant on, and wait for all.

        Each function runs in a thread, but only one at a time, in the order of the robots' names: another goes on when a
        call of this one has to let time pass. So the same functions give the same bits, and may share variables without locks. A
        function calls the robot that it got; to await something of another one, it lets time pass (`robot.wait(0.01)`).
        Robots without a function, and those whose function has returned, hold their position.

        When a function raises, the others' calls under way end as usual, and their next call raises `Cancelled`, which only
        `finally` should see. Ctrl-C stops all arms.

        Parameters
        ----------
        **functions
            By robot's name: ``together(left=lambda robot: robot.move(path), right=pick)``.

        Returns
        -------
        dict
            What each function has returned, by robot's name.

        Raises
        ------
        KeyError
            For a robot that there is not.
        Exception
            What the first function to fail has raised; what others raised stands in its notes.
        """
        names = sorted(functions)
        robots = [self.robots[name] for name in names]
        for name in names:
            if not callable(functions[name]):
                raise TypeError(f"together: {name} is of type {type(functions[name]).__name__}; a function of a Robot belongs here")
        results: dict[str, T] = {}
        errors: dict[str, BaseException] = {}

        def play(number: int) -> None:
            try:
                self._cell.enter(number)
                results[names[number]] = functions[names[number]](robots[number])
            except BaseException as error:
                errors[names[number]] = error
                self._cell.cancel()
            finally:
                self._cell.leave(number)

        order = list(self.robots)
        threads = [threading.Thread(target=play, args=(number,), name=name) for number, name in enumerate(names)]
        self._cell.gather([order.index(name) for name in names])
        try:
            for thread in threads:
                thread.start()
        except BaseException:
            self._cell.stop()
            raise
        finally:
            for number, thread in enumerate(threads):
                if thread.ident is None:  # it could not be started, and its function is cancelled
                    play(number)
            try:
                self._cell.await_end()
            finally:
                for thread in threads:
                    if thread.ident is not None:
                        thread.join()
        _raise_first(errors)
        return {name: results[name] for name in names}

    def close(self) -> None:
        """End the session of each robot and complete the logs. Once is enough; `with` does it."""
        self._cell.close()

    @property
    def closed(self) -> bool:
        """Whether it has ended."""
        return self._cell.closed


def _raise_first(errors: dict[str, BaseException]) -> None:
    """Raise the first error that is more than the end of a function after another's."""
    if not errors:
        return
    causes = [(name, error) for name, error in errors.items() if not isinstance(error, _core.Cancelled)]
    (name, first), *others = causes or errors.items()
    first.add_note(f"in the function of robot {name}")
    for other, error in others:
        first.add_note(f"robot {other} failed, too: {error!r}")
    raise first
