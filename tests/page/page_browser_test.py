#!/usr/bin/env python3
"""A person at the page, played by a browser: page_browser_test.py PROGRAM SOURCE_TREE [--keep FOLDER] [unittest options].

Drives the base, moves the arm, closes the hand and stops, by keys, sticks and buttons. Needs Debian's chromium, chromium-driver and
python3-selenium (scripts/setup installs them). --keep saves what the browser shows.
"""

import csv
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

import page_server_test
from web_client import TIMEOUT

KEEP = None
FACT = """const terms = [...document.querySelectorAll("#facts dt")];
const term = terms.find((each) => each.textContent === arguments[0]);
return term ? term.nextElementSibling.textContent : null"""


def start_browser(folder, name, width, height):
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", f"--window-size={width},{height}",
                 f"--user-data-dir={folder}/{name}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)


class PageBrowserTest(unittest.TestCase):
    """One person's session from connecting to the emergency stop, in this order; another one watches."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_", ignore_cleanup_errors=True)
        cls.addClassCleanup(folder.cleanup)
        source = page_server_test.SOURCE
        cls.served = page_server_test.Run(folder.name, (source / "models/applications/teleoperation.yaml").read_text(),
                                          ["--device", "page"])
        cls.addClassCleanup(cls.served.end)
        cls.out = pathlib.Path(folder.name, "out")
        cls.browser = start_browser(folder.name, "operator", 1280, 1000)
        cls.addClassCleanup(cls.browser.quit)
        cls.browser.get(cls.served.url)
        cls.wait_until(lambda: cls.fact("robot") == "Move")

    @classmethod
    def wait_until(cls, holds):
        WebDriverWait(cls.browser, TIMEOUT, poll_frequency=0.1).until(lambda _: holds())

    @classmethod
    def fact(cls, name):
        return cls.browser.execute_script(FACT, name)

    def numbers(self, name):
        return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", self.fact(name))]

    def element(self, name):
        return self.browser.find_element(By.ID, name)

    def hold_until(self, key, holds):
        ActionChains(self.browser).key_down(key).perform()
        self.wait_until(holds)
        ActionChains(self.browser).key_up(key).perform()

    def odometry_changes(self, way, numbers):
        """A test whether these numbers of the base, of x, y in m and yaw in degrees, have changed by so much from now."""
        before = self.numbers("odometry")[numbers]
        return lambda: sum(abs(a - b) for a, b in zip(self.numbers("odometry")[numbers], before)) > way

    def picture(self):
        return self.browser.execute_script("return document.getElementById('camera').toDataURL()")

    def keep(self, name):
        if KEEP:
            self.browser.save_screenshot(f"{KEEP}/{name}.png")

    def make_mode(self, mode):
        if self.fact("moves").split(",")[0] != mode:  # "arm, holds" as long as nobody has moved a stick
            self.element("mode").click()
        self.wait_until(lambda: self.fact("moves") == mode)

    def test_1_shows_moving_pictures_and_no_error(self):
        self.wait_until(lambda: not self.element("no-picture").is_displayed())
        first = self.picture()
        self.wait_until(lambda: self.picture() != first)
        self.assertEqual([entry for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"], [])

    def test_2_takes_control(self):
        self.element("take").click()
        self.wait_until(lambda: self.element("role").text == "you operate")

    def test_3_second_visitor_only_watches(self):
        with self.served.connect() as other:
            other.say("take")
            self.assertIn("operates; one at a time", other.hear("refused")["text"])
            other.say("press", button="mode")
            self.assertIn("take control first", other.hear("refused")["text"])
        self.assertEqual(self.element("role").text, "you operate")

    def test_4_moves_the_arm_by_a_stick(self):
        self.make_mode("arm")
        before = self.numbers("end effector")
        stick = self.element("right")
        ActionChains(self.browser).click_and_hold(stick).move_by_offset(0, -60).perform()
        self.wait_until(lambda: self.numbers("end effector")[2] > before[2] + 0.03)
        ActionChains(self.browser).release().perform()

    def test_5_closes_the_hand(self):
        self.element("gripper").click()
        self.wait_until(lambda: self.element("gripper").text.startswith("Open hand"))

    def test_6_drives_the_base_by_keys(self):
        self.make_mode("base")
        self.hold_until("w", self.odometry_changes(0.1, slice(0, 2)))
        self.keep("desk")

    def test_6_records_what_is_done_into_a_script(self):
        self.element("record").click()
        self.wait_until(lambda: self.element("record").get_attribute("aria-pressed") == "true")
        self.hold_until("a", self.odometry_changes(3, slice(2, 3)))
        self.element("record").click()
        self.wait_until((self.out / "operator_1.csv").is_file)
        with open(self.out / "operator_1.csv", newline="") as script:
            self.assertTrue(any(float(row[axis]) for row in csv.DictReader(script) for axis in ("x", "y", "z", "rx", "ry", "rz")))

    def test_7_lost_heartbeat_holds(self):
        with self.served.connect() as watcher:
            # As when the network is lost in the middle of a drive: the key is down, and nothing more is sent.
            ActionChains(self.browser).key_down("s").perform()
            watcher.hear(lambda message: message["type"] == "state" and abs(message["base"]["v"]) > 0.1)
            self.browser.execute_cdp_cmd("Network.enable", {})
            self.browser.execute_script("WebSocket.prototype.send = () => {};")
            led = 0.0  # until when: a machine that held the browser up had it hold before

            def rests(message):
                nonlocal led
                if message["type"] != "state":
                    return False
                if not message["teleop"]["holding"]:
                    led = message["t"]
                return message["teleop"]["holding"] and abs(message["base"]["v"]) < 0.01
            self.assertLess(watcher.hear(rests)["t"] - led, 2.0)
            watcher.hear(lambda message: message["type"] == "event" and "nothing was heard" in message["text"])
        self.browser.refresh()
        self.wait_until(lambda: self.element("role").text == "watching")

    def test_8_emergency_stop_by_key_and_release(self):
        self.element("take").click()
        self.wait_until(lambda: self.element("role").text == "you operate")
        self.make_mode("base")
        self.element("cameras").click()  # what was touched last must not keep the key
        ActionChains(self.browser).send_keys(Keys.ARROW_DOWN, Keys.ENTER).perform()
        ActionChains(self.browser).send_keys(" ").perform()
        self.wait_until(lambda: self.fact("moves") == "stopped" and self.fact("base") == "emergency stop")
        self.keep("stopped")
        self.element("release").click()
        self.wait_until(lambda: self.fact("base") != "emergency stop")

    def test_9_fits_a_phone(self):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                     {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True})
        self.wait_until(lambda: self.browser.execute_script("return document.documentElement.scrollWidth") <= 390)
        self.keep("phone")
        self.assertTrue(self.element("stop").is_displayed())


if __name__ == "__main__":
    page_server_test.PROGRAM, page_server_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    if "--keep" in sys.argv:
        at = sys.argv.index("--keep")
        KEEP = sys.argv[at + 1]
        del sys.argv[at:at + 2]
    del sys.argv[1:3]
    unittest.main()
