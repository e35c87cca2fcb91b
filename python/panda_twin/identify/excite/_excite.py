"""Design of excitation: a motion whose log tells of friction, a load or the links as much as limits and surroundings let it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .._identify import base_of_links
from .._model import STEEP, TwinModel, _friction
from .._rows import regressor
from ._clearance import Clearance
from ._expected import KINDS, terms_of
from ._series import POSITION_MARGIN, RAMP, JointBounds, Series, basis

Array: TypeAlias = npt.NDArray[np.float64]

# Limits of the Panda: rad/s, rad/s^2, rad/s^3 (models/robots/panda/limits.yaml).
_RATES = (np.array([2.175] * 4 + [2.61] * 3), np.array([15, 7.5, 10, 12.5, 15, 20, 20]),
          np.array([7500, 3750, 5000, 6250, 7500, 10000, 10000.0]))  # fmt: skip
# Fastest harmonic, Hz. Friction wants slow passages, a load the accelerations of the wrist; the estimator sees up to 8 Hz.
_FASTEST = {"friction": 0.5, "load": 1.0, "inertia": 0.8}
_SAMPLES = 160  # of one period
_STARTS = 4
_FIRST, _THEN = 250, 2500  # steps of the search from each start, and from the best of them
_BREACH = 300.0  # cost of a m too near, in factors e of the summed variances
_SHRINK = 0.92


@dataclasses.dataclass(frozen=True)
class Design:
    """A designed motion."""

    series: Series
    coefficients: Array
    """(1 + 2 terms, 7), rad."""

    def points(self, step: float = 0.02) -> tuple[Array, Array]:
        """Times (n,) and positions (n, 7), a point every `step` seconds."""
        n = round(self.series.seconds / step)
        t = np.linspace(0, self.series.seconds, n + 1)
        q = self.series.at(self.coefficients, t)[0]
        q[0] = q[-1] = self.series.start
        return t, q


def bounds_of(q_min: Array, q_max: Array, speed: float, joint_speed: Array) -> JointBounds:
    """A share of the robot's limits, and a lab's cap on the joints' speed."""
    velocity, acceleration, jerk = (speed * rate for rate in _RATES)
    return JointBounds(q_min + POSITION_MARGIN, q_max - POSITION_MARGIN, (np.minimum(velocity, joint_speed), acceleration, jerk))


def series_for(kind: str, start: Array, seconds: float, terms: int) -> Series:
    """The shortest period that is a whole part of the motion and asks for no harmonic too fast.

    Raises
    ------
    ValueError
        When the motion is too short for so many harmonics.
    """
    if kind not in KINDS:
        raise ValueError(f'--for is "{kind}"; it must be one of {", ".join(KINDS)}')
    if not 1 <= terms <= 20:
        raise ValueError(f"--terms is {terms}; it must be from 1 to 20")
    least = terms / _FASTEST[kind]
    periods = int((seconds - 2 * RAMP) / least + 1e-9) if np.isfinite(seconds) else 0
    if periods < 1:
        raise ValueError(f"--seconds is {seconds:g}: {terms} terms for {kind} take at least {least + 2 * RAMP:g} s, "
                         "one period and both ramps; give it more time, or fewer --terms")  # fmt: skip
    if seconds > 600:
        raise ValueError(f"--seconds is {seconds:g}; it must be at most 600")
    return Series(start, seconds, terms, (seconds - 2 * RAMP) / periods)


