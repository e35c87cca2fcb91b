"""Mistakes in a log's columns: what it would be if joints were swapped, or units others than said."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ._causes import Cause, residual_of
from ._model import TwinModel
from ._rows import Motion, rows_of

Array: TypeAlias = npt.NDArray[np.float64]

_TICKS = 5000  # of the motion that is tried
_MUCH = 0.1  # of the squared residual may remain behind the mistake


@dataclasses.dataclass(frozen=True)
class _Mistake:
    name: str
    words: str
    remedy: str
    mend: Callable[[Motion], Motion]
    scale: float = 1.0
    """Of torques, behind the mend."""


def _of_joints(motion: Motion, change: Callable[[Array], Array]) -> Motion:
    """The motion with all signals of joints (n, 7) changed."""
    others = {name: change(values) if values.ndim == 2 and values.shape[1] == 7 else values for name, values in motion.others.items()}
    return dataclasses.replace(motion, q=change(motion.q), dq=change(motion.dq), ddq=change(motion.ddq), others=others)


def _swapped(i: int, j: int) -> _Mistake:
    order = list(range(7))
    order[i], order[j] = j, i

    def mend(motion: Motion) -> Motion:
        return _of_joints(motion, lambda values: values[:, order])

    return _Mistake("swapped joints", f"the columns of joints {i + 1} and {j + 1} are swapped", f"name the columns of joint {i + 1} and {j + 1} the other way round in the mapping", mend)


def _scaled(name: str, words: str, remedy: str, positions: float, torques: float) -> _Mistake:
    def mend(motion: Motion) -> Motion:
        others = {key: values * torques if key.startswith("tau") else values for key, values in motion.others.items()}
        return dataclasses.replace(motion, q=motion.q * positions, dq=motion.dq * positions, ddq=motion.ddq * positions, others=others)

    return _Mistake(name, words, remedy, mend, torques)


def _turned(joint: int) -> _Mistake:
    sign = np.ones(7)
    sign[joint] = -1

    def mend(motion: Motion) -> Motion:
        return _of_joints(motion, lambda values: values * sign)

    return _Mistake("direction of a joint", f"joint {joint + 1} counts in the other direction", f"turn the sign of all columns of joint {joint + 1}", mend)


def _mistakes() -> list[_Mistake]:
    return [
        _scaled("degrees", "positions and velocities are in degrees, not in rad", "map q and dq with unit: deg and deg/s", np.pi / 180, 1),
        _scaled("torque unit", "torques are in mNm, not in Nm", "map tau_J with unit: mNm", 1, 1e-3),
        *[_swapped(i, j) for i, j in itertools.combinations(range(7), 2)],
        *[_turned(joint) for joint in range(7)],
    ]


def mistake_of(motions: Sequence[Motion], twin: TwinModel) -> Cause | None:
    """Name the mistake that explains why a log is far from its twin; None when none does."""
    motion = _liveliest(motions)
    try:
        before = _size(motion, twin)
        tried = [(_size(mistake.mend(motion), twin) / mistake.scale**2, mistake) for mistake in _mistakes()]
    except ValueError:  # a stretch too short
        return None
    after, best = min(tried, key=lambda one: one[0])
    return Cause(best.name, best.words, best.remedy, 1 - after / before) if after < _MUCH * before else None


def _liveliest(motions: Sequence[Motion]) -> Motion:
    """The stretch with the most motion, at most `_TICKS` long."""
    motion = max(motions, key=lambda one: float(np.sum(np.abs(np.diff(one.q[::100], axis=0)))))
    if len(motion.t) <= _TICKS:
        return motion
    steps = np.abs(np.diff(motion.q, axis=0)).sum(axis=1)
    way = np.concatenate([[0], np.cumsum(steps)])
    begin = int(np.argmax(way[_TICKS:] - way[:-_TICKS]))
    part = slice(begin, begin + _TICKS)
    return Motion(motion.t[part], motion.is_whole[part], motion.q[part], motion.dq[part], motion.ddq[part], {name: values[part] for name, values in motion.others.items()})


def _size(motion: Motion, twin: TwinModel) -> float:
    """Sum of squares of what the twin does not explain."""
    return float(np.sum(residual_of(rows_of([motion], twin), twin) ** 2))
