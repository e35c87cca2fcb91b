#!/usr/bin/env python3
"""scripts/nightly from outside: nightly_test.py SOURCE_TREE [unittest options]."""

import pathlib
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree

SOURCE = pathlib.Path()
TIMEOUT = 100  # s
# As ctest reads them. Each notes that it was run.
TESTS = """\
add_test(good sh -c "echo good >> {ran}")
set_tests_properties(good PROPERTIES LABELS "slow")
add_test(bad sh -c "echo bad >> {ran}; exit 1")
set_tests_properties(bad PROPERTIES LABELS "bench")
add_test(skips sh -c "echo skips >> {ran}; echo no disk; exit 77")
set_tests_properties(skips PROPERTIES LABELS "unit;slow" SKIP_RETURN_CODE 77)
add_test(endless sh -c "echo $$ >> {ran}; exec sleep 1000")
set_tests_properties(endless PROPERTIES LABELS "slow")
add_test(everyday sh -c "echo everyday >> {ran}")
set_tests_properties(everyday PROPERTIES LABELS "unit")
"""


class NightlyTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.ran = self.folder / "ran"
        (self.folder / "CTestTestfile.cmake").write_text(TESTS.format(ran=self.ran))

    def command(self, only, *options):
        return [SOURCE / "scripts/nightly", "--build", self.folder, "--out", self.folder / "out", "--only", only, *options]

    def nightly(self, *options, only="^(good|bad|skips|everyday)$"):
        return subprocess.run(self.command(only, *options), capture_output=True, text=True)

    def runs(self):
        return self.ran.read_text().split() if self.ran.exists() else []

    def test_runs_what_is_labelled_slow_or_bench_and_nothing_else(self):
        self.assertEqual(self.nightly().returncode, 1)
        self.assertCountEqual(self.runs(), ["good", "skips", "bad"])

    def test_a_name_that_matches_no_item_is_an_error(self):
        for options in ([], ["--list"]):
            done = self.nightly(*options, only="^nothing$")
            self.assertEqual(done.returncode, 2)
            self.assertIn("^nothing$", done.stderr)

    def test_what_has_ended_is_not_repeated(self):
        self.nightly(only="^good$")
        self.assertEqual(self.runs(), ["good"])
        self.nightly()
        done = self.nightly()
        self.assertCountEqual(self.runs(), ["good", "skips", "bad"])
        self.assertEqual(done.returncode, 1, "what failed is still a failure")
        self.nightly("--again", only="^bad$")
        self.assertEqual(self.runs().count("bad"), 2)

    def test_another_state_of_the_tree_is_run_anew(self):
        self.nightly(only="^good$")
        state = self.folder / "out/state.json"
        state.write_text(state.read_text().replace('"tree": "', '"tree": "0'))
        self.assertRegex(self.nightly("--list", only="^good$").stdout, "^good +slow +not run\n$")
        self.nightly(only="^good$")
        self.assertEqual(self.runs(), ["good", "good"])

    def test_begins_nothing_after_its_time(self):
        self.assertEqual(self.nightly("--for", "0s").returncode, 0)
        self.assertEqual(self.runs(), [])
        self.assertEqual(self.nightly("--for", "soon").returncode, 2)

    def test_passes_when_all_did(self):
        self.assertEqual(self.nightly(only="^good$").returncode, 0)
        self.assertEqual(self.nightly(only="^skips$").returncode, 1)

    def test_reports_each_item_with_its_time_log_and_reason(self):
        self.nightly()
        out = self.folder / "out"
        suite = xml.etree.ElementTree.parse(out / "junit.xml").getroot()
        cases = {case.get("name"): case for case in suite}
        self.assertEqual((suite.get("failures"), cases["bad"].get("classname")), ("1", "bench"))
        self.assertIsNotNone(cases["bad"].find("failure"))
        self.assertEqual(cases["skips"].find("skipped").get("message"), "skips: no disk")
        self.assertEqual(len(cases["good"]), 0)
        self.assertGreater(float(cases["good"].get("time")), 0)
        self.assertIn("unit_under_asan", cases)
        page = (out / "report.html").read_text()
        for text in ("<td>good<td>slow<td>passed", "<td>bad<td>bench<td>failed", "<td>skips: no disk", "<td>unit_under_asan<td>asan<td>not run",
                     "<td>unit_under_tsan<td>tsan<td>not run", "1 passed, 1 failed, 1 skipped, 3 not run", 'href="logs/bad.log"'):
            self.assertIn(text, page)
        self.assertIn("no disk", (out / "logs/skips.log").read_text())

    def test_broken_off_it_ends_its_item_and_begins_it_again(self):
        process = subprocess.Popen(self.command("^endless$"), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(process.kill)
        limit = time.monotonic() + TIMEOUT
        while not self.runs():
            self.assertLess(time.monotonic(), limit)
            time.sleep(0.02)
        process.terminate()
        process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 130)
        sleeper = pathlib.Path("/proc", self.runs()[0], "cmdline")
        while sleeper.exists() and sleeper.read_bytes():  # nobody may have waited for it yet
            self.assertLess(time.monotonic(), limit)
            time.sleep(0.02)
        self.assertRegex(self.nightly("--list", only="^endless$").stdout, "^endless +slow +not run\n$")

    def test_lists_without_running(self):
        self.nightly(only="^good$")
        self.ran.unlink()
        listed = self.nightly("--list").stdout
        self.assertRegex(listed, r"good +slow +passed +\d+ s\n")
        self.assertRegex(listed, r"bad +bench +not run\n")
        self.assertEqual(self.runs(), [])


if __name__ == "__main__":
    SOURCE = pathlib.Path(sys.argv[1])
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
