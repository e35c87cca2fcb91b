#!/usr/bin/env python3
"""Checks what a model library's file is like, and that a foreign process can load and call it.

    check_model_library.py FILE...      checks each file
    check_model_library.py --self-test  checks that every rule rejects the input made to break it

Exit code 0 when nothing is wrong, 1 otherwise.
"""

import copy
import ctypes
import math
import pathlib
import re
import subprocess
import sys

FUNCTIONS = sorted([f"{stem}{n}" for stem in ("O_T_J", "O_J_J", "Ji_J_J") for n in range(1, 10)] + ["M_NE", "c_NE", "g_NE"])
# What every C library has since it exists on the machine, beside its version there.
IMPORTS = {"sin", "cos", "sincos", "sqrt", "memcpy", "memset", "memmove"}
OLDEST = {"x86-64": "GLIBC_2.2.5", "AArch64": "GLIBC_2.17"}
NEEDED = {"libm.so.6", "libc.so.6"}
LARGEST = 64 * 1024
LIBRARY_PATHS = {"RPATH", "RUNPATH", "SONAME", "TEXTREL"}
OF_A_BUILD = re.compile(r"libstdc\+\+|libgcc_s|lib(a|t|ub)san")


def output_of(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def facts_of(file):
    """What the file's tables say."""
    header = output_of("readelf", "-hW", file)
    dynamic = re.findall(r"\((\w+)\)\s+(.*)", output_of("readelf", "-dW", file))
    undefined = [line.split()[-1] for line in output_of("nm", "-D", "--undefined-only", file).splitlines()]
    return {
        "machine": next((name for name in OLDEST if name.lower() in header.lower()), "unknown"),
        "exported": sorted(line.split()[-1] for line in output_of("nm", "-D", "--defined-only", file).splitlines()),
        "imported": [tuple((name + "@").split("@")[:2]) for name in undefined],
        "needed": re.findall(r"\[(.*)\]", "\n".join(value for tag, value in dynamic if tag == "NEEDED")),
        "tags": sorted({tag for tag, _ in dynamic}),
        "bound_at_load": any(tag == "FLAGS" and "BIND_NOW" in value for tag, value in dynamic),
        "stripped": ".symtab" not in output_of("readelf", "-SW", file),
        "executable_stack": bool(re.search(r"GNU_STACK.*RWE", output_of("readelf", "-lW", file))),
        "size": pathlib.Path(file).stat().st_size,
    }


def breaches(facts):
    """What a client would stumble over."""
    for name in FUNCTIONS:
        if name not in facts["exported"]:
            yield f"does not export {name}"
    for name in facts["exported"]:
        if name not in FUNCTIONS:
            yield f"exports {name}, which clients of two robots would share"
    oldest = OLDEST.get(facts["machine"])
    if oldest is None:
        yield f"is for a machine whose oldest glibc is not known: {facts['machine']}"
    for name, version in facts["imported"]:
        if name not in IMPORTS:
            yield f"imports {name}"
        elif oldest and version != oldest:
            yield f"imports {name} in version {version!r}, not {oldest}"
    for name in facts["needed"]:
        if name not in NEEDED:
            yield f"needs {name}"
    for tag in sorted(LIBRARY_PATHS.intersection(facts["tags"])):
        yield f"has a {tag}"
    if not facts["bound_at_load"]:
        yield "resolves names at the first call, which may be a real-time thread's"
    if not facts["stripped"]:
        yield "is not stripped"
    if facts["executable_stack"]:
        yield "wants an executable stack"
    if facts["size"] >= LARGEST:
        yield f"has {facts['size']} bytes; libfranka-rs loads only what is below {LARGEST}"


def check_loading(file):
    """Loads it here, where neither C++ nor a sanitizer is, and asks for the flange of the stretched arm."""
    before = OF_A_BUILD.findall(pathlib.Path("/proc/self/maps").read_text())
    library = ctypes.CDLL(str(file), mode=ctypes.RTLD_GLOBAL)
    loaded = OF_A_BUILD.findall(pathlib.Path("/proc/self/maps").read_text())
    if set(loaded) - set(before):
        yield f"brings with it {sorted(set(loaded) - set(before))}"
    q, pose = (ctypes.c_double * 7)(), (ctypes.c_double * 16)()
    library.O_T_J8(q, pose)
    expected = (0.088, 0, 0.333 + 0.316 + 0.384 - 0.107)  # sums of the DH table
    if not all(math.isclose(value, wanted, abs_tol=1e-12) for value, wanted in zip(pose[12:15], expected)):
        yield f"puts the flange at {pose[12:15]}, not at {expected}"


def sound_facts():
    return {"machine": "x86-64", "exported": list(FUNCTIONS), "imported": [("sincos", "GLIBC_2.2.5")], "needed": ["libm.so.6"],
            "tags": ["NEEDED", "GNU_HASH"], "bound_at_load": True, "stripped": True, "executable_stack": False, "size": 40000}


# Each case: a change of sound facts, and what must be said about it ("" means: nothing).
SELF_TEST = [
    (lambda facts: None, ""),
    (lambda facts: facts["needed"].append("libc.so.6"), ""),
    (lambda facts: facts.update(machine="AArch64", imported=[("sin", "GLIBC_2.17")]), ""),
    (lambda facts: facts["exported"].remove("O_J_J1"), "does not export O_J_J1"),
    (lambda facts: facts["exported"].append("helper"), "exports helper"),
    (lambda facts: facts["imported"].append(("exp", "GLIBC_2.2.5")), "imports exp"),
    (lambda facts: facts["imported"].append(("memcpy", "GLIBC_2.14")), "imports memcpy in version 'GLIBC_2.14'"),
    (lambda facts: facts["imported"].append(("sin", "")), "imports sin in version ''"),
    (lambda facts: facts["imported"].append(("__asan_init", "")), "imports __asan_init"),
    (lambda facts: facts["needed"].append("libstdc++.so.6"), "needs libstdc++.so.6"),
    (lambda facts: facts["tags"].append("RUNPATH"), "has a RUNPATH"),
    (lambda facts: facts["tags"].append("SONAME"), "has a SONAME"),
    (lambda facts: facts.update(machine="unknown"), "oldest glibc is not known"),
    (lambda facts: facts.update(bound_at_load=False), "at the first call"),
    (lambda facts: facts.update(stripped=False), "is not stripped"),
    (lambda facts: facts.update(executable_stack=True), "executable stack"),
    (lambda facts: facts.update(size=LARGEST), "has 65536 bytes"),
]


def self_test():
    """@returns what went wrong, one text per case."""
    failures = []
    for number, (change, expected) in enumerate(SELF_TEST):
        facts = copy.deepcopy(sound_facts())
        change(facts)
        found = list(breaches(facts))
        if (len(found) != 1 or expected not in found[0]) if expected else found:
            failures.append(f"case {number}: expected {expected or 'nothing'!r}, got {found}")
    # A file of someone else's: the tables are really read.
    python = facts_of(pathlib.Path("/proc/self/exe").resolve())
    said = "\n".join(breaches(python))
    if not all(text in said for text in ("does not export M_NE", "imports", "has ")):
        failures.append(f"Python passes for a model library: {python}")
    return failures


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if sys.argv[1] == "--self-test":
        wrong = self_test()
    else:
        wrong = []
        for file in sys.argv[1:]:
            facts = facts_of(file)
            print(f"{file}: {len(facts['exported'])} functions, imports {facts['imported']}, needs {facts['needed']}, {facts['size']} bytes")
            wrong += [f"{file} {text}" for text in list(breaches(facts)) + list(check_loading(file))]
    print("\n".join(wrong) if wrong else "model library: sound")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
