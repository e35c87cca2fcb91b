"""What an identification says of robots whose truth is known: its intervals hold the truth as often as they say, without bias.

    identify_recovery_test.py [ROBOTS [FIRST]]

As a test 6 robots; `identify_recovery_long_test` takes 200 and prints the table of docs/how-to/compare.md.
"""

import sys
import unittest

import numpy as np

import identify_robots as robots
from panda_twin.identify import compare
from panda_twin.identify._regression import QUANTILE

ROBOTS = 6
FIRST = 0
KINDS = ("viscous", "coulomb", "offset", "steepness", "shift", "load.m", "load.h", "load.I", "delay")


def truth_of(key, truth):
    if key.startswith("plant.friction"):
        name, _, rest = key.removeprefix("plant.friction.").partition("[")
        return truth.law[robots.FRICTION.index(name), int(rest[0])]
    if key.startswith("load"):
        return truth.body[("m", "hx", "hy", "hz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz").index(key[5:])]
    return truth.delay


def kind_of(key):
    return next(kind for kind in KINDS if kind in key)


class Recovery(unittest.TestCase):
    def test_intervals_hold_the_truth(self):
        found = {kind: [] for kind in KINDS}
        untold = 0
        for seed in range(FIRST, FIRST + ROBOTS):
            truth = robots.drawn(seed)
            log = robots.logged(robots.scenario(truth, seed), seed)
            result = compare(log, mapping=robots.MAPPING, against={"name": "prior", "plant": {"friction": "none"}, "motion": {"trajectory": {"unit": "rad", "waypoints": robots.swing(12, 0)}}},
                             identify=["friction", "load", "delay"])  # fmt: skip
            estimate = result.identified.estimates[0]
            for parameter, value, sd, told in zip(estimate.parameters, estimate.values, estimate.sd, estimate.told):
                untold += not told
                if told:
                    found[kind_of(parameter.key)].append((value, truth_of(parameter.key, truth), sd))
        print(f"\n{ROBOTS} robots from {FIRST}, {untold} parameters untold")
        print(f"{'':10}{'number':>8}{'in 95 %':>9}{'bias':>9}{'median sd':>12}")
        within, number = 0, 0
        for kind, values in found.items():
            if not values:
                continue
            value, true, sd = np.array(values).T
            inside = np.abs(value - true) < QUANTILE * sd
            bias = np.mean(value - true) / np.mean(np.abs(true))
            print(f"{kind:10}{len(value):8}{100 * inside.mean():8.1f} %{100 * bias:7.2f} %{np.median(sd):12.2g}")
            within, number = within + inside.sum(), number + len(inside)
            if ROBOTS >= 100 and kind != "shift":  # around zero, where a share says nothing
                self.assertLess(abs(bias), 0.02, kind)
        print(f"{'all':10}{number:8}{100 * within / number:8.1f} %")
        low, high = (0.93, 0.97) if ROBOTS >= 100 else (0.88, 0.995)
        self.assertTrue(low <= within / number <= high, within / number)


if __name__ == "__main__":
    arguments = [int(x) for x in sys.argv[1:] if x.isdigit()]
    ROBOTS, FIRST = arguments + [ROBOTS, FIRST][len(arguments) :]
    unittest.main(argv=sys.argv[:1])
