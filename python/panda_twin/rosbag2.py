"""Writes a log as a bag of ROS 2 (rosbag2, MCAP): python3 -m panda_twin.rosbag2 run.mcap --out DIR."""

from __future__ import annotations

import heapq
import operator
import os
import pathlib
import shutil
import sys
import tempfile
import typing
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ._command import exit_code_of, log_parser, parse_log
from ._foreign_logs import import_rosbags
from ._log import Log

Floats = npt.NDArray[np.float64]

_JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
_BASE = "panda_link0"
_STATE = "/franka_robot_state_broadcaster"  # topics of franka_ros2's broadcaster of that name
_LEVELS = {"error": 40, "warning": 30}  # of rcl_interfaces/msg/Log; else INFO, 20


def _quaternions(R: Floats) -> Floats:
    """Unit quaternions x, y, z, w of rotations (n, 3, 3), with w >= 0: the eigenvector of Bar-Itzhack's matrix (2000)."""
    xx, yy, zz = R[:, 0, 0], R[:, 1, 1], R[:, 2, 2]
    K = np.empty((len(R), 4, 4))
    K[:, 0, 0], K[:, 1, 1], K[:, 2, 2], K[:, 3, 3] = xx - yy - zz, yy - xx - zz, zz - xx - yy, xx + yy + zz
    for i, j in ((0, 1), (0, 2), (1, 2)):
        K[:, i, j] = K[:, j, i] = R[:, i, j] + R[:, j, i]
    K[:, 0, 3] = K[:, 3, 0] = R[:, 2, 1] - R[:, 1, 2]
    K[:, 1, 3] = K[:, 3, 1] = R[:, 0, 2] - R[:, 2, 0]
    K[:, 2, 3] = K[:, 3, 2] = R[:, 1, 0] - R[:, 0, 1]
    q: Floats = np.linalg.eigh(K / 3)[1][:, :, 3]
    return np.where(q[:, 3:] < 0, -q, q)


class _Bag:
    """Makes the messages of a log, and writes them in order of time."""

    def __init__(self, folder: pathlib.Path) -> None:
        rosbags = import_rosbags()
        self._store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.ROS2_JAZZY)
        self._types = self._store.types
        self._writer = rosbags.rosbag2.Writer(folder, version=9, storage_plugin=rosbags.rosbag2.StoragePlugin.MCAP)
        self._topics: list[Iterator[tuple[int, str, str, typing.Any]]] = []

    def write(self) -> None:
        with self._writer as writer:
            connections: dict[str, typing.Any] = {}
            for time, topic, kind, message in heapq.merge(*self._topics, key=operator.itemgetter(0)):
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=self._store)
                writer.write(connections[topic], time, self._store.serialize_cdr(message, kind))

    def _header(self, time: int, frame: str) -> typing.Any:
        stamp = self._types["builtin_interfaces/msg/Time"](sec=time // 10**9, nanosec=time % 10**9)
        return self._types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)

    def add(self, topic: str, kind: str, times: npt.NDArray[np.int64], messages: Iterator[typing.Any]) -> None:
        self._topics.append((time, topic, kind, message) for time, message in zip(times.tolist(), messages))

    def add_joints(self, topic: str, names: list[str], times: npt.NDArray[np.int64], q: Floats, dq: Floats, tau: Floats) -> None:
        kind = "sensor_msgs/msg/JointState"
        make = self._types[kind]
        rows = zip(times.tolist(), q, dq, tau)
        self.add(topic, kind, times, (make(self._header(t, ""), names, position, velocity, effort) for t, position, velocity, effort in rows))

    def add_poses(self, topic: str, times: npt.NDArray[np.int64], poses: Floats) -> None:
        kind = "geometry_msgs/msg/PoseStamped"
        make, pose = self._types[kind], self._types["geometry_msgs/msg/Pose"]
        point, quaternion = self._types["geometry_msgs/msg/Point"], self._types["geometry_msgs/msg/Quaternion"]
        rows = zip(times.tolist(), poses[:, :3, 3].tolist(), _quaternions(poses[:, :3, :3]).tolist())
        self.add(topic, kind, times, (make(self._header(t, _BASE), pose(point(*p), quaternion(*q))) for t, p, q in rows))

    def add_wrenches(self, topic: str, times: npt.NDArray[np.int64], wrenches: Floats) -> None:
        kind = "geometry_msgs/msg/WrenchStamped"
        make, wrench, vector = self._types[kind], self._types["geometry_msgs/msg/Wrench"], self._types["geometry_msgs/msg/Vector3"]
        rows = zip(times.tolist(), wrenches.tolist())
        self.add(topic, kind, times, (make(self._header(t, _BASE), wrench(vector(*w[:3]), vector(*w[3:]))) for t, w in rows))

    def add_events(self, times: npt.NDArray[np.int64], kinds: list[str], texts: list[str]) -> None:
        kind = "rcl_interfaces/msg/Log"
        make = self._types[kind]
        rows = zip(times.tolist(), kinds, texts)
        self.add("/rosout", kind, times, (make(self._header(t, "").stamp, _LEVELS.get(k, 20), "panda_twin." + k, text, "", "", 0) for t, k, text in rows))


