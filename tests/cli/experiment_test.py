#!/usr/bin/env python3
"""Runs `panda-twin experiment` on good and bad input: experiment_test.py PROGRAM SOURCE_TREE [unittest options].

On calibrated loops with a motion of one second, and a seed each: what is looked at is the report, not its figures.
"""

import json
import os
import pathlib
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import witness  # noqa: E402: found by the path above

PROGRAM = ""
SOURCE = pathlib.Path()

MOTION = "../scenarios/trajectories/canonical.yaml"
SHORT_MOTION = ("{unit: rad, duration: 1 s, waypoints: [{q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}, "
                "{q: [0.05, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}]}")
LOOPS = ("bare", "synchronous", "asynchronous")
TIMEOUT = 100  # s, longer than any machine takes over what is waited for


def free_ports():
    """@returns the first of two neighbours that nobody listens at."""
    while True:
        with socket.create_server(("127.0.0.1", 0)) as arm, socket.socket() as hand:
            port = arm.getsockname()[1]
            try:
                hand.bind(("127.0.0.1", port + 1))
            except (OSError, OverflowError):
                continue
            return port


class ExperimentTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_experiment_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out = self.folder / "out"
        self.calibration = self.folder / "calibration"
        self.calibration.mkdir()
        for loop in LOOPS:
            text = (SOURCE / "models/experiments" / f"{loop}.yaml").read_text()
            self.assertIn(MOTION, text)
            (self.calibration / f"{loop}.yaml").write_text(text.replace(MOTION, SHORT_MOTION))

    def arguments(self, *more, out=None):
        seeds = [] if "--seeds" in more else ["--seeds", "1"]
        return [PROGRAM, "experiment", *map(str, more), *seeds, "--out", str(out or self.out), "--data",
                str(SOURCE / "models"), "--calibration", str(self.calibration)]

    def call(self, *more, out=None):
        return subprocess.run(self.arguments(*more, out=out), cwd=self.folder, capture_output=True,
                              text=True, timeout=TIMEOUT)

    def files(self, folder=None):
        folder = folder or self.out
        return {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}

    def interrupt(self, process):
        """Once it has begun. @returns what it said on stderr."""
        limit = time.monotonic() + TIMEOUT
        while not (self.out / "scratch.partial").exists():
            self.assertIsNone(process.poll(), "it ended by itself")
            self.assertLess(time.monotonic(), limit, "it does not begin")
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        return process.communicate(timeout=TIMEOUT)[1]

    def spoil(self, loop, old, new):
        path = self.calibration / f"{loop}.yaml"
        self.assertIn(old, path.read_text())
        path.write_text(path.read_text().replace(old, new, 1))

    def assert_refused(self, done, code, says):
        """One error line that says `says`, and nothing written at all."""
        lines = [line for line in done.stderr.splitlines() if "error:" in line]
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertIn(says, lines[0])
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertFalse(self.out.exists())


