"""Bytes and type hashes of our messages beside those of rosbags: ros2_layouts_test.py PRINT_MESSAGES."""

import pathlib
import re
import subprocess
import sys
import unittest

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

HERE = pathlib.Path(__file__).resolve().parent
TABLES = HERE.parents[1] / "plugins/ros2"
INTERFACES = HERE / "interfaces"
# Of the JSON files that ROS 2 Jazzy installs: ROS takes a char in a .msg for uint8, rosbags 0.11.9 does not.
HASHES_OF_ROS = {
    "rmw_dds_common/msg/Gid": "RIHS01_ab6f21cfbb0a6dbb837161e1110c2051a2850ed9f9c53944d7115d9bcebedf71",
    "rmw_dds_common/msg/NodeEntitiesInfo": "RIHS01_8ffef65ee2d088c63b1e8fcd31e800ba9fc8dbe0ee15ca60d1676de5218087a7",
    "rmw_dds_common/msg/ParticipantEntitiesInfo": "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e",
}
# Of ROS 2's own packages, of which rosbags has no services.
SERVICES = {
    "action_msgs/srv/CancelGoal": "GoalInfo goal_info\n---\nint8 return_code\nGoalInfo[] goals_canceling",
    "std_srvs/srv/SetBool": "bool data\n---\nbool success\nstring message",
    "std_srvs/srv/Trigger": "---\nbool success\nstring message",
}
PARTS = {"msg": ("",), "srv": ("_Request", "_Response"), "action": ("_Goal", "_Result", "_Feedback")}
# What carries an action's messages.
CARRIERS = {
    "_SendGoal_Request": "unique_identifier_msgs/UUID goal_id\n{name}_Goal goal",
    "_SendGoal_Response": "bool accepted\nbuiltin_interfaces/Time stamp",
    "_GetResult_Request": "unique_identifier_msgs/UUID goal_id",
    "_GetResult_Response": "int8 status\n{name}_Result result",
    "_FeedbackMessage": "unique_identifier_msgs/UUID goal_id\n{name}_Feedback feedback",
}
PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()


def types_of(name, text):
    """{name of a message: its type} of an interface file's text."""
    kind = name.split("/")[1]
    texts = dict(zip(PARTS[kind], re.split("^---$", text, flags=re.MULTILINE), strict=True))
    if kind == "action":
        texts |= {part: text.format(name=name) for part, text in CARRIERS.items()}
    types = {}
    for part, fields in texts.items():
        # ROS has no message without a field. rosbags looks for a plain name beside what holds it, ROS always in .../msg.
        found = get_types_from_msg(fields.strip() or "uint8 structure_needs_at_least_one_member", f"{name}{part}".replace(f"/{kind}/", "/msg/"))
        ((_, types[name + part]),) = found.items()
    return types


def interfaces():
    """{name of an interface: its file's text}"""
    return {str(file.relative_to(INTERFACES).with_suffix("")): file.read_text() for kind in PARTS for file in INTERFACES.glob(f"*/{kind}/*.{kind}")}


def typestore():
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in (interfaces() | SERVICES).items():
        store.register(types_of(name, text))
    return store


class LayoutsTest(unittest.TestCase):
    def test_rosbags_has_the_same_hashes_and_bytes(self):
        store = typestore()
        ours = [line.split() for line in subprocess.run([PROGRAM], capture_output=True, text=True, check=True).stdout.splitlines()]
        self.assertGreaterEqual(len(ours), 140)
        for name, type_hash, dds_name, data in ours:
            with self.subTest(name):
                package, kind, short = name.split("/")
                self.assertEqual(dds_name, f"{package}::{kind}::dds_::{short}_")
                self.assertEqual(type_hash, HASHES_OF_ROS.get(name) or store.hash_rihs01(name))
                again = bytes(store.serialize_cdr(store.deserialize_cdr(bytes.fromhex(data), name), name)).hex()
                self.assertEqual(again[: len(data)], data)
                self.assertLess(len(again) - len(data), 8)  # rosbags pads its end
        parts = {part for name, text in interfaces().items() for part in types_of(name, text)}
        self.assertEqual(parts - {name for name, *_ in ours}, set())

    def test_each_field_is_visited_under_its_own_name(self):  # of what has one type, neither hashes nor bytes tell
        for file in TABLES.glob("*messages.h"):
            visits = re.findall(r'\bv\("(\w+)",\s*(?:m|self)\.(\w+)\)', file.read_text())
            self.assertGreater(len(visits), 10)
            self.assertEqual([visit for visit in visits if visit[0] != visit[1]], [], file.name)

    def test_enums_have_the_values_of_the_constants(self):  # which are not in hashes
        enums = {}
        for file in TABLES.glob("*messages.h"):
            for name, body in re.findall(r'kName = "([^"]+)";\s*(?:///[^\n]*\s*)*enum \w+ : [\w:]+ \{(.*?)\};', file.read_text(), re.DOTALL):
                enums[name] = {int(value): enum for enum, value in re.findall(r"\bk(\w+) = (-?\d+)", body)}
        texts = interfaces()
        compared = enums.keys() & texts.keys()
        self.assertGreaterEqual(len(compared), 10)
        for name in compared:
            with self.subTest(name):
                found = re.findall(r"^\w+ ([A-Z]\w*) *= *(-?\d+)", texts[name], re.MULTILINE)
                constants = {int(value): constant.title().replace("_", "") for constant, value in found}
                self.assertEqual(enums[name].keys(), constants.keys())
                # Ours leave out what all begin with.
                self.assertEqual([value for value in constants if not constants[value].endswith(enums[name][value])], [])


if __name__ == "__main__":
    unittest.main()
