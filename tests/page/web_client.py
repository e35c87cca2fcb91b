"""A WebSocket client on a bare socket, so that tests can also say what no browser would."""

import base64
import json
import os
import socket
import struct
import time

TIMEOUT = 100  # s, longer than any machine takes over what is waited for
CONTINUATION, TEXT, BINARY, CLOSE, PING = 0, 1, 2, 8, 9


class Refused(Exception):
    """The server did not open the WebSocket; the HTTP status is the argument."""


def http(port, lines, address="127.0.0.1"):
    """Sends a request as it is and returns (status, header, body); 0 for the status when nothing came."""
    with socket.create_connection((address, port), timeout=TIMEOUT) as connection:
        connection.sendall("\r\n".join([*lines, "", ""]).encode("latin1"))
        reply = b""
        try:
            while chunk := connection.recv(65536):
                reply += chunk
        except ConnectionResetError:  # it did not read all that was sent
            pass
    head, _, body = reply.partition(b"\r\n\r\n")
    if not head:
        return 0, "", b""
    return int(head.split()[1]), head.decode("latin1"), body


class WebSocket:
    def __init__(self, port, host=None, origin=None):
        host = host or f"127.0.0.1:{port}"
        self.connection = socket.create_connection(("127.0.0.1", port), timeout=TIMEOUT)
        key = base64.b64encode(os.urandom(16)).decode()
        lines = ["GET /ws HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
                 f"Sec-WebSocket-Key: {key}"]
        if origin != "":
            lines.append(f"Origin: {origin or 'http://' + host}")
        self.connection.sendall("\r\n".join([*lines, "", ""]).encode())
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            chunk = self.connection.recv(4096)
            if not chunk:
                raise Refused(0)
            self.buffer += chunk
        head, _, self.buffer = self.buffer.partition(b"\r\n\r\n")
        status = int(head.split()[1])
        if status != 101:
            self.connection.close()
            raise Refused(status)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.connection.close()

    def send_frame(self, kind, payload, final=True, masked=True):
        head = bytes([(0x80 if final else 0) | kind])
        mask_bit = 0x80 if masked else 0
        if len(payload) < 126:
            head += bytes([mask_bit | len(payload)])
        else:
            head += bytes([mask_bit | 126]) + struct.pack(">H", len(payload))
        if masked:
            mask = os.urandom(4)
            head += mask
            payload = bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))
        self.connection.sendall(head + payload)

    def say(self, kind, **more):
        self.send_frame(TEXT, json.dumps({"type": kind, **more}).encode())

    def _take(self, size):
        while len(self.buffer) < size:
            chunk = self.connection.recv(65536)
            if not chunk:
                raise ConnectionError("ended")
            self.buffer += chunk
        taken, self.buffer = self.buffer[:size], self.buffer[size:]
        return taken

    def frame(self):
        """The next message, or control frame: (kind, payload)."""
        kind, payload, final = self._frame()
        while not final:
            more, part, last = self._frame()
            if more == CONTINUATION:
                payload, final = payload + part, last
        return kind, payload

    def _frame(self):
        first, second = self._take(2)
        size = second & 0x7F
        if size == 126:
            size = struct.unpack(">H", self._take(2))[0]
        elif size == 127:
            size = struct.unpack(">Q", self._take(8))[0]
        return first & 0x0F, self._take(size), bool(first & 0x80)

    def hear(self, wanted):
        """The next message of this type; others are left out. `wanted` may be a test of the message instead."""
        fits = wanted if callable(wanted) else lambda message: message["type"] == wanted
        for kind, payload in self._frames(wanted):
            if kind == TEXT and fits(message := json.loads(payload)):
                return message
            if kind == CLOSE:
                raise ConnectionError(payload[2:].decode())

    def picture(self):
        """The next picture's bytes."""
        return next(payload for kind, payload in self._frames("a picture") if kind == BINARY)

    def _frames(self, wanted):
        limit = time.monotonic() + TIMEOUT
        while time.monotonic() < limit:
            yield self.frame()
        raise AssertionError(f"did not hear {wanted} for {TIMEOUT} s")

    def closing(self):
        """Why the server ends it: the reason it gives, or "" when it just ends."""
        try:
            while True:
                kind, payload = self.frame()
                if kind == CLOSE:
                    return payload[2:].decode()
        except (ConnectionError, OSError):
            return ""


class Operator:
    """A client whose hands do the same thing for as long as it listens. Control that it lost, to a machine that held it up for longer than
    the page waits for hands, it takes anew. It lets go when the page asks for it: keys that were held while the robot could not be led."""

    HANDS_S = 0.033

    def __init__(self, port, token, of="pictures"):
        self.client = WebSocket(port)
        self.client.say("hello", token=token, of=of)
        self.me = self.client.hear("welcome")["you"]
        self.sent = 0

    def lead(self, axes, until, ask=None):
        """Holds these axes until a message fits; that message. ask: the kind and fields of what it says first, and again if that is
        refused for want of control. A button is pressed only once the teleoperation leads: what is pressed before leads nothing."""
        asks = ask is not None

        def fits(message):
            nonlocal asks
            if message["type"] == "refused":
                asks = ask is not None
            if message["type"] == "state":
                if message["operator"] != self.me:
                    self.client.say("take")
                elif asks and (ask[0] != "press" or message["teleop"]):
                    self.client.say(ask[0], **ask[1])
                    asks = False
                if time.monotonic() - self.sent > self.HANDS_S:
                    self.sent = time.monotonic()
                    lets_go = message["teleop"] and message["teleop"]["awaits_release"]
                    self.client.say("hands", axes=[0] * 6 if lets_go else axes, engaged=True, sent_ms=0)
            return until(message)
        return self.client.hear(fits)
