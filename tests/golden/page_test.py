#!/usr/bin/env python3
"""Opens the page of the video regression in a browser: page_test.py PROGRAM SOURCE_TREE [--keep FILE.png] [unittest options].

Needs Debian's chromium, chromium-driver and python3-selenium (scripts/setup installs them). --keep saves what the browser shows.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

PROGRAM = ""
SOURCE = pathlib.Path()
KEEP = None
CASE = """scenario: scenarios/smoke.yaml
every: 5
key_frames: 3
views:
  overview: {camera: {azimuth: 142 deg}}
  hand: {camera: {track: panda_hand, distance: 0.5 m}, overlays: []}
"""


def make_page(folder):
    """A page of a case that is approved, and then seen from elsewhere."""
    (folder / "cases").mkdir()
    case = folder / "cases/small.yaml"
    common = ["--goldens", folder / "cases", "--data", SOURCE / "models", "--out", folder / "out"]
    case.write_text(CASE)
    subprocess.run([PROGRAM, "video", "approve", "small", "--reason", "made for a test", *common], check=True,
                   capture_output=True, timeout=100)
    case.write_text(CASE.replace("142", "146"))
    subprocess.run([PROGRAM, "video", "report", *common], check=True, capture_output=True, timeout=100)
    return folder / "out/report.html"


def start_browser(folder):
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--window-size=1200,1500",
                 f"--user-data-dir={folder}/profile"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)


class PageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_", ignore_cleanup_errors=True)
        cls.addClassCleanup(folder.cleanup)
        page = make_page(pathlib.Path(folder.name))
        cls.browser = start_browser(folder.name)
        cls.addClassCleanup(cls.browser.quit)
        cls.page = page.as_uri()

    def setUp(self):
        self.browser.get(self.page)
        WebDriverWait(self.browser, 30).until(lambda b: b.find_elements(By.CSS_SELECTOR, "section.case[data-ready]"))
        self.slider = self.browser.find_element(By.CSS_SELECTOR, "input[type=range]")

    def pixels(self, number):
        """A panel's picture, as the browser would save it."""
        return self.browser.execute_script("return document.querySelectorAll('canvas')[arguments[0]].toDataURL()", number)

    def captions(self):
        return [caption.text for caption in self.browser.find_elements(By.CSS_SELECTOR, ".panels figcaption")][:2]

    def where(self):
        return self.browser.find_element(By.CSS_SELECTOR, ".where").text

    def move_mouse_to(self, selector):
        ActionChains(self.browser).move_to_element(self.browser.find_element(By.CSS_SELECTOR, selector)).perform()

    def test_shows_what_differs_first_and_no_error(self):
        self.assertRegex(self.where(), r"^frame 0 of \d+, 0.00 s, key picture$")
        self.assertNotEqual(self.pixels(0), self.pixels(1))
        self.assertEqual([entry for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"], [])
        if KEEP:
            self.browser.save_screenshot(KEEP)

    def test_slider_shows_every_frame_small_or_whole(self):
        first = self.pixels(0)
        self.slider.send_keys(Keys.ARROW_RIGHT)
        self.assertRegex(self.where(), r"^frame 1 of \d+, 0.20 s, small picture$")
        self.assertNotEqual(self.pixels(0), first)
        self.slider.send_keys(Keys.END)
        number, count = map(int, re.match(r"frame (\d+) of (\d+)", self.where()).groups())
        self.assertEqual(number + 1, count)
        self.assertIn("key picture", self.where())

    def test_expected_and_actual_change_places_under_the_mouse(self):
        self.move_mouse_to("h1")
        expected, actual, difference = (self.pixels(i) for i in range(3))
        self.assertEqual(self.captions(), ["expected", "actual"])
        self.move_mouse_to("canvas")
        self.assertEqual(self.captions(), ["actual", "expected"])
        self.assertEqual((self.pixels(0), self.pixels(1), self.pixels(2)), (actual, expected, difference))
        self.move_mouse_to("h1")
        self.assertEqual((self.pixels(0), self.pixels(1)), (expected, actual))

    def test_difference_is_black_where_nothing_differs(self):
        count = "const c = document.querySelectorAll('canvas')[2]; const d = c.getContext('2d').getImageData(0, 0, " \
                "c.width, c.height).data; return d.filter((v, i) => i % 4 < 3 && v > 0).length"
        self.assertGreater(self.browser.execute_script(count), 1000)
        self.browser.find_elements(By.CSS_SELECTOR, "button.view")[1].click()  # that view was not changed
        self.assertEqual(self.browser.execute_script(count), 0)
        self.assertEqual(self.pixels(0), self.pixels(1))

    def test_buttons_go_from_key_picture_to_key_picture(self):
        self.browser.find_element(By.CSS_SELECTOR, "button.next").click()
        self.assertIn("key picture", self.where())
        middle = int(self.slider.get_property("value"))
        self.assertGreater(middle, 1)
        self.browser.find_element(By.CSS_SELECTOR, "button.previous").click()
        self.assertEqual(self.slider.get_property("value"), "0")

    def test_plot_marks_the_frame_and_takes_one_by_a_click(self):
        mark = "return Number(document.querySelector('line.mark').getAttribute('x1'))"
        curves = self.browser.execute_script("return document.querySelectorAll('.joints svg path').length")
        self.assertGreater(curves, 14)
        left = self.browser.execute_script(mark)
        self.slider.send_keys(Keys.END)
        right = self.browser.execute_script(mark)
        self.assertGreater(right, left + 300)
        svg = self.browser.find_element(By.CSS_SELECTOR, ".joints svg")
        ActionChains(self.browser).move_to_element(svg).click().perform()  # its middle
        width = self.browser.execute_script("return document.querySelector('.joints svg').viewBox.baseVal.width")
        self.assertLess(abs(self.browser.execute_script(mark) - width / 2), 40)
        self.assertNotIn(self.slider.get_property("value"), ("0", self.slider.get_property("max")))


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    rest = sys.argv[3:]
    if rest[:1] == ["--keep"]:
        KEEP, rest = rest[1], rest[2:]
    unittest.main(argv=[sys.argv[0], *rest])
