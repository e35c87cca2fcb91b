"""The twin that a log is compared with, as torques: its bodies, friction, gravity and sensors."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _core, model
from ..scenario import Scenario

Array: TypeAlias = npt.NDArray[np.float64]

FRICTION = ("viscous", "coulomb", "offset", "steepness", "shift")
"""Coefficients of the friction law, as `plant.friction` has them: Nm s/rad, Nm, Nm, s/rad, rad/s."""
STEEP = 100.0
"""Steepness of Coulomb friction, s/rad."""

# Gaz et al., RA-L 2019, supplement: the sigmoid's phi1 (Nm), phi2 (s/rad), phi3 (rad/s).
_GAZ = np.array([[0.54615, 0.87224, 0.64068, 1.2794, 0.83904, 0.30301, 0.56489],
                 [5.1181, 9.0657, 10.136, 5.5903, 8.3469, 17.133, 10.336],
                 [0.039533, 0.025882, -0.04607, 0.036194, 0.026226, -0.021047, 0.0035526]])
_STEEL = 7850.0  # kg/m^3: a load without inertia is a ball of it


def friction_torque(law: Array, dq: Array) -> Array:
    """Friction that opposes the motion: `law` (5, 7) as `FRICTION`, dq (n, 7) rad/s; (n, 7) Nm."""
    viscous, coulomb, offset, steepness, shift = law
    torque: Array = viscous * dq + coulomb * (_step(steepness * (dq + shift)) - _step(steepness * shift)) + offset
    return torque


def _step(x: Array) -> Array:
    """2 / (1 + exp(-x)) without its overflow: from 0 to 2."""
    return np.asarray(1 + np.tanh(x / 2))


def body_parameters(mass: float, centre: npt.ArrayLike, inertia: npt.ArrayLike) -> Array:
    """The ten parameters of a body, about its frame's origin, from mass, centre and the inertia (3, 3) about the centre."""
    c = np.asarray(centre, float)
    about_origin = np.asarray(inertia, float) + mass * (c @ c * np.eye(3) - np.outer(c, c))
    return np.concatenate([[mass], mass * c, about_origin[np.triu_indices(3)]])


def body_of(parameters: Array) -> tuple[float, Array, Array]:
    """Mass, centre and inertia about the centre of ten parameters."""
    mass = float(parameters[0])
    c = parameters[1:4] / mass if mass > 0 else np.zeros(3)
    inertia = np.zeros((3, 3))
    inertia[np.triu_indices(3)] = parameters[4:]
    inertia = inertia + np.triu(inertia, 1).T
    return mass, c, inertia - mass * (c @ c * np.eye(3) - np.outer(c, c))


def _number(value: Any) -> float:
    """The number of a quantity as a scenario writes it: "0.1 rad"."""
    return float(value.split()[0]) if isinstance(value, str) else float(value)


def _load(keys: Mapping[str, Any]) -> Array:
    """Parameters of a scenario's load."""
    mass = _number(keys["mass"])
    centre = [_number(x) for x in keys.get("position", (0, 0, 0))]
    xx, yy, zz = (_number(x) for x in keys.get("inertia", (0, 0, 0)))
    xy, xz, yz = (_number(x) for x in keys.get("products_of_inertia", (0, 0, 0)))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if not inertia.any():
        inertia = 0.4 * mass * (3 * mass / (4 * math.pi * _STEEL)) ** (2 / 3) * np.eye(3)
    return body_parameters(mass, centre, inertia)


def _load_of(section: Mapping[str, Any]) -> Array:
    """Parameters of a section's load; zero without one."""
    return _load(section["load"]) if _number(section.get("load", {}).get("mass", 0)) else np.zeros(10)


def _friction(value: Any) -> Array:
    """The law (5, 7) of a scenario's plant.friction."""
    law = np.zeros((5, 7))
    law[3] = STEEP
    if value == "residual":
        law[1], law[3], law[4] = _GAZ[0] / 2, _GAZ[1], _GAZ[2]
    elif value == "breakaway":
        law[0] = [0.0628, 0.2088, 0.0361, 0.2174, 0.1021, 1.6128e-4, 0.0632]
        law[1] = [0.8315, 0.99845, 0.8923, 1.29255, 0.81225, 0.58725, 0.4132]
    elif isinstance(value, Mapping):
        for i, name in enumerate(FRICTION):
            if name in value:
                law[i] = value[name]["values"]
    return law


@dataclasses.dataclass(frozen=True)
class TwinModel:
    """What a scenario says of the robot's body."""

    arm: Array
    """(70,): seven links."""
    hand: Array
    """(10,): the mounted hand, in the flange frame."""
    load: Array
    """(10,): the body that hangs on the flange beside the hand."""
    friction: Array
    """(5, 7), as `FRICTION`."""
    tilt: Array
    """(2,): roll and pitch of the base, rad."""
    torque_delay: float
    """Of the torque sensors, s."""
    believed: Array
    """(10,): what INT believes to hang on the flange, the hand among it."""

    @classmethod
    def of(cls, scenario: Scenario) -> TwinModel:
        """Return the model of a scenario's plant. Raise ValueError for a robot with dynamics of its own."""
        keys: Mapping[str, Any] = scenario.to_dict()
        plant, robot = keys.get("plant", {}), keys.get("robot", {})
        if (name := robot.get("model", "panda")) != "panda":
            raise ValueError(f"the scenario's robot.model is {name}: compare and identify reckon with the Panda's dynamics only; name a log, or a scenario, of a panda")
        scale = float(plant.get("mass_scale", 1))
        is_ideal = plant.get("kind") == "ideal"  # which has the controller's own figures, no friction, and torques of the instant
        arm = np.asarray(_core.model_parameters(not is_ideal))
        if links := plant.get("links"):
            arm = np.concatenate([_load(link) for link in links])
        hand = body_parameters(**model.HAND) if robot.get("hand", "franka_hand") == "franka_hand" else np.zeros(10)
        tilt = plant.get("base_tilt", {})
        return cls(scale * arm, scale * hand, _load_of(robot),
                   _friction("none" if is_ideal else plant.get("friction", "residual")), np.array([_number(tilt.get(name, 0)) for name in ("roll", "pitch")]),
                   -1e-3 if is_ideal else _number(plant.get("delay", {}).get("tau_J", 0)), hand + _load_of(keys.get("onboard", {})))

    @property
    def parameters(self) -> Array:
        """Of all bodies, (80,)."""
        return np.concatenate([self.arm, self.hand + self.load])

    @property
    def g_earth(self) -> Array:
        """Gravity in the base's axes, m/s^2."""
        roll, pitch = self.tilt
        return 9.81 * np.array([math.sin(pitch), -math.cos(pitch) * math.sin(roll), -math.cos(pitch) * math.cos(roll)])

    def compensation(self, q: Array) -> Array:
        """The gravity torque that INT adds to what is commanded, (n, 7): by the robot's own figures, for a level base."""
        mass, centre, inertia = body_of(self.believed)
        return model.gravity(q, mass=mass, centre=centre, inertia=inertia)

    def tilted(self) -> tuple[Array, Array]:
        """Change of gravity per rad of roll, and of pitch."""
        roll, pitch = self.tilt
        return (9.81 * math.cos(pitch) * np.array([0, -math.cos(roll), math.sin(roll)]),
                9.81 * np.array([math.cos(pitch), math.sin(pitch) * math.sin(roll), math.sin(pitch) * math.cos(roll)]))
