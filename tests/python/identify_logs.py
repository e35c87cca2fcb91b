"""What the tests of recordings have in common: a motion, and logs of it of every kind."""

import pathlib
import tempfile
import unittest

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import panda_twin as pt
from panda_twin import model
from panda_twin.identify import Recording

SOURCE = pathlib.Path(__file__).parents[2]
STORE = get_typestore(Stores.ROS2_JAZZY)
MESSAGES = SOURCE / "tests/ros2/interfaces/franka_msgs/msg"
STORE.register(
    {
        key: value
        for name in ("CollisionIndicators", "Elbow", "Errors", "FrankaRobotState")
        for key, value in get_types_from_msg((MESSAGES / f"{name}.msg").read_text(), f"franka_msgs/msg/{name}").items()
    }
)
# The older layout, of arrays; shortened.
STORE.register(
    get_types_from_msg(
        "std_msgs/Header header\nfloat64[7] q\nfloat64[7] dq\nfloat64[7] tau_j\nfloat64[6] o_f_ext_hat_k\nfloat64[16] "
        "o_t_ee\nfloat64 time\n",
        "franka_msgs/msg/FrankaState",
    )
)
MAPPING = {"columns": {"time": {"from": "t", "unit": "ms"}, "q": {"from": "q", "unit": "deg"}, "dq": "dq", "tau_J": "tau"}}
JOINTS = [f"panda_joint{i}" for i in range(1, 8)]


def motion(n=400):
    """A motion with the torques that it takes: dict of arrays, times in s."""
    t = np.arange(n) * 1e-3
    a, w = np.array([0.5, 0.3, 0.4, 0.4, 0.5, 0.4, 0.6]), 2 * np.array([1.1, 0.9, 1.3, 0.8, 1.7, 1.2, 2.1])
    q = model.Q_READY + a * np.sin(w * t[:, None])
    dq, ddq = a * w * np.cos(w * t[:, None]), -a * w * w * np.sin(w * t[:, None])
    tau = model.gravity(q) + model.coriolis(q, dq) + np.einsum("nij,nj->ni", model.mass(q), ddq)
    return {"t": t, "q": q, "dq": dq, "tau": tau}


def names_of(column, n=7):
    return [f"{column}[{i}]" for i in range(n)]


def libfranka_csv(file, m, ids=None):
    """As logToCSV() of libfranka 0.9.2 writes."""
    zero = 0 * m["q"]
    groups = [
        ("state.q", m["q"]),
        ("state.q_d", m["q"]),
        ("state.dq", m["dq"]),
        ("state.dq_d", m["dq"]),
        ("state.tau_J", m["tau"]),
        ("state.tau_ext_hat_filtered", zero),
        ("cmd.q_d", m["q"]),
        ("cmd.dq_d", zero),
        ("cmd.O_T_EE_d", np.zeros((len(zero), 16))),
        ("cmd.O_dP_EE_d", np.zeros((len(zero), 6))),
        ("cmd.tau_J_d", zero),
    ]
    ids = np.arange(len(zero)) + 5000 if ids is None else ids
    rows = np.hstack([values for _, values in groups])
    heading = "time, success_rate, " + ",".join(", ".join(names_of(name, values.shape[1])) for name, values in groups)
    file.write_text(
        heading + "\n" + "".join(f"{k},0.98,{','.join(map(repr, row))}\n" for k, row in zip(ids.tolist(), rows.tolist()))
    )
    return file


def table_csv(file, m, separator=",", encoding="utf-8", decimal="."):
    names = ["t", *(f"{name}{i}" for name in ("q", "dq", "tau") for i in range(1, 8))]
    rows = np.hstack([1e3 * m["t"][:, None], np.degrees(m["q"]), m["dq"], m["tau"]])
    lines = [separator.join(names), *(separator.join(map(repr, row)).replace(".", decimal) for row in rows.tolist())]
    file.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    return file


def blank(name):
    """A message of zeros."""
    values = []
    for _, (kind, detail) in STORE.fielddefs[name][1]:
        if kind == Nodetype.BASE:
            values.append({"string": "", "bool": False}.get(detail[0], 0))
        elif kind == Nodetype.NAME:
            values.append(blank(detail))
        elif kind == Nodetype.ARRAY:
            values.append(np.zeros(detail[1]))
        else:
            values.append([] if detail[0][1][0] == "string" else np.empty(0))
    return STORE.types[name](*values)


def put(message, **values):
    for key, value in values.items():
        object.__setattr__(message, key, value)
    return message


def header(ns, frame=""):
    return STORE.types["std_msgs/msg/Header"](STORE.types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9), frame)


def joint_state(ns, q, dq=(), tau=(), names=None):
    make = STORE.types["sensor_msgs/msg/JointState"]
    return make(header(ns), JOINTS if names is None else names, *(np.ascontiguousarray(x, float) for x in (q, dq, tau)))


def bag(folder, topics, plugin=StoragePlugin.MCAP):
    """`topics`: name: (type, [(ns, message)])."""
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        sent = []
        for topic, (kind, messages) in topics.items():
            connection = writer.add_connection(topic, kind, typestore=STORE)
            sent += [(ns, connection, kind, message) for ns, message in messages]
        for ns, connection, kind, message in sorted(sent, key=lambda one: one[0]):
            writer.write(connection, ns, STORE.serialize_cdr(message, kind))
    return folder


EPOCH = 1_700_000_000 * 10**9


def arm_topic(m, names=None):
    rows = zip((EPOCH + np.rint(1e9 * m["t"]).astype(int)).tolist(), m["q"], m["dq"], m["tau"])
    return "sensor_msgs/msg/JointState", [(ns, joint_state(ns, *row, names=names)) for ns, *row in rows]


def whole(recording, *names, **options):
    blocks = list(recording.blocks(*names, **options))
    return np.concatenate([b.t for b in blocks]), *(np.concatenate([b.columns[name] for b in blocks]) for name in names)


class LogsCase(unittest.TestCase):
    """A folder with a log of each kind."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.motion = motion()
        cls.run_ = pt.run("scenarios/smoke.yaml", out=cls.folder / "run", video=False, plots=False)
        cls.csv = libfranka_csv(cls.folder / "franka.csv", cls.motion)
        cls.table = table_csv(cls.folder / "table.csv", cls.motion)
        cls.npz = cls.folder / "panda_py.npz"
        np.savez(cls.npz, **cls.panda_py())
        cls.bag = bag(cls.folder / "bag", {"/joint_states": arm_topic(cls.motion)})

    @classmethod
    def panda_py(cls):
        m = cls.motion
        return {
            "time": 1e3 + 1e3 * m["t"][:, None].round(3),
            "q": m["q"],
            "dq": m["dq"],
            "tau_J": m["tau"],
            "O_T_EE": np.tile(np.eye(4).ravel(), (len(m["t"]), 1)),
        }

    def refused(self, text, path, mapping=None, kind=ValueError, names=()):
        with self.assertRaisesRegex(kind, text) as caught:
            for _ in Recording.open(path, mapping).blocks(*names):
                pass
        said = str(caught.exception)
        self.assertNotIn("\n", said)
        self.assertLess(len(said), 700)

    def same(self, recording, *names):
        self.assertEqual(recording.rows, len(self.motion["t"]))
        t, *values = whole(recording, *names)
        np.testing.assert_allclose(t, self.motion["t"], atol=3e-7)
        for name, value in zip(names, values):
            np.testing.assert_allclose(value, self.motion[{"tau_J": "tau"}.get(name, name)], rtol=1e-12, atol=1e-12, err_msg=name)
