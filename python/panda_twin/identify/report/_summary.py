"""What a comparison found in words and numbers, for the page, the terminal and programs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._demand import TORQUE_LIMITS, judge
from .._regression import QUANTILE
from .._result import rms

if TYPE_CHECKING:
    from .._demand import Item
    from .._regression import Estimate
    from .._result import Closed, Comparison, LogFacts

Array: TypeAlias = npt.NDArray[np.float64]


def headline(comparison: Comparison) -> str:
    """The verdict in one sentence, without its full stop."""
    count = len(comparison.items)
    bad = sum(item.is_met is False for item in comparison.items)
    if not count:
        return "Nothing is demanded of the twin"
    if bad:
        return f"The twin is not the robot: {bad} of {count} demands {'is' if bad == 1 else 'are'} not met"
    if comparison.passed:
        return "The twin is the robot, as demanded"
    return f"The data cannot tell whether the twin is the robot: none of {count} demands can be judged"


def in_detail(comparison: Comparison) -> str:
    """What the verdict rests on, and what becomes of it by identification."""
    items = comparison.items
    untold = sum(item.is_met is None for item in items)
    told = [f"{sum(item.is_met is True for item in items)} of {len(items)} demands are met"]
    if untold:
        told.append(f"{untold} cannot be judged with {'this log' if len(comparison.logs) == 1 else 'these logs'}")
    text = ", ".join(told) + "." if items else ""
    after = judged_after(comparison)
    if after:
        bad = sum(item.is_met is False for item in after)
        text += f" Of the {len(after)} that can be judged again, the identified twin misses {bad or 'none'}."
    return text.strip()


def values_before(comparison: Comparison) -> dict[str, Array]:
    """What was found with the twin as it is, by kind of demand, SI."""
    found = {}
    if comparison.open is not None and len(comparison.open.before):
        found["torque"] = rms(comparison.open.before)
        found["torque_share"] = found["torque"] / TORQUE_LIMITS
    if comparison.closed is not None:
        found["position"] = comparison.closed.position_rms
    if comparison.external is not None:
        found["external_torque"] = comparison.external.torque_rms
    return {**found, **comparison.found}


def values_after(comparison: Comparison) -> dict[str, Array]:
    """The same with the identified twin, as far as it was compared."""
    found = {}
    if comparison.open is not None and comparison.open.after is not None and len(comparison.open.after):
        found["torque"] = rms(comparison.open.after)
        found["torque_share"] = found["torque"] / TORQUE_LIMITS
    if comparison.closed_after is not None:
        found["position"] = comparison.closed_after.position_rms
    return found


def judged_after(comparison: Comparison) -> list[Item]:
    """The demands that can be judged with the identified twin."""
    after = values_after(comparison)
    demand: dict[str, list[float]] = {}
    for item in comparison.items:
        if item.kind in after:
            demand.setdefault(item.kind, []).append(item.demanded)
    return [item for item in judge({kind: np.array(most) for kind, most in demand.items()}, after) if item.is_met is not None]


def group_of(estimate: Estimate, key: str) -> str:
    """To which table of the page an estimate belongs."""
    if key.startswith("plant.friction"):
        of_motor = any(p.key.startswith("plant.armature") for p in estimate.parameters)
        return "motor friction" if of_motor else "friction"
    for begin, group in (
        ("load.", "load"),
        ("plant.delay", "delay"),
        ("plant.elasticity", "elasticity"),
        ("theta.", "elasticity"),
        ("plant.armature", "armature"),
        ("base[", "inertia"),
    ):
        if key.startswith(begin):
            return group
    return "other"


def plain(value: Any) -> Any:
    """What JSON can write: arrays as lists, what is not finite as None."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int)) else str(value)


