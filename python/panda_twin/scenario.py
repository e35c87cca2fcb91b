"""Scenarios: everything that describes a run. What they may hold is checked in C++, by the code that reads the files."""

from __future__ import annotations

import json
import math
import operator
import os
import pathlib
import typing
from collections.abc import Iterable, Mapping

from . import _core
from .model import Q_READY

if typing.TYPE_CHECKING:
    from .scenario_types import ScenarioKeys

_BUILT = "Scenario()"  # stands in messages where a file's name would


def _plain(value: typing.Any) -> typing.Any:
    """What JSON can write. YAML spells infinity and NaN in its own way."""
    if hasattr(value, "tolist"):  # arrays and scalars of numpy
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if value is None or isinstance(value, (str, bool, int, float)):
        return value
    raise TypeError(f"{value!r} is of type {type(value).__name__}; a scenario holds texts, numbers, lists and dicts")


def _text(value: typing.Any) -> str:
    return json.dumps(_plain(value), indent=1, ensure_ascii=False)


class Scenario:
    """A checked scenario, which does not change.

    Parameters
    ----------
    **keys
        The sections of a scenario file, as `panda_twin.scenario_types` has them: quantities are texts with a unit ("100 us",
        "0.5 %"), bare numbers are numbers. A file that a section names is sought below the current folder.

    Raises
    ------
    ValueError
        "<file>:<line>: <key>: ..." for anything invalid.

    Examples
    --------
    >>> scenario = Scenario.load("scenarios/canonical.yaml")
    >>> lossy = scenario.replace({"link": {"command_loss": "1 %"}})
    """

    def __init__(self, **keys: typing.Unpack[ScenarioKeys]) -> None:
        self._loaded = _core.LoadedScenario.parse(_text(keys), _BUILT)

    @classmethod
    def _of(cls, loaded: _core.LoadedScenario) -> Scenario:
        scenario = cls.__new__(cls)
        scenario._loaded = loaded
        return scenario

    @classmethod
    def load(cls, file: str | os.PathLike[str]) -> Scenario:
        """Read a scenario file: as named, else one of the installed models ("scenarios/grasp.yaml", "applications/compliance.yaml")."""
        return cls._of(_core.LoadedScenario.load(pathlib.Path(file)))

    @classmethod
    def from_yaml(cls, text: str, file: str | os.PathLike[str] = "text") -> Scenario:
        """Read a scenario from a text. `file` is its name in messages; files that it names are sought beside it."""
        return cls._of(_core.LoadedScenario.parse(text, pathlib.Path(file)))

    def replace(
        self, changes: ScenarioKeys | None = None, *, remove: Iterable[str] = (), **keys: typing.Unpack[ScenarioKeys]
    ) -> Scenario:
        """Return this scenario with other values.

        Parameters
        ----------
        changes : dict
            Laid over the scenario's text: dicts are merged key by key, any other value replaces the old one. Defaults that
            depend on what changes are chosen anew.
        remove : iterable of str
            Keys that get their defaults back: "link.command_loss".
        **keys
            As `changes`: ``replace(link={"command_loss": "1 %"})``.
        """
        if changes is None:
            changes = {}
        if not isinstance(changes, Mapping):
            raise TypeError(f"changes is of type {type(changes).__name__}; a dict of a scenario's keys belongs here")
        loaded = self._loaded.replaced(_text({**changes, **keys}))
        gone: dict[str, typing.Any] = {}
        for key in (remove,) if isinstance(remove, str) else remove:
            *path, last = key.split(".")
            inside = gone
            for part in path:
                inside = inside.setdefault(part, {})
            inside[last] = None
        return Scenario._of(loaded.replaced(_text(gone)) if gone else loaded)

    def to_yaml(self) -> str:
        """Return the canonical text: every key, waypoints included, so that it stands alone."""
        return self._loaded.to_yaml()

    def to_dict(self) -> ScenarioKeys:
        """Return every key of the canonical text: `Scenario(**s.to_dict()) == s`."""
        return typing.cast("ScenarioKeys", json.loads(self._loaded.to_json()))

    @property
    def name(self) -> str:
        """Names the folder of results."""
        return self._loaded.name

    @property
    def description(self) -> str:
        """Description for people."""
        return self._loaded.description

    @property
    def seed(self) -> int:
        """Seed of every random number of the run."""
        return self._loaded.seed

    @property
    def drive(self) -> str:
        """Who advances time: "lockstep", "realtime" or "remote"."""
        return self._loaded.drive

    def __eq__(self, other: object) -> bool:
        return self._loaded.equals(other._loaded) if isinstance(other, Scenario) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.to_yaml())

    def __reduce__(self) -> tuple[typing.Any, ...]:
        return Scenario.from_yaml, (self._loaded.text, str(self._loaded.file))

    def __repr__(self) -> str:
        return f"<Scenario {self.name}, seed {self.seed}>"


