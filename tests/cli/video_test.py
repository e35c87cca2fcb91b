#!/usr/bin/env python3
"""Compares and approves pictures by the command line: video_test.py PROGRAM SOURCE_TREE [unittest options]."""

import fcntl
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

PROGRAM = ""
SOURCE = pathlib.Path()
CASE = """scenario: scenarios/smoke.yaml
every: 5
key_frames: 2
views:
  overview: {width: 64, height: 48, camera: {azimuth: 142 deg}}
"""


class VideoTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_video_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.goldens = self.folder / "cases"
        self.goldens.mkdir()
        self.write(CASE)

    def write(self, text, case="small"):
        (self.goldens / f"{case}.yaml").write_text(text)

    def video(self, deed, *arguments, code=0, surroundings=None):
        done = subprocess.run([PROGRAM, "video", deed, *map(str, arguments), "--goldens", self.goldens, "--data",
                               SOURCE / "models", "--out", self.folder / "out"],
                              capture_output=True, text=True, timeout=100, env={**os.environ, **(surroundings or {})})
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout if code == 0 else done.stderr

    def approve(self, *arguments):
        return self.video("approve", "small", "--reason", "It is right.", *arguments)

    def approve_under(self, surroundings):
        return self.video("approve", "small", "--reason", "Another rasteriser.", surroundings=surroundings)

    def approved(self):
        return {path.name: path.read_bytes() for path in (self.goldens / "small").iterdir()}

    def test_what_was_approved_is_the_same_again(self):
        self.assertIn("approved: all", self.approve())
        text = self.approved()["golden.yaml"].decode()
        self.assertIn("It is right.", text)
        summary = json.loads((self.folder / "out/small/summary.json").read_text())
        self.assertIn(f'states: "{summary["states_hash"]}"', text)
        self.assertIn("the same, bit by bit", self.video("check"))
        self.assertFalse((self.folder / "out/report.html").exists())

    def test_approving_it_again_writes_nothing(self):
        self.approve()
        before = self.approved()
        self.assertIn("nothing was written", self.approve())
        self.assertEqual(self.approved(), before)

    def test_what_looks_different_fails_with_page_and_xml_until_it_is_approved(self):
        self.approve()
        self.write(CASE.replace("142", "150"))
        error = self.video("check", "--junit", self.folder / "junit.xml", code=1)
        self.assertIn("1 of 1 cases look different", error)
        page = (self.folder / "out/report.html").read_text()
        self.assertIn("the rendering changed", page)
        self.assertIn(f"panda-twin video approve small --goldens {self.goldens}", page)
        suite = xml.etree.ElementTree.parse(self.folder / "junit.xml").getroot().find("testsuite")
        self.assertEqual((suite.get("tests"), suite.get("failures")), ("1", "1"))
        self.assertIn("view overview", suite.find("testcase/failure").get("message"))
        self.assertIn("approved: pictures; the rendering changed", self.approve())
        self.assertIn("the same", self.video("check"))

    def test_a_passing_check_takes_an_earlier_ones_page_away(self):
        self.approve()
        self.video("report")
        self.video("check")
        self.assertFalse((self.folder / "out/report.html").exists())

    def test_a_passing_check_leaves_a_page_that_is_not_its_own(self):
        self.approve()
        (self.folder / "out/report.html").write_text("<title>mine</title>")
        self.video("check")
        self.assertEqual((self.folder / "out/report.html").read_text(), "<title>mine</title>")

    def test_where_the_file_for_machines_cannot_be_is_said_before_the_run(self):
        self.approve()
        shutil.rmtree(self.folder / "out")
        for file, why in ((self.folder / "no/such.xml", "No such file or directory"), (self.goldens, "Is a directory")):
            self.assertIn(f"--junit: {file}: cannot be written ({why})", self.video("check", "--junit", file, code=4))
        self.assertFalse((self.folder / "out").exists())
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["cases"])

    def test_a_run_that_differs_too_little_to_be_seen_is_told_and_passes(self):
        text = (SOURCE / "models/scenarios/smoke.yaml").read_text()
        smoke = self.folder / "smoke.yaml"
        smoke.write_text(text)
        self.write(CASE.replace("scenarios/smoke.yaml", str(smoke)))
        self.approve()
        smoke.write_text(text.replace("scale: 0.2", "scale: 0.2000001"))
        self.assertIn("the states differ from those approved, and the pictures look the same", self.video("check"))
        self.assertIn("approved: a hash of the states", self.approve())
        self.assertIn("the same, bit by bit", self.video("check"))

    def test_other_rasterisers_have_other_bits_and_raise_no_alarm(self):
        self.write("""scenario: applications/plan_and_execute.yaml
every: 26
key_frames: 3
views:
  overview: {camera: {distance: 2.9 m}, overlays: [text, goal]}
  hand: {camera: {track: panda_hand, distance: 0.5 m}, overlays: []}
""")
        self.approve()
        for other in ({"GALLIUM_OVERRIDE_CPU_CAPS": "sse2"}, {"GALLIUM_DRIVER": "softpipe"}):
            with self.subTest(surroundings=other):
                self.assertIn("rendering only", self.video("check", surroundings=other))
        self.assertIn("bit by bit", self.video("check", surroundings={"LP_NUM_THREADS": "1"}))
        self.assertIn("approved: hashes of the frames", self.approve_under({"GALLIUM_DRIVER": "softpipe"}))
        self.assertIn("bit by bit", self.video("check", surroundings={"GALLIUM_DRIVER": "softpipe"}))
        self.assertIn("bit by bit", self.video("check"))

    def test_a_report_is_written_whatever_comes_of_it(self):
        self.approve()
        self.assertIn("report.html", self.video("report", "small"))
        self.assertIn("the same, bit by bit", (self.folder / "out/report.html").read_text())

    def test_a_recorded_run_will_do(self):
        self.approve()
        for log in ("out/small", "out/small/run.mcap"):
            self.assertIn("the same", self.video("check", "small", "--log", self.folder / log))
        self.write(CASE, "other")
        self.assertIn("--log goes with one case", self.video("check", "--log", self.folder, code=3))

    def test_a_recorded_run_of_another_case_is_refused_by_what_differs(self):
        self.approve()
        before = self.approved()
        text = (SOURCE / "models/scenarios/smoke.yaml").read_text()
        other = self.folder / "other.yaml"
        for old, new, case, says in (
                ("name: smoke", "name: other", "", "its scenario is smoke, the case's other"),
                ("", "", "seed: 5\n", "its seed is 1, the case's 5"),
                ("scale: 0.2", "scale: 0.25", "", "its scenario's text (or lab) is another: \""),
        ):
            with self.subTest(says=says):
                other.write_text(text.replace(old, new))
                self.write(CASE.replace("scenarios/smoke.yaml", str(other)) + case)
                for deed in (("check",), ("approve", "--reason", "x")):
                    error = self.video(deed[0], "small", *deed[1:], "--log", self.folder / "out/small", code=3)
                    self.assertIn("run.mcap: not a run of the case small: " + says, error)
                    self.assertEqual(len(error.splitlines()), 1)
        self.assertEqual(self.approved(), before)

    def test_a_recorded_run_filmed_otherwise_is_a_run_of_the_case(self):
        self.approve()
        smoke = self.folder / "smoke.yaml"
        smoke.write_text((SOURCE / "models/scenarios/smoke.yaml").read_text() + "render: {width: 80}\n")
        self.write(CASE.replace("scenarios/smoke.yaml", str(smoke)))
        self.assertIn("the same", self.video("check", "small", "--log", self.folder / "out/small"))

    def test_a_killed_run_is_not_approved_and_noted_by_a_check(self):
        self.approve()
        whole = (self.folder / "out/small/run.mcap").read_bytes()
        cut = self.folder / "cut.mcap"
        cut.write_bytes(whole[:len(whole) * 3 // 4])
        error = self.video("approve", "small", "--reason", "x", "--log", cut, code=3)
        self.assertIn("cut.mcap: the run was killed", error)
        self.assertIn("note: " + str(cut), self.video("check", "small", "--log", cut, code=1))

    def test_a_second_approval_at_the_same_time_is_refused(self):
        self.approve()
        before = self.approved()
        folder = os.open(self.goldens, os.O_RDONLY)
        self.addCleanup(os.close, folder)
        fcntl.flock(folder, fcntl.LOCK_EX)
        self.assertIn("another approval writes into", self.video("approve", "small", "--reason", "x", code=4))
        self.assertEqual(self.approved(), before)

    def test_a_file_beside_the_pictures_is_refused_before_the_run_and_kept(self):
        self.approve()
        (self.goldens / "small/notes.txt").write_text("mine")
        shutil.rmtree(self.folder / "out")
        self.assertIn("small/notes.txt: ", self.video("approve", "small", "--reason", "x", code=3))
        self.assertFalse((self.folder / "out").exists())
        self.assertEqual((self.goldens / "small/notes.txt").read_text(), "mine")

    def test_without_a_reason_nothing_is_approved(self):
        self.video("approve", "small", code=2)
        self.assertIn("needs a reason", self.video("approve", "small", "--reason", " ", code=3))
        self.video("approve", "--reason", "none named", code=2)
        self.assertFalse((self.goldens / "small").exists())

    def test_what_cannot_be_compared_is_refused_and_left_as_it_is(self):
        self.approve()
        self.write(CASE.replace("64", "80"))
        before = self.approved()
        self.assertIn("overview (64 x 48), the case overview (80 x 48)", self.video("check", code=3))
        self.assertEqual(self.approved(), before)
        self.write(CASE)
        for name in ("overview_0000_depth.png", "overview.png", "golden.yaml"):
            whole = before[name]
            (self.goldens / "small" / name).write_bytes(whole[:len(whole) // 2])
            damaged = self.approved()
            for deed in (("check",), ("approve", "small", "--reason", "again")):
                error = self.video(*deed, code=3)
                self.assertIn(name, error)
                self.assertEqual(len(error.splitlines()), 1)
            self.assertEqual(self.approved(), damaged)
            (self.goldens / "small" / name).write_bytes(whole)

    def test_what_is_not_there_is_named(self):
        self.assertIn("nothing was approved of this case yet: panda-twin video approve small", self.video("check", code=3))
        self.write(CASE, "other")
        self.assertIn("there is no case tall in", error := self.video("check", "tall", code=3))
        self.assertIn("there are other, small", error)
        self.goldens = self.folder / "nowhere"
        self.assertIn("nowhere", self.video("check", code=3))

    def test_what_is_wrong_in_a_case_is_refused_by_its_line(self):
        for old, new, says in (
                ("every: 5", "every: 0", "small.yaml:2: every"),
                ("key_frames: 2", "keyframes: 2", "small.yaml:3"),
                ("overview:", "over view:", "a view's name has letters"),
                ("width: 64", "width: 63", "must be even"),
                ("width: 64", "width: 30", "goldens need at least 32 x 24"),
                ("{azimuth: 142 deg}", "{track: no_body}", 'cases/small.yaml: render: the model has no body named "no_body"'),
                ("smoke.yaml", "none.yaml", "none.yaml"),
        ):
            with self.subTest(new=new):
                self.write(CASE.replace(old, new))
                self.assertIn(says, self.video("approve", "small", "--reason", "x", code=3))
                self.assertFalse((self.goldens / "small").exists())


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
