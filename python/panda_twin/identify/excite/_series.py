"""Fourier series of seven joints (Swevers et al., IEEE T-RA 1997) that begin and end at rest in one pose, within limits."""

from __future__ import annotations

import dataclasses
import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]

RAMP = 2.0
"""Time in which the series fades in, and out, s."""
POSITION_MARGIN = 0.05
"""Distance from the ends of the joints' ranges, rad."""
_SPARE = 0.98  # of the allowed rates: peaks lie between samples
_GRID = 0.02  # s, of the search for peaks
# From 0 to 1 with four derivatives of 0 at both ends.
_FADE = np.polynomial.Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])


@dataclasses.dataclass(frozen=True)
class JointBounds:
    """What the joints may do: positions (rad), and magnitudes of velocity, acceleration and jerk (rad/s, ...), (7,) each."""

    q_min: Array
    q_max: Array
    rates: tuple[Array, Array, Array]


def fade(t: Array, seconds: float) -> list[Array]:
    """The window at times t, and three derivatives."""
    up, down = np.clip(t / RAMP, 0, 1), np.clip((seconds - t) / RAMP, 0, 1)
    rising = t < seconds / 2
    return [np.where(rising, _FADE.deriv(d)(up), (-1) ** d * _FADE.deriv(d)(down)) / RAMP**d for d in range(4)]


def basis(t: Array, seconds: float, period: float, terms: int) -> list[Array]:
    """Columns 1, cos and sin of each harmonic, times the window: (n, 1 + 2 terms), with three derivatives."""
    rate = 2 * np.pi / period * np.arange(1, terms + 1)
    phase = rate * (t[:, None] - RAMP)
    harmonics = []
    for d in range(4):
        turned = phase + d * np.pi / 2
        constant = np.full((len(t), 1), 1.0 if d == 0 else 0.0)
        harmonics.append(np.hstack([constant, rate**d * np.cos(turned), rate**d * np.sin(turned)]))
    window = fade(t, seconds)
    return [np.sum([math.comb(d, i) * window[d - i][:, None] * harmonics[i] for i in range(d + 1)], axis=0) for d in range(4)]


class Series:
    """q(t) = start + window(t) (c + sum over k of a_k cos(k w (t - ramp)) + b_k sin(k w (t - ramp))).

    Parameters
    ----------
    start : ndarray, shape (7,)
        Pose at both ends, rad.
    seconds : float
        Of the whole motion.
    terms : int
        Harmonics.
    period : float
        Of the base frequency, s.
    """

    def __init__(self, start: Array, seconds: float, terms: int, period: float) -> None:
        self.start, self.seconds, self.terms, self.period = start, seconds, terms, period
        self._peaks = basis(np.linspace(0, seconds, round(seconds / _GRID) + 1), seconds, period, terms)

    def at(self, coefficients: Array, t: Array) -> tuple[Array, Array, Array, Array]:
        """Position, velocity, acceleration and jerk at times t, (n, 7) each. `coefficients`: (1 + 2 terms, 7), rad."""
        q, *rates = (one @ coefficients for one in basis(t, self.seconds, self.period, self.terms))
        dq, ddq, dddq = rates
        return self.start + q, dq, ddq, dddq

    def within(self, coefficients: Array, bounds: JointBounds) -> Array:
        """The same series, joint by joint as much smaller as it must be to stay within bounds."""
        positions, *derivatives = (one @ coefficients for one in self._peaks)
        shares = [np.max(np.abs(one), axis=0) / limit for one, limit in zip(derivatives, bounds.rates)]
        shares.append(positions.max(axis=0) / (bounds.q_max - self.start))
        shares.append(-positions.min(axis=0) / (self.start - bounds.q_min))
        return np.asarray(coefficients * np.minimum(1, _SPARE / np.maximum(np.max(shares, axis=0), 1e-12)))
