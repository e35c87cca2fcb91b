"""Bytes and type hashes of our messages beside those of rosbags: ros2_layouts_test.py PRINT_MESSAGES."""

import pathlib
import subprocess
import sys
import unittest

from rosbags.typesys import Stores, get_typestore

# Of the JSON files that ROS 2 Jazzy installs: ROS takes a char in a .msg for uint8, rosbags 0.11.9 does not.
HASHES_OF_ROS = {
    "rmw_dds_common/msg/Gid": "RIHS01_ab6f21cfbb0a6dbb837161e1110c2051a2850ed9f9c53944d7115d9bcebedf71",
    "rmw_dds_common/msg/NodeEntitiesInfo": "RIHS01_8ffef65ee2d088c63b1e8fcd31e800ba9fc8dbe0ee15ca60d1676de5218087a7",
    "rmw_dds_common/msg/ParticipantEntitiesInfo": "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e",
}
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
                self.assertEqual(type_hash, HASHES_OF_ROS.get(name) or store.hash_rihs01(name))
                again = bytes(store.serialize_cdr(store.deserialize_cdr(bytes.fromhex(data), name), name)).hex()
                self.assertEqual(again[: len(data)], data)
                self.assertLess(len(again) - len(data), 8)  # rosbags pads its end


if __name__ == "__main__":
    unittest.main()
