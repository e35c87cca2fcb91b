#!/usr/bin/env python3
"""Runs every example scenario without video: examples_test.py PROGRAM SOURCE_TREE."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()


class ExamplesTest(unittest.TestCase):
    def test_every_example_reaches_its_goal(self):
        examples = [p for p in sorted((SOURCE / "models" / "scenarios").glob("*.yaml"))
                    if not p.name.endswith(".hash.yaml")]
        self.assertGreaterEqual(len(examples), 5)
        for path in examples:
            with self.subTest(example=path.name), tempfile.TemporaryDirectory() as out:
                done = subprocess.run([PROGRAM, "run", path, "--out", out, "--no-video", "--quiet",
                                       "--data", SOURCE / "models"], capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)
                summary = json.loads((pathlib.Path(out) / "summary.json").read_text())
                self.assertEqual(summary["outcome"], "success")
                self.assertLess(summary["final_error_rad"], 1e-3)

    def test_every_example_says_what_it_shows(self):
        for path in (SOURCE / "models" / "scenarios").glob("*.yaml"):
            self.assertTrue(path.read_text().startswith("# "), path.name)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
