#!/usr/bin/env python3
"""Runs `panda-twin experiment` on good and bad input: experiment_test.py PROGRAM SOURCE_TREE [unittest options].

On calibrated loops with a motion of one second, and a seed each: what is looked at is the report, not its figures.
"""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()

MOTION = "../scenarios/trajectories/canonical.yaml"
SHORT_MOTION = ("{unit: rad, duration: 1 s, waypoints: [{q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}, "
                "{q: [0.05, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}]}")
LOOPS = ("bare", "synchronous", "asynchronous")


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
                              text=True, timeout=100)

    def files(self, folder=None):
        folder = folder or self.out
        return {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}

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
        self.assertEqual(self.files(), {"report.html", "csv/timings_d_ext.csv", "csv/timings_intervals.csv",
                                        "csv/timings_sensitivity.csv"})
        self.assertFalse((self.out / "scratch.partial").exists())
        self.assertIn("timings", done.stdout)
        self.assertIn("100 %", done.stdout)
        page = (self.out / "report.html").read_text()
        for name in self.files() - {"report.html"}:
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
        for name in ("csv/timings_of_old.csv", "csv/mine.csv", "notes.txt"):
            (self.out / name).write_text("old")
        self.call("timings", "--quiet")
        self.assertNotIn("csv/timings_of_old.csv", self.files())
        self.assertLess({"csv/mine.csv", "notes.txt", "report.html"}, self.files())

    def test_a_missed_demand_is_named_and_gives_exit_code_1(self):
        self.spoil("bare", "median: 8.3 us", "median: 83 us")
        done = self.call("timings", "--quiet")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout, "")
        missed = [line for line in done.stderr.splitlines() if "LF, d_EXT, median" in line]
        self.assertEqual(len(missed), 1, done.stderr)
        self.assertTrue(missed[0].startswith("panda-twin: timings: "), missed)
        self.assertIn("within 20 %", missed[0])
        self.assertIn('<td class="missed">missed</td>', (self.out / "report.html").read_text())

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
        deadline = time.monotonic() + 60
        while not (self.out / "scratch.partial").exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        stderr = process.communicate(timeout=60)[1]
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
                              timeout=100, env=dict(os.environ, PATH="/nowhere"))
        self.assert_refused(done, 4, "gnuplot")


class List(ExperimentTest):
    def test_names_what_there_is(self):
        done = subprocess.run([PROGRAM, "experiment", "--list"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(done.stdout.startswith("timings"), done.stdout)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
