#!/usr/bin/env python3
"""An object from one arm's hand to another's: hand_over_test.py PROGRAM SOURCE_TREE HandOverTest|SeedsTest [unittest options]."""

import concurrent.futures
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = "", pathlib.Path()


class Runs(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_hand_over_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.text = (SOURCE / "models" / "cells" / "hand_over.yaml").read_text()

    def call(self, *arguments):
        return subprocess.run([PROGRAM, *arguments, "--data", SOURCE / "models"], cwd=self.folder, capture_output=True, text=True,
                              timeout=300)

    def changed(self, *pairs):
        """The shipped scenario with other texts; each stands once in it, or the last one counts."""
        text = self.text
        for before, after in pairs:
            self.assertIn(before, text)
            head, _, tail = text.rpartition(before)
            text = head + after + tail
        path = self.folder / "changed.yaml"
        path.write_text(text)
        return path

    def run_cell(self, path, out="out", *flags):
        done = self.call("run", path, "--out", self.folder / out, "--no-video", *flags)
        self.log = done.stdout + done.stderr
        summary = json.loads((self.folder / out / "summary.json").read_text())
        self.assertEqual(done.returncode, 0 if summary["outcome"] == "success" else 1, self.log)
        return summary

    def findings(self, robot, out="out"):
        return json.loads((self.folder / out / robot / "summary.json").read_text())["findings"]


class HandOverTest(Runs):
    def test_a_beam_goes_from_hand_to_hand(self):
        summary = self.run_cell(SOURCE / "models" / "cells" / "hand_over.yaml")
        self.assertEqual(summary["outcome"], "success", self.log)
        self.assertEqual([robot["outcome"] for robot in summary["robots"].values()], ["success", "success"])
        for name in ("left", "right"):
            for finding in self.findings(name):
                self.assertIsNot(finding["met"], False, finding)
        judged = {finding["quantity"]: finding["value"] for name in ("left", "right") for finding in self.findings(name)}
        self.assertGreater(judged["time in both hands"], 300)
        self.assertLess(judged["position error of the object as it is held out"], 1)
        # Only the four fingers touch anything.
        pairs = {(pair["a"], pair["b"]) for robot in summary["robots"].values() for pair in robot["contacts"]["pairs"]}
        self.assertEqual(pairs, {(f"{name}/panda_{side}finger", "beam") for name in ("left", "right") for side in ("left", "right")})
        subprocess.run([PROGRAM, "export", self.folder / "out" / "left" / "run.mcap"], check=True, capture_output=True, timeout=60)
        events = (self.folder / "out" / "left" / "csv" / "events.csv").read_text()
        self.assertLess(events.index("left to right: beam offered"), events.index("left to right: beam clear"))

    def test_the_receiver_ends_when_the_giver_fails(self):
        summary = self.run_cell(self.changed(("0.64 m, 0 m, 0.5 m", "0.64 m, 0 m, 1.9 m")))
        self.assertIn("step plan failed", summary["robots"]["left"]["failure"])
        self.assertRegex(summary["robots"]["right"]["failure"], 'step await offer failed: left has ended without having said "offered": step plan')
        self.assertLess(summary["simulated_s"], 0.1)

    def test_the_giver_ends_when_the_receiver_fails(self):
        summary = self.run_cell(self.changed(("[0.86 m, 0.36 m, 0 m]", "[0.86 m, 1.36 m, 0 m]")))
        self.assertIn("step plan failed", summary["robots"]["right"]["failure"])
        self.assertRegex(summary["robots"]["left"]["failure"], 'step await taker failed: right has ended without having said "taken": step plan')
        self.assertEqual(summary["outcome"], "failed")

    def test_a_beam_that_is_torn_away_is_noticed(self):
        push = "perturbations: [{push: {body: beam, begin: 14 s, duration: 1 s, force: [0 N, 0 N, -150 N]}}]"
        summary = self.run_cell(self.changed(("    application:", f"    {push}\n    application:")))
        self.assertIn("step await taker failed: the hand lost the beam", summary["robots"]["left"]["failure"])
        self.assertEqual(summary["robots"]["right"]["outcome"], "failed")
        missed = {finding["quantity"] for finding in self.findings("left") if finding["met"] is False}
        self.assertIn("longest free fall of the object", missed)
        self.assertIn("unwanted contacts: beam and floor", missed)

    def test_a_timeout_ends_the_wait(self):
        summary = self.run_cell(self.changed(("partner: left", "partner: left\n        timeout: 1 s")))
        self.assertIn('left has not said "offered" within 1 s (timeout)', summary["robots"]["right"]["failure"])

    def refusal(self, *pairs):
        path = self.changed(*pairs)
        messages = []
        for command in (["validate", path], ["run", path, "--no-video"]):
            done = self.call(*command)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (3, 1), done.stderr)
            messages.append(done.stderr)
        self.assertEqual(*messages)
        self.assertFalse((self.folder / "out").exists())
        return messages[0]

    def test_refuses_partners_that_do_not_fit(self):
        self.assertRegex(self.refusal(("partner: right", "partner: middle")),
                         r'changed.yaml:\d+: application.parameters.partner: "middle" is no other robot .* there are: right')
        self.assertIn('"left" is no other robot', self.refusal(("partner: right", "partner: left")))
        self.assertIn('the partner of right is "middle", not left', self.refusal(("partner: left", "partner: middle")))
        giver = ("role: receiver", "role: giver\n        meet: {position: [0.6 m, 0 m, 0.5 m]}")
        receivers_own = self.text[self.text.rindex("        place:"):self.text.index("render:")]
        self.assertIn("left and right are both givers; say role: receiver for one of them", self.refusal(giver, (receivers_own, "\n")))
        self.assertIn('it has: here, there, beam', self.refusal(("object: beam", "object: bean"), ("object: beam", "object: bean")))
        self.assertIn('hands over "beam", and right "block"',
                      self.refusal(("object: beam", "object: block"),
                                   ("robots:", "  - {name: block, shape: box, size: [200 mm, 40 mm, 40 mm], mass: 0.1 kg, on: here,"
                                    " position: [0 m, 0.13 m, 0 m]}\n\nrobots:")))
        self.assertIn("far away", self.refusal(("[1.28 m, 0 m, 0 m]", "[9 m, 0 m, 0 m]")).replace("is no other robot of the cell that this one can reach",
                                                                                          "far away"))

    def test_refuses_a_partner_with_another_task(self):
        start, end = self.text.rindex("    application:"), self.text.index("render:")
        moves = ("    motion: {trajectory: {unit: rad, duration: 3 s, waypoints: [{q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]},"
                 " {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}]}}\n")
        self.assertIn("right has a motion; it must have the application hand_over, too", self.refusal((self.text[start:end], moves)))

    def test_refuses_a_robot_that_is_alone(self):
        head, robots = self.text.split("robots:\n  left:\n")
        left = "\n".join(line[4:] for line in robots.split("  right:\n")[0].splitlines())
        self.assertIn("the application hand_over takes two robots", self.refusal((self.text, head + left + "\n")))


class SeedsTest(Runs):
    def test_nearly_all_seeds_succeed(self):
        def run(seed):
            out = self.folder / f"seed{seed}"
            done = self.call("run", SOURCE / "models" / "cells" / "hand_over.yaml", "--seed", str(seed), "--out", out, "--no-video", "--quiet")
            shutil.rmtree(out)
            return done.returncode, f"seed {seed}: {done.stderr.strip()}"

        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            ends = list(pool.map(run, range(1, 101)))
        failures = [text for code, text in ends if code != 0]
        self.assertLessEqual(len(failures), 2, "\n".join(failures))


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    del sys.argv[1:3]
    unittest.main()
