"""The package can be imported, and is that of this tree."""

import pathlib
import unittest

import panda_twin


class Package(unittest.TestCase):
    def test_has_a_version_and_its_error(self):
        self.assertRegex(panda_twin.__version__, r"^\d+\.\d+\.\d+$")
        self.assertTrue(issubclass(panda_twin.RobotFault, RuntimeError))

    def test_is_of_this_tree(self):
        source = pathlib.Path(__file__).parents[2] / "python/panda_twin/__init__.py"
        self.assertEqual(pathlib.Path(panda_twin.__file__).resolve(), source)


if __name__ == "__main__":
    unittest.main()
