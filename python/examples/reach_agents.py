"""Lets two agents try PandaTwin/Reach-v0: one acts at random, one goes straight to the goal.

    reach_agents.py [--episodes N] [--seed S] [--loss SHARE]
"""

import argparse
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

import panda_twin  # noqa: F401: registers the environments

Action = npt.NDArray[np.float32]
Agent = Callable[[dict[str, Any]], Action]


def straight(observation: dict[str, Any]) -> Action:
    """Velocity of the end effector's target along the way to the goal; 1 is 0.5 m/s."""
    way = observation["desired_goal"] - observation["achieved_goal"]
    action: Action = np.clip(2 * way, -1, 1).astype(np.float32)
    return action


def success_rate(env: gymnasium.Env[Any, Any], agent: Agent, episodes: int, seed: int) -> float:
    """Share of the episodes at whose end the end effector is at the goal."""
    successes = 0
    for episode in range(episodes):
        observation, info = env.reset(seed=seed + episode)
        over = False
        while not over:
            observation, reward, terminated, truncated, info = env.step(agent(observation))
            over = terminated or truncated
        if info.get("reflex"):
            print(f"episode {episode} was ended by the robot: {info['reflex']}")
        successes += info["is_success"]
    return successes / episodes


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--loss", type=float, default=0.0, help="share of messages lost in each direction, 0 to 1")
    arguments = parser.parse_args()

    env = gymnasium.make("PandaTwin/Reach-v0", losses=arguments.loss)
    env.action_space.seed(arguments.seed)
    agents: dict[str, Agent] = {"random": lambda observation: env.action_space.sample(), "straight": straight}
    for name, agent in agents.items():
        print(f"{name:8} reaches {100 * success_rate(env, agent, arguments.episodes, arguments.seed):.0f} % of the goals")


if __name__ == "__main__":
    main()
