"""Profiles: what was identified, as keys of a scenario, with its covariance."""

from __future__ import annotations

import datetime
import getpass
import os
import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._whole_files import write_whole
from ..model import Q_READY
from ..scenario import Scenario
from ._model import FRICTION, body_of
from ._result import CommandDelay
from ._rows import noise_of
from ._terms import FRICTION_PARAMETERS
from ._yaml import yaml_text

if TYPE_CHECKING:
    from ._identify import Identified
    from ._rows import Motion
    from .logs._recording import Recording

Array: TypeAlias = npt.NDArray[np.float64]

_FRICTION_UNITS = {name: unit for name, _, unit, _ in FRICTION_PARAMETERS}
_LOAD_KEYS = ["mass", *(f"position[{i}]" for i in range(3)), *(f"inertia[{i}]" for i in range(3)), *(f"products_of_inertia[{i}]" for i in range(3))]


def _numbers(values: npt.ArrayLike) -> list[float]:
    return [float(x) for x in np.asarray(values, float)]


def _joints(values: Array, unit: str) -> dict[str, Any]:
    return {"unit": unit, "values": _numbers(values)}


def _load_values(body: Array) -> Array:
    """Mass, centre, moments and products of inertia about the centre, in the order of a scenario's load."""
    mass, centre, inertia = body_of(body)
    return np.concatenate([[mass], centre, np.diag(inertia), [inertia[0, 1], inertia[0, 2], inertia[1, 2]]])


def _load_keys(body: Array) -> dict[str, Any]:
    mass, *rest = _numbers(_load_values(body))
    return {"mass": f"{mass} kg", "position": [f"{x} m" for x in rest[:3]], "inertia": [f"{x} kg m^2" for x in rest[3:6]],
            "products_of_inertia": [f"{x} kg m^2" for x in rest[6:]]}


def profile_of(
    recordings: Sequence[Recording], motions: Sequence[Motion], found: Identified, delay: CommandDelay | None, load_of_twin: Array, doubts: list[str]
) -> dict[str, Any]:
    """Put what was identified into the form that a scenario reads: `robot: {profile: file}`."""
    plant: dict[str, Any] = {}
    if found.friction is not None:
        plant["friction"] = {name: _joints(values, _FRICTION_UNITS[name]) for name, values in zip(FRICTION, found.friction)}
    if found.delay is not None:
        plant["delay"] = {"tau_J": f"{1e3 * found.delay:.4g} ms"}
    if found.armature is not None and np.all(np.isfinite(found.armature)):
        plant["armature"] = _joints(found.armature, "kg m^2")
    if found.stiffness is not None and not np.any(np.isnan(found.stiffness)):
        plant["elasticity"] = "rigid" if np.all(np.isinf(found.stiffness)) else _joints(np.minimum(found.stiffness, 1e7), "Nm/rad")
    if found.links is not None:
        plant["links"] = [_load_keys(body) for body in found.links.reshape(7, 10)]
    liveliest = max(motions, key=lambda m: len(m.t))
    noise = {"q": noise_of(liveliest.q), "dq": noise_of(liveliest.dq), "tau_J": noise_of(liveliest.others["tau_J"])}
    plant["noise"] = {"q": f"{noise['q']:.3g} rad", "dq": f"{noise['dq']:.3g} rad/s", "tau_J": f"{noise['tau_J']:.3g} Nm"}
    keys: dict[str, Any] = {"plant": plant}
    body = load_of_twin if found.load is None else found.load
    if found.load is not None:
        keys["robot"] = {"load": _load_keys(found.load)}
    if delay is not None and (late := delay.share[delay.expected + 1 :]).any():
        shares = delay.share[delay.expected : delay.expected + len(late) + 1]
        keys["link"] = {"command_delay": {"histogram": {"edges": [f"{i} ms" for i in range(len(shares) + 1)], "weights": _numbers(shares)}}}
    covariance_keys, matrix = _covariance(found)
    about = {"doubts": doubts} if doubts else {}
    return {
        "profile": 1,
        "robot": "panda",
        "identified": {"date": datetime.date.today().isoformat(), "by": _user(),
                       "log": [{"file": os.path.basename(str(r.path)), "sha256": r.sha256, "seconds": round(r.seconds, 3)} for r in recordings]} | about,
        "holds_for": {"speed": _joints(np.max([np.max(np.abs(m.dq), axis=0) for m in motions], axis=0), "rad/s"),
                      "load": {"from": f"{body[0]:.3f} kg", "to": f"{body[0]:.3f} kg"}},
        "scenario": keys,
        "covariance": {"keys": covariance_keys, "matrix": [_numbers(row) for row in matrix]},
    }


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return "unknown"


def _covariance(found: Identified) -> tuple[list[str], Array]:
    """Of the numbers in the profile: what the log cannot tell is not among them."""
    keys: list[str] = []
    parts: list[Array] = []
    for estimate in found.estimates:
        names = [p.key for p in estimate.parameters]
        chosen = [i for i, name in enumerate(names) if name.startswith("plant.") and not name.startswith("plant.elasticity") and estimate.told[i]]
        to_keys = np.eye(len(names))[chosen]
        own = [names[i] for i in chosen]
        body = [i for i, name in enumerate(names) if name.startswith("load.")]
        if body and found.load is not None and estimate.told[body].all():
            slope = np.zeros((10, len(names)))
            for place, i in enumerate(body):
                step = np.zeros(10)
                step[place] = 1e-6
                slope[:, i] = (_load_values(found.load + step) - _load_values(found.load - step)) / 2e-6
            to_keys, own = np.concatenate([to_keys, slope]), own + [f"robot.load.{key}" for key in _LOAD_KEYS]
        keys += own
        parts.append(to_keys @ estimate.covariance @ to_keys.T)
    size = sum(len(part) for part in parts)
    matrix, begin = np.zeros((size, size)), 0
    for part in parts:
        matrix[begin : begin + len(part), begin : begin + len(part)] = part
        begin += len(part)
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2) if size else (np.zeros(0), matrix)
    matrix = (vectors * np.maximum(values, 0)) @ vectors.T
    return keys, (matrix + matrix.T) / 2


def write_profile(profile: dict[str, Any], file: str | os.PathLike[str]) -> pathlib.Path:
    """Write a profile, whole or not at all: YAML whose innermost maps and lists are in one line.

    Raises
    ------
    ValueError
        When no scenario could take it: what was identified is no robot.
    OSError
        When the file cannot be written.
    """
    path = pathlib.Path(file)
    robot: Any = {"name": "profile", "robot": {"q_start": _joints(Q_READY, "rad")}}
    try:
        Scenario(**robot).replace(profile["scenario"])
    except ValueError as error:
        raise ValueError(f"{path}: not written, for no scenario takes what was identified: {error}; the log does not fit a Panda, or tells too little") from None
    text = "# A robot's profile: a scenario names it by robot: {profile: FILE}.\n" + yaml_text(profile)
    write_whole(path.parent, {path.name: text})
    return path
