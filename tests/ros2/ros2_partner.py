"""A node of real ROS 2 (rclpy) that commands a twin, and the twin it commands. Runs in an environment of ros_env.py; enter() goes there."""

import bisect
import fcntl
import importlib
import json
import math
import os
import pathlib
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time

import ros_env

ROOT = pathlib.Path(__file__).resolve().parents[2]
JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
ARM = "/panda_arm_controller/follow_joint_trajectory"
HAND = "/panda_hand_controller/gripper_cmd"
PATIENCE = 60  # s, for anything that comes


def free_domain():
    """A domain in which no other test of this machine is: this program's until it ends."""
    for domain in random.sample(range(20, 100), 80):
        lock = os.open(f"{tempfile.gettempdir()}/panda_twin_ros_domain_{domain}_{os.getuid()}.lock", os.O_RDWR | os.O_CREAT)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first:
                first.bind(("", 7410 + 250 * domain))  # DDS has it for a domain's first participant
            os.set_inheritable(lock, True)  # by what enter() starts
            return domain
        except OSError:
            os.close(lock)
    raise RuntimeError("all of ROS's domains are in use")


def enter(distro):
    """Starts this program again with the Python and the environment of a distribution, in a domain of its own."""
    if os.environ.get("TWIN_IN_ROS") == distro:
        return
    environment = os.environ | ros_env.environment_of(distro, free_domain()) | {"TWIN_IN_ROS": distro}
    python = str(ros_env.python_of(distro))
    os.execve(python, [python, *sys.argv], environment)


def free_ports():
    """Two ports in a row, below those that the system gives to clients."""
    while True:
        port = random.randrange(11000, 30000, 2)
        try:
            for number in (port, port + 1):
                with socket.socket() as one:
                    one.bind(("127.0.0.1", number))
            return port
        except OSError:
            continue


class Twin:
    """panda-twin serve --ros, or ros, as a process."""

    def __init__(self, program, *words, command="serve", port=None, ros=True):
        self.port = port or free_ports()
        self.log = tempfile.NamedTemporaryFile("w+", prefix="ros2_test_")
        self.control = tempfile.mktemp(prefix="ros2_test_", suffix=".sock")
        flags = ["--port", str(self.port), "--hand-port", str(self.port + 1), "--control", self.control] if command == "serve" else []
        flags += ["--ros"] if ros and command == "serve" else []
        sign = "ROS 2 domain" if ros else "ends  on Ctrl-C"
        self.program = program
        self.process = subprocess.Popen([program, command, *words, *flags], stdout=self.log, stderr=subprocess.STDOUT, cwd=ROOT,
                                        env={**os.environ, "LD_LIBRARY_PATH": ""})
        until(lambda: sign in self.told() or self.process.poll() is not None, "the twin did not begin")
        if self.process.poll() is not None:
            raise RuntimeError(self.told())

    def told(self, after=0):
        """What it has said, after the first so many characters."""
        return pathlib.Path(self.log.name).read_text()[after:]

    def ctl(self, *words):
        """@returns the robot's state after the request."""
        words = [self.program, "ctl", "--json", self.control, *words]
        done = subprocess.run(words, check=True, capture_output=True, timeout=PATIENCE, env={**os.environ, "LD_LIBRARY_PATH": ""})
        return json.loads(done.stdout)

    def memory_kb(self, what="VmRSS"):
        text = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(text.split(f"{what}:")[1].split()[0])

    def end(self, how=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            self.process.wait(timeout=PATIENCE)
            return self.told()
        finally:
            self.process.kill()
            self.process.wait()
            self.log.close()


def until(condition, why, seconds=PATIENCE, look=lambda: time.sleep(0.02)):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"{why} within {seconds} s")
        look()


