"""Each program of python/examples runs, and what it prints is right."""

import csv
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest

EXAMPLES = pathlib.Path(__file__).parents[2] / "python/examples"


class ExamplesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_example(self, name, *arguments):
        """What the example prints."""
        done = subprocess.run([sys.executable, EXAMPLES / f"{name}.py", *arguments], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_none_is_left_out(self):
        called = re.findall(r'run_example\("(\w+)"', pathlib.Path(__file__).read_text())
        self.assertEqual({path.stem for path in EXAMPLES.glob("*.py")}, set(called))

    def test_serve_panda_py(self):
        try:
            import panda_py  # noqa: F401
        except ImportError:
            self.skipTest("missing: panda-python (scripts/setup)")
        told = self.run_example("serve_panda_py", "--log", "served.mcap")
        self.assertEqual(told.count("motion   finished"), 3, told)
        self.assertRegex(told, r"joint positions, rad: .* 0\.9\d+\]")  # 45 and 10 degrees
        self.assertTrue((self.folder / "served.mcap").exists())

    def test_compare_chains(self):
        rows = [line.split() for line in self.run_example("compare_chains").splitlines()[1:]]
        self.assertEqual({row[0]: row[1] for row in rows}, {"none": "aborted", "joint": "aborted", "rejoining": "success"})

    def test_sweep_loss(self):
        several = self.run_example("sweep_loss", "--losses", "1", "60", "--seeds", "2", "--threads", "2")
        self.assertEqual([line.split()[1] for line in several.splitlines()[1:]], ["2/", "0/"])
        self.assertEqual(several, self.run_example("sweep_loss", "--losses", "1", "60", "--seeds", "2", "--threads", "1"))

    def test_joint_pd_and_plot_log(self):
        told = self.run_example("joint_pd", "--log", "pd.mcap")
        farthest, rest = ([float(value) for value in re.findall(r"[\d.]+", line)] for line in told.splitlines())
        self.assertGreater(max(farthest), 10)
        self.assertLess(max(rest), 1)
        softer = self.run_example("joint_pd", "--stiffness", "100")
        self.assertGreater(max(map(float, re.findall(r"[\d.]+", softer.splitlines()[0]))), 1.5 * max(farthest))

        self.run_example("plot_log", "pd.mcap", "--joint", "3", "--out", "plot")
        with open(self.folder / "plot/joint.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        off = max(abs(float(row["q"]) - float(row["q_d"])) for row in rows)
        self.assertAlmostEqual(1e3 * off, farthest[2], delta=0.1)
        picture = (self.folder / "plot/scene.png").read_bytes()
        self.assertEqual((picture[:8], struct.unpack(">II", picture[16:24])), (b"\x89PNG\r\n\x1a\n", (640, 480)))

    def test_reach_agents(self):
        told = self.run_example("reach_agents", "--episodes", "5")
        self.assertIn("random   reaches 0 %", told)
        self.assertIn("straight reaches 100 %", told)

    def test_own_environment(self):
        told = self.run_example("own_environment", "--episodes", "3")
        self.assertEqual(told.count("success"), 3, told)

    def test_train_reach(self):
        self.run_example("train_reach", "--iterations", "2", "--out", "learnt")
        self.assertEqual(len((self.folder / "learnt/curve.csv").read_text().splitlines()), 3)


if __name__ == "__main__":
    unittest.main()
