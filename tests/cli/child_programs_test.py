#!/usr/bin/env python3
"""What a run does when ffmpeg or gnuplot hang or do nothing: child_programs_test.py PROGRAM SOURCE_TREE [unittest options].

In their places stand scripts of a folder that PATH begins with.
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

PROGRAM, SOURCE = "", pathlib.Path()

SCENARIO = """name: short
motion:
  trajectory:
    unit: rad
    duration: 0.5 s
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.02, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
render: {width: 64, height: 48, fps: 25 Hz}
"""
TAKES_ALL_AND_HANGS = "cat > /dev/null; sleep 1000"
TAKES_NOTHING = "sleep 1000"
WRITES_NOTHING = "cat > /dev/null"


def runs(process):
    """Whether a process is there and no zombie that nobody waits for."""
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class ChildProgramsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_children_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out, self.started = self.folder / "out", self.folder / "started"
        self.environment = dict(os.environ, PATH=f"{self.folder}:{os.environ['PATH']}",
                                XDG_CACHE_HOME=str(self.folder / "cache"))

    def start(self, program, does):
        """A run that finds a `program` that tells its process and `does`."""
        stand_in = self.folder / program
        stand_in.write_text(f"#!/bin/sh\necho $$ > {self.started}.new\nmv {self.started}.new {self.started}\n{does}\n")
        stand_in.chmod(0o755)
        (self.folder / "scenario.yaml").write_text(SCENARIO)
        run = subprocess.Popen([PROGRAM, "run", self.folder / "scenario.yaml", "--out", self.out, "--quiet", "--data",
                                SOURCE / "models"], env=self.environment, stderr=subprocess.PIPE, text=True)
        self.addCleanup(run.stderr.close)
        self.addCleanup(run.wait)
        self.addCleanup(run.kill)
        return run

    def assert_ends(self, program, does, with_signal):
        run = self.start(program, does)
        while not self.started.exists():
            self.assertIsNone(run.poll(), "the run ended early")
            time.sleep(0.01)
        child = int(self.started.read_text())
        self.addCleanup(subprocess.run, ["kill", "-KILL", "--", f"-{child}"], stderr=subprocess.DEVNULL)
        run.send_signal(with_signal)
        begun = time.monotonic()
        self.assertEqual(run.wait(timeout=60), 130)
        self.assertLess(time.monotonic() - begun, 5)
        self.assertIn("interrupted", run.stderr.read())
        self.assertFalse(runs(child), f"{program} is an orphan")
        self.assertEqual(list(self.out.rglob("*.partial")), [])

    def test_a_signal_ends_a_run_whose_ffmpeg_hangs(self):
        for does in (TAKES_ALL_AND_HANGS, TAKES_NOTHING):
            for with_signal in (signal.SIGTERM, signal.SIGINT):
                with self.subTest(does=does, signal=with_signal):
                    self.started.unlink(missing_ok=True)
                    self.assert_ends("ffmpeg", does, with_signal)

    def test_a_signal_ends_a_run_whose_gnuplot_hangs(self):
        self.assert_ends("gnuplot", TAKES_ALL_AND_HANGS, signal.SIGTERM)

    def test_an_ffmpeg_that_writes_nothing_made_no_video(self):
        run = self.start("ffmpeg", WRITES_NOTHING)
        self.assertEqual(run.wait(timeout=120), 4)
        self.assertIn("wrote nothing", run.stderr.read())
        self.assertFalse((self.out / "video.mp4").exists())
        self.assertTrue((self.out / "summary.json").exists())


if __name__ == "__main__":
    PROGRAM, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
