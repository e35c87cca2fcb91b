"""The wheels, used where nothing but Debian's smallest system and Python is: that of Python 3.11 on Debian 12, that of later Pythons on
Debian 13. Builds them by scripts/wheel, and the systems by scripts/container-root.

    wheel_test.py PROGRAM        as root; PROGRAM: that of the build folder, to compare with
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import zipfile

import other_root

SOURCE = other_root.SOURCE
PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
OURS = ("libmujoco", "libOSMesa", "libompl", "libLLVM", "libassimp")
EXPECTED = (SOURCE / "models/scenarios/canonical.hash.yaml").read_text()
LARGEST = 100_000_000  # bytes, of a file on PyPI

# Draws an instant of a log by the extension module: the sum of all pixels, and a hash.
DRAW = """
import hashlib, sys
{before}
import panda_twin
{after}
picture = panda_twin.Log(sys.argv[1]).picture(2.0)
print(picture.shape, int(picture.sum()), hashlib.sha256(picture.tobytes()).hexdigest())
"""
RUN = """
import json, panda_twin
result = panda_twin.run("scenarios/canonical.yaml", out="/srv/{out}", video=False, plots=False)
print(json.dumps({{"libm": result.summary["libm"], "states_hash": result.states_hash}}))
"""
PANDA_PY = """
import sys, numpy, panda_py
panda = panda_py.Panda(sys.argv[1])
assert panda.move_to_start(), "panda_py did not move"
print(numpy.abs(panda.q - numpy.array([0, -numpy.pi / 4, 0, -3 * numpy.pi / 4, 0, numpy.pi / 2, numpy.pi / 4])).max())
print(numpy.abs(numpy.array(panda.get_model().gravity(panda.get_state())).max()))
"""
GYMNASIUM = """
import gymnasium
env = gymnasium.make("panda_twin:PandaTwin/Reach-v0", render_mode="rgb_array")
env.reset(seed=1)
for _ in range(3):
    env.step(env.action_space.sample())
