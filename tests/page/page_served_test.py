#!/usr/bin/env python3
"""A person moves a served robot from its page: page_served_test.py PROGRAM SOURCE_TREE [unittest options].

On the wall clock. A machine that does not keep time may end a motion; then control is taken anew, as a person would.
"""

import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import page_server_test
from web_client import TIMEOUT, Operator, WebSocket

PROGRAM = ""
SOURCE = pathlib.Path()
LED = """name: led
robot: {q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}}
operator: {device: page}
application: {type: teleoperation}
record: false
"""


def two_free_ports():
    """The first of two in a row: clients look for the hand behind the arm."""
    for port in range(23337, 23537, 2):
        try:
            with socket.create_server(("127.0.0.1", port)), socket.create_server(("127.0.0.1", port + 1)):
                return port
        except OSError:
            pass
    raise AssertionError("no two free ports")


def address_elsewhere():
    """An address of this machine that is not the loopback's; empty: it has none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        try:
            asking.connect(("192.0.2.1", 9))  # nothing is sent: only the way there is asked for
            address = asking.getsockname()[0]
        except OSError:
            return ""
    return "" if address.startswith("127.") else address


class PersistentOperator(Operator):
    """Ends a session in which the arm does not move, as a person would."""

    def lead_arm(self, axes, until):
        """Holds these axes until the arm fits; the arm."""
        def fits(message):
            if message["type"] != "state" or not message["arm"]:
                return False
            if until(message["arm"]):
                return True
            if message["arm"]["mode"] in ("Reflex", "Idle") and message["operator"] == self.me and self.waits_too_long():
                self.client.say("give_back")
            return False
        return self.lead(axes, fits)["arm"]

    def waits_too_long(self):
        """Whether the arm has stood outside a motion for seconds: the session has ended, or never began."""
        now = time.monotonic()
        if now - getattr(self, "last_asked", 0) > 0.5:
            self.standing_since = now
        self.last_asked = now
        if now - self.standing_since < 4:
            return False
        self.standing_since = now
        return True


class PageServedTest(unittest.TestCase):
    flags = ("--drive", "realtime")

    def setUp(self):
        self.process = subprocess.Popen(
            [PROGRAM, "serve", *self.flags, "--page=0", "--port", "0", "--hand-port", "0", "--data", SOURCE / "models"],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(self.end)
        for line in self.process.stdout:
            if match := re.search(r"http://127\.0\.0\.1:(\d+)/#token=([0-9a-f]{32})", line):
                self.operator = PersistentOperator(int(match[1]), match[2])
                self.addCleanup(self.operator.client.connection.close)
                self.where = (int(match[1]), match[2])
                return
        self.fail("no page")

    def end(self):
        self.process.terminate()
        self.process.communicate(timeout=TIMEOUT)

    def test_moves_stops_and_goes_on(self):
        operator = self.operator
        # A key that is held from before the robot is led has to be let go first.
        begin = operator.lead_arm([0, 0, 1, 0, 0, 0], lambda arm: arm["mode"] == "Move")["O_T_EE"]
        operator.lead_arm([0, 0, 1, 0, 0, 0], lambda arm: arm["O_T_EE"][14] > begin[14] + 0.02)

        # Anyone may stop: here one who only watches.
        watcher = Operator(*self.where)
        self.addCleanup(watcher.client.connection.close)
        watcher.client.say("stop")
        operator.lead_arm([0] * 6, lambda arm: arm["mode"] == "User stopped")

        operator.client.say("press", button="release")
        operator.lead_arm([0] * 6, lambda arm: arm["mode"] in ("Idle", "Reflex"))
        operator.client.say("give_back")
        stopped = operator.lead_arm([0] * 6, lambda arm: arm["mode"] == "Move")["O_T_EE"]
        operator.lead_arm([0, 0, -1, 0, 0, 0], lambda arm: arm["O_T_EE"][14] < stopped[14] - 0.02)


class PageServedAtAnotherAddressTest(PageServedTest):
    """The page leads the robot of its own server, not one that answers at the same port of 127.0.0.1."""
    flags = ("--drive", "realtime", "--bind", "127.0.0.5")


class PageServedAtItsPaceTest(PageServedTest):
    flags = ("--drive", "lockstep", "--pace", "1")

    def test_a_pause_ends_no_session(self):
        operator = self.operator

        def state(fits):
            def holds(message):
                self.assertNotEqual((message["type"], message.get("kind")), ("event", "error"), message.get("text"))
                return message["type"] == "state" and message["arm"] and fits(message)
            return holds
        begin = operator.lead([0] * 6, state(lambda message: message["teleop"] and message["arm"]["mode"] == "Move"))["arm"]
        operator.client.say("pause", on=True)
        operator.lead([0] * 6, state(lambda message: message["paused"]))
        until = time.monotonic() + 3  # s; longer than a robot may be silent
        operator.lead([0] * 6, state(lambda message: time.monotonic() > until))
        operator.client.say("pause", on=False)
        operator.lead([0, 0, 1, 0, 0, 0], state(lambda message: message["arm"]["O_T_EE"][14] > begin["O_T_EE"][14] + 0.02))


class PageOverAMovableBoxTest(PageServedTest):
    """The hand presses onto a box of 0.1 kg and pushes: where the box gives way, the hand must not strike the table."""
    flags = ("scenarios/grasp.yaml", "--drive", "lockstep", "--pace", "1")

    def test_moves_stops_and_goes_on(self):
        def held(axes, seconds):
            begun = []

            def is_over(message):
                if message["type"] != "state" or not message["arm"]:
                    return False
                self.assertEqual(message["arm"]["reflex"], [])
                begun.append(message["t"])
                return message["t"] > begun[0] + seconds
            return self.operator.lead(axes, is_over)["arm"]["O_T_EE"]
        self.operator.lead_arm([0] * 6, lambda arm: arm["mode"] == "Move")
        self.assertLess(held([0, 0, -0.6, 0, 0, 0], 8)[14], 0.36)
        held([0.6, 0, 0, 0, 0, 0], 4)


class PagesOfTwoRobotsTest(unittest.TestCase):
    """Two robots of one scene have a page each, and each page leads its own."""

    def test_each_leads_its_own(self):
        process = subprocess.Popen([PROGRAM, "serve", SOURCE / "tests/clients/two_arms.yaml", "--drive", "lockstep", "--pace", "1", "--page=0",
                                    "--port", "0", "--hand-port", "0", "--bind", "127.0.0.7", "--data", SOURCE / "models"],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

        def end():
            process.terminate()
            process.communicate(timeout=TIMEOUT)
        self.addCleanup(end)
        operators = {}
        for line in process.stdout:
            if match := re.match(r"(left|right): page +http://127\.0\.0\.1:(\d+)/#token=([0-9a-f]{32})", line):
                operators[match[1]] = PersistentOperator(int(match[2]), match[3])
                self.addCleanup(operators[match[1]].client.connection.close)
                if len(operators) == 2:
                    break
        state = {name: operator.lead([0] * 6, lambda message: message["type"] == "state" and message["arm"])["arm"]
                 for name, operator in operators.items()}
        begin = operators["right"].lead_arm([0] * 6, lambda arm: arm["mode"] == "Move")["O_T_EE"]
        operators["right"].lead_arm([0, 0, 1, 0, 0, 0], lambda arm: arm["O_T_EE"][14] > begin[14] + 0.02)
        stays = operators["left"].lead([0] * 6, lambda message: message["type"] == "state" and message["arm"])["arm"]
        self.assertEqual(stays["mode"], "Idle")
        self.assertLess(max(abs(a - b) for a, b in zip(stays["O_T_EE"], state["left"]["O_T_EE"])), 1e-3)
        # A way home is planned beside the other arm.
        operators["right"].client.say("home")
        sessions = []

        def is_home(message):
            if message["type"] == "state":
                sessions.append(message["session"])
            return "goes home" in sessions and sessions[-1] == "leads"
        home = operators["right"].lead([0] * 6, is_home)["arm"]
        self.assertLess(max(abs(a - b) for a, b in zip(home["O_T_EE"], begin)), 5e-3)


class StartsPrograms(unittest.TestCase):
    def start(self, *args):
        process = subprocess.Popen([PROGRAM, *args, "--data", SOURCE / "models"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

        def end():
            process.kill()
            process.communicate(timeout=TIMEOUT)
        self.addCleanup(end)
        return process


class PageElsewhereTest(StartsPrograms):
    """A twin at another address than this machine's loopback. Who may lead a real arm is hardware_test.py's."""

    def setUp(self):
        self.address = address_elsewhere()
        if not self.address:
            self.skipTest("this machine has no address but the loopback's")
        self.port = two_free_ports()
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "led.yaml").write_text(LED)
        server = self.start("serve", "--bind", self.address, "--allow", f"{self.address}/32", "--port", str(self.port), "--hand-port",
                            str(self.port + 1), "--drive", "lockstep")
        for line in server.stdout:
            if "open to" in line:
                break

    def refusal(self):
        """What an operator is told who takes control of it; None: it is given."""
        run = self.start("run", str(self.folder / "led.yaml"), "--backend", "fci", "--robot", f"{self.address}:{self.port}", "--robot-time",
                         "states", "--device", "page", "--page=0", "--out", str(self.folder / "out"))
        said = ""
        for line in run.stdout:
            said += line
            if match := re.search(r"http://127\.0\.0\.1:(\d+)/#token=([0-9a-f]{32})", line):
                with WebSocket(int(match[1])) as client:
                    client.say("hello", token=match[2])
                    return client.hear("welcome")["watch_only"]
        self.fail(said)

    def test_is_led(self):
        self.assertEqual(self.refusal(), "")


@unittest.skipUnless(page_server_test.has_three(), "missing: three.js, which scripts/setup fetches; it is built into the program")
class PageOfARobotThatIsNotSimulatedTest(StartsPrograms):
    """The page of a run whose robot is at the other end of a wire: it knows joint angles, not where bodies are."""

    def scene_and_poses(self, folder, *flags):
        """What the page says of the scene, and the poses of all bodies, seven numbers each."""
        path = pathlib.Path(folder, "still.yaml")
        path.write_text(page_server_test.SCENARIO)
        run = self.start("run", path, "--page=0", "--no-video", "--out", pathlib.Path(folder, "out"), *flags)
        said = ""
        for line in run.stdout:
            said += line
            if match := re.search(r"http://127\.0\.0\.1:(\d+)/#token=([0-9a-f]{32})", line):
                with WebSocket(int(match[1])) as client:
                    client.say("hello", token=match[2], of="scene")
                    scene = client.hear("welcome")["scene"]
                    return scene, client.hear("poses")["bodies"]
        self.fail(said)

    def test_shows_the_arm_where_its_joints_are_measured(self):
        port = two_free_ports()
        server = self.start("serve", "--port", str(port), "--hand-port", str(port + 1), "--drive", "lockstep")
        for line in server.stdout:
            if "open to" in line or str(port) in line:
                break
        with tempfile.TemporaryDirectory(prefix="panda_twin_page_") as folder:
            wired, measured = self.scene_and_poses(folder, "--backend", "fci", "--robot", f"127.0.0.1:{port}", "--robot-time", "states")
        with tempfile.TemporaryDirectory(prefix="panda_twin_page_") as folder:
            simulated, true = self.scene_and_poses(folder)
        self.assertIn("where the robot measures them", wired["note"])
        self.assertEqual(simulated["note"], "")
        self.assertEqual(wired["path"], simulated["path"])  # the same shapes
        self.assertEqual(len(measured), len(true))
        self.assertLess(max(abs(a - b) for a, b in zip(measured, true)), 0.002)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    del sys.argv[1:3]
    unittest.main()
