"""Designed excitation: it keeps the limits, tells what it will tell, and refuses what cannot be."""

import contextlib
import io
import json
import pathlib
import re
import tempfile
import unittest

import numpy as np

import panda_twin
from panda_twin import model
from panda_twin.identify.excite import _program
from panda_twin.identify.excite._expected import KINDS, expected_of, terms_of
from panda_twin.identify._model import TwinModel
from panda_twin.identify._regression import fit
from panda_twin.identify._rows import Motion, rows_of
from panda_twin.scenario import validate

VELOCITY = np.array([2.175] * 4 + [2.61] * 3)
ACCELERATION = np.array([15, 7.5, 10, 12.5, 15, 20, 20])
JERK = np.array([7500, 3750, 5000, 6250, 7500, 10000, 10000.0])
SPEED = 0.4
SECONDS = 24.0
LAB = """
limits:
  regions:
    - {name: cell, what: [end_effector, hand], keep: inside, box: {min: [0.1 m, -0.4 m, 0.05 m], max: [0.8 m, 0.4 m, 1 m]}}
    - {name: camera, keep: outside, box: {min: [0.5 m, 0.25 m, 0.5 m], max: [0.6 m, 0.4 m, 0.8 m]}}
  speed: {joints: 0.7 rad/s, end_effector: 0.4 m/s}
"""


