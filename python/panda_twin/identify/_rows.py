"""What a regression of joint torques sees: filtered torques and regressors, a row every 40 ms."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.interpolate import Akima1DInterpolator, CubicSpline  # type: ignore[import-untyped]
from scipy.signal import butter, firwin, sosfiltfilt  # type: ignore[import-untyped]
from scipy.sparse import csr_array  # type: ignore[import-untyped]

from .. import _core

if TYPE_CHECKING:
    from ._model import TwinModel
    from .logs._recording import Block, Recording

Array: TypeAlias = npt.NDArray[np.float64]

TICK = 1e-3
"""Period of the robot's controller, s."""
ROW = 40
"""Ticks between two rows."""
_CUTOFF = 8.0  # Hz, of the filter that torques and regressors pass alike
_HALF = 120  # ticks: half of the filter
_SHIFTS = np.arange(-6, 27, 2)  # ticks by which torques are looked up earlier or later: delays from -4 to 24 ms are between
_EDGE = 300  # ticks at both ends of a stretch that are there for the fusion of q and dq alone
_MARGIN = _EDGE + _HALF + int(_SHIFTS[-1]) + 2
_FUSED = (2.0, 20.0)  # Hz: below a frequency in this range the slope of q counts, above it dq
_GAP = 0.012  # s: a longer gap is not bridged
_BLOCK = 10.0  # s
_SHAKEN = 3
MOST = 120.0
"""Of a longer log, as many seconds are looked at, in blocks spread over all of it."""
_TAPS: Array = firwin(2 * _HALF + 1, _CUTOFF, fs=1 / TICK)

BODIES = 8
"""Bodies of a regressor: seven links, and what is on the flange; ten parameters each, as `_core.model_regressor` has them."""


@dataclasses.dataclass(frozen=True)
class Motion:
    """Signals of one stretch on a grid of 1 ms, without gaps longer than 12 ms where `is_whole`."""

    t: Array
    is_whole: npt.NDArray[np.bool_]
    q: Array
    dq: Array
    ddq: Array
    others: dict[str, Array]
    """Further columns, on the same grid."""
    measured_dq: Array | None = None
    """dq as the log has it."""

    def shaken(self, random: np.random.Generator) -> Motion:
        """Return the motion with the sensors' noise once more: what differs is what noise alone makes of it."""
        def again(values: Array) -> Array:
            return values + noise_of(values) * random.standard_normal(values.shape)

        q = again(self.q)
        measured = None if self.measured_dq is None else again(self.measured_dq)
        dq = _velocity(q, measured)
        others = {name: again(values) if values.ndim == 2 else values for name, values in self.others.items()}
        return Motion(self.t, self.is_whole, q, dq, _acceleration(dq), others, measured)

    def places(self) -> npt.NDArray[np.intp]:
        """Ticks at which a row can be made: those whose filter meets no gap."""
        first = int(np.ceil(round(self.t[0] / TICK) / ROW)) * ROW - round(self.t[0] / TICK)
        places = np.arange(first, len(self.t), ROW)
        places = places[(places >= _MARGIN) & (places < len(self.t) - _MARGIN)]
        holes = np.concatenate([[0], np.cumsum(~self.is_whole)])
        return np.asarray(places[holes[places + _MARGIN] == holes[places - _MARGIN]])


def _low_pass(ticks: int, places: npt.NDArray[np.intp], shift: int = 0) -> csr_array:
    """The filter as a matrix (places, ticks), `shift` ticks later than the places."""
    columns = (places + shift)[:, None] + np.arange(-_HALF, _HALF + 1)
    ends = np.arange(len(places) + 1) * len(_TAPS)
    return csr_array((np.tile(_TAPS, len(places)), columns.ravel(), ends), shape=(len(places), ticks))


def _filtered(values: Array, low_pass: csr_array) -> Array:
    """Rows (m, ...) of a stretch after the filter, (places, ...)."""
    return np.asarray(low_pass @ values.reshape(len(values), -1)).reshape(low_pass.shape[0], *values.shape[1:])


def regressor(q: Array, dq: Array, ddq: Array, g_earth: Iterable[float]) -> Array:
    """Y of M ddq + c + g = Y parameters, (n, 7, 80)."""
    Y = np.empty((len(q), 7, 10 * BODIES))
    gravity = [float(x) for x in g_earth]
    _core.model_regressor(np.ascontiguousarray(q), np.ascontiguousarray(dq), np.ascontiguousarray(ddq), gravity, Y.reshape(len(q), -1))
    return Y


