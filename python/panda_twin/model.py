"""The rigid-body model of the arm, M(q) ddq + C(q, dq) dq + g(q) = tau, over one configuration or many.

Joint positions are arrays of shape (7,) or (n, 7); results have the same leading shape. Frames are "joint1" to "joint7", "flange"
and "EE", the end effector, F_T_EE from the flange: by default the Franka Hand's, between its fingertips. A load is everything
beyond the flange, by default nothing: the Franka Hand is ``**HAND``. `figures` chooses the inertial parameters: "robot", those of
the real robot's own model, or "plant", those of the simulated arm.
"""

import functools
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
import numpy.typing as npt

from . import _core

__all__ = ["HAND", "F_T_HAND", "Q_MAX", "Q_MIN", "Q_READY", "coriolis", "fk", "gravity", "ik", "jacobian", "mass"]

Array: TypeAlias = npt.NDArray[np.float64]
Figures: TypeAlias = Literal["robot", "plant"]
Frame: TypeAlias = Literal["joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7", "flange", "EE"]


class Load(TypedDict):
    """The load arguments of `gravity`, `mass` and `coriolis`."""

    mass: float
    centre: Array
    inertia: Array


def _constant(values: npt.ArrayLike) -> Array:
    array = np.array(values, float)
    array.flags.writeable = False
    return array