def seconds_of(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def leaps_of(states, period=0.01):
    """Where stamps leave the robot's time, since the host was late and they follow the wall clock: (stamp, by how much). Lost states are none."""
    stamps = [seconds_of(m.header.stamp) for m in states]
    return [(b, b - a - period) for a, b in zip(stamps, stamps[1:]) if b - a > 0.09 and abs((b - a) / period - round((b - a) / period)) > 1e-4]


def robot_seconds(stamp, leaps):
    at = seconds_of(stamp)
    return at - sum(by for since, by in leaps if since <= at)


def interface_of(text):
    """The class of a type as the graph calls it: "sensor_msgs/msg/JointState", "control_msgs/action/GripperCommand_SendGoal"."""
    package, kind, name = text.split("/")
    parts = {"_FeedbackMessage": "FeedbackMessage", "_SendGoal": "SendGoalService", "_GetResult": "GetResultService"}
    module = importlib.import_module(f"{package}.{kind}")
    for end, part in parts.items():
        if kind == "action" and name.endswith(end):
            return getattr(getattr(module, name.removesuffix(end)).Impl, part)
    return getattr(module, name)


class Partner:
    """A node with what a user's program has of it."""

    def __init__(self, name="partner", parameters=()):
        import rclpy
        from sensor_msgs.msg import JointState
        self.rclpy = rclpy
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node(name, context=self.context, parameter_overrides=list(parameters))
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.states = []
        self.node.create_subscription(JointState, "/joint_states", self.states.append, 100)
        self.clients = {}

    def end(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.rclpy.shutdown(context=self.context)

    def spin(self, seconds=0.05):
        self.executor.spin_once(timeout_sec=seconds)

    def spin_for(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.spin(0.01)

    def until(self, condition, why="it did not come", seconds=PATIENCE):
        until(condition, why, seconds, self.spin)

    def wait(self, future, why="no answer"):
        self.until(future.done, why)
        return future.result()

    def state(self):
        """The arm's and the fingers' positions now."""
        count = -1
        while count < len(self.states):  # some wait since this node was last spun
            count = len(self.states)
            for _ in range(5):
                self.spin(0)
        self.states.clear()
        self.until(lambda: self.states, "no joint state")
        return list(self.states[-1].position)

    def collect(self, kind, topic, qos=10):
        got = []
        self.node.create_subscription(kind, topic, got.append, qos)
        return got

    def rest(self, joints=7):
        """Waits until the arm rests. @returns the stamp of its last state in motion, 0 if there is none, and the positions."""
        moving = lambda m: max(map(abs, m.velocity[:joints])) > 2e-3
        self.state()
        self.until(lambda: len(self.states) > 30 and not any(map(moving, self.states[-30:])), "the arm does not rest")
        last = [seconds_of(m.header.stamp) for m in self.states if moving(m)]
        return (last or [0.0])[-1], list(self.states[-1].position)

    def call(self, kind, name, request=None):
        key = (kind, name)
        if key not in self.clients:
            self.clients[key] = self.node.create_client(kind, name)
        client = self.clients[key]
        self.until(client.service_is_ready, f"no service {name}")
        return self.wait(client.call_async(request or kind.Request()), f"{name} did not answer")

    def action(self, kind, name):
        from rclpy.action import ActionClient
        key = (kind, name)
        if key not in self.clients:
            self.clients[key] = ActionClient(self.node, kind, name)
        self.until(self.clients[key].server_is_ready, f"no action {name}")
        return self.clients[key]

    def send(self, kind, name, goal, feedback=None):
        client = self.action(kind, name)
        take = None if feedback is None else lambda message: feedback.append(message.feedback)
        return self.wait(client.send_goal_async(goal, feedback_callback=take), f"{name} took no goal")

    def do(self, kind, name, goal, feedback=None):
        """@returns status and result of a goal."""
        response = self.wait(self.send(kind, name, goal, feedback).get_result_async(), f"a goal of {name} did not end")
        return response.status, response.result

    def arm(self, on=True):
        from std_srvs.srv import SetBool
        return self.call(SetBool, "/panda_twin/arm", SetBool.Request(data=on))


def duration_of(seconds):
    from builtin_interfaces.msg import Duration
    return Duration(sec=math.floor(seconds), nanosec=round(1e9 * (seconds - math.floor(seconds))))


def swing(share):
    """A smooth way from 0 to 1: its value and two derivatives by the share of its time."""
    return (1 - math.cos(math.pi * share)) / 2, math.pi * math.sin(math.pi * share) / 2, math.pi**2 * math.cos(math.pi * share) / 2


def goal_of(start, by=0.2, seconds=2.0, step=0.1, derivatives=0, names=None, begin=0.0):
    """A goal that moves all joints by as much. @param derivatives  given beside positions."""
    from control_msgs.action import FollowJointTrajectory
    from trajectory_msgs.msg import JointTrajectoryPoint
    names = names or JOINTS
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = list(names)
    at = [start[JOINTS.index(name)] if name in JOINTS else 0.0 for name in names]
    count = round(seconds / step)
    for i in range(count + 1):
        x, dx, ddx = swing(i / count)
        point = JointTrajectoryPoint(positions=[q + by * x for q in at], time_from_start=duration_of(begin + i * step))
        if derivatives > 0:
            point.velocities = [by * dx / seconds * (0 < i < count)] * len(names)
        if derivatives > 1:
            point.accelerations = [by * ddx / seconds**2] * len(names)
        goal.trajectory.points.append(point)
    return goal


def following_error(states, feedback, start, by=0.2, seconds=2.0):
    """Largest distance of any joint from the swing, at the best common delay after its begin, of which the feedback tells: (error, delay)."""
    leaps = leaps_of(states)
    begins = sorted(robot_seconds(one.header.stamp, leaps) - seconds_of(one.desired.time_from_start) for one in feedback)
    begin = begins[len(begins) // 2]
    best = (math.inf, 0.0)
    samples = []
    for message in states:
        moved = [x - q for x, q in zip(message.position[:7], start)]
        samples.append((robot_seconds(message.header.stamp, leaps) - begin, min(moved), max(moved)))
    for step in range(-50, 151):
        delay, error = 0.001 * step, 0.0
        for t, low, high in samples:
            x = by * swing(min(max((t - delay) / seconds, 0), 1))[0]
            error = max(error, x - low, high - x)
        best = min(best, (error, delay))
    return best


def stream_error(states, sent):
    """Largest distance of joint 1 from the line through what was sent, at the best common delay: (error, delay)."""
    times = [t for t, _ in sent]
    best = (math.inf, 0.0)
    leaps = leaps_of(states)
    samples = [(robot_seconds(m.header.stamp, leaps), m.position[0]) for m in states]
    for step in range(-60, 60):
        delay, worst = 0.002 * step, 0.0
        for t, x in samples:
            i = bisect.bisect(times, t - delay)
            if 0 < i < len(sent):
                (t0, x0), (t1, x1) = sent[i - 1 : i + 1]
                worst = max(worst, abs(x - x0 - (x1 - x0) * (t - delay - t0) / (t1 - t0)))
        best = min(best, (worst, delay))
    return best


def die_in_a_goal():
    """A client that is gone in the middle of its goal."""
    from control_msgs.action import FollowJointTrajectory
    partner = Partner("dies")
    partner.send(FollowJointTrajectory, ARM, goal_of(partner.state(), by=0.1, seconds=1.0))
    os.kill(os.getpid(), signal.SIGKILL)


if __name__ == "__main__":
    die_in_a_goal()
