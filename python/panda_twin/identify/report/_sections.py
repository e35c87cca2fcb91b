"""Sections of the page with plots: torques, the replay, estimates of external torques, timing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from . import _plots
from ._html import Cell, Cells, Html, bullets, figure, h2, h3, p, table
from ._summary import number

if TYPE_CHECKING:
    from .._result import Closed, Comparison

_JOINT_HEADS: list[str | Cell] = [f"joint {i + 1}" for i in range(7)]
_PAPER = (
    "To compare: the paper's Table 1 has 0.18 % of unserved cycles with bare libfranka, 5.91 % with a synchronous ROS 2 loop and "
    "0.41 % with an asynchronous one."
)


def torques(comparison: Comparison) -> list[Html]:
    """Torque residuals on the measured motion."""
    parts = [h2("Torques on the measured motion")]
    found = comparison.open
    if found is None:
        return [*parts, p("The torques were not compared: the logs do not hold what that needs (positions and joint torques).")]
    if len(found.t) < 2 or not np.any(np.isfinite(found.before)):
        return [*parts, p("The logs hold too little motion to show anything of the torques.")]
    parts.append(
        p(
            "Measured torque less the twin's inverse dynamics on the measured motion, after a low-pass of 8 Hz."
            + ("" if found.after is not None else " Nothing was identified, so there is one curve.")
        )
    )
    parts.append(
        figure(
            _plots.against_velocity(found),
            "Residual against velocity, Nm over rad/s. A step at zero is Coulomb friction, a slope viscous friction, "
            "a shift an offset of the sensor. Lines are means.",
        )
    )
    parts.append(
        figure(
            _plots.against_position(found),
            "Residual against position, Nm over rad. What varies with the position is gravity: masses, the load, a tilted base.",
        )
    )
    parts.append(figure(_plots.over_time(found), "Residual over time. Each curve shows the extremes of every part of the time."))
    spectrum = _plots.spectrum(found)
    parts.append(
        figure(
            spectrum,
            "Spectrum of the residual (Welch). Where it is high at the frequencies of the motion, the model is wrong; the rest is noise, up to 8 Hz, where the low-pass ends it.",
        )
        if spectrum
        else p("No part of the log without a gap is long enough for a spectrum.")
    )
    return parts


def closed(comparison: Comparison) -> list[Html]:
    """Robot and twin under the same commands, with events."""
    parts = [h2("Robot and twin under the same commands")]
    replayed, after = comparison.closed, comparison.closed_after
    if replayed is None:
        return [*parts, p("The logs were not replayed: they hold no commands that the twin could be given.")]
    rows = [
        row
        for name, one in (("twin as given", replayed), ("twin identified", after))
        if one is not None
        for row in _closed_rows(name, one)
    ]
    same = (
        "Every cycle is equal to the last bit."
        if replayed.first_difference is None
        else f"The first cycle that differs in any bit is number {replayed.first_difference}."
    )
    parts += [
        p(f"{replayed.cycles} cycles were replayed through the twin's robot control and plant. {same}"),
        table([["", *_JOINT_HEADS]], rows),
    ]
    if len(replayed.t) > 1 and np.any(np.isfinite(replayed.position)):
        parts.append(
            figure(
                _plots.closed_over_time(replayed, after),
                "Position of the robot less that of the twin, mrad over s. The grey curve is the same of q_d: it is the part of "
                "the link and the controller, the rest is the body's.",
            )
        )
    else:
        parts.append(p("The replay is too short to be drawn."))
    parts.append(h3("Events"))
    parts.append(bullets(replayed.events) if replayed.events else p("Neither the robot nor the twin reported an error."))
    if after is not None and after.events != replayed.events:
        parts += [p("With the identified twin:"), bullets(after.events) if after.events else p("No errors.")]
    return parts


def _closed_rows(name: str, closed: Closed) -> list[Cells]:
    return [
        [f"{name}: position, mrad (root of the mean square)", *(number(1e3 * x) for x in closed.position_rms)],
        [f"{name}: position, mrad (largest)", *(number(1e3 * x) for x in closed.position_largest)],
        [f"{name}: tau_J, Nm (root of the mean square)", *map(number, closed.torque_rms)],
    ]


def external(comparison: Comparison) -> list[Html]:
    """INT's estimates, the robot's beside the twin's."""
    parts = [h2("Estimates of external torque and wrench")]
    estimates = comparison.external
    if estimates is None:
        return [*parts, p("The robot's own estimates were not compared: the logs do not hold them.")]
    parts += [
        p(
            "The robot's estimates less the twin's, both from the robot's torques, over "
            f"{number(estimates.seconds)} s; root of the mean square."
        ),
        table([["", *_JOINT_HEADS]], [["tau_ext_hat_filtered, Nm", *map(number, estimates.torque_rms)]]),
    ]
    if estimates.wrench_rms is None:
        return [*parts, p("The logs hold no wrench.")]
    wrench: list[str | Cell] = ["Fx, N", "Fy, N", "Fz, N", "Mx, Nm", "My, Nm", "Mz, Nm"]
    return [*parts, table([["in the base's axes", *wrench]], [["O_F_ext_hat_K", *map(number, estimates.wrench_rms)]])]


def timing(comparison: Comparison) -> list[Html]:
    """Times of the logs, and the delay of commands."""
    parts = [h2("Timing")]
    if not comparison.logs:
        return [*parts, p("No log, no times.")]
    rows: list[Cells] = []
    for i, log in enumerate(comparison.logs):
        t = log.timing
        held = sum(length * count for length, count in t.held.items())
        rows.append(
            [
                f"log {i + 1}",
                Cell("the robot's message_id" if t.by == "message_id" else "stamps", "word"),
                number(t.median, 4),
                number(t.mean, 4),
                number(t.sd),
                number(t.longest, 4),
                number(t.longest_at, 4),
                str(t.lost),
                str(t.late),
                str(t.repeated),
                number(100 * held / log.rows) if t.held and log.rows else "–",
            ]
        )
    heads: Cells = [
        "",
        Cell("times by", "word"),
        "median, ms",
        "mean, ms",
        "sd, ms",
        "longest, ms",
        "at, s",
        "lost",
        "late",
        "repeated",
        "held, %",
    ]
    parts += [
        table([heads], rows),
        p(
            "Lost: cycles that are not in the log. Late: intervals of a quarter of a period too much. "
            "Held: cycles without a command in time.",
            "soft",
        ),
    ]
    unsorted = [f"log {i + 1}" for i, log in enumerate(comparison.logs) if not log.timing.sorted]
    if unsorted:
        parts.append(p(f"Rows were sorted by their stamps: {', '.join(unsorted)}."))
    drawn = _plots.timing([log.timing for log in comparison.logs], comparison.command_delay)
    parts.append(
        figure(
            drawn,
            "As far as the logs tell: cycles from a command to the state that shows it, intervals between rows, how many cycles "
            "in a row had no command in time, and the robot's own success rate.",
        )
        if drawn
        else p("The logs hold too few rows for distributions.")
    )
    if comparison.command_delay is None:
        parts.append(p("The delay of commands cannot be told: the logs do not hold commands beside the states that show them."))
    if any(log.timing.held for log in comparison.logs):
        parts.append(p(_PAPER, "soft"))
    else:
        parts.append(p("No cycle without a command is in the logs, or the logs do not say which those are."))
    return parts
