#!/usr/bin/env python3
"""Two programs of unmodified panda-python, in processes of their own, each lead a robot of one scene that `panda-twin serve` serves:

    cell_test.py PROGRAM SOURCE_TREE [unittest options]
"""

import concurrent.futures
import importlib.util
import ipaddress
import json
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import panda_python_test  # noqa: E402: after the path
import witness  # noqa: E402: found by the path above
from twin_server import TwinServer, own_address  # noqa: E402

PROGRAM, SOURCE = "", pathlib.Path()
SPOILT_BY = witness.ENDS_A_MOTION | witness.JUMPS


def after(address):
    return str(ipaddress.ip_address(address) + 1)


class CellTest(unittest.TestCase):
    def lead_both(self, *options, drive="lockstep"):
        scenario = SOURCE / "tests/clients/two_arms.yaml"
        with TwinServer(PROGRAM, SOURCE, drive, scenario, *options) as left, concurrent.futures.ThreadPoolExecutor() as threads:
            right = types.SimpleNamespace(address=after(left.address), said=left.said)
            moved = threads.submit(panda_python_test.run_client, left, "joint_moves")
            posed = threads.submit(panda_python_test.run_client, right, "pose_moves")
            for program, motions in (moved, 4), (posed, 3):
                facts, said = program.result()
                for sign in SPOILT_BY:
                    self.assertNotIn(sign, said)
                self.assertEqual(facts["returned"], [True] * motions, said)
            return left.said()

    def test_lockstep(self):
        said = self.lead_both()
        for name in ("left", "right"):
            self.assertIn(f"{name}: panda-twin serves panda", said)

    def test_at_the_pace_of_the_wall_clock(self):
        # The robot waits for answers; where other programs take the processors for long, the arm all the same became too fast 2 times of 4:
        # by a target that comes late, it seems, from a thread of panda-python's without priority.
        witness.undisturbed(lambda: witness.Witness(PROGRAM, 0), lambda: self.lead_both("--pace", "1"),
                            {"velocity_violation": (witness.IN_ROW, 20)}, attempts=3)

    def test_ends_on_the_wall_clock(self):
        done = subprocess.run([PROGRAM, "serve", SOURCE / "tests/clients/two_arms.yaml", "--bind", own_address(), "--drive", "realtime",
                               "--for", "1", "--data", SOURCE / "models"], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertNotIn("does not answer", done.stdout)

    def test_on_the_wall_clock(self):
        witness.undisturbed(lambda: witness.Witness(PROGRAM), lambda: self.lead_both(drive="realtime"),
                            SPOILT_BY, attempts=3)

    def test_logs_of_both(self):
        with tempfile.TemporaryDirectory(prefix="panda_twin_cell_") as folder:
            self.lead_both("--out", folder, "--no-video")
            for name in ("left", "right"):
                summary = json.loads((pathlib.Path(folder) / name / "summary.json").read_text())
                self.assertGreaterEqual(len(summary["motions"]), 3)

    def test_refuses_what_is_of_one_robot_before_it_listens(self):
        scenario = SOURCE / "tests/clients/two_arms.yaml"
        with TwinServer(PROGRAM, SOURCE, "lockstep", scenario) as served:  # the addresses are taken
            for options, what in ((("--capture", "wire.pcapng"), "--capture"), (("--idle", "freeze", "--drive", "lockstep"), "--idle freeze"),
                                  (("--ros", "--drive", "lockstep"), "--ros")):
                done = subprocess.run([PROGRAM, "serve", scenario, "--bind", served.address, "--data", SOURCE / "models", *options],
                                      capture_output=True, text=True, timeout=60)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (3, 1), done.stderr)
                self.assertIn(what, done.stderr)


if __name__ == "__main__":
    if importlib.util.find_spec("panda_py") is None:
        print("missing: panda-python is not installed: scripts/setup")
        sys.exit(panda_python_test.SKIPPED)
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    panda_python_test.PROGRAM, panda_python_test.SOURCE = PROGRAM, SOURCE
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
