#!/usr/bin/env python3
"""Runs applications by the command line: application_test.py PROGRAM SOURCE_TREE [unittest options]."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()


class ApplicationTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_application_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_with(self, file, *flags, out="out"):
        return subprocess.run([PROGRAM, "run", file, "--out", self.folder / out, "--data", SOURCE / "models", *flags],
                              capture_output=True, text=True, timeout=170)

    def changed(self, old, new):
        """The shipped file with one thing said otherwise."""
        text = (SOURCE / "models/applications/plan_and_execute.yaml").read_text()
        self.assertIn(old, text)
        path = self.folder / "task.yaml"
        path.write_text(text.replace(old, new))
        return path

    def test_one_command_leaves_report_pictures_video_plots_and_log(self):
        small = self.changed("render:", "render:\n  width: 160\n  height: 120\n  fps: 5 Hz")
        done = self.run_with(small)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("report.html", "run.mcap", "video.mp4", "contact_sheet.png", "summary.json", "timing.json",
                     "scenario.yaml", "plots/tracking.svg", "snapshots/1_goal_1_plan.png", "snapshots/1_goal_1.png"):
            self.assertGreater((self.folder / "out" / name).stat().st_size, 0, name)
        page = (self.folder / "out/report.html").read_text()
        self.assertIn("succeeded", page)
        self.assertEqual(page.count("data:image/png;base64,"), 2)
        self.assertIn("video.mp4", page)
        self.assertEqual(list((self.folder / "out").rglob("*.partial")), [])

    def test_the_same_seed_gives_the_same_bytes_another_one_another_goal(self):
        task = self.changed("seed: 1", "seed: 5")
        for out, flags in (("a", ()), ("b", ()), ("c", ("--seed", "6"))):
            done = self.run_with(task, "--no-video", *flags, out=out)
            self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("summary.json", "report.html", "run.mcap", "scenario.yaml"):
            self.assertEqual((self.folder / "a" / name).read_bytes(), (self.folder / "b" / name).read_bytes(), name)
        hashes = [json.loads((self.folder / run / "summary.json").read_text())["states_hash"] for run in "ac"]
        self.assertNotEqual(*hashes)

    def test_a_step_that_fails_is_named_and_the_exit_code_tells(self):
        done = self.run_with(self.changed("clearance: 15 mm", "clearance: 15 mm\n    budget: 3"), "--no-video")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("step plan failed", done.stderr)
        summary = json.loads((self.folder / "out/summary.json").read_text())
        self.assertEqual(summary["outcome"], "failed")
        self.assertEqual([step["succeeded"] for step in summary["steps"]], [False])
        self.assertIn("failed: step plan failed", (self.folder / "out/report.html").read_text())

    def test_what_is_wrong_in_the_file_is_refused_by_its_line(self):
        for old, new, says in (
                ("type: plan_and_execute", "type: juggle", "there are: "),
                ("clearance: 15 mm", "clearance: 15 s", "application.parameters.clearance"),
                ("\napplication:", "\nmotion: {plan: {goal: random}}\napplication:", "beside an application"),
        ):
            with self.subTest(new=new):
                done = self.run_with(self.changed(old, new))
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertIn(says, done.stderr)
                self.assertIn("task.yaml:", done.stderr)
                self.assertFalse((self.folder / "out").exists())

    def test_many_seeds_are_told_apart_and_repeat_whatever_the_threads(self):
        task = self.changed("seed: 1", "seed: 5")
        for out, threads in (("one", "1"), ("two", "2")):
            done = self.run_with(task, "--seeds", "3", "--threads", threads, out=out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("3 of 3 seeds succeeded", done.stdout)
        for name in ("seeds.csv", "summary.json", "report.html"):
            self.assertEqual((self.folder / "one" / name).read_bytes(), (self.folder / "two" / name).read_bytes(), name)
        rows = (self.folder / "one/seeds.csv").read_text().splitlines()
        self.assertEqual([row.split(",")[0] for row in rows], ["seed", "5", "6", "7"])
        self.assertEqual(len({row.split(",")[6] for row in rows[1:]}), 3, "each seed has states of its own")
        self.assertFalse((self.folder / "one/run.mcap").exists())

    def test_fewer_than_the_wanted_share_is_a_failure(self):
        task = self.changed("clearance: 15 mm", "clearance: 15 mm\n    budget: 3")
        for share, code in (("100", 1), ("0", 0)):
            done = self.run_with(task, "--seeds", "2", "--least-share", share, out=share)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn("seed 1: step plan failed", done.stderr)
            self.assertEqual(json.loads((self.folder / share / "summary.json").read_text())["succeeded"], 0)

    def test_seeds_go_with_applications_in_lockstep(self):
        for file, flags, says in (("scenarios/smoke.yaml", (), "goes with an application"),
                                  ("applications/plan_and_execute.yaml", ("--drive", "realtime"), "with lockstep"),
                                  ("applications/plan_and_execute.yaml", ("--least-share", "101"), "[0, 100] %")):
            with self.subTest(says=says):
                done = self.run_with(SOURCE / "models" / file, "--seeds", "2", *flags)
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertIn(says, done.stderr)

    def test_validate_passes_what_run_does(self):
        done = subprocess.run([PROGRAM, "validate", SOURCE / "models/applications/plan_and_execute.yaml", "--data",
                               SOURCE / "models"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("application  plan_and_execute", done.stdout)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
