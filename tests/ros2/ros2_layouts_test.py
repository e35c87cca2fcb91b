"""Bytes and type hashes of our messages beside those of rosbags: ros2_layouts_test.py PRINT_MESSAGES."""

import pathlib
import subprocess
import sys
import unittest

from rosbags.typesys import Stores, get_typestore

PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()


class LayoutsTest(unittest.TestCase):
    def test_rosbags_has_the_same_hashes_and_bytes(self):
        store = get_typestore(Stores.ROS2_JAZZY)
        ours = [line.split() for line in subprocess.run([PROGRAM], capture_output=True, text=True, check=True).stdout.splitlines()]
        self.assertGreaterEqual(len(ours), 25)
        for name, type_hash, dds_name, data in ours:
            with self.subTest(name):
                package, kind, short = name.split("/")
                self.assertEqual(dds_name, f"{package}::{kind}::dds_::{short}_")
                self.assertEqual(type_hash, store.hash_rihs01(name))
                again = bytes(store.serialize_cdr(store.deserialize_cdr(bytes.fromhex(data), name), name)).hex()
                self.assertEqual(again[: len(data)], data)
                self.assertLess(len(again) - len(data), 8)  # rosbags pads its end


if __name__ == "__main__":
    unittest.main()
