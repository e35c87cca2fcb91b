#!/usr/bin/env python3
"""A person goes on by the page alone, after STOP and after a reflex: page_resume_test.py PROGRAM SOURCE_TREE [--keep FOLDER] [unittest options].

A robot served in lockstep at the pace of the wall clock, led in a browser. --keep saves what the browser shows.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from selenium.webdriver.common.keys import Keys

from browser_page import BrowserPage, keep_folder
from web_client import TIMEOUT

PROGRAM = ""
SOURCE = pathlib.Path()
KEEP = None
READY = "[0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]"
SCENARIO = f"""name: served
motion:
  trajectory:
    unit: rad
    waypoints:
      - {{at: 0 s, q: {READY}}}
      - {{at: 1 s, q: {READY}}}
"""
# Forces that any motion causes are collisions.
TOUCHY = """onboard:
  collision_behavior:
    lower_force: {force: 0.1 N}
    lower_force_acc: {force: 0.1 N}
    lower_force_nominal: {force: 0.1 N}
    upper_force: {force: 0.2 N}
    upper_force_acc: {force: 0.2 N}
    upper_force_nominal: {force: 0.2 N}
"""
JOINTS = """return [...document.querySelectorAll("#bars .bar")].map((bar) => parseFloat(bar.children[2].textContent))"""


class PageResumeTest(unittest.TestCase):
    def lead(self, scenario):
        """The page of such a robot, in control of it."""
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_", ignore_cleanup_errors=True)
        self.addCleanup(folder.cleanup)
        path = pathlib.Path(folder.name, "served.yaml")
        path.write_text(SCENARIO + scenario)
        process = subprocess.Popen([PROGRAM, "serve", path, "--drive", "lockstep", "--pace", "1", "--page=0", "--port", "0", "--hand-port", "0",
                                    "--data", SOURCE / "models"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

        def end():
            process.terminate()
            process.communicate(timeout=TIMEOUT)
        self.addCleanup(end)
        said = ""
        for line in process.stdout:
            said += line
            if match := re.search(r"http://127\.0\.0\.1:\d+/#token=[0-9a-f]{32}", line):
                page = BrowserPage(folder.name, match[0], keep=KEEP)
                self.addCleanup(page.quit)
                page.wait_for("idle")
                page.element("take").click()
                page.wait_until(lambda: page.text("leads") == "You lead the arm.")
                return page
        self.fail(said)

    def events(self, page):
        return page.run("return document.getElementById('events').textContent")

    def test_goes_on_and_home_after_a_stop(self):
        page = self.lead("")
        start = page.run(JOINTS)
        height = page.numbers("z")[0]
        page.hold_until("r", lambda: page.numbers("z")[0] > height + 0.04)
        page.press(" ")
        page.wait_for("stopped")
        self.assertFalse(page.element("home").is_displayed())
        page.keep("served_stopped")
        page.element("release").click()
        page.wait_until(lambda: page.element("recover").is_displayed())
        self.assertTrue(page.element("home").is_displayed())
        page.keep("served_released")
        page.element("recover").click()
        page.wait_until(lambda: page.text("leads") == "You lead the arm.")
        height = page.numbers("z")[0]
        page.hold_until("f", lambda: page.numbers("z")[0] < height - 0.02)
        page.element("home").click()
        page.wait_until(lambda: page.text("leads") == "You have sent it home.")
        page.keep("served_home")
        page.wait_until(lambda: "reached" in self.events(page))
        for before, now in zip(start, page.run(JOINTS)):
            self.assertAlmostEqual(before, now, delta=0.3)  # degrees: a robot at rest, shown to 0.1
        page.wait_until(lambda: not page.element("no-picture").is_displayed())
        page.wait_until(lambda: page.text("leads") == "You lead the arm.")

    def test_pauses_in_a_motion_and_turns_a_joint(self):
        page = self.lead("")
        page.press("p")
        page.wait_for("paused")
        stands = page.text("clock")
        page.keep("served_paused")
        page.press("p")
        page.wait_until(lambda: page.text("leads") == "You lead the arm." and page.text("clock") != stands)
        page.press("j")
        page.wait_until(lambda: page.text("leads") == "You lead joint 1.")  # a key held before would have to be released first
        page.hold_until(Keys.ARROW_RIGHT, lambda: page.run(JOINTS)[0] > 5)

    def test_way_home_stops_and_says_so(self):
        page = self.lead("")
        height = page.numbers("z")[0]
        page.hold_until("r", lambda: page.numbers("z")[0] > height + 0.1)
        page.element("home").click()
        page.wait_until(lambda: page.text("leads") == "You have sent it home.")
        page.wait_until(lambda: page.numbers("z")[0] < height + 0.095)
        page.press(" ")
        page.wait_for("stopped")
        page.wait_until(lambda: "the way home ended early" in self.events(page))
        page.element("release").click()
        page.wait_until(lambda: page.element("recover").is_displayed())

    def test_recovers_from_a_reflex(self):
        page = self.lead(TOUCHY)
        page.hold_until("r", lambda: page.text("word") == "Reflex")
        self.assertIn("cartesian_reflex", page.text("why"))
        page.wait_until(lambda: page.element("recover").is_displayed())
        page.keep("served_reflex")
        page.element("recover").click()
        page.wait_until(lambda: page.text("leads") == "You lead the arm." or "recovery" in self.events(page))


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    KEEP = keep_folder(sys.argv)
    del sys.argv[1:3]
    unittest.main()
