"""Mutants of sources, each a single change of its text, and test programs that must catch them.

A script has a list of each, and calls main() with them. The file to change is copied, compiled as the build does, and linked in
front of the libraries into the programs, which run until one fails. A mutant that no program catches is a failure, and so
is a change that no longer applies: then the list wants an update. Needs a build by Ninja with the programs built.
"""

import argparse
import concurrent.futures
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

SECONDS = 200


class Build:
    """How the build compiles a source and links a program. folder: of the programs, below the build's."""

    def __init__(self, source, build, folder):
        self.source = source
        self.build = build
        self.folder = folder
        entries = json.loads((build / "compile_commands.json").read_text())
        self.commands = {entry["file"]: entry["command"] for entry in entries}

    def run(self, command):
        done = subprocess.run(command, cwd=self.build, shell=True, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{command[:200]} ...\n{done.stderr[-3000:]}")
        return done.stdout

    def compiled_in(self, file):
        """What the build compiles for a source: itself, or the unity source that includes it."""
        source = str(self.source / file)
        if source in self.commands:
            return pathlib.Path(source)
        for unity in self.commands:
            if "/Unity/" in unity and f'#include "{source}"\n' in pathlib.Path(unity).read_text():
                return pathlib.Path(unity)
        raise RuntimeError(f"the build compiles no {file}")

    def compile(self, file, text, scratch):
        """The object of a changed source."""
        changed = scratch / pathlib.Path(file).name
        changed.write_text(text)
        compiled = self.compiled_in(file)
        unit = changed
        if compiled != self.source / file:
            unit = scratch / "unity.cc"
            unit.write_text(compiled.read_text().replace(str(self.source / file), str(changed)))
        words = shlex.split(self.commands[str(compiled)])
        words[words.index("-o") + 1] = str(scratch / "mutant.o")
        words[words.index("-c") + 1] = str(unit)
        kept = [word for word in words if not word.endswith("ccache")]
        self.run(shlex.join(kept + ["-O1", "-Wno-error"]))  # a mutant may leave something unused
        return scratch / "mutant.o"

    def link(self, program, file, mutant, scratch):
        """The program with the mutant of a source in front of the libraries; None when the source is no part of it."""
        commands = self.run(f"ninja -t commands {program}").strip().splitlines()
        if not any(command.endswith(f" -c {self.compiled_in(file)}") for command in commands):
            return None
        last = commands[-1]
        word = f" -o {self.folder}/{program} "
        if last.count(word) != 1:
            raise RuntimeError(f"no link command of {program}: {last[:300]}")
        linked = scratch / program
        self.run(last.replace(word, f" -o {linked} {mutant} "))
        return linked

    def read(self, file, old):
        """The text of a source in which the change applies to one place."""
        text = (self.source / file).read_text()
        if text.count(old) != 1:
            raise RuntimeError(f"the change applies to {text.count(old)} places of {file}, not to one: {old!r}")
        return text


def run(program, arguments):
    """How the program fails, the names of its failed cases among it; None when it does not."""
    try:
        done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return " (does not end)"
    if done.returncode == 0:
        return None
    cases = dict.fromkeys(re.findall(r"^\[  FAILED  \] (\w+\.\w+)", done.stdout, re.MULTILINE))
    return "".join(f" {case}" for case in cases)


def catch(build, catchers, mutant, all_of_them):
    """The first program that fails with the mutant, or all of them; None when all pass."""
    _, file, old, new = mutant
    text = build.read(file, old).replace(old, new)
    caught = []
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        changed = build.compile(file, text, scratch)
        linked = {program: build.link(program, file, changed, scratch) for program in {program for program, _ in catchers}}
        for program, arguments in catchers:
            failure = run(linked[program], arguments) if linked[program] else None
            if failure is not None:
                caught.append(" ".join([program, *arguments]) + failure)
                if not all_of_them:
                    break
    return "; ".join(caught) or None


def main(text, folder, catchers, mutants, quick):
    """Ends the script. text: what it is, for --help.

    folder    of the programs, below the build's
    catchers  (program, arguments), cheapest first
    mutants   (name, file below the source's root, text, its replacement)
    quick     names of the few that --quick takes
    """
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--source", type=pathlib.Path, required=True)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--quick", action="store_true", help="a few that stand for the rest")
    parser.add_argument("--only", metavar="NAME", help="one mutant")
    parser.add_argument("--all", action="store_true", help="say of each mutant all that catches it, not the first")
    options = parser.parse_args()
    build = Build(options.source, options.build, folder)

    chosen = [m for m in mutants if (not options.quick or m[0] in quick) and options.only in (None, m[0])]
    for _, file, old, _ in mutants:
        build.read(file, old)  # all of them, so that a quick run already tells what no longer applies
    for program, arguments in catchers:
        if run(options.build / folder / program, arguments) is not None:
            sys.exit(f"{program} fails without any mutant: what it would catch says nothing")
    survivors = []
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        for mutant, catcher in zip(chosen, pool.map(lambda m: catch(build, catchers, m, options.all), chosen)):
            print(f"{'caught' if catcher else 'SURVIVES'}: {mutant[0]}" + (f" ({catcher})" if catcher else ""), flush=True)
            if not catcher:
                survivors.append(mutant[0])
    print(f"{len(chosen) - len(survivors)} of {len(chosen)} mutants caught")
    sys.exit(1 if survivors or not chosen else 0)
