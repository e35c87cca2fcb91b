#!/usr/bin/env python3
"""The seeds that fuzzing starts from: whole frames and datagrams as client and robot exchange them,
datagrams of operators' devices and scripts of what operators did.

    make_corpus.py          writes them to corpus/TARGET/NAME.bin beside this file
    make_corpus.py --check  says whether they are what it would write; exit code 1 when not

Independent of the project's own encoders: struct, and the protocol's description.
"""

import math
import pathlib
import struct
import sys

FOLDER = pathlib.Path(__file__).parent / "corpus"
MOST_BYTES = 100_000  # of all seeds

# Steps of a session's script (session_targets.h): what the arm does, what the hand's command ends with.
FINISHES, ABORTED, STOPPED, RESTS, RECOVERS, USER_STOPS, USER_LETS = (bytes([0xC0 + i]) for i in range(7))
SUCCESS, FAIL, UNSUCCESSFUL, HAND_ABORTED = (bytes([0xC0 + i]) for i in range(4))
SESSION, ANSWERS, STATE = b"\0", b"\1", b"\2"  # parts of the gripper's target


def arm(number, request_id=3, payload=b""):
    return struct.pack("<III", number, request_id, 12 + len(payload)) + payload


def hand(number, request_id=3, payload=b""):
    return struct.pack("<HII", number, request_id, 10 + len(payload)) + payload


def doubles(*values):
    return struct.pack(f"<{len(values)}d", *values)


def segments(stream, most=192):
    """As steps of a script."""
    parts = (stream[i:i + most] for i in range(0, len(stream), most))
    return b"".join(bytes([len(part) - 1]) + part for part in parts)


IDENTITY = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)
CONNECT = arm(0, 0, struct.pack("<HH", 5, 43210))
HAND_CONNECT = hand(0, 0, struct.pack("<HH", 3, 43210))
DEVIATIONS = 2 * doubles(10.0, 3.12, 2 * math.pi)
STOP = arm(2, 8)
RECOVERY = arm(12, 9)


def move(request_id=7, controller=0, generator=0):
    return arm(1, request_id, struct.pack("<II", controller, generator) + DEVIATIONS)


SETTERS = [
    arm(4, 10, doubles(*[20] * 28, *[20] * 24)),
    arm(5, 11, doubles(*[3000] * 7)),
    arm(6, 12, doubles(*[2000] * 3, *[100] * 3)),
    arm(7, 13, b"\1\1\1\1\1\1\0"),
    arm(8, 14, doubles(*IDENTITY)),
    arm(9, 15, doubles(*IDENTITY)),
    arm(10, 16, doubles(0.5, *[0] * 12)),
    arm(11, 17, doubles(*[100] * 5)),
]
ASKS = [arm(3, 18, struct.pack("<i", 1)), arm(13, 19, b"\0\0"), arm(13, 20, b"\3\0")]


def arm_sessions():
    yield "setters", segments(CONNECT + b"".join(SETTERS + ASKS))
    yield "motion", segments(CONNECT + move()) + FINISHES
    yield "every_mode", segments(CONNECT) + b"".join(
        segments(move(20 + 5 * controller + generator, controller, generator)) + FINISHES
        for controller in range(3) for generator in range(4))
    yield "stop", segments(CONNECT + move() + STOP) + STOPPED + segments(STOP)
    yield "many_stops", segments(CONNECT + move() + 66 * STOP)
    yield "reflex", segments(CONNECT + move()) + ABORTED + segments(STOP + RECOVERY + RECOVERY) + RESTS + RECOVERS + segments(move())
    yield "user_stop", segments(CONNECT + move()) + USER_STOPS + segments(RECOVERY + move()) + USER_LETS + RESTS + segments(move())
    yield "refused_while_moving", segments(CONNECT + move() + move() + SETTERS[1] + RECOVERY) + FINISHES
    yield "bytes_one_by_one", segments(CONNECT + STOP + move(), 1) + FINISHES
    yield "wrong_version", segments(arm(0, 0, struct.pack("<HH", 4, 43210)))
    yield "no_connect", segments(move())
    yield "second_connect", segments(CONNECT + CONNECT)
    yield "bad_values", segments(CONNECT + arm(10, 1, doubles(math.nan, *[0] * 12)) + move(2, 7, 7))
    yield "too_large", segments(CONNECT + struct.pack("<III", 4, 1, 1 << 31))
    yield "unknown", segments(CONNECT + arm(99))


HAND_COMMANDS = [hand(1, 4), hand(2, 5, doubles(0.03, 0.005, 0.005, 0.1, 20)), hand(3, 6, doubles(0.04, 0.1)), hand(4, 7)]


