#!/usr/bin/env python3
"""Follows the tutorials of docs/tutorials word by word, each in a home of its own: tutorial_test.py BUILD SOURCE.

Fenced blocks are followed in their order, by language:
  sh       runs in one shell, with what the blocks before exported and where they went; "# exit code N" is expected if it is said
  text     its lines stand in what the block of commands before printed
  console  is not run here: it installs from the network, or builds what BUILD holds already (NOT_RUN)
A block of any language with title="FILE" is written to that file. Other blocks fail.
What depends on the machine's speed is replaced (replaced()): the wall clock by lockstep; so is the robot, by a served twin.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "clients"))
from twin_server import ARM_PORT, is_listening, own_address  # noqa: E402

BUILD, SOURCE = "", pathlib.Path()
FENCE = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
NOT_RUN = {
    "scripts/demo\n", "pip install panda-python==1.1.1\n",
    "scripts/setup\nscripts/wheel\npython3 -m venv ~/twin\n. ~/twin/bin/activate\n"
    "pip install out/wheels/panda_twin-*-cp311-*.whl gymnasium panda-python==1.1.1\n",
}


class Shell:
    """A shell whose blocks of commands are given one after the other; ends at the first command that fails."""

    def __init__(self, home, folder):
        path = os.pathsep.join([str(home / "panda-twin/bin"), str(pathlib.Path(sys.executable).parent), os.environ["PATH"]])
        environment = {**os.environ, "HOME": str(home), "PATH": path, "LC_ALL": "C.UTF-8"}
        self.block = home / "block.sh"
        self.process = subprocess.Popen(["bash"], cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True)

    def run(self, commands):
        """Exit code of the last command, or of the first that fails, and all they print."""
        end = "=== end of the block"
        self.block.write_text(commands)
        self.process.stdin.write(f'set -e; . {self.block} </dev/null; set +e; echo; echo "{end}"\n')
        self.process.stdin.flush()
        printed = []
        for line in self.process.stdout:
            if line.startswith(end):
                return 0, "".join(printed)
            printed.append(line)
        return self.process.wait(), "".join(printed)

    def folder(self):
        return pathlib.Path(self.run("pwd\n")[1].split("\n")[0])

    def close(self):
        self.process.stdin.close()
        self.process.wait(timeout=60)
        self.process.stdout.close()


class TutorialTest(unittest.TestCase):
    """Each case follows one tutorial, in the source's folder, so that paths of the repository hold; files go to a folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda-twin-tutorial-")
        self.addCleanup(folder.cleanup)
        self.home = pathlib.Path(folder.name)
        self.address = None
        self.server = None
        self.addCleanup(self.stop_server)

    def install(self):
        subprocess.run(["cmake", "--install", BUILD, "--prefix", self.home / "panda-twin"], check=True, stdout=subprocess.DEVNULL)

    def replaced(self, block):
        block = block.replace("build/release", BUILD)
        block = block.replace("--drive realtime", "--drive lockstep")
        block = re.sub(r"127\.0\.0\.1|172\.16\.0\.2", str(self.address), block)
        block = block.replace("--allow-hardware", "--allow-hardware --yes")  # here is no terminal
        # Before a motion the run measures how states arrive; on a busy machine they are late, and the arm does not move.
        return re.sub(r"^(.* --backend fci .*)$", r"\1 || \1 || \1", block, flags=re.MULTILINE)

    def stop_server(self):
        if self.server:
            self.server.terminate()
            self.server.wait(60)
            self.server = None

    def serve(self, commands, folder):
        """Starts what the tutorial has in a terminal of its own, after the server before it, and waits until it listens."""
        self.stop_server()
        self.address = own_address()
        options = commands.split()[1:] + ([] if "--drive" in commands else ["--drive", "lockstep"])
        self.server = subprocess.Popen([self.home / "panda-twin/bin/panda-twin", *options, "--bind", self.address], cwd=folder,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
        while not is_listening(self.address, ARM_PORT):
            self.assertIsNone(self.server.poll(), f"the server has gone: {commands}")

    def follow(self, name):
        text = (SOURCE / "docs/tutorials" / name).read_text()
        blocks = FENCE.findall(text)
        self.assertEqual(len(blocks), len(re.findall(r"^ *```", text, re.MULTILINE)) / 2, "a block is not understood")
        start = self.home / "work"
        start.mkdir()
        for known in ("build", "controllers", "models", "scripts"):  # of the repository's root, in which the tutorials begin
            (start / known).symlink_to(SOURCE / known)
        shell = Shell(self.home, start)
        self.addCleanup(shell.close)
        printed = ""
        for language, title, block in blocks:
            if title:
                (shell.folder() / title).write_text(block)
            elif language == "console":
                self.assertIn(block, NOT_RUN)
            elif language == "text":
                for line in block.splitlines():
                    self.assertIn(line, printed)
            elif block.startswith("panda-twin serve"):
                self.serve(block, shell.folder())
            else:
                self.assertEqual(language, "sh", block)
                expected = re.search(r"# exit code (\d+)", block)
                if expected:
                    block = f"{block.rstrip()} || test $? -eq {expected.group(1)}\n".replace(expected.group(0), "")
                code, printed = shell.run(self.replaced(block))
                self.assertEqual(code, 0, f"{block}\n{printed}")
        return shell.folder()

    def test_get_started(self):
        self.follow("get-started.md")

    def test_libfranka_program(self):
        if subprocess.run([sys.executable, "-c", "import panda_py"], capture_output=True).returncode:
            self.skipTest("missing: panda-python (scripts/setup)")
        self.install()
        folder = self.follow("libfranka-program.md")
        self.stop_server()
        self.assertTrue((folder / "session.mcap").exists())
        for command in ("explain session.mcap", "decode session.pcapng"):
            subprocess.run([self.home / "panda-twin/bin/panda-twin", *command.split()], cwd=folder, check=True, capture_output=True)

    def test_controller(self):
        folder = self.follow("controller.md")
        for run in ("soft_spring", "stiffer", "served"):
            summary = json.loads((folder / "out" / run / "summary.json").read_text())
            self.assertEqual(summary["outcome"], "success", run)
        for plot in re.findall(r"plots/\w+\.svg", (SOURCE / "docs/tutorials/controller.md").read_text()):
            self.assertTrue((folder / "out/soft_spring" / plot).exists(), plot)

    def test_explain_an_abort(self):
        self.install()
        folder = self.follow("explain-an-abort.md")
        self.assertTrue((folder / "out/jerky/explain.html").exists())

    def test_python(self):
        for module in ("gymnasium", "panda_py"):
            if subprocess.run([sys.executable, "-c", f"import {module}"], capture_output=True).returncode:
                self.skipTest(f"missing: {module} (scripts/setup)")
        folder = self.follow("python.md")
        for file in ("served.mcap", "session.mcap", "plot/scene.png"):
            self.assertTrue((folder / file).exists(), file)

    def test_from_twin_to_robot(self):
        self.install()
        self.follow("from-twin-to-robot.md")

    def test_no_tutorial_is_left_out(self):
        cases = {name[len("test_"):].replace("_", "-") + ".md" for name in dir(self) if name.startswith("test_")}
        self.assertLessEqual({path.name for path in (SOURCE / "docs/tutorials").glob("*.md")}, cases)


class NewControllerTest(unittest.TestCase):
    def new(self, *arguments, folder):
        return subprocess.run([SOURCE / "scripts" / "new-controller", *arguments], cwd=folder, capture_output=True, text=True)

    def test_refuses_what_is_no_name_or_no_empty_folder_and_touches_nothing(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for bad in ("", "Spring", "my-law", "1law", "a/b", "test"):
                done = self.new(bad, folder=folder)
                self.assertEqual(done.returncode, 3, bad)
                self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertEqual(self.new(folder=folder).returncode, 2)
            self.assertEqual(list(folder.iterdir()), [])
            (folder / "mine").mkdir()
            (folder / "mine" / "thesis.txt").write_text("precious")
            done = self.new("law", "mine", folder=folder)
            self.assertEqual((done.returncode, [p.name for p in (folder / "mine").iterdir()]), (3, ["thesis.txt"]))
            (folder / "file").write_text("")
            self.assertEqual(self.new("law", "file", folder=folder).returncode, 3)

    def test_names_class_and_files_after_the_controller(self):
        with tempfile.TemporaryDirectory() as name:
            done = self.new("my_own_law", folder=name)
            self.assertEqual(done.returncode, 0, done.stderr)
            folder = pathlib.Path(name, "my_own_law")
            self.assertEqual(sorted(p.name for p in folder.iterdir()),
                             ["CMakeLists.txt", "my_own_law.cc", "my_own_law.h", "my_own_law.yaml", "my_own_law_test.cc"])
            self.assertIn("class MyOwnLaw final", (folder / "my_own_law.h").read_text())
            for path in folder.iterdir():
                self.assertNotRegex(path.read_text(), r"@\w+@", path.name)


if __name__ == "__main__":
    BUILD, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
