"""Tells the extension module about this host: the only place of the package that reads the environment."""

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
    """Where the program would be: in the build folder that has this package as python/panda_twin."""
    return pathlib.Path(_core.__file__).resolve().parents[2] / "panda-twin"


_core.set_host(
    executable=_executable(),
    models="",  # Path() would be the working folder
    meshes="",
    cache=pathlib.Path(_own_folder("XDG_CACHE_HOME", ".cache")),
    state=pathlib.Path(_own_folder("XDG_STATE_HOME", ".local/state")),
    path=os.environ.get("PATH", ""),
)
