#!/usr/bin/env python3
"""The scene in 3D in a browser: page_scene_test.py PROGRAM SOURCE_TREE [--keep FOLDER] [unittest options].

A client without a browser leads the arm; the browser only looks. --keep saves what the browser shows.
"""

import base64
import pathlib
import sys
import tempfile
import unittest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.by import By

import page_server_test
from browser_page import BrowserPage, keep_folder
from page_browser_test import CLIPPED, CONTRAST, WINDOWS
from web_client import Operator

KEEP = None
SMALL = (720, 450)  # the browser draws by software, each pixel of each picture
RETURNED = 0.03  # share of pixels: a slow browser leaves out shadows from some moment on

# The share of pixels that differ clearly between two pictures of the same size, PNG in base64.
DIFFERENCE = """const [one, other, done] = arguments;
async function pixels(png) {
  const image = new Image();
  image.src = `data:image/png;base64,${png}`;
  await image.decode();
  const canvas = new OffscreenCanvas(image.width, image.height);
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.width, image.height).data;
}
Promise.all([pixels(one), pixels(other)]).then(([a, b]) => {
  let differ = 0;
  for (let i = 0; i < a.length; i += 4) differ += Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 60;
  done(a.length === b.length ? differ / (a.length / 4) : -1);
});"""

# The browser's WebGL says that a graphics processor does it, so that the page begins in 3D.
AS_ON_A_GRAPHICS_PROCESSOR = """const own = WebGL2RenderingContext.prototype.getParameter;
WebGL2RenderingContext.prototype.getParameter = function (name) { return name === 0x9246 ? "a graphics processor" : own.call(this, name); };"""


