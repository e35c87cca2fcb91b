"""What may make a robot differ from its twin, one cause at a time, ordered by how much it explains."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .. import model
from ._model import TwinModel, body_of, body_parameters, friction_torque
from ._regression import QUANTILE, Estimate, fit, spread_of
from ._rows import Rows
from ._terms import ALL, Columns, Delay, Friction, Load, Parameter, Term

Array: TypeAlias = npt.NDArray[np.float64]

_SMALLEST = 2e-3  # Nm: what no torque sensor of the robot tells from nothing
_MOST_SCALE = 0.6  # by which a mass or a sensor is off
_BY_PROFILE = "robot: {{profile: profile.yaml}}  # by --identify {} --write profile.yaml"
_LEAST_SHARE = 0.02  # of the squared residual that is left: a cause of less is not named
_LEAST_OF_ALL = 0.002  # of the whole


@dataclasses.dataclass(frozen=True)
class Cause:
    """A cause, with what it explains."""

    name: str
    """"friction of joint 3", "load", "gravity direction", ..."""
    words: str
    """What was found, with its interval: "joint 3 has 0.20 +- 0.01 Nm more Coulomb friction"."""
    remedy: str
    """What to put into the scenario, or what to do."""
    share: float
    """Of the squared torque residual that is there before it, 0 to 1."""


@dataclasses.dataclass(frozen=True)
class _Candidate:
    term: Term
    tell: Callable[[Estimate], tuple[str, str]]
    most: float = math.inf
    """A value beyond it has another cause."""


def _between(value: float, sd: float, unit: str) -> str:
    return f"{value:+.3g} +- {QUANTILE * sd:.1g} {unit}" if np.isfinite(value) else f"an unknown number of {unit}"


def _values(numbers: Array, unit: str) -> str:
    return "[" + ", ".join(f"{x:.4g}{unit}" for x in numbers) + "]"


def _friction(joint: int) -> _Candidate:
    def tell(e: Estimate) -> tuple[str, str]:
        parts = [f"{_between(v, s, p.unit)} {p.text.partition(' of joint')[0]}" for v, s, p in zip(e.values, e.sd, e.parameters) if np.isfinite(v) and abs(v) > QUANTILE * s]
        return f"joint {joint + 1} differs in friction by {', '.join(parts) or 'little'}", _BY_PROFILE.format("friction")

    return _Candidate(Friction([joint]), tell)


def _scaled(name: str, columns: Array, key: str, words: str, remedy: Callable[[float], str]) -> _Candidate:
    def tell(e: Estimate) -> tuple[str, str]:
        return words.format(_between(100 * e.values[0], 100 * e.sd[0], "%")), remedy(e.values[0])

    return _Candidate(Columns(name, columns[:, :, None], [Parameter(key, name, "", 1.0)]), tell, _MOST_SCALE)


def _tilt(rows: Rows, twin: TwinModel) -> _Candidate:
    def tell(e: Estimate) -> tuple[str, str]:
        degrees = np.degrees(np.nan_to_num(e.values))
        words = (f"gravity points {math.hypot(*degrees):.2f} deg away: the base is tilted by {_between(degrees[0], math.degrees(e.sd[0]), 'deg')} roll "
                 f"and {_between(degrees[1], math.degrees(e.sd[1]), 'deg')} pitch")
        roll, pitch = twin.tilt + np.radians(degrees)
        return words, f"plant: {{base_tilt: {{roll: {roll:.4f} rad, pitch: {pitch:.4f} rad}}}}, or level the base"

    return _Candidate(Columns("gravity direction", rows.tilt, [Parameter(f"plant.base_tilt.{k}", k, "rad", 0.3) for k in ("roll", "pitch")]), tell)


def _delay(twin: TwinModel) -> _Candidate:
    def tell(e: Estimate) -> tuple[str, str]:
        delay = twin.torque_delay + float(np.nan_to_num(e.values[0]))
        if delay < 0:
            return f"torques come {_between(-1e3 * e.values[0], 1e3 * e.sd[0], 'ms')} earlier than the twin's", "check the stamps of q against those of tau_J"
        return f"torques come {_between(1e3 * e.values[0], 1e3 * e.sd[0], 'ms')} later than the twin's", f"plant: {{delay: {{tau_J: {1e3 * delay:.2f} ms}}}}"

    return _Candidate(Delay(), tell)


def _load(twin: TwinModel) -> _Candidate:
    def tell(e: Estimate) -> tuple[str, str]:
        mass, centre, _ = body_of(np.nan_to_num(twin.load + np.nan_to_num(e.values)))
        more = float(np.nan_to_num(e.values[0]))
        who, other = ("the flange", "the twin") if more >= 0 else ("the twin", "the robot")
        words = f"{who} carries {_between(abs(more), e.sd[0], 'kg')} that {other} does not"
        return words, f"robot: {{load: {{mass: {max(mass, 0):.3f} kg, position: {_values(centre, ' m')}}}}}"

    return _Candidate(Load(), tell)


def _hand(rows: Rows, twin: TwinModel) -> _Candidate:
    """The Franka Hand, which the one has and the other has not."""
    has = bool(twin.hand.any())
    torque = rows.Y[:, :, 70:] @ (-twin.hand if has else body_parameters(**model.HAND))

    def tell(e: Estimate) -> tuple[str, str]:
        return (("the robot carries no Franka Hand, the twin does", "robot: {hand: none}") if has
                else ("the robot carries a Franka Hand, the twin does not", "robot: {hand: franka_hand}"))

    # No coefficient: it is there or it is not.
    return _Candidate(Columns("hand", torque[:, :, None], []), tell)


def _candidates(rows: Rows, twin: TwinModel) -> list[_Candidate]:
    links = [rows.Y[:, :, 10 * i : 10 * i + 10] @ twin.arm[10 * i : 10 * i + 10] for i in range(7)]
    hand = rows.Y[:, :, 70:] @ twin.hand
    flange = rows.Y[:, :, 70:] @ twin.load
    all_bodies = sum(links) + hand + flange
    found = [_friction(joint) for joint in ALL]
    found.append(_Candidate(Friction(), lambda _: ("the joints differ in friction", _BY_PROFILE.format("friction"))))
    found += [_tilt(rows, twin), _delay(twin), _load(twin), _hand(rows, twin),
              _scaled("mass of all links", sum(links) + hand, "plant.mass_scale", "all links are heavier by {}",
                      lambda x: f"plant: {{mass_scale: {1 + x:.3f}}}")]
    found += [_scaled(f"mass of link {i + 1}", links[i], f"link[{i}]", f"link {i + 1} is heavier by {{}}",
                      lambda x: _BY_PROFILE.format("inertia")) for i in range(1, 7)]
    for joint in ALL:
        own = np.zeros_like(all_bodies)
        own[:, joint] = all_bodies[:, joint]
        found.append(_scaled(f"torque sensor of joint {joint + 1}", own, f"gain[{joint}]", f"the torques of joint {joint + 1} are larger by {{}}",
                             lambda x: "calibrate the torque sensor, or check the unit of tau_J"))
    if twin.load.any():
        found.append(_scaled("mass of the load", flange, "load", "the load is heavier by {}",
                             lambda x: f"robot: {{load: {{mass: {(1 + x) * twin.load[0]:.3f} kg}}}}"))
    return found


def residual_of(rows: Rows, twin: TwinModel) -> Array:
    """Measured torques less the twin's, (n, 7)."""
    torque: Array = rows.tau_at(twin.torque_delay) - rows.Y @ twin.parameters - rows.of_velocity(lambda dq: friction_torque(twin.friction, dq))
    return torque


