"""A program that has set a locale with decimal commas, as Qt's and GTK's do, gets the same bytes."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = """
import locale, sys
import panda_twin as pt
if sys.argv[1] != "C":
    locale.setlocale(locale.LC_ALL, sys.argv[1])
print(locale.localeconv()["decimal_point"], end="")
for name in ("applications/plan_and_execute", "scenarios/grasp"):
    pt.run(f"{name}.yaml", out=f"{sys.argv[2]}/{name}", video=False)
"""


class LocaleTest(unittest.TestCase):
    def files_in(self, locale, folder, environment):
        done = subprocess.run([sys.executable, "-c", PROGRAM, locale, folder], env=environment, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        files = {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        return done.stdout, {name: text for name, text in files.items() if name.name != "timing.json"}

    def test_decimal_commas_change_nothing(self):
        with tempfile.TemporaryDirectory(prefix="panda_twin_locale_") as name:
            folder = pathlib.Path(name)
            subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", folder / "de_DE.UTF-8"], check=True)
            environment = os.environ | {"LOCPATH": name}
            point, plain = self.files_in("C", folder / "plain", environment)
            comma, localized = self.files_in("de_DE.UTF-8", folder / "localized", environment)
        self.assertEqual((point, comma), (".", ","))
        self.assertGreater(len(plain), 10)
        self.assertEqual(plain.keys(), localized.keys())
        self.assertEqual([name for name in plain if plain[name] != localized[name]], [])


if __name__ == "__main__":
    unittest.main()
