#!/usr/bin/env python3
"""What a run does when ffmpeg or gnuplot hang or do nothing: child_programs_test.py PROGRAM SOURCE_TREE [unittest options].

In their places stand scripts of a folder that PATH begins with.
"""

import pathlib
import signal
import subprocess
import sys
import time
import unittest

from stand_ins import StandInsTest

PROGRAM, SOURCE = "", pathlib.Path()

TAKES_ALL_AND_HANGS = "cat > /dev/null; sleep 1000"
TAKES_NOTHING = "sleep 1000"
WRITES_NOTHING = "cat > /dev/null"


def runs(process):
    """Whether a process is there and no zombie that nobody waits for."""
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class ChildProgramsTest(StandInsTest):
    def setUp(self):
        super().setUp()
        self.started = self.folder / "started"

    def start(self, program, does):
        """A run that finds a `program` that tells its process and `does`."""
        self.stand_in(program, f"echo $$ > {self.started}.new\nmv {self.started}.new {self.started}\n{does}")
        run = subprocess.Popen([PROGRAM, "run", self.scenario("0.5 s"), "--out", self.out, "--quiet", "--data",
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
