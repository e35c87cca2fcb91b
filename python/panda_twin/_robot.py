"""A robot that moves in this process: its motions, hand and objects."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import RobotFault

Interface: TypeAlias = Literal["joint_position", "joint_velocity", "cartesian_pose", "torque"]
Impedance: TypeAlias = Literal["joint_impedance", "cartesian_impedance"]
Command: TypeAlias = (
    _core.Torques
    | _core.JointPositions
    | _core.JointVelocities
    | _core.CartesianPose
    | _core.CartesianVelocities
)
Law: TypeAlias = Callable[[_core.RobotState, float], Command]


class MotionFault(RobotFault):
    """A motion that did not end well.

    Attributes
    ----------
    motion : MotionResult
        How the motion went.
    errors : list of str
        Names of the errors that ended it, as clients of the real robot print them; empty when none did.
    """

    def __init__(self, motion: _core.MotionResult) -> None:
        super().__init__("; ".join([motion.failure, *map(str, motion.violations)]))
        self.motion = motion
        self.errors = motion.errors
        self._first = motion.violations[0] if motion.violations else None

    @property
    def error(self) -> str | None:
        """Name of the first error; None when no error ended the motion."""
        return self.errors[0] if self.errors else None

    @property
    def joint(self) -> int | None:
        """Joint that broke a limit, 1 to 7; None when the error is of no joint."""
        return self._first.joint if self._first else None

    @property
    def value(self) -> float | None:
        """Value that broke the limit, in the unit of `motion.violations`."""
        return self._first.value if self._first else None

    @property
    def limit(self) -> float | None:
        """Limit that was broken, in the same unit."""
        return self._first.limit if self._first else None

    @property
    def cycle(self) -> int | None:
        """Message id of the robot state of the cycle that raised the error."""
        return self._first.cycle if self._first else None


def _checked(motion: _core.MotionResult, check: bool) -> _core.MotionResult:
    if check and not motion.succeeded:
        raise MotionFault(motion)
    return motion


class Hand:
    """The Franka Hand or cobot pump of a session; each command waits, in the robot's time, until it ends."""

    def __init__(self, twin: _core.TwinSession) -> None:
        self._twin = twin

    @property
    def state(self) -> _core.HandState:
        """State of the hand now. ValueError: the robot has no hand."""
        return self._twin.hand_state()

    def homing(self) -> _core.HandOutcome:
        """Find both end stops of the fingers."""
        return self._ended(self._twin.homing())

    def move(self, width: float, *, speed: float = 0.1) -> _core.HandOutcome:
        """Move the fingers to an opening.

        Parameters
        ----------
        width
            Between the fingers, m, in [0, 0.08].
        speed
            Of the opening, m/s, above 0; cut to 0.1.
        """
        return self._ended(self._twin.move_hand(width, speed))

    def grasp(
        self,
        width: float,
        *,
        force: float,
        speed: float = 0.1,
        epsilon_inner: float = 0.005,
        epsilon_outer: float = 0.005,
    ) -> _core.HandOutcome:
        """Grasp an object and hold it.

        Parameters
        ----------
        width
            Of the object, m.
        force
            Of each finger, N, in (0, 140].
        speed
            As in `move`.
        epsilon_inner, epsilon_outer
            The grasp succeeds when the opening is in (width - epsilon_inner, width + epsilon_outer), m.

        Returns
        -------
        HandOutcome
            `succeeded` says whether something is held.
        """
        return self._ended(self._twin.grasp(width, speed, force, epsilon_inner, epsilon_outer))

    def vacuum(self, vacuum: float = 600, *, timeout: float = 1.0, profile: int = 0) -> _core.HandOutcome:
        """Suck an object on and hold it, with a cobot pump.

        Parameters
        ----------
        vacuum
            Set point, mbar, to the nearest 10; the pump reaches 750.
        timeout
            Seconds to hold an object; else it is unsuccessful, and sucks no more.
        profile
            Of the pump's settings, 0 to 3; all are the same.
        """
        return self._ended(self._twin.vacuum(round(vacuum / 10), profile, round(1000 * timeout)))

    def drop_off(self, *, timeout: float = 1.0) -> _core.HandOutcome:
        """Let the object go, with a cobot pump.

        Parameters
        ----------
        timeout
            Seconds to be rid of the vacuum.
        """
        return self._ended(self._twin.drop_off(round(1000 * timeout)))

    def stop(self) -> _core.HandOutcome:
        """Stop pressing, or sucking."""
        return self._ended(self._twin.stop_hand())

    @staticmethod
    def _ended(outcome: _core.HandOutcome) -> _core.HandOutcome:
        if outcome.failure:
            raise _core.RobotFault(f"hand: {outcome.failure}")
        return outcome


class Objects(Mapping[str, npt.NDArray[np.float64]]):
    """The scene's free bodies: name -> pose (4, 4) in the world, m.

    An assignment puts a body at rest, between two motions. It raises ValueError for an unknown name
    and where the body would lie in another.
    """

    def __init__(self, twin: _core.TwinSession) -> None:
        self._twin = twin

    def __getitem__(self, name: str) -> npt.NDArray[np.float64]:
        return self._twin.bodies()[name]

    def __setitem__(self, name: str, pose: npt.ArrayLike) -> None:
        self._twin.place(name, pose)

    def __iter__(self) -> Iterator[str]:
        return iter(self._twin.bodies())

    def __len__(self) -> int:
        return len(self._twin.bodies())

    def __repr__(self) -> str:
        return f"Objects({list(self)})"


