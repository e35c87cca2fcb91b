#!/usr/bin/env python3
"""Talks to the page of a run over sockets, well and badly: page_server_test.py PROGRAM SOURCE_TREE [unittest options]."""

import json
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from web_client import TIMEOUT, PING, TEXT, Operator, Refused, WebSocket, http

PROGRAM = ""
SOURCE = pathlib.Path()
# An arm that holds still for ten minutes; the tests end it.
SCENARIO = """name: page
motion:
  trajectory:
    unit: rad
    waypoints:
      - {at: 0 s, q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {at: 600 s, q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
record: false
"""


def has_three():
    """Whether the 3D view can be built into the program. Asked before the tests know their tree: from this file's."""
    return (pathlib.Path(__file__).resolve().parents[2] / ".data/three/version").is_file()


class Run:
    """A run whose page is served at a free port."""

    def __init__(self, folder, scenario=SCENARIO, flags=()):
        path = pathlib.Path(folder, "page.yaml")
        path.write_text(scenario)
        self.process = subprocess.Popen(
            [PROGRAM, "run", path, "--page=0", "--no-video", "--out", pathlib.Path(folder, "out"), "--data", SOURCE / "models",
             *flags], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.said = ""
        for line in self.process.stdout:
            self.said += line
            if match := re.search(r"http://127\.0\.0\.1:(\d+)/#token=([0-9a-f]{32})", line):
                self.url, self.port, self.token = match[0], int(match[1]), match[2]
                return
        raise AssertionError(f"no page: {self.said}")

    def end(self):
        self.process.terminate()
        try:
            self.said += self.process.communicate(timeout=TIMEOUT)[0]
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise

    def connect(self, token=None):
        client = WebSocket(self.port)
        client.say("hello", token=token or self.token)
        return client


class PageServerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_")
        cls.addClassCleanup(folder.cleanup)
        cls.served = Run(folder.name)
        cls.addClassCleanup(cls.served.end)
        cls.port = cls.served.port

    def get(self, path, host=None, more=()):
        return http(self.port, [f"GET {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{self.port}'}", "Connection: close", *more])

    def assert_lives(self):
        with self.served.connect() as client:
            client.hear("state")

    def test_page_comes_with_headers_that_lock_it_in(self):
        status, head, body = self.get("/")
        self.assertEqual(status, 200)
        self.assertIn(b"<title>panda-twin</title>", body)
        for line in ("Cache-Control: no-store", "X-Content-Type-Options: nosniff", "X-Frame-Options: DENY", "default-src 'none'",
                     "script-src 'self'", "frame-ancestors 'none'"):
            self.assertIn(line, head)
        self.assertNotIn("unsafe", head)

    def test_page_holds_no_script_and_no_style_of_its_own(self):
        body = self.get("/")[2].decode()
        self.assertNotRegex(body, r"<script(?![^>]*\bsrc=)|<style|\sstyle=|\son\w+=")

    def test_nothing_else_is_served(self):
        for path in ("/../CMakeLists.txt", "/page.js?x", "/etc/passwd", "/%2e%2e/", "/wss"):
            self.assertEqual(self.get(path)[0], 404, path)
        self.assertEqual(http(self.port, ["POST / HTTP/1.1", f"Host: 127.0.0.1:{self.port}", "Content-Length: 0"])[0], 405)

    def test_a_name_that_resolves_to_us_is_not_us(self):
        for host in ("evil.example", f"evil.example:{self.port}", f"127.0.0.1:{self.port + 1}"):
            self.assertEqual(self.get("/", host=host)[0], 421, host)
            with self.assertRaises(Refused) as refused:
                WebSocket(self.port, host=host)
            self.assertEqual(refused.exception.args, (421,))

    def test_pages_from_elsewhere_get_no_socket(self):
        for origin in ("http://evil.example", "null", f"http://127.0.0.1:{self.port + 1}", f"https://127.0.0.1:{self.port}", ""):
            with self.assertRaises(Refused) as refused:
                WebSocket(self.port, origin=origin)
            self.assertEqual(refused.exception.args, (403,))

    def test_wrong_token_is_sent_away(self):
        with self.served.connect(token="0" * 32) as client:
            self.assertEqual(client.closing(), "wrong token")

    def test_who_says_nothing_is_sent_away(self):
        with WebSocket(self.port) as client:
            self.assertEqual(client.closing(), "no token came")

    def test_client_is_told_what_is(self):
        with self.served.connect() as client:
            welcome = client.hear("welcome")
            self.assertEqual(welcome["title"], "page")
            self.assertEqual(len(welcome["limits"]["q_max"]), 7)
            first = client.hear(lambda message: message["type"] == "state" and message["arm"])
            later = client.hear(lambda message: message["type"] == "state" and message["t"] > first["t"] + 0.1)
            self.assertEqual(later["arm"]["mode"], "Move")
            self.assertGreater(later["arm"]["margin"], 0)
            self.assertEqual(later["arm"]["held"], 0)

    def test_run_on_a_virtual_clock_goes_at_the_walls_pace(self):
        begin = time.monotonic()  # before any state can have been sent: what is heard may have waited
        with self.served.connect() as client:
            first = client.hear(lambda message: message["type"] == "state" and message["arm"])
            later = client.hear(lambda message: message["type"] == "state" and message["t"] > first["t"] + 1)
            self.assertLessEqual(later["t"] - first["t"], time.monotonic() - begin + 0.3)

    def test_a_picture_comes_and_the_next_when_it_was_shown(self):
        with self.served.connect() as client:
            picture = client.picture()
            self.assertEqual((picture[:3], picture[-2:]), (b"\xff\xd8\xff", b"\xff\xd9"))  # as a JPEG begins and ends
            client.say("shown")
            self.assertEqual(client.picture()[:3], b"\xff\xd8\xff")

    def scene(self, more=None):
        """The request for the scene's file, with its token unless `more` is given, and the answer."""
        with self.served.connect() as client:
            path = client.hear("welcome")["scene"]["path"]
        return path, self.get(path, more=more if more is not None else (f"Authorization: Bearer {self.served.token}",))

    @unittest.skipUnless(has_three(), "missing: three.js, which scripts/setup fetches; it is built into the program")
    def test_the_scenes_file_is_there_for_who_has_the_token(self):
        path, (status, head, body) = self.scene()
        self.assertEqual(status, 200)
        self.assertRegex(path, r"^/scene/[0-9a-f]{16}$")
        for line in ("Cache-Control: private, max-age=31536000, immutable", "X-Content-Type-Options: nosniff",
                     "Cross-Origin-Resource-Policy: same-origin"):
            self.assertIn(line, head)
        length = int.from_bytes(body[:4], "little")
        scene = json.loads(body[4:4 + length])
        self.assertGreater(len(scene["geoms"]), 10)
        ends = [mesh["at"] + 24 * mesh["vertices"] + 12 * mesh["faces"] for mesh in scene["meshes"]]
        ends += [texture["at"] + 3 * texture["width"] * texture["height"] for texture in scene["textures"]]
        self.assertLess(len(body) - 4 - length - max(ends, default=0), 4)

    @unittest.skipUnless(has_three(), "missing: three.js, which scripts/setup fetches; it is built into the program")
    def test_the_scenes_file_is_for_nobody_else(self):
        good = f"Authorization: Bearer {self.served.token}"
        for more in ((), ("Authorization: Bearer ",), (f"Authorization: Bearer {'0' * 32}",), (f"Authorization: Basic {self.served.token}",),
                     (f"Authorization: {self.served.token}",), (good + "0",), (good, good)):
            path, (status, head, body) = self.scene(more)
            self.assertEqual((status, body[:9]), (401, b"The token"), more)
            self.assertIn("Cache-Control: no-store", head)
        for wrong in (path + "0", path[:-1], path + "?x", "/scene/", "/scene/../" + path, "/scene/" + "0" * 16):
            self.assertEqual(self.get(wrong, more=(good,))[0], 404, wrong)
        self.assertEqual(self.get(path, host="evil.example", more=(good,))[0], 421)
        self.assertEqual(http(self.port, [f"OPTIONS {path} HTTP/1.1", f"Host: 127.0.0.1:{self.port}", "Origin: http://evil.example"])[0], 405)
        self.assert_lives()

    @unittest.skipUnless(has_three(), "missing: three.js, which scripts/setup fetches; it is built into the program")
    def test_who_draws_the_scene_gets_poses_and_no_pictures(self):
        with WebSocket(self.port) as client:
            client.say("hello", token=self.served.token, of="scene")
            first = client.hear("poses")
            self.assertEqual(len(first["bodies"]) % 7, 0)
            kinds = []

            def later(message):
                kinds.append(message["type"])
                return message["type"] == "poses" and message["t"] > first["t"] + 1
            for kind, payload in iter(client.frame, None):
                self.assertEqual(kind, TEXT)
                if later(json.loads(payload)):
                    break
            self.assertGreaterEqual(kinds.count("poses"), 15)
            client.say("view", of="pictures")
            self.assertEqual(client.picture()[:3], b"\xff\xd8\xff")

    def test_nobody_operates_a_run_that_goes_by_itself(self):
        with self.served.connect() as client:
            client.say("take")
            self.assertIn("takes no commands from here", client.hear("refused")["text"])

    def test_malformed_frames_end_their_connection_and_nothing_else(self):
        def unmasked(client): client.send_frame(TEXT, b'{"type":"stop"}', masked=False)
        def reserved(client): client.send_frame(11, b"x")
        def long_ping(client): client.send_frame(PING, b"x" * 200)
        def too_long(client): client.send_frame(TEXT, b"x" * 5000)
        def no_text(client): client.send_frame(2, b"\x00\x01")
        def no_utf8(client): client.send_frame(TEXT, b"\xff\xfe")
        def no_json(client): client.send_frame(TEXT, b"{")
        def endless(client): client.connection.sendall(b"\x81\xff" + b"\x7f" + b"\xff" * 7 + b"mask")
        def garbage(client): client.connection.sendall(bytes(range(256)))
        for bad in (unmasked, reserved, long_ping, too_long, no_text, no_utf8, no_json, endless, garbage):
            with self.subTest(bad.__name__), self.served.connect() as client:
                client.hear("welcome")
                bad(client)
                client.closing()
        self.assert_lives()

    def test_malformed_requests_end_their_connection_and_nothing_else(self):
        for lines in (["x"], ["GET / HTTP/9.9", "Host: x"], ["GET /" + "a" * 20000 + " HTTP/1.1"], ["\0\1\2"],
                      ["GET / HTTP/1.1", f"Host: 127.0.0.1:{self.port}", "Content-Length: 10", "", "0123456789"]):
            self.assertNotEqual(http(self.port, lines)[0], 200)
        self.assert_lives()

    def test_fifty_connections_that_stay_hurt_nobody(self):
        clients = [self.served.connect() for _ in range(50)]
        try:
            for client in clients:
                client.hear("welcome")
            with self.served.connect() as late:
                self.assertGreaterEqual(late.hear("state")["clients"], 51)
                begin = late.hear("state")["t"]
                self.assertGreater(late.hear(lambda m: m["type"] == "state" and m["t"] > begin + 0.5)["t"], begin)
        finally:
            for client in clients:
                client.connection.close()

    def test_one_too_many_is_told_so(self):
        clients = []
        try:
            with self.assertRaises(Refused) as refused:
                for _ in range(120):
                    clients.append(self.served.connect())
                    clients[-1].hear("welcome")
            self.assertEqual(refused.exception.args, (503,))
            self.assertEqual(len(clients), 100)
        finally:
            for client in clients:
                client.connection.close()
        limit = time.monotonic() + TIMEOUT
        while True:  # until the server has noticed that they are gone
            try:
                return self.assert_lives()
            except Refused:
                self.assertLess(time.monotonic(), limit)

    def test_who_has_not_shown_the_token_keeps_nobody_out(self):
        """Twice as many as are served: silent, in the middle of a request, and with a WebSocket that says nothing."""
        strangers = []
        self.addCleanup(lambda: [stranger.close() for stranger in strangers])

        def come():
            for i in range(200):
                if i % 3 == 2:
                    strangers.append(WebSocket(self.port).connection)
                    continue
                strangers.append(socket.create_connection(("127.0.0.1", self.port), timeout=TIMEOUT))
                if i % 3 == 1:
                    strangers[-1].sendall(b"GET / HTTP/1.1\r\n")
        come()
        with self.served.connect() as client:
            client.hear("welcome")
            come()
            client.hear("state")  # who has shown it stays
            for _ in range(40):
                self.assertEqual(self.get("/")[0], 200)
                self.assert_lives()

    def test_a_second_host_is_refused(self):
        for other in ("evil.example", f"127.0.0.1:{self.port}"):
            self.assertEqual(self.get("/", more=(f"Host: {other}",))[0], 400)
        self.assertEqual(http(self.port, ["GET / HTTP/1.1", "Connection: close"])[0], 400)
        self.assert_lives()

    def test_client_who_takes_nothing_holds_up_nobody(self):
        with self.served.connect() as slow, self.served.connect() as quick:
            slow.hear("welcome")
            for _ in range(200):  # answers to these pile up: nobody reads them
                slow.say("ping", sent_ms=1)
            first = quick.hear("state")["t"]
            self.assertGreater(quick.hear(lambda m: m["type"] == "state" and m["t"] > first + 0.5)["t"], first)


LED = """name: led
base: {model: husky}
robot: {q_start: {unit: deg, values: [0, -45, 0, -135, 0, 90, 45]}}
operator: {device: page}
application: {type: teleoperation}
record: false
"""


class PageRecordingTest(unittest.TestCase):
    def test_a_recording_begins_in_the_mode_in_which_it_was_begun(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_")
        self.addCleanup(folder.cleanup)
        served = Run(folder.name, LED)
        self.addCleanup(served.end)
        operator = Operator(served.port, served.token)
        self.addCleanup(operator.client.connection.close)

        def leads(until):
            return lambda message: message["type"] == "state" and bool(message["teleop"]) and until(message["teleop"])

        def told(text):
            return lambda message: message["type"] == "event" and text in message["text"]

        for until, kind, fields in ((leads(lambda teleop: teleop["mode"] == "base"), "press", {"button": "mode"}),
                                    (told("recording what"), "record", {"on": True}),
                                    (leads(lambda teleop: teleop["hand_closed"]), "press", {"button": "gripper"}),
                                    (told("recorded:"), "record", {"on": False})):
            operator.lead([0] * 6, until, (kind, fields))
        header, first, *more = pathlib.Path(folder.name, "out", "operator_1.csv").read_text().splitlines()
        row = dict(zip(header.split(","), first.split(",")))
        self.assertEqual((row["mode"], row["gripper"]), ("1", "0"))
        self.assertTrue(more)


class PageEndTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_anyone_may_stop_and_all_hear_it(self):
        served = Run(self.folder)
        with served.connect() as watcher, served.connect() as other:
            watcher.hear(lambda message: message["type"] == "state" and message["arm"])
            watcher.say("stop")
            self.assertIn("emergency stop", other.hear(lambda m: m["type"] == "event" and m["kind"] == "stop")["text"])
            self.assertIn("interrupt", other.hear("end")["text"])
        self.assertEqual(served.process.wait(timeout=TIMEOUT), 130)
        served.process.stdout.close()

    def test_a_run_that_is_over_says_so(self):
        served = Run(self.folder, SCENARIO.replace("600 s", "1.5 s"))
        with served.connect() as client:
            self.assertEqual(client.hear("end")["text"], "it went well")
            self.assertEqual(client.closing(), "the run is over")
        self.assertEqual(served.process.wait(timeout=TIMEOUT), 0)
        served.process.stdout.close()


    def test_a_run_waits_for_its_first_visitor(self):
        served = Run(self.folder, SCENARIO.replace("600 s", "0.5 s"), flags=("--wait-for-visitor",))
        with self.assertRaises(subprocess.TimeoutExpired):
            served.process.wait(timeout=3)
        with served.connect() as client:
            self.assertEqual(client.hear("end")["text"], "it went well")
        self.assertEqual(served.process.wait(timeout=TIMEOUT), 0)
        served.process.stdout.close()

    def test_a_run_that_waits_can_be_interrupted(self):
        served = Run(self.folder, flags=("--wait-for-visitor",))
        served.process.send_signal(signal.SIGINT)
        self.assertEqual(served.process.wait(timeout=TIMEOUT), 130)
        served.process.stdout.close()


class PageFlagsTest(unittest.TestCase):
    def refusal(self, command, *flags):
        process = subprocess.run([PROGRAM, command, SOURCE / "models/scenarios/smoke.yaml", *flags, "--data", SOURCE / "models"],
                                 capture_output=True, text=True, timeout=TIMEOUT)
        self.assertEqual(process.returncode, 3, process.stderr)
        return process.stderr

    def test_what_cannot_be_is_said_before_anything_is_done(self):
        for command in ("run", "serve"):
            self.assertIn('--page is "99999"; it must be a port in [0, 65535]', self.refusal(command, "--page=99999"))
            self.assertIn("--page-allow", self.refusal(command, "--page", "--page-bind", "0.0.0.0"))
            self.assertIn("go with --page", self.refusal(command, "--page-bind", "127.0.0.2"))
        self.assertIn("goes with --page", self.refusal("run", "--wait-for-visitor"))
        self.assertIn("leave out --seeds", self.refusal("run", "--page", "--seeds", "2"))
        self.assertIn("section operator", self.refusal("run", "--page", "--device", "page"))

    def test_each_address_that_is_printed_works(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_page_")
        self.addCleanup(folder.cleanup)
        served = Run(folder.name, flags=("--page-bind", "0.0.0.0", "--page-allow", "0.0.0.0/0"))
        self.addCleanup(served.end)
        urls = re.findall(r"http://([0-9.]+):(\d+)/#token=", served.said)  # this machine's own is the last
        for address, port in urls:
            self.assertEqual(http(int(port), ["GET / HTTP/1.1", f"Host: {address}:{port}", "Connection: close"], address=address)[0], 200)

    def test_port_that_is_taken_is_named(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            with tempfile.TemporaryDirectory() as folder:
                process = subprocess.run([PROGRAM, "run", SOURCE / "models/scenarios/smoke.yaml", f"--page={port}", "--out", folder,
                                          "--data", SOURCE / "models"], capture_output=True, text=True, timeout=TIMEOUT)
        self.assertEqual(process.returncode, 4)
        self.assertIn(f"127.0.0.1:{port}", process.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    del sys.argv[1:3]
    unittest.main()
