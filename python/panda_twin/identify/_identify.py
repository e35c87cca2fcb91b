"""Identification: friction, load, delay, elasticity, armature and inertia out of a log, and what of them it cannot tell."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.linalg import qr  # type: ignore[import-untyped]
from scipy.optimize import least_squares  # type: ignore[import-untyped]

from ._causes import residual_of
from ._model import FRICTION, STEEP, TwinModel, friction_torque
from ._regression import QUANTILE, Estimate, fit
from ._rows import Rows, regressor
from ._terms import ALL, BODY, Columns, Delay, Friction, Inertia, Load, Parameter, SmoothFriction, Term

Array: TypeAlias = npt.NDArray[np.float64]

KINDS = ("friction", "load", "delay", "elasticity", "armature", "inertia")
_LEAST_MASS = 1e-3  # kg: a lighter load is none
_PART = 5.0  # s: of each two such parts one fits and the other judges
_BODY_SCALE = np.array([scale for _, _, scale in BODY])


@dataclasses.dataclass(frozen=True)
class Identified:
    """What was identified."""

    estimates: list[Estimate]
    """One for the torques; one each for elasticity and armature, where the log has their signals."""
    friction: Array | None
    """(5, 7), as `FRICTION` of the model."""
    load: Array | None
    """(10,): the feasible body on the flange that is nearest to the estimate."""
    links: Array | None
    """(70,): feasible links nearest to the estimate and to the twin's."""
    delay: float | None
    stiffness: Array | None
    armature: Array | None
    held_out: tuple[Array, Array] | None
    """Root of the mean square of each joint's torque residual on parts that did not fit, before and after, (7,) each, Nm."""
    untold: list[str]
    """What the log cannot tell, in words."""


def base_of_links() -> tuple[npt.NDArray[np.int64], Array]:
    """Which parameters of the links stand for the base parameters, and how the others count in them: (k,), (k, 70).

    By a pivoted QR of random motions (Gautier 1991), in the order of what moves the torques most.
    """
    random = np.random.default_rng(1)
    Y = regressor(random.uniform(-2, 2, (200, 7)), random.uniform(-2, 2, (200, 7)), random.uniform(-5, 5, (200, 7)), (0, 0, -9.81))
    scale = np.tile(_BODY_SCALE, 7)
    R, order = qr(Y[:, :, :70].reshape(-1, 70) * scale, mode="economic", pivoting=True)[1:]
    rank = int(np.sum(np.abs(np.diag(R)) > 1e-9 * abs(R[0, 0])))
    share = np.zeros((rank, 70))
    share[:, order[:rank]] = np.eye(rank)
    share[:, order[rank:]] = np.linalg.solve(R[:rank, :rank], R[:rank, rank:])
    return np.asarray(order[:rank]), share / scale * scale[order[:rank], None]


def friction_terms(rows: Rows, torque: Array, others: Sequence[Term]) -> list[Term]:
    """Each joint's friction law as the log supports it: viscous + Coulomb + offset, or the sigmoid where that is clearly better (BIC)."""
    plain = fit(rows, torque, [Friction(), *others])
    own = plain.residual + Friction().at(rows, np.nan_to_num(plain.values[:21]))[0]
    start = np.stack([_sigmoid_near(rows, own[:, joint], joint) for joint in ALL], axis=1)
    smooth = fit(rows, torque, [SmoothFriction(ALL, start), *others])
    least = 1e-300  # of a log without noise
    gain = len(rows) * np.log(np.maximum(np.sum(plain.residual**2, axis=0), least) / np.maximum(np.sum(smooth.residual**2, axis=0), least))
    told = smooth.told[:35].reshape(5, 7).all(axis=0) & (np.nan_to_num(smooth.values[21:28]) > 0)
    # Four times what two more coefficients cost: laws this close to each other predict the same.
    is_smooth = told & (gain > 4 * 2 * np.log(len(rows)))
    law = np.nan_to_num(smooth.values[:35].reshape(5, 7))
    kept: list[Term] = []
    if is_smooth.any():
        kept.append(SmoothFriction(np.flatnonzero(is_smooth).tolist(), law))
    if not is_smooth.all():
        kept.append(Friction(np.flatnonzero(~is_smooth).tolist()))
    return kept


