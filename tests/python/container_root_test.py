"""The root that scripts/container-root makes: an application with video, plots and report in it, and a motion in real time.

    container_root_test.py PROGRAM        as root; PROGRAM: of the build folder, whose witness watches the host
"""

import json
import pathlib
import shutil
import sys
import tempfile
import unittest

import other_root

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import witness  # noqa: E402

PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()


class ContainerRoot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        work = pathlib.Path(tempfile.mkdtemp(prefix="panda-twin-root-", dir=PROGRAM.parent))
        cls.addClassCleanup(shutil.rmtree, work, ignore_errors=True)
        wheel = other_root.make_wheels(work / "wheels", "--python", "/usr/bin/python3")["cp311-cp311"]
        cls.root = other_root.OtherRoot(work / "root", wheel)

    def test_picks_and_places_with_video_plots_and_report(self):
        self.root.run("panda-twin", "run", "applications/pick_and_place.yaml", "--out", "demo", "--quality", "draft")
        out = self.root.path("/srv/demo")
        self.assertEqual(json.loads((out / "summary.json").read_text())["outcome"], "success")
        for pattern in ("*.mp4", "*.html", "*.mcap"):
            self.assertTrue(list(out.glob(pattern)), pattern)

    def test_moves_in_real_time(self):
        def attempt():
            return self.root.run("panda-twin", "run", "scenarios/smoke.yaml", "--drive", "realtime", "--out", "realtime")

        witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.A_CLIENT)
        summary = json.loads(self.root.path("/srv/realtime/summary.json").read_text())
        self.assertEqual(summary["drive"], "realtime")


if __name__ == "__main__":
    unittest.main()
