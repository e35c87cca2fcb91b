#!/usr/bin/env python3
"""Packs the Debian package and checks what it says of itself and holds.

    check_deb.py BUILD VERSION
"""

import pathlib
import subprocess
import sys
import tempfile

FIELDS = {
    "Package": lambda value, _: value == "panda-twin",
    "Version": lambda value, version: value == version,
    "Maintainer": lambda value, _: "@" in value,
    "Description": lambda value, _: "Panda" in value,
    # dpkg-shlibdeps found what the program links to, and what it runs is named beside it.
    "Depends": lambda value, _: all(name in value for name in ("libmujoco", "libosmesa6", "libc6", "ffmpeg", "gnuplot")),
}
CONTENTS = (
    "./usr/bin/panda-twin",
    "./usr/bin/panda-twin-campaign",
    "./usr/share/bash-completion/completions/panda-twin",
    "./usr/share/man/man1/panda-twin.1",
    "./usr/include/twin/core/robot_state.h",
    "./usr/lib/panda-twin/libpanda_model.so",
    "./usr/share/panda_twin/models/scenarios/canonical.yaml",
    "./usr/share/doc/panda-twin/copyright",
    "./usr/share/doc/panda-twin/LICENSE",
)


def output_of(*command):
    """Runs a command; ends the check with its output when it fails."""
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0:
        sys.exit(f"failed ({result.returncode}): {' '.join(command)}\n{result.stdout}")
    return result.stdout


def main():
    build, version = pathlib.Path(sys.argv[1]), sys.argv[2]
    wrong = []
    with tempfile.TemporaryDirectory(prefix="panda-twin-deb-") as folder:
        output_of("cpack", "-G", "DEB", "--config", str(build / "CPackConfig.cmake"), "-B", folder)
        packages = list(pathlib.Path(folder).glob("*.deb"))
        if len(packages) != 1:
            sys.exit(f"expected one package, got {packages}")
        package = str(packages[0])
        for field, holds in FIELDS.items():
            value = output_of("dpkg-deb", "--field", package, field).strip()
            print(f"{field}: {value.splitlines()[0] if value else ''}")
            if not holds(value, version):
                wrong.append(f"field {field} is wrong: {value!r}")
        names = {line.split()[-1] for line in output_of("dpkg-deb", "--contents", package).splitlines()}
        wrong += [f"{name} is not in the package" for name in CONTENTS if name not in names]
        print(f"{packages[0].name}: {packages[0].stat().st_size // 1024} KiB, {len(names)} entries")
    print("\n".join(wrong) if wrong else "deb: sound")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
