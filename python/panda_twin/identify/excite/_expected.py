"""What a motion will tell before a robot moves: the standard deviation of every parameter that `compare` estimates of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .._identify import base_of_links
from .._model import TwinModel, _friction
from .._regression import QUANTILE, _solve
from .._rows import _MARGIN, ROW, TICK, Motion, Rows, rows_of
from .._terms import ALL, Friction, Inertia, Load, Parameter, SmoothFriction, Term
from ._series import Series

Array: TypeAlias = npt.NDArray[np.float64]

KINDS = ("friction", "load", "inertia")
_REST = 0.5  # s: at rest before and after
_BLOCK = 10_000  # ticks


@dataclasses.dataclass(frozen=True)
class Expected:
    """Of one model of the torques."""

    parameters: list[Parameter]
    sd: Array
    """(k,); NaN where the motion cannot tell."""
    condition: float
    """Condition number of the weighted regressor, its columns scaled to a norm of 1."""


def terms_of(kind: str, smooth: bool = False) -> list[Term]:
    """What is fitted to a log of that kind. `smooth`: friction by the sigmoid, about the published one."""
    friction: Term = SmoothFriction(ALL, _friction("residual")) if smooth else Friction()
    if kind == "load":
        return [friction, Load()]
    return [friction, Inertia(*base_of_links())] if kind == "inertia" else [friction]


def _motions(series: Series, coefficients: Array, tau_J: Array | None) -> Iterator[Motion]:
    n = ticks_of(series)
    overlap = 2 * (_MARGIN + ROW)
    for begin in range(0, n, _BLOCK):
        places = np.arange(max(0, begin - overlap), min(n, begin + _BLOCK))
        if len(places) <= 2 * _MARGIN:
            continue
        t = np.asarray(places * TICK, np.float64)
        q, dq, ddq, _ = series.at(coefficients, np.asarray(np.clip(t - _REST, 0, series.seconds)))
        tau = np.zeros_like(q) if tau_J is None else tau_J[places]
        yield Motion(t, np.ones(len(t), bool), q, dq, ddq, {"tau_J": tau})


def ticks_of(series: Series) -> int:
    """Rows of the log that a motion makes, with half a second of rest at both ends."""
    return round((series.seconds + 2 * _REST) / TICK)


def rows_of_series(series: Series, coefficients: Array, twin: TwinModel, tau_J: Array | None = None) -> Rows:
    """The rows that `compare` makes of the motion's log; tau_J (ticks_of(series), 7), Nm, is 0 by default."""
    return rows_of(_motions(series, coefficients, tau_J), twin)


def expected_of(rows: Rows, terms: Sequence[Term], noise: float) -> Expected:
    """Standard deviations of least squares on these rows where each tau_J has white noise of `noise` Nm at 1 kHz.

    Filter and rows are the estimator's: the noise of neighbouring rows is correlated, and counts so.
    What the estimator would call untold is untold.
    """
    parameters = [parameter for term in terms for parameter in term.parameters]
    scale = np.array([parameter.scale for parameter in parameters])
    X = np.concatenate([term.at(rows, term.start())[1] for term in terms], axis=2) * scale
    share = np.sqrt((rows._fast[0][1].power(2)).sum(axis=1).max())  # of the noise that passes the filter
    weight = np.full(X.shape[:2], 1 / (share * noise) ** 2)
    _, inverse, told = _solve(X, np.zeros(X.shape[:2]), weight, None)
    meat = np.zeros_like(inverse)
    begin = 0
    for _, low_pass in rows._fast:
        end = begin + low_pass.shape[0]
        for joint in ALL:
            passed = low_pass.T @ X[begin:end, joint]
            meat += passed.T @ passed
        begin = end
    covariance = inverse @ meat @ inverse * noise**2 * weight[0, 0] ** 2
    sd = np.sqrt(np.diag(covariance))
    told = told & (QUANTILE * sd < 1)
    flat = X.reshape(-1, X.shape[2])
    norms = np.linalg.norm(flat, axis=0)
    condition = float(np.linalg.cond(flat / np.where(norms > 0, norms, 1)))
    return Expected(parameters, np.where(told, sd * scale, np.nan), condition)
