"""Replay of a log's commands: the twin's own to the bit, a robot's with losses, gaps and without commands; INT's estimates."""

import os
import pathlib
import tempfile
import unittest

import numpy as np

import panda_twin
from panda_twin.identify._closed import closed_of, external_of
from panda_twin.identify._observer import ExternalTorque, external_torque
from panda_twin.identify.logs._recording import Recording
from panda_twin.identify._replay import replay

SCENARIOS = pathlib.Path(__file__).parents[2] / "models/scenarios"
STATES = ("q", "dq", "tau_J", "q_d", "dq_d", "tau_ext_hat_filtered", "O_F_ext_hat_K")
SHORT = {"motion": {"trajectory": {"unit": "rad", "duration": "2 s", "waypoints": [
    {"q": [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}, {"q": [0.3, -0.6, 0.1, -2.2, 0, 1.7, 0.7854]}]}}}  # fmt: skip
PUSH = {"push": {"body": "panda_hand", "begin": "0.5 s", "duration": "1 s", "rise": "200 ms", "force": ["0 N", "8 N", "0 N"]}}


def joined(blocks):
    blocks = list(blocks)
    return {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}


class Logs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.made = {}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def log(self, name, scenario):
        """Recording and scenario of a run, aborted or not."""
        if name not in self.made:
            out = os.path.join(self.folder.name, name)
            try:
                panda_twin.run(scenario, out=out, video=False, plots=False)
            except panda_twin.RobotFault:
                pass
            recording = Recording.open(os.path.join(out, "run.mcap"))
            self.made[name] = recording, recording.scenario
        return self.made[name]

    def short(self, **changes):
        return self.log("short" + "_".join(sorted(changes)), panda_twin.Scenario(name="short", **{**SHORT, **changes}))

    def arrays(self, recording, *names):
        return {name: np.concatenate([block.columns[name] for block in recording.blocks(name)]) for name in names}


class OwnTest(Logs):
    def test_gives_the_logs_states_to_the_bit(self):
        for name in ("smoke", "packet_loss", "torque", "outage", "collision", "cartesian_pose"):
            recording, scenario = self.log(name, SCENARIOS / f"{name}.yaml")
            with self.subTest(name):
                twin = joined(replay(recording, scenario))
                logged = self.arrays(recording, "message_id", "fate", "robot_mode", "errors", *STATES)
                for column, values in logged.items():
                    np.testing.assert_array_equal(twin[column], values, column)
                if name in ("outage", "collision"):
                    self.assertNotEqual(twin["errors"][-1], "")

    def test_compares_without_a_difference(self):
        recording, scenario = self.short()
        closed = closed_of(recording, scenario)
        self.assertIsNone(closed.first_difference)
        self.assertEqual((closed.cycles, closed.events), (recording.rows, []))
        self.assertEqual((closed.position_rms.max(), closed.torque_rms.max()), (0, 0))
        self.assertEqual(len(closed.t), -(-recording.rows // 10))
        heavy = closed_of(recording, scenario.replace(robot={"load": {"mass": "1 kg"}}))
        self.assertLess(heavy.first_difference, 5)
        self.assertGreater(heavy.torque_rms[1], 1)
        self.assertEqual(closed_of(*self.log("outage", SCENARIOS / "outage.yaml")).events,
                         [f"{who}: communication_constraints_violation in cycle 5020" for who in ("robot", "twin")])

    def test_delays_the_commands(self):
        recording, scenario = self.short()
        twin, late = (joined(replay(recording, scenario, cycles_of_delay=cycles)) for cycles in (0, 3))
        np.testing.assert_allclose(late["q_d"][3:], twin["q_d"][:-3], rtol=0, atol=1e-12)
        self.assertEqual(list(late["errors"]), [""] * recording.rows)


class RobotTest(Logs):
    """The same logs without what only the twin tells."""

    def robots(self, keep=None, columns=("q", "dq", "tau_J", "q_c", "q_d", "dq_d"), **changes):
        recording, scenario = self.short(**changes)
        arrays = self.arrays(recording, "message_id", "fate", *columns)
        if "q_c" in arrays:
            arrays["q_c"] = np.nan_to_num(arrays["q_c"])
        fates = arrays.pop("fate")
        rows = np.ones(len(fates), bool) if keep is None else keep(fates)
        return Recording.open({name: values[rows] for name, values in arrays.items()}), scenario, arrays, rows

    def follows(self, robot, scenario, arrays, rows, tolerance=1e-9):
        twin = joined(replay(robot, scenario))
        self.assertEqual(set(twin["errors"]), {""})
        self.assertEqual(len(twin["q"]), rows.sum())
        np.testing.assert_allclose(twin["q_d"], arrays["q_d"][rows], rtol=0, atol=tolerance)
        np.testing.assert_allclose(twin["q"], arrays["q"][rows], rtol=0, atol=1e-3)
        return twin

    def test_takes_positions(self):
        self.follows(*self.robots())

    def test_takes_the_robots_reference_where_there_are_no_commands(self):
        self.follows(*self.robots(columns=("q", "q_d")))

    def test_holds_where_the_robot_did(self):
        robot, scenario, arrays, rows = self.robots(link={"command_loss": "3 %"})
        twin = self.follows(robot, scenario, arrays, rows, tolerance=1e-8)
        self.assertGreater(np.sum(twin["fate"] == "held"), 20)

    def test_bridges_rows_that_are_missing(self):
        random = np.random.default_rng(2)

        def keep(fates):
            gaps = random.random(len(fates)) < 0.02
            for k in np.flatnonzero(gaps):
                gaps[k : k + random.integers(1, 9)] = True
            gaps[:50] = False
            return ~gaps

        self.follows(*self.robots(keep), tolerance=1e-6)

    def test_aborts_where_the_robot_did(self):
        recording, scenario = self.log("outage", SCENARIOS / "outage.yaml")
        robot = Recording.open(self.arrays(recording, "message_id", "q", "dq", "tau_J", "q_c", "q_d", "dq_d"))
        self.assertEqual(closed_of(robot, scenario).events, ["twin: communication_constraints_violation in cycle 5020"])

    def test_takes_torques(self):
        recording, scenario = self.log("torque", SCENARIOS / "torque.yaml")
        arrays = self.arrays(recording, "message_id", "q", "dq", "tau_J", "tau_J_c", "q_d", "dq_d")
        closed = closed_of(Recording.open(arrays), scenario)
        self.assertEqual(closed.events, [])
        self.assertLess(closed.position_largest.max(), 1e-4)
        del arrays["tau_J_c"]  # what is left is a q_d that stands still
        self.assertIsNone(closed_of(Recording.open(arrays), scenario))

    def test_needs_a_begin_at_rest(self):
        robot, scenario, _, _ = self.robots(lambda fates: np.arange(len(fates)) > 800)
        with self.assertRaisesRegex(ValueError, "begins in a motion: joint . moves at"):
            next(replay(robot, scenario))
        self.assertIsNone(closed_of(robot, scenario))


class ExternalTest(Logs):
    def test_gives_the_logs_estimates(self):
        recording, scenario = self.short(perturbations=[PUSH])
        arrays = self.arrays(recording, "q", "dq", "tau_J", "tau_ext_hat_filtered", "O_F_ext_hat_K")
        self.assertGreater(np.abs(arrays["O_F_ext_hat_K"]).max(), 5)
        torque, wrench = external_torque(scenario, arrays["q"], arrays["dq"], arrays["tau_J"])
        np.testing.assert_allclose(torque, arrays["tau_ext_hat_filtered"], rtol=0, atol=1e-12)
        np.testing.assert_allclose(wrench, arrays["O_F_ext_hat_K"], rtol=0, atol=1e-11)
        found = external_of([recording], scenario)
        self.assertLess(found.torque_rms.max(), 1e-12)
        self.assertLess(found.wrench_rms.max(), 1e-11)

    def test_goes_on_from_block_to_block_and_begins_anew_after_a_gap(self):
        recording, scenario = self.short(perturbations=[PUSH])
        arrays = self.arrays(recording, "q", "dq", "tau_J")
        whole = external_torque(scenario, *arrays.values())
        observer, t = ExternalTorque(scenario), 1e-3 * np.arange(len(arrays["q"]))
        parts = [observer.advance(t[part], *(x[part] for x in arrays.values())) for part in (slice(0, 700), slice(700, None))]
        for i in range(2):
            np.testing.assert_array_equal(np.concatenate([part[i] for part in parts]), whole[i])
        gap = ExternalTorque(scenario)
        gap.advance(t[:1000], *(x[:1000] for x in arrays.values()))
        after = gap.advance(t[1100:], *(x[1100:] for x in arrays.values()))[0]
        np.testing.assert_allclose(after[200:], whole[0][1300:], rtol=0, atol=1e-6)

    def test_is_absent_without_the_robots_estimate(self):
        self.assertIsNone(external_of([Recording.open({"message_id": np.arange(10), "q": np.zeros((10, 7))})], panda_twin.Scenario(name="short", **SHORT)))


if __name__ == "__main__":
    unittest.main()
