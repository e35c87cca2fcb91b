#!/usr/bin/env python3
"""A person at the page, played by a browser: page_browser_test.py PROGRAM SOURCE_TREE [--keep FOLDER] [unittest options].

Drives the base, moves the arm, closes the hand and stops, by keys, sticks and buttons. --keep saves what the browser shows.
"""

import csv
import pathlib
import re
import sys
import tempfile
import time
import unittest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

import page_server_test
from browser_page import BrowserPage, keep_folder

KEEP = None
WINDOWS = {"wide": (1440, 900), "laptop": (1440, 757), "small": (1024, 768), "portrait": (390, 844), "landscape": (844, 390)}

# Visible elements with text of their own: the text, and the ratio of contrast between it and what is behind it, by WCAG 2.
CONTRAST = """
const channel = (c) => { c /= 255; return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
const numbers = (colour) => colour.match(/[\\d.]+/g).map(Number);
const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
function behind(element) {
  for (let at = element; at; at = at.parentElement) {
    const [r, g, b, a = 1] = numbers(getComputedStyle(at).backgroundColor);
    if (a === 1) return [r, g, b];
    if (a > 0) throw new Error("a background that shines through");
  }
  return [255, 255, 255];
}
return [...document.querySelectorAll("body *")].filter((element) => element.offsetParent !== null
    && [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())).map((element) => {
  const style = getComputedStyle(element);
  const both = [light(numbers(style.color)), light(behind(element))].sort((a, b) => b - a);
  const size = parseFloat(style.fontSize);
  const isLarge = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
  return { text: element.textContent.trim().slice(0, 40), ratio: (both[0] + 0.05) / (both[1] + 0.05), least: isLarge ? 3 : 4.5 };
});"""

# Elements whose content does not fit them, except those that may scroll or end in an ellipsis.
CLIPPED = """return [...document.querySelectorAll("body *")].filter((element) => element.offsetParent !== null && element.clientWidth > 0
    && element.scrollWidth > element.clientWidth + 1 && getComputedStyle(element).display !== "inline"
    && !element.closest("select, input, .screen, #title, #about, #events, .stick, .track"))
  .map((element) => `${element.tagName} ${element.id} ${element.className}: ${element.textContent.slice(0, 60)}`)"""

