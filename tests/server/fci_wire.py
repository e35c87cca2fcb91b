"""A client of the Franka Control Interface, protocol 5, in a hundred lines: sockets and struct, nothing of the project.

Offsets and numbers are those of the protocol's description. Nothing sleeps for a fixed time: what is waited for comes, or the
socket's time limit ends the test.
"""

import math
import socket
import struct

LIMIT = 60  # s, for anything to come
STATE_BYTES, COMMAND_BYTES, HAND_STATE_BYTES, VACUUM_STATE_BYTES = 2373, 370, 23, 16

CONNECT, MOVE, STOP_MOVE, GET_CARTESIAN_LIMIT, SET_COLLISION_BEHAVIOR, SET_JOINT_IMPEDANCE = 0, 1, 2, 3, 4, 5
SET_LOAD, RECOVERY, LOAD_MODEL_LIBRARY = 10, 12, 13
HAND_CONNECT, HAND_HOMING, HAND_GRASP, HAND_MOVE, HAND_STOP = 0, 1, 2, 3, 4
VACUUM, VACUUM_DROP_OFF, VACUUM_STOP = 1, 2, 3

SUCCESS, MOTION_STARTED, PREEMPTED, NOT_POSSIBLE, REFLEX_ABORTED = 0, 1, 2, 3, 6
SETTING_NOT_POSSIBLE, SETTING_INVALID = 1, 2
IDLE, MOVING, REFLEX = 1, 2, 4


class State:
    """A robot state; `content` is all of it but its id."""

    def __init__(self, data):
        assert len(data) == STATE_BYTES, len(data)
        self.id, = struct.unpack_from("<Q", data, 0)
        self.m_load, = struct.unpack_from("<d", data, 880)
        self.tau_J = struct.unpack_from("<7d", data, 1016)
        self.q = struct.unpack_from("<7d", data, 1184)
        self.q_d = struct.unpack_from("<7d", data, 1240)
        self.generator, self.controller = data[2280], data[2281]
        self.errors = [i for i in range(41) if data[2282 + i]]
        self.reflex_reason = [i for i in range(41) if data[2323 + i]]
        self.mode = data[2364]
        self.success_rate, = struct.unpack_from("<d", data, 2365)
        self.content = data[8:]


def command(state_id, q_c, finished=False):
    data = bytearray(COMMAND_BYTES)
    struct.pack_into("<Q7d", data, 0, state_id, *q_c)
    data[313] = finished
    return bytes(data)


def there_and_back(x, amplitude):
    """Without a step in velocity or acceleration at either end, x in [0, 1]."""
    return amplitude * math.sin(math.pi * min(1.0, x)) ** 4


class Stream:
    """One TCP connection: requests out, answers in."""

    def __init__(self, port, head):
        self.head = struct.Struct(head)
        self.tcp = socket.create_connection(("127.0.0.1", port), timeout=LIMIT)
        self.tcp.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.udp.bind(("0.0.0.0", 0))
        self.udp.settimeout(LIMIT)
        self.next_id = 0
        self.kept = {}

    def request(self, number, payload=b""):
        """@returns the id of the request."""
        request_id, self.next_id = self.next_id, self.next_id + 1
        self.tcp.sendall(self.head.pack(number, request_id, self.head.size + len(payload)) + payload)
        return request_id

    def receive_exactly(self, count):
        data = b""
        while len(data) < count:
            part = self.tcp.recv(count - len(data))
            if not part:
                raise ConnectionAbortedError("the server has closed the connection")
            data += part
        return data

    def receive(self):
        """@returns (command, id, payload) of the next answer."""
        number, request_id, size = self.head.unpack(self.receive_exactly(self.head.size))
        return number, request_id, self.receive_exactly(size - self.head.size)

    def answer(self, request_id):
        """Payload of the next answer to that request; others are kept."""
        while not self.kept.get(request_id):
            _, answered, payload = self.receive()
            self.kept.setdefault(answered, []).append(payload)
        return self.kept[request_id].pop(0)

    def ask(self, number, payload=b""):
        return self.answer(self.request(number, payload))

    def close(self):
        self.tcp.close()
        self.udp.close()

    def vanish(self):
        """As when the process is killed with bytes unread: the connection is reset."""
        self.tcp.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.close()


