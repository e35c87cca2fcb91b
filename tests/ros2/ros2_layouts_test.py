"""Compares bytes and type hashes of our messages with those of rosbags, which comes from PyPI into a Python environment in the build folder.

    ros2_layouts_test.py PRINT_MESSAGES SOURCE_TREE BUILD_FOLDER
"""

import hashlib
import pathlib
import shutil
import subprocess
import sys
import unittest
import venv

PROGRAM, SOURCE, BUILD = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(3))
BIN = BUILD / "rosbags/bin"
# Of each line of standard input: the message's hash, and its bytes after rosbags has read and written it.
READ_AND_WRITE = """
import sys
from rosbags.typesys import Stores, get_typestore
store = get_typestore(Stores.ROS2_JAZZY)
for line in sys.stdin:
    name, data = line.split()
    message = store.deserialize_cdr(bytes.fromhex(data), name)
    print(name, store.hash_rihs01(name), bytes(store.serialize_cdr(message, name)).hex())
"""


def setUpModule():
    wanted = SOURCE / "tests/ros2/requirements-rosbags.txt"
    stamp, digest = BIN.parent / "stamp", hashlib.sha256(wanted.read_bytes()).hexdigest()
    if not stamp.exists() or stamp.read_text() != digest:
        shutil.rmtree(BIN.parent, ignore_errors=True)
        venv.create(BIN.parent, with_pip=True)
        subprocess.run([BIN / "python", "-m", "pip", "install", "-q", "--no-deps", "--only-binary=:all:", "--require-hashes", "-r", wanted], check=True)
        stamp.write_text(digest)


class LayoutsTest(unittest.TestCase):
    def test_rosbags_has_the_same_hashes_and_bytes(self):
        ours = [line.split() for line in subprocess.run([PROGRAM], capture_output=True, text=True, check=True).stdout.splitlines()]
        self.assertGreaterEqual(len(ours), 25)
        asked = "".join(f"{name} {data}\n" for name, _, _, data in ours)
        said = subprocess.run([BIN / "python", "-c", READ_AND_WRITE], input=asked, capture_output=True, text=True)
        self.assertEqual(said.returncode, 0, said.stderr)
        theirs = {line.split()[0]: line.split()[1:] for line in said.stdout.splitlines()}
        self.assertEqual(len(theirs), len(ours))
        for name, type_hash, dds_name, data in ours:
            with self.subTest(name):
                package, kind, short = name.split("/")
                self.assertEqual(dds_name, f"{package}::{kind}::dds_::{short}_")
                self.assertEqual(type_hash, theirs[name][0])
                # rosbags pads its end.
                self.assertEqual(theirs[name][1][: len(data)], data)
                self.assertLess(len(theirs[name][1]) - len(data), 8)
        print(f"{len(ours)} messages", flush=True)


if __name__ == "__main__":
    unittest.main()
