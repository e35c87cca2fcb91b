#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/python_package.h"

namespace twin::cli {
namespace {

struct ExciteFlags {
  HandedOver design;
  bool run = false;
  CLI::App* command = nullptr;  ///< has the flags for `run`
};

/// The design is the Python package's.
int Excite(const ExciteFlags& flags, const Program& program) {
  std::vector<std::string> words = flags.design.Words(program);
  if (flags.run) words.emplace_back("--run");
  const std::vector<std::string> of_run = flags.command->remaining();
  words.insert(words.end(), of_run.begin(), of_run.end());
  BecomePython("identify.excite._program", words, program.host);
}

}  // namespace

void AddExcite(CLI::App& app, Program& program) {
  const auto [excite, flags] =
      AddCommand(app, program, "excite",
                 "Design a motion whose log tells of friction, a load or the links", &Excite);
  flags.command = &excite;
  excite.allow_extras();
  HandedOver& design = flags.design;
  design.Add(excite, "--for KIND", "What the log is to tell: friction, load or inertia")
      ->required();
  design.Add(excite, "--scenario FILE",
             "The robot and what stands around it (default: an arm with its hand over the floor)");
  design.Add(excite, "--limits FILE", "Lab whose limits the motion keeps");
  design.Add(excite, "--seconds S=40", "Duration");
  design.Add(excite, "--terms N=5", "Harmonics of each joint");
  design.Add(excite, "--speed SHARE=0.5",
             "Share of the joints' limits of velocity, acceleration and jerk");
  design.Add(excite, "--noise NM=0.05",
             "Standard deviation of the torque sensors, for what is to be expected");
  design.Add(excite, "--seed N=1", "Of the search");
  design.Add(excite, "--out DIR", "Folder of trajectory, scenarios and what is to be expected");
  excite.add_flag("--run", flags.run,
                  "Run it then; other flags are those of run: --backend fci --robot HOST");
}

}  // namespace twin::cli
