"""Units, signs and orders of columns that cannot be a Panda's."""

import unittest

import numpy as np

from identify_logs import motion
from panda_twin import model
from panda_twin.identify import Block, suspicions


class SuspicionsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.motion = motion(4000)

    def said(self, **changed):
        m = self.motion
        return suspicions(Block(changed.pop("t", m["t"]), {"q": m["q"], "dq": m["dq"], "tau_J": m["tau"], **changed}))

    def exchanged(self, name, i, j):
        values = self.motion[name].copy()
        values[:, [i - 1, j - 1]] = values[:, [j - 1, i - 1]]
        return values

    def test_a_right_log_is_not_suspected(self):
        self.assertEqual(self.said(), [])
        self.assertEqual(self.said(q_d=self.motion["q"]), [])
        self.assertEqual(self.said(q_d=0 * self.motion["q"] + model.Q_READY), [])  # under torque commands
        noise = np.random.default_rng(1).normal(0, 0.2, self.motion["q"].shape)
        self.assertEqual(
            self.said(tau_J=self.motion["tau"] + noise + np.sign(self.motion["dq"]), dq=self.motion["dq"] + 0.05 * noise), []
        )
        load = model.gravity(self.motion["q"], **model.HAND) - model.gravity(self.motion["q"])
        self.assertEqual(self.said(tau_J=self.motion["tau"] + load), [])

    def test_units_and_signs_are_named(self):
        m = self.motion
        for changed, text in (
            ({"q": np.degrees(m["q"])}, "q looks like degrees: joint . is from .*; map it with unit: deg"),
            ({"dq": np.degrees(m["dq"])}, "dq looks like deg/s: it is 57.3 times"),
            ({"dq": -m["dq"]}, "dq has the opposite sign"),
            ({"dq": 0 * m["dq"]}, "dq is zero throughout"),
            ({"t": 1.2 * m["t"]}, "dq is 1.2 times the slope of q"),
            ({"tau_J": 1e3 * m["tau"]}, "tau_J looks like mNm: it is 1000 times"),
            ({"tau_J": -m["tau"]}, "tau_J has the opposite sign"),
            ({"tau_J": m["tau"] - model.gravity(m["q"])}, "tau_J has no gravity in it"),
            (
                {"tau_J": model.gravity(m["q"], g_earth=(9.81, 0, 0))},
                "another robot, another direction of gravity, or a heavy load",
            ),
            ({"q_d": np.degrees(m["q"])}, "q_d looks like degrees"),
            ({"q_d": self.exchanged("q", 2, 4)}, "joint 2 and 4 look swapped in q_d"),
            ({"q": np.repeat(m["q"][::4], 4, axis=0)}, "q changes only once in 4.0 rows"),
            ({"q": m["q"] + 4}, "q is not a Panda's"),
        ):
            with self.subTest(text=text):
                self.assertRegex("\n".join(self.said(**changed)), text)

    def test_exchanged_columns_are_named(self):
        for i, j in ((1, 2), (3, 4), (2, 4), (4, 6), (5, 6), (2, 7)):
            for names in (("dq",), ("tau",), ("q", "dq"), ("q", "dq", "tau")):
                with self.subTest(joints=(i, j), names=names):
                    said = self.said(**{"tau_J" if name == "tau" else name: self.exchanged(name, i, j) for name in names})
                    self.assertRegex("\n".join(said), f"{i} and {j}")


if __name__ == "__main__":
    unittest.main()