class Arm(Stream):
    def __init__(self, port, version=5, connect=True):
        super().__init__(port, "<III")
        self.state = None
        self.robot = None  # where states come from
        if connect:
            try:
                answer = self.ask(CONNECT, struct.pack("<HH", version, self.udp.getsockname()[1]))
            except ConnectionError:
                self.close()
                raise
            self.connected, self.version = answer[0], struct.unpack("<H", answer[1:])[0]

    def read(self):
        """The next state with a higher id."""
        while True:
            data, self.robot = self.udp.recvfrom(4096)
            state = State(data)
            if self.state is None or state.id > self.state.id:
                self.state = state
                return state

    def newest(self):
        """The newest state: those that wait are passed over. Waits for one when none waits."""
        self.udp.setblocking(False)
        before = self.state
        try:
            while True:
                self.read()
        except BlockingIOError:
            pass
        finally:
            self.udp.settimeout(LIMIT)
        return self.state if self.state is not before else self.read()

    def send(self, data):
        self.udp.sendto(data, self.robot)

    def move(self, controller=0, generator=0):
        """@returns (id of the request, status)."""
        deviation = struct.pack("<3d", 10.0, 3.12, 2 * math.pi)
        request_id = self.request(MOVE, struct.pack("<II", controller, generator) + 2 * deviation)
        return request_id, self.answer(request_id)[0]

    def start(self):
        """Starts a joint motion as libfranka does: until the modes show, and one state more. @returns the request's id."""
        request_id, status = self.move()
        assert status == MOTION_STARTED, status
        while self.newest().generator != 1:
            pass
        self.read()
        return request_id

    def wave(self, cycles=300, amplitude=0.01, on_state=lambda k, state: None, joint=0, until=math.inf):
        """Moves a joint there and back. @param until  answers given at most. @returns the states from the first answer's on,
        to the first that is idle."""
        start, first, states = self.state.q_d, self.state.id, []
        while self.state.generator != 0 and len(states) < until:
            k = self.state.id - first
            q_c = list(start)
            q_c[joint] += there_and_back(k / cycles, amplitude)
            on_state(k, self.state)
            self.send(command(self.state.id, q_c, k >= cycles))
            states.append(self.read())
        return states

    def run_motion(self, **motion):
        request_id = self.start()
        states = self.wave(**motion)
        return states, self.answer(request_id)[0]

    def await_mode(self, mode):
        while self.newest().mode != mode:
            pass


class Hand(Stream):
    def __init__(self, port, version=3):
        super().__init__(port, "<HII")
        answer = self.ask(HAND_CONNECT, struct.pack("<HH", version, self.udp.getsockname()[1]))
        self.connected, self.version = struct.unpack("<HH", answer)

    def read(self):
        """@returns (id, width, max_width, is_grasped, temperature)."""
        data = self.udp.recv(4096)
        assert len(data) == HAND_STATE_BYTES, len(data)
        return struct.unpack("<Idd?H", data)

    def do(self, number, payload=b""):
        return struct.unpack("<H", self.ask(number, payload))[0]


class Vacuum(Hand):
    """The vacuum gripper: framed as the hand."""

    def __init__(self, port, version=1):
        super().__init__(port, version)

    def read(self):
        """@returns (id, in_control_range, part_detached, part_present, device_status, actual_power, vacuum)."""
        data = self.udp.recv(4096)
        assert len(data) == VACUUM_STATE_BYTES, len(data)
        return struct.unpack("<I???Bii", data)