Q_READY: Array = _constant([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
"""Ready pose, to which panda_py's ``move_to_start`` moves, rad, shape (7,)."""
Q_MIN: Array
"""Lower joint limits, rad, shape (7,)."""
Q_MAX: Array
"""Upper joint limits, rad, shape (7,)."""
F_T_HAND: Array
"""End effector of the Franka Hand in the flange, shape (4, 4)."""
HAND: Load
"""The Franka Hand as a load: ``gravity(q, **HAND)``."""


@functools.cache
def _panda() -> dict[str, Any]:
    """The constants above, from the models' files; read when first needed, so that the package can be imported without them."""
    q_min, q_max, F_T_hand, m, centre, inertia = _core.model_panda()
    return {"Q_MIN": _constant(q_min), "Q_MAX": _constant(q_max), "F_T_HAND": _constant(np.reshape(F_T_hand, (4, 4)).T),
            "HAND": {"mass": m, "centre": _constant(centre), "inertia": _constant(np.reshape(inertia, (3, 3)).T)}}


def __getattr__(name: str) -> Any:
    if name in ("Q_MIN", "Q_MAX", "F_T_HAND", "HAND"):
        return _panda()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _array(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    """`values` with a last shape, C-contiguous."""
    array = np.ascontiguousarray(values, float)
    if array.shape[-len(shape):] != shape or array.ndim > len(shape) + 1:
        rows = ", ".join(map(str, shape))
        one = f"({rows},)" if len(shape) == 1 else f"({rows})"
        raise ValueError(f"{name} has shape {array.shape}; it must be {one} or (n, {rows})")
    return array


def _rows(q: Array) -> Array:
    return q.reshape(-1, 7)


def _load(mass: float, centre: npt.ArrayLike, inertia: npt.ArrayLike) -> list[float]:
    load = [float(mass), *_array("centre", centre, (3,)).ravel().tolist(), *_array("inertia", inertia, (3, 3)).T.ravel().tolist()]
    if len(load) != 13 or not np.all(np.isfinite(load)) or load[0] < 0:
        raise ValueError("a load has one mass of at least 0 kg, one centre (3,) and one inertia (3, 3), all finite")
    return load


def _columns(F_T_EE: npt.ArrayLike | None) -> list[float]:
    """A pose as C++ has it; None: the hand's."""
    if F_T_EE is None:
        F_T_EE = _panda()["F_T_HAND"]
    pose = np.asarray(F_T_EE, float)
    if pose.shape != (4, 4):
        raise ValueError(f"F_T_EE has shape {pose.shape}; it must be (4, 4)")
    R = pose[:3, :3]
    if not np.allclose(R @ R.T, np.eye(3), atol=1e-6) or np.linalg.det(R) < 0 or not np.all(np.isfinite(pose)):
        raise ValueError("F_T_EE: it must be finite, with a rotation in the upper left, right-handed and orthonormal to 1e-6")
    columns: list[float] = pose.T.ravel().tolist()
    return columns


def _of_plant(figures: Figures) -> bool:
    if figures not in ("robot", "plant"):
        raise ValueError(f'figures: "{figures}" is neither robot nor plant')
    return figures == "plant"


def gravity(q: npt.ArrayLike, *, mass: float = 0.0, centre: npt.ArrayLike = (0.0, 0.0, 0.0),
            inertia: npt.ArrayLike = ((0.0, 0.0, 0.0),) * 3, g_earth: npt.ArrayLike = (0.0, 0.0, -9.81),
            figures: Figures = "robot") -> Array:
    """The torque that holds the arm, g(q).

    Parameters
    ----------
    q : array_like, shape (7,) or (n, 7)
        Joint positions, rad.
    mass, centre, inertia : float, array_like (3,), array_like (3, 3)
        Load beyond the flange: kg; centre of mass in the flange, m; inertia about it in the flange's axes, kg m^2.
    g_earth : array_like, shape (3,)
        Gravity in the base's axes, m/s^2.
    figures : {"robot", "plant"}
        Inertial parameters.

    Returns
    -------
    ndarray, shape (7,) or (n, 7)
        Nm.
    """
    q = _array("q", q, (7,))
    out = np.empty_like(q)
    g = _array("g_earth", g_earth, (3,)).ravel().tolist()
    _core.model_gravity(_rows(q), _load(mass, centre, inertia), g, _of_plant(figures), _rows(out))
    return out


def coriolis(q: npt.ArrayLike, dq: npt.ArrayLike, *, mass: float = 0.0, centre: npt.ArrayLike = (0.0, 0.0, 0.0),
             inertia: npt.ArrayLike = ((0.0, 0.0, 0.0),) * 3, figures: Figures = "robot") -> Array:
    """The torque of Coriolis and centrifugal forces, C(q, dq) dq.

    Parameters
    ----------
    q, dq : array_like, shape (7,) or (n, 7)
        Joint positions, rad, and velocities, rad/s.
    mass, centre, inertia, figures
        As for `gravity`.

    Returns
    -------
    ndarray, shape (7,) or (n, 7)
        Nm.
    """
    q, dq = np.broadcast_arrays(_array("q", q, (7,)), _array("dq", dq, (7,)))
    out = np.empty(q.shape)
    _core.model_coriolis(_rows(np.ascontiguousarray(q)), _rows(np.ascontiguousarray(dq)), _load(mass, centre, inertia),
                         _of_plant(figures), _rows(out))
    return out


def mass(q: npt.ArrayLike, *, mass: float = 0.0, centre: npt.ArrayLike = (0.0, 0.0, 0.0),
         inertia: npt.ArrayLike = ((0.0, 0.0, 0.0),) * 3, figures: Figures = "robot") -> Array:
    """The mass matrix M(q), of links and load, without rotors.

    Parameters
    ----------
    q : array_like, shape (7,) or (n, 7)
        Joint positions, rad.
    mass, centre, inertia, figures
        As for `gravity`.

    Returns
    -------
    ndarray, shape (7, 7) or (n, 7, 7)
        kg m^2.
    """
    q = _array("q", q, (7,))
    out = np.empty((*q.shape, 7))
    _core.model_mass(_rows(q), _load(mass, centre, inertia), _of_plant(figures), out.reshape(-1, 49))
    return out


def jacobian(q: npt.ArrayLike, frame: Frame = "EE", *, F_T_EE: npt.ArrayLike | None = None,
             axes: Literal["base", "body"] = "base") -> Array:
    """The Jacobian of a frame's origin, J dq = [v; w].

    Parameters
    ----------
    q : array_like, shape (7,) or (n, 7)
        Joint positions, rad.
    frame : str
        Frame.
    F_T_EE : array_like, shape (4, 4), optional
        End effector in the flange, for frame "EE". Default: `F_T_HAND`.
    axes : {"base", "body"}
        Axes of the twist: the base's (zero Jacobian) or the frame's own (body Jacobian).

    Returns
    -------
    ndarray, shape (6, 7) or (n, 6, 7)
        Rows vx, vy, vz, wx, wy, wz.
    """
    if axes not in ("base", "body"):
        raise ValueError(f'axes: "{axes}" is neither base nor body')
    q = _array("q", q, (7,))
    out = np.empty((*q.shape[:-1], 6, 7))
    _core.model_jacobian(_rows(q), frame, _columns(F_T_EE), axes == "body", out.reshape(-1, 42))
    return out


def fk(q: npt.ArrayLike, frame: Frame = "EE", *, F_T_EE: npt.ArrayLike | None = None) -> Array:
    """The pose of a frame in the base.

    Parameters
    ----------
    q : array_like, shape (7,) or (n, 7)
        Joint positions, rad.
    frame : str
        Frame.
    F_T_EE : array_like, shape (4, 4), optional
        End effector in the flange, for frame "EE". Default: `F_T_HAND`.

    Returns
    -------
    ndarray, shape (4, 4) or (n, 4, 4)
        Homogeneous matrices, m.
    """
    q = _array("q", q, (7,))
    out = np.empty((*q.shape[:-1], 4, 4))
    _core.model_fk(_rows(q), frame, _columns(F_T_EE), out.reshape(-1, 16))
    return out


def ik(O_T_EE: npt.ArrayLike, q7: npt.ArrayLike = np.pi / 4, *, F_T_EE: npt.ArrayLike | None = None,
       within_limits: bool = True) -> Array:
    """All joint positions that put the end effector at a pose with a given angle of joint 7, the arm's free parameter.

    In closed form; at most eight for each pose and angle.

    Parameters
    ----------
    O_T_EE : array_like, shape (4, 4) or (n, 4, 4)
        Pose in the base: a rotation and a position, m.
    q7 : float or array_like, shape (n,)
        Angle of joint 7, rad. One pose and many angles give all configurations of that pose.
    F_T_EE : array_like, shape (4, 4), optional
        End effector in the flange. Default: `F_T_HAND`; the identity for poses of the flange.
    within_limits : bool
        Whether solutions beyond `Q_MIN` and `Q_MAX` are left out. With False angles are in (-pi, pi], q6 in (-pi/2, 3 pi/2].

    Returns
    -------
    ndarray, shape (k, 7) or (n, 8, 7)
        rad. Of one pose and one angle the k solutions there are; of many, eight rows each, those after the last solution NaN.
    """
    poses = _array("O_T_EE", O_T_EE, (4, 4))
    angles = np.asarray(q7, float)
    if angles.ndim > 1:
        raise ValueError(f"q7 has shape {angles.shape}; it must be a number or (n,)")
    R = poses[..., :3, :3]
    if not np.allclose(R @ R.swapaxes(-1, -2), np.eye(3), atol=1e-6) or np.any(np.linalg.det(R) < 0):
        raise ValueError("O_T_EE: the upper left 3 x 3 block must be a rotation, right-handed and orthonormal to 1e-6")
    leading = np.broadcast_shapes(poses.shape[:-2], angles.shape)
    columns = np.ascontiguousarray(np.broadcast_to(poses.swapaxes(-1, -2), (*leading, 4, 4))).reshape(-1, 16)
    rows = np.ascontiguousarray(np.broadcast_to(angles, leading)).reshape(-1, 1)
    out = np.empty((*leading, 8, 7))
    low, high = (_panda()["Q_MIN"], _panda()["Q_MAX"]) if within_limits else (np.full(7, -np.inf), np.full(7, np.inf))
    _core.model_ik(columns, rows, _columns(F_T_EE), low.tolist(), high.tolist(), out.reshape(-1, 56))
    return out if leading else out[~np.isnan(out[:, 0])]