def hand_sessions():
    yield "commands", segments(HAND_CONNECT) + b"".join(segments(command) + SUCCESS for command in HAND_COMMANDS)
    yield "aborted_by_the_next", segments(HAND_CONNECT + b"".join(HAND_COMMANDS))
    yield "failures", segments(HAND_CONNECT + HAND_COMMANDS[1]) + UNSUCCESSFUL + segments(HAND_COMMANDS[2]) + FAIL + HAND_ABORTED
    yield "bad_values", segments(HAND_CONNECT + hand(3, 6, doubles(7, 0.1)) + hand(3, 7, doubles(math.inf, 0.1)))
    yield "bytes_one_by_one", segments(HAND_CONNECT + HAND_COMMANDS[3], 1)
    yield "wrong_version", segments(hand(0, 0, struct.pack("<HH", 2, 43210)))


def command(state_id, finished=False, elbow=False, value=0.5):
    q = doubles(0, -math.pi / 4, 0, -3 * math.pi / 4, 0, math.pi / 2, math.pi / 4)
    data = struct.pack("<Q", state_id) + q + doubles(*[0] * 7, *IDENTITY, *[0] * 6, value, -1)
    return data + bytes([elbow, finished]) + doubles(*[value] * 7)


def commands():
    yield "first", command(1)
    yield "last", command(1 << 40, finished=True)
    yield "elbow", command(2, elbow=True)
    yield "not_a_number", command(3, value=math.nan)
    yield "flag_that_is_none", command(4)[:312] + b"\2\0" + command(4)[314:]
    yield "short", command(5)[:-1]
    yield "end_of_one", command(6)[-60:]


def state(state_id, generator, controller, mode, errors=()):
    flags = bytes(i in errors for i in range(41))
    values = doubles(*(0.01 * i for i in range(284)))
    return struct.pack("<Q", state_id) + values + bytes([generator, controller]) + 2 * flags + bytes([mode]) + doubles(1.0)


def states():
    yield "idle", state(1, 0, 3, 1)
    yield "moving", state(1 << 33, 3, 1, 2)
    yield "reflex", state(7, 0, 3, 4, errors=(14, 25))
    yield "mode_that_is_none", state(8, 9, 9, 99)
    yield "short", state(9, 0, 3, 1)[:-1]
    yield "end_of_one", state(10, 0, 3, 4)[-93:]


def hand_state(width=0.04, grasped=1):
    return struct.pack("<IddBH", 12, width, 0.08, grasped, 30)


def asked(number, answer, piece=256):
    """For the targets of answers: what was asked, in what pieces the answer comes."""
    return bytes([number, piece - 1]) + answer


def arm_answers():
    yield "connect", asked(0, arm(0, 0, struct.pack("<BH", 0, 5)))
    yield "wrong_version", asked(0, arm(0, 0, struct.pack("<BH", 1, 4)))
    yield "move", asked(1, arm(1, 7, b"\1") + arm(1, 7, b"\0"), 7)
    yield "stop_and_move", asked(2, arm(2, 8, b"\0") + arm(1, 7, b"\2"))
    yield "wall", asked(3, arm(3, 1, b"\0" + doubles(1, 2, 3, *IDENTITY) + b"\1"))
    yield "setter", asked(5, arm(5, 2, b"\2"))
    yield "library", asked(13, arm(13, 9, b"\0\x7fELF" + bytes(range(64))), 50)
    yield "empty", asked(4, arm(4, 2))
    yield "too_large", asked(13, struct.pack("<III", 13, 1, 1 << 31))


def hand_answers():
    yield "connect", asked(0, hand(0, 0, struct.pack("<HH", 0, 3)))
    yield "grasp", asked(2, hand(2, 5, struct.pack("<H", 2)), 3)
    yield "status_that_is_none", asked(1, hand(1, 4, struct.pack("<H", 9)))


def gripper():
    for name, script in hand_sessions():
        yield f"session_{name}", SESSION + script
    for name, answers in hand_answers():
        yield f"answer_{name}", ANSWERS + answers
    yield "state", STATE + hand_state()
    yield "state_flag_that_is_none", STATE + hand_state(grasped=7)
    yield "state_short", STATE + hand_state()[:-1]


def sample(kind=0, engaged=1, token=b"secret", sequence=7, axes=(0.1, -0.2, 0.3, 0, 0, -1), presses=(1, 2, 3, 4, 5, 6, 7), magic=b"PTOS",
           version=1):
    return struct.pack("<4sHBB16sQq6d7I", magic, version, kind, engaged, token, sequence, -5, *axes, *presses)