def _sigmoid_near(rows: Rows, torque: Array, joint: int) -> Array:
    """The law (5,) of one joint on a grid of steepness and shift: where the search begins."""
    grid = [(steepness, shift) for steepness in np.geomspace(3, STEEP, 12) for shift in np.linspace(-0.06, 0.06, 5)]
    steepness, shift = np.array(grid).T

    def basis(dq: Array) -> Array:
        v = dq[:, joint, None]
        return np.concatenate([np.tanh(steepness * (v + shift) / 2) - np.tanh(steepness * shift / 2), v, np.ones_like(v)], axis=1)

    columns = rows.of_velocity(basis)
    fits = []
    for i in range(len(grid)):
        X = columns[:, [-2, i, -1]]
        values, *_ = np.linalg.lstsq(X, torque, rcond=None)
        fits.append((float(np.sum((torque - X @ values) ** 2)), values, grid[i]))
    _, values, best = min(fits, key=lambda one: one[0])
    return np.concatenate([values, best])


def _terms(rows: Rows, torque: Array, kinds: set[str]) -> list[Term]:
    terms: list[Term] = []
    if "load" in kinds:
        terms.append(Load())
    if "inertia" in kinds:
        terms.append(Inertia(*base_of_links()))
    if "delay" in kinds:
        terms.append(Delay())
    if "friction" in kinds:
        terms = [*friction_terms(rows, torque, terms), *terms]
    return terms


def _torque_left(rows: Rows, kinds: set[str], twin: TwinModel) -> Array:
    """What is measured less what the twin says of all that is not identified."""
    parameters = twin.parameters - (np.concatenate([np.zeros(70), twin.load]) if "load" in kinds else 0)
    torque: Array = rows.tau_at(0.0 if "delay" in kinds else twin.torque_delay) - rows.Y @ parameters
    return torque if "friction" in kinds else torque - rows.of_velocity(lambda dq: friction_torque(twin.friction, dq))


def identify(rows: Rows, twin: TwinModel, kinds: set[str]) -> Identified:
    """Fit what is asked for, and judge it on parts of the log that did not fit.

    Raises
    ------
    ValueError
        For load and inertia together.
    """
    if {"load", "inertia"} <= kinds:
        raise ValueError("a load is part of link 7 to every motion: identify inertia with a known load, or load with known links, in two steps")
    untold: list[str] = []
    estimates: list[Estimate] = []
    of_torque = kinds & {"friction", "load", "delay", "inertia"}
    friction = load = links = held_out = None
    delay: float | None = None
    if of_torque:
        torque = _torque_left(rows, of_torque, twin)
        terms = _terms(rows, torque, of_torque)
        estimate = fit(rows, torque, terms)
        estimates.append(estimate)
        untold += [f"{p.text} (the motion does not excite it)" for p, told in zip(estimate.parameters, estimate.told) if not told]
        held_out = _judge(rows, torque, terms, twin)
        friction = _friction_of(estimate, twin) if "friction" in kinds else None
        if any(told and p.key.startswith("load") for p, told in zip(estimate.parameters, estimate.told)):
            mass, sd = estimate.of("load.m")[0], estimate.sd[[p.key == "load.m" for p in estimate.parameters]][0]
            is_there = not mass < max(_LEAST_MASS, QUANTILE * sd)
            load = nearest_feasible(_part(estimate, "load"), twin.load, 1) if is_there else np.zeros(10)
        if "inertia" in kinds:
            links = _links_of(estimate, twin)
        if "delay" in kinds and np.isfinite(value := estimate.of("plant.delay")[0]):
            delay = max(0.0, float(value))
    stiffness = _stiffness(rows, estimates, untold) if "elasticity" in kinds else None
    armature = _armature(rows, estimates, untold) if "armature" in kinds else None
    return Identified(estimates, friction, load, links, delay, stiffness, armature, held_out, untold)


