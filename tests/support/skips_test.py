#!/usr/bin/env python3
"""What is skipped is a skip to ctest, with its reason: skips_test.py SKIPPING_PROGRAM BUILD SOURCE_TREE [unittest options]."""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, BUILD, SOURCE = "", pathlib.Path(), pathlib.Path()

# As ctest reads them: name, what the test runs, its properties.
PASSES = ("passes", "echo fine", "")
FAILS = ("fails", "exit 1", "")
SKIPS = ("skips", "echo; echo there is no disk; exit 77", "SKIP_RETURN_CODE 77")
LACKS = ("lacks", "echo missing: meshes; exit 77", "SKIP_RETURN_CODE 77")


def unittest_that(body):
    """The command that runs a case with this body, and one that is skipped."""
    return f"""python3 - <<'END'
import unittest
class T(unittest.TestCase):
  def test_x(self): {body}
  def test_y(self): self.skipTest("it isn't here")
unittest.main(argv=["x", "-v"])
END"""


class RunTestsTest(unittest.TestCase):
    def run_tests(self, tests, *options):
        with tempfile.TemporaryDirectory() as folder:
            lines = []
            for name, command, properties in tests:
                lines.append(f"add_test({name} sh -c [==[{command}]==])")
                lines += [f"set_tests_properties({name} PROPERTIES {properties})"] if properties else []
            pathlib.Path(folder, "CTestTestfile.cmake").write_text("\n".join(lines))
            return subprocess.run([SOURCE / "scripts/run-tests", folder, *options], capture_output=True, text=True)

    def test_without_a_skip_it_is_as_ctest(self):
        self.assertEqual(self.run_tests([PASSES], "--skips", "0").returncode, 0)
        self.assertNotEqual(self.run_tests([FAILS], "--skips", "0").returncode, 0)

    def test_tells_each_skip_and_its_reason_at_the_end(self):
        done = self.run_tests([SKIPS, PASSES, LACKS])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.splitlines()[-3:], ["skipped: skips: there is no disk", "skipped: lacks: missing: meshes",
                                                         "run-tests: 2 tests skipped"])

    def test_more_skips_than_allowed_are_a_failure(self):
        self.assertEqual(self.run_tests([SKIPS, PASSES], "--skips", "1").returncode, 0)
        done = self.run_tests([SKIPS, PASSES], "--skips", "0")
        self.assertEqual(done.returncode, 1)
        self.assertIn("1 tests skipped, more than 0: a failure", done.stdout)

    def test_what_is_missing_is_a_failure_where_skips_are_counted(self):
        self.assertEqual(self.run_tests([LACKS, PASSES]).returncode, 0)
        self.assertEqual(self.run_tests([LACKS, PASSES], "--skips", "9").returncode, 1)

    def test_a_wrong_argument_is_refused_before_the_setup(self):
        with tempfile.TemporaryDirectory() as folder:
            scripts = pathlib.Path(folder, "scripts")
            scripts.mkdir()
            for name in ("test", "run-tests"):
                shutil.copy(SOURCE / "scripts" / name, scripts)
            (scripts / "setup").write_text("#!/bin/sh\necho setup ran; exit 9\n")
            (scripts / "setup").chmod(0o755)
            done = subprocess.run([scripts / "test", "--skips", "few"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertIn("--skips: invalid int value: 'few'", done.stderr)
            self.assertEqual(subprocess.run([scripts / "test", "--skips", "3"], capture_output=True).returncode, 9)

    def test_a_failure_beside_skips_is_a_failure(self):
        self.assertNotEqual(self.run_tests([SKIPS, FAILS], "--skips", "9").returncode, 0)

    def test_ctests_arguments_are_passed_on(self):
        self.assertEqual(self.run_tests([PASSES, FAILS], "-R", "^passes$", "--skips", "0", "-j2").returncode, 0)
        self.assertNotEqual(self.run_tests([PASSES], "-R", "nowhere").returncode, 0)


class OfThisBuildTest(unittest.TestCase):
    """Every test of this build, whatever kind of program it is."""

    @classmethod
    def setUpClass(cls):
        shown = subprocess.run(["ctest", "--test-dir", BUILD, "--show-only=json-v1"], check=True, capture_output=True, text=True)
        cls.properties = {test["name"]: {p["name"]: p["value"] for p in test["properties"]}
                          for test in json.loads(shown.stdout)["tests"]}

    def test_every_test_can_say_that_it_skipped(self):
        for name, of in self.properties.items():
            self.assertEqual(of.get("SKIP_RETURN_CODE"), 77, name)
            self.assertTrue(of.get("SKIP_REGULAR_EXPRESSION"), name)

    def properties_for(self):
        of = self.properties["skips_test"]
        [expression] = of["SKIP_REGULAR_EXPRESSION"]
        return f"SKIP_RETURN_CODE {of['SKIP_RETURN_CODE']} SKIP_REGULAR_EXPRESSION [==[\n{expression}]==]"

    def told(self, command):
        """What run-tests says of the command as a test of this build."""
        return RunTestsTest.run_tests(self, [("it", command, self.properties_for())])

    def test_googletest_with_a_skipped_case(self):
        self.assertIn("skipped: it: there is no disk\n", self.told(f"{PROGRAM} --gtest_filter=*Skips").stdout)
        self.assertIn("skipped: it: there is no disk\n", self.told(f"{PROGRAM} --gtest_filter=*Skips:*Passes").stdout)
        self.assertIn("run-tests: 0 tests skipped", self.told(f"{PROGRAM} --gtest_filter=*Passes").stdout)
        failed = self.told(f"{PROGRAM} --gtest_filter=*Skips:*Fails")
        self.assertNotEqual(failed.returncode, 0)
        self.assertIn("run-tests: 0 tests skipped", failed.stdout)

    def test_unittest_with_a_skipped_case(self):
        done = self.told(unittest_that("pass"))
        self.assertIn("skipped: it: it isn't here\n", done.stdout)
        failed = self.told(unittest_that("self.fail()"))
        self.assertNotEqual(failed.returncode, 0)
        self.assertIn("run-tests: 0 tests skipped", failed.stdout)


if __name__ == "__main__":
    PROGRAM, BUILD, SOURCE = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