def call(*words):
    """Exit code, and what it printed and complained."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = _program.main(list(words))
    return code, out.getvalue(), err.getvalue()


def path_of(folder):
    """The splined path at 1 kHz, with half a second of rest at both ends: t, q, dq, ddq."""
    table = np.loadtxt(folder / "trajectory.csv", delimiter=",", skiprows=1)
    path = panda_twin.Trajectory(table[:, 1:], table[:, 0].tolist())
    t = 1e-3 * np.arange(round((path.duration + 1) * 1000))
    q, dq, ddq = (np.array(rows) for rows in zip(*(path.sample(float(x)) for x in np.clip(t - 0.5, 0, path.duration))))
    return t, q, dq, ddq


def rows_from(path, noise=None):
    t, q, dq, ddq = path
    tau_J = np.zeros_like(q) if noise is None else noise
    twin = TwinModel.of(panda_twin.Scenario.load("scenarios/smoke.yaml"))
    return rows_of([Motion(t, np.ones(len(t), bool), q, dq, ddq, {"tau_J": tau_J})], twin)


class Excite(unittest.TestCase):
    """Of one motion for each purpose."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.lab = cls.folder / "lab.yaml"
        cls.lab.write_text(LAB)
        cls.paths, cls.facts, cls.tables = {}, {}, {}
        for kind in KINDS:
            code, out, err = call("--for", kind, "--seconds", str(SECONDS), "--speed", str(SPEED), "--out", str(cls.folder / kind))
            assert code == 0, err
            cls.tables[kind] = out
            cls.paths[kind] = path_of(cls.folder / kind)
            cls.facts[kind] = json.loads((cls.folder / kind / "expected.json").read_text())

    def test_keeps_the_limits_and_rests_at_both_ends(self):
        for kind in KINDS:
            _, q, dq, ddq = self.paths[kind]
            with self.subTest(kind):
                text = validate(self.folder / kind / "scenario.yaml")
                shares = [float(x) for x in re.search(r"velocity (\S+) %, acceleration (\S+) %, jerk (\S+) %", text).groups()]
                self.assertLess(max(shares), 100 * SPEED)
                for rate, limit in ((dq, VELOCITY), (ddq, ACCELERATION), (np.diff(ddq, axis=0) / 1e-3, JERK)):
                    self.assertLess(np.max(np.abs(rate) / limit), SPEED)
                self.assertTrue(np.all((q > np.array(model.Q_MIN) + 0.049) & (q < np.array(model.Q_MAX) - 0.049)))
                for end in (0, -1):
                    np.testing.assert_allclose(q[end], model.Q_READY, atol=1e-9)
                    np.testing.assert_allclose([dq[end], ddq[end]], 0, atol=1e-9)
                # It uses what it may.
                self.assertGreater(shares[0], 0.7 * 100 * SPEED)

    def test_friction_passes_slow_and_fast_velocities_both_ways(self):
        dq = self.paths["friction"][2]
        for joint in range(7):
            for sign in (1, -1):
                seen = np.histogram(sign * dq[:, joint], bins=np.array([0.02, 0.1, 0.25, 0.5, 0.75]) * SPEED * VELOCITY[joint])[0]
                self.assertTrue(np.all(seen > 50), (joint, sign, seen))

    def test_condition_is_no_worse_than_stated(self):
        for kind in KINDS:
            for law, condition in self.facts[kind]["condition"].items():
                found = expected_of(rows_from(self.paths[kind]), terms_of(kind, law == "sigmoid"), 0.05)
                with self.subTest(kind=kind, law=law):
                    self.assertLessEqual(found.condition, 1.01 * condition)

    def test_everything_is_told_and_the_table_says_so(self):
        for kind in KINDS:
            with self.subTest(kind):
                self.assertTrue(all(one["sd"] for one in self.facts[kind]["parameters"]))
                self.assertNotIn("cannot be told", self.tables[kind])
                for one in self.facts[kind]["parameters"]:
                    self.assertIn(one["text"], self.tables[kind])

    def test_deviations_are_those_of_fits(self):
        random = np.random.default_rng(5)
        for kind in ("friction", "load"):
            terms = terms_of(kind)
            values = []
            for _ in range(20):
                rows = rows_from(self.paths[kind], random.normal(0, 0.05, self.paths[kind][1].shape))
                values.append(fit(rows, rows.tau_at(0.0), terms).values)
            sd = {one["key"]: one["sd"] for one in self.facts[kind]["parameters"] if one["law"] == "plain"}
            expected = np.array([sd[p.key] for term in terms for p in term.parameters])
            ratio = np.sqrt(np.mean(np.square(values), axis=0)) / expected
            with self.subTest(kind):
                self.assertAlmostEqual(np.sqrt(np.mean(ratio**2)), 1, delta=0.12)
                self.assertTrue(np.all((ratio > 0.5) & (ratio < 1.7)), ratio)

    def test_same_seed_same_bytes(self):
        words = ("--for", "load", "--seconds", str(SECONDS), "--speed", str(SPEED))
        for seed, is_same in (("1", True), ("2", False)):
            out = self.folder / f"seed{seed}"
            self.assertEqual(call(*words, "--seed", seed, "--out", str(out))[0], 0)
            for name in ("trajectory.csv", "expected.json"):
                self.assertEqual((out / name).read_bytes() == (self.folder / "load" / name).read_bytes(), is_same)

    def test_keeps_a_labs_limits(self):
        out = self.folder / "lab"
        code, _, err = call("--for", "load", "--seconds", "14", "--limits", str(self.lab), "--out", str(out))
        self.assertEqual((code, err), (0, ""))
        _, q, dq, _ = path_of(out)
        self.assertLessEqual(np.abs(dq).max(), 0.7)
        speed = np.linalg.norm(np.einsum("nij,nj->ni", model.jacobian(q), dq)[:, :3], axis=1)
        self.assertLessEqual(speed.max(), 0.4)
        self.assertGreater(speed.max(), 0.2)
        tip = model.fk(q)[:, :3, 3]
        self.assertTrue(np.all((tip >= [0.1, -0.4, 0.05]) & (tip <= [0.8, 0.4, 1])))
        self.assertIn("regions", panda_twin.Scenario.load(out / "scenario.yaml").to_dict()["limits"])

    def test_says_what_cannot_be_told(self):
        lab = self.folder / "slow.yaml"
        lab.write_text("limits: {speed: {joints: 0.002 rad/s}}\n")
        out = self.folder / "slow"
        code, text, _ = call("--for", "load", "--seconds", "14", "--limits", str(lab), "--out", str(out))
        self.assertEqual(code, 0)
        self.assertIn("cannot be told", text)
        sd = {one["key"]: one["sd"] for one in json.loads((out / "expected.json").read_text())["parameters"]}
        self.assertIsNone(sd["load.Ixx"])
        self.assertIsNone(sd["load.centre.x"])

    def test_refuses(self):
        def scenario(text):
            path = self.folder / "robot.yaml"
            path.write_text(f"name: robot\nscene: scenes/floor.xml\n{text}\n")
            return str(path)

        def lab(name, text):
            path = self.folder / f"{name}.yaml"
            path.write_text(text)
            return str(path)

        wall = "limits: {regions: [{name: wall, keep: inside, half_space: {normal: [1, 0, 0], offset: 0.1 m}}]}"
        cases = (
            (("--for", "friction", "--seconds", "8"), "5 terms for friction take at least 14 s"),
            (("--for", "load", "--seconds", "nan"), "take at least 9 s"),
            (("--for", "load", "--terms", "0"), "--terms is 0"),
            (("--for", "masses"), '--for is "masses"'),
            (("--for", "load", "--speed", "1.5"), "--speed is 1.5"),
            (("--for", "load", "--noise", "0"), "--noise is 0"),
            (("--for", "load", "--robot", "host"), "it goes with --run"),
            (("--for", "load", "--scenario", scenario("robot: {q_start: {unit: rad, values: [0, -0.7, 0, -0.08, 0, 1.5, 0.7]}}")), "joint 4 at -0.0800 rad"),
            (("--for", "load", "--limits", lab("list", "limits: [1]")), "no section limits"),
            (("--for", "load", "--limits", lab("unit", "limits: {speed: {joints: 1 m}}")), "unit.yaml"),
            (("--for", "load", "--seconds", "9", "--limits", lab("wall", wall)), "wall"),
        )
        for words, said in cases:
            with self.subTest(said):
                code, _, err = call(*words, "--out", str(self.folder / "refused"))
                self.assertEqual(code, 3, err)
                self.assertIn(said, err)
                self.assertEqual(err.count("\n"), 1, err)


if __name__ == "__main__":
    unittest.main()
