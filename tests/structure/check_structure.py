#!/usr/bin/env python3
"""Checks rules about the tree that no compiler sees.

    check_structure.py ROOT         checks the tree at ROOT; prints every breach as file:line: text
    check_structure.py --self-test  checks that every rule rejects the input made to break it

Exit code 0 when nothing is wrong, 1 otherwise.
"""

import pathlib
import re
import sys
import tempfile

CODE_FOLDERS = ("include", "src", "plugins", "controllers", "python", "tests")
TEXT_FOLDERS = CODE_FOLDERS + ("docs", "scripts", "models", ".ci")
TEXT_SUFFIXES = {".h", ".cc", ".py", ".txt", ".cmake", ".in", ".md", ".yaml", ".xml", ".urdf", ".proto", ".json", ""}
MOST_LINES = 600

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
CLOCK = re.compile(r"(steady|system|high_resolution|utc|file)_clock\b|\bclock_gettime\b|\bgettimeofday\b|(?<![.>])\btime\((nullptr|NULL|0)\)")
RANDOMNESS = re.compile(r"\bs?rand\(|\brandom_device\b|\bmt19937|\bdefault_random_engine\b|\bdrand48\b")
ENVIRONMENT = re.compile(r"\bgetenv\(")
MACHINE_PATH = re.compile(r"(?<![\w.])/(work|root|home/\w+)/|[.][.]/shared\b")
HTML = re.compile(r"<(!DOCTYPE|html|table|t[rdh]|h[1-6]|div|pre|script|style|figure)[ >]")
LOOSE_TODO = re.compile(r"\b(TODO|FIXME|XXX)\b(?!\(#\d+\))")

TERMS = dict(line.split(" ", 1) for line in pathlib.Path(__file__).with_name("terms.txt").read_text().splitlines() if line[:1] != "#")
STRING = re.compile(r'"(\\.|[^"\\])*"')
WORD_OF_IDENTIFIER = re.compile(r"[A-Z]?[a-z]+")

CLOCK_READERS = ("src/core/clock.cc", "src/rt/", "plugins/ros2/fast_dds.cc")  # the last: a signature of DDS's names one
MUJOCO_USERS = ("src/plant/", "src/planning/", "src/render/", "plugins/emulated/", "tests/")
TRUTH_USERS = ("include/twin/plant/", "src/plant/", "include/twin/render/", "src/render/", "plugins/emulated/", "tests/",
               "include/twin/application/application.h", "src/page/live_page.cc", "include/twin/run/run_records.h")
TRUTH = {"twin/plant/truth_probe.h": TRUTH_USERS, "twin/plant/contact_watch.h": (*TRUTH_USERS, "include/twin/run/"),
         "twin/plant/object_watch.h": TRUTH_USERS}
PLUG_IN_NAMERS = ("src/cli/", "python/", "plugins/", "controllers/", "tests/")
ENVIRONMENT_READERS = ("src/cli/", "tests/")


def areas_in_order(root):
    """The areas, as src/CMakeLists.txt builds them: an area may use itself and those before it."""
    text = (root / "src/CMakeLists.txt").read_text()
    return re.search(r"foreach\(area ([^)]*)\)", text).group(1).split()


def area_of(path):
    """The area a file belongs to, or None (plug-ins, controllers, tests: above every area)."""
    match = re.match(r"(?:include/twin|src)/(\w+)/", path)
    return match.group(1) if match else None


def area_of_include(included, areas):
    """The area an include names: "twin/rt/x.h" is public, "rt/x.h" private; None when it names none."""
    parts = included.split("/")
    if parts[0] == "twin" and len(parts) > 2:
        return parts[1]
    return parts[0] if len(parts) > 1 and parts[0] in areas else None


def check_include(path, included, areas):
    """The breaches of one include."""
    mine = area_of(path)
    theirs = area_of_include(included, areas)
    if mine and theirs:
        if theirs not in areas:
            yield f'includes "{included}" of an area that src/CMakeLists.txt does not list'
        elif mine not in areas:
            yield f'belongs to an area that src/CMakeLists.txt does not list'
        elif areas.index(theirs) > areas.index(mine):
            yield f'includes "{included}": area {theirs} comes after {mine}'
        elif not included.startswith("twin/") and theirs != mine:
            yield f'includes "{included}", a private header of area {theirs}'
        if mine == "onboard" and theirs == "plant":
            yield f'includes "{included}": the onboard controller knows no plant'
    if included.startswith("mujoco/") and not path.startswith(MUJOCO_USERS):
        yield f"includes <{included}>: MuJoCo stays inside {', '.join(MUJOCO_USERS)}"
    if included in TRUTH and not path.startswith(TRUTH[included]):
        yield f'includes "{included}": ground truth, as of the truth probe, is for render, experiments and tests'
    if included.startswith(("plugins/", "controllers/")) and not path.startswith(PLUG_IN_NAMERS):
        yield f'includes "{included}": only cli and python name plug-ins and controllers'


