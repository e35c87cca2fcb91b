#!/usr/bin/env python3
"""Every promise of the threat model has a file and a test that exist: check_threat_model.py SOURCE_TREE BUILD [unittest options]."""

import json
import pathlib
import re
import subprocess
import sys
import unittest

SOURCE, BUILD = pathlib.Path(), pathlib.Path()
MODEL = "docs/explanation/threat-model.md"
# Tests that only some builds have: the hardened Release, and those with Fast DDS.
OF_SOME_BUILDS = {"hardening_test": "tests/security/hardening_test.py", "ros2_loopback_test": "tests/ros2/ros2_loopback_test.py",
                  "ros2_cdr_test": "tests/ros2/ros2_cdr_test.cc"}


def promises(text: str) -> list[tuple[str, list[str], str, list[str]]]:
    """The rows of the table: (promise, files, name of a test, its cases). A row that is not like this is an error."""
    table = text.split("\n## Promises\n")[1].split("\n## ")[0]
    rows = []
    for line in [line for line in table.splitlines() if line.startswith("|")][2:]:
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if len(cells) != 3:
            raise ValueError(f"a row has three cells: {line}")
        files, shown = (re.findall(r"`([^`]+)`", cell) for cell in cells[1:])
        if not files or not shown:
            raise ValueError(f"a promise has a file and a test: {line}")
        rows.append((cells[0], files, shown[0], shown[1:]))
    return rows


def sources_of_tests() -> dict[str, pathlib.Path]:
    """The script, or the source, of each test of the build, as ctest knows it."""
    shown = json.loads(subprocess.run(["ctest", "--show-only=json-v1"], cwd=BUILD, check=True, capture_output=True, text=True).stdout)
    stems = {path.stem: path for path in sorted((SOURCE / "tests").rglob("*.cc"))}
    sources = {name: SOURCE / path for name, path in OF_SOME_BUILDS.items()}
    for test in shown["tests"]:
        scripts = [word for word in test.get("command", []) if word.endswith(".py")]
        source = pathlib.Path(scripts[0]) if scripts else stems.get(test["name"])
        if source:
            sources[test["name"]] = source
    return sources


def faults(text: str, sources: dict[str, pathlib.Path]) -> list[str]:
    found = []
    for promise, files, test, cases in promises(text):
        found += [f"{promise}: no file {name}" for name in files if not (SOURCE / name).exists()]
        if test not in sources or not sources[test].is_file():
            found.append(f"{promise}: no test {test}")
            continue
        code = sources[test].read_text()
        for case in cases:
            if not re.search(rf"^\s*def {case}\(self|^TEST\w*\(\w+,\s*{case}\)", code, re.M):
                found.append(f"{promise}: {test} has no case {case}")
    return found


class ThreatModelTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.text, cls.sources = (SOURCE / MODEL).read_text(), sources_of_tests()

    def test_every_promise_has_its_test(self):
        self.assertGreater(len(promises(self.text)), 30)
        self.assertEqual(faults(self.text, self.sources), [])

    def test_what_is_gone_is_found(self):
        row = "\n## Promises\n\n| promise | where | shown by |\n|---|---|---|\n| P | `{}` | `{}` `{}` |\n"
        good = ("CMakeLists.txt", "serve_test", "test_replayed_commands_do_nothing")
        self.assertEqual(faults(row.format(*good), self.sources), [])
        for place, says in enumerate(("no file gone", "no test gone", "no case gone")):
            words = [*good]
            words[place] = "gone"
            found = faults(row.format(*words), self.sources)
            self.assertEqual(len(found), 1)
            self.assertIn(says, found[0])
        with self.assertRaises(ValueError):
            promises("\n## Promises\n|a|b|c|\n|---|---|---|\n| P | `CMakeLists.txt` | trust us |\n")


if __name__ == "__main__":
    SOURCE, BUILD = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
