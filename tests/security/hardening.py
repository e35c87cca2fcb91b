"""What a program is hardened by, as `readelf` of binutils shows it: what Debian's `hardening=+all` asks for, and CET beside."""

import pathlib
import re
import subprocess

ENDBR64 = b"\xf3\x0f\x1e\xfa"  # where an indirect jump may land (Intel SDM, volume 2)


def readelf(*arguments: str) -> str:
    return subprocess.run(["readelf", "-W", *arguments], check=True, capture_output=True, text=True).stdout


def is_position_independent(program: pathlib.Path) -> bool:
    return bool(re.search(r"FLAGS_1\).*\bPIE\b", readelf("-d", program)))


def is_read_only_once_bound(program: pathlib.Path) -> bool:
    """Full RELRO: the tables of addresses are bound at start and read-only from then on."""
    return "GNU_RELRO" in readelf("-l", program) and bool(re.search(r"BIND_NOW|FLAGS_1\).*\bNOW\b", readelf("-d", program)))


def has_no_executable_stack(program: pathlib.Path) -> bool:
    return bool(re.search(r"GNU_STACK(\s+0x[0-9a-f]+){5}\s+RW\s", readelf("-l", program)))


def imports(program: pathlib.Path) -> set[str]:
    return set(re.findall(r"\bUND\s+(\w+)", readelf("--dyn-syms", program)))


def guards_its_stacks(program: pathlib.Path) -> bool:
    return "__stack_chk_fail" in imports(program)


def calls_checked_functions(program: pathlib.Path) -> bool:
    """Fortified: libc's functions that know how large their destination is."""
    return any(re.fullmatch(r"__\w+_chk", name) for name in imports(program))


def functions_without_landing(program: pathlib.Path, names: str) -> tuple[int, list[str]]:
    """Of the functions that others may name or point to, and whose mangled names match: how many there are, and which begin without endbr64."""
    text = re.search(r"\s\.text\s+PROGBITS\s+([0-9a-f]+)\s+([0-9a-f]+)\s+([0-9a-f]+)", readelf("-S", program))
    address, offset, size = (int(number, 16) for number in text.groups())
    code = program.read_bytes()[offset:offset + size]
    found, without = 0, []
    for value, name in re.findall(r"^\s*\d+:\s+([0-9a-f]+)\s+\S+\s+FUNC\s+(?:GLOBAL|WEAK)\s+\S+\s+\d+\s+(\S+)", readelf("-s", program), re.M):
        begin = int(value, 16) - address
        if re.match(names, name) and 0 <= begin < size:
            found += 1
            if code[begin:begin + len(ENDBR64)] != ENDBR64:
                without.append(name)
    return found, without
