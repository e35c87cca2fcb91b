#!/usr/bin/env python3
"""Runs a command under the system-call filter of a systemd unit: sandbox.py UNIT COMMAND...

Does without systemd what it does for SystemCallFilter=, SystemCallArchitectures=native, SystemCallErrorNumber=EPERM and
MemoryDenyWriteExecute= (systemd.exec(5)): a seccomp filter (seccomp(2)) that children inherit. x86-64 only. Groups are those of
`systemd-analyze syscall-filter`, numbers those of the kernel's headers.
"""

import ctypes
import errno
import functools
import os
import pathlib
import re
import struct
import subprocess
import sys

NUMBERS = pathlib.Path("/usr/include/x86_64-linux-gnu/asm/unistd_64.h")
NO_NEW_PRIVILEGES, SET_SECCOMP, MODE_FILTER = 38, 22, 2  # linux/prctl.h, linux/seccomp.h
LOAD, AND, IF_EQUAL, IF_NOT_LESS, RETURN = 0x20, 0x54, 0x15, 0x35, 0x06  # linux/bpf_common.h
ALLOW, KILL, REFUSE = 0x7FFF0000, 0x80000000, 0x00050000 | errno.EPERM
NUMBER_AT, ARCHITECTURE_AT, PROTECTION_AT = 0, 4, 32  # struct seccomp_data; the third argument's lower half
X86_64, X32_BIT = 0xC000003E, 0x40000000
WRITE, EXECUTE = 2, 4  # PROT_WRITE, PROT_EXEC


def settings(unit: pathlib.Path) -> list[tuple[str, str]]:
    return re.findall(r"^(\w+)=(.*)$", unit.read_text(), re.M)


@functools.cache
def members(group: str) -> frozenset[str]:
    lines = subprocess.run(["systemd-analyze", "syscall-filter", group], check=True, capture_output=True, text=True).stdout.split("\n")[1:]
    return frozenset().union(*(expanded(line.strip()) for line in lines if line.strip() and "#" not in line))


def expanded(word: str) -> frozenset[str]:
    return members(word) if word.startswith("@") else frozenset((word,))


def allowed(unit: pathlib.Path) -> frozenset[str]:
    calls: frozenset[str] = frozenset()
    for key, value in settings(unit):
        if key == "SystemCallFilter":
            named = frozenset().union(*(expanded(word) for word in value.lstrip("~").split()))
            calls = calls - named if value.startswith("~") else calls | named
    return calls


def program(unit: pathlib.Path) -> bytes:
    """The filter, in the kernel's instructions."""
    numbers = {name: int(number) for name, number in re.findall(r"#define __NR_(\w+) (\d+)", NUMBERS.read_text())}
    code = [(LOAD, 0, 0, ARCHITECTURE_AT), (IF_EQUAL, 1, 0, X86_64), (RETURN, 0, 0, KILL),
            (LOAD, 0, 0, NUMBER_AT), (IF_NOT_LESS, 0, 1, X32_BIT), (RETURN, 0, 0, REFUSE)]
    if ("MemoryDenyWriteExecute", "yes") in settings(unit):
        for name, bits in (("mmap", WRITE | EXECUTE), ("mprotect", EXECUTE), ("pkey_mprotect", EXECUTE)):
            code += [(IF_EQUAL, 0, 5, numbers[name]), (LOAD, 0, 0, PROTECTION_AT), (AND, 0, 0, bits), (IF_EQUAL, 0, 1, bits),
                     (RETURN, 0, 0, REFUSE), (LOAD, 0, 0, NUMBER_AT)]
    for name in sorted(allowed(unit) & numbers.keys()):
        code += [(IF_EQUAL, 0, 1, numbers[name]), (RETURN, 0, 0, ALLOW)]
    return b"".join(struct.pack("<HBBI", *instruction) for instruction in [*code, (RETURN, 0, 0, REFUSE)])


def main():
    code = ctypes.create_string_buffer(program(pathlib.Path(sys.argv[1])))
    filter_of_it = ctypes.create_string_buffer(struct.pack("<HxxxxxxQ", len(code) // 8, ctypes.addressof(code)))
    libc = ctypes.CDLL(None, use_errno=True)
    for request in ((NO_NEW_PRIVILEGES, 1, 0, 0, 0), (SET_SECCOMP, MODE_FILTER, filter_of_it, 0, 0)):
        if libc.prctl(*request) != 0:
            sys.exit(f"sandbox: prctl: {os.strerror(ctypes.get_errno())}")
    os.execv(sys.argv[2], sys.argv[2:])


if __name__ == "__main__":
    main()
