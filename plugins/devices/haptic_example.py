#!/usr/bin/env python3
"""A haptic device's program: haptic_example.py TOKEN [PORT]. Here, the "device" draws an eight."""
import math, socket, struct, sys, time

token, port = sys.argv[1].encode(), int(sys.argv[2]) if len(sys.argv) > 2 else 4811
device = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
device.connect(("127.0.0.1", port))
device.setblocking(False)
began = time.monotonic()
for sequence in range(1, 1001):                        # ten seconds, a hundred samples a second
    t = time.monotonic() - began
    axes = [0.3 * math.sin(t), 0.3 * math.sin(2 * t), 0, 0, 0, 0]  # deflections: ahead, left, up, and about them; from 0 on
    presses = [0, int(t > 1), 0, 0, 0, 0, int(t > 9)]  # mode, gripper (at 1 s), frame, scale, stop, release, end (at 9 s)
    device.send(struct.pack("<4sHBB16sQq6d7I", b"PTOS", 1, 0, 1, token, sequence, int(t * 1e9), *axes, *presses))
    try:
        while True:                                    # the newest feedback counts
            magic, version, mode, flags, number, echo, *wrench = struct.unpack("<4sHBBQQ6d", device.recv(72))
            if sequence % 20 == 0:
                print(f"{'base' if mode else 'arm'} force {wrench[0]:+.1f} {wrench[1]:+.1f} {wrench[2]:+.1f} N", flush=True)
    except (BlockingIOError, ConnectionRefusedError):
        pass                                           # nothing came, or no program listens (yet)
    time.sleep(0.01)
