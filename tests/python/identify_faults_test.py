"""A twin's own log leaves nothing unexplained; with one fault each, the report names that fault first.

    identify_faults_test.py [FAULTS [FIRST]]

In CI 16 faults; `identify_faults_long_test` takes 40.
"""

import sys
import unittest

import numpy as np

import identify_robots as robots
import panda_twin as pt
from panda_twin.identify import compare
from panda_twin.identify._model import TwinModel, body_of

FAULTS = 16
FIRST = 0
NOISE = {"q": "0.00001 rad", "dq": "0.001 rad/s", "tau_J": "0.05 Nm"}
GAZ = TwinModel.of(pt.Scenario(name="gaz", motion={"trajectory": {"unit": "rad", "waypoints": robots.swing(12, 0)}})).friction


def twin(seed, **plant):
    return {
        "name": "known",
        "seed": seed + 1,
        "plant": {"noise": NOISE} | plant,
        "onboard": {"collision_behavior": "off"},
        "motion": {"trajectory": {"unit": "rad", "waypoints": robots.swing(16, seed)}},
    }


def mass(rng, keys):
    keys["plant"]["mass_scale"] = 1.1
    return "mass of all links"


def link(rng, keys):
    which = int(rng.integers(1, 6))
    model = TwinModel.of(pt.Scenario(**keys)).arm.reshape(7, 10).copy()
    model[which] *= 1.1
    keys["plant"]["links"] = [body_keys(body) for body in model]
    return f"mass of link {which + 1}"


def body_keys(parameters):
    m, centre, inertia = body_of(parameters)
    return {
        "mass": f"{m!r} kg",
        "position": [f"{x!r} m" for x in centre.tolist()],
        "inertia": [f"{x!r} kg m^2" for x in np.diag(inertia).tolist()],
        "products_of_inertia": [f"{x!r} kg m^2" for x in inertia[[0, 0, 1], [1, 2, 2]].tolist()],
    }


def friction(rng, keys):
    joint = int(rng.integers(7))
    law = GAZ.copy()
    law[1, joint] += 0.2
    keys["plant"]["friction"] = {name: robots.joints(values, robots.UNITS[name]) for name, values in zip(robots.FRICTION, law)}
    return f"friction of joint {joint + 1}"


def delay(rng, keys):
    keys["plant"]["delay"] = {"tau_J": "1 ms"}
    return "torque delay"


def load(rng, keys):
    keys["robot"] = {"load": {"mass": f"{rng.uniform(0.3, 2)!r} kg", "position": [f"{x!r} m" for x in rng.uniform(-0.05, 0.05, 3)[:2].tolist()] + ["0.08 m"]}}
    return "load"


def gravity(rng, keys):
    angle = rng.uniform(0, 2 * np.pi)
    keys["plant"]["base_tilt"] = {name: f"{float(np.radians(x))!r} rad" for name, x in (("roll", float(np.cos(angle))), ("pitch", float(np.sin(angle))))}
    return "gravity direction"


def hand(rng, keys):
    keys["robot"] = {"hand": "none"}
    return "hand"


def swapped(rng, log):
    i, j = rng.choice(7, 2, replace=False)
    order = list(range(7))
    order[i], order[j] = j, i
    for name in ("q", "dq", "tau_J"):
        log[name] = log[name][:, order]
    return "swapped joints"


def degrees(rng, log):
    log["q"], log["dq"] = np.degrees(log["q"]), np.degrees(log["dq"])
    return "degrees"


IN_ROBOT = (mass, friction, delay, load, gravity, hand, link)
IN_LOG = (swapped, degrees)


class Identity(unittest.TestCase):
    def test_the_twin_is_itself(self):
        keys = twin(0)
        del keys["plant"]["noise"]
        result = compare(pt.run(keys))
        self.assertTrue(result.passed)
        self.assertLess(np.abs(result.open.before).max(), 1e-5)
        self.assertEqual(result.causes, [])
        self.assertIsNone(result.closed.first_difference)
        self.assertEqual(result.closed.position_largest.max(), 0)

    def test_noise_is_no_cause(self):
        result = compare(pt.run(twin(1)))
        self.assertEqual(result.causes, [])
        self.assertTrue(result.passed)


class Faults(unittest.TestCase):
    def test_the_fault_is_named_first(self):
        missed, wrong = [], []
        for seed in range(FIRST, FIRST + FAULTS):
            rng = np.random.default_rng(1000 + seed)
            fault = (IN_ROBOT + IN_LOG)[seed % (len(IN_ROBOT) + len(IN_LOG))]
            keys = twin(seed)
            expected = fault(rng, keys) if fault in IN_ROBOT else ""
            log = robots.logged(keys, seed)
            if fault in IN_LOG:
                expected = fault(rng, log)
            result = compare(log, mapping=robots.MAPPING, against=twin(seed))
            named = [cause.name for cause in result.causes]
            print(f"{seed:3} {expected:22} {named} {[round(c.share, 3) for c in result.causes]}")
            if not named:
                missed.append(expected)
            elif named[0] != expected:
                wrong.append((expected, named))
        print(f"{FAULTS} faults, {len(missed)} missed, {len(wrong)} not named first")
        self.assertEqual(missed, [])
        self.assertLessEqual(len(wrong), FAULTS // 10, wrong)


if __name__ == "__main__":
    arguments = [int(x) for x in sys.argv[1:] if x.isdigit()]
    FAULTS, FIRST = arguments + [FAULTS, FIRST][len(arguments) :]
    unittest.main(argv=sys.argv[:1])
