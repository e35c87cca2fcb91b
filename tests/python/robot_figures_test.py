"""docs/reference/robot-figures.md: our figures in it are those of the code, and the differences are differences."""

import pathlib
import re
import unittest

import numpy as np

from panda_twin import _core, model
from panda_twin.identify._model import FRICTION, _friction, body_of

ROOT = pathlib.Path(__file__).resolve().parents[2]
POSE = [0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4]
INERTIA = {"Ixx": (0, 0), "Iyy": (1, 1), "Izz": (2, 2), "Ixy": (0, 1), "Ixz": (0, 2), "Iyz": (1, 2)}


def constant(file, name):
    """Seven numbers of a JointVector in a file of C++."""
    found = re.search(rf"\b{name}{{([^}}]*)}}", (ROOT / file).read_text())
    return np.array([float(x) for x in found.group(1).split(",")])


def ours():
    """(figure, whose) -> seven numbers, of what runs."""
    found = {}
    for whose, of_plant in (("plant", True), ("model", False)):
        parameters = np.array(_core.model_parameters(of_plant)).reshape(7, 10)
        bodies = [body_of(one) for one in parameters]
        found["mass", whose] = np.array([m for m, _, _ in bodies])
        for i, axis in enumerate("xyz"):
            found[f"centre {axis}", whose] = np.array([c[i] for _, c, _ in bodies])
        for name, place in INERTIA.items():
            found[name, whose] = np.array([inertia[place] for _, _, inertia in bodies])
        figures = "plant" if of_plant else "robot"
        found["gravity", whose] = model.gravity(POSE, figures=figures)
        found["diagonal of M", whose] = np.diag(model.mass(POSE, figures=figures))
    residual, breakaway = _friction("residual"), _friction("breakaway")
    found["phi1", "residual"], found["phi2", "residual"], found["phi3", "residual"] = 2 * residual[1], residual[3], residual[4]
    found["Coulomb", "residual"] = residual[1]
    found["viscous", "residual"], found["offset", "residual"] = residual[0], residual[2]
    found["break-away", "breakaway"], found["viscous", "breakaway"] = breakaway[1], breakaway[0]
    found["armature", "plant"] = constant("include/twin/plant/arm_properties.h", "kArmature")
    return found


class Figures(unittest.TestCase):
    def setUp(self):
        text = (ROOT / "docs/reference/robot-figures.md").read_text()
        self.rows = {}
        for line in text.splitlines():
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            if len(cells) == 9 and re.fullmatch(r"-?[0-9.e-]+|—", cells[2]):
                figure = cells[0].split(",")[0]
                self.assertNotIn((figure, cells[1]), self.rows)
                self.rows[figure, cells[1]] = cells[2:]

    def values(self, figure, whose):
        return np.array([float(x) for x in self.rows[figure, whose]])

    def test_our_figures_are_those_of_the_code(self):
        for (figure, whose), values in ours().items():
            for x, text in zip(values, self.rows[figure, f"ours, {whose}"]):
                self.assertEqual(text, f"{x + 0:.5g}" if abs(x) > 1e-12 else "0", (figure, whose))

    def test_differences_are_differences(self):
        checked = 0
        for figure, whose in self.rows:
            if not (match := re.fullmatch(r"ours, (\w+), less (.+)", whose)):
                continue
            a, b = self.values(figure, f"ours, {match[1]}"), self.values(figure, match[2])
            np.testing.assert_allclose(self.values(figure, whose), a - b, rtol=0, atol=1e-4 * np.maximum(np.abs(a), np.abs(b)).max())
            checked += 1
        self.assertGreaterEqual(checked, 20)

    def test_the_package_and_the_program_have_the_same_friction(self):
        found = ours()
        for name, figure in (("kPhi1", "phi1"), ("kPhi2", "phi2"), ("kPhi3", "phi3")):
            np.testing.assert_array_equal(constant("src/model/panda.cc", name), found[figure, "residual"])
        np.testing.assert_array_equal(constant("src/plant/joint_parameters.h", "kBreakawayTorque"), found["break-away", "breakaway"])
        np.testing.assert_array_equal(constant("src/plant/joint_parameters.h", "kViscousFriction"), found["viscous", "breakaway"])
        self.assertEqual(FRICTION[:3], ("viscous", "coulomb", "offset"))

    def test_published_links_give_published_gravity(self):
        """A slip in a published mass or centre would show."""
        for whose in ("Gaz 2019", "franka-rs"):
            if ("mass", whose) not in self.rows:
                continue
            mass = self.values("mass", whose)
            parameters = np.zeros((8, 10))
            parameters[:7, 0] = mass
            for i, axis in enumerate("xyz"):
                parameters[:7, 1 + i] = mass * self.values(f"centre {axis}", whose)
            Y = np.empty((1, 560))
            still = np.zeros((1, 7))
            _core.model_regressor(np.array([POSE]), still, still, [0.0, 0.0, -9.81], Y)
            np.testing.assert_allclose(Y.reshape(7, 80) @ parameters.ravel(), self.values("gravity", whose), atol=6e-4)


if __name__ == "__main__":
    unittest.main()
