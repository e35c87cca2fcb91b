"""What an identification tells beside friction, load and delay, and what it must not pretend to know."""

import unittest

import numpy as np

import identify_robots as robots
import panda_twin as pt
from panda_twin import model
from panda_twin.identify import compare

PRIOR = {"name": "prior", "plant": {"friction": "none"}, "motion": {"trajectory": {"unit": "rad", "waypoints": robots.swing(12, 0)}}}
NOISE = {"q": "0.00001 rad", "dq": "0.001 rad/s", "tau_J": "0.05 Nm"}


def table(q, dq, seed=0):
    """A log of a motion without acceleration: torques of gravity, noise on top."""
    tau = model.gravity(q, figures="plant", **model.HAND) + np.random.default_rng(seed).normal(size=q.shape) * 0.05
    return {"time": 1e-3 * np.arange(len(q)), "q": q, "dq": dq, "tau_J": tau}


def untold_of(result):
    estimate = result.identified.estimates[0]
    return [p.key for p, told in zip(estimate.parameters, estimate.told) if not told]


class NotTold(unittest.TestCase):
    def test_friction_of_a_constant_velocity(self):
        rows = 10000
        q = np.tile(robots.CENTRE, (rows, 1))
        q[:, 6] += 0.2 * 1e-3 * np.arange(rows)
        dq = np.zeros_like(q)
        dq[:, 6] = 0.2
        result = compare(table(q, dq), mapping=robots.MAPPING, against=PRIOR, identify=["friction"])
        told = {p.key for p, t in zip(result.identified.estimates[0].parameters, result.identified.estimates[0].told) if t}
        self.assertEqual(told & {f"plant.friction.{name}[{j}]" for name in ("viscous", "coulomb") for j in range(7)}, set())
        self.assertTrue(any("joint 7" in text for text in result.untold))

    def test_a_load_that_is_never_turned(self):
        keys = robots.scenario(robots.drawn(1), 1)
        for point in keys["motion"]["trajectory"]["waypoints"]:  # joint 1 alone, about the vertical, and slowly
            point["q"] = [point["q"][0] * 0.3, *robots.CENTRE[1:].tolist()]
        result = compare(robots.logged(keys, 1), mapping=robots.MAPPING, against=PRIOR, identify=["friction", "load"])
        self.assertIn("load.m", untold_of(result))
        self.assertTrue({"load.Ixx", "load.Ixy", "load.Iyz"} <= set(untold_of(result)))
        self.assertIsNone(result.identified.load)  # its few told directions are noise's
        self.assertNotIn("robot", result.profile["scenario"])
        self.assertTrue(np.all(np.isfinite(result.identified.friction)))

    def test_columns_that_are_not_there(self):
        keys = robots.scenario(robots.drawn(1), 1)
        result = compare(robots.logged(keys, 1), mapping=robots.MAPPING, against=PRIOR, identify=["elasticity", "armature"])
        self.assertIsNone(result.identified.stiffness)
        self.assertTrue(any("theta" in text for text in result.untold))
        self.assertTrue(any("tau_J_d" in text for text in result.untold))

    def test_load_and_links_at_once(self):
        keys = robots.scenario(robots.drawn(1), 1)
        with self.assertRaisesRegex(ValueError, "in two steps"):
            compare(robots.logged(keys, 1), mapping=robots.MAPPING, against=PRIOR, identify=["load", "inertia"])


class Told(unittest.TestCase):
    def test_stiffness_and_armature(self):
        stiffness, armature = np.array([9000.0, 11000, 8000, 10000, 5000, 6000, 7000]), np.array([0.5, 0.7, 0.4, 0.5, 0.25, 0.18, 0.22])
        keys = robots.scenario(robots.drawn(2), 2)
        keys["robot"] = {}
        keys["plant"] = {"noise": NOISE, "elasticity": robots.joints(stiffness, "Nm/rad"), "armature": robots.joints(armature, "kg m^2")}
        result = compare(pt.run(keys), identify=["elasticity", "armature"])
        np.testing.assert_allclose(result.identified.stiffness, stiffness, rtol=0.05)
        np.testing.assert_allclose(result.identified.armature, armature, rtol=0.03)
        for estimate, truth in zip(result.identified.estimates, (1 / stiffness, armature)):
            self.assertTrue(np.all(np.abs(estimate.values[:7] - truth) < 5 * estimate.sd[:7] + 0.01 * truth))

    def test_links(self):
        keys = robots.scenario(robots.drawn(3), 3)
        keys["robot"] = {}
        keys["plant"]["mass_scale"] = 1.1
        keys["motion"]["trajectory"]["waypoints"] = robots.swing(40, 3)
        result = compare(robots.logged(keys, 3), mapping=robots.MAPPING, against=PRIOR, identify=["friction", "inertia", "delay"])
        before, after = result.identified.held_out
        self.assertTrue(np.all(after < 0.02), after)
        self.assertTrue(np.all(before > 2 * after))
        for mass, *_ in result.identified.links.reshape(7, 10):
            self.assertGreater(mass, 0)
        self.assertLess(np.sqrt(np.mean(result.open.after**2)), 0.02)  # the links that exist explain it as well


if __name__ == "__main__":
    unittest.main()
