#!/usr/bin/env python3
"""Same seed, same bytes: determinism_test.py PROGRAM SOURCE_TREE [--approve].

Runs the canonical scenario twice and compares log, exported states, plots and summary byte by byte; another
seed must differ. Then compares the hash of all states with the expected one in
models/scenarios/canonical.hash.yaml, which has one entry per variant of the C library's mathematics and
none for a variant nobody has approved yet.

--approve prints the entries that can be computed on this machine instead of comparing them.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()
COMPARED = ["run.mcap", "scenario.yaml", "summary.json", "csv/cycles.csv", "csv/ticks.csv", "csv/events.csv",
            "csv/config.csv", "plots/joints.svg", "plots/tracking.svg", "plots/velocities.svg", "plots/jerk.svg", "plots/served.svg"]
# glibc without the code for fused multiply-add; where there is none anyway, this changes nothing.
WITHOUT_FMA = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4"}


def call(*arguments, environment=None):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          env={**os.environ, **(environment or {})})
    if done.returncode != 0:
        raise AssertionError(f"{arguments}: {done.stderr}")


def run(out, *flags, environment=None):
    call("run", SOURCE / "models" / "scenarios" / "canonical.yaml", "--out", out, "--data", SOURCE / "models",
         "--no-video", "--quiet", *flags, environment=environment)
    call("export", out / "run.mcap")
    return json.loads((out / "summary.json").read_text())


def expected_hashes():
    text = (SOURCE / "models" / "scenarios" / "canonical.hash.yaml").read_text()
    return dict(re.findall(r"^  ([0-9a-f]{16}): ([0-9a-f]{16})", text, re.MULTILINE))


class DeterminismTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="panda_twin_determinism_")
        root = pathlib.Path(cls.folder.name)
        cls.first, cls.second, cls.other = root / "first", root / "second", root / "other"
        cls.summary = run(cls.first)
        run(cls.second, "--rebuild-cache")
        cls.other_summary = run(cls.other, "--seed", "2")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_same_seed_gives_the_same_bytes(self):
        for name in COMPARED:
            with self.subTest(file=name):
                content = (self.first / name).read_bytes()
                self.assertTrue(content)
                self.assertTrue(content == (self.second / name).read_bytes(), f"{name} differs")

    def test_another_seed_differs(self):
        self.assertNotEqual(self.other_summary["states_hash"], self.summary["states_hash"])
        for name in ["run.mcap", "csv/cycles.csv", "plots/jerk.svg"]:
            self.assertTrue((self.first / name).read_bytes() != (self.other / name).read_bytes(), name)

    def test_final_position(self):
        self.assertEqual(self.summary["outcome"], "success")
        self.assertLess(self.summary["final_error_rad"], 1e-3)

    def assert_expected(self, summary):
        expected = expected_hashes()
        self.assertTrue(expected)
        libm = summary["libm"]
        if libm not in expected:
            self.skipTest(f"no hash is kept for the C library's mathematics of this machine ({libm})")
        self.assertEqual(summary["states_hash"], expected[libm],
                         "the physics changed; if that was wanted, see --approve")

    def test_expected_hash(self):
        self.assert_expected(self.summary)

    def test_expected_hash_without_fused_multiply_add(self):
        with tempfile.TemporaryDirectory() as out:
            self.assert_expected(run(pathlib.Path(out), environment=WITHOUT_FMA))


def approve():
    for environment in [None, WITHOUT_FMA]:
        with tempfile.TemporaryDirectory() as out:
            summary = run(pathlib.Path(out), environment=environment)
        print(f"  {summary['libm']}: {summary['states_hash']}")


if __name__ == "__main__":
    arguments = [a for a in sys.argv[1:] if a != "--approve"]
    PROGRAM, SOURCE = arguments[0], pathlib.Path(arguments[1])
    if "--approve" in sys.argv:
        approve()
    else:
        unittest.main(argv=[sys.argv[0], *arguments[2:]])
