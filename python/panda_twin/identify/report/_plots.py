"""Plots of a comparison as SVG for the page: vectors take the page's colours, so that they read in light and dark."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter
from scipy.signal import welch  # type: ignore[import-untyped]

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .._result import Closed, CommandDelay, Open
    from ..logs._timing import Timing

Array: TypeAlias = npt.NDArray[np.float64]

# Stand for the page's colours, which differ in light and dark.
_INK, _GRID = "#010203", "#010204"
BEFORE, AFTER, COMMANDED = "#d9822b", "#3f7fca", "#888888"
"""Colours that read on white and on black, and differ for colour-blind readers."""
_SERIES = ("#3f7fca", "#d9822b", "#2a9c87", "#c0475b", "#8a5ac0", "#888888")

_STYLE: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "panda_twin",
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "text.parse_math": False,
    "text.color": _INK,
    "axes.edgecolor": _INK,
    "axes.labelcolor": _INK,
    "axes.titlesize": 8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.facecolor": "none",
    "axes.formatter.limits": (-3, 4),
    "axes.xmargin": 0.02,
    "xtick.color": _INK,
    "ytick.color": _INK,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.size": 2,
    "ytick.major.size": 2,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0,
    "grid.color": _GRID,
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "lines.linewidth": 1.0,
    "figure.facecolor": "none",
    "figure.dpi": 72,
    "savefig.dpi": 110,
}
_POINTS = 1200  # of a scatter
_ROWS = 20_000  # that means and percentiles are made of
_BUCKETS = 260  # of a curve over time: each shows its least and largest value
_WIDE = 10.4  # inches


def _svg(figure: Figure, name: str) -> str:
    """The figure as an element of a page; `name` keeps its ids apart from those of other figures."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None}, transparent=True)
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    head = rf'<svg viewBox="\1" xmlns:xlink="http://www.w3.org/1999/xlink" role="img" aria-label="{name}">'
    text = re.sub(r'<svg [^>]*?viewBox="([^"]*)"[^>]*>', head, text, count=1)
    text = re.sub(r"<metadata>.*?</metadata>|<style .*?</style>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'(url\(|href=")#', rf"\1#{name}-", text)
    text = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d\.\d\d)\d+", r"\1", tag[0]), text)
    text = re.sub(r"\s*\n\s*", "\n", text)
    return text.replace(_INK, "var(--ink)").replace(_GRID, "var(--rule)")


def _panels(rows: int, columns: int, height: float) -> tuple[Figure, list[Axes], Axes]:
    """A panel for each joint, and one for the legend."""
    figure = Figure(figsize=(_WIDE, height))
    axes = [figure.add_subplot(rows, columns, 1 + i) for i in range(8)]
    figure.subplots_adjust(left=0.05, right=0.995, top=1 - 0.25 / height, bottom=0.42 / height, wspace=0.22, hspace=0.5)
    axes[7].axis("off")
    for i in range(7):
        axes[i].set_title(f"joint {i + 1}", loc="left", pad=3)
    return figure, axes[:7], axes[7]


def _label(axes: Sequence[Axes], columns: int, x: str, y: str) -> None:
    for i, one in enumerate(axes):
        if i + columns > 6:  # nothing below
            one.set_xlabel(x, labelpad=1)
        if i % columns == 0:
            one.set_ylabel(y, labelpad=2)


def _nothing(axes: Axes) -> None:
    axes.text(0.5, 0.5, "not in the log", ha="center", va="center", transform=axes.transAxes)
    axes.set(xticks=[], yticks=[])


def _key(axes: Axes, entries: Sequence[tuple[str, str]]) -> None:
    lines = [Line2D([], [], color=colour, linewidth=2.5) for _, colour in entries]
    axes.legend(lines, [text for text, _ in entries], loc="center", fontsize=9, labelspacing=1.0)


def _both(before: Array, after: Array | None, what: str) -> list[tuple[Array, str, str]]:
    return [
        (values, text, colour)
        for values, text, colour in ((before, f"{what} as given", BEFORE), (after, f"{what} identified", AFTER))
        if values is not None
    ]


