#!/usr/bin/env python3
"""Unmodified panda-python on a robot whose session is kept (`serve --out`) and whose time a second program pauses (`--control`):

    session_test.py PROGRAM SOURCE_TREE [unittest options]
"""

import concurrent.futures
import importlib.util
import json
import pathlib
import sys
import tempfile
import unittest

import panda_python_test
from twin_server import TwinServer

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "server"))
from serve_control_test import Channel  # noqa: E402: found by the path above

PROGRAM, SOURCE = "", pathlib.Path()


class SessionTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_a_grasp_leaves_each_of_its_motions(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep", *panda_python_test.TABLE, "--out", str(self.folder), "--no-video") as server:
            facts = panda_python_test.run_client(server, "grasp_box")[0]
        self.assertTrue(facts["grasped_lifted"])
        motions = json.loads((self.folder / "summary.json").read_text())["motions"]
        self.assertGreaterEqual(len(motions), 3)
        self.assertEqual({motion["end"] for motion in motions}, {"finished"})
        self.assertEqual(len({motion["client"] for motion in motions}), 1)
        for number in range(1, len(motions) + 1):
            self.assertTrue((self.folder / "motions" / str(number) / "plots/joints.svg").exists())

    def test_pauses_and_steps_do_not_disturb_it(self):
        path = self.folder / "control"
        with TwinServer(PROGRAM, SOURCE, "lockstep", "--control", str(path)) as server, \
                concurrent.futures.ThreadPoolExecutor() as threads:
            channel = Channel(path)
            self.addCleanup(channel.close)
            moved = threads.submit(panda_python_test.run_client, server, "joint_moves")
            in_motion = 0
            while not moved.done():
                paused = channel.ask(do="pause")
                stepped = channel.ask(do="step", cycles=20)
                self.assertEqual(stepped["cycle"], paused["cycle"] + 20)
                in_motion += stepped["mode"] == "Move"
                self.assertTrue(channel.ask(do="resume")["ok"])
            facts = moved.result()[0]
        self.assertGreater(in_motion, 0)
        self.assertEqual(facts["returned"], [True] * 4)
        self.assertLess(max(facts["errors"]), panda_python_test.JOINT_GOAL)


if __name__ == "__main__":
    if importlib.util.find_spec("panda_py") is None:
        print("missing: panda-python is not installed: scripts/setup")
        sys.exit(panda_python_test.SKIPPED)
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