def _explain(rows: Rows, torque: Array, candidate: _Candidate, sigma: Array) -> tuple[float, float, Array, Estimate | None]:
    """What a candidate gains in log-likelihood, less what its parameters cost (BIC); its share; what remains."""
    before = float(np.sum((torque / sigma) ** 2))
    if candidate.term.parameters:
        estimate = fit(rows, torque, [candidate.term])
        after = estimate.residual
        if np.any(np.abs(np.nan_to_num(estimate.values)) > candidate.most):
            return -math.inf, 0.0, torque, estimate
    else:
        estimate = None
        after = torque - candidate.term.at(rows, np.ones(1))[0]
    gain = before - float(np.sum((after / sigma) ** 2))
    cost = len(candidate.term.parameters) * math.log(max(torque.size, 2))
    return gain - cost, gain / max(before, 1e-300), after, estimate


def causes_of(rows: Rows, torque: Array, twin: TwinModel, most: int = 3) -> list[Cause]:
    """Name the causes of a torque residual, the one that explains most first.

    Each cause is fitted alone; the best by the Bayesian information criterion is named and taken away, then the next is sought in
    what remains.

    Parameters
    ----------
    rows
        Of the log.
    torque : ndarray, shape (n, 7)
        Measured less the twin's, Nm.
    twin
        With whose figures the residual was made.
    most
        As many causes are named at most.
    """
    candidates = _candidates(rows, twin)
    everything: Sequence[Term] = [Friction(), Load(), Delay(), _tilt(rows, twin).term]
    sigma = np.maximum(spread_of(fit(rows, torque, everything).residual), _SMALLEST)
    found: list[Cause] = []
    whole = float(np.sum(torque**2))
    for _ in range(most):
        if np.all(np.sqrt(np.mean(torque**2, axis=0)) < 1.5 * _SMALLEST):
            break
        tried = [_explain(rows, torque, candidate, sigma) for candidate in candidates]
        best = max(range(len(tried)), key=lambda i: tried[i][0])
        score, share, after, estimate = tried[best]
        of_all = (float(np.sum(torque**2)) - float(np.sum(after**2))) / whole
        if score <= 0 or share < _LEAST_SHARE or of_all < _LEAST_OF_ALL:
            break
        empty = Estimate([], np.zeros(0), np.zeros((0, 0)), np.zeros(0, bool), after)
        words, remedy = candidates[best].tell(estimate or empty)
        found.append(Cause(candidates[best].term.name, words, remedy, of_all))
        torque = after
        del candidates[best]
    return found
