"""How far an arm keeps from itself, the floor and a lab's limits, as a search can afford it: the program's check decides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ... import model

Array: TypeAlias = npt.NDArray[np.float64]

_TRACKING = 0.01  # m: the arm deviates by so much from its path, and samples miss the nearest point
_SPARE = 0.97  # of a cap on speed
# Spheres that cover the hand, in its frame, the flange's turned by -45 degrees: x, y, z, radius (docs/reference/limits.md).
_ROWS = ((0.037, 0.065, 0.054), (0.095, 0.05, 0.027))
_HAND = np.array([[0, share * width, z, r] for z, width, r in _ROWS for share in (-1, -1 / 3, 1 / 3, 1)])
_FRAMES: tuple[model.Frame, ...] = ("joint4", "joint5", "joint7", "flange", "EE")
_FLANGE = np.array([[0, 0, 0, 0.05]])


def _number(value: Any) -> float:
    return float(str(value).split()[0])


def _numbers(value: Any) -> Array:
    if isinstance(value, Mapping):
        value = value["values"]
    if isinstance(value, Sequence) and not isinstance(value, str):
        return np.array([_number(one) for one in value])
    return np.full(7, _number(value))


def _to_segment(points: Array, a: Array, b: Array) -> Array:
    """Distances of points (n, k, 3) from the segments a to b, (n, 3) each: (n, k)."""
    along = b - a
    share = np.einsum("nkd,nd->nk", points - a[:, None], along) / np.sum(along**2, axis=1)[:, None]
    nearest = a[:, None] + np.clip(share, 0, 1)[:, :, None] * along[:, None]
    return np.asarray(np.linalg.norm(points - nearest, axis=2))


class Clearance:
    """Of a robot with or without a hand, in the limits of a lab.

    Parameters
    ----------
    has_hand : bool
        Whether the Franka Hand is mounted.
    limits : mapping
        The section `limits` of a scenario, in SI units as its canonical text has them.
    """

    def __init__(self, has_hand: bool, limits: Mapping[str, Any]) -> None:
        self._spheres = _HAND if has_hand else _FLANGE
        self._regions = limits.get("regions", [])
        speed = limits.get("speed", {})
        self.joint_speed = _numbers(speed["joints"]) if "joints" in speed else np.full(7, np.inf)
        self._caps = [_number(speed[name]) if name in speed else np.inf for name in ("end_effector", "rotation")]
        turn = np.sqrt(0.5)
        self._F_R_hand = np.array([[turn, turn, 0], [-turn, turn, 0], [0, 0, 1]])

    def breach(self, q: Array, dq: Array) -> float:
        """By how much a motion, samples (n, 7), goes too far at most: m, m/s and rad/s alike; 0 if it does not."""
        frames = {name: model.fk(q, name) for name in _FRAMES}
        flange = frames["flange"]
        R = flange[:, :3, :3] @ self._F_R_hand
        hand = flange[:, None, :3, 3] + np.einsum("nij,kj->nki", R, self._spheres[:, :3])
        radii = self._spheres[:, 3]
        elbow, wrist = frames["joint4"][:, :3, 3], frames["joint5"][:, :3, 3]
        low, shoulder = np.broadcast_to([0, 0, 0.0], elbow.shape), np.broadcast_to([0, 0, 0.333], elbow.shape)
        joint7 = frames["joint7"][:, None, :3, 3]
        outer = np.concatenate([hand, joint7], axis=1)
        outer_radii = np.append(radii, 0.09)
        margins = [
            outer[:, :, 2] - outer_radii - 0.03,
            _to_segment(outer, low, shoulder) - outer_radii - 0.13,
            _to_segment(outer, shoulder, elbow) - outer_radii - 0.1,
            _to_segment(hand, elbow, wrist) - radii - 0.08,
            wrist[:, 2:] - 0.1,
            elbow[:, 2:] - 0.15,
            *self._in_regions(frames["EE"][:, None, :3, 3], elbow[:, None], hand),
        ]
        worst = -min(float(np.min(one)) for one in margins)
        if np.isfinite(self._caps).any():
            twist = np.einsum("nij,nj->ni", model.jacobian(q), dq)
            for part, cap in zip((twist[:, :3], twist[:, 3:]), self._caps):
                worst = max(worst, float(np.linalg.norm(part, axis=1).max()) - _SPARE * cap)
        return max(0.0, worst)

    def _in_regions(self, tip: Array, elbow: Array, hand: Array) -> list[Array]:
        parts = {"end_effector": (tip, np.zeros(1)), "elbow": (elbow, np.zeros(1)), "hand": (hand, self._spheres[:, 3])}
        margins = []
        for region in self._regions:
            for name in region.get("what", list(parts)):
                points, radii = parts[name]
                if "box" in region:
                    low, high = _numbers(region["box"]["min"]), _numbers(region["box"]["max"])
                    inside = np.minimum(points - low, high - points).min(axis=2)
                else:
                    normal = _numbers(region["half_space"]["normal"])
                    inside = _number(region["half_space"]["offset"]) - points @ (normal / np.linalg.norm(normal))
                margins.append((inside if region["keep"] == "inside" else -inside) - radii - _TRACKING)
        return margins