def summary(comparison: Comparison) -> dict[str, Any]:
    """The numbers of a comparison, SI but for times of logs, which are in ms; joints from 1; what is not told is None.

    Of a residual it is each joint's root of the mean square, Nm; `sd` of an estimate is its standard deviation, `interval`
    its 95 % interval.
    """
    identified, delay, external = comparison.identified, comparison.command_delay, comparison.external
    return {
        "summary": 1,
        "passed": comparison.passed,
        "verdict": headline(comparison),
        "twin": comparison.scenario.name,
        "items": [_item(item) for item in comparison.items],
        "items_identified": [_item(item) for item in judged_after(comparison)],
        "causes": [{"name": c.name, "words": c.words, "remedy": c.remedy, "share": plain(c.share)} for c in comparison.causes],
        "estimates": [one for estimate in (identified.estimates if identified else []) for one in _estimates(estimate)],
        "residual": _residual(comparison),
        "closed": {"before": _closed(comparison.closed), "after": _closed(comparison.closed_after)},
        "external": external
        and {
            "torque_rms": plain(external.torque_rms),
            "wrench_rms": plain(external.wrench_rms),
            "seconds": plain(external.seconds),
        },
        "torque_delay": plain(identified.delay) if identified else None,
        "command_delay": delay
        and {"cycles": plain(delay.cycles), "share": plain(delay.share), "expected": plain(delay.expected)},
        "untold": untold_of(comparison),
        "logs": [_log(log) for log in comparison.logs],
    }


def untold_of(comparison: Comparison) -> list[str]:
    """What the data cannot tell, each thing once."""
    return list(dict.fromkeys([*comparison.untold, *(comparison.identified.untold if comparison.identified else [])]))


def _item(item: Item) -> dict[str, Any]:
    return {
        "kind": item.kind,
        "joint": None if item.joint is None else item.joint + 1,
        "found": plain(item.found),
        "demanded": plain(item.demanded),
        "met": item.is_met,
        "words": item.words,
    }


def _estimates(estimate: Estimate) -> list[dict[str, Any]]:
    found = []
    for parameter, value, sd, told in zip(estimate.parameters, estimate.values, estimate.sd, estimate.told):
        is_told = bool(told) and math.isfinite(value) and math.isfinite(sd)
        half = QUANTILE * float(sd)
        found.append(
            {
                "key": parameter.key,
                "group": group_of(estimate, parameter.key),
                "text": parameter.text,
                "unit": parameter.unit,
                "value": plain(float(value)) if told else None,
                "sd": plain(float(sd)) if is_told else None,
                "interval": [float(value) - half, float(value) + half] if is_told else None,
            }
        )
    return found


def _residual(comparison: Comparison) -> dict[str, Any]:
    before, after = values_before(comparison).get("torque"), values_after(comparison).get("torque")
    held_out = comparison.identified.held_out if comparison.identified else None
    return {
        "before": plain(before),
        "after": plain(after),
        "held_out_before": plain(held_out and held_out[0]),
        "held_out_after": plain(held_out and held_out[1]),
    }


def _closed(closed: Closed | None) -> dict[str, Any] | None:
    if closed is None:
        return None
    return {
        "position_rms": plain(closed.position_rms),
        "position_largest": plain(closed.position_largest),
        "torque_rms": plain(closed.torque_rms),
        "cycles": closed.cycles,
        "events": plain(closed.events),
        "first_difference": closed.first_difference,
    }


def _log(log: LogFacts) -> dict[str, Any]:
    t = log.timing
    return {
        "name": log.name,
        "kind": log.kind,
        "sha256": log.sha256,
        "rows": log.rows,
        "seconds": plain(log.seconds),
        "missing": [{"column": column, "lost": lost} for column, lost in log.missing],
        "notes": plain(log.notes),
        "suspicions": plain(log.suspicions),
        "timing": {
            "by": t.by,
            "median_ms": plain(t.median),
            "mean_ms": plain(t.mean),
            "sd_ms": plain(t.sd),
            "longest_ms": plain(t.longest),
            "longest_at_s": plain(t.longest_at),
            "lost": t.lost,
            "late": t.late,
            "repeated": t.repeated,
            "sorted": t.sorted,
            "held_runs": {str(k): t.held[k] for k in sorted(t.held)},
        },
    }


def number(value: float | None, digits: int = 3) -> str:
    """A number for people; a dash for none."""
    if value is None or not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < 1e7 else text


def interval(value: float, sd: float) -> str:
    """An estimate with its 95 % interval, to its first digit, or to two where that is a 1 or a 2: "0.546 ± 0.012"."""
    if not math.isfinite(value):
        return "not told"
    half = QUANTILE * sd
    if not math.isfinite(half) or half <= 0:
        return number(value, 4)
    power = math.floor(math.log10(half))
    places = (half < 2.95 * 10.0**power) - power
    if power < -5 or power > 4:
        return f"{value:.4g} ± {half:.1g}"
    places = max(0, places)
    return f"{value:z.{places}f} ± {half:.{places}f}"


def percent(share: float) -> str:
    """A share as a whole percentage."""
    return "<1 %" if 0 < share < 0.005 else f"{100 * share:.0f} %"
