#!/usr/bin/env python3
"""What a session leaves in the folder of `panda-twin serve --out`: serve_session_test.py PROGRAM SOURCE_TREE [unittest options]."""

import csv
import json
import pathlib
import re
import subprocess
import sys
import unittest

import fci_wire as fci
import serve_test

PLOTS = {"joints.svg", "tracking.svg", "velocities.svg", "jerk.svg", "served.svg"}
BODIES = serve_test.SCENARIO.replace("plant: {kind: ideal}\n", "")


class SessionTest(serve_test.ServeTest):
    def setUp(self):
        super().setUp()
        self.out = pathlib.Path(self.folder, "out")

    def motions(self):
        return json.loads((self.out / "summary.json").read_text())["motions"]

    def move(self, server, *steps):
        """One client; a motion for each largest step of a joint, rad per motion of 0.3 s."""
        arm = self.arm(server)
        arm.read()
        ends = [arm.run_motion(cycles=300, amplitude=step)[1] for step in steps]
        arm.close()
        return ends

    def program(self, *arguments):
        return subprocess.run([serve_test.PROGRAM, *arguments], check=True, capture_output=True, text=True).stdout

    def test_each_motion_leaves_what_a_run_leaves(self):
        server = self.serve("--out", self.out, scenario=BODIES)
        self.assertEqual(self.move(server, 0.01), [fci.SUCCESS])
        self.assertEqual(self.move(server, 0.02, 3.0), [fci.SUCCESS, fci.REFLEX_ABORTED])
        code, errors = server.end()
        self.assertEqual(code, 130, errors)
        motions = self.motions()
        self.assertEqual([(m["end"] == "finished", m["aborted"]) for m in motions], [(True, False), (True, False), (False, True)])
        self.assertNotEqual(motions[0]["client"], motions[1]["client"])
        self.assertEqual(motions[1]["client"], motions[2]["client"])
        self.assertIn("aborted by reflex: joint_motion_generator", motions[2]["end"])
        for motion in motions:
            self.assertEqual((motion["motion_generator"], motion["controller"]), ("joint_position", "joint_impedance"))
            self.assertEqual(motion["cycles_held"], 0, "lockstep loses nothing")
        for motion in motions[:2]:
            self.assertAlmostEqual(motion["end_s"] - motion["begin_s"], 0.3, delta=0.02)
            self.assertTrue(0 < motion["largest_tracking_error_rad"] < 0.01, motion)
        self.check_files(server)

    def check_files(self, server):
        for number in (1, 2, 3):
            folder = self.out / "motions" / str(number)
            self.assertEqual({plot.name for plot in (folder / "plots").iterdir()}, PLOTS)
            self.assertEqual((folder / "explain.html").exists(), number == 3)
            self.assertTrue((folder / "run.mcap").exists())
        self.assertEqual(list(self.out.rglob("*.partial")), [])
        for name in ("run.mcap", "scenario.yaml", "video.mp4", "contact_sheet.png"):
            self.assertGreater((self.out / name).stat().st_size, 0, name)
        page = (self.out / "report.html").read_text()
        for link in re.findall(r'(?:href|src)="([^"#]+)', page):
            self.assertTrue((self.out / link).exists(), link)
        self.assertEqual(len(set(re.findall(r'href="#(motion-\d)"', page))), 3)
        self.assertEqual(len(set(re.findall(r'id="(motion-\d)"', page))), 3)
        self.assertEqual(page.count("<h2>Client 127.0.0.1:"), 2)
        self.assertIn("in motion 3: joint_position", page)
        self.assertEqual(len(re.findall(r'href="video.mp4#t=[\d.]+"', page)), 3)
        # The commands of a run read a motion's folder as a run's.
        said = self.program("explain", self.out / "motions/3")
        self.assertIn("aborted at", said)
        self.assertIn("motion 3", said)
        self.program("export", self.out / "run.mcap", "--out", self.out / "csv")
        with open(self.out / "csv/events.csv") as file:
            kinds = [row["kind"] for row in csv.DictReader(file)]
        self.assertEqual((kinds.count("motion"), kinds.count("client")), (6, 4))

    def test_a_motion_whose_client_vanished_is_there_as_well(self):
        server = self.serve("--out", self.out, "--no-video")
        arm = self.arm(server)
        arm.start()
        arm.wave(cycles=300, until=100)
        arm.vanish()
        server.await_line("arm: motion stopped")
        server.end()
        self.assertEqual([m["end"] for m in self.motions()], ["stopped"])
        self.assertFalse((self.out / "video.mp4").exists())

    def test_a_client_in_motion_at_the_end_is_written(self):
        server = self.serve("--out", self.out, "--no-video")
        arm = self.arm(server)
        arm.start()
        arm.wave(cycles=300, until=100)
        code, errors = server.end()
        self.assertEqual(code, 130, errors)
        self.assertEqual(len(self.motions()), 1)
        self.assertIn("Motion 1", (self.out / "report.html").read_text())

    def test_a_second_interrupt_leaves_the_report_whole(self):
        server = self.serve("--out", self.out, scenario=BODIES)
        self.move(server, *[0.01] * 6)
        report = self.out / "report.html"
        server.process.terminate()
        while not report.exists():  # written first, then plots and film
            self.assertIsNone(server.process.poll())
        code, errors = server.end()
        self.assertEqual(code, 130, errors)
        self.assertEqual(len(self.motions()), 6)
        self.assertIn("Motion 6", report.read_text())
        self.assertTrue((self.out / "motions/6/run.mcap").exists())
        self.assertEqual(list(self.out.rglob("*.partial")), [])

    def test_a_second_interrupt_before_the_explanations_leaves_the_report(self):
        server = self.serve("--out", self.out, scenario=BODIES)
        self.move(server, 0.01, 3.0)
        server.process.terminate()
        while not (self.out / "summary.json").exists():  # written before the logs of the motions
            self.assertIsNone(server.process.poll())
        code, errors = server.end()
        self.assertEqual(code, 130, errors)
        self.assertIn("Motion 2", (self.out / "report.html").read_text())

    def test_a_session_replaces_the_one_before_and_leaves_other_files(self):
        server = self.serve("--out", self.out, "--no-video")
        self.move(server, 0.01, 0.01)
        server.end()
        mine = self.out / "motions/2/notes.txt"
        mine.write_text("mine")
        server = self.serve("--out", self.out, "--no-video")
        self.move(server, 0.01)
        server.end()
        self.assertEqual(len(self.motions()), 1)
        self.assertEqual([path.name for path in (self.out / "motions/2").iterdir()], ["notes.txt"])

    def test_without_a_motion_the_report_says_so(self):
        server = self.serve("--out", self.out)
        server.end()
        self.assertEqual(self.motions(), [])
        self.assertIn("Motions: 0;", (self.out / "report.html").read_text())

    def refused(self, code, *flags):
        file = pathlib.Path(self.folder, "s.yaml")
        file.write_text(serve_test.SCENARIO)
        done = subprocess.run([serve_test.PROGRAM, "serve", file, "--port", "0", "--hand-port", "0", "--drive", "lockstep", "--for",
                               "0.1", "--data", serve_test.SOURCE / "models", *flags], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_what_does_not_go_together_is_refused(self):
        self.assertIn("leave out --log", self.refused(3, "--out", self.out, "--log", "x.mcap"))
        self.assertIn("--no-video goes with --out", self.refused(3, "--no-video"))
        self.assertIn("own results", self.refused(3, "--out", self.out, "--capture", self.out / "run.mcap"))
        self.assertFalse(self.out.exists())
        file = pathlib.Path(self.folder, "s.yaml")
        self.assertIn(str(file), self.refused(4, "--out", file))
        self.serve("--out", self.out, "--no-video")
        self.assertIn("another run writes into", self.refused(4, "--out", self.out))


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
