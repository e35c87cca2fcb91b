#!/usr/bin/env python3
"""The list of what is linked: sbom_test.py PROGRAM SOURCE_TREE BUILD [unittest options]."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE, BUILD = "", pathlib.Path(), pathlib.Path()
# Required of a document, of its creation and of a package by SPDX 2.3, clauses 6 and 7.
OF_DOCUMENT = {"spdxVersion", "dataLicense", "SPDXID", "name", "documentNamespace", "creationInfo", "packages", "relationships"}
OF_PACKAGE = {"name", "SPDXID", "downloadLocation"}
# Headers of the compiler and of the C library, whose libraries are listed where they are linked.
TOOLCHAIN = {"gcc-12", "glibc", "linux"}
# Used by tests, benchmarks, tracepoints and the Python module, which the program is not made of.
OF_TESTS = {"googletest", "benchmark", "qhull", "ust", "liburcu", "python3.11"}


def sbom(*words, **environment):
    return subprocess.run([SOURCE / "scripts/sbom", *words], capture_output=True, text=True, env={**os.environ, **environment})


class SbomTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made = sbom(PROGRAM, SOURCE_DATE_EPOCH="1700000000")
        cls.document = json.loads(cls.made.stdout)
        cls.packages = {one["name"]: one for one in cls.document["packages"]}

    def test_has_what_spdx_requires(self):
        self.assertEqual(OF_DOCUMENT - self.document.keys(), set())
        self.assertEqual((self.document["spdxVersion"], self.document["dataLicense"], self.document["SPDXID"]),
                         ("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"))
        self.assertEqual(self.document["creationInfo"]["created"], "2023-11-14T22:13:20Z")
        self.assertTrue(all(re.match("(Person|Organization|Tool): ", one) for one in self.document["creationInfo"]["creators"]))
        self.assertRegex(self.document["documentNamespace"], r"^https://[^#]+$")
        ids = [one["SPDXID"] for one in self.document["packages"]]
        self.assertEqual(len(ids), len(set(ids)))
        for one in self.document["packages"]:
            self.assertEqual(OF_PACKAGE - one.keys(), set(), one["name"])
            self.assertRegex(one["SPDXID"], r"^SPDXRef-[A-Za-z0-9.-]+$")
            self.assertRegex(one["downloadLocation"], r"^(https://\S+|NOASSERTION)$")
            self.assertTrue(one["versionInfo"])
        for one in self.document["relationships"]:
            self.assertLessEqual({one["spdxElementId"], one["relatedSpdxElement"]}, {*ids, "SPDXRef-DOCUMENT"})

    def test_our_program_is_what_it_describes(self):
        described = [one["relatedSpdxElement"] for one in self.document["relationships"] if one["relationshipType"] == "DESCRIBES"]
        self.assertEqual(described, [self.packages["panda-twin"]["SPDXID"]])

    def linked_by(self, kind):
        root = self.packages["panda-twin"]["SPDXID"]
        found = {one["relatedSpdxElement"] for one in self.document["relationships"] if (one["spdxElementId"], one["relationshipType"]) == (root, kind)}
        return [one for one in self.document["packages"] if one["SPDXID"] in found]

    def test_every_library_that_is_asked_for_is_there(self):
        asked = re.findall(r"\(NEEDED\).*\[(.+)\]", subprocess.run(["readelf", "-dW", PROGRAM], check=True, capture_output=True, text=True).stdout)
        listed = {name for one in self.linked_by("DYNAMIC_LINK") for name in one["comment"].removeprefix("libraries ").split(", ")}
        self.assertGreater(len(asked), 10)
        self.assertEqual([name for name in asked if name not in listed], [])

    def test_every_library_that_is_loaded_is_there(self):
        loaded = re.findall(r"^\s+(?:/\S+/)?(\S+\.so\S*)", subprocess.run(["ldd", PROGRAM], check=True, capture_output=True, text=True).stdout, re.M)
        listed = {name for one in self.packages.values() for name in one["comment"].removeprefix("libraries ").split(", ")}
        self.assertEqual([name for name in loaded if name not in listed and "vdso" not in name], [])

    def test_every_header_that_was_compiled_is_of_a_listed_source(self):
        """By what the compiler told ninja, and dpkg's lists of files."""
        read = subprocess.run(["ninja", "-C", BUILD, "-t", "deps"], check=True, capture_output=True, text=True).stdout
        headers = {os.path.realpath(name) for name in re.findall(r"^\s+(/usr/(?:include|lib)/\S+)", read, re.M)}
        self.assertGreater(len(headers), 500)
        owners = set()
        for files in pathlib.Path("/var/lib/dpkg/info").glob("*.list"):
            if not headers.isdisjoint(files.read_text(errors="replace").splitlines()):
                owners.add(files.stem.split(":")[0])
        sources = set(subprocess.run(["dpkg-query", "-W", "-f", "${source:Package}\n", *owners], check=True, capture_output=True,
                                     text=True).stdout.split())
        listed = {one["sourceInfo"].split()[-2] for one in self.packages.values() if "sourceInfo" in one}
        self.assertEqual(sources - listed - TOOLCHAIN - OF_TESTS, set())

    def test_two_are_equal(self):
        self.assertEqual(sbom(PROGRAM, SOURCE_DATE_EPOCH="1700000000").stdout, self.made.stdout)

    def test_what_cannot_be_is_said(self):
        with tempfile.NamedTemporaryFile() as text:
            for program in ("/nonexistent", text.name):
                done = sbom(program)
                self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (4, "", 1), done.stderr)
                self.assertIn(program, done.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE, BUILD = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
