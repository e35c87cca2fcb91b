"""A run that finds scripts in the places of ffmpeg and gnuplot."""

import os
import pathlib
import shutil
import tempfile
import unittest

SCENARIO = """name: short
motion:
  trajectory:
    unit: rad
    duration: %s
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.02, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
render: {width: 64, height: 48, fps: 25 Hz}
"""


class StandInsTest(unittest.TestCase):
    """Scripts go into `programs`, with which PATH begins; results go into `out`."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_children_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out, self.programs = self.folder / "out", self.folder / "programs"
        self.programs.mkdir()
        self.environment = dict(os.environ, PATH=f"{self.programs}:{os.environ['PATH']}",
                                XDG_CACHE_HOME=str(self.folder / "cache"))

    def stand_in(self, program, does):
        path = self.programs / program
        path.write_text(f"#!/bin/sh\n{does}\n")
        path.chmod(0o755)

    def scenario(self, duration):
        """@returns the file of a run that takes so long."""
        file = self.folder / "scenario.yaml"
        file.write_text(SCENARIO % duration)
        return file
