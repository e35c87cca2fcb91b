#!/usr/bin/env python3
"""The program is hardened as Debian's packages are, and its functions are marked for CET: hardening_test.py PROGRAM [unittest options].

The mark by which Linux would switch CET on for a program (GNU property IBT, SHSTK) is on it only if every object that is linked has it.
Debian 12's start-up files (Scrt1.o, crti.o, libc_nonshared.a) do not, so no program of Debian 12 has it: what is checked is our own code.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import hardening

PROGRAM = pathlib.Path()
OURS = "_ZNK?4twin|_ZNK?10panda_twin|main$"
SMALL = "#include <stdio.h>\nint main(int n, char** words) { char text[99]; return sprintf(text, words[0], n); }\n"
UNHARDENED = ("-O2", "-U_FORTIFY_SOURCE", "-no-pie", "-fno-stack-protector", "-fcf-protection=none", "-Wl,-z,norelro,-z,lazy,-z,execstack")
CHECKS = (hardening.is_position_independent, hardening.is_read_only_once_bound, hardening.has_no_executable_stack,
          hardening.guards_its_stacks, hardening.calls_checked_functions)


@unittest.skipUnless(shutil.which("readelf"), "missing: readelf (binutils)")
class HardeningTest(unittest.TestCase):
    def test_the_program_is_hardened(self):
        self.assertEqual([check.__name__ for check in CHECKS if not check(PROGRAM)], [])

    def test_every_function_of_ours_is_marked_for_indirect_calls(self):
        found, without = hardening.functions_without_landing(PROGRAM, OURS)
        self.assertGreater(found, 1000)
        self.assertEqual(without, [])

    def test_a_program_that_is_not_hardened_is_found(self):
        with tempfile.TemporaryDirectory(prefix="panda_twin_unhardened_") as folder:
            source, program = pathlib.Path(folder, "small.c"), pathlib.Path(folder, "small")
            source.write_text(SMALL)
            subprocess.run(["cc", "-w", *UNHARDENED, source, "-o", program], check=True)
            self.assertEqual([check.__name__ for check in CHECKS if check(program)], [])
            self.assertEqual(hardening.functions_without_landing(program, "main$"), (1, ["main"]))


if __name__ == "__main__":
    PROGRAM = pathlib.Path(sys.argv.pop(1))
    unittest.main()
