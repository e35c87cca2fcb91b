"""The program's command `excite`: designs a motion, says what its log will tell, and runs it."""

from __future__ import annotations

import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import typing
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ... import _host, model
from ..._command import exit_code_of
from ..._whole_files import write_whole
from ...scenario import Scenario, validate
from .._model import TwinModel, body_of
from .._yaml import read_yaml
from ._clearance import Clearance
from ._excite import Design, bounds_of, design, freed, series_for
from ._expected import Expected, expected_of, rows_of_series, terms_of
from ._series import POSITION_MARGIN

if typing.TYPE_CHECKING:
    from ...scenario_types import Limits

_NOISE = 0.05
_WITHOUT = "an arm with its hand, and nothing beside it but the floor"
_NAMES = ["time", *(f"q{j}" for j in range(1, 8))]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="panda-twin excite", allow_abbrev=False,
                                     description="Design a motion whose log tells of friction, a load or the links.")  # fmt: skip
    parser.add_argument("--for", dest="kind", required=True, help="friction, load or inertia")
    parser.add_argument("--scenario", help=f"the robot and what stands around it (default: {_WITHOUT})")
    parser.add_argument("--limits", type=pathlib.Path, help="lab whose limits the motion keeps (YAML)")
    parser.add_argument("--seconds", type=float, default=40.0, help="of the motion (default: 40)")
    parser.add_argument("--terms", type=int, default=5, help="harmonics of each joint (default: 5)")
    parser.add_argument("--speed", type=float, default=0.5, help="share of the joints' limits of rate (default: 0.5)")
    parser.add_argument("--noise", type=float, default=_NOISE, help="standard deviation of tau_J at 1 kHz, Nm (default: 0.05)")
    parser.add_argument("--seed", type=int, default=1, help="of the search (default: 1)")
    parser.add_argument("--out", type=pathlib.Path, help="folder (default: out/excite_KIND)")
    parser.add_argument("--run", action="store_true", help="run it then; other flags are those of panda-twin run")
    parser.add_argument("--quiet", action="store_true", help="no table")
    return parser


def _limits_of(path: pathlib.Path) -> Mapping[str, Any]:
    section = read_yaml(path)
    if not isinstance(section, dict) or not isinstance(section.get("limits"), dict):
        raise ValueError(f"{path}: it has no section limits; docs/reference/limits.md says what belongs there")
    limits: Mapping[str, Any] = section["limits"]
    return limits


def _lower(one: Any, other: Any) -> Any:
    """The lower of two caps: quantities with one unit, or of each joint."""
    if isinstance(one, dict) and "values" in one or isinstance(other, dict) and "values" in other:
        pair = [x if isinstance(x, dict) else {"unit": x.split()[1], "values": [float(x.split()[0])] * 7} for x in (one, other)]
        return {"unit": pair[0]["unit"], "values": np.minimum(pair[0]["values"], pair[1]["values"]).tolist()}
    return min(one, other, key=lambda text: float(text.split()[0]))


def _merged(own: Mapping[str, Any], lab: Mapping[str, Any]) -> dict[str, Any]:
    """Limits of a scenario and of a lab, both canonical: all regions, the lower of two caps."""
    both: dict[str, Any] = {**own, **lab}
    both["regions"] = [*own.get("regions", []), *lab.get("regions", [])]
    both["speed"] = {**own.get("speed", {}), **lab.get("speed", {})}
    for name in set(own.get("speed", {})) & set(lab.get("speed", {})):
        both["speed"][name] = _lower(own["speed"][name], lab["speed"][name])
    for name in {"force", "torque"} & set(own) & set(lab):
        both[name] = _lower(own[name], lab[name])
    return {name: value for name, value in both.items() if value}


