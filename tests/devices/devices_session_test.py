#!/usr/bin/env python3
"""Leads the robot by devices, from the command line: devices_session_test.py PROGRAM [unittest options]."""

import json
import os
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import witness  # noqa: E402: found by the path above

PROGRAM = ""

SCENARIO = """name: led
seed: 1
plant: {{kind: ideal}}
operator:
  device: {device}
  parameters: {{{parameters}}}
robot:
  q_start: {{unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}}
application:
  type: teleoperation
render: {{enabled: false}}
"""

HEADER = "time,kind,x,y,z,rx,ry,rz,engaged,mode,gripper,frame,scale,stop,release,end\n"


def script(duration=2.0, deflection=0.5):
    """At rest for 0.5 s, ahead for half of the rest, at rest again."""
    count = round(duration / 0.02)
    return HEADER + "".join(
        f"{0.02 * i:.9f},rate,{deflection if 25 < i < count // 2 else 0},0,0,0,0,0,1,0,0,0,0,0,0,0\n" for i in range(count))


class SessionTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_session_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def arguments(self, name, device, parameters, *more):
        (self.folder / f"{name}.yaml").write_text(SCENARIO.format(device=device, parameters=parameters))
        return [PROGRAM, "run", f"{name}.yaml", "--out", name, *more]

    def run_led(self, name, device, parameters, *more):
        environment = dict(os.environ, XDG_CACHE_HOME=str(self.folder / "cache"))
        return subprocess.run(self.arguments(name, device, parameters, *more), cwd=self.folder, env=environment,
                              capture_output=True, text=True, timeout=100)

    def summary(self, name):
        return json.loads((self.folder / name / "summary.json").read_text())


class LockstepTest(SessionTest):
    def test_a_recording_repeats_the_session_bit_by_bit(self):
        (self.folder / "hands.csv").write_text(script())
        first = self.run_led("first", "script", "file: hands.csv, record: again.csv")
        self.assertEqual(first.returncode, 0, first.stdout + first.stderr)
        again = self.run_led("again", "script", "file: again.csv")
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertEqual(self.summary("first")["states_hash"], self.summary("again")["states_hash"])

    def test_other_hands_lead_elsewhere(self):
        (self.folder / "ahead.csv").write_text(script())
        (self.folder / "back.csv").write_text(script(deflection=-0.5))
        for name in ("ahead", "back"):
            self.assertEqual(self.run_led(name, "script", f"file: {name}.csv").returncode, 0)
        self.assertNotEqual(self.summary("ahead")["states_hash"], self.summary("back")["states_hash"])

    def test_files_are_named_against_the_folder_of_the_scenario(self):
        (self.folder / "deep").mkdir()
        (self.folder / "deep" / "hands.csv").write_text(script())
        arguments = self.arguments("deep/led", "script", "file: hands.csv, record: again.csv")
        done = subprocess.run(arguments, cwd=self.folder, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue((self.folder / "deep" / "again.csv").is_file())

    def test_a_script_ends_over_a_wire_that_loses_most(self):
        (self.folder / "hands.csv").write_text(HEADER + "0,rate,0,0,0,0,0,0,1,0,0,0,0,0,0,1\n")
        arguments = self.arguments("lossy", "script", "file: hands.csv")
        path = self.folder / "lossy.yaml"
        lossy = path.read_text().replace("  device:", "  to_robot_loss: 60 %\n  device:")
        path.write_text(lossy.replace("type: teleoperation", "type: teleoperation\n  parameters: {longest: 9 s}"))
        done = subprocess.run(arguments, cwd=self.folder, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        took = re.search(r"\bduration: ([\d.]+) s", done.stdout)
        self.assertLess(float(took[1]), 6, done.stdout)  # and not for as long as it may

    def test_refuses_what_a_device_does_not_take(self):
        (self.folder / "hands.csv").write_text(HEADER + "0,rate,2,0,0,0,0,0,1,0,0,0,0,0,0,0\n")
        for device, parameters, text in (
                ("script", "file: hands.csv", "hands.csv:2: column x is '2'; it must lie in [-1, 1]"),
                ("script", "file: hands.csv, repeat: 1 h", "operator.parameters.repeat"),
                ("network", "token: secret", "goes with --drive realtime"),
                ("mouse", "", "evdev, network, script")):
            done = self.run_led("refused", device, parameters)
            self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(text, done.stderr)


class RealtimeTest(SessionTest):
    def test_what_a_program_led_on_the_wall_clock_runs_in_lockstep(self):
        witness.undisturbed(lambda: witness.Witness(PROGRAM), self.lead_on_the_wall_clock, witness.ENDS_A_MOTION)
        again = self.run_led("again", "script", "file: led.csv")
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertRegex(again.stdout, r"speed of the arm's reference, largest: 0\.0[1-9]")

    def lead_on_the_wall_clock(self):
        led = subprocess.Popen(self.arguments("led", "network", "token: secret, port: 0, record: led.csv", "--drive", "realtime"),
                               cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        port = next(int(found.group(1)) for line in led.stdout if (found := re.search(r"127\.0\.0\.1:(\d+) \(UDP\)", line)))
        device = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(device.close)
        device.connect(("127.0.0.1", port))
        device.settimeout(0.01)
        answers, sequence = 0, 0
        while led.poll() is None:  # at rest, ahead, at rest; then the end is pressed until it has come
            sequence += 1
            ahead = 0.4 if 50 < sequence < 150 else 0
            device.send(struct.pack("<4sHBB16sQq6d7I", b"PTOS", 1, 0, 1, b"secret", sequence, 0, ahead, *5 * [0], *6 * [0], int(sequence > 250)))
            try:
                answers += len(device.recv(200)) == 72
            except (TimeoutError, ConnectionRefusedError):
                pass
            time.sleep(0.01)
        said = led.stdout.read()
        led.stdout.close()
        self.assertEqual(led.returncode, 0, said)
        self.assertGreater(answers, 0)


if __name__ == "__main__":
    PROGRAM = sys.argv[1]
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
