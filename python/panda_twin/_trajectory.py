"""Paths through joint space."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from . import _core


class Trajectory(_core.Trajectory):
    """A joint-space path through waypoints, at rest at both ends, within the robot's limits.

    A quintic spline with continuous derivatives up to the fourth; of all paths through the points at
    their times it has the least integral of jerk squared.

    Parameters
    ----------
    waypoints
        Joint positions, shape (n, 7), n >= 2, rad.
    times
        Time of each waypoint, shape (n,), s, from 0 on and increasing. Without times each distance
        takes the time of its slowest joint, all of them stretched by one factor.
    duration
        Total time, s. With neither `times` nor `duration` the path is as fast as the shares of the
        limits allow.
    velocity_scale, acceleration_scale, jerk_scale
        Shares of the joint limits, each in (0, 1].

    Raises
    ------
    ValueError
        When a point or the path in between breaks a limit: point or time, joint, value and limit.

    Examples
    --------
    >>> rest = [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]
    >>> there = [0.3, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]
    >>> round(Trajectory([rest, there], duration=2).duration, 3)
    2.0
    """

    def __init__(
        self,
        waypoints: npt.ArrayLike,
        times: Sequence[float] | npt.NDArray[np.float64] | None = None,
        *,
        duration: float | None = None,
        velocity_scale: float = 0.5,
        acceleration_scale: float = 0.2,
        jerk_scale: float = 0.1,
    ) -> None:
        super().__init__(
            waypoints,
            None if times is None else [float(time) for time in times],
            duration,
            velocity_scale,
            acceleration_scale,
            jerk_scale,
        )