print(int(env.render().max()))
"""


def setUpModule():
    global work, wheels
    work = pathlib.Path(tempfile.mkdtemp(prefix="panda-twin-wheel-", dir=PROGRAM.parent))
    unittest.addModuleCleanup(shutil.rmtree, work, ignore_errors=True)
    begin = time.monotonic()
    wheels = other_root.make_wheels(work / "wheels")
    print(f"wheels: {', '.join(wheels)} in {time.monotonic() - begin:.0f} s", flush=True)


class Contents(unittest.TestCase):
    def test_there_is_one_for_python_3_11_that_pypi_takes(self):
        self.assertIn("cp311-cp311", wheels)
        for wheel in wheels.values():
            self.assertLess(wheel.stat().st_size, LARGEST)
            self.assertRegex(wheel.name, r"manylinux_2_3[0-6]_x86_64\.whl$")

    def test_its_notice_names_every_library_in_it(self):
        for wheel in wheels.values():
            with zipfile.ZipFile(wheel) as archive:
                names = archive.namelist()
                notice = next(name for name in names if name.endswith("licenses/NOTICE"))
                text = archive.read(notice).decode()
                bundled = [name.split("/")[1] for name in names if name.startswith("panda_twin.libs/")]
                self.assertGreater(len(bundled), 20)
                self.assertEqual([library for library in bundled if library not in text], [])
                for package in re.findall(r"^([a-z0-9.+-]+) \S+ \(source ", text, re.MULTILINE):
                    self.assertIn(notice.replace("NOTICE", f"licences/{package}"), names)


class Used:
    """What must hold in any root; `root` is it."""

    root: other_root.OtherRoot

    def test_nothing_of_what_it_needs_is_installed_there(self):
        cached = self.root.run("ldconfig", "-p")
        self.assertIn("libc.so.6", cached)
        self.assertEqual([name for name in OURS if name in cached], [])

    def test_runs_to_the_same_bits_by_program_and_by_module(self):
        copies = self.root.path("/srv/unrecorded")  # so that no plots are wanted
        shutil.copytree(SOURCE / "models/scenarios", copies)
        with open(copies / "canonical.yaml", "a") as scenario:
            scenario.write("record: false\n")
        self.root.run("panda-twin", "run", "unrecorded/canonical.yaml", "--no-video", "--out", "by_program")
        by_program = json.loads(self.root.path("/srv/by_program/summary.json").read_text())
        by_module = json.loads(self.root.python(RUN.format(out="by_module")).splitlines()[-1])
        self.assertEqual(by_program["states_hash"], by_module["states_hash"])
        self.assertIn(f"{by_module['libm']}: {by_module['states_hash']}", EXPECTED)

    def test_draws_the_same_picture_by_program_and_by_module(self):
        if not self.root.path("/srv/by_module/run.mcap").exists():
            self.root.python(RUN.format(out="by_module"))
        shape, total, digest = re.fullmatch(r"(\(.*\)) (\d+) (\S+)\n", self.root.python(DRAW.format(before="", after=""),
                                                                                   "by_module/run.mcap")).groups()
        print(shape, total, digest, flush=True)
        self.assertGreater(int(total), 1_000_000)  # not black
        self.root.run("panda-twin", "render", "by_module/run.mcap", "--at", "2", "--out", "there.png")
        # The same log by the build's program, which has Debian's own libraries; without meshes, as the root has none.
        place = work / "installed"
        (place / "bin").mkdir(parents=True, exist_ok=True)
        (place / "share/panda_twin").mkdir(parents=True, exist_ok=True)
        shutil.copy(PROGRAM, place / "bin")
        shutil.copytree(SOURCE / "models", place / "share/panda_twin/models", dirs_exist_ok=True)
        here = work / "here.png"
        other_root.run(place / "bin" / PROGRAM.name, "render", self.root.path("/srv/by_module/run.mcap"), "--at", "2", "--out", here)
        self.assertEqual(here.read_bytes(), self.root.path("/srv/there.png").read_bytes())

    def test_says_that_ffmpeg_and_gnuplot_are_missing(self):
        for video, program in ((True, "ffmpeg"), (False, "gnuplot")):
            said = self.root.python(f"import panda_twin\ntry: panda_twin.run('scenarios/canonical.yaml', out='x', video={video})\n"
                                    "except OSError as error: print(error)")
            self.assertIn(program, said)


class Debian12(Used, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = other_root.OtherRoot(work / "bookworm", wheels["cp311-cp311"], "--bare")
        cls.root.install(("mujoco-core", "tests/python/requirements-wheel-test.txt"),
                         ("panda-python", "scripts/requirements-clients.txt"), ("requests", "scripts/requirements-clients.txt"),
                         ("certifi", "scripts/requirements-clients.txt"), ("charset-normalizer", "scripts/requirements-clients.txt"),
                         ("idna", "scripts/requirements-clients.txt"), ("urllib3", "scripts/requirements-clients.txt"),
                         ("websockets", "scripts/requirements-clients.txt"),
                         ("gymnasium", "scripts/requirements-python.txt"), ("cloudpickle", "scripts/requirements-python.txt"),
                         ("farama-notifications", "scripts/requirements-python.txt"),
                         ("typing-extensions", "scripts/requirements-test.txt"))

    def test_draws_beside_another_mujoco_whichever_comes_first(self):
        if not self.root.path("/srv/by_module/run.mcap").exists():
            self.root.python(RUN.format(out="by_module"))
        alone = self.root.python(DRAW.format(before="", after=""), "by_module/run.mcap")
        other = ("import mujoco; assert mujoco.mj_versionString() == '4.0.0'\n"
                 "model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><body><freejoint/><geom size=\"1\"/></body></worldbody></mujoco>')\n"
                 "mujoco.mj_step(model, mujoco.MjData(model))")
        for order in ({"before": other, "after": ""}, {"before": "", "after": other}):
            self.assertEqual(self.root.python(DRAW.format(**order), "by_module/run.mcap"), alone)

    def test_serves_a_program_made_for_the_robot(self):
        command = self.root.command("panda-twin", "serve", "--bind", "127.53.3.11", "--drive", "lockstep")
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
            try:
                self.wait_for_listener("127.53.3.11")
                error, gravity = map(float, self.root.python(PANDA_PY, "127.53.3.11").split()[-2:])
            finally:
                server.kill()  # unshare, which heeds no other signal, and with it what it runs
        self.assertLess(error, 0.01)
        self.assertGreater(gravity, 1.0)  # by the model library that the wheel has

    @staticmethod
    def wait_for_listener(address):
        octets = "".join(f"{int(part):02X}" for part in reversed(address.split(".")))
        limit = time.monotonic() + 120
        while f"{octets}:{1337:04X} 00000000:0000 0A" not in pathlib.Path("/proc/net/tcp").read_text():
            if time.monotonic() > limit:
                raise AssertionError("panda-twin does not serve")
            time.sleep(0.05)

    def test_has_environments_for_gymnasium(self):
        self.assertGreater(int(self.root.python(GYMNASIUM).split()[-1]), 100)

    def test_takes_the_meshes_of_example_robot_data(self):
        self.assertEqual(self.root.python("import panda_twin._host; print(panda_twin._host.meshes)").strip(), "")
        self.root.install(("example-robot-data", "scripts/requirements-data.txt"))
        try:
            folder = self.root.python("import panda_twin._host; print(panda_twin._host.meshes)").strip()
            self.assertTrue(self.root.path(f"{folder}/meshes/visual/link0.dae").exists())
            said = self.root.run("panda-twin", "validate", "-v", "/opt/panda-twin/lib/python3.11/site-packages/panda_twin/share/"
                                 "panda_twin/models/scenarios/canonical.yaml")
            self.assertIn(folder, said)
        finally:
            self.root.run("pip", "uninstall", "--quiet", "--yes", "example-robot-data")


class Debian13(Used, unittest.TestCase):
    """Another C library, a later Python, no library of the same version."""

    @classmethod
    def setUpClass(cls):
        if "cp312-abi3" not in wheels:
            raise unittest.SkipTest("no Python 3.12 or later, with its headers, is here")
        cls.root = other_root.OtherRoot(work / "trixie", wheels["cp312-abi3"], "--bare", "--suite", "trixie")


if __name__ == "__main__":
    unittest.main()
