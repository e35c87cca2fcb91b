"""Robots that nobody knows: twins with drawn friction, load and delay, and what a program beside them would have logged."""

import dataclasses

import numpy as np

import panda_twin as pt
from panda_twin.identify._model import FRICTION, body_parameters

UNITS = dict(zip(FRICTION, ("Nms/rad", "Nm", "Nm", "s/rad", "rad/s")))
CENTRE = np.array([0, -0.6, 0, -2.0, 0, 1.7, 0.8])
FASTEST = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
SWING = np.array([1.0, 0.5, 0.9, 0.6, 1.2, 1.0, 1.4])


def swing(seconds, seed):
    """Waypoints of a Fourier series in all joints, from rest to rest."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, seconds + 1e-9, 0.05)
    rise, fall = np.clip(t / 2, 0, 1), np.clip((seconds - t) / 2, 0, 1)
    window = np.prod([x**3 * (10 - 15 * x + 6 * x**2) for x in (rise, fall)], axis=0)
    q = np.zeros((len(t), 7))
    for joint in range(7):
        for k in range(1, 6):
            q[:, joint] += rng.normal() * np.sin(2 * np.pi * 0.1 * k * t + rng.uniform(0, 2 * np.pi)) / k
        q[:, joint] *= SWING[joint] / np.abs(q[:, joint]).max()
    q = q * window[:, None]
    q = CENTRE + q * min(1, 0.8 / np.max(np.abs(np.gradient(q, 0.05, axis=0)) / FASTEST))
    return [{"q": [round(float(x), 6) for x in row], "at": f"{at:.3f} s"} for row, at in zip(q, t)]


MAPPING = {"columns": {"time": {"from": "time", "unit": "s"}, "q": "q", "dq": "dq", "tau_J": "tau_J"}}


def joints(values, unit):
    return {"unit": unit, "values": [float(x) for x in values]}


@dataclasses.dataclass
class Truth:
    """What is true of a robot."""

    law: np.ndarray  # (5, 7)
    body: np.ndarray  # (10,): the load's parameters about the flange
    load: dict  # as a scenario has it
    delay: float  # s
    seconds: float


def drawn(seed):
    """A robot: friction by either law, a load of up to 3 kg, torques late by up to 5 ms, 12 to 60 s of log."""
    rng = np.random.default_rng(seed)
    law = np.zeros((5, 7))
    law[0], law[1], law[2] = rng.uniform(0, 0.3, 7), rng.uniform(0.1, 0.6, 7), rng.uniform(-0.2, 0.2, 7)
    law[3] = 100
    if rng.uniform() < 0.4:
        law[0], law[3], law[4] = rng.uniform(0.05, 0.2, 7), rng.uniform(5, 17, 7), rng.uniform(-0.05, 0.05, 7)
    mass, centre = rng.uniform(0.05, 3), rng.uniform(-0.06, 0.06, 3) + [0, 0, 0.06]
    # A cloud of mass points has an inertia that exists.
    points = rng.normal(size=(8, 3)) * 0.04
    points -= points.mean(axis=0)
    inertia = mass / 8 * sum(p @ p * np.eye(3) - np.outer(p, p) for p in points)
    load = {
        "mass": f"{mass!r} kg",
        "position": [f"{x!r} m" for x in centre.tolist()],
        "inertia": [f"{x!r} kg m^2" for x in np.diag(inertia).tolist()],
        "products_of_inertia": [f"{x!r} kg m^2" for x in inertia[[0, 0, 1], [1, 2, 2]].tolist()],
    }
    return Truth(law, body_parameters(mass, centre, inertia), load, rng.uniform(0, 5e-3), float(rng.integers(12, 61)))


def scenario(truth, seed, **changes):
    """The robot as a twin; its own controller does not know the load."""
    keys = {
        "name": "hidden",
        "seed": seed + 1,
        "robot": {"load": truth.load},
        "plant": {
            "friction": {name: joints(values, UNITS[name]) for name, values in zip(FRICTION, truth.law)},
            "delay": {"tau_J": f"{truth.delay!r} s"},
            "noise": {"q": "0.00001 rad", "dq": "0.001 rad/s", "tau_J": "0.05 Nm"},
        },
        "onboard": {"collision_behavior": "off"},
        "motion": {"interface": "joint_position", "trajectory": {"unit": "rad", "waypoints": swing(truth.seconds, seed)}},
    }
    return keys | changes


def logged(keys, seed, jitter=1.9e-4, gaps=20):
    """What a program beside the robot logs: positions of an encoder, jittered stamps, and rows that it missed."""
    cycles = pt.Log(pt.run(keys)).cycles.load("q", "dq", "tau_J")
    columns = {name: np.array(cycles[name]) for name in ("q", "dq", "tau_J")}
    rng = np.random.default_rng(seed)
    columns["q"] = np.round(columns["q"] / 1e-6) * 1e-6
    time = 1e-3 * np.arange(len(columns["q"]))
    keep = np.ones(len(time), bool)
    for begin in rng.integers(100, len(time) - 100, gaps):
        keep[begin : begin + rng.integers(1, 9)] = False
    time = np.sort(time + rng.normal(size=len(time)) * jitter)
    time = time[0] + np.cumsum(np.maximum(np.diff(time, prepend=time[0]), 1e-7))
    return {"time": time[keep], **{name: values[keep] for name, values in columns.items()}}