def feedback(mode=1, flags=31, wrench=(1, 2, 3, 4, 5, 6)):
    return struct.pack("<4sHBBQQ6d", b"PTOF", 1, mode, flags, 9, 8, *wrench)


def operator_datagrams():
    yield "good_rate", sample()
    yield "good_pose", sample(kind=1, axes=(0.5, -2, 9.5, 3.1, 0, 0))
    yield "good_clutch", sample(engaged=0, sequence=1 << 40, presses=7 * (0xFFFFFFFF,))
    yield "good_feedback", feedback()
    yield "good_feedback_of_nothing", feedback(0, 0, 6 * (0,))
    yield "bad_magic", sample(magic=b"PTOX")
    yield "bad_version", sample(version=2)
    yield "bad_kind", sample(kind=2)
    yield "bad_flag", sample(engaged=255)
    yield "bad_sequence", sample(sequence=0)
    yield "bad_deflection", sample(axes=(1.01, 0, 0, 0, 0, 0))
    yield "bad_handle", sample(kind=1, axes=(0, 0, -11, 0, 0, 0))
    yield "bad_number", sample(axes=(0, math.nan, 0, 0, 0, 0))
    yield "bad_short", sample()[:-1]
    yield "bad_long", sample() + b"\0"
    yield "bad_feedback_flag", feedback(flags=32)
    yield "bad_feedback_mode", feedback(mode=2)
    yield "bad_feedback_number", feedback(wrench=(math.inf, 0, 0, 0, 0, 0))


SCRIPT = b"time,kind,x,y,z,rx,ry,rz,engaged,mode,gripper,frame,scale,stop,release,end\n"
REST = b"0,rate,0,0,0,0,0,0,1,0,0,0,0,0,0,0\n"


def operator_scripts():
    yield "good_short", SCRIPT + REST
    yield "good_session", SCRIPT + REST + b"".join(
        f"{0.01 * i:.9f},rate,{i / 20},0,0,0,0,{-i / 20},{i % 2},0,{i % 3},0,0,0,0,{i // 19}\n".encode() for i in range(1, 20))
    yield "good_poses", SCRIPT + b" 1e-3 , pose ,1.5,-2,3,0,0,0,0,1,1,1,1,1,1,1\r\n\r\n"
    yield "good_end_of_line", b"\xef\xbb\xbf" + SCRIPT + REST[:-1]
    yield "bad_empty", b""
    yield "bad_no_rows", SCRIPT
    yield "bad_header", SCRIPT.replace(b"kind", b"sort") + REST
    yield "bad_time", SCRIPT + REST + REST
    yield "bad_kind", SCRIPT + REST.replace(b"rate", b"speed")
    yield "bad_axis", SCRIPT + b"0,rate,0,0,1.5,0,0,0,1,0,0,0,0,0,0,0\n"
    yield "bad_number", SCRIPT + b"0,rate,0,0,nan,0,0,0,1,0,0,0,0,0,0,0\n"
    yield "bad_presses", SCRIPT + b"0,rate,0,0,0,0,0,0,1,0,-1,0,0,0,0,0\n"
    yield "bad_fields", SCRIPT + b"0,rate,0,0,0\n"
    yield "bad_gap", SCRIPT + REST + b"\n" + b"1" + REST[1:]
    yield "bad_bytes", SCRIPT + bytes(range(256)) * 4


def corpus():
    """@returns {path: bytes}."""
    targets = {"server_tcp": arm_sessions, "server_udp": commands, "client_tcp": arm_answers, "client_udp": states, "gripper": gripper,
               "operator_datagram": operator_datagrams, "operator_script": operator_scripts}
    return {FOLDER / target / f"{name}.bin": data for target, seeds in targets.items() for name, data in seeds()}


def differences(wanted):
    there = {path: path.read_bytes() for path in FOLDER.rglob("*") if path.is_file()}
    for path in sorted(wanted.keys() | there.keys()):
        if wanted.get(path) != there.get(path):
            yield path.relative_to(FOLDER)


def main():
    wanted = corpus()
    size = sum(map(len, wanted.values()))
    if size > MOST_BYTES:
        sys.exit(f"the corpus has {size} bytes; it may have {MOST_BYTES}")
    if "--check" not in sys.argv:
        for path, data in wanted.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
    wrong = list(differences(wanted))
    for path in wrong:
        print(f"{path} is not what make_corpus.py writes; run it again")
    print(f"{len(wanted)} seeds, {size} bytes")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