def _judge(rows: Rows, torque: Array, terms: list[Term], twin: TwinModel) -> tuple[Array, Array] | None:
    fits = (rows.t / _PART).astype(int) % 2 == 0
    if np.sum(fits) < 50 or np.sum(~fits) < 50:
        return None
    before = residual_of(rows, twin)
    after = fit(rows, torque, terms, use=fits).residual
    before_rms, after_rms = (np.sqrt(np.mean(x[~fits] ** 2, axis=0)) for x in (before, after))
    return before_rms, after_rms


def _friction_of(estimate: Estimate, twin: TwinModel) -> Array | None:
    """The law of all joints: the twin's own of those that the log does not tell; None when it tells none."""
    law = np.zeros((5, 7))
    law[3] = STEEP
    for parameter, value in zip(estimate.parameters, estimate.values):
        for i, name in enumerate(FRICTION):
            if parameter.key.startswith(f"plant.friction.{name}["):
                law[i, int(parameter.key[-2])] = value
    told = np.isfinite(law).all(axis=0)
    law[:2] = np.maximum(law[:2], 0)
    return np.where(told, law, twin.friction) if told.any() else None


@dataclasses.dataclass(frozen=True)
class _Part:
    """What is known of some parameters: values and information matrix, in their scales."""

    values: Array
    information: Array


def _part(estimate: Estimate, prefix: str) -> _Part:
    chosen = np.array([p.key.startswith(prefix) for p in estimate.parameters])
    scale = np.array([p.scale for p in estimate.parameters])[chosen]
    covariance = estimate.covariance[np.ix_(chosen, chosen)] / np.outer(scale, scale)
    told = estimate.told[chosen]
    information = np.zeros_like(covariance)
    information[np.ix_(told, told)] = np.linalg.inv(covariance[np.ix_(told, told)] + 1e-14 * np.eye(int(told.sum())))
    return _Part(np.nan_to_num(estimate.values[chosen]) / scale, information)


def _body(x: Array) -> Array:
    """Ten parameters of a body from its logarithmic Cholesky ones: always feasible (Rucker and Wensing, RA-L 2022)."""
    alpha, d1, d2, d3, s12, s23, s13, t1, t2, t3 = x
    U = np.exp(alpha) * np.array([[np.exp(d1), s12, s13, t1], [0, np.exp(d2), s23, t2], [0, 0, np.exp(d3), t3], [0, 0, 0, 1]])
    J = U @ U.T  # the pseudo-inertia
    sigma, h, m = J[:3, :3], J[:3, 3], J[3, 3]
    inertia = np.trace(sigma) * np.eye(3) - sigma
    return np.concatenate([[m], h, inertia[np.triu_indices(3)]])


def _logarithms(body: Array) -> Array:
    """The inverse of `_body` for a feasible body, after the least change that makes it one."""
    inertia = np.zeros((3, 3))
    inertia[np.triu_indices(3)] = body[4:]
    inertia = inertia + np.triu(inertia, 1).T
    J = np.zeros((4, 4))
    J[:3, :3] = np.trace(inertia) / 2 * np.eye(3) - inertia
    J[:3, 3] = J[3, :3] = body[1:4]
    J[3, 3] = body[0]
    values, vectors = np.linalg.eigh(J)
    J = (vectors * np.maximum(values, 1e-6)) @ vectors.T
    flip = np.eye(4)[::-1]
    U = flip @ np.linalg.cholesky(flip @ J @ flip) @ flip  # upper triangular, J = U U^T
    a = U[3, 3]
    U = U / a
    return np.array([np.log(a), np.log(U[0, 0]), np.log(U[1, 1]), np.log(U[2, 2]), U[0, 1], U[1, 2], U[0, 2], U[0, 3], U[1, 3], U[2, 3]])


