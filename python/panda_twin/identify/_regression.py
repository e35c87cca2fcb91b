"""Robust least squares of joint torques, with intervals that hold where the noise is coloured."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ._rows import Rows
from ._terms import Parameter, Term

Array: TypeAlias = npt.NDArray[np.float64]

QUANTILE = 1.959964
"""Of the normal distribution: 95 % intervals are this many standard deviations to both sides."""
_HUBER = 2.5  # standard deviations: beyond, a residual counts by its size, not its square
_LAGS = 8  # rows: residuals further apart count as independent
_STEPS = 20
_NOISY = 0.02  # of the information in a direction, at most, may be noise: as large is the share by which it is underestimated
_LEAST_SD = 1e-5  # Nm: below this, arithmetic is what is fitted


@dataclasses.dataclass(frozen=True)
class Estimate:
    """What a log says of some parameters."""

    parameters: list[Parameter]
    values: Array
    """(k,); NaN where the log cannot tell."""
    covariance: Array
    """(k, k)."""
    told: npt.NDArray[np.bool_]
    """(k,): whether the log can tell it."""
    residual: Array
    """(n, 7), Nm."""

    @property
    def sd(self) -> Array:
        """Standard deviations."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0))

    def of(self, prefix: str) -> Array:
        """Values of the parameters whose key begins so."""
        return self.values[[p.key.startswith(prefix) for p in self.parameters]]


def spread_of(residual: Array) -> Array:
    """Standard deviation of each column, robust against outliers."""
    return np.maximum(1.4826 * np.median(np.abs(residual), axis=0), _LEAST_SD)


def fit(rows: Rows, torque: Array, terms: Sequence[Term], use: npt.NDArray[np.bool_] | None = None) -> Estimate:
    """Fit terms to torques.

    Each joint weighs by its own noise, an outlier less (Huber). Directions of the parameters that the motion does not excite are left
    out and said to be untold. The covariance is that of a sandwich (White 1980) with Bartlett weights over 0.32 s (Newey and West 1987).

    Parameters
    ----------
    rows
        Of the log.
    torque : ndarray, shape (n, 7)
        What the terms are to explain, Nm.
    terms
        What is fitted; linear ones, and ones that are linearised again in each step.
    use : ndarray of bool, shape (n,)
        Rows that count; all by default. The residual is that of all rows.
    """
    parameters = [parameter for term in terms for parameter in term.parameters]
    scale = np.array([parameter.scale for parameter in parameters])
    counted = np.ones(len(rows), bool) if use is None else use
    theta = np.concatenate([term.start() for term in terms])
    for step in range(_STEPS):
        at = _evaluate(rows, terms, theta)
        X = at[1][counted] * scale
        r = (torque - at[0])[counted]
        sigma = spread_of(r)
        weight = np.minimum(1, _HUBER / np.maximum(np.abs(r) / sigma, 1e-12)) / sigma**2
        change, inverse, told = _solve(X, r, weight, _by_noise(rows, terms, theta, scale, sigma))
        cost = float(np.sum(weight * r**2))
        while np.any(np.abs(change) > 1e-6) and _cost(rows, torque, terms, theta + change * scale, weight, counted) > cost * (1 + 1e-9):
            change = change / 2
        theta = theta + change * scale
        # Far below what the noise makes of it.
        if step > 1 and np.all(np.abs(change) <= 0.02 * np.sqrt(np.diag(inverse))):
            break
    at = _evaluate(rows, terms, theta)
    residual = torque - at[0]
    X = at[1][counted] * scale
    covariance = _sandwich(X, residual[counted], weight, inverse, rows.block[counted])
    covariance = covariance * np.outer(scale, scale)
    told = told & (QUANTILE * np.sqrt(np.maximum(np.diag(covariance), 0)) < scale)
    return Estimate(parameters, np.where(told, theta, np.nan), covariance, told, residual)


def _evaluate(rows: Rows, terms: Sequence[Term], theta: Array) -> tuple[Array, Array]:
    torque, columns, begin = np.zeros((len(rows), 7)), [], 0
    for term in terms:
        end = begin + len(term.parameters)
        part, slope = term.at(rows, theta[begin:end])
        torque = torque + part
        columns.append(slope)
        begin = end
    return torque, np.concatenate(columns, axis=2) if columns else np.zeros((len(rows), 7, 0))


def _cost(rows: Rows, torque: Array, terms: Sequence[Term], theta: Array, weight: Array, counted: npt.NDArray[np.bool_]) -> float:
    return float(np.sum(weight * (torque - _evaluate(rows, terms, theta)[0])[counted] ** 2))


def _by_noise(rows: Rows, terms: Sequence[Term], theta: Array, scale: Array, sigma: Array) -> Array | None:
    """The part of the normal matrix that the sensors' noise alone makes."""
    if rows.noise is None:
        return None
    part, shaken = (_evaluate(some, terms, theta)[1] * scale for some in rows.noise)
    difference = ((part - shaken) / sigma[:, None]).reshape(-1, len(scale))
    return np.asarray(difference.T @ difference * (len(rows) / len(part)))


def _solve(X: Array, r: Array, weight: Array, by_noise: Array | None) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
    """A step, the inverse of the normal matrix where the rows tell something, and which parameters they tell.

    A direction that is excited by noise more than by the motion is not told: least squares would find too little of it.
    """
    flat = (X * np.sqrt(weight)[:, :, None]).reshape(-1, X.shape[2])
    right = (r * np.sqrt(weight)).ravel()
    A = flat.T @ flat
    values, vectors = np.linalg.eigh(A)
    # In units of scales: a direction whose standard deviation would be a hundred scales is not there.
    kept = values > max(1e-4, 1e-13 * values[-1])
    dropped = vectors[:, ~kept]
    white = vectors[:, kept] / np.sqrt(values[kept])  # A becomes the identity
    if by_noise is not None:
        share, axes = np.linalg.eigh(white.T @ by_noise @ white)
        noisy = white @ axes[:, share > _NOISY]
        dropped = np.concatenate([dropped, noisy / np.maximum(np.linalg.norm(noisy, axis=0), 1e-300)], axis=1)
        white = white @ axes[:, share <= _NOISY]
    inverse = white @ white.T
    lost = np.sum(np.linalg.qr(dropped)[0] ** 2, axis=1) if dropped.shape[1] else np.zeros(len(A))
    return inverse @ (flat.T @ right), inverse, lost < 1e-3


def _sandwich(X: Array, r: Array, weight: Array, inverse: Array, block: npt.NDArray[np.int64]) -> Array:
    scores = np.einsum("njk,nj->nk", X, weight * r)
    meat = scores.T @ scores
    for lag in range(1, _LAGS + 1):
        same = block[lag:] == block[:-lag]
        part = scores[lag:][same].T @ scores[:-lag][same]
        meat += (1 - lag / (_LAGS + 1)) * (part + part.T)
    # As if each joint's rows had to bear all parameters: the noise of neighbouring rows and joints is not independent.
    n, k = len(X), X.shape[2]
    free = n / max(n - k, 1)
    covariance: Array = inverse @ meat @ inverse * free
    return covariance
