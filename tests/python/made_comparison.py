"""A comparison with made-up but plausible numbers, for tests of what is told of it."""

import dataclasses

import numpy as np

import panda_twin
from panda_twin.identify._causes import Cause
from panda_twin.identify._demand import TORQUE_LIMITS, judge, read_demand
from panda_twin.identify._identify import Identified
from panda_twin.identify._model import body_parameters
from panda_twin.identify._regression import Estimate
from panda_twin.identify._result import Closed, CommandDelay, Comparison, External, LogFacts, Open, rms
from panda_twin.identify._terms import ALL, Delay, Load, Parameter, _friction_parameters
from panda_twin.identify.logs._timing import Timing

COULOMB = np.array([0.25, 0.4, 0.62, 0.5, 0.3, 0.12, 0.2])


def made_timing(**changes):
    edges = np.linspace(0, 2, 41)
    counts = np.rint(2e5 * np.exp(-0.5 * ((edges[:-1] - 0.97) / 0.08) ** 2)).astype(np.int64)
    counts[-1] = 3
    success = np.zeros(101, np.int64)
    success[[100, 99, 98, 95]] = 59000, 900, 80, 20
    timing = Timing(
        "message_id",
        1.0,
        1.0006,
        0.031,
        9.2,
        23.417,
        11,
        4,
        2,
        True,
        (edges, counts),
        {1: 90, 2: 40, 3: 11, 5: 2},
        (np.append(np.arange(101) - 0.5, 100.5) / 100, success),
    )
    return dataclasses.replace(timing, **changes)


def made_log(**changes):
    log = LogFacts(
        "lab3/run_17.mcap",
        "MCAP of panda-twin",
        "9f" * 32,
        60000,
        60.0,
        made_timing(),
        [("theta", "stiffness of the joints"), ("O_F_ext_hat_K", "the wrench")],
        ["2 rows have the stamp of the row before and are left out"],
        ["joint 5 and joint 6 may be swapped: their torques fit the other one better"],
    )
    return dataclasses.replace(log, **changes)