class Robot:
    """A robot on which motions follow each other in simulated time: that of a `Session`, or one of a `Cell`.

    Time stands still between two calls. Ctrl-C stops the arm and raises KeyboardInterrupt from any call,
    and the robot can go on.
    """

    def __init__(self, twin: _core.TwinSession, name: str) -> None:
        self._twin = twin
        self._name = name
        self.hand = Hand(twin)
        self.objects = Objects(twin)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._name!r}{', closed' if self._twin.closed else ''})"

    @property
    def state(self) -> _core.RobotState:
        """The robot's last state; no time passes. In real time the next one."""
        return self._twin.state()

    @property
    def time(self) -> float:
        """Of the session, s; a restored snapshot takes it back."""
        return self._twin.now()

    def move(
        self,
        trajectory: _core.Trajectory | None = None,
        interface: Interface = "joint_position",
        *,
        impedance: Impedance = "joint_impedance",
        name: str = "",
        check: bool = True,
    ) -> _core.MotionResult:
        """Move along a trajectory, and on until the arm rests.

        Loop, tick and timing of the controller are the scenario's.

        Parameters
        ----------
        trajectory
            Begins where the arm stands, within 1 mrad. None: the scenario's own motion, planned if the
            scenario says so; the other parameters then count for nothing.
        interface
            What is commanded. On "torque" a PD law follows the path.
        impedance
            The robot's own controller.
        name
            For the log.
        check
            Raise when the motion fails; False: see the result.

        Raises
        ------
        MotionFault
            A RobotFault: the motion was aborted, or did not end.
        RobotFault
            The robot refuses the motion: after an abort call `recover` first.
        ValueError
            The motion cannot start from here.
        """
        if trajectory is None:
            return _checked(self._twin.move_own(), check)
        if not isinstance(trajectory, _core.Trajectory):
            raise TypeError(f"trajectory is of type {type(trajectory).__name__}; a panda_twin.Trajectory belongs here: Trajectory(waypoints)")
        return _checked(self._twin.move(trajectory, interface, impedance, name), check)

    def move_to(
        self,
        q: npt.ArrayLike,
        interface: Interface = "joint_position",
        *,
        velocity_scale: float = 0.5,
        acceleration_scale: float = 0.2,
        jerk_scale: float = 0.1,
        clearance: float = 0.01,
        check: bool = True,
    ) -> _core.MotionResult:
        """Plan a motion to a configuration around the scene as it is now, and move.

        What the hand holds goes with it.

        Parameters
        ----------
        q
            Goal, shape (7,), rad.
        velocity_scale, acceleration_scale, jerk_scale
            Shares of the joint limits, each in (0, 1].
        clearance
            From everything, m, in [0.001, 0.1].

        Raises
        ------
        ValueError
            Start or goal is in collision (with what) or beyond a limit.
        RobotFault
            No path was found; otherwise as `move`.
        """
        return _checked(
            self._twin.move_to(q, interface, velocity_scale, acceleration_scale, jerk_scale, clearance),
            check,
        )

    def control(
        self,
        law: Law,
        until: float | None = None,
        *,
        impedance: Impedance = "joint_impedance",
        tick: Mapping[str, Any] | None = None,
        check: bool = True,
    ) -> _core.MotionResult:
        """Move the arm by a function that is called once a cycle, as a callback of libfranka.

        Time waits for the function, so its speed does not matter. It may not use the session.

        Parameters
        ----------
        law
            `law(state, dt)` returns Torques, JointPositions, JointVelocities, CartesianPose or
            CartesianVelocities. The type of the first one decides on the interface. The first call comes before the
            motion, with dt = 0; dt is then 1e-3 s times the cycles since the last call. A command that is
            `finished` ends the motion, once the robot has reached it.
        until
            The motion ends after this time, s. None: when the law has finished.
        impedance
            The robot's own controller; of no meaning with torques.
        tick
            Keys of the section `tick` of a scenario, instead of the scenario's section:
            ``{"generator": "none", "limiter": True}`` is what libfranka does.

        Raises
        ------
        TypeError, ValueError
            The law returned something else, or numbers of another shape, or not finite.
        Exception
            What the law raises, unchanged; the robot has been stopped as by a client that stops.
        MotionFault
            As `move`.
        """
        section = None if tick is None else json.dumps(dict(tick))
        return _checked(self._twin.control(law, until, impedance, section), check)

    def wait(self, seconds: float) -> None:
        """Let the robot's time pass."""
        self._twin.wait(seconds)

    def recover(self) -> None:
        """Bring a robot that stopped by a reflex back to Idle.

        Raises
        ------
        RobotFault
            The robot refuses, or has not become Idle within 5 s.
        """
        self._twin.recover()

    def user_stop(self, on: bool) -> None:
        """Press the user stop, or release it."""
        self._twin.user_stop(on)

    def reset(self, q: npt.ArrayLike | None = None) -> None:
        """Begin anew: the arm at rest, objects and hand as at the beginning. Time goes on. Not of a cell's robot.

        Parameters
        ----------
        q
            Where the arm shall rest, shape (7,), rad; None: where the scenario has it.
        """
        self._twin.reset(q)

    def snapshot(self) -> _core.Snapshot:
        """A copy of the whole twin and of the session's time and counts; a few MB. Not of a cell's robot."""
        return self._twin.save()

    def restore(self, snapshot: _core.Snapshot) -> None:
        """Go back to a snapshot of this session: the same calls then give the same bits, each time."""
        self._twin.restore(snapshot)

    @property
    def result(self) -> _core.SessionResult:
        """How the session went, once it is closed; ValueError before."""
        return self._twin.result

    @property
    def states_hash(self) -> str:
        """Fingerprint of all states, once the session is closed, as `panda-twin run` prints it."""
        return self.result.states_hash
