"""What a regression can fit: each term gives torques that depend on its parameters, and their derivatives."""

from __future__ import annotations

import dataclasses
from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from ._model import STEEP, friction_torque
from ._rows import Rows

Array: TypeAlias = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Parameter:
    """One fitted number."""

    key: str
    """As in a scenario: "plant.friction.coulomb[2]"; "base[3]" of what no scenario names."""
    text: str
    """In words: "Coulomb friction of joint 3"."""
    unit: str
    scale: float
    """An uncertainty of this size means that the log says nothing."""


class Term(Protocol):
    """A part of the model with parameters of its own."""

    name: str
    parameters: list[Parameter]

    def start(self) -> Array:
        """Return values to begin with."""
        ...

    def at(self, rows: Rows, values: Array) -> tuple[Array, Array]:
        """Return torques (n, 7) and their derivatives (n, 7, k)."""
        ...


class _Linear:
    """A term whose torques are its columns times its parameters."""

    name: str
    parameters: list[Parameter]

    def __init__(self) -> None:
        self._made: dict[int, tuple[Rows, Array]] = {}  # the rows, so that no other ones get their id

    def start(self) -> Array:
        return np.zeros(len(self.parameters))

    def at(self, rows: Rows, values: Array) -> tuple[Array, Array]:
        if id(rows) not in self._made:
            self._made[id(rows)] = rows, self.columns(rows)
        columns = self._made[id(rows)][1]
        return columns @ values, columns

    def columns(self, rows: Rows) -> Array:
        raise NotImplementedError


def _spread(columns: Array, joints: list[int]) -> Array:
    """Columns (n, joints, k) of single joints as those of all, (n, 7, k joints), coefficient after coefficient."""
    n, count, kinds = columns.shape
    out = np.zeros((n, 7, kinds, count))
    for place, joint in enumerate(joints):
        out[:, joint, :, place] = columns[:, place]
    return out.reshape(n, 7, kinds * count)


ALL = list(range(7))
FRICTION_PARAMETERS = (("viscous", "viscous friction", "Nms/rad", 1.0), ("coulomb", "Coulomb friction", "Nm", 1.0), ("offset", "torque offset", "Nm", 1.0),
             ("steepness", "steepness of friction", "s/rad", 100.0), ("shift", "velocity shift of friction", "rad/s", 0.2))


def _friction_parameters(joints: list[int], kinds: int) -> list[Parameter]:
    return [Parameter(f"plant.friction.{key}[{joint}]", f"{text} of joint {joint + 1}", unit, scale)
            for key, text, unit, scale in FRICTION_PARAMETERS[:kinds] for joint in joints]


class Friction(_Linear):
    """Viscous and Coulomb friction and offset of joints."""

    def __init__(self, joints: list[int] = ALL) -> None:
        super().__init__()
        self.joints = joints
        self.name = "friction" if len(joints) == 7 else f"friction of joint {joints[0] + 1}"
        self.parameters = _friction_parameters(joints, 3)

    def columns(self, rows: Rows) -> Array:
        def basis(dq: Array) -> Array:
            v = dq[:, self.joints]
            return np.stack([v, np.tanh(STEEP / 2 * v), np.ones_like(v)], axis=2)

        return _spread(rows.of_velocity(basis), self.joints)


class SmoothFriction:
    """Friction by a sigmoid of the velocity: all five coefficients of the law, of some joints."""

    name = "friction"

    def __init__(self, joints: list[int], start: Array) -> None:
        self.joints = joints
        self.parameters = _friction_parameters(joints, 5)
        self._start = start

    def start(self) -> Array:
        return self._start[:, self.joints].ravel()

    def at(self, rows: Rows, values: Array) -> tuple[Array, Array]:
        law = values.reshape(5, -1)
        _, coulomb, _, steepness, shift = law

        def all_of(all_dq: Array) -> Array:
            dq = all_dq[:, self.joints]
            s, s0 = np.tanh(steepness * (dq + shift) / 2), np.tanh(steepness * shift / 2)
            slope, slope0 = (1 - s**2) / 2, (1 - s0**2) / 2
            return np.stack([dq, s - s0, np.ones_like(dq), coulomb * (slope * (dq + shift) - slope0 * shift),
                             coulomb * steepness * (slope - slope0), friction_torque(law, dq)], axis=2)

        filtered = rows.of_velocity(all_of)
        torque = np.zeros((len(rows), 7))
        torque[:, self.joints] = filtered[:, :, 5]
        return torque, _spread(filtered[:, :, :5], self.joints)


BODY = (("m", "kg", 1.0), ("hx", "kg m", 0.1), ("hy", "kg m", 0.1), ("hz", "kg m", 0.1),
         ("Ixx", "kg m^2", 0.02), ("Ixy", "kg m^2", 0.02), ("Ixz", "kg m^2", 0.02), ("Iyy", "kg m^2", 0.02), ("Iyz", "kg m^2", 0.02), ("Izz", "kg m^2", 0.02))
"""Parameters of a body: name, unit, and the scale of `Parameter`."""
_BODY_WORDS = {"m": "mass", "h": "mass times centre", "I": "moment of inertia about the flange"}


class Load(_Linear):
    """The ten parameters of a body on the flange, beside the hand."""

    name = "load"

    def __init__(self) -> None:
        super().__init__()
        self.parameters = [Parameter(f"load.{key}", f"{_BODY_WORDS[key[0]]} of the load{'' if key == 'm' else ', ' + key[1:]}", unit, scale)
                           for key, unit, scale in BODY]

    def columns(self, rows: Rows) -> Array:
        return rows.Y[:, :, 70:]


class Inertia(_Linear):
    """Base parameters of the seven links, as a difference from the twin's: each by the parameter that stands for it."""

    name = "inertia"

    def __init__(self, leading: npt.NDArray[np.int64], share: Array) -> None:
        super().__init__()
        self._leading = leading
        self.parameters = []
        for i, place in enumerate(leading):
            key, unit, scale = BODY[place % 10]
            others = int(np.sum(np.abs(share[i]) > 1e-9)) - 1
            self.parameters.append(Parameter(f"base[{i}]", f"{key} of link {place // 10 + 1}{f' with {others} others' if others else ''}", unit, scale))

    def columns(self, rows: Rows) -> Array:
        return rows.Y[:, :, self._leading]


class Delay:
    """Delay of the torque sensors beyond that of the model."""

    name = "torque delay"
    parameters = [Parameter("plant.delay.tau_J", "delay of the torque sensors", "s", 0.005)]

    def start(self) -> Array:
        return np.zeros(1)

    def at(self, rows: Rows, values: Array) -> tuple[Array, Array]:
        delay = float(np.clip(values[0], -0.003, 0.024))
        return rows.tau_at(0.0) - rows.tau_at(delay), -rows.tau_at(delay, 1)[:, :, None]


class Columns(_Linear):
    """A term by columns that are there."""

    def __init__(self, name: str, columns: Array, parameters: list[Parameter]) -> None:
        super().__init__()
        self.name = name
        self.parameters = parameters
        self._columns = columns

    def columns(self, rows: Rows) -> Array:
        return self._columns
