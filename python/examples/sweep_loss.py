"""Runs a scenario at several rates of loss and several seeds, in threads, and prints how often the motion arrives.

    sweep_loss.py [SCENARIO] [--losses 1 10 30] [--seeds N] [--threads N]

A run lets other threads of Python go on, so that threads are enough. Results do not depend on their number.
"""

import argparse
import concurrent.futures
import os

import numpy as np

import panda_twin as pt


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="scenarios/packet_loss.yaml")
    parser.add_argument("--losses", type=float, nargs="+", default=[1.0, 10.0, 30.0, 60.0], help="of commands, percent")
    parser.add_argument("--seeds", type=int, default=5, help="runs at each rate")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    arguments = parser.parse_args()

    base = pt.Scenario.load(arguments.scenario)

    def run(loss: float, seed: int) -> pt.RunResult:
        scenario = base.replace({"link": {"command_loss": f"{loss} %"}})
        return pt.run(scenario, seed=seed, check=False)

    print(f"{'loss, %':>8} {'arrived':>8} {'longest loss':>13} {'deviation, mrad':>16}")
    with concurrent.futures.ThreadPoolExecutor(arguments.threads) as threads:
        jobs = {loss: [threads.submit(run, loss, seed) for seed in range(arguments.seeds)] for loss in arguments.losses}
        for loss, running in jobs.items():
            found = [job.result() for job in running]
            arrived = sum(result.succeeded for result in found)
            longest = max(result.summary["longest_loss_cycles"] for result in found)
            deviation = np.median([result.summary["deviation_rad"] for result in found])
            print(f"{loss:8g} {arrived:5}/{arguments.seeds:2} {longest:13} {1e3 * deviation:16.2f}")


if __name__ == "__main__":
    main()
