#!/usr/bin/env python3
"""Runs in real time from outside: realtime_test.py PROGRAM SOURCE_TREE [unittest options].

A run that this machine spoilt, as a witness saw, is repeated.
"""

import bisect
import csv
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import witness  # noqa: E402: found by the path above

PROGRAM = ""
SOURCE = pathlib.Path()

MOTION = """\
name: gentle
plant: {kind: ideal}
link: {state_delay: 80 us, command_delay: 80 us}
onboard: {abort_after_lost: 1000}
controller: {phase: 400 us}
motion:
  trajectory:
    unit: rad
    velocity_scale: 0.1
    acceleration_scale: 0.03
    jerk_scale: 0.03
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.2, -0.7854, 0.1, -2.3562, 0, 1.5708, 0.9]}
render: {enabled: false}
"""

# One that nobody waits for the end of, and that a machine that holds it up for seconds does not abort.
LONG = MOTION.replace("velocity_scale: 0.1", "duration: 60 s").replace("abort_after_lost: 1000", "abort_after_lost: 1000000")

HAND = """\
hand:
  - {at: 0 s, move: {width: 75 mm, speed: 0.1 m/s}}
  - {at: 0.5 s, grasp: {width: 50 mm, speed: 0.1 m/s, force: 40 N}}
"""

# Longer than any machine takes over what is waited for.
TIMEOUT = 120


def columns(folder, prefix):
    """Times and the seven values `prefix` of every cycle of a run's log while it moved."""
    subprocess.run([PROGRAM, "export", folder / "run.mcap", "--out", folder / "csv"], check=True, capture_output=True)
    times, values = [], []
    with open(folder / "csv" / "cycles.csv", newline="") as table:
        for row in csv.DictReader(table):
            times.append(int(row["at_ns"]) * 1e-9)
            values.append([float(row[f"{prefix}[{j}]"]) for j in range(7)])
    return times, values


def at(times, values, t):
    """Linear between the cycles."""
    i = min(max(bisect.bisect_right(times, t) - 1, 0), len(times) - 2)
    share = (t - times[i]) / (times[i + 1] - times[i])
    return [a + share * (b - a) for a, b in zip(values[i], values[i + 1])]


def first_move(times, values):
    start = values[0]
    return next(t for t, v in zip(times, values) if max(abs(a - b) for a, b in zip(v, start)) > 1e-4)


class RealtimeTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.tmp = pathlib.Path(self.folder.name)
        self.scenario = self.tmp / "gentle.yaml"
        self.scenario.write_text(MOTION)

    def command(self, out, drive):
        return [PROGRAM, "run", self.scenario, "--drive", drive, "--out", out, "--data", SOURCE / "models", "--no-video"]

    def await_log(self, out, chunks):
        """Until so many chunks of the log are on the disk: each holds some 200 cycles."""
        log = out / "run.mcap.partial"
        limit = time.monotonic() + TIMEOUT
        while not (log.exists() and log.stat().st_size > chunks * 512 * 1024):
            self.assertLess(time.monotonic(), limit, "no cycles are recorded")
            time.sleep(0.01)

    def start(self):
        """A long run in real time that is in its motion."""
        self.scenario.write_text(LONG)
        out = self.tmp / "out"
        process = subprocess.Popen(self.command(out, "realtime"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        self.await_log(out, 1)
        return process, out

    def assert_of_a_whole_run(self, out, claim):
        """claim() holds of a run in real time beside which no thread, of the controller's priority, was late for four cycles in a row."""
        def attempt():
            done = subprocess.run(self.command(out, "realtime"), capture_output=True, text=True)
            if done.returncode not in (0, 1):  # no lateness of the host excuses a crash or a refusal
                raise RuntimeError(f"exit code {done.returncode}: {done.stdout}{done.stderr}")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            claim()
        witness.undisturbed(lambda: witness.Witness(PROGRAM, 0), attempt, {"": (witness.IN_ROW, 4)})

    def assert_readable(self, log):
        done = subprocess.run([PROGRAM, "export", log, "--out", self.tmp / "exported"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(len((self.tmp / "exported" / "cycles.csv").read_text().splitlines()), 100)

    def test_moves_as_in_lockstep(self):
        out = self.tmp / "lockstep"
        done = subprocess.run(self.command(out, "lockstep"), capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        times, values = columns(out, "q_d")
        # Three wake-ups behind and three commands; the shift is known to a cycle.
        way_of_a_cycle = max(max(abs(a - b) for a, b in zip(v, w)) for v, w in zip(values, values[1:]))
        out = self.tmp / "realtime"

        def claim():
            realtime = columns(out, "q_d")
            shift = first_move(*realtime) - first_move(times, values)
            worst = max(max(abs(a - b) for a, b in zip(v, at(*realtime, t + shift))) for t, v in zip(times[::5], values[::5]))
            self.assertLess(worst, 7 * way_of_a_cycle)
        self.assert_of_a_whole_run(out, claim)

    def test_terminated_it_stops_the_arm_and_completes_the_log(self):
        process, out = self.start()
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 130, said)
        self.assert_readable(out / "run.mcap")

    def test_killed_it_leaves_a_log_that_can_be_read(self):
        process, out = self.start()
        process.kill()
        process.communicate(timeout=TIMEOUT)
        self.assert_readable(out / "run.mcap.partial")

    def test_stopped_and_continued_it_ends_and_never_catches_up_in_a_burst(self):
        process, out = self.start()
        process.send_signal(signal.SIGSTOP)
        time.sleep(1)
        process.send_signal(signal.SIGCONT)
        self.await_log(out, 3)
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=TIMEOUT)
        self.assertIn(process.returncode, (1, 130), said)
        self.assert_readable(out / "run.mcap")
        self.assertGreaterEqual(json.loads((out / "timing.json").read_text())["robot_overruns"], 900)
        with open(self.tmp / "exported" / "cycles.csv", newline="") as table:
            cycles = [(int(row["at_ns"]), int(row["message_id"])) for row in csv.DictReader(table)]
        for (t0, id0), (t1, id1) in zip(cycles, cycles[1:]):
            self.assertEqual(id1, id0 + 1)
            self.assertGreaterEqual(t1 - t0, 999_000, "a cycle was begun before the last was over")

    def test_drift_of_the_robots_clock_shows_in_the_period(self):
        out = self.tmp / "out"
        subprocess.run([*self.command(out, "realtime"), "--clock-ppm", "1000"], capture_output=True)
        times, _ = columns(out, "q_d")
        # A cycle that began late is postponed, and the step to it is longer; none is shorter.
        self.assertAlmostEqual(min(b - a for a, b in zip(times, times[1:])), 1e-3 / 1.001, delta=1e-8)

    def test_gives_the_hand_its_commands_beside_the_motion(self):
        self.scenario.write_text(MOTION + HAND)

        def claim():
            hand = json.loads((self.tmp / "out/summary.json").read_text())["hand"]
            self.assertEqual([command["result"] for command in hand["commands"]], ["success", "unsuccessful"])
            for command, begin in zip(hand["commands"], (0, 0.5)):
                self.assertGreaterEqual(command["begun_s"], begin)
            self.assertFalse(hand["is_grasped"])
        self.assert_of_a_whole_run(self.tmp / "out", claim)

    def test_two_robots_hand_an_object_over(self):
        out = self.tmp / "cell"

        def attempt():
            done = subprocess.run([PROGRAM, "run", SOURCE / "models/cells/hand_over.yaml", "--drive", "realtime", "--out", out, "--data",
                                   SOURCE / "models", "--no-video"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.A_CLIENT)
        begun = []
        for robot in ("left", "right"):
            # As in lockstep: whose motion has ended is recorded no more, so it saw nothing of what came after.
            summary = json.loads((out / robot / "summary.json").read_text())
            self.assertEqual([finding for finding in summary["findings"] if finding["met"] is False], [])
            subprocess.run([PROGRAM, "export", out / robot / "run.mcap", "--out", self.tmp / robot], check=True, capture_output=True)
            with open(self.tmp / robot / "cycles.csv", newline="") as table:
                cycles = [(int(row["at_ns"]), int(row["message_id"])) for row in csv.DictReader(table)]
            self.assertTrue(all(b[1] == a[1] + 1 for a, b in zip(cycles, cycles[1:])))
            begun.append(cycles[0])
        # One clock and one begin: the first cycles are of the same millisecond, whatever the host did.
        self.assertEqual(begun[0][1], begun[1][1])
        self.assertLess(abs(begun[0][0] - begun[1][0]), 1_000_000)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
