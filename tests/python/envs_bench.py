"""Steps per second of the environments, beside those of peers where a folder has them installed.

    envs_bench.py [--peers VENV] [--steps N] [--memory STEPS]

VENV has panda-gym 3.0.7, gymnasium-robotics 1.4.2 and robosuite 1.5.2 (which need mujoco<3.4), or some of them. All are
measured in turns in one run, by the processor time of their process: so figures are per core, and compare on a busy machine.
"""

import argparse
import json
import pathlib
import resource
import subprocess
import sys
import time

TURNS = 3

# Runs in the peers' Python, too: standard library, Gymnasium and numpy alone.
MEASURE = """
import sys, time, json, warnings
warnings.filterwarnings("ignore")
import numpy as np
kind, steps = sys.argv[1], int(sys.argv[2])
if kind.startswith("robosuite/"):
    import robosuite
    env = robosuite.make(kind.split("/")[1], robots="Panda", has_renderer=False, has_offscreen_renderer=False,
                         use_camera_obs=False, control_freq=20, horizon=100000)
    low, high = env.action_spec
    step = lambda: env.step(np.random.uniform(low, high))
else:
    import gymnasium
    if kind.startswith("PandaTwin/"):
        import panda_twin
    elif kind.startswith("Panda"):
        import panda_gym
    else:
        import gymnasium_robotics
        gymnasium.register_envs(gymnasium_robotics)
    env = gymnasium.make(kind).unwrapped
    step = lambda: env.step(env.action_space.sample())
env.reset()
for _ in range(20):
    step()
begin = time.process_time()
for k in range(steps):
    if k % 50 == 0:
        env.reset()
    step()
stepping = time.process_time() - begin
begin = time.process_time()
for _ in range(20):
    env.reset()
print(json.dumps({"steps_per_s": steps / stepping, "step_ms": stepping / steps * 1e3,
                  "reset_ms": (time.process_time() - begin) / 20 * 1e3}))
"""


def measure(python: str, kind: str, steps: int) -> dict[str, float] | None:
    """Figures of one environment in a process of its own; None if it does not run there."""
    done = subprocess.run([python, "-c", MEASURE, kind, str(steps)], capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{kind}: not measured ({done.stderr.strip().splitlines()[-1:]})")
        return None
    figures: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return figures


def measure_all(kinds: dict[str, tuple[str, int]]) -> dict[str, dict[str, float]]:
    """Best of some turns, in which all environments come once."""
    best: dict[str, dict[str, float]] = {}
    for _ in range(TURNS):
        for kind, (python, steps) in kinds.items():
            figures = measure(python, kind, steps)
            if figures is None:
                continue
            last = best.get(kind, figures)
            best[kind] = {"steps_per_s": max(last["steps_per_s"], figures["steps_per_s"]),
                          "step_ms": min(last["step_ms"], figures["step_ms"]),
                          "reset_ms": min(last["reset_ms"], figures["reset_ms"])}
    return best


def vector_rates(steps: int) -> dict[str, float]:
    """Robot steps per second of wall time: one robot, and two on two threads, in turns."""
    import gymnasium
    import numpy as np

    import panda_twin  # noqa: F401

    rates = {"one": 0.0, "two": 0.0, "busy": 0.0}
    envs = {"one": gymnasium.make_vec("PandaTwin/Reach-v0", num_envs=1, threads=1),
            "two": gymnasium.make_vec("PandaTwin/Reach-v0", num_envs=2, threads=2)}
    for _ in range(TURNS):
        for name, env in envs.items():
            env.reset(seed=1)
            actions = np.zeros(env.action_space.shape, dtype=np.float32)
            begin, used = time.perf_counter(), time.process_time()
            for _ in range(steps):
                env.step(actions)
            wall = time.perf_counter() - begin
            if steps * env.num_envs / wall > rates[name]:
                rates[name] = steps * env.num_envs / wall
                if name == "two":
                    rates["busy"] = (time.process_time() - used) / wall
    return rates


def memory_growth(steps: int) -> float:
    """MB that the process grows by over so many steps, after the first tenth."""
    import gymnasium

    import panda_twin  # noqa: F401

    env = gymnasium.make("PandaTwin/Reach-v0").unwrapped
    action = env.action_space.sample()
    at = 0
    for k in range(steps):
        if k % 50 == 0:
            env.reset()
        env.step(action)
        if k == steps // 10:
            at = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - at) / 1024


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=pathlib.Path, help="a virtual environment that has the peers")
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--memory", type=int, default=100_000, help="steps over which memory must not grow")
    arguments = parser.parse_args()

    kinds = {f"PandaTwin/{task}-v0": (sys.executable, arguments.steps)
             for task in ("Reach", "Push", "PickAndPlace", "Peg", "Wipe")}
    if arguments.peers is not None:
        python = str(arguments.peers / "bin" / "python")
        kinds |= {"PandaReach-v3": (python, arguments.steps), "PandaPickAndPlace-v3": (python, arguments.steps),
                  "FetchReach-v4": (python, arguments.steps), "robosuite/Lift": (python, arguments.steps // 5)}
    figures = measure_all(kinds)
    for kind, row in figures.items():
        print(f"{kind:26} {row['steps_per_s']:8.0f} steps/s   step {row['step_ms']:7.3f} ms   reset {row['reset_ms']:7.3f} ms")
    failures = []
    ours = figures["PandaTwin/Reach-v0"]
    if ours["reset_ms"] > ours["step_ms"]:
        failures.append(f"a reset takes {ours['reset_ms']:.3f} ms, a step {ours['step_ms']:.3f} ms")
    for kind, demand in (("PandaReach-v3", 1.5), ("FetchReach-v4", 0.0), ("robosuite/Lift", 0.0)):
        if kind not in figures:
            continue
        ratio = ours["steps_per_s"] / figures[kind]["steps_per_s"]
        print(f"Reach against {kind}: {ratio:.2f}" + (f" (demanded: {demand})" if demand else ""))
        if ratio < demand:
            failures.append(f"Reach has {ratio:.2f} times the steps/s of {kind}, not {demand}")
    rates = vector_rates(arguments.steps)
    ratio = rates["two"] / rates["one"]
    print(f"two robots on two threads: {ratio:.2f} times one ({rates['one']:.0f} -> {rates['two']:.0f} robot steps/s), "
          f"with {rates['busy']:.2f} processors given by the host (demanded: 1.8, of a host that gives 1.9)")
    if ratio < 1.8 and rates["busy"] >= 1.9:
        failures.append(f"two robots on two threads make {ratio:.2f} times the steps of one")
    growth = memory_growth(arguments.memory)
    print(f"memory: {growth:.1f} MB more over {arguments.memory} steps (demanded: at most 2)")
    if growth > 2:
        failures.append(f"memory grows by {growth:.1f} MB")
    print("\n".join(["", "FAILED: " + "; ".join(failures)] if failures else ["", "all demands met"]))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
