#!/usr/bin/env python3
"""The examples of the Rust crate libfranka-rs 0.9.0, unmodified, against `panda-twin serve`:

    libfranka_rs_test.py PROGRAM SOURCE_TREE lockstep|realtime [unittest options]

They insist on a realtime kernel, which they know by a file in /sys; each sees one in a mount namespace of its own. That needs
root. Not run: mirror_robot, which wants two arms.
"""

import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest

from twin_server import TwinServer

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import witness  # noqa: E402: found by the path above

PROGRAM, SOURCE, DRIVE = "", pathlib.Path(), ""
SKIPPED = 77  # ctest's word for it
EXAMPLES = pathlib.Path()
HERE = pathlib.Path(__file__).parent
MODEL_KEPT_BY_CRATE = pathlib.Path("/tmp/model.so")  # it takes the file for this robot's when there is one
REALTIME_KERNEL = ["unshare", "--mount", "sh", "-c",
                   'mount -t tmpfs tmpfs /sys/kernel && echo 1 >/sys/kernel/realtime && exec "$@"', "sh"]


def example(name, *arguments):
    return [*REALTIME_KERNEL, EXAMPLES / name, *arguments]


def missing():
    """What keeps the examples from running here; empty when nothing does."""
    if not (EXAMPLES / "echo_robot_state").exists():
        return "missing: libfranka-rs is not installed: scripts/setup --clients"
    if os.geteuid() != 0:
        return "only root can show the examples a realtime kernel"
    if subprocess.run([*REALTIME_KERNEL, "true"], capture_output=True).returncode != 0:
        return "this machine allows no mount namespaces"
    return ""


class LibfrankaRsTest(unittest.TestCase):
    def setUp(self):
        MODEL_KEPT_BY_CRATE.unlink(missing_ok=True)
        self.addCleanup(MODEL_KEPT_BY_CRATE.unlink, missing_ok=True)

    def complete(self, name):
        """The example's output, once it has run to its end with success."""
        def attempt():
            with TwinServer(PROGRAM, SOURCE, DRIVE, HERE / "elsewhere.yaml") as server:
                done = subprocess.run(example(name, server.address), input="\n", capture_output=True, text=True, timeout=150)
                said = done.stdout + done.stderr
                self.assertEqual(done.returncode, 0, f"{said}\nserver: {server.said()}")
            return said
        if DRIVE == "lockstep":
            return attempt()
        return witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.ENDS_A_MOTION | witness.JUMPS, attempts=3)

    def test_echo_robot_state(self):
        said = self.complete("echo_robot_state")
        times = [int(t) for t in re.findall(r"time: (\d+)ms", said)]
        self.assertIn("Done", said)
        self.assertEqual(said.count("O_T_EE_c"), 101)
        self.assertEqual(times, sorted(times))

    def test_print_joint_poses(self):
        said = self.complete("print_joint_poses")
        for frame in ("Joint 1", "Joint 7", "Flange", "End-Effector"):
            self.assertIn(frame, said)
        self.assertIn("0.333", said)  # height of the first joint

    def test_download_model(self):
        with tempfile.TemporaryDirectory() as folder, TwinServer(PROGRAM, SOURCE, DRIVE) as server:
            subprocess.run(example("download_model", server.address, folder), check=True, timeout=60, capture_output=True)
            model = pathlib.Path(folder, "model.so")
            self.assertEqual(model.read_bytes()[:4], b"\x7fELF")
            self.assertLess(model.stat().st_size, 64 * 1024)

    def test_generate_joint_position_motion(self):
        self.assertIn("Finished motion", self.complete("generate_joint_position_motion"))

    def test_generate_joint_velocity_motion(self):
        self.assertIn("Finished motion", self.complete("generate_joint_velocity_motion"))

    def test_generate_cartesian_pose_motion(self):
        self.assertIn("Finished motion", self.complete("generate_cartesian_pose_motion"))

    def test_generate_cartesian_velocity_motion(self):
        self.assertIn("Finished motion", self.complete("generate_cartesian_velocity_motion"))

    def test_generate_elbow_motion(self):
        self.assertIn("Finished motion", self.complete("generate_elbow_motion"))

    def test_generate_consecutive_motions(self):
        said = self.complete("generate_consecutive_motions")
        self.assertEqual(said.count("Finished motion."), 5)
        self.assertNotIn("error recovery", said)

    def test_communication_test(self):
        said = self.complete("communication_test")
        samples = int(re.search(r"success rate of (\d+) samples", said).group(1))
        rates = {name: float(rate) for name, rate in re.findall(r"(Max|Avg|Min):? ([\d.]+)", said)}
        print(f"{DRIVE}: success rates {rates} in {samples} samples")
        if DRIVE == "lockstep":
            self.assertEqual(samples, 10000)
            self.assertEqual(rates["Max"], 1)
            self.assertNotIn("did not get executed", said)

    @unittest.skipIf(importlib.util.find_spec("panda_py") is None, "missing: panda-python is not installed: scripts/setup")
    def test_grasp_object(self):
        with TwinServer(PROGRAM, SOURCE, DRIVE, "--scene", "scenes/table_box.xml") as server:
            subprocess.run([sys.executable, "-B", HERE / "panda_programs.py", "reach_for_box", server.address], check=True,
                           timeout=120, capture_output=True)
            done = subprocess.run(example("grasp_object", server.address, "0.05"), capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 0, f"{done.stdout}{done.stderr}\nserver: {server.said()}")
        self.assertIn("Grasped object, will release it now.", done.stdout)

    def test_grasp_object_finds_out_that_there_is_none(self):
        with TwinServer(PROGRAM, SOURCE, DRIVE) as server:
            done = subprocess.run(example("grasp_object", "--homing", server.address, "0.05"), capture_output=True, text=True,
                                  timeout=60)
        self.assertIn("Object lost", done.stderr)

    def test_cartesian_impedance_control(self):
        """It ends with an error or never: it is let run, and killed; the next client finds the robot idle."""
        with TwinServer(PROGRAM, SOURCE, DRIVE) as server:
            endless = subprocess.Popen(example("cartesian_impedance_control", server.address), stdin=subprocess.PIPE,
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            endless.stdin.write("\n")
            endless.stdin.flush()
            time.sleep(5)
            ended = endless.poll()
            endless.kill()
            said, _ = endless.communicate(timeout=60)
            self.assertIsNone(ended, said)
            echo = subprocess.run(example("echo_robot_state", server.address), capture_output=True, text=True, timeout=60)
            self.assertIn("robot_mode: Idle", echo.stdout)


if __name__ == "__main__":
    PROGRAM, SOURCE, DRIVE = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    EXAMPLES = SOURCE / ".clients/rust/bin"
    if reason := missing():
        print(reason)
        sys.exit(SKIPPED)
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
