#!/usr/bin/env python3
"""The real program where its host, its input or its robot fail it: cli_faults_test.py PROGRAM SOURCE_TREE [unittest options]."""

import pathlib
import resource
import signal
import subprocess
import sys
import unittest

import cli_test
from cli_test import SHORT, CliTest

MUJOCO = SHORT.replace("kind: ideal", "kind: mujoco")


class BadEnvironment(CliTest):
    def test_a_file_that_may_not_grow_leaves_a_log_that_can_be_read(self):
        limit = 300_000  # less than the log of 20 s
        done = subprocess.run([cli_test.PROGRAM, *map(str, self.run_arguments(SHORT.replace("1 s", "20 s")))], cwd=self.folder,
                              env=self.environment, capture_output=True, text=True, timeout=120,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        self.assert_error(done, 4, "run.mcap.partial: File too large")
        self.assertEqual(self.files(), {"run.mcap.partial"})
        done = self.call("export", self.out / "run.mcap.partial")
        self.assertEqual(done.returncode, 0, done.stderr)
        cycles = (self.out / "csv" / "cycles.csv").read_text().count("\n")
        self.assertGreater(cycles, 100)

    def test_corrupt_cache(self):
        self.assertEqual(self.run_scenario(MUJOCO).returncode, 0)
        cached = [p for p in (self.folder / "cache").rglob("*") if p.is_file()]
        self.assertTrue(cached)
        for path in cached:
            content = bytearray(path.read_bytes())
            content[len(content) // 2] ^= 0xFF
            path.write_bytes(content)
        done = self.run_scenario(MUJOCO)
        self.assertEqual(done.returncode, 0, done.stderr)
        [note] = done.stderr.splitlines()
        self.assertIn(f"note: {cached[0]}: the compiled model that was kept is damaged", note)
        self.assertNotIn("--", note)
        done = self.run_scenario(MUJOCO)  # it is whole again
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_cache_that_cannot_be_written(self):
        self.environment["XDG_CACHE_HOME"] = str(self.scenario())  # a file
        for _ in range(2):
            done = self.run_scenario(MUJOCO)
            self.assertEqual(done.returncode, 0, done.stderr)
            [note] = done.stderr.splitlines()
            self.assertIn("note: ", note)
            self.assertIn("compiled models cannot be kept there", note)
            self.assertNotIn("--", note)


class EarlyEnd(CliTest):
    def test_under_nohup_a_terminal_may_be_closed(self):
        process = subprocess.Popen(["nohup", cli_test.PROGRAM, *map(str, self.run_arguments(SHORT.replace("1 s", "60 s")))],
                                   cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        process.stdout.readline()  # the first tenth is done
        process.send_signal(signal.SIGHUP)
        _, stderr = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, stderr)


if __name__ == "__main__":
    cli_test.PROGRAM, cli_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
