#!/usr/bin/env python3
"""Several robots in one scene: cells_test.py PROGRAM SOURCE_TREE [unittest options]."""

import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, SOURCE = "", pathlib.Path()

READY, ASIDE, UP = ("[0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]", "[0.4, -0.7854, 0, -2.2, 0.2, 1.5708, 0.7854]",
                    "[0, -0.9, 0, -2.3562, 0, 1.5708, 0.7854]")


def robot(name, y, goal=ASIDE, seconds=3, more=""):
    return f"""  {name}:
    robot: {{pose: {{position: [0 m, {y} m, 0 m]}}}}
    plant: {{noise: {{q: 0.001 deg}}}}
    link: {{command_loss: 1 %, command_delay: {{log_normal: {{median: 50 us, sigma: 0.5}}}}}}
    motion:
      trajectory:
        unit: rad
        duration: {seconds} s
        waypoints:
          - {{q: {READY}}}
          - {{q: {goal}}}
{more}"""


def cell(*robots, more=""):
    return "name: cell\n" + more + "robots:\n" + "".join(robots) + "render: {enabled: false}\n"


class CellsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_cells_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def call(self, *arguments):
        return subprocess.run([PROGRAM, *arguments, "--data", SOURCE / "models"], cwd=self.folder, capture_output=True, text=True,
                              timeout=300)

    def run_file(self, text, out, *flags, code=0):
        """text: of a scenario, or its path. Returns the summary."""
        path = text
        if isinstance(text, str):
            path = self.folder / f"{out}.yaml"
            path.write_text(text)
        done = self.call("run", path, "--out", self.folder / out, "--no-video", *flags)
        self.assertEqual(done.returncode, code, done.stderr)
        self.log = done.stdout + done.stderr
        return json.loads((self.folder / out / "summary.json").read_text())

    def log_of(self, *folder):
        return self.folder.joinpath(*folder, "run.mcap").read_bytes()

    def hash_of(self, *folder):
        return json.loads(self.folder.joinpath(*folder, "summary.json").read_text())["states_hash"]

    def test_each_arm_moves_as_alone_where_they_cannot_touch(self):
        summary = self.run_file(cell(robot("left", 1.5), robot("right", -1.5, UP, 2)), "both")
        self.assertEqual((summary["outcome"], list(summary["robots"])), ("success", ["left", "right"]))
        for name in ("left", "right"):
            self.assertEqual(summary["robots"][name]["shares_a_model"], name)
            self.run_file(self.folder / "both" / name / "scenario.yaml", name)
            self.assertEqual(self.hash_of(name), summary["robots"][name]["states_hash"])
            self.assertEqual(self.log_of(name), self.log_of("both", name))
            self.assertTrue((self.folder / "both" / name / "plots").is_dir())

    def test_the_order_in_the_file_does_not_count(self):
        for apart, gap in (("far", 1.5), ("near", 0.5)):
            one, other = robot("left", gap), robot("right", -gap, UP, 2)
            self.run_file(cell(one, other), apart)
            self.run_file(cell(other, one), apart + "_turned")
            for file in ("summary.json", "scenario.yaml", "left/run.mcap", "right/run.mcap"):
                self.assertEqual((self.folder / apart / file).read_bytes(), (self.folder / (apart + "_turned") / file).read_bytes(), file)

    def test_a_further_robot_out_of_reach_changes_nothing(self):
        two = self.run_file(cell(robot("left", 0.5), robot("right", -0.5, UP, 2)), "two")
        three = self.run_file(cell(robot("a", 5), robot("left", 0.5), robot("right", -0.5, UP, 2)), "three")
        self.assertEqual({name: three["robots"][name] for name in two["robots"]}, two["robots"])
        self.assertEqual(two["robots"]["left"]["shares_a_model"], "left, right")

    def test_arms_within_reach_move_on_while_one_rests(self):
        summary = self.run_file(cell(robot("left", 0.5, seconds=4), robot("right", -0.5, UP, 1)), "near")
        self.assertEqual(summary["outcome"], "success")
        self.assertGreater(summary["robots"]["left"]["simulated_s"], 4)
        self.assertLess(summary["robots"]["right"]["simulated_s"], 4)
        # The engine solves the contacts of a model together; without any, the arms differ from themselves alone by rounding at most.
        self.run_file(self.folder / "near" / "left" / "scenario.yaml", "left")
        alone = json.loads((self.folder / "left" / "summary.json").read_text())
        both = json.loads((self.folder / "near" / "left" / "summary.json").read_text())
        for a, b in zip(alone["q_final_rad"], both["q_final_rad"], strict=True):
            self.assertAlmostEqual(a, b, delta=1e-9)

    def test_a_collision_stops_both(self):
        summary = self.run_file(SOURCE / "models" / "cells" / "collision.yaml", "hit", code=1)
        self.assertEqual(summary["outcome"], "failed")
        for name, other in (("left", "right"), ("right", "left")):
            end = summary["robots"][name]
            self.assertEqual(end["outcome"], "aborted", end)
            self.assertRegex(end["failure"], "(cartesian|joint)_reflex")
            pairs = {(pair["a"].split("/")[0], pair["b"].split("/")[0]) for pair in end["contacts"]["pairs"]}
            self.assertIn((name, other), pairs)
            self.assertIn(f"{name}: ", self.log)
            subprocess.run([PROGRAM, "export", self.folder / "hit" / name / "run.mcap"], check=True, capture_output=True, timeout=60)
            events = (self.folder / "hit" / name / "csv" / "events.csv").read_text()
            force = re.search(rf"{name}/panda_\w+ and {other}/panda_\w+ at .* with up to (\d+) N", events)
            self.assertIsNotNone(force, events)
            self.assertGreater(int(force[1]), 5)

    def test_objects_belong_to_who_reaches_them(self):
        cubes = """objects:
  - {name: near_left, shape: box, size: [50 mm, 50 mm, 50 mm], mass: 0.1 kg, on: ground, position: [0.5 m, 2 m, 0 m]}
  - {name: near_right, shape: box, size: [50 mm, 50 mm, 50 mm], mass: 0.1 kg, on: ground, position: [0.5 m, -2 m, 0 m]}
  - {name: table, shape: box, size: [50 mm, 50 mm, 50 mm], on: ground, position: [0.5 m, 0 m, 0 m]}
"""
        summary = self.run_file(cell(robot("left", 2), robot("right", -2), more=cubes), "cubes")
        self.assertEqual(summary["robots"]["left"]["shares_a_model"], "left")
        text = (self.folder / "cubes" / "left" / "scenario.yaml").read_text()
        self.assertIn("near_left", text)
        self.assertIn("table", text)
        self.assertNotIn("near_right", text)
        between = cubes + "  - {name: bar, shape: box, size: [50 mm, 2 m, 50 mm], mass: 1 kg, on: ground, position: [0.6 m, 0 m, 0 m]}\n"
        summary = self.run_file(cell(robot("left", 2), robot("right", -2), more=between), "bar")
        self.assertEqual(summary["robots"]["left"]["shares_a_model"], "left, right")

    def test_the_seed_is_the_cells(self):
        text = cell(robot("left", 1.5), robot("right", -1.5))
        one, two = self.run_file(text, "one"), self.run_file(text, "two", "--seed", "2")
        for name in ("left", "right"):
            self.assertNotEqual(one["robots"][name]["states_hash"], two["robots"][name]["states_hash"])

    def test_validate(self):
        for path in sorted((SOURCE / "models" / "cells").glob("*.yaml")):
            done = self.call("validate", path)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, "left:\n  (motion|application)  ")
        self.assertIn("reach each other  left, right", self.call("validate", SOURCE / "models" / "cells" / "collision.yaml").stdout)

    def refuse(self, text, *flags, command="run"):
        path = self.folder / "bad.yaml"
        path.write_text(text)
        done = self.call(command, path, *flags)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (3, 1), done.stderr)
        self.assertFalse((self.folder / "out").exists())
        return done.stderr

    def test_bad_input(self):
        two = cell(robot("left", 0.6), robot("right", -0.6))
        self.assertIn("bad.yaml:14: robots.left: given twice; first in line 3", self.refuse(cell(robot("left", 0.6), robot("left", -0.6))))
        self.assertIn("bad.yaml:14: robots.right: its base stands 0.100 m from that of left",
                      self.refuse(cell(robot("left", 0.05), robot("right", -0.05))))
        self.assertIn("bad.yaml:2: robot: beside robots", self.refuse(two.replace("robots:", "robot: {}\nrobots:")))
        self.assertIn("bad.yaml:4: robots.left.robot: unknown key \"pos\"", self.refuse(two.replace("pose", "pos", 1)))
        # Close enough for the hands to overlap.
        facing = robot("left", 0.3) + robot("right", -0.3).replace("-0.3 m, 0 m]", "-0.3 m, 0 m], yaw: 180 deg")
        message = self.refuse(cell(facing.replace("[0 m, 0.3 m", "[0 m, 0 m").replace("[0 m, -0.3 m", "[0.7 m, 0 m")))
        self.assertRegex(message, r"bad.yaml:14: robots: where they start, left/panda_\w+ and right/panda_\w+ overlap by")
        inside = two.replace(READY, "[-0.593, -0.548, -0.380, -2.977, 0.060, 1.016, 1.251]", 1)
        self.assertRegex(self.refuse(inside), r"bad.yaml:3: robots: where they start, left/panda_\w+ and left/panda_link\d overlap by")
        self.assertIn("several robots", self.refuse(two, "--seeds", "2"))
        self.assertIn("--drive realtime", self.refuse(two, "--ext-cpu", "0"))
        self.assertIn("several robots", self.refuse(two, "--load", command="validate"))
        # What only a run can find, of one of the robots.
        self.assertIn("trajectory", self.refuse(cell(robot("left", 0.6), robot("right", -0.6, seconds=0.01))))

    def test_a_robot_that_cannot_begin_keeps_no_other_waiting(self):
        lost = """  right:
    robot: {pose: {position: [0 m, -0.4 m, 0 m]}, q_start: {unit: rad, values: %s}}
    motion: {plan: {goal: {pose: {position: [3 m, 0 m, 0.5 m], rpy: [180 deg, 0 deg, 0 deg]}}}}
""" % READY
        self.run_file(cell(robot("left", 0.4), robot("right", -0.4)), "out")
        for drive in ("lockstep", "realtime"):
            path = self.folder / "lost.yaml"
            path.write_text(cell(robot("left", 0.4), lost))
            done = self.call("run", path, "--out", self.folder / "out", "--no-video", "--drive", drive)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("lost.yaml:16: planning: the goal:", done.stderr)
            # Earlier results are as they were.
            self.assertEqual(json.loads((self.folder / "out/summary.json").read_text())["outcome"], "success")

    def test_what_was_recorded_until_an_interrupt_can_be_drawn(self):
        for drive in ("lockstep", "realtime"):
            path, out = self.folder / "long.yaml", self.folder / drive
            path.write_text(cell(robot("left", 0.4, seconds=1000), robot("right", -0.4, seconds=1000)))
            process = subprocess.Popen([PROGRAM, "run", path, "--out", out, "--no-video", "--drive", drive, "--data", SOURCE / "models"],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            self.addCleanup(process.kill)
            while process.poll() is None and not (out / "right/run.mcap.partial").exists():
                time.sleep(0.01)
            time.sleep(0.5)  # of the motion
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=100)
            self.assertEqual(process.returncode, 130, said)
            summary = json.loads((out / "summary.json").read_text())
            self.assertEqual([robot["outcome"] for robot in summary["robots"].values()], ["interrupted"] * 2)
            drawn = self.call("render", out, "--at", "0.3", "--out", self.folder / "a.png")
            self.assertEqual(drawn.returncode, 0, drawn.stderr)
            told = subprocess.run([PROGRAM, "explain", out], capture_output=True, text=True)
            self.assertEqual(told.returncode, 3)
            self.assertRegex(told.stderr, f"{out} holds no run.mcap, but its folders do; name one, such as {out}/(left|right)\n")

    def test_commands_of_one_robot_refuse_several(self):
        path = self.folder / "cell.yaml"
        path.write_text(cell(robot("left", 0.6), robot("right", -0.6)))
        done = self.call("move-to", "start-of", path)
        self.assertEqual(done.returncode, 3)
        self.assertIn("cell.yaml:2: robots: several robots", done.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    del sys.argv[1:3]
    unittest.main()