def _information(kind: str, twin: TwinModel) -> Callable[[Array, Array, Array], Array]:
    """What samples (n, 7) tell of the parameters in their scales: (k, k), friction first; of friction alone (7, 5, 5)."""
    scale = np.array([p.scale for term in terms_of(kind, smooth=kind == "friction") for p in term.parameters])
    law = _friction("residual")
    leading = base_of_links()[0] if kind == "inertia" else np.arange(70, 80)

    def of_friction(q: Array, dq: Array, ddq: Array) -> Array:
        # As SmoothFriction has it.
        _, coulomb, _, steepness, shift = law
        s, s0 = np.tanh(steepness * (dq + shift) / 2), np.tanh(steepness * shift / 2)
        slope, slope0 = (1 - s**2) / 2, (1 - s0**2) / 2
        X = np.stack([dq, s - s0, np.ones_like(dq), coulomb * (slope * (dq + shift) - slope0 * shift),
                      coulomb * steepness * (slope - slope0)], axis=2) * scale[::7]  # fmt: skip
        return np.asarray(X.transpose(1, 2, 0) @ X.transpose(1, 0, 2))

    def of_bodies(q: Array, dq: Array, ddq: Array) -> Array:
        X = np.zeros((len(q), 7, 21 + len(leading)))
        for joint in range(7):
            X[:, joint, joint : 21 : 7] = np.stack([dq[:, joint], np.tanh(STEEP / 2 * dq[:, joint]), np.ones(len(q))], axis=1)
        X[:, :, 21:] = regressor(q, dq, ddq, twin.g_earth)[:, :, leading]
        flat = X.reshape(-1, X.shape[2]) * scale
        return np.asarray(flat.T @ flat)

    return of_friction if kind == "friction" else of_bodies


def design(
    kind: str, series: Series, bounds: JointBounds, clearance: Clearance, twin: TwinModel, noise: float, seed: int
) -> Design:
    """Search for coefficients: random starts, then steps on one joint at a time that are kept where they are better.

    Better is a smaller sum of the variances of the parameters wanted, each in its own scale (A-optimal), friction being fitted
    beside them, and no breach of the clearance. The same arguments give the same motion.
    """
    random = np.random.default_rng(seed)
    information = _information(kind, twin)
    t = np.linspace(RAMP, RAMP + series.period, _SAMPLES, endpoint=False)
    samples = basis(t, series.seconds, series.period, series.terms)
    each = series.seconds * 1000 / _SAMPLES / noise**2
    wanted = slice(None) if kind == "friction" else slice(21, None)

    def motion(coefficients: Array) -> tuple[Array, Array, Array]:
        q, dq, ddq = (one @ coefficients for one in samples[:3])
        return series.start + q, dq, ddq

    def cost(coefficients: Array) -> float:
        q, dq, ddq = motion(coefficients)
        told = information(q, dq, ddq) * each
        variance = np.diagonal(np.linalg.inv(told + np.eye(told.shape[-1])), axis1=-2, axis2=-1)[..., wanted]
        return float(np.log(np.sum(variance))) + _BREACH * clearance.breach(q, dq)

    def improved(best: Array, value: float, steps: int) -> tuple[Array, float]:
        size = np.full(7, 0.3)
        for _ in range(steps):
            joint = int(random.integers(7))
            tried = best.copy()
            tried[:, joint] += size[joint] * random.normal(size=len(best)) * spread
            tried = series.within(tried, bounds)
            new = cost(tried)
            if new < value:
                best, value = tried, new
                size[joint] = min(1.0, size[joint] * 1.5)
            else:
                size[joint] = max(0.01, size[joint] * 0.93)
        return best, value

    # Harmonics of like speed.
    order = np.arange(1, series.terms + 1)
    spread = np.concatenate([[1.0], 1 / order, 1 / order])
    found = []
    for _ in range(_STARTS):
        first = series.within(random.normal(size=(len(spread), 7)) * spread[:, None], bounds)
        # From a breach the way out is shorter.
        while clearance.breach(*motion(first)[:2]) > 0.05 and np.abs(first).max() > 0.05:
            first = 0.8 * first
        found.append(improved(first, cost(first), _FIRST))
    best, _ = improved(*min(found, key=lambda one: one[1]), _THEN)
    return Design(series, best)


def freed(found: Design, check: Callable[[Design], None]) -> Design:
    """The motion, as much smaller about its start as the program's check demands.

    Raises
    ------
    ValueError
        What the check says of the smallest one tried.
    """
    for _ in range(25):
        try:
            check(found)
            return found
        except ValueError as error:
            said = error
            found = dataclasses.replace(found, coefficients=_SHRINK * found.coefficients)
    raise ValueError(f"no motion about this start keeps within the limits, not even a small one: {said}")
