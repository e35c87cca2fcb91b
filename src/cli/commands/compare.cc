#include <string>

#include "cli/commands/commands.h"
#include "cli/python_package.h"

namespace twin::cli {
namespace {

/// Numbers of logs are the Python package's: it reads other programs' logs, and has SciPy.
int Compare(const HandedOver& flags, const Program& program) {
  BecomePython("identify._program", flags.Words(program), program.host);
}

}  // namespace

void AddCompare(CLI::App& app, Program& program) {
  const auto [compare, flags] =
      AddCommand(app, program, "compare",
                 "Compare a robot's log with the twin: how far, why, and what helps", &Compare);
  Add(compare, "log LOG...", flags.positionals,
      "Logs of one robot: run.mcap or its folder, libfranka's CSV, panda-py's log as .npz, a bag of "
      "ROS 2, or a table with --map")
      ->required();
  flags.Add(compare, "--against SCENARIO",
            "The twin (default: the log's own scenario, else a Panda with its hand)");
  flags.Add(compare, "--map FILE", "Which columns of a table are which, with units (YAML)");
  flags.Add(compare, "--identify WHAT",
            "Of friction, load, delay, elasticity, armature, inertia, with commas: what is fitted");
  flags.Add(compare, "--demand FILE",
            "What the twin must keep (YAML; default: torque within 2 % of each joint's rated one, "
            "positions within 3 mrad, delay within 1 ms)");
  flags.Add(compare, "--write FILE",
            "Profile of the identified robot, which a scenario names by robot: {profile: FILE}");
  flags.Add(compare, "--out DIR", "Folder of the report (default: out/compare)");
}

}  // namespace twin::cli
