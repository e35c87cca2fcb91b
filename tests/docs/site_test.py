#!/usr/bin/env python3
"""Builds the site of documents and looks into it: site_test.py PROGRAM SOURCE [unittest options]."""

import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = "", pathlib.Path()


def build(*arguments):
    """Runs mkdocs as scripts/docs does, with this test's program."""
    return subprocess.run([SOURCE / "scripts/docs", *arguments], env={**os.environ, "TWIN_PROGRAM": PROGRAM}, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)


@unittest.skipUnless(importlib.util.find_spec("mkdocs") and shutil.which("doxygen"), "missing: MkDocs or doxygen (scripts/setup)")
class SiteTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_site_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.site = cls.folder / "site"
        cls.built = build("--site-dir", cls.site)

    def page(self, name):
        return (self.site / name).read_text()

    def test_builds_without_a_warning(self):
        self.assertEqual(self.built.returncode, 0, self.built.stdout)
        self.assertNotIn("WARNING", self.built.stdout)

    def test_its_catalogue_has_every_error_that_the_program_explains(self):
        catalogue = subprocess.run([PROGRAM, "explain", "--errors"], capture_output=True, text=True, check=True).stdout
        errors = re.findall(r"^## \d+ (\w+)$", catalogue, re.MULTILINE)
        self.assertGreater(len(errors), 35)
        page = self.page("reference/errors.html")
        self.assertEqual([error for error in errors if error not in page], [])

    def test_its_command_line_has_every_command(self):
        page = self.page("reference/command-line.html")
        for command in ("run", "serve", "proxy", "render", "explain"):
            self.assertIn(f'<h2 id="{command}">', page)
        self.assertIn("--allow-hardware", page)

    def test_links_lead_to_pages_and_to_the_interface_of_the_library(self):
        self.assertIn('href="api/index.html"', self.page("reference/cpp.html"))
        self.assertTrue((self.site / "reference/api/index.html").exists())
        self.assertIn('href="explanation/guarantee.html"', self.page("index.html"))

    def test_refuses_a_link_to_nothing(self):
        documents = self.folder / "docs"
        shutil.copytree(SOURCE / "docs", documents)
        with open(documents / "index.md", "a") as page:
            page.write("\n[a page](nowhere.md)\n")
        config = self.folder / "mkdocs.yml"
        config.write_text(f"INHERIT: {SOURCE}/mkdocs.yml\ndocs_dir: {documents}\nhooks: [{SOURCE}/scripts/site/hooks.py]\n")
        built = build("-f", config, "--site-dir", self.folder / "other")
        self.assertEqual(built.returncode, 1)
        self.assertIn("nowhere.md, which does not exist", built.stdout)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
