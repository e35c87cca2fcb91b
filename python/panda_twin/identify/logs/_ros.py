"""What messages of ROS 2 say of an arm, in canonical columns."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._foreign_logs import _arm_of
from ._cdr import Layout, Messages
from ._mapping import TEXTS, WIDTHS

Values = npt.NDArray[Any]
Rows = npt.NDArray[np.uint8]

STATES = ("franka_msgs/msg/FrankaRobotState", "franka_msgs/msg/FrankaState")
JOINTS = "sensor_msgs/msg/JointState"
WRENCH = "geometry_msgs/msg/WrenchStamped"
POSE = "geometry_msgs/msg/PoseStamped"

_MODES = ("Other", "Idle", "Move", "Guiding", "Reflex", "User stopped", "Automatic error recovery")  # as in our logs
_JOINT_FIELDS = ("position", "velocity", "effort")
_ROLES = {  # columns of position, velocity, effort of joint states by their topic or field
    "measured": ("q", "dq", "tau_J"),
    "desired": ("q_d", "dq_d", "tau_J_d"),
    "motor": ("theta", "dtheta", ""),
    "external": ("", "", "tau_ext_hat_filtered"),
}
_STATE_JOINTS = {
    "measured_joint_state": "measured",
    "desired_joint_state": "desired",
    "measured_joint_motor_state": "motor",
    "tau_ext_hat_filtered": "external",
}
_BY_LOWER = {name.lower(): name for name in WIDTHS}


class WrongRobot(ValueError):
    """Joints of another robot."""


def arm_of(names: Sequence[str]) -> tuple[list[int], str]:
    """Places of the arm's joints 1 to 7 among names, and their prefix. ([], "") for a hand alone.

    Raises WrongRobot for joints of another arm, a part of them, or two arms.
    """
    if not names:
        return list(range(7)), ""
    prefixes: dict[str, list[int]] = {}
    for place, name in enumerate(names):
        if (match := re.fullmatch(r"(.*?)joint[1-7]", name)) and "finger" not in name:
            prefixes.setdefault(match[1], []).append(place)
    whole = {prefix: places for prefix, places in prefixes.items() if _arm_of([names[place] for place in places])}
    if len(whole) > 1:
        raise WrongRobot(f"has joints of {len(whole)} arms ({', '.join(sorted(whole))}); record a bag of one arm's joint states")
    for prefix, places in whole.items():
        order = _arm_of([names[place] for place in places])
        return [places[i] for i in order], prefix
    if all("finger" in name or "gripper" in name for name in names):
        return [], ""
    there = sum(map(len, prefixes.values()))
    what = f"{there} of the 7 joints of a Panda" if there else "no joints of a Panda, which end with joint1 to joint7"
    raise WrongRobot(f"has {what}: {', '.join(names[:8])}")


def _pose(layout: Layout, rows: Rows, field: str) -> Values | None:
    """A pose as 16 numbers, column by column."""
    parts = [layout.read(rows, f"{field}.position.{axis}") for axis in "xyz"] + [
        layout.read(rows, f"{field}.orientation.{axis}") for axis in "xyzw"
    ]
    if any(part is None for part in parts):
        return None
    p = np.concatenate([part for part in parts if part is not None], axis=1)
    q = p[:, 3:] / np.maximum(np.linalg.norm(p[:, 3:], axis=1, keepdims=True), 1e-12)
    x, y, z, w = q.T
    pose = np.zeros((len(p), 4, 4))  # [row, column of the pose, element of that column]
    pose[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)], axis=1)
    pose[:, 1, :3] = np.stack([2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)], axis=1)
    pose[:, 2, :3] = np.stack([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)], axis=1)
    pose[:, 3, :3] = p[:, :3]
    pose[:, 3, 3] = 1
    return pose.reshape(-1, 16)


def _six(layout: Layout, rows: Rows, first: str, second: str) -> Values | None:
    parts = [layout.read(rows, f"{part}.{axis}") for part in (first, second) for axis in "xyz"]
    return None if any(part is None for part in parts) else np.concatenate([part for part in parts if part is not None], axis=1)


def _joints(layout: Layout, rows: Rows, field: str, role: str) -> dict[str, Values]:
    dot = f"{field}." if field else ""
    names = layout.texts.get(f"{dot}name", ())
    places, _ = arm_of(names)
    found = {}
    for part, column in zip(_JOINT_FIELDS, _ROLES[role]):
        values = layout.read(rows, f"{dot}{part}")
        if column and places and values is not None and values.shape[1] == max(len(names), 7):
            found[column] = values[:, places]
    return found


def joint_states(role: str) -> Callable[[Layout, Rows], dict[str, Values]]:
    """Reads JointState."""
    return lambda layout, rows: _joints(layout, rows, "", role)


def wrenches(column: str) -> Callable[[Layout, Rows], dict[str, Values]]:
    """Reads WrenchStamped."""

    def read(layout: Layout, rows: Rows) -> dict[str, Values]:
        values = _six(layout, rows, "wrench.force", "wrench.torque")
        return {} if values is None else {column: values}

    return read


def poses(column: str) -> Callable[[Layout, Rows], dict[str, Values]]:
    """Reads PoseStamped."""

    def read(layout: Layout, rows: Rows) -> dict[str, Values]:
        values = _pose(layout, rows, "pose")
        return {} if values is None else {column: values}

    return read


def franka_state(layout: Layout, rows: Rows) -> dict[str, Values]:
    """Reads FrankaRobotState, whose fields are messages of their own, and the older FrankaState, whose fields are arrays."""
    found: dict[str, Values] = {}
    for field, role in _STATE_JOINTS.items():
        if f"{field}.name" in layout.texts:
            found |= _joints(layout, rows, field, role)
    for lower, column in _BY_LOWER.items():
        if column in TEXTS:
            continue
        width = WIDTHS[column]
        values = layout.read(rows, lower)
        if values is None and width == 16:
            values = _pose(layout, rows, f"{lower}.pose")
        elif values is None and width == 6:
            pairs = ("wrench.force", "wrench.torque"), ("twist.linear", "twist.angular"), ("accel.linear", "accel.angular")
            found_six = (_six(layout, rows, f"{lower}.{first}", f"{lower}.{second}") for first, second in pairs)
            values = next((six for six in found_six if six is not None), None)
        if values is not None and values.shape[1] == width:
            found[column] = values if width > 1 else values[:, 0]
    time = layout.read(rows, "time")
    if time is not None and time.any():
        found["message_id"] = np.rint(time[:, 0] * 1e3)
    mode = layout.read(rows, "robot_mode")
    if mode is not None:
        found["robot_mode"] = np.array(_MODES, object)[np.minimum(mode[:, 0], len(_MODES) - 1)]
    for column, field in (("errors", "current_errors"), ("reflex_reason", "last_motion_errors")):
        found |= _errors(layout, rows, column, field)
    return found


def _errors(layout: Layout, rows: Rows, column: str, field: str) -> dict[str, Values]:
    names = [name for name in layout.numbers if name.startswith(f"{field}.")]
    flags = [values for name in names if (values := layout.read(rows, name)) is not None]
    if not flags:
        return {}
    flag = np.concatenate(flags, axis=1) != 0
    texts = np.full(len(flag), "", object)
    some = np.flatnonzero(flag.any(axis=1))
    which, place = np.unique(flag[some], axis=0, return_inverse=True)
    texts[some] = np.array(["|".join(name.partition(".")[2] for name, one in zip(names, row) if one) for row in which], object)[
        place.reshape(-1)
    ]
    return {column: texts}


def stamps(layout: Layout, rows: Rows) -> Values | None:
    """Stamps of headers, ns."""
    sec, nanosec = layout.read(rows, "header.stamp.sec"), layout.read(rows, "header.stamp.nanosec")
    if sec is None or nanosec is None:
        return None
    return sec[:, 0].astype(np.int64) * 10**9 + nanosec[:, 0].astype(np.int64)


def read_all(
    messages: Messages, raw: Sequence[bytes], times: Sequence[int], read: Callable[[Layout, Rows], dict[str, Values]]
) -> tuple[Values, dict[str, Values]]:
    """Stamps, ns, and columns of messages; NaN where a message lacks one. The time of recording stands in for a stamp of 0."""
    at = np.array(times, np.int64)
    columns: dict[str, Values] = {}
    for layout, places, rows in messages.alike(raw):
        stamped = stamps(layout, rows)
        if stamped is not None and stamped.all():
            at[places] = stamped
        for name, values in read(layout, rows).items():
            if name not in columns:
                text = values.dtype.kind == "O"
                columns[name] = np.full((len(raw), *values.shape[1:]), "" if text else np.nan, object if text else np.float64)
            columns[name][places] = values
    return at, columns