def _thinned(values: Array, most: int) -> Array:
    return values[:: -(-len(values) // most)] if len(values) > most else values


def _means(x: Array, y: Array) -> tuple[Array, Array]:
    """Means of x and y in 24 equal parts of the range of x; parts of fewer than ten rows are left out."""
    least, most = np.percentile(x, [0.2, 99.8])
    edges = np.linspace(least, most, 25)
    order = np.argsort(x, kind="stable")
    parts = np.split(order, np.searchsorted(x[order], edges))[1:-1]
    found = np.array([[np.mean(x[part]), np.mean(y[part])] for part in parts if len(part) >= 10])
    return (found[:, 0], found[:, 1]) if len(found) else (np.zeros(0), np.zeros(0))


def _against(name: str, x: Array, found: Open, label: str) -> str:
    figure, axes, legend = _panels(2, 4, 3.9)
    kept = _both(found.before, found.after, "twin")
    for joint, one in enumerate(axes):
        if not np.any(np.isfinite(found.before[:, joint]) & np.isfinite(x[:, joint])):
            _nothing(one)
            continue
        limits = []
        for values, _, colour in kept:
            told = np.isfinite(values[:, joint]) & np.isfinite(x[:, joint])
            at, y = _thinned(x[told, joint], _ROWS), _thinned(values[told, joint], _ROWS)
            if not len(at):
                continue
            limits.append(np.percentile(y, [0.3, 99.7]))
            one.plot(
                _thinned(at, _POINTS),
                _thinned(y, _POINTS),
                ".",
                color=colour,
                markersize=2.0,
                alpha=0.55,
                markeredgewidth=0,
                rasterized=True,
            )
            one.plot(*_means(at, y), color=colour, linewidth=1.8)
        low, high = np.min(limits), np.max(limits)
        pad = 0.1 * (high - low) or 1e-9
        one.set_ylim(low - pad, high + pad)
    _label(axes, 4, label, "Nm")
    _key(legend, [(text, colour) for _, text, colour in kept])
    return _svg(figure, name)


def against_velocity(found: Open) -> str:
    """Torque residual of each joint against its velocity: points, and means as a line."""
    return _against("velocity", found.dq, found, "rad/s")


def against_position(found: Open) -> str:
    """Torque residual of each joint against its position."""
    return _against("position", found.q, found, "rad")


def _runs(t: Array) -> list[slice]:
    """Parts of a log without a gap."""
    dt = np.diff(t)
    breaks = np.flatnonzero(dt > 1.5 * np.median(dt)) + 1 if len(dt) else np.zeros(0, int)
    edges = [0, *breaks.tolist(), len(t)]
    return [slice(a, b) for a, b in zip(edges[:-1], edges[1:])]


def _envelope(t: Array, y: Array) -> tuple[Array, Array]:
    """A curve of few points that keeps every extreme, broken at gaps of the log."""
    period = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    size = 1 if len(t) <= 2 * _BUCKETS else -(-len(t) // _BUCKETS)
    if size > 1:
        places = []
        for begin in range(0, len(t), size):
            part = y[begin : begin + size]
            if np.any(np.isfinite(part)):
                places += sorted({begin + int(np.nanargmin(part)), begin + int(np.nanargmax(part))})
        t, y = t[places], y[places]
    gaps = np.flatnonzero(np.diff(t) > (2 * size + 1) * period) + 1
    return np.insert(t, gaps, np.nan), np.insert(y, gaps, np.nan)


def _over_time(name: str, t: Array, curves: Sequence[tuple[Array, Array, str, str]], unit: str) -> str:
    figure, axes, legend = _panels(4, 2, 6.2)
    for joint, one in enumerate(axes):
        shown = False
        for at, values, _, colour in curves:
            if np.any(np.isfinite(values[:, joint])):
                one.plot(*_envelope(at, values[:, joint]), color=colour, linewidth=0.8)
                shown = True
        if shown:
            one.set_xlim(t[0], t[-1] if t[-1] > t[0] else t[0] + 1)
        else:
            _nothing(one)
    _label(axes, 2, "s", unit)
    _key(legend, [(text, colour) for _, _, text, colour in curves])
    return _svg(figure, name)


def over_time(found: Open) -> str:
    """Torque residual of each joint over time."""
    return _over_time("time", found.t, [(found.t, *one) for one in _both(found.before, found.after, "twin")], "Nm")


def closed_over_time(before: Closed, after: Closed | None) -> str:
    """Position of the robot less that of the twin over time, mrad."""
    curves = [
        (before.t, 1e3 * before.reference, "reference q_d, twin as given", COMMANDED),
        (before.t, 1e3 * before.position, "twin as given", BEFORE),
    ]
    if after is not None and len(after.t):
        curves.append((after.t, 1e3 * after.position, "twin identified", AFTER))
    return _over_time("closed", before.t, curves, "mrad")


def _density(t: Array, y: Array) -> tuple[Array, Array] | None:
    """Root of the spectral density (Welch) over parts without a gap, Nm/sqrt(Hz); None where they are too short."""
    parts = [y[run] for run in _runs(t)]
    parts = [part for part in parts if len(part) >= 32 and np.all(np.isfinite(part))]
    if not parts:
        return None
    size = min(256, max(len(part) for part in parts))
    parts = [part for part in parts if len(part) >= size]
    rate = 1 / float(np.median(np.diff(t)))
    found = [welch(part, rate, nperseg=size) for part in parts]
    weights = np.array([len(part) for part in parts], float)
    power = np.average([p for _, p in found], axis=0, weights=weights)
    return found[0][0][1:], np.sqrt(power[1:])


def spectrum(found: Open) -> str | None:
    """Spectrum of the torque residual of each joint; None where no part of the log is long enough."""
    figure, axes, legend = _panels(2, 4, 3.9)
    kept = _both(found.before, found.after, "twin")
    drawn = 0
    for joint, one in enumerate(axes):
        lines = [(_density(found.t, values[:, joint]), colour) for values, _, colour in kept]
        told = [(line, colour) for line, colour in lines if line is not None and line[1].max() > 0]
        for line, colour in told:
            one.plot(*line, color=colour)
        if told:
            _logarithmic(one)
        else:
            _nothing(one)
        drawn += len(told)
    if not drawn:
        return None
    _label(axes, 4, "Hz", "Nm/√Hz")
    _key(legend, [(text, colour) for _, text, colour in kept])
    return _svg(figure, "spectrum")


def _delay_panel(axes: Axes, delay: CommandDelay) -> None:
    axes.bar(delay.cycles, 100 * delay.share, width=0.8, color=AFTER)
    axes.axvline(delay.expected, color=_INK, linestyle="--", linewidth=1)
    axes.set_title("command to state; dashed: no delay", loc="left")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="cycles", ylabel="% of the cycles in motion")


def _logarithmic(axes: Axes) -> None:
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 3.0), numticks=6))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_locator(NullLocator())


