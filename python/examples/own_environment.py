"""An environment of your own: the fingertips go from above a wall to a point beside it, on either side.

    own_environment.py [--episodes N] [--seed S]

A class derived from `panda_twin.envs.Task` says what stands around the robot, where goals are and what has been achieved.
Observations, actions, rewards, the robot and its limits are those of the other environments; so are the options of `make`.
"""

import argparse
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from panda_twin.envs import Draw, Task, field

Array = npt.NDArray[np.float64]
Action = npt.NDArray[np.float32]


class BesideWall(Task):
    """The point between the fingertips to a point beside a wall of 0.3 m."""

    scenario = "objects: [{name: wall, shape: box, size: [0.3 m, 0.02 m, 0.3 m], on: ground, position: [0.5 m, 0 m, 0 m]}]\n"
    threshold = 0.02

    def draw(self, rng: np.random.Generator) -> Draw:
        goal = rng.uniform((0.45, 0.12, 0.25), (0.55, 0.2, 0.35))
        goal[1] *= rng.choice((-1, 1))
        return Draw(goal, {})

    def achieved(self, rows: Array) -> Array:
        return rows[:, field("position")].copy()


gymnasium.register("Own/BesideWall-v0", "panda_twin.envs:PandaEnv", max_episode_steps=60, kwargs={"task": BesideWall})


def around(observation: dict[str, Any]) -> Action:
    """First sideways, then down."""
    way = observation["desired_goal"] - observation["achieved_goal"]
    if abs(way[1]) > 0.05:
        way[2] = 0
    action: Action = np.clip(3 * way, -1, 1).astype(np.float32)
    return action


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()

    env = gymnasium.make("Own/BesideWall-v0", reward="dense")
    for episode in range(arguments.episodes):
        observation, info = env.reset(seed=arguments.seed + episode)
        over, total = False, 0.0
        while not over:
            observation, reward, terminated, truncated, info = env.step(around(observation))
            total, over = total + float(reward), terminated or truncated
        print(f"episode {episode}: return {total:.3f}, {'success' if info['is_success'] else 'failure'}", info.get("reflex") or "")


if __name__ == "__main__":
    main()
