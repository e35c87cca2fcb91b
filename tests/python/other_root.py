"""Another system's root as a folder (scripts/container-root), and commands in it: its own files, processes and environment, this host's
network and kernel. Wants root's rights."""

import functools
import pathlib
import re
import shutil
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def run(*command, **options):
    """What it prints. Fails with that when it fails."""
    result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=3600, **options)
    if result.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} ended with {result.returncode}:\n{result.stdout}")
    return result.stdout


def make_wheels(out, *options):
    """By their tags, such as cp311-cp311."""
    run(SOURCE / "scripts/wheel", *options, out)
    return {"-".join(wheel.name.split("-")[2:4]): wheel for wheel in out.glob("panda_twin-*-manylinux_*.whl")}


class OtherRoot:
    """The root that scripts/container-root makes in a folder."""

    def __init__(self, folder, wheel, *options):
        print(run(SOURCE / "scripts/container-root", *options, "--wheel", wheel, folder), end="", flush=True)
        self.folder = folder
        self.site = next(folder.glob("opt/panda-twin/lib/python3.*/site-packages"))

    def command(self, *words, **variables):
        """What runs it in there."""
        environment = {"PATH": "/opt/panda-twin/bin:/usr/bin:/bin:/sbin", "HOME": "/srv", "LC_ALL": "C.UTF-8"} | variables
        return ["unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc", "--root", self.folder, "--wd", "/srv",
                "env", "-i", *(f"{name}={value}" for name, value in environment.items()), *words]

    def run(self, *words, **variables):
        return run(*self.command(*words, **variables))

    def python(self, program, *arguments):
        """What a program in Python prints."""
        return self.run("python", "-c", program, *arguments)

    def path(self, inside):
        """Of a file in it, seen from here."""
        return self.folder / inside.lstrip("/")

    def install(self, *requirements):
        """Packages from PyPI, each a name and the file of scripts/ or tests/ that has its version and hashes."""
        wheels = fetch(self.folder / "tmp/fetched", requirements)
        self.run("pip", "install", "--quiet", "--no-index", "--no-deps", *(f"/tmp/fetched/{wheel.name}" for wheel in wheels))


@functools.cache
def blocks(file):
    """The requirements of a file, each with its hashes, by the package's name."""
    text = (SOURCE / file).read_text()
    return {block[1]: block[0] for block in re.finditer(r"^([A-Za-z0-9_-]+)==(?:.*\\\n)*.*$", text, re.MULTILINE)}


def fetch(folder, requirements):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    wanted = folder / "requirements.txt"
    wanted.write_text("\n".join(blocks(file)[name] for name, file in requirements) + "\n")
    run(sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:", "--require-hashes", "-r", wanted,
        "-d", folder)
    return sorted(folder.glob("*.whl"))