def _names(logs: Sequence[int], axes: Axes) -> None:
    if len(logs) > 1:
        axes.legend(fontsize=7, loc="best")


def _interval_panel(axes: Axes, timings: Sequence[Timing], logs: list[int]) -> None:
    for place, i in enumerate(logs):
        edges, counts = timings[i].intervals
        axes.stairs(100 * counts / counts.sum(), edges, color=_SERIES[place], label=f"log {i + 1}", linewidth=1.2)
    _logarithmic(axes)
    axes.set_title("interval between rows", loc="left")
    axes.set(xlabel="ms (the last bin: all that are longer)", ylabel="% of the intervals")
    _names(logs, axes)


def _held_panel(axes: Axes, timings: Sequence[Timing], logs: list[int]) -> None:
    width = 0.8 / len(logs)
    for place, i in enumerate(logs):
        cycles = np.array(sorted(timings[i].held))
        axes.bar(
            cycles - 0.4 + (place + 0.5) * width,
            [timings[i].held[k] for k in cycles.tolist()],
            width=width,
            color=_SERIES[place],
            label=f"log {i + 1}",
        )
    _logarithmic(axes)
    axes.set_ylim(bottom=0.5)
    axes.set_title("runs of held cycles", loc="left")
    axes.set(xlabel="held cycles in a row", ylabel="how often")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    _names(logs, axes)


def _success_panel(axes: Axes, timings: Sequence[Timing], logs: list[int]) -> None:
    for place, i in enumerate(logs):
        edges, counts = timings[i].success or (np.zeros(2), np.zeros(1, np.int64))
        least = int(np.flatnonzero(counts)[0]) if counts.any() else 0
        edges, counts = edges[least:], counts[least:]
        axes.stairs(100 * counts / counts.sum(), edges, color=_SERIES[place], label=f"log {i + 1}", linewidth=1.2)
    _logarithmic(axes)
    axes.set_xlim(right=1.006)
    axes.set_title("success rate of commands", loc="left")
    axes.set(xlabel="share of the last 100 cycles", ylabel="% of the rows")
    _names(logs, axes)


def timing(timings: Sequence[Timing], delay: CommandDelay | None) -> str | None:
    """Delay of commands, intervals between rows, runs of held cycles and success rates, as logs tell; None where none does.

    Of many logs the first six are drawn.
    """
    first = range(min(len(timings), len(_SERIES)))
    panels: list[Any] = []
    if delay is not None and len(delay.cycles):
        panels.append(lambda axes: _delay_panel(axes, delay))
    for draw, logs in (
        (_interval_panel, [i for i in first if timings[i].intervals[1].sum() > 0]),
        (_held_panel, [i for i in first if timings[i].held]),
        (_success_panel, [i for i in first if timings[i].success is not None]),
    ):
        if logs:
            panels.append(lambda axes, draw=draw, logs=logs: draw(axes, timings, logs))
    if not panels:
        return None
    figure = Figure(figsize=(_WIDE, 2.5))
    columns = max(3, len(panels))
    for i, draw_panel in enumerate(panels):
        draw_panel(figure.add_subplot(1, columns, 1 + i))
    figure.subplots_adjust(left=0.065, right=0.995, top=0.9, bottom=0.17, wspace=0.36)
    return _svg(figure, "timing")


def style() -> Any:
    """Return the context in which plots are drawn."""
    return matplotlib.rc_context(_STYLE)
