"""The package's types: stubs are those of the module, mypy --strict passes, and finds what users get wrong."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import panda_twin

BUILT = pathlib.Path(panda_twin._core.__file__).parent
EXAMPLES = pathlib.Path(__file__).parents[2] / "python/examples"
GENERATOR = pathlib.Path(__file__).parents[2] / "python/generate_scenario.py"

RIGHT = """
import pathlib
import numpy
import panda_twin as pt

scenario = pt.Scenario(
    name="a",
    link={"command_loss": "1 %", "state_delay": {"log_normal": {"median": "50 us", "sigma": 0.5}}},
    tick={"lambda": 1e-3},
    motion={"trajectory": {"unit": "rad", "waypoints": [{"q": numpy.zeros(7)}, {"q": [0.0] * 7, "at": "1 s"}]}},
)
lossy = scenario.replace({"link": {"command_loss": "1 %"}}, remove=["seed"])
result = pt.run(lossy, seed=7, out=pathlib.Path("out"), drive="lockstep")
log: pathlib.Path | None = result.log
try:
    pt.run("canonical.yaml")
except pt.RobotFault as fault:
    joint: int | None = fault.joint
text: str = pt.explain(result).text


def turn(robot: pt.Robot) -> float:
    robot.move()
    return robot.time


with pt.Cell({"robots": {"left": {}, "right": {}}}, log="out") as cell:
    ends: dict[str, float] = cell.together(left=turn, right=turn)
    turn(cell.robots["left"])
with pt.Session() as session:
    turn(session)
"""
WRONG = {
    'pt.Scenario(naem="a")': "naem",
    'pt.Scenario(name="a", link={"command_los": "1 %"})': "command_los",
    'pt.Scenario(name="a", link={"d_INT": 100})': "d_INT",
    'pt.Scenario(name="a", drive="fast")': "fast",
    'pt.run("a.yaml", drive="fast")': "fast",
    'pt.run("a.yaml", 7)': "positional",
    'pt.run("a.yaml").states_hsah': "states_hsah",
    'pt.Cell("a.yaml").move()': "move",
    'pt.Cell("a.yaml").together(left=7)': "int",
}


class TypesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cache = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        cls.addClassCleanup(cls.cache.cleanup)

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def mypy(self, *arguments):
        # nanobind writes os.PathLike without what it is of.
        (self.folder / "mypy.ini").write_text("[mypy]\n[mypy-panda_twin._core]\ndisallow_any_generics = False\n")
        done = subprocess.run(
            [sys.executable, "-m", "mypy", "--strict", "--cache-dir", self.cache.name, *arguments],
            cwd=self.folder, env={**os.environ, "MYPYPATH": str(BUILT.parent)}, capture_output=True, text=True,
        )
        return done.stdout + done.stderr

    def test_the_stub_says_what_lists_are_of(self):
        self.assertNotRegex((BUILT / "_core.pyi").read_text(), r"(: |-> )(list|dict|tuple)\b(?!\[)")

    def test_the_package_is_strictly_typed(self):
        self.assertRegex(self.mypy("-p", "panda_twin"), "^Success: no issues found in [1-9]")

    def test_the_examples_are_strictly_typed(self):
        self.assertRegex(self.mypy(*sorted(EXAMPLES.glob("*.py"))), "^Success: no issues found in [1-9]")

    def test_right_use_passes(self):
        (self.folder / "right.py").write_text(RIGHT)
        self.assertRegex(self.mypy("right.py"), "^Success")

    def test_wrong_use_is_found(self):
        (self.folder / "wrong.py").write_text("\n".join(["import panda_twin as pt", *WRONG]))
        told = self.mypy("wrong.py").splitlines()
        for line, (text, word) in enumerate(WRONG.items(), 2):
            with self.subTest(text):
                self.assertTrue(any(one.startswith(f"wrong.py:{line}: error") and word in one for one in told), told)

    def test_the_stub_is_that_of_the_module(self):
        stub = self.folder / "_core.pyi"
        subprocess.run([sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "panda_twin._core", "-o", stub], check=True)
        self.assertEqual((BUILT / "_core.pyi").read_text(), stub.read_text())

    def test_the_sections_are_those_of_the_schema(self):
        types = self.folder / "scenario_types.py"
        subprocess.run([sys.executable, "-P", GENERATOR, types], check=True)
        self.assertEqual((BUILT / "scenario_types.py").read_text(), types.read_text())

    def test_every_key_of_the_schema_has_a_type(self):
        import panda_twin.scenario_types as types

        def compare(schema, keys):
            self.assertEqual(set(schema["properties"]), set(keys.__annotations__))
            for key, value in schema["properties"].items():
                name = keys.__annotations__[key]
                nested = getattr(types, getattr(name, "__forward_arg__", str(name)), None)
                if value.get("properties") and nested:
                    compare(value, nested)

        compare(panda_twin.schema(), types.ScenarioKeys)


if __name__ == "__main__":
    unittest.main()
