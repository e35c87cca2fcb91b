"""A `panda-twin serve` of a test's own: on a loopback address that no other test uses, stopped when the test ends.

libfranka's ports are fixed (1337 to 1339), its address is not: all of 127.0.0.0/8 is this machine.
"""

import itertools
import os
import pathlib
import signal
import subprocess
import tempfile
import time

ARM_PORT, HAND_PORT, VACUUM_PORT = 1337, 1338, 1339
GOOD_ENDS = (0, 130)  # the program's exit codes: done, interrupted
_numbers = itertools.count()


def own_address():
    """Differs between tests that run at the same time, and between the servers of one."""
    pid = os.getpid()
    return f"127.{1 + next(_numbers) % 254}.{pid >> 8 & 255}.{pid & 255}"


def is_listening(address, port):
    """Looks at the kernel's table: a connection made only to see would be a client to the server."""
    octets = "".join(f"{int(part):02X}" for part in reversed(address.split(".")))
    wanted = f"{octets}:{port:04X}"
    for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]:
        _, local, _, state = line.split()[:4]
        if local == wanted and state == "0A":
            return True
    return False


class TwinServer:
    """with TwinServer(program, source, "lockstep", "--scene", "scenes/table_box.xml") as server: server.address"""

    def __init__(self, program, source, drive, *options, hand_port=HAND_PORT):
        self.address, self.hand_port = own_address(), hand_port
        self.command = [program, "serve", "--bind", self.address, "--drive", drive,
                        "--data", pathlib.Path(source, "models"), *options]

    def __enter__(self):
        self.output = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen(self.command, stdout=self.output, stderr=subprocess.STDOUT)
        limit = time.monotonic() + 60
        while not (is_listening(self.address, ARM_PORT) and is_listening(self.address, self.hand_port)):
            if self.process.poll() is not None or time.monotonic() > limit:
                self._end(signal.SIGKILL)
                raise RuntimeError(f"{self.command} does not serve:\n{self.said()}")
            time.sleep(0.02)
        return self

    def __exit__(self, *_):
        """It must go when asked to: one that hangs or crashed is a failure."""
        status = self._end(signal.SIGTERM)
        if status not in GOOD_ENDS:
            raise RuntimeError(f"{self.command} ended with {status}:\n{self.said()}")
        self.output.close()

    def said(self):
        """What the server has printed so far."""
        self.output.seek(0)
        return self.output.read()

    def _end(self, with_signal):
        self.process.send_signal(with_signal)
        try:
            return self.process.wait(timeout=60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            return "no end for 60 s"