def check_line(path, line, areas):
    """The breaches of one line of code."""
    include = INCLUDE.match(line)
    if include:
        yield from check_include(path, include.group(1), areas)
        return
    code = line.split("//")[0]
    product = not path.startswith("tests/")
    if product and CLOCK.search(code) and not path.startswith(CLOCK_READERS):
        yield "reads a clock: use core/clock.h"
    if RANDOMNESS.search(code):
        yield "uses a random source of its own: use core/random.h"
    if ENVIRONMENT.search(code) and not path.startswith(ENVIRONMENT_READERS):
        yield "reads the environment: only cli does"
    if product and HTML.search(code):
        yield "writes HTML: pages are templates in src/report/templates"
    words = {word.lower() for word in WORD_OF_IDENTIFIER.findall(STRING.sub("", code))} if product else set()
    for word in sorted(words & TERMS.keys()):
        yield f"an identifier says {word}: the term is {TERMS[word]} (tests/structure/terms.txt)"


def check_code(path, lines, areas):
    """The breaches of one source or header file, as (line number, text)."""
    if not re.fullmatch(r"[a-z0-9_]+", pathlib.PurePath(path).stem):
        yield 1, "file names are lower_snake"
    if path.endswith(".h") and "#pragma once" not in lines:
        yield 1, "a header says #pragma once"
    for number, line in enumerate(lines, 1):
        for text in check_line(path, line, areas):
            yield number, text


def check_text(path, lines):
    """The breaches any text file can have, as (line number, text)."""
    if len(lines) > MOST_LINES and path.endswith((".h", ".cc", ".py")):
        yield len(lines), f"has {len(lines)} lines; split it, at most {MOST_LINES}"
    for number, line in enumerate(lines, 1):
        if MACHINE_PATH.search(line):
            yield number, "names a path of one machine"
        if LOOSE_TODO.search(line) and not path.endswith((".md", "check_structure.py")):
            yield number, "a TODO names its issue: TODO(#12)"


