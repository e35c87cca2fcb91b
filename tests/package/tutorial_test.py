#!/usr/bin/env python3
"""Follows controllers/TUTORIAL.md word by word, in a home of its own: tutorial_test.py BUILD SOURCE.

Every block of shell commands is run in one shell after the other, with what it exported and where it went. Changed are only the folder
of the build, and the address of the served robot, which another test may use at the same time.
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


def blocks(text):
    return re.findall(r"^```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


class Shell:
    """A shell whose commands are given one after the other; ends at the first that fails."""

    def __init__(self, home, folder):
        environment = {**os.environ, "HOME": str(home), "LC_ALL": "C.UTF-8"}
        self.process = subprocess.Popen(["bash"], cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True)

    def run(self, commands):
        """Exit code of the first command that fails, or 0, and all they print."""
        end = "=== end of the block"
        self.process.stdin.write(f"status=0\n")
        for line in commands.strip().splitlines():
            self.process.stdin.write(f"[ $status -ne 0 ] || {{ {line}\n}} </dev/null || status=$?\n")
        self.process.stdin.write(f'echo "{end} $status"\n')
        self.process.stdin.flush()
        said = []
        for line in self.process.stdout:
            if line.startswith(end):
                return int(line.split()[-1]), "".join(said)
            said.append(line)
        return self.process.wait(), "".join(said)

    def close(self):
        self.process.stdin.close()
        self.process.wait(timeout=60)
        self.process.stdout.close()


class TutorialTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda-twin-tutorial-")
        self.addCleanup(folder.cleanup)
        self.home = pathlib.Path(folder.name)
        self.shell = Shell(self.home, SOURCE)
        self.addCleanup(self.shell.close)

    def serve(self, commands, address):
        """Starts what the tutorial has in a terminal of its own, and waits until it listens."""
        program = self.home / "panda-twin" / "bin" / "panda-twin"
        command = [program, *commands.split()[1:], "--bind", address]
        server = subprocess.Popen(command, cwd=self.home / "soft_spring", stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
        self.addCleanup(server.wait, 20)
        self.addCleanup(server.terminate)
        while not is_listening(address, ARM_PORT):
            self.assertIsNone(server.poll(), "the server has gone")

    def test_its_commands_do_what_it_says(self):
        address = own_address()
        text = (SOURCE / "controllers" / "TUTORIAL.md").read_text()
        found = blocks(text)
        self.assertGreaterEqual(len(found), 7)
        for block in found:
            block = block.replace("build/release", BUILD, 1).replace("127.0.0.1", address)
            if block.startswith("panda-twin serve"):
                self.serve(block, address)
                continue
            code, said = self.shell.run(block)
            self.assertEqual(code, 0, f"{block}\n{said}")
        for run in ("soft_spring", "stiffer", "served"):
            summary = json.loads((self.home / "soft_spring" / "out" / run / "summary.json").read_text())
            self.assertEqual(summary["outcome"], "success", run)
        for plot in re.findall(r"plots/\w+\.svg", text):
            self.assertTrue((self.home / "soft_spring" / "out" / "soft_spring" / plot).exists(), plot)


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
