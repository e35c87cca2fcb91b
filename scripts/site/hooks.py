"""Hooks of MkDocs (mkdocs.yml): pages from notes beside the code, pages from the program's output, the C++ API.

Links in a page count from its file in the repository, so that they also work where the repository is browsed. A link to a file that
the site does not hold becomes the file's path; a link to a file that does not exist is an error.
"""

import logging
import os
import pathlib
import posixpath
import re
import subprocess

from mkdocs.structure.files import File

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("TWIN_PROGRAM", str(ROOT / "build/release/panda-twin"))
log = logging.getLogger("mkdocs.hooks")

# Page of the site: file of the repository.
NOTES = {
    "how-to/applications.md": "models/applications/README.md",
    "how-to/labs.md": "models/labs/README.md",
    "how-to/devices.md": "plugins/devices/README.md",
    "how-to/video-regression.md": "src/golden/README.md",
    "how-to/calibrate.md": "models/experiments/README.md",
    "reference/scenarios.md": "models/scenarios/README.md",
    "reference/keys.md": "models/scenarios/KEYS.md",
    "reference/controllers.md": "controllers/README.md",
    "reference/panda.md": "models/robots/panda/README.md",
    "reference/fr3.md": "models/robots/fr3/README.md",
    "reference/hand.md": "models/robots/hand/README.md",
    "reference/cobot-pump.md": "models/robots/cobot_pump/README.md",
    "reference/husky.md": "models/robots/husky/README.md",
    "reference/changes.md": "CHANGELOG.md",
    "explanation/architecture.md": "include/twin/README.md",
    "explanation/generators.md": "src/reference/CHAINS.md",
    "explanation/guarantee.md": "src/reference/VIABILITY.md",
    "explanation/teleoperation.md": "src/teleop/README.md",
    "explanation/rendering.md": "src/render/README.md",
}
PAGE_OF_NOTE = {note: page for page, note in NOTES.items()}

FENCE = re.compile(r"^( *)(```|~~~)")
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
LIST_ITEM = re.compile(r"(?:[-*]|\d+\.) ")
OUTPUT = re.compile(r"<!-- output: panda-twin (.*?) -->")
QUOTED = re.compile(r"<!-- code: (\w+) (\S+) -->")


def run_program(arguments):
    """What the program prints, or an empty text and a warning, which fails a strict build."""
    try:
        return subprocess.run([PROGRAM, *arguments.split()], capture_output=True, text=True, check=True, cwd=ROOT).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        log.warning("%s %s: %s. Build it, or set TWIN_PROGRAM", PROGRAM, arguments, error)
        return ""


def commands():
    """The names of the program's commands, as --help lists them."""
    listed = re.search(r"^Subcommands:\n((?:  .*\n)+)", run_program("--help"), re.MULTILINE | re.IGNORECASE)
    return re.findall(r"^  (\w[\w-]*)", listed.group(1), re.MULTILINE) if listed else []


def output(arguments):
    """The program's output as Markdown: as it is, without its title, when it is Markdown already."""
    if arguments == "COMMAND --help":
        return "\n".join(f"## {name}\n\n{output(f'{name} --help')}" for name in commands())
    text = run_program(arguments)
    return text.split("\n", 1)[1] if text.startswith("# ") else f"```text\n{text}```\n"


def source_of(page):
    """The file of the repository that a page of the site is made of."""
    return NOTES.get(page, f"docs/{page}")


def rewrite_link(page, match):
    """One Markdown link of a page, for the site."""
    bang, text, target = match.groups()
    if re.match(r"[a-z]+:|#", target):
        return match.group(0)
    path, hash_, anchor = target.partition("#")
    source = posixpath.normpath(posixpath.join(posixpath.dirname(source_of(page)), path))
    if not (ROOT / source).exists():
        log.warning("%s links to %s, which does not exist", source_of(page), target)
    there = PAGE_OF_NOTE.get(source) or (source[len("docs/"):] if source.startswith("docs/") else None)
    if there is None:
        in_brackets = match.string[:match.start()].endswith("(")
        return f"`{source}`" if in_brackets else f"{text} (`{source}`)"
    return f"{bang}[{text}]({posixpath.relpath(there, posixpath.dirname(page) or '.')}{hash_}{anchor})"


def on_files(files, config):
    for page, note in NOTES.items():
        files.append(File.generated(config, page, abs_src_path=str(ROOT / note)))
    return files


def on_page_markdown(markdown, page, **_):
    """Links; output of the program; the blank line before a list, which GitHub does without."""
    lines, fence, before = [], None, ""
    for line in markdown.splitlines():
        mark = FENCE.match(line)
        if mark:
            fence = None if fence else mark.group(2)
        elif not fence:
            line = LINK.sub(lambda match: rewrite_link(page.file.src_uri, match), line)
            line = QUOTED.sub(lambda match: f"```{match.group(1)}\n{(ROOT / match.group(2)).read_text()}```", line)
            line = OUTPUT.sub(lambda match: output(match.group(1)), line)
            if LIST_ITEM.match(line) and before and not LIST_ITEM.match(before) and not before.startswith(" "):
                lines.append("")
        lines.append(line)
        before = line
    return "\n".join(lines)


def on_post_build(config):
    """The C++ API, by Doxygen, beside the page that links to it."""
    settings = (ROOT / "scripts/site/Doxyfile").read_text() + f"\nOUTPUT_DIRECTORY = {config.site_dir}/reference\n"
    try:
        subprocess.run(["doxygen", "-"], input=settings, text=True, check=True, cwd=ROOT, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        log.warning("the C++ API is missing: %s", error)