LINK = re.compile(r"\[[^\]]*\]\(([^)\s#]+)[^)]*\)")
QUOTE = re.compile(r"<!-- file: (\S+) -->\n```\w*(?: title=\"[^\"]+\")?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PICTURES = "docs/images"


def check_notes(root, files):
    """Links of notes to files that are not there, and quotations that differ from the file they name."""
    for path in files:
        if not path.endswith(".md"):
            continue
        text = (root / path).read_text(errors="replace")
        for number, line in enumerate(text.splitlines(), 1):
            for target in LINK.findall(line):
                if ":" not in target and not (root / path).parent.joinpath(target).exists():
                    yield path, number, f"links to {target}, which does not exist"
        for quote in QUOTE.finditer(text):
            file = root / quote.group(1)
            if not file.is_file() or file.read_text() != quote.group(2):
                yield path, text.count("\n", 0, quote.start()) + 1, f"quotes {quote.group(1)}, which differs"


def check_pictures(root):
    """Pictures that scripts/gallery does not draw."""
    drawn = (root / "scripts/gallery").read_text() if (root / "scripts/gallery").is_file() else ""
    for picture in sorted((root / PICTURES).glob("*")):
        if picture.stem not in drawn:
            yield f"{PICTURES}/{picture.name}", 1, "is not drawn by scripts/gallery"


def check_listed(root, folder_files):
    """Test programs and sources that no CMakeLists.txt beside them names: they would never run."""
    for path in folder_files:
        if not path.endswith(".cc") or not path.startswith(("tests/", "src/", "python/")):
            continue
        folder = root / pathlib.PurePath(path).parent
        while not (folder / "CMakeLists.txt").exists() and folder != root:
            folder = folder.parent
        if pathlib.PurePath(path).stem not in (folder / "CMakeLists.txt").read_text():
            yield path, 1, f"is not named in {folder.relative_to(root)}/CMakeLists.txt"


def text_files(root):
    """Paths of the files to check, relative to root, with forward slashes."""
    found = [path for path in root.iterdir() if path.is_file() and path.name != ".git"]  # a file where this is a worktree
    for folder in TEXT_FOLDERS:
        found += [path for path in (root / folder).rglob("*") if path.is_file()]
    kept = (path for path in found if path.suffix in TEXT_SUFFIXES and "__pycache__" not in path.parts)
    return sorted(path.relative_to(root).as_posix() for path in kept)


def check_tree(root):
    """All breaches of the tree, as "file:line: text"."""
    areas = areas_in_order(root)
    files = text_files(root)
    breaches = [*check_listed(root, files), *check_notes(root, files), *check_pictures(root)]
    for path in files:
        lines = (root / path).read_text(errors="replace").splitlines()
        breaches += [(path, number, text) for number, text in check_text(path, lines)]
        if path.startswith(CODE_FOLDERS) and path.endswith((".h", ".cc")):
            breaches += [(path, number, text) for number, text in check_code(path, lines, areas)]
    return [f"{path}:{number}: {text}" for path, number, text in breaches]


# Each case: a file added to a sound tree, and what must be said about it ("" means: nothing).
SELF_TEST = [
    ("src/rt/a.cc", '#include "twin/core/x.h"\n#include "rt/private.h"\n#include <vector>\n', ""),
    ("src/core/a.cc", '#include "twin/rt/x.h"\n', "area rt comes after core"),
    ("src/rt/a.cc", "class ErrandBox;\n", "the term is Call"),
    ("src/rt/a.cc", 'Say("an errand");  // an errand\n', ""),
    ("include/twin/core/a.h", '#pragma once\n#include "twin/plant/x.h"\n', "area plant comes after core"),
    ("src/rt/a.cc", '#include "core/private.h"\n', "a private header of area core"),
    ("src/rt/a.cc", '#include "twin/elsewhere/x.h"\n', "does not list"),
    ("src/onboard/a.cc", '#include "twin/plant/x.h"\n', "knows no plant"),
    ("include/twin/plant/a.h", "#pragma once\n#include <mujoco/mujoco.h>\n", "MuJoCo stays inside"),
    ("src/onboard/a.cc", "#include <mujoco/mujoco.h>\n", "MuJoCo stays inside"),
    ("src/plant/a.cc", "#include <mujoco/mujoco.h>\n", ""),
    ("controllers/a.cc", '#include "twin/plant/truth_probe.h"\n', "truth probe"),
    ("controllers/a.cc", '#include "twin/plant/contact_watch.h"\n', "ground truth"),
    ("src/cli/a.cc", '#include "twin/plant/object_watch.h"\n', "ground truth"),
    ("src/application/a.cc", '#include "twin/plant/truth_probe.h"\n', "ground truth"),
    ("include/twin/application/application.h", '#pragma once\n#include "twin/plant/truth_probe.h"\n', ""),
    ("src/onboard/a.cc", '#include "plugins/emulated/x.h"\n', "only cli and python name plug-ins"),
    ("src/core/a.cc", "auto t = std::chrono::steady_clock::now();\n", "reads a clock"),
    ("src/core/a.cc", "clock_gettime(CLOCK_MONOTONIC, &t);\n", "reads a clock"),
    ("src/core/clock.cc", "auto t = std::chrono::steady_clock::now();\n", ""),
    ("src/core/a.cc", "// steady_clock would be wrong here\n", ""),
    ("src/core/a.cc", "std::mt19937 generator;\n", "random source"),
    ("tests/core/a_test.cc", "int x = rand();\n", "random source"),
    ("src/core/a.cc", 'std::getenv("HOME");\n', "reads the environment"),
    ("src/golden/a.cc", 'page += "<td>";\n', "writes HTML"),
    ("include/twin/core/a.h", "int x;\n", "#pragma once"),
    ("src/core/BadName.cc", "int x;\n", "lower_snake"),
    ("src/core/a.cc", "int x;\n" * 601, "split it"),
    ("src/core/a.cc", "// TO" "DO: later\n", "names its issue"),
    ("src/core/a.cc", "// TO" "DO(#12): later\n", ""),
    ("README.md", "see /wo" "rk/main\n", "path of one machine"),
    ("models/robots/a.yaml", "file: ../sha" "red/data.json\n", "path of one machine"),
    ("README.md", "![a picture](models/there_is_none.png)\n", "which does not exist"),
    ("README.md", "see [a note](docs/there_is_none.md#part)\n", "which does not exist"),
    ("README.md", "<!-- file: src/core/CMakeLists.txt -->\n```cmake\nb.cc\n```\n", "which differs"),
    ("README.md", "<!-- file: src/core/CMakeLists.txt -->\n```cmake title=\"a\"\nb.cc\n```\n", "which differs"),
    ("README.md", "<!-- file: src/core/CMakeLists.txt -->\n```cmake\na.cc a_test clock.cc BadName.cc\n```\n", ""),
    ("README.md", "![a picture](https://example.com/a.png)\n", ""),
    ("docs/images/forgotten.png", "", "is not drawn by scripts/gallery"),
    ("src/core/unlisted.cc", "int x;\n", "is not named"),
    ("tests/core/unlisted_test.cc", "int x;\n", "is not named"),
]


def self_test():
    """@returns what went wrong, one text per case."""
    failures = []
    for path, content, expected in SELF_TEST:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            sound = {"src/CMakeLists.txt": "foreach(area core rt plant onboard application cli)\n"}
            for area in ("src/core", "src/rt", "src/plant", "src/onboard", "src/application", "src/cli", "tests/core"):
                sound[f"{area}/CMakeLists.txt"] = "a.cc a_test clock.cc BadName.cc\n"
            for name, text in {**sound, path: content}.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            breaches = check_tree(root)
        if (len(breaches) != 1 or expected not in breaches[0]) if expected else breaches:
            failures.append(f"{path} with {content[:60]!r}: expected {expected or 'nothing'!r}, got {breaches}")
    return failures


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    wrong = self_test() if sys.argv[1] == "--self-test" else check_tree(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(wrong) if wrong else "structure: sound")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
