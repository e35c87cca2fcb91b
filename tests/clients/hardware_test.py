#!/usr/bin/env python3
"""Only --allow-hardware moves a real arm, at whatever address it listens: hardware_test.py PROGRAM SOURCE_TREE [unittest options].

The independent peer stands for a robot: like one it knows nothing of twins, and tells which requests came.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import own_client_test
import proxy_test
from twin_server import TwinServer, own_address

PROGRAM, SOURCE = "", pathlib.Path()
FLAG = "--allow-hardware"
UNREHEARSED = (FLAG, "--yes", "--no-rehearsal", "a peer without physics")


class Robot:
    """with Robot() as robot: robot.address; afterwards robot.requests, the names of those it got"""

    def __enter__(self):
        self.address = own_address()
        self.process = subprocess.Popen([sys.executable, pathlib.Path(__file__).with_name("fci_peer.py"), "--host", self.address, "-v"],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        if "listening" not in self.process.stdout.readline():
            raise RuntimeError("no peer")
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.requests = re.findall(r"(?m)^<- ([A-Z]\w+)", self.process.communicate()[0])


class HardwareTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)
        self.scenario = self.tmp / "scenario.yaml"
        self.scenario.write_text(own_client_test.MOTION.replace("INTERFACE", "joint_position").replace("CONTROLLER", "")
                                 .replace("START", "0.7853981633974483"))

    def run_at(self, address, *flags):
        """A machine on which no Connect is answered within the client's 3 s says nothing yet."""
        while True:
            done = subprocess.run([PROGRAM, "run", self.scenario, "--backend", "fci", "--robot", address, "--data", SOURCE / "models",
                                   "--out", self.tmp / "out", *flags], capture_output=True, text=True, timeout=120)
            if "has not answered for 3 s" not in done.stderr:
                return done

    def check_is_refused(self, address, *flags):
        done = self.run_at(address, *flags)
        self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
        self.assertIn(FLAG, done.stderr)
        self.assertIn("does not say that it is a twin", done.stderr)
        self.assertIn(f"--robot {address if ':' in address else address + ':1337'}:", done.stderr)  # which port would have moved
        self.assertNotIn("settings", done.stdout)  # nothing was asked of it

    def check_got_no_request_that_acts(self, robot):
        """GetCartesianLimit changes nothing: it asks for the twin's sign."""
        self.assertIn("Connect", robot.requests)
        self.assertLessEqual(set(robot.requests), {"Connect", "GetCartesianLimit"})

    def test_a_robot_is_asked_for_at_the_loopback_too(self):
        with Robot() as robot:
            self.check_is_refused(robot.address)
            self.check_is_refused(robot.address, "--page=0")
        self.check_got_no_request_that_acts(robot)

    def test_a_proxy_speaks_for_the_robot_behind_it(self):
        with Robot() as robot, proxy_test.Proxy(robot.address) as proxy:
            self.check_is_refused(proxy.address)
        self.check_got_no_request_that_acts(robot)

    def test_a_robot_that_was_allowed_is_driven(self):
        with Robot() as robot:
            done = self.run_at(robot.address, *UNREHEARSED)
        self.assertNotIn(f"say {FLAG}", done.stderr)
        self.assertRegex(done.stdout + done.stderr, r"(?m)^ok +hardware +a real arm may move")
        self.assertRegex(done.stdout, r"(?m) states ")  # its checks go on
        self.assertTrue([name for name in robot.requests if name.startswith("Set")], robot.requests)

    def test_check_only_tells_all_and_moves_nothing(self):
        """The peer stands 0.2 rad beside the first waypoint."""
        with Robot() as robot:
            done = self.run_at(robot.address, *UNREHEARSED[:1], *UNREHEARSED[2:], "--check-only")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        for check in ("lab", "path", "rehearsal", "speed", "reach", "hardware", "mode", "errors", "joint limits", "settings", "payload"):
            self.assertRegex(done.stdout, rf"(?m)^ok +{check} ")
        for check in ("states", "communication", "scheduler"):  # what this machine decides
            self.assertRegex(done.stdout, rf"(?m)^(ok|FAILED) +{check} ")
        self.assertRegex(done.stdout, r"(?m)^FAILED start +joint 4 is 0\.2000 rad from the first waypoint")
        self.assertIn("the arm was not moved", done.stderr)
        self.assertNotIn("Move", robot.requests)
        self.assertFalse((self.tmp / "out").exists())

    def test_a_twin_is_not_asked_for(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server, proxy_test.Proxy(server.address) as proxy:
            for address in (server.address, proxy.address):
                done = self.run_at(address, "--robot-time", "states")
                self.assertNotIn(FLAG, done.stderr)
                self.assertRegex(done.stdout + done.stderr, r"(?m)^ok +hardware +none")
                self.assertRegex(done.stdout, r"(?m) states ")

    def test_a_tilt_and_a_load_must_be_said(self):
        """The robot does not know them; its torques at rest do."""
        lab = self.tmp / "lab.yaml"
        lab.write_text("plant: {base_tilt: {roll: 8 deg, pitch: 0 deg}}\nload: {mass: 0.8 kg}\n")
        with TwinServer(PROGRAM, SOURCE, "lockstep", self.scenario, "--lab", lab) as server:
            flags = (server.address, "--robot-time", "states", "--check-only")
            done = self.run_at(*flags)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertRegex(done.stdout, r"(?m)^FAILED torques +joint \d holds .* tilted by 0\.0, 0\.0 deg .* a load of 0\.000 kg need")
            self.assertRegex(self.run_at(*flags, "--lab", lab).stdout,
                             r"(?m)^ok +torques +at rest within .* tilted by 8\.0, 0\.0 deg .* a load of 0\.800 kg")

    def test_a_path_beyond_a_limit_of_the_lab_moves_nothing(self):
        lab = self.tmp / "lab.yaml"
        lab.write_text("limits: {regions: [{name: wall, what: [end_effector], keep: inside, "
                       "half_space: {normal: [0, 1, 0], offset: 5 mm}}]}\n")
        with Robot() as robot:
            done = self.run_at(robot.address, *UNREHEARSED, "--lab", lab)
        self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
        self.assertIn('limit "wall": the end effector reaches', done.stderr)
        self.assertNotIn("Move", robot.requests)

    def test_a_force_above_the_labs_cap_stops_the_arm_over_the_wire(self):
        lab = self.tmp / "lab.yaml"
        lab.write_text("limits: {force: 15 N}\n")
        with self.scenario.open("a") as file:
            file.write("onboard: {collision_behavior: off}\nperturbations: [{push: {body: panda_hand, motion: 1, begin: 300 ms, "
                       "duration: 600 ms, rise: 200 ms, force: [0 N, 30 N, 0 N], point: [0 m, 0 m, 0.1 m]}}]\n")
        with TwinServer(PROGRAM, SOURCE, "lockstep", self.scenario) as server:
            done = self.run_at(server.address, "--robot-time", "states", "--lab", lab)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertRegex(done.stdout + done.stderr, r"lab_limit: limit force: the end effector is pushed with 15\.\d* N; the bound is 15 N")

    def test_without_a_wire_there_is_nothing_to_allow(self):
        done = subprocess.run([PROGRAM, "run", self.scenario, FLAG, "--data", SOURCE / "models", "--out", self.tmp / "out"],
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 3)
        self.assertIn("--backend fci", done.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    proxy_test.PROGRAM = PROGRAM
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
