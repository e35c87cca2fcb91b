"""Environments of the twin for Gymnasium: actions go through the workstation and the robot's own 1 kHz controller.

Importing this package registers them: ``gymnasium.make("PandaTwin/Reach-v0")``; without the import
``gymnasium.make("panda_twin:PandaTwin/Reach-v0")``. Gymnasium 1 loads no entry points.
"""

from typing import TYPE_CHECKING, Any

from gymnasium.envs.registration import register, registry

from .tasks import Draw, Task, field

if TYPE_CHECKING:
    from .env import PandaEnv as PandaEnv
    from .vector import PandaVectorEnv as PandaVectorEnv

__all__ = ["Draw", "PandaEnv", "PandaVectorEnv", "Task", "field", "register_envs"]

_STEPS = {"Reach": 50, "Push": 100, "PickAndPlace": 100, "Peg": 150, "Wipe": 100}


def register_envs() -> None:
    """Registers ``PandaTwin/<task>-v0`` for every task; once, however often it is called."""
    for task, steps in _STEPS.items():
        if f"PandaTwin/{task}-v0" in registry:
            continue
        register(
            id=f"PandaTwin/{task}-v0",
            entry_point="panda_twin.envs.env:PandaEnv",
            vector_entry_point="panda_twin.envs.vector:PandaVectorEnv",
            max_episode_steps=steps,
            kwargs={"task": task},
        )


def __getattr__(name: str) -> Any:
    # When they are used: they need all of Gymnasium, which takes long to import.
    if name == "PandaEnv":
        from .env import PandaEnv

        return PandaEnv
    if name == "PandaVectorEnv":
        from .vector import PandaVectorEnv

        return PandaVectorEnv
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


register_envs()
