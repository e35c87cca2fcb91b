#!/usr/bin/env python3
"""Holds scenario files against the JSON Schema: scenario_json_schema_test.py PROGRAM SOURCE_TREE [unittest options]."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import jsonschema
from ruamel.yaml import YAML

PROGRAM = ""
SOURCE = pathlib.Path()

GOOD = """name: good
tick: {lambda: 0.01, low_pass: off}
link: {state_delay: 80 us, command_loss: {gilbert_elliott: {good_to_bad: 0.1 %, bad_to_good: 25 %}}}
motion:
  interface: joint_position
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
"""

# What is wrong, the text, and what stands in its place.
BAD = (
    ("an unknown key", "lambda: 0.01", "lamda: 0.01"),
    ("an unknown section", "tick:", "tock:"),
    ("a missing key", "name: good\n", ""),
    ("a missing motion", "motion:", "description:"),
    ("a name with a slash", "name: good", "name: ../good"),
    ("a plain number out of range", "lambda: 0.01", "lambda: 2"),
    ("a text for a number", "lambda: 0.01", "lambda: soft"),
    ("a quantity without a unit", "state_delay: 80 us", "state_delay: 80"),
    ("a unit of another dimension", "state_delay: 80 us", "state_delay: 80 Hz"),
    ("a negative time", "state_delay: 80 us", "state_delay: -80 us"),
    ("a choice that there is not", "joint_position", "joint_posture"),
    ("another word than off", "low_pass: off", "low_pass: none"),
    ("two alternatives", "{gilbert_elliott:", "{scripted: [], gilbert_elliott:"),
    ("an alternative that lacks a key", "good_to_bad: 0.1 %, ", ""),
    ("a joint too few", "[0.1, -0.7854,", "[-0.7854,"),
    ("a single value for a map", "tick: {lambda: 0.01, low_pass: off}", "tick: 3"),
    ("a list for a map", "tick: {lambda: 0.01, low_pass: off}", "tick: [3]"),
    ("two motions", "  trajectory:", "  plan: {goal: random}\n  trajectory:"),
    ("a section of former versions", "tick:", "int: {}\ntick:"),
)


def schema_text(*flags):
    return subprocess.run([PROGRAM, "schema", *flags], capture_output=True, text=True, timeout=60, check=True).stdout


def parsed(text):
    """As YAML 1.2, in which off is a word."""
    return YAML(typ="safe", pure=True).load(text)


class JsonSchemaTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.schema = json.loads(schema_text())
        jsonschema.Draft202012Validator.check_schema(cls.schema)
        cls.validator = jsonschema.Draft202012Validator(cls.schema)

    def faults(self, text):
        return [f"{error.json_path}: {error.message}" for error in self.validator.iter_errors(parsed(text))]

    def is_read(self, text):
        with tempfile.TemporaryDirectory(prefix="panda_twin_schema_") as folder:
            file = pathlib.Path(folder) / "s.yaml"
            file.write_text(text)
            done = subprocess.run([PROGRAM, "validate", file, "--data", SOURCE / "models"], capture_output=True, text=True,
                                  timeout=120)
        self.assertIn(done.returncode, (0, 3), done.stderr)
        return done.returncode == 0

    def test_every_scenario_that_is_shipped_is_valid(self):
        files = [file for folder in ("scenarios", "applications", "experiments", "cells")
                 for file in sorted((SOURCE / "models" / folder).glob("*.yaml")) if not file.name.endswith(".hash.yaml")]
        self.assertGreater(len(files), 20)
        for file in files:
            with self.subTest(file=file.name):
                self.assertEqual(self.faults(file.read_text()), [])

    def test_what_a_run_writes_is_valid(self):
        with tempfile.TemporaryDirectory(prefix="panda_twin_schema_") as folder:
            subprocess.run([PROGRAM, "run", SOURCE / "models/scenarios/smoke.yaml", "--no-video", "--out", folder + "/out",
                            "--data", SOURCE / "models"], capture_output=True, timeout=120, check=True)
            self.assertEqual(self.faults((pathlib.Path(folder) / "out/scenario.yaml").read_text()), [])

    def test_reader_and_schema_take_a_good_file(self):
        self.assertEqual(self.faults(GOOD), [])
        self.assertTrue(self.is_read(GOOD))

    def test_reader_and_schema_take_the_unit_of_the_interface(self):
        text = GOOD.replace("joint_position", "torque") + "controller: {target_noise: 0.2 Nm}\n"
        self.assertEqual(self.faults(text), [])
        self.assertTrue(self.is_read(text))

    def test_reader_and_schema_refuse_bad_files(self):
        for what, good, bad in BAD:
            with self.subTest(what):
                self.assertIn(good, GOOD)
                text = GOOD.replace(good, bad, 1)
                self.assertFalse(self.is_read(text))
                self.assertNotEqual(self.faults(text), [])

    def test_editors_are_told_meaning_unit_and_default(self):
        clearance = self.schema["properties"]["motion"]["properties"]["plan"]["properties"]["clearance"]
        self.assertEqual(clearance["default"], "0.01 m")
        self.assertEqual(clearance["title"], "length in [0.001, 0.1] m")
        self.assertIn("Distance", clearance["description"])

    def test_the_table_of_keys_is_printed_too(self):
        self.assertEqual(schema_text("--keys"), (SOURCE / "models/scenarios/KEYS.md").read_text())


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
