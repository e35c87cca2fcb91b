"""A comparison of a robot's logs with a twin."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Collection, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import model
from .._results import RunResult
from ..scenario import Scenario, ScenarioLike, as_scenario
from ._causes import Cause, causes_of, residual_of
from ._closed import closed_of, external_of
from ._demand import TORQUE_LIMITS, judge, read_demand
from ._identify import KINDS, Identified, identify
from ._mistakes import mistake_of
from ._model import TwinModel
from ._profile import profile_of
from ._regression import fit
from ._result import Closed, CommandDelay, Comparison, LogFacts, Open, rms
from ._rows import MOST, Motion, Rows, joined, motions_of, rows_of, with_noise
from ._terms import Delay, Friction, Load
from .logs._recording import MappingLike, Recording
from .logs._suspicions import suspicions

Array: TypeAlias = npt.NDArray[np.float64]
LogLike = str | os.PathLike[str] | Mapping[str, Any] | RunResult

_PANDA: Any = {"name": "panda", "robot": {"q_start": {"unit": "rad", "values": model.Q_READY.tolist()}}}
_BESIDE = ("tau_J", "theta", "tau_J_d")
_IMPOSSIBLE = 1e6
_EXPLAINED = 0.95  # of the squared residual
_LARGE = 0.1  # of the measured torques: a smaller residual is not due to columns that are others than said
_MOST_CYCLES = 20  # of a delay between command and motion


def compare(
    *logs: LogLike,
    against: ScenarioLike | None = None,
    mapping: MappingLike | None = None,
    identify: Collection[str] = (),
    demand: str | os.PathLike[str] | Mapping[str, Any] | None = None,
) -> Comparison:
    """Compare a robot's logs with its twin.

    Parameters
    ----------
    *logs
        Of one robot with one load: the result of `run`, a folder of results or run.mcap, libfranka's CSV, what panda_py's get_log() returned (.npz or the
        dict), a bag of ROS 2, or any CSV, Parquet or NPZ file with a `mapping`.
    against
        The twin: a scenario. By default that of the log, if it is the twin's own; else a Panda with its hand.
    mapping
        Which columns are which, with their units.
    identify
        Of friction, load, delay, elasticity, armature, inertia: what is fitted.
    demand
        What the twin must keep: a file or a map, as {"torque": "0.5 Nm", "position": "2 mrad"}.

    Returns
    -------
    Comparison
        `passed` is the verdict on the twin as it is given; the identified one is beside it.

    Raises
    ------
    ValueError
        For a log, a mapping or a demand that is none: says what, where and what to do.
    OSError
        For a file that cannot be read.
    """
    if not logs:
        raise ValueError("no log to compare; name one")
    unknown = set(identify) - set(KINDS)
    if unknown:
        raise ValueError(f"{', '.join(sorted(unknown))} cannot be identified; choose of {', '.join(KINDS)}")
    wanted = read_demand(demand)
    files = [os.path.realpath(log) for log in logs if isinstance(log, (str, os.PathLike))]
    if twice := next((file for file in files if files.count(file) > 1), None):
        raise ValueError(f"{twice} is named twice; a log counts once")
    recordings = [Recording.open(log.folder if isinstance(log, RunResult) else log, mapping) for log in logs]
    for recording in recordings:
        if "q" not in recording.columns:
            raise ValueError(f"{recording.name}: it has no joint positions q, and nothing can be compared without them; map its columns")
    return _Comparing(recordings, _twin_of(recordings, against), set(identify)).result(wanted)


def _twin_of(recordings: Sequence[Recording], against: ScenarioLike | None) -> Scenario:
    if against is not None:
        return as_scenario(against)
    own = recordings[0].scenario
    if own is None:
        return Scenario(**_PANDA)
    return own.replace({"backend": "mujoco"}) if own.to_dict().get("backend") == "fci" else own


def _require_possible(name: str, motions: Sequence[Motion]) -> None:
    """Raise ValueError for numbers that are no robot's in any unit."""
    for motion in motions:
        for column, values in (("q", motion.q), ("dq", motion.dq), *motion.others.items()):
            most = float(np.max(np.abs(values)))
            if not most < _IMPOSSIBLE:
                at = motion.t[int(np.argmax(np.max(np.abs(values), axis=1)))]
                raise ValueError(f"{name}: {column} is {most:.3g} at {at:.3f} s, which no robot has in any unit; remove the row, or leave {column} out")


