#!/usr/bin/env python3
"""Plugs devices in and shows them: devices_command_test.py PROGRAM SOURCE_TREE [unittest options].

Input devices are umockdev's: the program, libevdev and the ioctls are real, the kernel's side is described here. What is
sent to the device "network" is sent by the example of its documentation.
"""

import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()

EV_SYN, EV_KEY, EV_REL, EV_ABS = range(4)
BTN_0, BTN_SOUTH = 0x100, 0x130
# Bytes that libevdev asks for, per request. 255: the longest text it takes.
TEXT, KEYS, FEW = 255, 96, 8


def bits(codes, size):
    field = bytearray(size)
    for code in codes:
        field[code // 8] |= 1 << code % 8
    return bytes(field)


def described(path, name, axes, keys):
    """What the kernel would answer: axes is {code: (minimum, maximum, flat)}."""
    def text(words):
        return words.encode().ljust(TEXT, b"\0")

    events = [EV_SYN, EV_KEY] + ([EV_ABS] if axes else [])
    answers = [("VERSION", 0, struct.pack("<i", 0x10001)), ("ID", 0, struct.pack("<4H", 3, 0x046D, 0xC635, 0x111)),
               ("NAME", len(name) + 1, text(name)), ("PHYS", 1, text("")), ("UNIQ", 1, text("")), ("PROP", FEW, bytes(FEW)),
               ("BIT(0)", FEW, bits(events, FEW)), ("BIT(1)", KEYS, bits(keys, KEYS)), ("BIT(3)", FEW, bits(axes, FEW))]
    answers += [(f"BIT({number})", size, bytes(size)) for number, size in
                ((2, FEW), (4, FEW), (5, FEW), (0x11, FEW), (0x12, FEW), (0x15, 16))]
    answers += [("KEY", KEYS, bytes(KEYS)), ("LED", FEW, bytes(FEW)), ("SW", FEW, bytes(FEW))]
    answers += [(f"ABS({code})", 0, struct.pack("<6i", 0, *axes[code][:2], 0, axes[code][2], 0)) for code in axes]
    lines = [f"EVIOCG{name} {result} {data.hex().upper()}" for name, result, data in answers]
    return "\n".join([f"@DEV {path}", *lines, ""])


SPACE_MOUSE = ("/dev/input/event5", "3Dconnexion SpaceMouse Compact", {i: (-350, 350, 0) for i in range(6)}, [BTN_0, BTN_0 + 1])
KEYBOARD = ("/dev/input/event2", "A keyboard", {}, [30, 31, 32])
GAMEPAD = ("/dev/input/event11", "A gamepad", {i: (-32768, 32767, 128) for i in (0, 1, 3, 4)}, range(BTN_SOUTH, BTN_SOUTH + 15))


def reports(*rows):
    """Events for umockdev: each row is a time in s and (type, code, value) of a whole report."""
    lines = []
    for time, *events in rows:
        lines += [f"E: {time:.6f} {kind:04x} {code:04x} {value}" for kind, code, value in [*events, (EV_SYN, 0, 0)]]
    return "\n".join([*lines, ""])


class DevicesTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_devices_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def call(self, *arguments, before=()):
        # umockdev's library is loaded before the sanitizer's, which minds by default.
        options = ":".join(filter(None, [os.environ.get("ASAN_OPTIONS"), "verify_asan_link_order=0"]))
        return subprocess.run([*before, PROGRAM, "devices", *arguments], cwd=self.folder, capture_output=True, text=True, timeout=100,
                              env=dict(os.environ, ASAN_OPTIONS=options))

    def plugged_in(self, *devices, events=None):
        """The command in front of one that sees these devices; events are those of the first."""
        if not shutil.which("umockdev-run"):
            self.skipTest("missing: umockdev is not installed; scripts/setup does it")
        command = ["umockdev-run"]
        for path, name, axes, keys in devices:
            node = pathlib.PurePath(path).name
            (self.folder / f"{node}.device").write_text(
                f"P: /devices/virtual/input/{node}\nN: input/{node}\nE: DEVNAME={path}\nE: SUBSYSTEM=input\n\n")
            command += ["--device", f"{self.folder}/{node}.device"]
            if not name:  # a node that answers nothing
                continue
            (self.folder / f"{node}.ioctl").write_text(described(path, name, axes, keys))
            command += ["--ioctl", f"{path}={self.folder}/{node}.ioctl"]
        if events:
            (self.folder / "events").write_text(events)
            command += ["--evemu-events", f"{devices[0][0]}={self.folder}/events"]
        return [*command, "--"]

    def assert_refused(self, done, code, text):
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(text, done.stderr)

    def test_lists_what_is_plugged_in_and_what_it_is_good_for(self):
        done = self.call(before=self.plugged_in(GAMEPAD, KEYBOARD, SPACE_MOUSE))
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = [line.strip() for line in done.stdout.splitlines()]
        self.assertEqual([re.split(" {2,}", line) for line in lines[1:4]],
                         [["/dev/input/event2", "none to lead with", "A keyboard (0 axes, 3 buttons)"],
                          ["/dev/input/event5", "SpaceMouse", "3Dconnexion SpaceMouse Compact (6 axes, 2 buttons)"],
                          ["/dev/input/event11", "gamepad", "A gamepad (4 axes, 15 buttons)"]])
        self.assertIn("evdev, network, script", lines[4])

    def test_says_once_that_some_cannot_be_opened(self):
        mute = [(f"/dev/input/event{number}", "", {}, []) for number in (3, 4)]
        done = self.call(before=self.plugged_in(*mute, SPACE_MOUSE))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("SpaceMouse Compact", done.stdout)
        self.assertIn("  2 cannot be opened; /dev/input/event3: is no input device", done.stdout)

    def test_shows_the_axes_of_a_space_mouse_by_a_part_of_its_name(self):
        events = reports((0, (EV_ABS, 1, -175)), (0.2, (EV_KEY, BTN_0, 1)), (0.4, (EV_KEY, BTN_0, 0)))
        done = self.call("spacemouse", "--for", "3", before=self.plugged_in(SPACE_MOUSE, events=events))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("3Dconnexion SpaceMouse Compact at /dev/input/event5", done.stdout)
        self.assertIn("x +0.50 y +0.00 z", done.stdout)
        self.assertRegex(done.stdout.splitlines()[-2], r"rz \+0\.00 gripper 1$")

    def test_asks_the_device_when_the_kernel_has_dropped_events(self):
        # What is described has its axes in the middle: so it is, whatever was told before.
        dropped = (EV_SYN, 3, 0)
        events = reports((0, (EV_ABS, 1, -175)), (1.5, dropped))
        done = self.call("spacemouse", "--for", "3", before=self.plugged_in(SPACE_MOUSE, events=events))
        self.assertIn("x +0.50", done.stdout)
        self.assertIn("x +0.00", done.stdout.splitlines()[-2])

    def test_takes_a_space_mouse_before_a_gamepad(self):
        done = self.call("evdev", "--for", "0.1", before=self.plugged_in(GAMEPAD, SPACE_MOUSE))
        self.assertIn("SpaceMouse Compact at", done.stdout)

    def test_names_what_there_is_instead_of_what_is_not(self):
        done = self.call("joystick", before=self.plugged_in(GAMEPAD, KEYBOARD))
        self.assert_refused(done, 3, 'called "joystick"; there are: A gamepad (/dev/input/event11)')

    def test_refuses_to_lead_with_a_keyboard(self):
        done = self.call("/dev/input/event2", before=self.plugged_in(KEYBOARD))
        self.assert_refused(done, 3, '"A keyboard" has neither six axes nor')

    def test_names_the_group_that_may_read(self):
        closed = self.folder / "event0"
        closed.write_bytes(b"")
        closed.chmod(0)
        nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] if os.getuid() == 0 else []
        self.folder.chmod(0o755)
        if subprocess.run([*nobody, PROGRAM, "--version"], capture_output=True).returncode != 0:
            self.skipTest("another user cannot run the program here")
        self.assert_refused(self.call(str(closed), before=nobody), 4, "usermod -aG input")

    def test_refuses_parameters_that_are_none(self):
        self.assert_refused(self.call("network", "--set", "port=0", "--set", "silense=1 s"), 3, 'did you mean "silence"?')
        self.assert_refused(self.call("network", "--set", "port"), 3, "write KEY=VALUE")
        self.assert_refused(self.call("network", "--for", "0"), 3, "--for (s) is 0")

    def test_says_that_no_sample_came(self):
        done = self.call("network", "--set", "port=0", "--for", "0.1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no sample came", done.stdout)

    def test_records_what_runs_again(self):
        events = reports((0, (EV_ABS, 1, -350)), (1.5, (EV_ABS, 1, 0)))  # longer than a busy machine holds up who reads them
        done = self.call("evdev", "--for", "3", "--record", "me.csv", before=self.plugged_in(SPACE_MOUSE, events=events))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = [line.split(",") for line in (self.folder / "me.csv").read_text().splitlines()[1:]]
        self.assertGreater(len(rows), 3)
        self.assertIn("1", [row[2] for row in rows])
        self.assertFalse((self.folder / "me.csv.partial").exists())
        again = self.call("script", "--set", "file=me.csv", "--for", "3.5")
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertRegex(again.stdout, r"x \+1\.00")
        self.assertRegex(again.stdout, r"(?m)x \+0\.00.* end 1$")
        refused = self.call("script", "--set", "file=me.csv", "--record", "me.csv")
        self.assert_refused(refused, 3, "a recording is not replaced")

    def test_hears_the_example_of_its_documentation(self):
        example = SOURCE / "plugins/devices/haptic_example.py"
        self.assertIn(example.read_text(), (SOURCE / "plugins/devices/README.md").read_text())
        shown = subprocess.Popen([PROGRAM, "devices", "network", "--set", "port=0", "--set", "token=secret", "--for", "60"],
                                 cwd=self.folder, stdout=subprocess.PIPE, text=True)
        port = re.search(r":(\d+) ", shown.stdout.readline()).group(1)
        with subprocess.Popen([sys.executable, example, "secret", port], stdout=subprocess.PIPE, text=True) as program:
            felt = program.stdout.readline()  # its first answer
            gripped = any("gripper 1" in line for line in shown.stdout)
            program.kill()
        shown.send_signal(signal.SIGINT)
        shown.stdout.read()
        self.assertEqual(shown.wait(timeout=60), 130)
        shown.stdout.close()
        self.assertEqual(felt, "arm force +0.0 +0.0 +0.0 N\n")
        self.assertTrue(gripped)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
