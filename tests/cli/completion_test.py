#!/usr/bin/env python3
"""Completion and manual page of the real program: completion_test.py PROGRAM [unittest options]."""

import os
import pathlib
import pty
import re
import select
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ""


def output_of(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True, **options).stdout


def help_of(*command):
    return output_of(PROGRAM, *command, "--help")


def commands_of(*command):
    """The commands below one, by its help."""
    _, _, listed = help_of(*command).partition("\nSubcommands:\n")
    return re.findall(r"^  (\S+)", listed.partition("\n\n")[0], re.MULTILINE)


def flags_of(*command):
    return re.findall(r"^  (?:-\w,)?(--[\w-]+)", help_of(*command), re.MULTILINE)


class BashTest(unittest.TestCase):
    def complete(self, *words):
        """What bash offers in the place of the last word."""
        script = """source <("$0" completion bash); COMP_WORDS=(panda-twin "$@"); COMP_CWORD=$#; _panda_twin; printf '%s\\n' "${COMPREPLY[@]}" """
        return output_of("bash", "-c", script, PROGRAM, *words).split()

    def test_completes_a_command(self):
        self.assertEqual(self.complete("vali"), ["validate"])
        self.assertEqual(sorted(self.complete("")), sorted(commands_of()))
        self.assertEqual(self.complete("video", "ap"), ["approve"])

    def test_completes_a_flag(self):
        self.assertEqual(self.complete("run", "scenario.yaml", "--see"), ["--seed", "--seeds"])
        for command in (["run"], ["serve"], ["video", "check"]):
            self.assertEqual(sorted(self.complete(*command, "--")), sorted(flags_of(*command)), command)

    def test_completes_a_word_that_stands_for_one_of_a_few(self):
        self.assertEqual(self.complete("run", "--robot-time", ""), ["auto", "wall", "states"])
        self.assertEqual(self.complete("completion", "z"), ["zsh"])

    def test_leaves_files_to_the_shell(self):
        self.assertEqual(self.complete("run", "sc"), [])
        self.assertEqual(self.complete("run", "--out", ""), [])


class FishTest(unittest.TestCase):
    def complete(self, line):
        """What fish offers at the end of the line."""
        return output_of("fish", "--no-config", "-c", '$argv[1] completion fish | source; complete -C "$argv[2]"', PROGRAM, line).splitlines()

    def test_completes_a_command(self):
        self.assertEqual([line.split("\t")[0] for line in self.complete("panda-twin vali")], ["validate"])
        self.assertEqual([line.split("\t")[0] for line in self.complete("panda-twin video ap")], ["approve"])

    def test_completes_a_flag_and_its_words(self):
        self.assertEqual([line.split("\t")[0] for line in self.complete("panda-twin run scenario.yaml --see")], ["--seed", "--seeds"])
        self.assertEqual([line.split("\t")[0] for line in self.complete("panda-twin run --robot-time ")], ["auto", "states", "wall"])


class ZshTest(unittest.TestCase):
    """An interactive zsh at a terminal: its completion runs nowhere else."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_zsh_")
        self.addCleanup(folder.cleanup)
        pathlib.Path(folder.name, "_panda-twin").write_text(output_of(PROGRAM, "completion", "zsh"))
        pathlib.Path(folder.name, "panda-twin").symlink_to(PROGRAM)
        path = f"{folder.name}:{os.environ['PATH']}"
        process, self.terminal = pty.fork()
        if process == 0:
            os.execvpe("zsh", ["zsh", "-f", "-i"], {**os.environ, "TERM": "dumb", "PATH": path, "HOME": folder.name})
        self.addCleanup(os.waitpid, process, 0)
        self.addCleanup(os.close, self.terminal)
        # unsetopt zle_bracketed_paste and a plain prompt: nothing but the line comes back.
        self.type(f"PS1=; unset zle_bracketed_paste; fpath=({folder.name} $fpath); autoload -U compinit; compinit -u -D; echo rea'dy'\n")
        self.read_until("ready")

    def type(self, text):
        os.write(self.terminal, text.encode())

    def read_until(self, wanted):
        said, end = "", time.monotonic() + 60
        while wanted not in said:
            if time.monotonic() > end or not select.select([self.terminal], [], [], 60)[0]:
                self.fail(f"no {wanted!r} from zsh: {said!r}")
            said += os.read(self.terminal, 65536).decode(errors="replace")
        return said

    def test_completes_a_command(self):
        self.type("panda-twin vali\t")
        self.read_until("validate ")
        self.type("\x15panda-twin video ap\t")
        self.read_until("approve ")

    def test_completes_a_flag_and_its_words(self):
        self.type("panda-twin run --sessio\t\x15panda-twin serve --session-t\t")
        self.read_until("--session-timeout")
        self.type("\x15panda-twin run --robot-time st\t")
        self.read_until("states ")


class OtherShellsTest(unittest.TestCase):
    def test_another_is_refused(self):
        done = subprocess.run([PROGRAM, "completion", "tcsh"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (3, ""))
        self.assertIn("name bash, zsh, fish, or man", done.stderr)


class ManTest(unittest.TestCase):
    def test_formats_without_a_warning(self):
        page = output_of(PROGRAM, "completion", "man")
        done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-z"], input=page, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_has_every_command_and_every_flag(self):
        page = output_of(PROGRAM, "completion", "man").replace("\\-", "-")
        commands = [[]] + [[name] for name in commands_of()] + [["video", name] for name in commands_of("video")]
        for command in commands:
            section = page
            if command:
                section = page.partition(f".SS panda-twin {' '.join(command)}\n")[2].partition("\n.SS")[0]
            for flag in flags_of(*command):
                self.assertIn(f"\\fB{flag}\\fR", re.sub(r"-\w, ", "", section), command)


if __name__ == "__main__":
    PROGRAM = sys.argv[1]
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