class _Comparing:
    """The steps of a comparison."""

    def __init__(self, recordings: Sequence[Recording], scenario: Scenario, kinds: set[str]) -> None:
        self.recordings = recordings
        self.scenario = scenario
        self.kinds = kinds
        self.twin = TwinModel.of(scenario)
        self.notes: list[str] = []
        self.untold: list[str] = []
        self.motions = [list(motions_of(r, *(set(_BESIDE) & r.columns))) for r in recordings]
        for recording, motions in zip(recordings, self.motions):
            _require_possible(recording.name, motions)
        for recording in recordings:
            if recording.seconds > MOST:
                self.notes.append(f"{recording.name} is {recording.seconds:.0f} s long: torques of {MOST:.0f} s, spread over all of it, are compared")

    def result(self, demand: Mapping[str, Array]) -> Comparison:
        all_motions = [motion for motions in self.motions for motion in motions]
        rows = self._rows()
        before = residual_of(rows, self.twin) if rows else None
        causes = self._causes(rows, before, all_motions) if rows is not None and before is not None else []
        found = identify(with_noise(rows, all_motions, self.twin), self.twin, self.kinds) if rows and self.kinds else None
        if found:
            self.untold += found.untold
        delay = self._command_delay()
        facts = [self._facts(r) for r in self.recordings]
        doubts = [text for one in facts for text in one.suspicions]
        profile = profile_of(self.recordings, all_motions, found, delay, self.twin.load, doubts) if found else None
        after_twin = self._identified(found)
        after = residual_of(rows, after_twin) if rows and found else None
        closed, closed_after = self._closed(profile)
        external = external_of(self.recordings, self.scenario)
        values = self._found(rows, before, closed, external.torque_rms if external else None)
        torques = Open(rows.t, rows.q, rows.dq, rows.tau_at(0.0), before, after) if rows is not None and before is not None else None
        return Comparison(
            facts, self.scenario, torques, causes, found,
            closed, closed_after, external, delay, values, judge(demand, values), self.untold + self.notes, profile,
        )  # fmt: skip

    def _causes(self, rows: Rows, before: Array, motions: Sequence[Motion]) -> list[Cause]:
        if self.scenario.to_dict().get("plant", {}).get("kind") == "ideal":
            self.notes.append("what makes the torques differ: the twin's plant is ideal, an arm without friction that does what its controller wants")
            return []
        causes = causes_of(rows, before, self.twin)
        beyond = np.any((rows.q < model.Q_MIN - 0.1) | (rows.q > model.Q_MAX + 0.1))
        if sum(cause.share for cause in causes) > _EXPLAINED and not beyond or np.sum(before**2) < _LARGE**2 * np.sum(rows.tau_at(0.0) ** 2):
            return causes
        # Nothing physical makes a twin so wrong.
        mistake = mistake_of(motions, self.twin)
        return [mistake, *causes[:2]] if mistake else causes

    def _rows(self) -> Rows | None:
        parts = [rows_of(motions, self.twin, recording.name) for recording, motions in zip(self.recordings, self.motions) if "tau_J" in recording.columns]
        if not parts:
            self.untold.append("torques, and so friction, load, delay and inertia: no log has tau_J")
        return joined(parts) if parts else None

    def _identified(self, found: Identified | None) -> TwinModel:
        if found is None:
            return self.twin
        changes: dict[str, Any] = {"friction": found.friction, "load": found.load, "arm": found.links, "torque_delay": found.delay}
        return dataclasses.replace(self.twin, **{name: value for name, value in changes.items() if value is not None})

    def _closed(self, profile: Mapping[str, Any] | None) -> tuple[Closed | None, Closed | None]:
        recording = self.recordings[0]
        closed = closed_of(recording, self.scenario)
        if closed is None:
            self.untold.append("how the robot follows its commands: the log has neither q_c nor q_d, nor another command, or begins in a motion")
            return None, None
        if profile is None:
            return closed, None
        return closed, closed_of(recording, self.scenario.replace(profile["scenario"]))

    def _command_delay(self) -> CommandDelay | None:
        recording = self.recordings[0]
        if not {"q_c", "q_d"} <= recording.columns or not recording.by_id:
            return None
        found = np.zeros(_MOST_CYCLES + 1)
        for block in recording.blocks("q_c", "q_d"):
            q_c, q_d = block.columns["q_c"], block.columns["q_d"]
            moving = np.flatnonzero(np.any(np.diff(q_d, axis=0) != 0, axis=1)) + 1
            moving = moving[moving > _MOST_CYCLES]
            left = moving
            for delay in range(_MOST_CYCLES + 1):
                same = np.all(np.abs(q_d[left] - q_c[left - delay]) < 1e-9, axis=1)
                found[delay] += np.sum(same)
                left = left[~same]
        if found.sum() < 100:
            return None
        return CommandDelay(np.arange(len(found), dtype=float), found / found.sum(), 0)

    def _found(self, rows: Rows | None, torque: Array | None, closed: Closed | None, external: Array | None) -> dict[str, Array]:
        timing = [r.timing for r in self.recordings]
        values: dict[str, Array] = {"lost": np.array([sum(t.lost for t in timing) / sum(t.lost + r.rows for t, r in zip(timing, self.recordings))])}
        if torque is not None and rows is not None:
            values["torque"] = rms(torque)
            values["torque_share"] = values["torque"] / TORQUE_LIMITS
            delay = fit(rows, torque, [Delay(), Friction(), Load()])
            values["delay"] = np.abs(delay.values[:1])
        if closed is not None:
            values["position"] = closed.position_rms
        if external is not None:
            values["external_torque"] = external
        return values

    def _facts(self, recording: Recording) -> LogFacts:
        return LogFacts(recording.name, recording.kind, recording.sha256, recording.rows, recording.seconds, recording.timing,
                        recording.missing, recording.notes, suspicions(recording.head(20.0, *({"q", "dq", "tau_J", "q_d"} & recording.columns))))  # fmt: skip