class HasYaml(typing.Protocol):
    """A scenario as an object."""

    def to_yaml(self) -> str:
        """The scenario as the text of its file."""
        ...


ScenarioLike: typing.TypeAlias = "Scenario | ScenarioKeys | str | os.PathLike[str]"
"""A scenario, its keys, or the name of its file."""

RobotLike: typing.TypeAlias = "HasYaml | ScenarioKeys | str | os.PathLike[str]"
"""A scenario that may be without a motion: an object with `to_yaml()`, keys, a text of several lines, or the name of a file."""


def _standing(keys: Mapping[str, typing.Any]) -> Mapping[str, typing.Any]:
    """A robot's keys; without a motion it begins in the ready pose unless they name another."""
    if "motion" in keys or "application" in keys:
        return keys
    return {**keys, "robot": {"q_start": {"unit": "rad", "values": Q_READY}, **keys.get("robot", {})}}


def as_robot(scenario: RobotLike, name: str) -> tuple[str | None, pathlib.Path]:
    """Return the text of a scenario that may be without a motion (None: its file is to be read) and its file.

    Of keys, `name` and the pose in which the arm begins, `model.Q_READY`, may be missing.
    """
    if isinstance(scenario, Mapping):
        return _text(_standing({"name": name, **scenario})), pathlib.Path(name)
    if isinstance(scenario, str) and "\n" in scenario:
        return scenario, pathlib.Path(name)
    if isinstance(scenario, (str, os.PathLike)):
        return None, pathlib.Path(scenario)
    if hasattr(scenario, "to_yaml"):
        return scenario.to_yaml(), pathlib.Path(name)
    raise TypeError(f"scenario is of type {type(scenario).__name__}; a Scenario, a dict of its keys or a file's name belongs here")


def as_cell(scenario: RobotLike) -> tuple[str | None, pathlib.Path]:
    """Return as `as_robot` what describes several robots, each of which may be without a motion."""
    robots = scenario.get("robots") if isinstance(scenario, Mapping) else None
    if not isinstance(robots, Mapping):
        return as_robot(scenario, "cell")
    standing = {name: _standing(keys) if isinstance(keys, Mapping) else keys for name, keys in robots.items()}
    return _text({"name": "cell", **typing.cast("dict[str, typing.Any]", scenario), "robots": standing}), pathlib.Path("cell")


def as_scenario(scenario: ScenarioLike) -> Scenario:
    """Return the scenario that an argument names. Raises ValueError for one that says nothing of a motion."""
    if isinstance(scenario, Mapping):
        scenario = Scenario(**scenario)
    if isinstance(scenario, (str, os.PathLike)):
        scenario = Scenario.load(scenario)
    if isinstance(scenario, Scenario):
        if scenario._loaded.moves:
            return scenario
        raise ValueError(f"scenario {scenario.name}: motion is missing; give it one, or an application")
    raise TypeError(f"scenario is of type {type(scenario).__name__}; a Scenario, a dict of its keys or a file's name belongs here")


def checked_seed(seed: int | None) -> int | None:
    """Return a seed that replaces a scenario's, which must be of 64 bits; None stays."""
    if seed is not None and not 0 <= (seed := operator.index(seed)) < 2**64:
        raise ValueError(f"seed is {seed}; it must be a whole number from 0 to {2**64 - 1}")
    return seed


def validate(scenario: ScenarioLike, load: bool = False) -> str:
    """Check a scenario as `panda-twin validate` does: what passes here, a run does not refuse.

    Parameters
    ----------
    scenario : Scenario, dict or path
        As of `run`.
    load : bool
        Load the scenario's `controller.library` too, which runs code of it.

    Returns
    -------
    str
        What was checked, a line each.

    Raises
    ------
    ValueError
        Naming file, line and key, or what is wrong with the motion.
    """
    return as_scenario(scenario)._loaded.validate(load)


def schema() -> dict[str, typing.Any]:
    """Return the JSON Schema (draft 2020-12) of scenario files."""
    return typing.cast(dict[str, typing.Any], json.loads(_core.schema()))