def noise_of(values: Array) -> float:
    """Standard deviation of white noise, by what does not follow from the neighbours: robust, the median of the columns."""
    fourth = np.diff(values, 4, axis=0)
    return float(np.median(1.4826 * np.median(np.abs(fourth), axis=0)) / np.sqrt(70))


def _velocity(q: Array, dq: Array | None) -> Array:
    """Joint velocities: dq above the frequency at which its noise equals that of the slope of q, that slope below it."""
    slope: Array = np.diff(q, axis=0, prepend=q[:1]) / TICK
    slope[0] = slope[1] if len(slope) > 1 else 0
    if len(q) < 100:
        return slope if dq is None else dq
    if dq is None:
        return np.asarray(sosfiltfilt(butter(2, _FUSED[1], fs=1 / TICK, output="sos"), slope, axis=0))
    equal = noise_of(dq) / max(2 * np.pi * noise_of(q), 1e-12)
    if equal < _FUSED[0]:
        return dq
    low = butter(2, min(equal, _FUSED[1]), fs=1 / TICK, output="sos")
    return np.asarray(dq + sosfiltfilt(low, slope - dq, axis=0))


def _acceleration(dq: Array) -> Array:
    """What leads from one tick to the next belongs to the earlier tick's q and dq: plant and robot alike sample after it."""
    return np.asarray(np.diff(dq, axis=0, append=dq[-1:]) / TICK)


def motion_of(block: Block, by_id: bool) -> Motion:
    """Bring a block of a log onto a grid of 1 ms.

    Rows by the robot's message id fall onto it exactly. Stamps are taken as they are, at any rate: the signals are interpolated
    between them. Without `dq`, it is the slope of `q`.
    """
    stamps = block.t
    first, last = int(np.ceil(stamps[0] / TICK - 1e-6)), int(np.floor(stamps[-1] / TICK + 1e-6))
    t = np.asarray(np.arange(first, last + 1) * TICK, float)
    names = [name for name in block.columns if name not in ("q", "dq")]
    period = float(np.median(np.diff(stamps))) if len(stamps) > 1 else TICK
    if by_id and len(t) == len(stamps):
        def on_grid(values: Array) -> Array:
            return values
    elif period < 2 * TICK:
        def on_grid(values: Array) -> Array:
            return np.stack([np.interp(t, stamps, column) for column in values.T], axis=1)
    else:
        def on_grid(values: Array) -> Array:
            return np.asarray(Akima1DInterpolator(stamps, values)(t))
    q: Array = on_grid(block.columns["q"])
    after = np.clip(np.searchsorted(stamps, t, side="left"), 1, len(stamps) - 1)
    gap = stamps[after] - stamps[after - 1]
    exact = np.abs(stamps[np.clip(np.searchsorted(stamps, t - 1e-9), 0, len(stamps) - 1)] - t) < 1e-6
    is_whole = (gap <= max(_GAP, 4 * period)) | exact
    measured = on_grid(block.columns["dq"]) if "dq" in block.columns else None
    dq = _velocity(q, measured)
    return Motion(t, is_whole, q, dq, _acceleration(dq), {name: on_grid(block.columns[name]) for name in names}, measured)


@dataclasses.dataclass(frozen=True)
class Rows:
    """Rows of all blocks. Torques are those of the sensor, tau_J; `Y` times the parameters of all bodies is what links need."""

    t: Array
    """(n,), s."""
    block: npt.NDArray[np.int64]
    """(n,): which block a row is from."""
    q: Array
    dq: Array
    ddq: Array
    """(n, 7) each, filtered."""
    Y: npt.NDArray[np.float64]
    """(n, 7, 80)."""
    tilt: Array
    """(n, 7, 2): change of the model's torque per rad of roll and of pitch of the base."""
    beside: dict[str, Array]
    """(n, 7) each, filtered, at the instant of tau_J: theta and q of the sensors, tau_J_d with the gravity that INT adds."""
    tau_at: CubicSpline
    """tau_at(delay) is (n, 7): torques measured a delay (s) after each row, filtered."""
    _fast: tuple[tuple[Array, csr_array], ...]  # of each block: dq at 1 kHz, the filter
    noise: tuple[Rows, Rows] | None = None
    """Some of the rows, and the same ones of the shaken motion."""

    def __len__(self) -> int:
        return len(self.t)

    def of_velocity(self, law: Callable[[Array], Array]) -> Array:
        """A function of joint velocities (m, 7) -> (m, ...) after the filter: (n, ...)."""
        return np.concatenate([_filtered(law(dq), low_pass) for dq, low_pass in self._fast])


