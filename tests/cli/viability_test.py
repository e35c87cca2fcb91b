#!/usr/bin/env python3
"""Looks at what a run tells of its viability filter: viability_test.py PROGRAM SOURCE_TREE [unittest options]."""

import csv
import json
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True  # nothing beside the tests

import cli_test
from cli_test import SHORT, CliTest

# Joint 1 alone, at 0.4 of its acceleration limit: a raw stream that jumps by what 19 lost commands left asks for more jerk
# than there is.
LOST = SHORT.replace("[0.1, ", "[0.5, ").replace("duration: 1 s", "duration: 700 ms").replace(
    "command_loss: 0 %", "command_loss: {scripted: [{at: 300 ms, count: 19}]}")


class Viability(CliTest):
    def run_with(self, generator, viability):
        tick = f"generator: {generator}\n  viability: {viability}"
        done = self.run_scenario(LOST.replace("lambda: 0.001", tick))
        summary = json.loads((self.out / "summary.json").read_text())
        return done, summary["viability"]

    def ticks(self):
        done = self.call("export", self.out / "run.mcap", "--out", self.folder / "csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.folder / "csv" / "ticks.csv", newline="") as table:
            return list(csv.DictReader(table))

    def test_summary_log_and_plot_tell_what_was_kept_back(self):
        done, told = self.run_with("none", 19)
        self.assertGreater(told["kept_back"], 0)
        self.assertEqual(told["kept_back"], told["kept_back_of_joint"][0])
        self.assertEqual(told["kept_back_of_joint"][1:], [0] * 6)
        self.assertIn(f"{told['kept_back']} of {told['commands']} commands", done.stdout)
        self.assertIn("plots/viability.svg", self.files())
        ticks = self.ticks()
        self.assertEqual(sum(tick["kept_back"] == "1" for tick in ticks), told["kept_back"])
        self.assertEqual(min(float(tick["margin"]) for tick in ticks if tick["margin"]), told["least_margin"])

    def test_a_rejoining_generator_is_let_pass(self):
        done, told = self.run_with("rejoining", 19)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(told["kept_back"], 0)
        self.assertGreater(told["least_margin"], 0)

    def test_without_a_filter_there_is_nothing_to_tell(self):
        done, told = self.run_with("rejoining", "off")
        self.assertIsNone(told)
        self.assertNotIn("kept back", done.stdout)
        self.assertNotIn("plots/viability.svg", self.files())
        self.assertEqual({(tick["kept_back"], tick["margin"]) for tick in self.ticks()}, {("0", "")})


if __name__ == "__main__":
    cli_test.PROGRAM, cli_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
