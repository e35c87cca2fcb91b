#!/usr/bin/env python3
"""Completion and manual page of the real program: completion_test.py PROGRAM [unittest options]."""

import re
import shutil
import subprocess
import sys
import tempfile
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
        self.assertEqual(self.complete("run", "--robot-time", ""), ["wall", "states"])
        self.assertEqual(self.complete("completion", "z"), ["zsh"])

    def test_leaves_files_to_the_shell(self):
        self.assertEqual(self.complete("run", "sc"), [])
        self.assertEqual(self.complete("run", "--out", ""), [])


class OtherShellsTest(unittest.TestCase):
    def check(self, shell, *arguments):
        script = output_of(PROGRAM, "completion", shell)
        for command in commands_of():
            self.assertIn(command, script)
        if shutil.which(shell) is None:
            return  # scripts/setup installs neither of the two
        with tempfile.NamedTemporaryFile("w") as file:
            file.write(script)
            file.flush()
            output_of(shell, *arguments, file.name)

    def test_zsh_reads_its_script(self):
        self.check("zsh", "-n")

    def test_fish_reads_its_script(self):
        self.check("fish", "-n")

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
