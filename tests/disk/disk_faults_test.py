#!/usr/bin/env python3
"""Files fail under the real program: disk_faults_test.py PROGRAM SOURCE_TREE FAULTY_FILES_LIBRARY [--all] [unittest options].

Each command's calls that change files are counted first (faulty_files.c). Then it is repeated, and one call, or all from
one on, fail as on a full, broken, read-only or foreign disk, or the program is killed there. What must hold each time:

- it ends by itself, with code 0 or 4, or by the SIGKILL that is the fault;
- code 0: every result is there, new and whole; code 4: one error, which names the file or its folder;
- an error on closing or syncing a result is no success;
- each result is absent, the old whole one or the new whole one; what is unfinished is called *.partial, and of a log
  can be read to its last chunk;
- the input, a file of the user's among the results, and all beside that folder are as they were;
- the same command without a fault then succeeds.

Without --all, a sample by the seed $TWIN_FAULT_SEED, and not of what takes long. Faults that other tests have: a file that may not grow
(tests/cli/cli_faults_test.py, tests/server/serve_files_test.py), killed with ffmpeg at work (tests/cli/killed_video_test.py), a
small disk under a video (tests/render/video_faults_test.cc), sweeps killed at random moments (tests/cli/sweep_test.py).
"""

import dataclasses
import errno
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE, LIBRARY, ALL = "", pathlib.Path(), "", False

SAMPLE = 8  # faults per command
SEED = int(os.environ.get("TWIN_FAULT_SEED", "1"))

SHORT = """name: short
plant: {kind: %s}
link: {command_loss: 0 %%}
motion:
  trajectory:
    unit: rad
    duration: 0.3 s
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.02, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
render: {enabled: false}
"""
SWEEP = """name: losses
scenario: scenario.yaml
axes:
  - {key: link.command_loss, values: [0 %, 100 %]}
seeds: 1
keep: all
"""
LED = """name: led
robot: {q_start: {unit: rad, values: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}}
operator:
  device: script
  parameters: {file: hands.csv, record: %s}
application: {type: teleoperation, parameters: {longest: 5 s}}
record: false
render: {enabled: false}
"""
HANDS = """time,kind,x,y,z,rx,ry,rz,engaged,mode,gripper,frame,scale,stop,release,end
0,rate,0,0,0,0,0,0,1,0,0,0,0,0,0,0
0.05,rate,0.5,0,0,0,0,0,1,0,0,0,0,0,0,0
0.1,rate,0,0,0,0,0,0,1,0,0,0,0,0,0,1
"""
CASE = """scenario: scenarios/smoke.yaml
every: 10
key_frames: 2
views:
  far:
    camera: {azimuth: 142 deg, elevation: -18 deg, distance: 2.05 m, lookat: [0.18 m, 0 m, 0.46 m]}
"""
MAGIC = b"\x89MCAP0\r\n"

NO_SPACE = ("open", "write", "fsync", "rename", "link", "mkdir", "close")  # at close: on NFS
READ_ONLY = ("open", "write", "fsync", "truncate", "rename", "link", "mkdir", "unlink")
ANY = ("open", "write", "fsync", "truncate", "rename", "link", "mkdir", "unlink", "close")


@dataclasses.dataclass(frozen=True)
class Fault:
    name: str
    kind: str     # TWIN_FAULT_KIND
    calls: tuple  # to which it can happen
    sticky: bool = False

    @property
    def kills(self):
        return self.kind in ("kill", "torn")


FAULTS = (
    Fault("full disk", str(errno.ENOSPC), NO_SPACE, sticky=True),
    Fault("disk full for a moment", str(errno.ENOSPC), NO_SPACE),
    Fault("used-up quota", str(errno.EDQUOT), NO_SPACE, sticky=True),
    Fault("broken disk", str(errno.EIO), ANY, sticky=True),
    Fault("broken block", str(errno.EIO), ANY),
    Fault("disk turned read-only", str(errno.EROFS), READ_ONLY, sticky=True),
    Fault("too many open files", str(errno.EMFILE), ("open",)),
    Fault("interrupted call", str(errno.EINTR), ("write", "fsync", "truncate")),
    Fault("short write", "short", ("write",)),
    Fault("short writes", "short", ("write",), sticky=True),
    Fault("kill", "kill", ANY),
    Fault("kill amid a write", "torn", ("write",)),
)


