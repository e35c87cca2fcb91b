"""Runs one motion over one lossy wire with three reference generators, and prints how each did.

    compare_chains.py [SCENARIO] [--loss PERCENT] [--seed S]

Without SCENARIO a brisk motion over a wire that is dead for up to 19 ms at a time.
"""

import argparse

import panda_twin as pt
from panda_twin.scenario_types import Tick

CHAINS: dict[str, Tick] = {
    "none": {"generator": "none", "viability": "off"},  # targets as they come
    "joint": {"generator": "joint", "viability": "off"},  # the paper's generator
    "rejoining": {"generator": "rejoining", "viability": 19},  # the default: correction and viability filter
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="scenarios/viability.yaml")
    parser.add_argument("--loss", type=float, help="commands lost on their way, percent, instead of the scenario's")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()

    scenario = pt.Scenario.load(arguments.scenario)
    if arguments.loss is not None:
        scenario = scenario.replace({"link": {"command_loss": f"{arguments.loss} %"}})
    print(f"{'generator':10} {'outcome':8} {'simulated, s':>12} {'held':>6} {'deviation, mrad':>15}  error")
    for name, tick in CHAINS.items():
        result = pt.run(scenario.replace({"tick": tick}), seed=arguments.seed, check=False)
        told = result.explain()
        found = result.summary
        print(f"{name:10} {found['outcome']:8} {found['simulated_s']:12.3f} {found['cycles_held']:6} "
              f"{1e3 * found['deviation_rad']:15.2f}  {told.error or '-'}")


if __name__ == "__main__":
    main()