def made_open(n=3000, after=True):
    random = np.random.default_rng(3)
    t = 0.02 * np.arange(n) + np.where(np.arange(n) > n // 2, 0.4, 0)
    phase = np.arange(7) * 0.7
    q = 0.8 * np.sin(0.9 * t[:, None] + phase) + 0.3 * np.sin(2.2 * t[:, None]) + np.array([0, -0.6, 0, -1.9, 0, 1.8, 0.8])
    dq = 0.72 * np.cos(0.9 * t[:, None] + phase) + 0.66 * np.cos(2.2 * t[:, None])
    noise = random.normal(0, 0.04, (n, 7)) * np.sqrt(TORQUE_LIMITS / 87)
    before = COULOMB * np.tanh(30 * dq) + 0.15 * dq + 0.5 * (TORQUE_LIMITS > 50) * np.sin(q) + noise
    return Open(t, q, dq, 10 * np.sin(q), before, noise + 0.01 * np.sin(q) if after else None)


def made_estimate(parameters, values, sd):
    values = np.asarray(values, float)
    return Estimate(parameters, values, np.diag(np.asarray(sd, float) ** 2), np.isfinite(values), np.zeros((0, 7)))


def made_identified():
    load = body_parameters(0.84, [0.01, -0.004, 0.071], np.diag([2.1e-3, 2.3e-3, 1.4e-3]))
    load[[5, 8]] = np.nan
    friction = _friction_parameters([0, 1, 2, 3], 5) + _friction_parameters([4, 5, 6], 3)
    law = [
        np.full(4, 0.15),
        COULOMB[:4],
        np.array([0.02, np.nan, -0.1, 0]),
        np.full(4, 14.2),
        np.full(4, 0.03),
        np.full(3, 0.08),
        COULOMB[4:],
        np.zeros(3),
    ]
    base = [Parameter(f"base[{i}]", f"hx of link {i % 7 + 1} with 3 others", "kg m", 0.1) for i in range(43)]
    parameters = friction + Load().parameters + Delay().parameters + base
    values = np.concatenate([*law, load, [0.00083], np.linspace(-0.1, 0.1, 43)])
    estimates = [
        made_estimate(parameters, values, [0.004 * p.scale for p in parameters]),
        made_estimate(
            [Parameter(f"plant.elasticity[{i}]", f"compliance of joint {i + 1}", "rad/Nm", 1e-3) for i in ALL],
            [7e-5] * 6 + [np.nan],
            [4e-6] * 7,
        ),
        made_estimate(
            [Parameter(f"plant.armature[{i}]", f"armature of joint {i + 1}", "kg m^2", 0.5) for i in ALL]
            + _friction_parameters(ALL, 3),
            [0.6] * 7 + [0.1] * 21,
            [0.02] * 28,
        ),
    ]
    found = made_open()
    return Identified(
        estimates,
        None,
        None,
        None,
        0.00083,
        np.full(7, 14000.0),
        np.full(7, 0.6),
        (1.02 * rms(found.before), 1.1 * rms(found.after)),
        ["inertia xy of the load (the motion does not excite it)"],
    )


def made_closed(scale):
    t = 0.01 * np.arange(6000)
    position = scale * 1e-3 * (1 + np.sin(1.3 * t[:, None] + np.arange(7))) * np.linspace(3, 1, 7)
    return Closed(
        t,
        position,
        position / 4,
        rms(position),
        np.abs(position).max(axis=0),
        scale * COULOMB,
        60000,
        ["robot: joint_velocity_discontinuity at cycle 31877", "twin: no error"],
        12,
    )


def made_comparison(**changes):
    before = made_open()
    found = {
        "torque": rms(before.before),
        "torque_share": rms(before.before) / TORQUE_LIMITS,
        "position": made_closed(1).position_rms,
        "delay": np.array([0.00083]),
        "lost": np.array([np.nan]),
    }
    demand = {**read_demand(None), **read_demand({"torque": "0.5 Nm", "lost": "0.1 %"})}
    causes = [
        Cause(
            "friction of joint 3",
            "joint 3 differs in friction by +0.62 +- 0.02 Nm Coulomb friction",
            "plant.friction of joint 3: --identify friction --write profile.yaml",
            0.41,
        ),
        Cause(
            "load",
            "the flange carries +0.84 +- 0.01 kg that the twin does not",
            "robot: {load: {mass: 0.840 kg, position: [0.01, -0.004, 0.071] m}}",
            0.3,
        ),
        Cause("torque delay", "torques come +0.83 +- 0.04 ms later than the twin's", "plant: {delay: {tau_J: 0.83 ms}}", 0.05),
    ]
    profile = {
        "profile": 1,
        "scenario": {
            "plant": {"friction": {"coulomb": {"unit": "Nm", "values": COULOMB}}},
            "robot": {"load": {"mass": "0.84 kg"}},
        },
    }
    scenario = panda_twin.Scenario(
        name="lab_cell",
        description="The cell of lab 3 <b>",
        motion={
            "trajectory": {
                "unit": "rad",
                "waypoints": [{"q": [0, 0, 0, -1.5, 0, 1.5, 0]}, {"q": [0.1, 0, 0, -1.5, 0, 1.5, 0], "at": "1 s"}],
            }
        },
    )
    comparison = Comparison(
        [made_log()],
        scenario,
        before,
        causes,
        made_identified(),
        made_closed(1),
        made_closed(0.1),
        External(COULOMB, np.array([2.0, 1, 3, 0.2, 0.1, 0.3]), 59.2),
        CommandDelay(np.arange(6), np.array([0, 0.001, 0.93, 0.06, 0.008, 0.001]), 1),
        found,
        judge(demand, found),
        ["the inertia of the load about z"],
        profile,
    )
    return dataclasses.replace(comparison, **changes)


def with_nan(closed_or_open):
    """The same with joint 6 not in the log."""

    def lost(value):
        if isinstance(value, np.ndarray) and value.shape[-1:] == (7,):
            value = value.copy()
            value[..., 5] = np.nan
        return value

    return dataclasses.replace(
        closed_or_open, **{f.name: lost(getattr(closed_or_open, f.name)) for f in dataclasses.fields(closed_or_open)}
    )