def _start_of(keys: Mapping[str, Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    given = keys["robot"].get("q_start")
    if given is None:
        trajectory = keys.get("motion", {}).get("trajectory")
        return np.array(trajectory["waypoints"][0]["q"] if trajectory else model.Q_READY, float)
    return np.array(given["values"], float)


def robot_of(name: str | None, limits: pathlib.Path | None, kind: str) -> Scenario:
    """The scenario without its motion: where the arm stands, what is around, and both sections of limits.

    Raises
    ------
    ValueError
        For an invalid scenario or lab.
    """
    if name is None:
        start = json.dumps({"q_start": {"unit": "rad", "values": model.Q_READY.tolist()}})
        scenario = Scenario.from_yaml(f"name: excite\nscene: scenes/floor.xml\nrobot: {start}\n", "excite")
    else:
        file = pathlib.Path(name)
        is_file = file.is_file()
        scenario = Scenario.from_yaml(file.read_text(encoding="utf-8"), file) if is_file else Scenario.load(name)
    keys = scenario.to_dict()
    changes: dict[str, Any] = {"name": f"excite_{kind}", "backend": "mujoco",
                               "description": f"Designed by panda-twin excite --for {kind}.",
                               "motion": None, "application": None, "render": {"enabled": False}}  # fmt: skip
    changes["robot"] = {"q_start": {"unit": "rad", "values": _start_of(keys)}}
    folder = scenario._loaded.file.parent
    scene_file = keys.get("scene", "")
    if scene_file and (folder / scene_file).exists():
        changes["scene"] = str((folder / scene_file).resolve())
    scenario = Scenario._of(scenario._loaded.replaced(json.dumps(changes, default=lambda x: x.tolist())))
    if limits is None:
        return scenario
    own = scenario.to_dict().get("limits", {})
    try:
        section = typing.cast("Limits", _limits_of(limits))
        lab = scenario.replace(remove="limits").replace(limits=section).to_dict()["limits"]
    except ValueError as error:
        raise ValueError(f"{limits}: {error}") from None
    return scenario.replace(limits=typing.cast("Limits", _merged(own, lab)))


def require_start(start: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    """Raise ValueError unless the start is where a motion about it has room."""
    panda = model._panda()
    low, high = np.array(panda["Q_MIN"]) + POSITION_MARGIN, np.array(panda["Q_MAX"]) - POSITION_MARGIN
    for joint in range(7):
        if not low[joint] < start[joint] < high[joint]:
            raise ValueError(f"the start has joint {joint + 1} at {start[joint]:.4f} rad; a motion about it needs it between "
                             f"{low[joint]:.4f} and {high[joint]:.4f} rad: give robot.q_start")  # fmt: skip


def write_motion(found: Design, robot: Scenario, out: pathlib.Path) -> pathlib.Path:
    """Write trajectory.csv and scenario.yaml; return the scenario's file."""
    t, q = found.points()
    table = np.column_stack([t, q])
    lines = [",".join(_NAMES), *(",".join(f"{x:.12g}" for x in row) for row in table)]
    head = ("# Designed by panda-twin excite; expected.json beside it says what its log will tell. On a robot:\n"
            "# panda-twin run THIS --backend fci --robot HOST, or backend: fci below.\n")  # fmt: skip
    scenario = head + robot._loaded.text.rstrip() + "\nmotion: {trajectory: trajectory.csv}\n"
    write_whole(out, {"trajectory.csv": "\n".join(lines) + "\n", "scenario.yaml": scenario})
    return out / "scenario.yaml"


def _told(value: float) -> float | None:
    return None if math.isnan(value) else float(f"{value:.6g}")


def _of_load(expected: Expected, twin: TwinModel) -> list[dict[str, Any]]:
    """Centre of mass, and inertia about it, of the scenario's load, else of 1 kg in the flange's origin."""
    sd = {p.key: float(x) for p, x in zip(expected.parameters, expected.sd)}
    mass, centre, _ = body_of(twin.load) if twin.load[0] > 0 else (1.0, np.zeros(3), None)
    rows = []
    for axis, at in zip("xyz", centre):
        value = math.hypot(sd[f"load.h{axis}"], at * sd["load.m"]) / mass
        text = f"centre of a load of {mass:g} kg, {axis}"
        rows.append({"key": f"load.centre.{axis}", "text": text, "unit": "m", "sd": _told(value)})
    return rows


def expectation(kind: str, found: Design, twin: TwinModel, noise: float) -> dict[str, Any]:
    """What `expected.json` holds: standard deviations, null where the motion cannot tell, by both laws of friction."""
    rows = rows_of_series(found.series, found.coefficients, twin)
    parameters: list[dict[str, Any]] = []
    conditions = {}
    for law, smooth in (("plain", False), ("sigmoid", True)):
        expected = expected_of(rows, terms_of(kind, smooth), noise)
        conditions[law] = float(f"{expected.condition:.6g}")
        pairs = zip(expected.parameters, expected.sd)
        all_of_it = [{"key": p.key, "text": p.text, "unit": p.unit, "sd": _told(x)} for p, x in pairs]
        all_of_it += _of_load(expected, twin) if kind == "load" else []
        parameters += [{**one, "law": law} for one in all_of_it]
    return {"for": kind, "seconds": found.series.seconds, "terms": found.series.terms, "period": found.series.period,
            "noise": {"tau_J": noise, "unit": "Nm", "rate": "1000 Hz"},
            "condition": conditions, "parameters": parameters}  # fmt: skip


def _table(facts: Mapping[str, Any]) -> str:
    lines = []
    names = {"plain": "viscous + Coulomb + offset", "sigmoid": "the smooth law, about the published one"}
    for law, condition in facts["condition"].items():
        lines.append(f"friction by {names[law]}: condition number {condition:.1f}; expected standard deviations")
        for one in facts["parameters"]:
            if one["law"] == law:
                value = "cannot be told" if one["sd"] is None else f"{one['sd']:.2g} {one['unit']}"
                lines.append(f"  {one['text']:<56} {value}")
    noise = facts["noise"]["tau_J"]
    lines.append(f"They are of least squares with noise of {noise:g} Nm on tau_J; what the model leaves out adds to them.")
    return "\n".join(lines)


def excite(options: argparse.Namespace, run_flags: Sequence[str]) -> None:
    """Carry out the command.

    Raises
    ------
    ValueError
        For bad input, and when no motion keeps within the limits.
    RuntimeError
        When the run failed.
    """
    for name, value, most in (("--speed", options.speed, 1.0), ("--noise", options.noise, 100.0)):
        if not 0 < value <= most:
            raise ValueError(f"{name} is {value:g}; it must be above 0 and at most {most:g}")
    if options.seed < 0:
        raise ValueError(f"--seed is {options.seed}; it must be at least 0")
    if run_flags and not options.run:
        raise ValueError(f"{run_flags[0]} is a flag of panda-twin run; it goes with --run")
    robot = robot_of(options.scenario, options.limits, options.kind)
    keys: Mapping[str, Any] = robot.to_dict()
    start = _start_of(keys)
    require_start(start)
    series = series_for(options.kind, start, options.seconds, options.terms)
    twin = TwinModel.of(robot)
    clearance = Clearance(keys["robot"].get("hand", "") == "franka_hand", keys.get("limits", {}))
    panda = model._panda()
    bounds = bounds_of(np.array(panda["Q_MIN"]), np.array(panda["Q_MAX"]), options.speed, clearance.joint_speed)
    out = options.out or pathlib.Path("out") / f"excite_{options.kind}"
    checked: list[str] = []

    def check(found: Design) -> None:
        checked[:] = [validate(write_motion(found, robot, out))]

    found = freed(design(options.kind, series, bounds, clearance, twin, options.noise, options.seed), check)
    facts = expectation(options.kind, found, twin, options.noise)
    write_whole(out, {"expected.json": json.dumps(facts, indent=1) + "\n"})
    if not options.quiet:
        print(checked[0].rstrip())
        print(_table(facts))
        for what, name in (("motion", "trajectory.csv"), ("scenario", "scenario.yaml"), ("expected", "expected.json")):
            print(f"{what:<9} {out / name}", flush=True)
    if options.run:
        _run(out, run_flags)


def _run(out: pathlib.Path, flags: Sequence[str]) -> None:
    words = [os.fspath(_host.executable), "run", os.fspath(out / "scenario.yaml"), "--out", os.fspath(out / "run"), *flags]
    code = subprocess.run(words).returncode
    if code:
        raise RuntimeError(f"the run ended with exit code {code}; panda-twin explain {out / 'run'} says why")
    print(f"log       {out / 'run' / 'run.mcap'}")


def main(arguments: list[str]) -> int:
    """Carries out the command; returns the exit code, which is as the program's."""
    options, run_flags = _parser().parse_known_args(arguments)
    return exit_code_of(lambda: excite(options, run_flags))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