class PageSceneTest(unittest.TestCase):
    """In this order: nothing asks for a picture before the last test."""

    @classmethod
    def setUpClass(cls):
        if not page_server_test.has_three():
            raise unittest.SkipTest("missing: three.js, which scripts/setup fetches; it is built into the program")
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_", ignore_cleanup_errors=True)
        cls.addClassCleanup(folder.cleanup)
        scenario = pathlib.Path(page_server_test.SOURCE, "models/applications/teleoperation.yaml").read_text()
        cls.served = page_server_test.Run(folder.name, scenario, ["--device", "page"])
        cls.addClassCleanup(cls.served.end)
        cls.page = BrowserPage(folder.name, cls.served.url, *SMALL, keep=KEEP, before=AS_ON_A_GRAPHICS_PROCESSOR)
        cls.addClassCleanup(cls.page.quit)

    def picture(self):
        return base64.b64encode(self.page.browser.find_element(By.CLASS_NAME, "screen").screenshot_as_png).decode()

    def difference(self, one, other):
        return self.page.browser.execute_async_script(DIFFERENCE, one, other)

    def settled(self):
        """A picture that the next one repeats."""
        pictures = [self.picture()]

        def repeats():
            pictures.append(self.picture())
            return self.difference(*pictures[-2:]) < 0.001
        self.page.wait_until(repeats)
        return pictures[-1]

    def changed(self, before, share):
        """The settled picture once this share of `before` has changed."""
        self.page.wait_until(lambda: self.difference(before, self.picture()) > share)
        return self.settled()

    def test_1_begins_in_3d_where_a_graphics_processor_draws(self):
        self.page.wait_until(lambda: self.page.run("return document.getElementById('no-picture').hidden"))
        self.assertEqual(self.page.run("return document.getElementById('cameras').value"), "scene")
        self.assertTrue(self.page.element("scene").is_displayed())
        self.assertEqual(self.page.severe(), [])

    def test_2_shows_the_arm_where_it_is(self):
        at_rest = self.settled()
        self.page.keep("scene_before")

        operator = Operator(self.served.port, self.served.token, of="scene")
        self.addCleanup(operator.client.connection.close)

        def state(holds):
            return lambda message: message["type"] == "state" and message["arm"] and message["teleop"] and holds(message)
        still = operator.lead([0] * 6, state(lambda message: message["operator"] == operator.me and not message["teleop"]["holding"]))
        z = still["arm"]["O_T_EE"][14] + 0.1
        operator.lead([0, 0, 1, 0, 0, 0], state(lambda message: message["arm"]["O_T_EE"][14] > z))
        operator.client.say("give_back")
        self.changed(at_rest, 0.005)
        self.page.keep("scene_after")

    def test_3_mouse_orbits_and_zooms_and_reset_returns(self):
        first = self.settled()
        canvas = self.page.element("scene")
        ActionChains(self.page.browser).drag_and_drop_by_offset(canvas, 150, 30).perform()
        orbited = self.changed(first, 0.1)
        self.page.keep("scene_orbited")
        ActionChains(self.page.browser).scroll_from_origin(ScrollOrigin.from_element(canvas), 0, -400).perform()
        self.changed(orbited, 0.1)
        self.page.keep("scene_zoomed")
        self.assertEqual(self.page.run("return scrollY"), 0)
        self.page.element("reset").click()
        ActionChains(self.page.browser).move_to_element(self.page.element("title")).perform()  # no explanation covers the view
        self.page.wait_until(lambda: self.difference(first, self.picture()) < RETURNED)

    def test_4_keys_orbit_and_zoom_and_reset(self):
        first = self.settled()
        turn = ("for (let i = 0; i < 6; ++i) window.dispatchEvent(Object.defineProperty("
                "new KeyboardEvent('keydown', { code: arguments[0], ctrlKey: arguments[1] }), 'target', { value: document.body }))")
        self.page.run(turn, "ArrowRight", True)
        orbited = self.changed(first, 0.1)
        self.page.run(turn, "Period", False)
        self.changed(orbited, 0.1)
        self.page.press("0")
        self.page.wait_until(lambda: self.difference(first, self.picture()) < RETURNED)

    def test_5_fingers_orbit_and_zoom_and_do_not_scroll(self):
        self.page.resize(*WINDOWS["portrait"])
        self.page.wait_until(lambda: self.page.run("return innerWidth") == WINDOWS["portrait"][0])
        before = self.settled()
        left, top, width, height = self.page.box("scene")
        x, y = left + width / 2, top + height / 2
        self.touch([[(x + 40 - 10 * i, y + i)] for i in range(9)])
        turned = self.changed(before, 0.05)
        self.touch([[(x - 20 - 5 * i, y), (x + 20 + 5 * i, y)] for i in range(9)])
        self.changed(turned, 0.05)
        self.assertEqual(self.page.run("return [scrollX, scrollY, visualViewport.scale]"), [0, 0, 1])
        self.page.element("reset").click()
        self.page.resize(*SMALL)

    def touch(self, steps):
        def say(kind, points):
            self.page.browser.execute_cdp_cmd("Input.dispatchTouchEvent", {
                "type": kind, "touchPoints": [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]})
        say("touchStart", steps[0])
        for points in steps[1:]:
            say("touchMove", points)
        say("touchEnd", [])

    def test_6_fits_all_windows(self):
        for window, (width, height) in WINDOWS.items():
            with self.subTest(window):
                self.page.resize(width, height)
                self.page.wait_until(lambda: self.page.run("return innerWidth") == width)
                if KEEP:
                    self.settled()
                    self.page.keep(f"scene_{window}")
                self.assertEqual(self.page.run(CLIPPED), [])
                self.assertEqual([text for text in self.page.run(CONTRAST) if text["ratio"] < text["least"]], [])
                self.assertEqual(self.page.box("scene"), self.page.box("camera"))
                self.assertGreaterEqual(min(self.page.box("reset")[2:]), 38)
        self.page.resize(*SMALL)

    def rasterizers(self):
        """The threads of panda-twin that Mesa draws with."""
        tasks = pathlib.Path(f"/proc/{self.served.process.pid}/task").iterdir()
        return [name for task in tasks if (name := (task / "comm").read_text().strip()).startswith("llvmpipe")]

    def test_7_panda_twin_has_drawn_nothing_until_a_picture_is_wanted(self):
        self.assertEqual(self.rasterizers(), [])
        self.page.press("2")
        self.page.wait_until(lambda: self.page.run("return !document.getElementById('rate').hidden"))
        self.page.wait_until(lambda: self.page.run("return document.getElementById('cameras').value") == "1")
        self.assertFalse(self.page.element("scene").is_displayed())
        self.assertFalse(self.page.element("reset").is_displayed())
        self.assertNotEqual(self.rasterizers(), [])
        self.assertEqual(self.page.severe(), [])


if __name__ == "__main__":
    page_server_test.PROGRAM, page_server_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    KEEP = keep_folder(sys.argv)
    del sys.argv[1:3]
    unittest.main()
