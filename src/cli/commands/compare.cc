#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/python_package.h"

namespace twin::cli {
namespace {

struct CompareFlags {
  std::vector<std::string> logs;
  std::string against;
  std::string map;
  std::string identify;
  std::string demand;
  std::string write;
  std::string out;
};

/// Numbers of logs are the Python package's: it reads other programs' logs, and has SciPy.
int Compare(const CompareFlags& flags, const Program& program) {
  std::vector<std::string> words = flags.logs;
  AddFlag("--against", flags.against, words);
  AddFlag("--map", flags.map, words);
  AddFlag("--identify", flags.identify, words);
  AddFlag("--demand", flags.demand, words);
  AddFlag("--write", flags.write, words);
  AddFlag("--out", flags.out, words);
  if (program.is_quiet()) words.emplace_back("--quiet");
  BecomePython("identify._program", words, program.host);
}

}  // namespace

void AddCompare(CLI::App& app, Program& program) {
  const auto [compare, flags] =
      AddCommand(app, program, "compare",
                 "Compare a robot's log with the twin: how far, why, and what helps", &Compare);
  Add(compare, "log LOG...", flags.logs,
      "Logs of one robot: run.mcap or its folder, libfranka's CSV, panda-py's log as .npz, a bag of "
      "ROS 2, or a table with --map")
      ->required();
  Add(compare, "--against SCENARIO", flags.against,
      "The twin (default: the log's own scenario, else a Panda with its hand)");
  Add(compare, "--map FILE", flags.map, "Which columns of a table are which, with units (YAML)");
  Add(compare, "--identify WHAT", flags.identify,
      "Of friction, load, delay, elasticity, armature, inertia, with commas: what is fitted");
  Add(compare, "--demand FILE", flags.demand,
      "What the twin must keep (YAML; default: torque within 2 % of each joint's largest, "
      "positions within 3 mrad, delay within 1 ms)");
  Add(compare, "--write FILE", flags.write,
      "Profile of the identified robot, which a scenario names by robot: {profile: FILE}");
  Add(compare, "--out DIR", flags.out, "Folder of the report (default: out/compare)");
}

}  // namespace twin::cli
