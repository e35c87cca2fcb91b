#!/usr/bin/env python3
"""scripts/trace from outside: trace_test.py PROGRAM TRACE_POINTS_TEST SOURCE_TREE [unittest options].

Skipped where LTTng's tools are missing or its daemon cannot run.
"""

import json
import os
import pathlib
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
PROGRAM, POINTS, SOURCE = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
sys.path.insert(0, str(SOURCE / "scripts"))

sys.path.insert(0, str(SOURCE / "tests/support"))

import witness  # noqa: E402: found by the path above
from tracing import figures, session  # noqa: E402

TIMEOUT = 240  # seconds, longer than any machine takes over what is waited for
NOT_HERE = ("lttng-sessiond does not start", "this container permits none beside it", "LTTng keeps its buffers in",
            "KiB are needed for")

MOTION = """\
name: traced
plant: {kind: ideal}
link: {state_delay: 80 us, command_delay: 80 us}
onboard: {abort_after_lost: 1000000}
controller: {phase: 400 us}
motion:
  trajectory:
    unit: rad
    duration: DURATION
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.02, -0.7854, 0.01, -2.3562, 0, 1.5708, 0.8]}
render: {enabled: false}
"""

# A log that would say of each command that it was written 6 us later.
SHIFTED = """\
import csv, pathlib, subprocess, sys
program, out = sys.argv[1], pathlib.Path(sys.argv[2])
code = subprocess.run(sys.argv[3:]).returncode
subprocess.run([program, "export", out / "run.mcap"], check=True)
rows = list(csv.DictReader(open(out / "csv" / "ticks.csv")))
for row in rows:
    row["written_ns"] = int(row["written_ns"]) + 6000
with open(out / "shifted.csv", "w") as table:
    shifted = csv.DictWriter(table, rows[0].keys())
    shifted.writeheader()
    shifted.writerows(rows)
sys.exit(code)
"""


class TraceTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.tmp = pathlib.Path(self.folder.name)
        self.out = self.tmp / "out"
        self.temporary = self.tmp / "t"  # short: LTTng's sockets are below it
        self.temporary.mkdir()
        self.environment = {**os.environ, "TMPDIR": str(self.temporary)}

    def run_command(self, drive, duration="1 s"):
        scenario = self.tmp / "traced.yaml"
        scenario.write_text(MOTION.replace("DURATION", duration))
        return [PROGRAM, "run", str(scenario), "--drive", drive, "--out", str(self.out), "--data", str(SOURCE / "models"),
                "--no-video", "--quiet"]

    def arguments(self, options, command):
        build = pathlib.Path(PROGRAM).parent
        return [str(SOURCE / "scripts/trace"), "--build", str(build), *map(str, options), "--", *command]

    def trace(self, *options, command):
        try:
            session.require_tools()
        except session.TraceError as missing:
            self.skipTest(f"missing: {missing}")
        done = subprocess.run(self.arguments(options, command), capture_output=True, text=True, env=self.environment,
                              timeout=TIMEOUT)
        if done.returncode == 4 and any(reason in done.stderr for reason in NOT_HERE):
            self.skipTest(done.stderr)
        self.assertEqual(os.listdir(self.temporary), [], "the session leaves files behind")
        return done

    def traced_run(self, *options, command):
        def attempt():
            done = self.trace(*options, command=command)
            self.assertTrue((self.out / "run.mcap").exists(), done.stderr)
            return done
        return witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.GIVES_UP)

    def test_agrees_with_the_log_command_by_command(self):
        kept = self.tmp / "kept"
        done = self.traced_run("--out", kept, "--compare", self.out, command=self.run_command("realtime"))
        [motion] = figures.motions_of(figures.read_events(kept / "lttng"))
        compared = figures.compare(motion, figures.read_ticks(self.out, PROGRAM))
        self.assertGreater(len(compared.excess), 100)  # of a motion of 1 s: this machine decides how many cycles are served
        # The log's readings of the clock are outside the trace's, whatever interrupts the thread between them. That makes a few
        # differ, and the latest may be among those: as many more as reads and writes of the same trace were interrupted.
        self.assertGreaterEqual(min(compared.excess.values()), 0)
        interrupted = sum(took > statistics.median(takes) + figures.TOLERANCE_NS
                          for takes in ([c.read - c.look for c in motion.commands], [c.end - c.begin for c in motion.commands])
                          for took in takes)
        self.assertLess(len(compared.commands_apart()), 0.02 * len(compared.excess) + interrupted, done.stdout)
        self.assertNotIn("median", compared.apart(), done.stdout)
        self.assertEqual(done.returncode, 1 if compared.apart() else 0, done.stdout + done.stderr)
        self.assertIn("no event lost", done.stdout)

    def test_has_its_figures_in_a_report_of_loop_timings(self):
        calibration = self.tmp / "calibration"
        calibration.mkdir()
        for loop in ("bare", "synchronous", "asynchronous"):
            text = (SOURCE / "models/experiments" / f"{loop}.yaml").read_text()
            (calibration / f"{loop}.yaml").write_text(text.replace("../scenarios/trajectories/canonical.yaml",
                                                                   MOTION.split("trajectory:")[1].split("render")[0]
                                                                   .replace("DURATION", "1 s")))
        command = [PROGRAM, "experiment", "timings", "--drive", "realtime", "--seeds", "1", "--quiet", "--out", str(self.out),
                   "--data", str(SOURCE / "models"), "--calibration", str(calibration)]

        def attempt():
            done = self.trace("--report", self.out, command=command)
            self.assertIn("no event lost", done.stdout, done.stderr)
            return done
        done = witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.GIVES_UP)
        rows = json.loads((self.out / "findings.json").read_text())["experiments"][0]["comparisons"]
        traced = [row for row in rows if "lttng" in row]
        self.assertEqual(len(traced), 9)
        # As for logs: only what interrupts a thread between two readings of the clock is apart, and that is the largest.
        for row in traced:
            if row["quantity"].endswith("median"):
                self.assertAlmostEqual(row["ours"], row["lttng"], delta=0.005, msg=done.stdout)
        self.assertIn("by LTTng", (self.out / "report.html").read_text())

    def test_refuses_a_shifted_log(self):
        command = [sys.executable, "-c", SHIFTED, PROGRAM, str(self.out), *self.run_command("realtime")]
        done = self.traced_run("--compare", self.out / "shifted.csv", command=command)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, "median.*shifted.csv differ")

    def test_tells_of_each_motion_of_a_command(self):
        twice = ["sh", "-c", '"$@" && "$@"', "sh", *self.run_command("lockstep")]
        done = self.trace("--out", self.tmp / "kept", command=twice)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("trace: 2 motions, no event lost", done.stdout)
        self.assertTrue((self.tmp / "kept/figures.json").exists())
        counts = [line.split(",")[0] for line in (self.tmp / "kept/commands.csv").read_text().splitlines()[1:]]
        self.assertEqual(counts.count("1"), counts.count("2"))

    def test_says_when_events_were_lost(self):
        done = self.trace("--buffer", "16k", command=self.run_command("lockstep", "20 s"))
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertRegex(done.stderr, r"[1-9]\d* events were lost")

    def test_passes_on_output_and_exit_code(self):
        done = self.trace(command=[PROGRAM, "run", str(self.tmp / "missing.yaml")])
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("missing.yaml", done.stderr)
        self.assertIn("nothing was traced", done.stderr)

    def test_refuses_a_program_without_tracepoints(self):
        other = self.tmp / "panda-twin"
        shutil.copy(shutil.which("true"), other)
        done = self.trace(command=[str(other)])
        self.assertEqual(done.returncode, 4)
        self.assertIn("-DTWIN_LTTNG=ON", done.stderr)

    def test_points_neither_allocate_nor_lock_while_lttng_records_them(self):
        done = self.trace(command=[POINTS])
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("1000 commands", done.stdout)

    def test_terminated_it_ends_the_run_and_leaves_no_daemon(self):
        self.trace(command=[POINTS])  # skips the test where LTTng cannot run
        process = subprocess.Popen(self.arguments((), self.run_command("realtime", "60 s")), stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=self.environment)
        self.addCleanup(process.kill)
        limit = time.monotonic() + TIMEOUT
        while not ((log := self.out / "run.mcap.partial").exists() and log.stat().st_size > 512 * 1024):
            self.assertIsNone(process.poll(), "it ended by itself")
            self.assertLess(time.monotonic(), limit, "no cycles are recorded")
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        said, errors = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 130, errors)
        self.assertIn("trace: 1 motion", said, errors)
        self.assertEqual(os.listdir(self.temporary), [], "the session leaves files behind")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
