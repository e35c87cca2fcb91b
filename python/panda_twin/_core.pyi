"""Types of the extension module. Each part is in the source of that name in python/src."""

import pathlib

import numpy as np
import numpy.typing as npt

__version__: str

class RobotFault(RuntimeError): ...

# module.cc
def set_host(*, executable: pathlib.Path, models: str, meshes: str, cache: str, state: str, path: str) -> None: ...

# model.cc: arrays of n rows, C-contiguous; the last one is filled
_Rows = npt.NDArray[np.float64]

def model_gravity(q: _Rows, load: list[float], g_earth: list[float], of_plant: bool, out: _Rows, /) -> None: ...
def model_coriolis(q: _Rows, dq: _Rows, load: list[float], of_plant: bool, out: _Rows, /) -> None: ...
def model_mass(q: _Rows, load: list[float], of_plant: bool, out: _Rows, /) -> None: ...
def model_jacobian(q: _Rows, frame: str, F_T_EE: list[float], in_body: bool, out: _Rows, /) -> None: ...
def model_fk(q: _Rows, frame: str, F_T_EE: list[float], out: _Rows, /) -> None: ...
def model_ik(O_T_EE: _Rows, q7: _Rows, F_T_EE: list[float], q_min: list[float], q_max: list[float], out: _Rows, /) -> None: ...
def model_panda() -> tuple[list[float], list[float], list[float], float, list[float], list[float]]: ...

# served.cc
class ServeOptions:
    scenario: pathlib.Path
    yaml: str
    lab: str | None
    scene: pathlib.Path | None
    seed: int | None
    drive: str | None
    pace: float | None
    idle: str
    clock_ppm: float | None
    session_timeout: float
    viability: int | None
    guard: bool
    reset: str
    out: pathlib.Path | None
    no_video: bool
    log: pathlib.Path | None
    capture: pathlib.Path | None

class Served:
    closed: bool
    hostname: str
    port: int
    drive: str
    events: list[tuple[float, str, str]]
    def ask(self, line: str, /) -> str: ...
    def close(self) -> list[str]: ...

def serve(options: ServeOptions, hostname: str | None, control: pathlib.Path | None) -> Served: ...
