#!/usr/bin/env python3
"""The bounds of a soak, of processes that leak: soak_figures_test.py [unittest options]."""

import contextlib
import io
import pathlib
import sys
import types
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "server"))

from soak_figures import Findings, Samples  # noqa: E402


class BoundsTest(unittest.TestCase):
    def verdict(self, memory_kb=lambda hours: 90_000, descriptors=lambda hours: 13, threads=lambda hours: 5):
        """Of ten hours of a process with that usage. @returns whether all bounds hold."""
        samples = Samples(None)
        samples.hours = [minute / 60 for minute in range(600)]
        samples.usages = [types.SimpleNamespace(memory_kb=memory_kb(h), descriptors=descriptors(h), threads=threads(h))
                          for h in samples.hours]
        findings = Findings()
        findings.usage(samples)
        with contextlib.redirect_stdout(io.StringIO()):
            return findings.show()

    def test_what_is_flat_holds(self):
        self.assertTrue(self.verdict())
        self.assertTrue(self.verdict(memory_kb=lambda h: 90_000 + 900 * h))

    def test_what_is_used_first_is_no_growth(self):
        self.assertTrue(self.verdict(memory_kb=lambda h: 90_000 if h > 0.01 else 50_000))

    def test_a_leak_is_found(self):
        self.assertFalse(self.verdict(memory_kb=lambda h: 90_000 + 1100 * h))
        self.assertFalse(self.verdict(descriptors=lambda h: 13 + h / 4))
        self.assertFalse(self.verdict(threads=lambda h: 5 + h / 4))


if __name__ == "__main__":
    unittest.main()