class Report(ExperimentTest):
    def test_has_a_page_and_the_points_of_every_curve(self):
        done = self.call("timings")
        self.assertEqual(self.files(), {"report.html", "findings.json", "csv/timings_d_ext.csv", "csv/timings_intervals.csv",
                                        "csv/timings_sensitivity.csv"})
        self.assertFalse((self.out / "scratch.partial").exists())
        self.assertIn("timings", done.stdout)
        self.assertIn("100 %", done.stdout)
        page = (self.out / "report.html").read_text()
        for name in self.files() - {"report.html", "findings.json"}:
            self.assertIn(f'href="{name}"', page)
        rows = (self.out / "csv/timings_d_ext.csv").read_text().splitlines()
        self.assertTrue(rows[0].startswith("d_EXT [us],"))
        self.assertEqual({row.count(",") for row in rows}, {6})

    def test_repeats_with_the_seed_and_shows_nothing_of_the_machine(self):
        for out in ("a", "b"):
            self.call("timings", "--seed", "7", out=self.folder / out)
        self.call("timings", "--seed", "8", out=self.folder / "c")
        pages = [(self.folder / out / "report.html").read_bytes() for out in "abc"]
        self.assertEqual(pages[0], pages[1])
        self.assertNotEqual(pages[0], pages[2])
        self.assertNotIn(os.uname().nodename.encode(), pages[0])
        self.assertNotIn(str(self.folder).encode(), pages[0])

    def test_takes_the_place_of_an_earlier_one_and_leaves_other_files_alone(self):
        (self.out / "csv").mkdir(parents=True)
        for name in ("csv/timings_of_mine.csv", "csv/mine.csv", "notes.txt"):
            (self.out / name).write_text("old")
        self.call("timings", "--quiet")
        self.assertLess({"csv/timings_of_mine.csv", "csv/mine.csv", "notes.txt", "report.html"}, self.files())

    def test_a_missed_demand_is_named_and_gives_exit_code_1(self):
        done = self.call("feed_forward", "--quiet")  # a second of motion is too little for its demands
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout, "")
        missed = done.stderr.splitlines()
        self.assertTrue(missed)
        for line in missed:
            self.assertTrue(line.startswith("panda-twin: feed_forward: "), line)
            self.assertIn("demanded: ", line)
        self.assertEqual((self.out / "report.html").read_text().count('<td class="missed">not reproduced</td>'), len(missed))

    def test_nothing_is_demanded_of_a_loop_of_ones_own(self):
        self.spoil("bare", "median: 12 us", "median: 120 us")
        done = self.call("timings", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("nothing is demanded", (self.out / "report.html").read_text())

    def test_a_loop_in_the_wrong_file_is_refused(self):
        self.spoil("bare", "loop: bare", "loop: asynchronous")
        self.assert_refused(self.call("timings"), 3, "its loop must be bare")

    def test_an_experiment_that_cannot_be_done_is_marked(self):
        self.spoil("synchronous", "controller:\n", "controller:\n  type: no_such_controller\n")
        done = self.call("timings", "--quiet")
        self.assertEqual(done.returncode, 1)
        self.assertIn("panda-twin: timings: failed: ", done.stderr)
        self.assertIn("no_such_controller", done.stderr)
        page = (self.out / "report.html").read_text()
        self.assertIn('<p class="failed">', page)
        self.assertIn('<td class="failed">failed</td>', page)

    def test_an_interrupt_leaves_no_report(self):
        process = subprocess.Popen(self.arguments("timings", "--seeds", "1000"), cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        stderr = self.interrupt(process)
        self.assertEqual(process.returncode, 130, stderr)
        self.assertEqual(self.files(), set())
        self.assertFalse((self.out / "scratch.partial").exists())


class BadInput(ExperimentTest):
    def test_unknown_experiment(self):
        self.assert_refused(self.call("timing"), 3, 'experiment "timing": there is none of that name; there are timings')

    def test_too_few_seeds(self):
        self.assert_refused(self.call("timings", "--seeds", "0"), 3, "--seeds 0: must be from 1 to 1000")

    def test_seed_that_is_no_number(self):
        self.assert_refused(self.call("timings", "--seed", "-1"), 2, "is not a whole number")

    def test_nothing_asked_for(self):
        self.assert_refused(self.call(), 2, "--list")

    def test_calibration_without_a_loop(self):
        (self.calibration / "bare.yaml").unlink()
        self.assert_refused(self.call("timings"), 3, "bare.yaml")

    def test_calibration_with_a_wrong_key(self):
        self.spoil("asynchronous", "wake_delay", "wake_delai")
        self.assert_refused(self.call("timings"), 3, 'unknown key "wake_delai"')

    def test_folder_that_cannot_be_made(self):
        (self.folder / "file").write_text("")
        done = self.call("timings", out=self.folder / "file" / "out")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("cannot be written", done.stderr)

    def test_missing_gnuplot(self):
        done = subprocess.run(self.arguments("timings"), cwd=self.folder, capture_output=True, text=True,
                              timeout=TIMEOUT, env=dict(os.environ, PATH="/nowhere"))
        self.assert_refused(done, 4, "gnuplot")


class EarlierReports(ExperimentTest):
    def test_what_others_wrote_stays(self):
        (self.out / "csv").mkdir(parents=True)
        (self.out / "csv/lambda_mine.csv").write_text("mine")
        done = self.call("lambda")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.out / "csv/lambda_mine.csv").read_text(), "mine")

    def test_a_page_of_others_is_not_overwritten(self):
        self.out.mkdir()
        (self.out / "report.html").write_text("<h1>mine</h1>")
        done = self.call("lambda")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("no report of panda-twin", done.stderr)
        self.assertEqual((self.out / "report.html").read_text(), "<h1>mine</h1>")

    def test_the_next_report_replaces_the_last_with_its_tables(self):
        self.assertEqual(self.call("lambda").returncode, 0)
        self.assertIn(self.call("feed_forward").returncode, (0, 1))  # a second of motion is little for it
        self.assertFalse([name for name in self.files() if "lambda" in name])

    def test_an_interrupted_one_leaves_the_last(self):
        self.assertEqual(self.call("lambda").returncode, 0)
        before = {name: (self.out / name).read_bytes() for name in self.files()}
        program = subprocess.Popen(self.arguments("timings", "--seeds", "1000"), cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(program.kill)
        stderr = self.interrupt(program)
        self.assertEqual(program.returncode, 130, stderr)
        self.assertEqual({name: (self.out / name).read_bytes() for name in self.files()}, before)


class OnTheWallClock(ExperimentTest):
    """What it measures is the machine's affair; that it measures is ours."""

    # Demands that a busy machine may miss; nothing else may fail.
    HANG_ON_THE_MACHINE = {"median d_EXT, RA to LF", "unserved cycles, RS to RA"}

    def test_timings_and_jitter(self):
        done = self.call("timings", "jitter", "--drive", "realtime")
        self.assertNotIn("failed", done.stdout + done.stderr)
        found = json.loads((self.out / "findings.json").read_text())
        rows = {row["quantity"]: row for one in found["experiments"] for row in one["comparisons"]}
        missed = {name for name, row in rows.items() if row["verdict"] == "not reproduced"}
        self.assertLessEqual(missed, self.HANG_ON_THE_MACHINE)
        self.assertEqual(done.returncode, 1 if missed else 0, done.stderr)
        for name in missed:
            self.assertIn(f"panda-twin: timings: {name}: ", done.stderr)
        latency, unserved = (rows[name] for name in sorted(self.HANG_ON_THE_MACHINE))
        self.assertEqual(latency["verdict"], "predicted" if latency["ours"] <= 1.2 else "not reproduced")
        if unserved["verdict"] != "reported":  # a machine that leaves the bare loop unserved says nothing of it
            self.assertEqual(unserved["verdict"], "predicted" if unserved["ours"] >= 5 else "not reproduced")
        self.assertEqual(rows["RS and RA, what their controllers keep the processor busy for"]["verdict"], "calibrated")
        page = (self.out / "report.html").read_text()
        for text in ("on the wall clock", "Left out: noise, feed_forward, lambda", "<td>machine</td>",
                     "median d_EXT, RA to LF", "unserved cycles, RS to RA", "raw stream: aborts in 1 runs"):
            self.assertIn(text, page)
        lines = (self.out / "csv/timings_d_ext.csv").read_text().splitlines()[1:]
        table = [[float(value) for value in line.split(",")] for line in lines]
        for column in (1, 3, 5):  # of each loop: the share in a bin of 1 us to 3 ms, the share above its lower edge
            in_bins = sum(row[column] for row in table)
            beyond = table[-1][column + 1]
            self.assertGreater(table[0][column + 1], 0.99)
            self.assertAlmostEqual(in_bins, 100 * (table[0][column + 1] - beyond), delta=0.01)

    def test_timings_of_a_client(self):
        """Our own program as though it were somebody's."""
        port = free_ports()
        run = [PROGRAM, "run", self.calibration / "asynchronous.yaml", "--backend", "fci", "--robot",
               f"127.0.0.1:{port}", "--out", self.folder / "run", "--no-video", "--quiet", "--data", SOURCE / "models"]
        command = shlex.join(map(str, run))

        def attempt():
            shutil.rmtree(self.folder / "run", ignore_errors=True)
            done = self.call("timings", "--client", command, "--port", port)
            summary = self.folder / "run" / "summary.json"
            self.assertEqual(done.returncode, 0, done.stderr + (summary.read_text() if summary.exists() else ""))
        # This machine may not be ready for a motion, which the program refuses then, or spoil it.
        witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt,
                            witness.ENDS_A_MOTION | witness.JUMPS | {"without a motion": witness.REFUSES["FAILED states"]})
        page = (self.out / "report.html").read_text()
        for text in ("Timings of a program of your own", "d_EXT, median, on the wire", "margin to the 20 that end a motion",
                     "motion 1, "):
            self.assertIn(text, page)
        losses = (self.out / "csv/client_losses.csv").read_text().splitlines()[1:]
        self.assertGreater(len(losses), 900)  # a second of motion

    def test_client_that_does_not_move(self):
        done = self.call("timings", "--client", "exit 3", "--port", free_ports())
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("ended with exit code 3 and without a motion", done.stderr)
        self.assertIn("failed: the client ended", (self.out / "report.html").read_text())

    def test_client_that_does_not_end_is_ended(self):
        """With all it has started, at --for and when the program itself is interrupted."""
        mark, port = self.folder / "mark", free_ports()
        command = f"sh -c 'echo $$ > {mark}; exec sleep 1000'; true"
        done = self.call("timings", "--client", command, "--port", port, "--for", 0.5)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("without a motion", done.stderr)
        self.assert_gone(int(mark.read_text()))
        mark.unlink()
        with subprocess.Popen(self.arguments("timings", "--client", command, "--port", port), cwd=self.folder,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as program:
            limit = time.monotonic() + TIMEOUT
            while not (mark.exists() and mark.read_text().strip()):
                self.assertLess(time.monotonic(), limit, "the client is not started")
                time.sleep(0.02)
            program.send_signal(signal.SIGINT)
            self.assertEqual(program.wait(timeout=TIMEOUT), 130)
        self.assert_gone(int(mark.read_text()))

    def assert_gone(self, process):
        limit = time.monotonic() + TIMEOUT
        while time.monotonic() < limit:
            if not pathlib.Path(f"/proc/{process}").exists():
                return
            time.sleep(0.02)
        self.fail(f"process {process} is still there")

    def test_client_beside_other_experiments_is_refused(self):
        self.assert_refused(self.call("timings", "jitter", "--client", "true"), 3, "with that alone")
        self.assert_refused(self.call("timings", "--client", ""), 3, "command line")

    def test_port_in_use(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            done = self.call("timings", "--client", "true", "--port", taken.getsockname()[1])
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("in use", done.stderr)

    def test_one_that_hangs_on_no_clock_is_refused(self):
        self.assert_refused(self.call("noise", "--drive", "realtime"), 3,
                            "run it without --drive realtime")

    def test_unknown_drive(self):
        self.assert_refused(self.call("timings", "--drive", "remote"), 3, "must be lockstep or realtime")


class List(ExperimentTest):
    def test_names_what_there_is(self):
        done = subprocess.run([PROGRAM, "experiment", "--list"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(done.stdout.startswith("timings"), done.stdout)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