def write(log: Log, folder: str | os.PathLike[str]) -> pathlib.Path:
    """Write a log as a bag.

    Topics, at 1 kHz: joint states of the arm, and what franka_ros2's state broadcaster publishes: desired joint states, measured
    and desired pose of the end effector, external wrench and joint torques; also events on /rosout. Frames and joints are named
    as in the Panda's URDF. Times are those of the run, from 0. The bag is of version 9, which ROS 2 Jazzy and later read.

    Parameters
    ----------
    log
        What is written.
    folder
        Of the bag; must not exist. It is there whole, or not at all.

    Returns
    -------
    pathlib.Path
        The folder.

    Raises
    ------
    ImportError
        Without rosbags: pip install 'panda-twin[ros]'.
    FileExistsError
        When there is something of that name.
    ValueError
        For a log without cycles.
    """
    folder = pathlib.Path(folder)
    if folder.exists():
        raise FileExistsError(f"{folder} exists; name a new folder, or remove it")
    cycles = log.cycles
    if len(cycles) == 0:
        raise ValueError("the log has no cycles")
    folder.parent.mkdir(parents=True, exist_ok=True)
    made = pathlib.Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    try:
        bag = _Bag(made / folder.name)
        _add_all(log, bag)
        bag.write()
        os.rename(made / folder.name, folder)
    finally:
        shutil.rmtree(made, ignore_errors=True)
    return folder


def _add_all(log: Log, bag: _Bag) -> None:
    cycles, events = log.cycles, log.events
    times = np.asarray(cycles["at_ns"], dtype=np.int64)
    none = np.empty((len(times), 0))
    bag.add_joints("/joint_states", _JOINTS, times, cycles["q"], cycles["dq"], cycles["tau_J"])
    bag.add_joints(f"{_STATE}/desired_joint_states", _JOINTS, times, cycles["q_d"], cycles["dq_d"], cycles["tau_J_d"])
    bag.add_joints(f"{_STATE}/external_joint_torques", _JOINTS, times, none, none, cycles["tau_ext_hat_filtered"])
    bag.add_poses(f"{_STATE}/current_pose", times, cycles.poses("O_T_EE"))
    bag.add_poses(f"{_STATE}/last_desired_pose", times, cycles.poses("O_T_EE_d"))
    bag.add_wrenches(f"{_STATE}/external_wrench_in_base_frame", times, cycles["O_F_ext_hat_K"])
    bag.add_events(np.asarray(events["at_ns"], dtype=np.int64), list(events["kind"]), list(events["text"]))


def main(arguments: list[str]) -> int:
    options = parse_log(log_parser("rosbag2", "Write a log as a bag of ROS 2 (MCAP)."), "rosbag2", arguments)
    return exit_code_of(lambda: print(write(Log(options.log), options.out)))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
