#!/usr/bin/env python3
"""The unit of systemd in scripts/packaging, tried without systemd: sandbox_test.py PROGRAM SOURCE_TREE [unittest options].

A robot is served, recorded, controlled and shown under the unit's system-call filter, which sandbox.py builds. What systemd does with mounts and
users is not tried; systemd-analyze judges it.
"""

import os
import pathlib
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

import sandbox

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(SOURCE / "tests/server"), str(SOURCE / "tests/page")]
import fci_wire as fci  # noqa: E402
import serve_test  # noqa: E402
from web_client import WebSocket  # noqa: E402

PROGRAM = ""
UNIT = SOURCE / "scripts/packaging/panda-twin@.service"
MOST_EXPOSURE = 20  # tenths, of 100; systemd calls up to 2.9 "OK"
REFUSED = """
import mmap, os
for attempt in (lambda: mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC),
                lambda: os.chown("/tmp", 0, 0), lambda: os.chroot("/")):
    try:
        attempt()
    except PermissionError:
        print("refused")
"""

WANTED = platform.machine() == "x86_64" and shutil.which("systemd-analyze") and sandbox.NUMBERS.is_file()


@unittest.skipUnless(WANTED, "missing: systemd-analyze, or the kernel's headers of x86-64")
class SandboxTest(serve_test.ServeTest):
    def setUp(self):
        super().setUp()
        command = shlex.join([sys.executable, "-B", str(pathlib.Path(sandbox.__file__)), str(UNIT), PROGRAM])
        wrapper = pathlib.Path(self.folder, "sandboxed")
        wrapper.write_text(f'#!/bin/sh\nexec {command} "$@"\n')
        wrapper.chmod(0o700)
        serve_test.PROGRAM, serve_test.SOURCE = str(wrapper), SOURCE
        for key, value in sandbox.settings(UNIT):
            if key == "Environment" and "%" not in value:
                os.environ.update([value.split("=")])

    def serve_in_motion(self, *flags):
        file = pathlib.Path(self.folder)
        server = self.serve("--log", file / "run.mcap", "--capture", file / "run.pcapng", "--control", file / "control", *flags,
                            scenario=serve_test.SCENARIO.replace("plant: {kind: ideal}\n", ""))
        self.check_serves(server)
        answer = subprocess.run([serve_test.PROGRAM, "ctl", file / "control", "status"], capture_output=True, text=True)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        return server

    def check_end(self, server, log="run.mcap"):
        code, errors = server.end()
        self.assertEqual(code, 130, errors)
        file, = pathlib.Path(self.folder).glob(log)
        self.assertGreater(file.stat().st_size, 1000)

    def test_a_robot_is_served_in_lockstep(self):
        self.check_end(self.serve_in_motion())

    def test_a_log_is_split_and_old_files_are_removed(self):
        self.check_end(self.serve_in_motion("--log-split", "0.2 s", "--log-keep", "1"), "run_*.mcap")

    def test_a_robot_is_served_on_the_wall_clock(self):
        self.FLAGS = ("--drive", "realtime")
        server = self.serve("--control", pathlib.Path(self.folder, "control"))
        arm = self.arm(server)
        self.assertEqual(arm.connected, fci.SUCCESS)
        self.assertLess(arm.read().id, arm.read().id)
        arm.close()
        self.assertEqual(server.end()[0], 130)

    def test_its_page_draws_pictures(self):
        server = self.serve_in_motion("--pace", "1", "--page=0")
        port, token = server.await_line(r"http://127\.0\.0\.1:(\d+)/#token=([0-9a-f]{32})").groups()
        with WebSocket(int(port)) as client:
            client.say("hello", token=token)
            picture = client.picture()
        self.assertEqual(picture[:2], b"\xff\xd8")  # a JPEG file
        self.check_end(server)

    def test_the_filter_refuses_what_it_should(self):
        done = subprocess.run([sys.executable, "-B", sandbox.__file__, UNIT, sys.executable, "-c", REFUSED], capture_output=True, text=True)
        self.assertEqual(done.stdout.split(), ["refused"] * 3, done.stderr)

    def test_systemd_understands_it(self):
        unit = pathlib.Path(self.folder, UNIT.name)
        unit.write_text(UNIT.read_text().replace("/usr/bin/panda-twin", PROGRAM))
        verified = subprocess.run(["systemd-analyze", "verify", unit], capture_output=True, text=True)
        self.assertEqual((verified.returncode, verified.stderr), (0, ""))

    def test_it_may_do_little(self):
        judged = subprocess.run(["systemd-analyze", "security", "--offline=yes", f"--threshold={MOST_EXPOSURE}", "--no-pager", UNIT],
                                capture_output=True, text=True)
        self.assertEqual(judged.returncode, 0, judged.stdout + judged.stderr)


if __name__ == "__main__":
    PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
