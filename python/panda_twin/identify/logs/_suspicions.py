"""What in a log cannot be a Panda's in the units and order that it says: findings with their cure, by plausible physics."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

from ... import model
from ._recording import Block

Floats = npt.NDArray[np.float64]

_MARGIN = 0.15  # rad beyond the limits, which a real robot's calibration may show
_WINDOW = 0.02  # s over which slopes are taken
_MOVES = 0.01  # rad/s
_ROWS = 300  # at which torques are compared
_SCALE = np.array([5.0, 5, 5, 5, 1, 1, 1])  # Nm that a model of an unloaded arm may miss
_ANGLES = (("degrees", np.pi / 180, "deg"), ("mrad", 1e-3, "mrad"))
_BENT = 0.17  # rad that joint 4 is bent at least, lest small angles pass for those of another unit


def suspicions(block: Block) -> list[str]:
    """Find units, signs and orders of columns that cannot be right.

    Judged by the joint limits, by dq against the slope of q, and by tau_J against the model's torques of the measured motion,
    without a load. A few seconds with motion suffice; what does not move is not judged. These are findings, no refusals.

    Parameters
    ----------
    block : Block
        With q; better with dq, tau_J, q_d too.

    Returns
    -------
    list of str
        A sentence each, the plainest first.
    """
    columns = block.columns
    if "q" not in columns or len(block.t) < 8:
        return []
    q = np.asarray(columns["q"], float)
    found: list[str] = []
    factor = _angles(q, found)
    dq = columns.get("dq")
    if dq is not None:
        _velocities(block.t, factor * q, np.asarray(dq, float), found)
    if "q_d" in columns:
        _desired(factor * q, np.asarray(columns["q_d"], float), found)
    _held(block.t, q, found)
    if "tau_J" in columns:
        _torques(block.t, factor * q, np.asarray(columns["tau_J"], float), found)
    return found


def _inside(q: Floats) -> npt.NDArray[np.bool_]:
    """Whether each joint is within its limits in nearly all rows."""
    inside = (q > model.Q_MIN - _MARGIN) & (q < model.Q_MAX + _MARGIN)
    return np.asarray(inside.mean(axis=0) > 0.99)


def _angles(q: Floats, found: list[str]) -> float:
    """Find another unit of q. Returns the factor to rad."""
    inside = _inside(q)
    if inside.all():
        return 1.0
    joint = int(np.argmin(inside))
    low, high = model.Q_MIN[joint], model.Q_MAX[joint]
    least, most = q[:, joint].min(), q[:, joint].max()
    said = f"joint {joint + 1} is from {least:.4g} to {most:.4g}, beyond its limits of {low:.2f} to {high:.2f} rad"
    for name, factor, unit in _ANGLES:
        if _inside(factor * q).all() and np.abs(factor * q[:, 3]).max() > _BENT:
            found.append(f"q looks like {name}: {said}, and within them as {name}; map it with unit: {unit}")
            return factor
    pairs = [(i, j) for i, j in itertools.combinations(range(7), 2) if _inside(_swapped(q, i, j)).all()]
    cure = (
        f"exchanged columns, such as {pairs[0][0] + 1} and {pairs[0][1] + 1},"
        if pairs
        else "another order of the joints, another unit"
    )
    found.append(f"q is not a Panda's: {said}; look for {cure} or another robot")
    return 1.0


def _swapped(values: Floats, i: int, j: int) -> Floats:
    order = list(range(7))
    order[i], order[j] = j, i
    return values[:, order]


def _slopes(t: Floats, q: Floats, dq: Floats) -> tuple[Floats, Floats]:
    """Slopes of q over a window, and the means of dq over the same."""
    step = max(1, int(round(_WINDOW / float(np.median(np.diff(t))) / 2)))
    if len(t) <= 2 * step:
        return np.zeros((0, 7)), np.zeros((0, 7))
    dt = np.diff(t)[:, None]
    way = np.concatenate([np.zeros((1, 7)), np.cumsum(0.5 * dt * (dq[1:] + dq[:-1]), axis=0)])
    span = (t[2 * step :] - t[: -2 * step])[:, None]
    return (q[2 * step :] - q[: -2 * step]) / span, (way[2 * step :] - way[: -2 * step]) / span


def _velocities(t: Floats, q: Floats, dq: Floats, found: list[str]) -> None:
    slope, mean = _slopes(t, q, dq)
    if not len(slope):
        return
    size = np.sqrt((slope**2).mean(axis=0))
    moving = [joint for joint in range(7) if size[joint] > _MOVES]
    if not moving:
        return
    if not dq.any():
        found.append(f"dq is zero throughout while q of joint {moving[0] + 1} moves; leave dq out of the mapping")
        return
    product = mean.T @ slope
    cosine = product / np.maximum(np.outer(np.linalg.norm(mean, axis=0), np.linalg.norm(slope, axis=0)), 1e-12)
    wrong = [joint for joint in moving if abs(cosine[joint, joint]) < 0.9]
    apart = 1 - cosine
    for i, j in itertools.combinations([joint for joint in moving if apart[joint, joint] > 0.01], 2):
        if apart[i, j] < min(0.05, 0.2 * apart[i, i]) and apart[j, i] < min(0.05, 0.2 * apart[j, j]):
            found.append(
                f"columns of joint {i + 1} and {j + 1} look swapped: dq of {i + 1} is the slope of q of {j + 1}, and the other "
                f"way round; exchange them in q or in dq"
            )
            wrong = [joint for joint in wrong if joint not in (i, j)]
    good = [joint for joint in moving if abs(cosine[joint, joint]) >= 0.9]
    ratio = {joint: product[joint, joint] / (slope[:, joint] @ slope[:, joint]) for joint in good}
    if ratio:
        _ratio(float(np.median(list(ratio.values()))), ratio, found)
    for joint in wrong:
        found.append(
            f"dq of joint {joint + 1} is not the slope of its q (cosine {cosine[joint, joint]:.2f}); look for another order of "
            f"columns, or rows of another time"
        )


def _ratio(middle: float, ratio: dict[int, float], found: list[str]) -> None:
    """What the ratio of dq to the slope of q says of units and signs."""
    if 50 < middle < 65:
        found.append(f"dq looks like deg/s: it is {middle:.1f} times the slope of q; map it with unit: deg/s")
    elif 1 / 65 < middle < 1 / 50:
        found.append(f"q looks like degrees: its slope is {1 / middle:.1f} times dq; map it with unit: deg")
    elif any(0.9 < middle / factor < 1.1 for factor in (1e-6, 1e-3, 1e3, 1e6)):
        found.append(
            f"time, q or dq has another unit: dq is {middle:.3g} times the slope of q, such as for ms read as s, or mrad/s "
            f"read as rad/s; name the units in the mapping"
        )
    elif middle < -0.9:
        found.append("dq has the opposite sign of the slope of q; one of the two is of another convention")
    elif not 0.9 < middle < 1.1:
        found.append(
            f"dq is {middle:.3g} times the slope of q, so that the times are not those of the rows (as of rows that were taken "
            f"for 1 kHz), or a unit is wrong"
        )
    else:
        for joint, one in ratio.items():
            if one < -0.9:
                found.append(f"dq of joint {joint + 1} has the opposite sign of the slope of its q")


def _desired(q: Floats, q_d: Floats, found: list[str]) -> None:
    """Find another unit or order of q_d. Under torque commands it may stand still, far from q."""
    there = np.flatnonzero(np.isfinite(q_d).all(axis=1))[:: max(1, len(q) // 2000)]
    if not len(there):
        return
    q, q_d = q[there], q_d[there]

    def apart(desired: Floats) -> float:
        return float(np.sqrt(((desired - q) ** 2).mean()))

    now = apart(q_d)
    if now < 0.3:
        return
    if apart(q_d * np.pi / 180) < 0.1 * now:
        found.append("q_d looks like degrees: as degrees it follows q; map it with unit: deg")
    for i, j in itertools.combinations(range(7), 2):
        if apart(_swapped(q_d, i, j)) < 0.1 * now:
            found.append(
                f"columns of joint {i + 1} and {j + 1} look swapped in q_d: exchanged, it follows q; exchange them in the mapping"
            )


def _held(t: Floats, q: Floats, found: list[str]) -> None:
    """Rows that repeat the state of the row before while the arm moves."""
    same = (np.diff(q, axis=0) == 0).all(axis=1)
    span = np.ptp(q, axis=0).max()
    if span > 0.05 and 0.3 < same.mean() < 1:
        rows = 1 / (1 - same.mean())
        found.append(
            f"q changes only once in {rows:.1f} rows: the log was written faster than the state was read, so that the true "
            f"rate is about {rows * float(np.median(np.diff(t))) * 1e3:.1f} ms"
        )


def _expected(q: Floats, dq: Floats, ddq: Floats) -> Floats:
    """Torques of a motion without load and friction, Nm."""
    inertial = np.einsum("nij,nj->ni", model.mass(q), ddq)
    return np.asarray(model.gravity(q) + model.coriolis(q, dq) + inertial, float)


def _torques(t: Floats, q: Floats, tau: Floats, found: list[str]) -> None:
    if not tau.any():
        found.append("tau_J is zero throughout; leave it out of the mapping")
        return
    for joint in np.flatnonzero(np.ptp(tau, axis=0) == 0):
        found.append(f"tau_J of joint {joint + 1} does not change at all: a sensor that is dead, or another column")
    step = max(1, int(round(5 * _WINDOW / float(np.median(np.diff(t))) / 2)))
    if len(t) <= 2 * step:
        return
    rows = np.linspace(step, len(t) - 1 - step, min(_ROWS, len(t) - 2 * step)).astype(int)
    span = 0.5 * (t[rows + step] - t[rows - step])[:, None]
    dq, ddq = (q[rows + step] - q[rows - step]) / (2 * span), (q[rows + step] - 2 * q[rows] + q[rows - step]) / span**2
    q, tau = q[rows], tau[rows]
    expected = _expected(q, dq, ddq)
    power = float((expected**2).sum())
    if power / len(rows) < 25.0:  # less than 5 Nm rms: the arm stands straight
        return
    share = float((tau * expected).sum()) / power
    for low, high, said in ((600, 1600, "tau_J looks like mNm: it is {:.0f} times the torque that holds the arm; map it "
                                        "with unit: mNm"),
                            (0.0006, 0.0016, "tau_J looks like kNm: it is {:.2g} times the torque that holds the arm"),
                            (-1.6, -0.6, "tau_J has the opposite sign: it is {:.2f} times the torque that holds the "
                                         "arm; negate it"),
                            (-0.2, 0.2, "tau_J has no gravity in it: it is {:.2f} times the torque that holds the arm; it may "
                                        "be tau_J_d, or another column")):  # fmt: skip
        if low < share < high:
            if not _exchanged(q, dq, ddq, tau, expected, found):
                found.append(said.format(share))
            return
    if not _exchanged(q, dq, ddq, tau, expected, found) and (rest := float(((tau - expected) ** 2).sum())) > 0.5 * power:
        found.append(
            f"tau_J is {np.sqrt(rest / len(rows)):.0f} Nm (rms) from what holds a Panda of {np.sqrt(power / len(rows)):.0f} "
            f"Nm: another robot, another direction of gravity, or a heavy load"
        )


def _exchanged(q: Floats, dq: Floats, ddq: Floats, tau: Floats, expected: Floats, found: list[str]) -> bool:
    """Find two joints whose columns are exchanged in tau_J, in q, or in both: then the torques fit the model much better."""

    def misfit(torque: Floats, model_torque: Floats) -> float:
        return float((((torque - model_torque) / _SCALE) ** 2).mean())

    now = misfit(tau, expected)
    if now < 0.02:
        return False
    best = (min(0.3 * now, 1.0), "")
    for i, j in itertools.combinations(range(7), 2):
        names = f"columns of joint {i + 1} and {j + 1} look swapped in"
        turned = tuple(_swapped(values, i, j) for values in (q, dq, ddq))
        of_turned = _expected(*turned) if _inside(turned[0]).all() else None
        options = [
            (
                misfit(_swapped(tau, i, j), expected),
                f"{names} tau_J: exchanged, they fit the torques of the measured motion; exchange them in the mapping",
            )
        ]
        if of_turned is not None:
            options.append(
                (
                    misfit(tau, of_turned),
                    f"{names} q: exchanged, tau_J is the torque of the measured motion; exchange them in the mapping",
                )
            )
            options.append(
                (
                    misfit(_swapped(tau, i, j), of_turned),
                    f"{names} q and tau_J: exchanged, both fit a Panda; exchange them in the mapping",
                )
            )
        best = min(best, *options, key=lambda one: one[0])
    if best[1]:
        found.append(best[1])
    return bool(best[1])
