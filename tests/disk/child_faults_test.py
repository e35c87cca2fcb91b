#!/usr/bin/env python3
"""Programs that fail a run, and readers that read nothing: child_faults_test.py PROGRAM SOURCE_TREE [unittest options].

Other tests have: ffmpeg and gnuplot that hang until a signal, an ffmpeg that writes nothing (tests/cli/child_programs_test.py),
a run killed with its ffmpeg (tests/cli/killed_video_test.py), an ffmpeg without the encoder (tests/render/video_faults_test.cc),
a run without gnuplot (tests/cli/cli_test.py), unread output of serve and proxy with clients (tests/server/unread_output_test.py).
"""

import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from stand_ins import StandInsTest  # noqa: E402

PROGRAM, SOURCE = "", pathlib.Path()

KEPT = {"run.mcap", "scenario.yaml", "summary.json"}  # what no other program has a hand in
MISBEHAVIOUR = {
    "killed at once": "kill -KILL $$",
    "killed amid its input": "head -c 1000 > /dev/null; kill -KILL $$",
    "fails": "echo no memory >&2; exit 1",
    "ends well at once": "exit 0",
}


def full_pipe():
    """@returns (its end to read, its end to write): nothing more fits in."""
    reads, writes = os.pipe()
    os.set_blocking(writes, False)
    try:
        while True:
            os.write(writes, b"x" * 4096)
    except BlockingIOError:
        os.set_blocking(writes, True)
    return reads, writes


class ChildFaultsTest(StandInsTest):
    def arguments(self, *more, duration="0.3 s"):
        return [PROGRAM, "run", self.scenario(duration), "--out", self.out, "--data", SOURCE / "models", *more]

    def call(self, *arguments):
        return subprocess.run(arguments, env=self.environment, capture_output=True, text=True, timeout=120)

    def files(self):
        return {str(p.relative_to(self.out)) for p in self.out.rglob("*") if p.is_file()}

    def assert_told(self, done, program):
        self.assertEqual(done.returncode, 4, done.stderr)
        [error] = [line for line in done.stderr.splitlines() if "error:" in line]
        self.assertIn(program, error)

    def test_a_gnuplot_that_fails_costs_the_plots_alone(self):
        for name, does in MISBEHAVIOUR.items():
            with self.subTest(name):
                self.stand_in("gnuplot", does)
                self.assert_told(self.call(*self.arguments("--no-video")), "gnuplot")
                self.assertLessEqual(KEPT, self.files())
                self.assertEqual({f for f in self.files() if f.endswith((".partial", ".svg"))}, set())

    def test_an_ffmpeg_that_fails_costs_the_video_alone(self):
        for name, does in MISBEHAVIOUR.items():
            with self.subTest(name):
                self.stand_in("ffmpeg", does)
                self.assert_told(self.call(*self.arguments()), "ffmpeg")
                self.assertLessEqual(KEPT, self.files())
                self.assertNotIn("video.mp4", self.files())

    def test_without_ffmpeg_nothing_begins(self):
        self.stand_in("gnuplot", "exit 0")
        self.environment["PATH"] = str(self.programs)
        self.assert_told(self.call(*self.arguments()), "ffmpeg")
        self.assertEqual(self.files(), set())

    def test_plots_of_an_explanation(self):
        run = self.arguments("--no-video")
        with open(self.folder / "scenario.yaml", "a") as scenario:
            scenario.write("link: {command_loss: 100 %}\n")
        done = self.call(*run)
        self.assertEqual(done.returncode, 1, done.stderr)
        for name, does in MISBEHAVIOUR.items():
            with self.subTest(name):
                self.stand_in("gnuplot", does)
                self.assert_told(self.call(PROGRAM, "explain", self.out), "gnuplot")
                self.assertFalse((self.out / "explain.html").exists())

    def unread(self, *arguments, both=False):
        """Starts what finds its output full. @returns (process, the end to read)."""
        reads, writes = full_pipe()
        self.addCleanup(os.close, reads)
        process = subprocess.Popen(arguments, env=self.environment, stdout=writes, stderr=writes if both else subprocess.DEVNULL)
        os.close(writes)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process, reads

    def test_one_signal_ends_a_run_that_nobody_reads(self):
        for drive in ("lockstep", "realtime"):
            for how in (signal.SIGINT, signal.SIGTERM):
                for both in (False, True):
                    with self.subTest(drive=drive, signal=how.name, both=both):
                        process, _ = self.unread(*self.arguments("--no-video", "--drive", drive, duration="2 s"), both=both)
                        time.sleep(0.7)  # it waits for its reader by now
                        self.assertIsNone(process.poll())
                        process.send_signal(how)
                        self.assertEqual(process.wait(20), 130)

    def test_a_run_goes_on_when_it_is_read(self):
        process, reads = self.unread(*self.arguments("--no-video"))
        time.sleep(0.5)
        said = b""
        while block := os.read(reads, 65536):
            said += block
        self.assertEqual(process.wait(20), 0)
        self.assertIn("short: success", said.decode().lstrip("x"))
        self.assertLessEqual(KEPT, self.files())

    def test_a_server_that_nobody_reads_ends_in_time_and_on_a_signal(self):
        serve = [PROGRAM, "serve", "--data", SOURCE / "models", "--drive", "lockstep", "--port", "0", "--hand-port", "0"]
        process, _ = self.unread(*serve, "--for", "0.5")
        self.assertEqual(process.wait(20), 0)
        for both in (False, True):
            process, _ = self.unread(*serve, both=both)
            time.sleep(0.5)
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(20), 130)


if __name__ == "__main__":
    PROGRAM, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
