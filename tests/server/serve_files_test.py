#!/usr/bin/env python3
"""The files that `panda-twin serve` writes: serve_files_test.py PROGRAM SOURCE_TREE [unittest options]."""

import csv
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "clients"))
from twin_server import TwinServer  # noqa: E402

PROGRAM, SOURCE = "", pathlib.Path()

SCENARIO = """name: served
plant: {kind: ideal}
motion:
  trajectory:
    unit: rad
    duration: 1 s
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
"""


class ServeFilesTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_serve_files_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scenario = self.folder / "s.yaml"
        self.scenario.write_text(SCENARIO)

    def serve(self, *flags, seconds="0.3"):
        return subprocess.run([PROGRAM, "serve", self.scenario, "--port", "0", "--hand-port", "0", "--for", seconds, "--drive",
                               "lockstep", "--data", SOURCE / "models", *flags], capture_output=True, text=True, timeout=60)

    def names(self):
        return sorted(file.name for file in self.folder.glob("a_*"))

    def export(self, log):
        """@returns the message ids of a log's cycles."""
        done = subprocess.run([PROGRAM, "export", log, "--out", self.folder / "csv", "--columns", "message_id"], capture_output=True,
                              text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.folder / "csv/cycles.csv", newline="") as file:
            return [int(row["message_id"]) for row in csv.DictReader(file)]

    def assert_refused(self, code, says, *flags):
        done = self.serve(*flags)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(says, done.stderr)
        self.assertEqual(len([line for line in done.stderr.splitlines() if "error:" in line]), 1, done.stderr)

    def test_what_is_no_log_or_capture_is_not_overwritten(self):
        foreign = self.folder / "thesis.tex"
        foreign.write_text("\\begin{document}")
        for flag in ("--log", "--capture"):
            for file, text in ((self.scenario, SCENARIO), (foreign, "\\begin{document}")):
                with self.subTest(flag=flag, file=file.name):
                    self.assert_refused(3, f"{file}: ", flag, file)
                    self.assertEqual(file.read_text(), text)
                    self.assertFalse(pathlib.Path(f"{file}.partial").exists())
            with self.subTest(flag=flag, file="a partial one"):
                partial = self.folder / "mine.partial"
                partial.write_text("mine")
                self.assert_refused(3, f"{partial}: ", flag, self.folder / "mine")
                self.assertEqual(partial.read_text(), "mine")

    def test_a_log_is_no_capture(self):
        log, capture = self.folder / "a.mcap", self.folder / "a.pcapng"
        self.assertEqual(self.serve("--log", log, "--capture", capture).returncode, 0)
        kept = log.read_bytes(), capture.read_bytes()
        self.assert_refused(3, "a.mcap", "--capture", log)
        self.assert_refused(3, "a.pcapng", "--log", capture)
        self.assertEqual((log.read_bytes(), capture.read_bytes()), kept)
        done = self.serve("--log", log, "--capture", capture)  # those of an earlier session are replaced
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_what_is_no_file_is_not_replaced(self):
        for flag in ("--log", "--capture"):
            fifo = self.folder / f"fifo{flag}"
            subprocess.run(["mkfifo", fifo], check=True)
            self.assert_refused(4, str(fifo), flag, fifo)
            self.assertTrue(fifo.is_fifo())

    def test_two_do_not_write_one_file(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep", "--log", str(self.folder / "a.mcap"), "--capture",
                        str(self.folder / "a.pcapng")):
            self.assert_refused(4, "another", "--log", self.folder / "a.mcap")
            self.assert_refused(4, "another", "--capture", self.folder / "a.pcapng")
        with TwinServer(PROGRAM, SOURCE, "lockstep", "--log", str(self.folder / "b.mcap"), "--log-split", "1h"):
            self.assert_refused(4, "another", "--log", self.folder / "b.mcap", "--log-split", "1h")
        self.assertTrue((self.folder / "a.mcap").exists() and (self.folder / "a.pcapng").exists())

    def test_log_and_capture_are_two_files(self):
        for other in ("x", "./x"):
            self.assert_refused(3, "--capture", "--log", self.folder / "x", "--capture", f"{self.folder}/{other}")
        self.assertFalse((self.folder / "x").exists())

    def test_a_split_log_has_each_cycle_in_one_file(self):
        split = ("--log", self.folder / "a.mcap", "--log-split", "0.2 s")
        done = self.serve(*split, seconds="2")
        self.assertEqual(done.returncode, 0, done.stderr)
        names = self.names()
        self.assertGreaterEqual(len(names), 3)
        self.assertEqual(names, [f"a_{number + 1:04}.mcap" for number in range(len(names))])
        cycles = [self.export(self.folder / name) for name in names]
        self.assertEqual({len(ids) for ids in cycles[:-1]}, {200})
        ids = sum(cycles, [])
        self.assertEqual(ids, list(range(ids[0], ids[0] + len(ids))))

        done = self.serve(*split, "--log-keep", "2")  # of both sessions
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(self.names()), 2)
        self.assertGreater(self.names()[-1], names[-1])

    def test_flags_of_a_split_log_that_do_not_go_together(self):
        log = ("--log", self.folder / "a.mcap")
        self.assert_refused(3, "--log-split goes with --log", "--log-split", "1h")
        self.assert_refused(3, "--log-keep goes with --log-split", *log, "--log-keep", "3")
        self.assert_refused(3, "--log-keep", *log, "--log-split", "1h", "--log-keep", "0")
        self.assert_refused(3, '--log-split: "1" is neither', *log, "--log-split", "1")
        self.assertEqual(self.names(), [])

    def test_a_disk_that_is_full_is_told_at_once(self):
        served = subprocess.Popen([PROGRAM, "serve", self.scenario, "--port", "0", "--hand-port", "0", "--drive", "lockstep", "--log",
                                   self.folder / "a.mcap", "--data", SOURCE / "models"], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, text=True,
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000)))
        self.addCleanup(served.stderr.close)
        self.addCleanup(served.wait)
        self.addCleanup(served.kill)
        said = served.stderr.readline()
        self.assertIn("File too large", said)
        self.assertIn("a.mcap.partial", said)
        self.assertIsNone(served.poll(), "it serves on")
        served.terminate()
        self.assertEqual(served.wait(timeout=20), 4)
        partial = self.folder / "a.mcap.partial"
        done = subprocess.run([PROGRAM, "export", partial], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
