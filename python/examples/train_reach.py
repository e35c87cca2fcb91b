"""Learns PandaTwin/Reach-v0 by the cross-entropy method, with numpy alone, in a few minutes.

    train_reach.py [--out DIR] [--iterations N] [--seed S]

The policy is linear: 3 velocities from the way to the goal, the end effector's velocity and the lead of its target (and a
constant): 30 weights. Each iteration draws a population, lets every robot of a vector environment try one, and fits a
normal distribution to the best quarter. The same seed gives the same curve, on any number of threads.
DIR gets curve.csv, policy.npy, and curve.png where gnuplot is installed.
"""

import argparse
import pathlib
import shutil
import subprocess
import time

import gymnasium
import numpy as np
import numpy.typing as npt

import panda_twin  # noqa: F401: registers the environments

POPULATION, BEST, EPISODES, STEPS = 32, 8, 2, 30
Array = npt.NDArray[np.float64]


def act(weights: Array, observations: dict[str, Array]) -> Array:
    """Actions of policies (n, 3, 10), one per robot."""
    way = observations["desired_goal"] - observations["achieved_goal"]
    speed = observations["observation"][:, 7:10]
    lead = observations["observation"][:, -3:]
    features = np.concatenate([10 * way, speed, 10 * lead, np.ones((len(way), 1))], axis=1)
    actions: Array = np.clip(np.einsum("nij,nj->ni", weights, features), -1, 1)
    return actions


def evaluate(env: gymnasium.vector.VectorEnv, weights: Array, seed: int) -> tuple[Array, Array]:
    """Mean negative distance per policy, m, and whether its end is at the goal."""
    observations, infos = env.reset(seed=seed)
    returns = np.zeros(env.num_envs)
    for _ in range(STEPS):
        observations, rewards, _, _, infos = env.step(act(weights, observations).astype(np.float32))
        returns += rewards / STEPS
    return returns, infos["is_success"].astype(float)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/train_reach"))
    parser.add_argument("--iterations", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)

    env = gymnasium.make_vec("PandaTwin/Reach-v0", num_envs=POPULATION, reward="dense", max_episode_steps=10 * STEPS)
    rng = np.random.default_rng(arguments.seed)
    mean, spread = np.zeros((3, 10)), np.full((3, 10), 0.5)
    curve, begin = [], time.monotonic()
    for iteration in range(arguments.iterations):
        weights = mean + spread * rng.standard_normal((POPULATION, 3, 10))
        seeds = [int(rng.integers(2**31)) for _ in range(EPISODES)]
        results = [evaluate(env, weights, seed) for seed in seeds]
        returns = np.mean([one for one, _ in results], axis=0)
        best = weights[np.argsort(returns)[-BEST:]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05 * 0.9**iteration
        _, success = evaluate(env, np.repeat(mean[np.newaxis], POPULATION, axis=0), seed=2**31 + iteration)
        curve.append((iteration, (iteration + 1) * POPULATION * EPISODES * STEPS, returns.mean(), returns.max(), success.mean()))
        print(f"iteration {iteration:2}: mean return {curve[-1][2]:.4f} m, best {curve[-1][3]:.4f} m, "
              f"success of the mean policy {100 * success.mean():.0f} %, {time.monotonic() - begin:.0f} s")

    np.save(arguments.out / "policy.npy", mean)
    table = arguments.out / "curve.csv"
    lines = [f"{i},{steps},{average:.6f},{most:.6f},{success:.4f}" for i, steps, average, most, success in curve]
    table.write_text("\n".join(["iteration,steps,mean_return_m,best_return_m,success", *lines]) + "\n")
    if shutil.which("gnuplot"):
        plot = (f'set terminal pngcairo size 800,500; set output "{arguments.out / "curve.png"}"; set datafile separator ","; '
                'set xlabel "steps"; set ylabel "negative distance, m"; set y2label "success"; set y2tics; set y2range [0:1.05]; '
                f'plot "{table}" every ::1 using 2:3 with lines title "mean", "" every ::1 using 2:5 axes x1y2 with lines title "success"')
        subprocess.run(["gnuplot", "-e", plot], check=True)
    print(f"the curve is in {table}")


if __name__ == "__main__":
    main()