@dataclasses.dataclass(frozen=True)
class Call:
    """One that was counted."""
    name: str
    path: pathlib.Path

    def names(self):
        """Words of which an error has one: the file, or the folder that is tried out by a file of no name."""
        name = re.sub(r"(\.\d+)?(\.partial)*$", "", self.path.name)
        return str(self.path.parent) if name.startswith(".panda-twin.") else name

    def loses_a_result(self, out):
        """Whether it was to close or sync what was written: it says last that something is missing."""
        return self.name in ("close", "fsync") and self.path.suffix == ".partial" and self.path.is_relative_to(out)


def span_of_whole_chunks(log):
    """First and last time (ns) in those chunks (records of kind 6) of an MCAP file that are there to their end; None without any."""
    spans, at = [], len(MAGIC)
    while at + 9 <= len(log):
        end = at + 9 + int.from_bytes(log[at + 1:at + 9], "little")
        if log[at] == 6 and end <= len(log):
            spans.append([int.from_bytes(log[at + from_there:at + from_there + 8], "little") for from_there in (9, 17)])
        at = end
    return (spans[0][0], spans[-1][1]) if spans else None


class DiskFaultsTest(unittest.TestCase):
    def setUp(self):
        # Without symbolic links, as the library wants it.
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_disk_")).resolve()
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.box, self.beside, self.report = self.folder / "box", self.folder / "beside", self.folder / "report"
        self.out = self.box / "out"
        self.out.mkdir(parents=True)
        self.beside.mkdir()
        self.not_replaced = []  # results
        self.program = "panda-twin"  # whose calls fail
        for folder in (self.out, self.beside):
            (folder / "notes.txt").write_text("the user's\n")
        self.write("scenario.yaml", SHORT % "ideal")

    def write(self, name, text):
        (self.beside / name).write_text(text)
        return self.beside / name

    def call(self, *arguments, **faulty):
        environment = dict(os.environ, XDG_CACHE_HOME=str(self.box / "cache"), XDG_STATE_HOME=str(self.box / "state"), **faulty)
        environment["MESA_SHADER_CACHE_DISABLE"] = "true"  # Mesa's files are not ours
        environment["ASAN_OPTIONS"] = environment.get("ASAN_OPTIONS", "") + ":verify_asan_link_order=0"
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.beside, env=environment, capture_output=True, text=True,
                              timeout=120)

    def good(self, *arguments):
        done = self.call(*arguments, "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)

    def faulty(self, fault, at):
        """@returns (the command's end, calls that were counted, calls that failed)."""
        self.report.unlink(missing_ok=True)
        done = self.call(*self.arguments, LD_PRELOAD=LIBRARY, TWIN_FAULT_FOLDER=str(self.box), TWIN_FAULT_REPORT=str(self.report),
                         TWIN_FAULT_AT=str(at), TWIN_FAULT_KIND=fault.kind, TWIN_FAULT_CALLS=",".join(fault.calls),
                         TWIN_FAULT_STICKY=str(int(fault.sticky)), TWIN_FAULT_PROGRAM=self.program)
        lines = [line.split(" ", 2) for line in self.report.read_text().splitlines()] if self.report.exists() else []
        calls = [(number, Call(name, pathlib.Path(path))) for number, name, path in lines]
        return done, [c for _, c in calls], [c for number, c in calls if number == "!"]

    def files(self, folder):
        return {p.relative_to(folder): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}

    def prepare(self, arguments, varying=(), older=True):
        """Takes the box as it is for the input of a command, carries it out without faults, and makes older results of what
        it writes. @param varying  names or folders of results that do not repeat byte by byte. @param older  whether there are
        older results."""
        self.arguments, self.varying = [*arguments, "--quiet"], set(varying)
        self.input = self.files(self.box)
        shutil.copytree(self.box, self.folder / "old")
        done, self.calls, _ = self.faulty(Fault("none", "0", ANY), 0)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(len(self.calls), 3)
        self.new = {name: text for name, text in self.files(self.box).items() if self.input.get(name) != text}
        self.assertTrue(self.new)
        self.results = [name for name in self.new if name.parts[0] == "out"]
        self.old = {name: self.new[name] + b"\nolder" for name in self.results if older}
        for name, text in self.old.items():
            path = self.folder / "old" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text)
        self.before = self.files(self.beside)

    def restore(self):
        shutil.rmtree(self.box)
        shutil.copytree(self.folder / "old", self.box)

    def varies(self, name):
        return any(part in self.varying for part in name.parts)

    def assert_whole(self, path, text):
        """Of a result that does not repeat byte by byte."""
        if path.suffix == ".json":
            json.loads(text)
        elif path.suffix == ".mcap":
            self.assertEqual((text[:8], text[-8:]), (MAGIC, MAGIC), path)
        elif path.suffix in (".html", ".svg"):
            self.assertTrue(text.rstrip().endswith(f"</{path.suffix[1:]}>".encode()), path)
        elif path.suffix == ".mp4":
            self.assertIn(b"ftyp", text[:16])
            self.assertIn(b"mfra", text[-200:])  # the index of its fragments, which ffmpeg writes last
        elif path.suffix == ".pcapng":
            self.assertEqual(self.call("decode", path).returncode, 0)
        else:
            self.fail(f"{path}: nothing tells whether it is whole")

    def assert_readable(self, path, text):
        """An unfinished log is read to its last whole chunk, or refused as none when not even its head is there."""
        if not path.name.endswith(".mcap.partial"):
            return
        tables = self.folder / "tables"
        done = self.call("export", path, "--out", tables, "--quiet")
        if span := span_of_whole_chunks(text):
            self.assertEqual(done.returncode, 0, done.stderr)
            cycles = (tables / "cycles.csv").read_text().splitlines()
            self.assertEqual(cycles[0].split(",")[0], "at_ns")
            self.assertAlmostEqual(int(cycles[-1].split(",")[0]), span[1], delta=3e6, msg="the last cycle of the last whole chunk")
            self.assertGreater(len(cycles), (span[1] - span[0]) / 1e6, "a row per cycle")
        else:
            self.assertIn(done.returncode, (0, 3), done.stderr)
        shutil.rmtree(tables, ignore_errors=True)

    def assert_files(self, done, killed):
        there = self.files(self.box)
        for name, text in self.input.items():
            if name not in self.new:
                self.assertEqual(there.pop(name, None), text, name)
        for name, text in there.items():
            path = self.box / name
            if name.name.endswith(".partial"):
                self.assert_readable(path, text)
            elif any(re.search(r"\.\d+$", part) for part in name.parts):
                self.assertIn("sweep", self.arguments)  # a process's own folder, which docs/how-to/sweep.md tells of
            elif name.name.startswith(".panda-twin."):  # tries out whether a folder can be written
                self.assertEqual(text, b"")
            elif name in self.new and self.varies(name) and text != self.old.get(name):
                self.assert_whole(path, text)
            else:
                self.assertIn(name, self.new, "a file of an unexpected name")
                self.assertIn(text, (self.new[name], self.old.get(name)), f"{name}: neither the old nor the new one")
        if done.returncode == 0:
            for name in self.results:
                self.assertIn(name, there)
                self.assertNotEqual(there[name], self.old.get(name), f"{name} is an old one")
            self.assertEqual([n for n in there if n.name.endswith(".partial") and n.parts[0] == "out"], [])
        self.assertEqual(self.files(self.beside), self.before)

    def assert_end(self, done, fault, failed):
        if fault.kills:
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            return
        self.assertIn(done.returncode, (0, 4), done.stderr)
        if fault.kind != str(errno.EINTR) and any(call.loses_a_result(self.out) for call in failed):
            self.assertEqual(done.returncode, 4, "what was written may be lost, and nothing says so")
        errors = [line for line in done.stderr.splitlines() if "error:" in line]
        self.assertEqual(len(errors), 1 if done.returncode == 4 else 0, done.stderr)
        if errors:
            self.assertTrue(errors[0].startswith("panda-twin: error: "), errors)
            self.assertTrue(any(call.names() in errors[0] for call in failed), (errors, failed))

    def strike(self, fault, at):
        self.restore()
        done, _, failed = self.faulty(fault, at)
        if not failed:  # a log's chunks may be fewer on another day
            return False
        with self.subTest(fault=fault.name, at=at, call=failed[0]):
            self.assert_end(done, fault, failed)
            self.assert_files(done, fault.kills)
            for name in self.not_replaced:
                (self.box / name).unlink(missing_ok=True)
            done = self.call(*self.arguments)
            self.assertEqual(done.returncode, 0, "afterwards, without a fault: " + done.stderr)
            for name in self.results:
                if not self.varies(name):
                    self.assertEqual((self.box / name).read_bytes(), self.new[name], f"{name}, afterwards")
        return True

    def strike_all(self, sample=SAMPLE):
        strikes = [(fault, at + 1) for fault in FAULTS for at in range(sum(call.name in fault.calls for call in self.calls))]
        if not ALL:
            strikes = random.Random(f"{SEED} {self.id()}").sample(strikes, min(sample, len(strikes)))
        struck = sum(self.strike(*one) for one in strikes)
        print(f"{self._testMethodName}: {struck} faults", file=sys.stderr)
        self.assertGreater(struck, 0.8 * len(strikes))

    def run_arguments(self):
        return ["run", self.beside / "scenario.yaml", "--out", self.out, "--data", SOURCE / "models", "--no-video"]

    def record(self):
        """@returns a run's log, beside the box."""
        log = self.beside / "recorded"
        self.good("run", self.beside / "scenario.yaml", "--out", log, "--data", SOURCE / "models", "--no-video")
        return log / "run.mcap"

    def test_run(self):
        self.prepare(self.run_arguments(), ["timing.json", "state"])
        self.strike_all()

    def test_run_that_compiles_its_model(self):
        self.write("scenario.yaml", SHORT % "mujoco" + "record: false\n")
        self.prepare(self.run_arguments(), ["timing.json", "state"])
        self.strike_all()

    def test_run_with_a_video(self):
        video = (SHORT % "mujoco").replace("enabled: false", "width: 64, height: 48, fps: 25 Hz")
        self.write("scenario.yaml", video + "record: false\n")
        self.prepare([*self.run_arguments()[:-1]], ["timing.json", "state", "video.mp4"])
        self.strike_all(sample=2)

    def test_export_to_csv(self):
        self.prepare(["export", self.record(), "--out", self.out])
        self.strike_all()

    def test_export_to_numpy(self):
        self.prepare(["export", self.record(), "--out", self.out, "--format", "npz"])
        self.strike_all()

    def test_explain(self):
        self.write("scenario.yaml", SHORT.replace("command_loss: 0", "command_loss: 100") % "ideal")
        lost = self.beside / "lost"
        done = self.call("run", self.beside / "scenario.yaml", "--out", lost, "--data", SOURCE / "models", "--no-video")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.prepare(["explain", lost, "--out", self.out])
        self.strike_all()

    def serve_arguments(self, seconds="0.2"):
        return ["serve", self.beside / "scenario.yaml", "--data", SOURCE / "models", "--drive", "lockstep", "--port", "0",
                "--hand-port", "0", "--for", seconds]

    def test_serve_with_log_and_capture(self):
        self.prepare([*self.serve_arguments(), "--log", self.out / "a.mcap", "--capture", self.out / "a.pcapng"],
                     ["a.mcap", "a.pcapng"])
        self.strike_all()

    def test_serve_with_a_split_log(self):
        split = ["--log", self.out / "a.mcap", "--log-split", "0.8 s"]
        self.prepare([*self.serve_arguments("1.5"), *split], ["a_0001.mcap", "a_0002.mcap"], older=False)  # it adds to older ones
        self.assertEqual(len(self.results), 2)
        self.strike_all()

    def test_an_error_at_the_split_of_a_log_is_told(self):
        split = ["--log", self.out / "a.mcap", "--log-split", "0.8 s"]
        self.prepare([*self.serve_arguments("1.5"), *split], ["a_0001.mcap", "a_0002.mcap"], older=False)
        for call, file, whole in (("open", "a_0002.mcap.partial", True), ("fsync", "a_0001.mcap.partial", False)):
            with self.subTest(call=call):
                fault = Fault("broken block", str(errno.EIO), (call,))
                self.restore()
                done, _, failed = self.faulty(fault, [c.path.name for c in self.calls if c.name == call].index(file) + 1)
                self.assert_end(done, fault, failed)
                self.assertEqual(done.returncode, 4)
                self.assertIn(f"{file}: Input/output error", done.stderr)
                self.assert_files(done, False)
                self.assertEqual((self.out / "a_0001.mcap").exists(), whole)

    def test_serve_into_a_folder(self):
        self.prepare([*self.serve_arguments(), "--out", self.out, "--no-video"],
                     ["run.mcap", "summary.json", "report.html", "timing.json"])
        self.strike_all()

    def shipped_arguments(self, file, *flags):
        return ["run", SOURCE / "models" / file, "--out", self.out, "--data", SOURCE / "models", "--no-video", *flags]

    def test_application(self):
        self.prepare(self.shipped_arguments("applications/plan_and_execute.yaml"), ["timing.json", "state"])
        self.strike_all(sample=2)

    def test_seeds_of_an_application(self):
        self.prepare(self.shipped_arguments("applications/plan_and_execute.yaml", "--seeds", "2"), ["timing.json", "state"])
        self.strike_all(sample=1)

    def test_cell(self):
        self.prepare(self.shipped_arguments("cells/two_arms.yaml"), ["timing.json", "state"])
        self.strike_all(sample=2)

    def test_render_a_picture(self):
        self.write("scenario.yaml", SHORT % "mujoco")
        self.prepare(["render", self.record(), "--data", SOURCE / "models", "--at", "0.1", "--size", "64x48", "--out", self.out / "a.png"])
        self.strike_all(sample=4)

    def test_render_pictures(self):
        self.write("scenario.yaml", SHORT % "mujoco")
        self.prepare(["render", self.record(), "--data", SOURCE / "models", "--fps", "20", "--size", "64x48", "--out", self.out / "pictures/"])
        self.strike_all(sample=2)

    def test_experiment(self):
        self.prepare(["experiment", "feed_forward", "--seeds", "2", "--out", self.out, "--data", SOURCE / "models"])
        self.strike_all(sample=4)

    def test_recording_of_an_operator(self):
        self.write("hands.csv", HANDS)
        self.write("scenario.yaml", LED % (self.out / "operator.csv"))
        self.not_replaced = ["out/operator.csv"]
        self.prepare(self.run_arguments(), ["timing.json", "state"], older=False)
        self.strike_all(sample=4)

    def test_approval_of_pictures(self):
        shutil.copy(SOURCE / "models/scenarios/smoke.yaml", self.beside / "scenario.yaml")
        (self.out / "small.yaml").write_text(CASE)
        self.prepare(["video", "approve", "small", "--log", self.record(), "--goldens", self.out, "--out", self.box / "runs", "--data",
                      SOURCE / "models", "--reason", "a test"], older=False)  # what looks the same is kept
        self.strike_all(sample=2)

    def test_excite(self):
        self.program = "python"
        self.prepare(["excite", "--for", "load", "--seconds", "6", "--terms", "2", "--out", self.out])
        self.strike_all(sample=1)

    def sweep_arguments(self, what, *flags):
        sweep = self.write("sweep.yaml", SWEEP)
        return ["sweep", what, sweep, "--out", self.out, "--data", SOURCE / "models", *flags]

    def test_sweep(self):
        self.prepare(self.sweep_arguments("run", "--jobs", "1"), ["timing.json"], older=False)  # what is there is not made again
        self.strike_all()

    def test_merge_of_a_sweep(self):
        self.good(*self.sweep_arguments("run", "--jobs", "1"))
        for name in ("report.html", "summary.json"):
            (self.out / name).unlink(missing_ok=True)
        self.prepare(self.sweep_arguments("merge"))
        self.strike_all(sample=4)


if __name__ == "__main__":
    PROGRAM, SOURCE, LIBRARY = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    ALL = "--all" in sys.argv
    if not ALL:  # they take CI too long
        del DiskFaultsTest.test_excite, DiskFaultsTest.test_seeds_of_an_application
    unittest.main(argv=[sys.argv[0], *(argument for argument in sys.argv[4:] if argument != "--all")])
