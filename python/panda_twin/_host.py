"""Tells the extension module about this host: the only place of the package that reads the environment."""

import importlib.metadata
import os
import pathlib

from . import _core


def _own_folder(variable: str, usual: str) -> str:
    """The package's folder in a base folder of the XDG specification, as the program has it."""
    base = os.environ.get(variable, "")
    home = os.environ.get("HOME", "")
    if base.startswith("/"):
        return f"{base}/panda-twin"
    return f"{home}/{usual}/panda-twin" if home.startswith("/") else ""


def _executable() -> pathlib.Path:
    """The program: in the wheel, else where it would be in the build folder that has this package as python/panda_twin."""
    module = pathlib.Path(_core.__file__).resolve()
    installed = module.parent / "bin/panda-twin"
    return installed if installed.exists() else module.parents[2] / "panda-twin"


def _meshes() -> str:
    """The Panda's meshes: as the user says, else those of the package example-robot-data, else those beside the program."""
    if given := os.environ.get("PANDA_TWIN_MESHES"):
        return given
    try:
        package = importlib.metadata.distribution("example-robot-data")
    except importlib.metadata.PackageNotFoundError:
        return ""
    folder = str(package.locate_file("cmeel.prefix/share/example-robot-data/robots/panda_description"))
    return folder if os.path.isdir(folder) else ""


executable = _executable()
meshes = _meshes()
# Texts, since an empty one says that a folder is sought: pathlib.Path("") is the current folder.
_core.set_host(
    executable=executable,
    models="",
    meshes=meshes,
    cache=_own_folder("XDG_CACHE_HOME", ".cache"),
    state=_own_folder("XDG_STATE_HOME", ".local/state"),
    path=os.environ.get("PATH", ""),
)