def motions_of(recording: Recording, *names: str) -> Iterator[Motion]:
    """Stretches of a log on the grid; of a log longer than `MOST` seconds, some that are spread over it."""
    stride = max(1, int(np.ceil(recording.seconds / MOST)))
    wanted = [name for name in ("q", "dq", *names) if name in recording.columns]
    for number, block in enumerate(recording.blocks(*wanted, seconds=_BLOCK, overlap=2 * (_MARGIN + ROW) * TICK)):
        if number % stride == 0 and len(block.t) > 2 * _MARGIN:
            yield motion_of(block, recording.by_id)


def _beside(motion: Motion, low_pass: csr_array, later: csr_array, twin: TwinModel) -> dict[str, Array]:
    found = {"q": _filtered(motion.q, later)}
    if "theta" in motion.others:
        found["theta"] = _filtered(motion.others["theta"], later)
    if "tau_J_d" in motion.others:
        found["tau_J_d"] = _filtered(motion.others["tau_J_d"], later) + _filtered(twin.compensation(motion.q), low_pass)
    return found


def rows_of(motions: Iterable[Motion], twin: TwinModel, name: str = "the log") -> Rows:
    """Make the rows of motions that have the column tau_J.

    Raises
    ------
    ValueError
        Without 0.9 s in a row.
    """
    g = twin.g_earth.tolist()
    parts: list[dict[str, Any]] = []
    fast: list[tuple[Array, csr_array]] = []
    beside: list[dict[str, Array]] = []
    done = -np.inf
    for motion in motions:
        places = motion.places()
        places = places[motion.t[places] > done + 1e-9]
        if len(places) == 0:
            continue
        done = motion.t[places[-1]]
        Y = regressor(motion.q, motion.dq, motion.ddq, g)
        still = np.zeros_like(motion.q)
        tilt = np.stack([regressor(motion.q, still, still, g_i) @ twin.parameters for g_i in twin.tilted()], axis=2)
        tau = motion.others["tau_J"]
        # The sensors' values of a tick belong to the acceleration that led to it: one tick after its q and dq.
        filters = [_low_pass(len(tau), places, int(shift) + 1) for shift in _SHIFTS]
        shifted = np.stack([_filtered(tau, one) for one in filters], axis=2)
        low_pass = _low_pass(len(tau), places)
        parts.append({"t": motion.t[places], "block": np.full(len(places), len(parts)), "Y": _filtered(Y, low_pass), "tau": shifted, "tilt": _filtered(tilt, low_pass)}
                     | {name: _filtered(getattr(motion, name), low_pass) for name in ("q", "dq", "ddq")})
        beside.append(_beside(motion, low_pass, _low_pass(len(tau), places, 1), twin))
        fast.append((motion.dq, low_pass))
    if not parts:
        raise ValueError(f"{name}: no 0.9 s in a row without a gap longer than 12 ms; nothing can be compared")
    whole: dict[str, Any] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    tau_at = CubicSpline(_SHIFTS * TICK, whole.pop("tau"), axis=2)
    others = {name: np.concatenate([part[name] for part in beside]) for name in beside[0]}
    return Rows(**whole, beside=others, tau_at=tau_at, _fast=tuple(fast))


def joined(parts: Sequence[Rows]) -> Rows:
    """Rows of several logs of one robot, one after the other."""
    if len(parts) == 1:
        return parts[0]
    blocks, ends = [], 0
    for part in parts:
        blocks.append(part.block + ends)
        ends += int(part.block.max()) + 1
    whole: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ("t", "q", "dq", "ddq", "Y", "tilt")}
    names = set.intersection(*(set(part.beside) for part in parts))
    beside = {name: np.concatenate([part.beside[name] for part in parts]) for name in names}
    delays = parts[0].tau_at.x
    tau_at = CubicSpline(delays, np.concatenate([np.stack([part.tau_at(x) for x in delays], axis=2) for part in parts]), axis=2)
    return Rows(**whole, block=np.concatenate(blocks), beside=beside, tau_at=tau_at, _fast=sum((part._fast for part in parts), ()))


def with_noise(rows: Rows, motions: Sequence[Motion], twin: TwinModel) -> Rows:
    """Rows that know what the sensors' noise makes of them, from one stretch in `_SHAKEN`."""
    random = np.random.default_rng(1)
    chosen = [motion for motion in motions[::_SHAKEN] if len(motion.places())]
    if not chosen:
        return rows
    return dataclasses.replace(rows, noise=(rows_of(chosen, twin), rows_of([motion.shaken(random) for motion in chosen], twin)))
