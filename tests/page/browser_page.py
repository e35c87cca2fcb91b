"""The operator's page in a real browser: Debian's chromium, chromium-driver and python3-selenium (scripts/setup installs them)."""

import re
import shutil

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from web_client import TIMEOUT

FACT = """const terms = [...document.querySelectorAll("dl dt")];
const term = terms.find((each) => each.textContent === arguments[0] && !each.parentElement.hidden);
return term ? term.nextElementSibling.textContent : null"""


def keep_folder(arguments):
    """The folder after --keep, which is taken out of the arguments; None without it."""
    if "--keep" not in arguments:
        return None
    at = arguments.index("--keep")
    folder = arguments[at + 1]
    del arguments[at:at + 2]
    return folder


class BrowserPage:
    """Waits for states of the page, never for a time. keep: a folder for pictures of what is shown; None: no pictures. before: a script that
    runs before the page's own."""

    def __init__(self, folder, url, width=1440, height=900, keep=None, before=None):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", f"--user-data-dir={folder}/browser"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.browser = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.keep_in = keep
        self.resize(width, height)
        self.browser.set_script_timeout(TIMEOUT)
        if before:
            self.browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": before})
        self.browser.get(url)

    def quit(self):
        self.browser.quit()

    def resize(self, width, height):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                     {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 900})

    def keep(self, name):
        if self.keep_in:
            self.browser.save_screenshot(f"{self.keep_in}/{name}.png")

    def wait_until(self, holds):
        WebDriverWait(self.browser, TIMEOUT, poll_frequency=0.1).until(lambda _: holds())

    def wait_for(self, word):
        """Until the status area says this."""
        self.wait_until(lambda: self.text("word").lower() == word.lower())

    def run(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def element(self, name):
        return self.browser.find_element(By.ID, name)

    def text(self, name):
        return self.run("return document.getElementById(arguments[0]).textContent", name)

    def fact(self, name):
        return self.run(FACT, name)

    def numbers(self, name):
        return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", self.fact(name) or "")]

    def box(self, name):
        """Left, top, width and height in the window."""
        return self.run("const at = document.getElementById(arguments[0]).getBoundingClientRect();"
                        "return [at.left, at.top, at.width, at.height].map(Math.round)", name)

    def press(self, *keys):
        ActionChains(self.browser).send_keys(*keys).perform()

    def hold_until(self, key, holds):
        ActionChains(self.browser).key_down(key).perform()
        self.wait_until(holds)
        ActionChains(self.browser).key_up(key).perform()

    def severe(self):
        """What the browser's console holds of errors."""
        return [entry for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]


