#!/usr/bin/env python3
"""Which lines, branches and functions of some areas the campaign reaches, as Markdown.

    coverage.py SOURCE [--worlds N] [--seed N] [--kept]

Builds the preset `coverage` in SOURCE/build/coverage, which counts, and runs the campaign there. Fails when an area's share of branches is more than
SLACK points below that of the table in docs/reference/reliability.md, rounded down.

A branch is a way out of a condition. Whether a call throws does not count, nor do lines without code of ours (closing braces: destructors).
A template's instances count as one.

--kept    no build and no run: of the counts that are there
"""

import argparse
import collections
import itertools
import json
import os
import pathlib
import re
import subprocess
import sys

AREAS = ("onboard", "loop", "reference", "server", "fci")
PROGRAM = "panda-twin-campaign"
SLACK = 2
NO_CODE = re.compile(r"[\s{}();,]*(else[\s{]*)?(//.*)?")


def of_conditions(branches):
    """Those that are neither a call's throw nor the return beside it."""
    kept = []
    with_throw = False
    for branch in branches:
        if branch["throw"]:
            with_throw = not (kept and kept[-1]["fallthrough"])
            kept = kept if with_throw else kept[:-1]
        elif with_throw and branch["fallthrough"]:
            with_throw = False
        else:
            kept.append(branch)
    return kept


class File:
    """Counts of one source."""

    def __init__(self, path):
        self.text = path.read_text().splitlines()
        self.lines = collections.Counter()
        self.branches = {}  # counts by (line, so many of one instance)
        self.functions = collections.Counter()
        self.names = {}

    def add(self, counted):
        for function in counted["functions"]:
            place = function["start_line"], function["start_column"]
            self.functions[place] += function["execution_count"]
            self.names[place] = function["demangled_name"]
        for line in counted["lines"]:
            number = line["line_number"]
            self.lines[number] += line["count"]
            ways = [branch["count"] for branch in of_conditions(line["branches"])]
            if len(ways) < 2 or NO_CODE.fullmatch(self.text[number - 1]):
                continue
            before = self.branches.get((number, len(ways)), [0] * len(ways))
            self.branches[number, len(ways)] = [a + b for a, b in zip(before, ways)]

    def counts(self):
        """Of lines, branches and functions: (reached, all)."""
        ways = [way for ways in self.branches.values() for way in ways]
        return [(sum(count > 0 for count in counts), len(counts)) for counts in (self.lines.values(), ways, self.functions.values())]

    def unreached_functions(self):
        names = (self.names[place] for place in sorted(self.functions) if not self.functions[place])
        return list(dict.fromkeys(filter(None, map(short, names))))

    def unreached_branches(self):
        """Lines of which a way was not taken."""
        return sorted({line for (line, _), ways in self.branches.items() if not all(ways)})


def short(name):
    """A function without namespaces, template arguments, arguments and qualifiers; empty: a lambda, which is inside another."""
    if "lambda" in name or name.startswith("_Z"):
        return ""
    name = re.sub(r"\(anonymous namespace\)::|\[abi:\w+\]", "", name).replace("operator()", "operator")
    while re.search(r"<[^<>]*>", name):
        name = re.sub(r"<[^<>]*>", "", name)
    return re.sub(r"\btwin::(?:[a-z]\w*::)*", "", name.split("(")[0]).strip().split(" ")[-1]


def run(*command, **options):
    done = subprocess.run(command, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"coverage.py: {' '.join(map(str, command))} ended with {done.returncode}")
    return done.stdout


def measure(source, build, options):
    run("cmake", "--preset", "coverage", cwd=source, stdout=subprocess.DEVNULL)
    run("cmake", "--build", build, "--target", PROGRAM, "-j", str(os.cpu_count()), stdout=subprocess.DEVNULL)
    for counts in build.rglob("*.gcda"):
        counts.unlink()
    run_worlds(build / "tests/campaign" / PROGRAM, build / "campaign", options)


def run_worlds(program, out, options):
    """In processes, as threads of one would wait for each other at every count."""
    shares = os.cpu_count()
    firsts = [options.seed + options.worlds * share // shares for share in range(shares + 1)]
    commands = [[program, "--worlds", str(end - first), "--seed", str(first), "--threads", "1", "--out", f"{out}-{first}"]
                for first, end in itertools.pairwise(firsts) if end > first]
    for done in [subprocess.Popen(command, stdout=sys.stderr) for command in commands]:
        if done.wait() != 0:
            sys.exit(f"coverage.py: {' '.join(map(str, done.args))} ended with {done.returncode}")


def read(source, build):
    """Files by path below src."""
    files = {}
    for area in AREAS:
        for compiled in sorted((build / "src" / area).rglob("*.gcno")):  # also what no world has made the linker take
            said = json.loads(run("gcov", "--json-format", "--stdout", "--branch-probabilities", compiled, stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL))
            for counted in said["files"]:
                path = pathlib.Path(os.path.normpath(pathlib.Path(said["current_working_directory"]) / counted["file"]))
                if not path.is_relative_to(source / "src") or path.relative_to(source / "src").parts[0] not in AREAS:
                    continue
                name = str(path.relative_to(source / "src"))
                files.setdefault(name, File(path)).add(counted)
    return files


def share(reached, of):
    return 100 * reached / of if of else 100.0


def of_area(files, area):
    """Sums of counts(), of lines, branches and functions."""
    of_files = [file.counts() for name, file in files.items() if name.startswith(area + "/")]
    return [tuple(map(sum, zip(*counts))) for counts in zip(*of_files)]


def table(files):
    yield "| folder | lines | branches | functions |"
    yield "|---|---|---|---|"
    for area in AREAS:
        yield f"| `src/{area}` | " + " | ".join(f"{share(*counts):.1f} % of {counts[1]}" for counts in of_area(files, area)) + " |"


def unreached(files):
    for name, file in sorted(files.items()):
        lines, branches, _ = file.counts()
        yield f"{name}: lines {share(*lines):.1f} %, branches {share(*branches):.1f} %"
        functions = file.unreached_functions()
        if functions:
            yield "    functions not reached: " + ", ".join(functions)
        half = file.unreached_branches()
        if half:
            yield "    lines with branches not taken: " + " ".join(map(str, half))


def told(source):
    """Shares of branches that the document tells, by area."""
    text = (source / "docs/reference/reliability.md").read_text()
    shares = {area: float(branches) for area, branches in
              re.findall(r"^\| `src/(\w+)` \| [\d.]+ % of \d+ \| ([\d.]+) % of \d+ \|", text, re.MULTILINE)}
    if set(shares) != set(AREAS):
        sys.exit(f"coverage.py: reliability.md tells shares of {sorted(shares)}, not of {sorted(AREAS)}")
    return shares


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--worlds", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kept", action="store_true")
    options = parser.parse_args()
    build = options.source / "build/coverage"
    if not options.kept:
        measure(options.source, build, options)
    files = read(options.source, build)
    print("\n".join([*table(files), "", *unreached(files)]))
    fallen = {area: (share(*of_area(files, area)[1]), least) for area, least in told(options.source).items()}
    fallen = {area: (now, least) for area, (now, least) in fallen.items() if now < int(least) - SLACK}
    for area, (now, least) in fallen.items():
        print(f"FAILED: branches of src/{area}: {now:.1f} %, of {least} % once")
    return 1 if fallen else 0


if __name__ == "__main__":
    sys.exit(main())