# What shows a number, without an explanation of its own or around it.
UNEXPLAINED = """return [...document.querySelectorAll("dd, output, .bar, #clock, #rate")].filter((element) => element.offsetParent !== null
    && !element.closest("[data-tip]")).map((element) => element.outerHTML.slice(0, 100))"""


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
        cls.page = BrowserPage(folder.name, cls.served.url, keep=KEEP)
        cls.addClassCleanup(cls.page.quit)
        cls.page.wait_until(lambda: cls.page.fact("force"))
        cls.sizes = {}

    def odometry_changes(self, way, numbers):
        """A test whether these numbers of the base, of x, y in m and yaw in degrees, have changed by so much from now."""
        before = self.page.numbers("odometry")[numbers]
        return lambda: sum(abs(a - b) for a, b in zip(self.page.numbers("odometry")[numbers], before)) > way

    def picture(self):
        return self.page.run("return document.getElementById('camera').toDataURL()")

    def angles(self):
        """Of the joints, degrees."""
        return self.page.run("return [...document.querySelectorAll('.bar')].map((bar) => parseFloat(bar.children[2].textContent))")

    def rests(self):
        """Whether no joint turns for half a second."""
        before = self.angles()
        time.sleep(0.5)
        return max(abs(now - then) for now, then in zip(self.angles(), before)) < 0.15

    def make_mode(self, mode):
        if self.page.fact("moves").split(",")[0] != mode:  # "arm, holds" as long as nobody has moved a stick
            self.page.element("mode").click()
        self.page.wait_until(lambda: self.page.fact("moves") == mode)

    def take(self):
        self.page.element("take").click()
        self.page.wait_until(lambda: self.page.text("leads").startswith("You lead"))

    def knob(self, stick):
        """Where a stick's knob is from its middle, in pixels to the right and up."""
        return self.page.run("""const middle = (at) => [at.left + at.width / 2, at.top + at.height / 2];
const stick = document.getElementById(arguments[0]);
const [a, b] = [stick, stick.firstElementChild].map((each) => middle(each.getBoundingClientRect()));
return [b[0] - a[0], a[1] - b[1]].map(Math.round)""", stick)

    def look_in_all_windows(self, name):
        """In each window: what fits, what is told in contrast, and where picture and STOP are, which no state changes."""
        for window, (width, height) in WINDOWS.items():
            with self.subTest(name, window=window):
                self.page.resize(width, height)
                self.page.wait_until(lambda: self.page.run("return innerWidth") == width)
                self.page.run("scrollTo(0, 0)")
                self.page.keep(f"{name}_{window}")
                self.assertLessEqual(self.page.run("return document.documentElement.scrollWidth"), width)
                self.assertEqual(self.page.run(CLIPPED), [])
                self.assertEqual([text for text in self.page.run(CONTRAST) if text["ratio"] < text["least"]], [])
                self.assertEqual(self.page.run(UNEXPLAINED), [])
                stop, camera = self.page.box("stop"), self.page.box("camera")
                self.assertGreaterEqual(min(stop[2:]), 40)
                self.assertEqual(self.sizes.setdefault(window, (stop, camera[2:])), (stop, camera[2:]))
                self.page.run("scrollTo(0, document.body.scrollHeight)")
                self.assertEqual(self.page.box("stop"), stop)
        self.page.resize(*WINDOWS["wide"])
        self.page.run("scrollTo(0, 0)")

    def test_1_shows_moving_pictures_and_no_error(self):
        self.page.wait_until(lambda: not self.page.element("no-picture").is_displayed())
        first = self.picture()
        self.page.wait_until(lambda: self.picture() != first)
        self.assertEqual(self.page.severe(), [])

    def test_1_watched_it_fits_all_windows(self):
        self.page.wait_until(lambda: self.page.text("leads") == "No operator.")
        self.look_in_all_windows("watched")

    def test_2_sticks_are_locked_until_control_is_taken(self):
        ActionChains(self.page.browser).click_and_hold(self.page.element("right")).move_by_offset(0, -40).perform()
        self.assertEqual(self.knob("right"), [0, 0])
        ActionChains(self.page.browser).release().perform()

    def test_2_takes_control(self):
        self.take()
        self.assertFalse(self.page.element("tip").is_displayed(), "who has pressed a button has read what it does")
        screen, film = (self.page.run("const at = document.querySelector(arguments[0]).getBoundingClientRect(); return [at.bottom, at.height]", each)
                        for each in (".screen", ".film"))
        self.assertLess(film[0], screen[0] - 0.09 * screen[1], "the buttons leave the picture's time free")
        self.look_in_all_windows("led")

    def test_2_says_when_the_robot_waits_for_an_answer(self):
        arm = {"mode": "Move", "errors": [], "reflex": []}
        now = {"over": None, "lost": None, "welcome": {}, "operates": True, "state": {"arm": arm, "session": "leads", "operator": 1, "paused": False,
               "teleop": {"mode": "arm", "at_border": True, "why": "something blocks the arm"}}}
        for stands, word in ((False, "Move"), (True, "Waits")):
            told = self.page.browser.execute_async_script("import('./status.js').then((module) => arguments[1](module.verdict(arguments[0])))",
                                                          {**now, "stands": stands})
            self.assertEqual(told["word"], word)
            self.assertEqual("blocks" in told["why"], not stands)

    def test_3_second_visitor_only_watches(self):
        with self.served.connect() as other:
            other.say("take")
            self.assertIn("operates; one at a time", other.hear("refused")["text"])
            other.say("press", button="mode")
            self.assertIn("take control first", other.hear("refused")["text"])
        self.assertTrue(self.page.text("leads").startswith("You lead"))

    def test_4_moves_the_arm_by_a_stick(self):
        self.make_mode("arm")
        before = self.page.numbers("z")[0]
        ActionChains(self.page.browser).click_and_hold(self.page.element("right")).move_by_offset(0, -50).perform()
        self.page.wait_until(lambda: self.page.numbers("z")[0] > before + 0.03)
        ActionChains(self.page.browser).release().perform()

    def test_4_sticks_move_under_keys(self):
        self.make_mode("arm")
        for key, stick, way in (("r", "right", [0, 1]), ("q", "right", [-1, 0]), ("d", "left", [1, 0]), (Keys.ARROW_UP, "tilt", [0, 1])):
            with self.subTest(key):
                self.page.hold_until(key, lambda: [(part > 5) - (part < -5) for part in self.knob(stick)] == way)
                self.page.wait_until(lambda: self.knob(stick) == [0, 0])

    def test_4_turns_one_joint_by_its_button_and_by_keys_up_to_a_bound(self):
        self.make_mode("arm")
        self.page.press("j")
        self.page.wait_until(lambda: self.page.element("jog").is_displayed() and not self.page.element("left").is_displayed())
        self.look_in_all_windows("joints")
        buttons = {number: self.page.run("return document.querySelectorAll('#jog .joint')[arguments[0] - 1].lastElementChild", number) for number in (5, 7)}
        self.page.wait_until(lambda: self.page.text("leads").startswith("You lead joint"))
        self.page.wait_until(self.rests)
        before = self.angles()
        ActionChains(self.page.browser).click_and_hold(buttons[5]).perform()
        self.page.wait_until(lambda: self.angles()[4] > before[4] + 5)
        ActionChains(self.page.browser).release().perform()
        self.assertEqual(self.page.text("leads"), "You lead joint 5.")
        self.assertEqual([round(a - b) for i, (a, b) in enumerate(zip(self.angles(), before)) if i != 4], [0] * 6)
        self.page.press(Keys.ARROW_DOWN)
        at_6 = self.angles()[5]
        self.page.hold_until(Keys.ARROW_LEFT, lambda: self.angles()[5] < at_6 - 3)
        self.page.press(Keys.ARROW_UP, Keys.ARROW_UP, *"========")  # joint 4, at full speed
        self.page.hold_until(Keys.ARROW_LEFT, lambda: self.page.text("why").startswith("No further that way"))
        self.page.keep("joint_at_a_bound")
        self.page.press(*"--------", "j")
        self.page.wait_until(lambda: self.page.text("leads") == "You lead the arm.")

    def test_4_keys_change_speed(self):
        self.page.press("-")
        self.page.wait_until(lambda: self.page.text("speed-told") == "55 %")
        self.page.press("=")
        self.page.wait_until(lambda: self.page.text("speed-told") == "60 %")

    def test_5_closes_the_hand(self):
        self.page.element("gripper").click()
        self.page.wait_until(lambda: self.page.element("gripper").text.startswith("Open hand"))

    def test_5_numbers_explain_themselves_to_mouse_and_keyboard(self):
        tip = self.page.element("tip")
        row = self.page.run("return document.querySelector('#facts [data-tip]')")
        ActionChains(self.page.browser).move_to_element(row).perform()
        self.page.wait_until(lambda: tip.text == row.get_attribute("data-tip"))
        self.page.keep("explained")
        ActionChains(self.page.browser).move_to_element(self.page.element("title")).perform()
        self.page.wait_until(lambda: not tip.is_displayed())
        self.page.run("document.getElementById('stop').focus()")
        told = set()

        def tells_of_a_joint():
            self.page.press(Keys.TAB)
            told.add(tip.text)
            return any(text.startswith("Joint 4") for text in told)
        self.page.wait_until(tells_of_a_joint)
        self.page.run("document.activeElement.blur()")

    def test_5_pauses_and_goes_on(self):
        self.page.press("p")
        self.page.wait_for("paused")
        stands = self.page.text("clock")
        self.look_in_all_windows("paused")
        self.assertEqual(self.page.text("clock"), stands)
        self.page.element("pause").click()
        self.page.wait_until(lambda: self.page.text("clock") != stands)
        self.page.wait_for("move")

    def test_5_replays_what_was_and_returns(self):
        self.page.press("b")
        self.page.wait_until(lambda: self.page.element("replayed").is_displayed())
        self.page.element("play").click()
        began = float(self.page.text("clock").split()[0])
        self.look_in_all_windows("replay")
        self.assertEqual(float(self.page.text("clock").split()[0]), began)
        self.page.run("const moment = document.getElementById('moment'); moment.value = moment.max; moment.dispatchEvent(new Event('input'))")
        self.assertGreater(float(self.page.text("clock").split()[0]), began)
        self.page.element("play").click()  # from the begin
        self.page.wait_until(lambda: float(self.page.text("clock").split()[0]) < began + 2)
        self.page.press(" ")  # STOP works, and shows what is now
        self.page.wait_for("stopped")
        self.assertFalse(self.page.element("replayed").is_displayed())
        self.assertGreater(float(self.page.text("clock").split()[0]), began)
        self.page.element("release").click()
        self.page.wait_for("move")

    def test_6_drives_the_base_by_keys(self):
        self.make_mode("base")
        self.page.hold_until("w", self.odometry_changes(0.1, slice(0, 2)))

    def test_6_records_what_is_done_into_a_script(self):
        self.page.element("record").click()
        self.page.wait_until(lambda: self.page.element("record").get_attribute("aria-pressed") == "true")
        self.page.hold_until("a", self.odometry_changes(3, slice(2, 3)))
        self.page.element("record").click()
        self.page.wait_until((self.out / "operator_1.csv").is_file)
        with open(self.out / "operator_1.csv", newline="") as script:
            self.assertTrue(any(float(row[axis]) for row in csv.DictReader(script) for axis in ("x", "y", "z", "rx", "ry", "rz")))

    def test_7_lost_heartbeat_holds(self):
        with self.served.connect() as watcher:
            # As when the network is lost in the middle of a drive: the key is down, and nothing more is sent.
            ActionChains(self.page.browser).key_down("s").perform()
            watcher.hear(lambda message: message["type"] == "state" and abs(message["base"]["v"]) > 0.1)
            self.page.browser.execute_cdp_cmd("Network.enable", {})
            self.page.run("WebSocket.prototype.send = () => {};")
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
        self.page.browser.refresh()
        self.page.wait_until(lambda: self.page.text("leads") == "No operator.")

    def test_8_emergency_stop_by_key_and_release(self):
        self.take()
        self.make_mode("base")
        self.page.element("cameras").click()  # what was touched last must not keep the key
        self.page.press(Keys.ARROW_DOWN, Keys.ENTER)
        began = float(self.page.text("clock").split()[0])
        self.page.press(" ")
        self.page.wait_until(lambda: self.page.fact("moves") == "stopped" and self.page.fact("base") == "emergency stop")
        self.page.wait_for("stopped")
        self.assertTrue(self.page.element("stopped").is_displayed())
        self.assertTrue(self.page.run("return document.title").startswith("Stopped"))
        self.look_in_all_windows("stopped")
        self.check_events(began)
        self.page.element("release").click()
        self.page.wait_until(lambda: self.page.fact("base") != "emergency stop")
        self.page.wait_for("move")
        self.assertFalse(self.page.element("stopped").is_displayed())

    def test_9_tells_that_the_run_is_over(self):
        self.page.element("end").click()
        self.page.wait_for("over")
        self.page.wait_until(lambda: not self.page.element("take").is_displayed())
        self.assertIn("The run failed: object position error", self.page.text("why"))  # the object was not carried
        self.assertIn(str(self.out / "report.html"), self.page.text("report"))
        self.page.keep("over")

    def check_events(self, stop_pressed_after):
        """All events have the clock that the page shows, newest first."""
        lines = self.page.run("return [...document.querySelectorAll('#events li')].map((line) => line.innerText)")
        times = [float(re.match(r"[\d.]+", line)[0]) for line in lines]
        self.assertEqual(times, sorted(times, reverse=True))
        stop = next(time for time, line in zip(times, lines) if "emergency stop" in line)
        self.assertGreaterEqual(stop, stop_pressed_after)
        self.assertLessEqual(stop, float(self.page.text("clock").split()[0]))


if __name__ == "__main__":
    page_server_test.PROGRAM, page_server_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    KEEP = keep_folder(sys.argv)
    del sys.argv[1:3]
    unittest.main()
