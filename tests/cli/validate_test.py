#!/usr/bin/env python3
"""What validate accepts and refuses: validate_test.py PROGRAM SOURCE_TREE [unittest options]."""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = "", pathlib.Path()

READY, ASIDE, BELOW_THE_FLOOR = ("[0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]", "[0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]",
                                 "[0, 1.4, 0, -1.0, 0, 1.5708, 0.7854]")


def motion_to(goal, more=""):
    return f"""name: there
motion:
  trajectory:
    unit: rad
    duration: 8 s
    waypoints:
      - {{q: {READY}}}
      - {{q: {goal}}}
{more}"""


class ValidateTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_validate_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def validate(self, scenario, *flags, folder=None):
        """scenario: a path, or a text."""
        if "\n" in str(scenario):
            path = self.folder / "scenario.yaml"
            path.write_text(scenario)
            scenario = path
        return subprocess.run([PROGRAM, "validate", scenario, "--data", SOURCE / "models", *flags], cwd=folder or self.folder,
                              capture_output=True, text=True, timeout=120)

    def accept(self, *arguments, **options):
        done = self.validate(*arguments, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def refuse(self, text):
        done = self.validate(text)
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (3, "", 1), done.stderr)
        return done.stderr

    def test_every_example(self):
        for path in sorted((SOURCE / "models" / "scenarios").glob("*.yaml")):
            if not path.name.endswith(".hash.yaml"):
                self.accept(path)

    def test_finds_what_run_finds(self):
        self.assertIn("trajectory: ", self.refuse(motion_to(ASIDE).replace("8 s", "10 ms")))

    def test_paths_do_not_depend_on_the_working_folder(self):
        self.accept("models/scenarios/canonical.yaml")
        (self.folder / "mine.xml").write_text(
            "<mujoco><worldbody><geom name='wall' type='box' size='1 1 1' pos='5 0 0'/></worldbody></mujoco>")
        for folder in (self.folder, "/"):
            self.accept(motion_to(ASIDE, "scene: mine.xml\n"), folder=folder)

    def test_refuses_a_motion_through_the_floor(self):
        self.assertRegex(self.refuse(motion_to(BELOW_THE_FLOOR)), r"motion: at \d\.\d+ s of 8\.000 s .*finger and floor overlap")
        said = self.accept(motion_to(BELOW_THE_FLOOR), "--no-collision-check", "to see the reflex")
        self.assertIn("not checked: to see the reflex", said)
        self.accept(motion_to(BELOW_THE_FLOOR, "  touches: to see the reflex\n"))


if __name__ == "__main__":
    PROGRAM, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
