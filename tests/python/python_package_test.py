"""The package can be imported, and is that of this tree."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import panda_twin


class Package(unittest.TestCase):
    def test_has_a_version_and_its_error(self):
        self.assertRegex(panda_twin.__version__, r"^\d+\.\d+\.\d+$")
        self.assertTrue(issubclass(panda_twin.RobotFault, RuntimeError))

    def test_is_of_this_tree(self):
        source = pathlib.Path(__file__).parents[2] / "python/panda_twin/__init__.py"
        self.assertEqual(pathlib.Path(panda_twin.__file__).resolve(), source)

    def test_a_broken_gymnasium_costs_the_environments_alone(self):
        with tempfile.TemporaryDirectory(prefix="panda_twin_test_") as folder:
            (pathlib.Path(folder) / "gymnasium.py").write_text("raise AttributeError('made for another numpy')")
            path = os.pathsep.join([folder, *sys.path])
            program = "import panda_twin as pt; print(pt.model.gravity(pt.model.Q_READY)[1] < 0); import panda_twin.envs"
            done = subprocess.run([sys.executable, "-c", program], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True)
        self.assertEqual((done.stdout, done.returncode), ("True\n", 1), done.stderr)
        self.assertIn("made for another numpy", done.stderr)

    def test_the_reference_names_all_of_it(self):
        page = (pathlib.Path(__file__).parents[2] / "docs/reference/python.md").read_text()
        for module, names in ((panda_twin, panda_twin.__all__), (panda_twin.model, panda_twin.model.__all__),
                              (panda_twin.envs, panda_twin.envs.__all__)):
            for name in names:
                if not name.startswith("__"):
                    self.assertRegex(page, rf"\b{name}\b", module.__name__)


if __name__ == "__main__":
    unittest.main()
