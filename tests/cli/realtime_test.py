#!/usr/bin/env python3
"""Runs in real time from outside: realtime_test.py PROGRAM SOURCE_TREE [unittest options].

The machine's own lapses decide nothing: a run in which it lost time is run again.
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

PROGRAM = ""
SOURCE = pathlib.Path()

MOTION = """\
name: gentle
plant: {kind: ideal}
link: {state_delay: 80 us, command_delay: 80 us}
int: {abort_after_lost: 1000}
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
PATIENCE = 120


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
        limit = time.monotonic() + PATIENCE
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

    def undisturbed(self, out, holds=lambda done, summary: False):
        """A whole run in real time and its summary: one for which the claim holds, or else one in which this machine lost no
        time. The test is skipped where it did in each of five."""
        for _ in range(5):
            done = subprocess.run(self.command(out, "realtime"), capture_output=True, text=True)
            if not (out / "timing.json").exists():
                self.assertIn("this machine gives it no time", done.stderr)
                continue
            lost_time = json.loads((out / "timing.json").read_text())["robot_overruns"]
            summary = json.loads((out / "summary.json").read_text())
            quiet = lost_time == 0 and summary["longest_loss_cycles"] <= 3 and summary["controller_overruns"] <= 3
            if quiet or holds(done, summary):
                return done, summary
        self.skipTest("this machine lost time in each of five runs")

    def assert_readable(self, log):
        done = subprocess.run([PROGRAM, "export", log, "--out", self.tmp / "exported"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(len((self.tmp / "exported" / "cycles.csv").read_text().splitlines()), 100)

    def test_moves_as_in_lockstep(self):
        runs = {}
        out = self.tmp / "lockstep"
        done = subprocess.run(self.command(out, "lockstep"), capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        runs["lockstep"] = columns(out, "q_d")
        out = self.tmp / "realtime"
        done, _ = self.undisturbed(out)
        self.assertEqual(done.returncode, 0, done.stderr)
        runs["realtime"] = columns(out, "q_d")
        times, values = runs["lockstep"]
        shift = first_move(*runs["realtime"]) - first_move(times, values)
        worst = max(max(abs(a - b) for a, b in zip(v, at(*runs["realtime"], t + shift)))
                    for t, v in zip(times[::5], values[::5]))
        # An undisturbed run, see undisturbed(): three wake-ups behind and three commands; the shift is known to a cycle.
        way_of_a_cycle = max(max(abs(a - b) for a, b in zip(v, w)) for v, w in zip(values, values[1:]))
        self.assertLess(worst, 7 * way_of_a_cycle)

    def test_terminated_it_stops_the_arm_and_completes_the_log(self):
        process, out = self.start()
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 130, said)
        self.assert_readable(out / "run.mcap")

    def test_killed_it_leaves_a_log_that_can_be_read(self):
        process, out = self.start()
        process.kill()
        process.communicate(timeout=PATIENCE)
        self.assert_readable(out / "run.mcap.partial")

    def test_stopped_and_continued_it_ends_and_never_catches_up_in_a_burst(self):
        process, out = self.start()
        process.send_signal(signal.SIGSTOP)
        time.sleep(1)
        process.send_signal(signal.SIGCONT)
        self.await_log(out, 3)
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=PATIENCE)
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
        def results(summary):
            return [c["result"] for c in summary["hand"]["commands"]]
        wanted = ["success", "unsuccessful"]
        done, summary = self.undisturbed(self.tmp / "out", lambda d, s: d.returncode == 0 and results(s) == wanted)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(results(summary), wanted)
        for command, at in zip(summary["hand"]["commands"], (0, 0.5)):
            self.assertGreaterEqual(command["begun_s"], at)
        self.assertFalse(summary["hand"]["is_grasped"])


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