def nearest_feasible(known: _Part, prior: Array, bodies: int, share: Array | None = None) -> Array:
    """Bodies that exist (positive mass, a possible inertia), nearest to an estimate and, where it says nothing, to others.

    Parameters
    ----------
    known
        Of parameters that are `share` (k, 10 bodies) times those of the bodies, in their scales; of themselves without.
    prior
        (10 bodies,), with the parameters' scales as standard deviations.
    """
    scale = np.tile(_BODY_SCALE, bodies)
    root = np.linalg.cholesky(known.information + 1e-9 * np.eye(len(known.values))).T
    to_known = np.eye(len(scale)) if share is None else share * scale

    def difference(x: Array) -> Array:
        theta = np.concatenate([_body(part) for part in x.reshape(bodies, 10)]) / scale
        result: Array = np.concatenate([root @ (to_known @ theta - known.values), 1e-1 * (theta - prior / scale)])
        return result

    # At least 4 mg, and a millimetre of gyration about every axis: thinner bodies are none to the engine.
    low, high = np.tile([-6.2, -7.0, -7.0, -7.0, *[-20.0] * 6], bodies), np.full(len(scale), 5.0)
    guess = prior if share is not None else np.nan_to_num(known.values * scale)
    x0 = np.concatenate([_logarithms(body) for body in guess.reshape(bodies, 10)])
    found = least_squares(difference, np.clip(x0, low, high), bounds=(low, high), x_scale="jac", max_nfev=100).x
    return np.concatenate([_body(part) for part in found.reshape(bodies, 10)])


def _links_of(estimate: Estimate, twin: TwinModel) -> Array:
    _, share = base_of_links()
    known = _part(estimate, "base")
    scale = np.array([p.scale for p in estimate.parameters if p.key.startswith("base")])
    shifted = _Part(known.values + share @ twin.arm / scale, known.information)
    return nearest_feasible(shifted, twin.arm, 7, share / scale[:, None])


def _missing(name: str, column: str, untold: list[str]) -> None:
    untold.append(f"{name} (the log has no {column})")


def _stiffness(rows: Rows, estimates: list[Estimate], untold: list[str]) -> Array | None:
    """k of theta = q + tau_J / k; None where the log has no theta, infinite where motor and link move as one."""
    if "theta" not in rows.beside:
        _missing("stiffness of the joints", "theta", untold)
        return None
    twist = rows.beside["theta"] - rows.beside["q"]
    if np.all(np.abs(twist) < 1e-9):
        return np.full(7, np.inf)
    tau = np.zeros((len(rows), 7, 14))
    for joint in ALL:
        tau[:, joint, joint] = rows.tau_at(0.0)[:, joint]
        tau[:, joint, 7 + joint] = 1
    parameters = [Parameter(f"plant.elasticity[{i}]", f"compliance of joint {i + 1}", "rad/Nm", 1e-3) for i in ALL]
    parameters += [Parameter(f"theta.offset[{i}]", f"offset of theta of joint {i + 1}", "rad", 0.1) for i in ALL]
    estimate = fit(dataclasses.replace(rows, noise=None), twist, [Columns("elasticity", tau, parameters)])
    estimates.append(estimate)
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness: Array = np.where(estimate.values[:7] > 0, 1 / estimate.values[:7], np.nan)
    return stiffness


def _armature(rows: Rows, estimates: list[Estimate], untold: list[str]) -> Array | None:
    """Inertia of the rotors: what INT commands less what the sensors behind the gear see, against the acceleration."""
    if "tau_J_d" not in rows.beside:
        _missing("armature", "tau_J_d", untold)
        return None
    columns = np.zeros((len(rows), 7, 7))
    for joint in ALL:
        columns[:, joint, joint] = rows.ddq[:, joint]
    rotor = Columns("armature", columns, [Parameter(f"plant.armature[{i}]", f"armature of joint {i + 1}", "kg m^2", 0.5) for i in ALL])
    # Friction of motor and gear that the robot does not make up for is in the same difference.
    estimate = fit(dataclasses.replace(rows, noise=None), rows.beside["tau_J_d"] - rows.tau_at(0.0), [rotor, Friction()])
    estimates.append(estimate)
    untold += [p.text for p, told in zip(estimate.parameters[:7], estimate.told) if not told]
    return np.maximum(estimate.values[:7], 0)
