"""Scenarios in Python: read, built, changed and compared, all by the code that reads files."""

import json
import pathlib
import pickle
import tempfile
import unittest

import numpy

import panda_twin as pt

READY = [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]
MOTION = {"trajectory": {"unit": "rad", "waypoints": [{"q": READY}, {"q": [0.5, *READY[1:]]}]}}
MODELS = pathlib.Path(__file__).parents[2] / "models"


class ScenarioTest(unittest.TestCase):
    def test_replace_takes_keys_as_names_too(self):
        old = pt.Scenario.load("scenarios/smoke.yaml")
        new = old.replace(link={"command_loss": "1 %"}, seed=7)
        self.assertEqual(new, old.replace({"link": {"command_loss": "1 %"}, "seed": 7}))
        self.assertNotEqual(new, old)
        self.assertEqual(old.replace(), old)

    def test_is_found_among_the_models_as_the_program_finds_it(self):
        for name in ("scenarios/canonical.yaml", "models/scenarios/canonical.yaml", MODELS / "scenarios/canonical.yaml"):
            self.assertEqual(pt.Scenario.load(name).name, "canonical")

    def test_repeats_by_its_text_its_keys_and_its_pickle(self):
        for file in sorted((MODELS / "scenarios").glob("*.yaml")) + sorted((MODELS / "applications").glob("*.yaml")):
            if file.name == "canonical.hash.yaml":
                continue
            with self.subTest(file.name):
                scenario = pt.Scenario.load(file)
                self.assertEqual(pt.Scenario.from_yaml(scenario.to_yaml()), scenario)
                self.assertEqual(pt.Scenario(**scenario.to_dict()), scenario)
                self.assertEqual(pickle.loads(pickle.dumps(scenario)), scenario)
                self.assertEqual(hash(pickle.loads(pickle.dumps(scenario))), hash(scenario))

    def test_is_built_of_numbers_texts_and_arrays(self):
        motion = {"trajectory": {"unit": "rad", "waypoints": [{"q": numpy.array(READY)}, {"q": tuple([numpy.float64(0.5), *READY[1:]])}]}}
        built = pt.Scenario(name="here", seed=2**64 - 1, motion=motion, plant={"kind": "ideal"}, render={"enabled": False})
        self.assertEqual((built.name, built.seed, built.drive), ("here", 2**64 - 1, "lockstep"))
        self.assertEqual(built, pt.Scenario(name="here", seed=2**64 - 1, motion=MOTION, plant={"kind": "ideal"}, render={"enabled": False}))

    def test_another_value_is_another_scenario(self):
        scenario = pt.Scenario(name="here", motion=MOTION)
        self.assertNotEqual(scenario, scenario.replace({"link": {"d_INT": "200 us"}}))
        self.assertNotEqual(scenario, "here")
        self.assertEqual(scenario, scenario.replace({}))

    def test_replaces_nested_values_and_leaves_the_others(self):
        before = pt.Scenario.load("scenarios/canonical.yaml")
        after = before.replace({"link": {"command_loss": "1 %"}, "seed": 7})
        expected = before.to_dict()
        expected["link"]["command_loss"] = "1 %"
        expected["seed"] = 7
        self.assertEqual(after.to_dict(), expected)
        self.assertEqual(before.seed, 1)

    def test_chooses_dependent_defaults_anew(self):
        torque = pt.Scenario(name="here", motion=MOTION).replace({"motion": {"interface": "torque"}})
        self.assertEqual(torque.to_dict()["controller"]["type"], "joint_trajectory_effort")
        self.assertEqual(torque, pt.Scenario(name="here", motion={**MOTION, "interface": "torque"}))

    def test_gives_removed_keys_their_defaults_back(self):
        scenario = pt.Scenario(name="here", motion=MOTION, link={"d_INT": "200 us"}, tick={"viability": 3})
        self.assertEqual(scenario.replace({}, remove=["link.d_INT", "tick"]), pt.Scenario(name="here", motion=MOTION))
        self.assertEqual(scenario.replace({}, remove="link").to_dict()["tick"]["viability"], 3)

    def test_names_file_line_and_key(self):
        text = f"name: here\nlink:\n  command_los: 1 %\nmotion: {json.dumps(MOTION)}\n"
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "a.yaml")
            file.write_text(text)
            for read, where in ((lambda: pt.Scenario.load(file), f"{file}:3: link: "), (lambda: pt.Scenario.from_yaml(text, "b"), "b:3: link: ")):
                with self.assertRaises(ValueError) as refused:
                    read()
                self.assertTrue(str(refused.exception).startswith(where), refused.exception)
                self.assertIn('unknown key "command_los"; did you mean "command_loss"?', str(refused.exception))

    def test_finds_waypoints_beside_its_file_after_a_change(self):
        scenario = pt.Scenario.load("scenarios/canonical.yaml").replace({"seed": 2}).replace({"seed": 3})
        self.assertEqual(scenario.seed, 3)


class ValidateTest(unittest.TestCase):
    def test_needs_no_motion_but_a_place_where_the_arm_stands(self):
        standing = pt.Scenario(name="standing", robot={"q_start": {"unit": "rad", "values": pt.model.Q_READY}})
        with pt.Session(standing) as session:
            numpy.testing.assert_allclose(session.state.q, pt.model.Q_READY, atol=1e-6)
        with self.assertRaisesRegex(ValueError, "nothing says where the arm stands: give robot.q_start, or a motion"):
            pt.Scenario(name="nowhere")
        for call in (pt.run, pt.validate):
            with self.assertRaisesRegex(ValueError, "scenario standing: motion is missing; give it one, or an application"):
                call(standing)

    def test_tells_what_it_checked(self):
        self.assertIn("3 waypoints", pt.validate("scenarios/smoke.yaml"))
        self.assertIn("application  plan_and_execute", pt.validate("applications/plan_and_execute.yaml"))

    def test_refuses_what_only_a_run_can_know(self):
        with self.assertRaisesRegex(ValueError, "touch"):
            into_the_floor = [0, 1.4, 0, -1.0, 0, 1.5708, 0.7854]
            pt.validate({"name": "low", "motion": {"trajectory": {"unit": "rad", "waypoints": [{"q": READY}, {"q": into_the_floor}]}}})

    def test_loads_no_code_unless_asked(self):
        scenario = pt.Scenario(name="here", motion=MOTION, controller={"library": __file__, "type": "mine"}, plant={"kind": "ideal"})
        self.assertIn("not loaded", pt.validate(scenario))
        with self.assertRaisesRegex(ValueError, "python_scenario_test.py"):
            pt.validate(scenario, load=True)


if __name__ == "__main__":
    unittest.main()
