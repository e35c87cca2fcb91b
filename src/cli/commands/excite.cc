#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/python_package.h"

namespace twin::cli {
namespace {

struct ExciteFlags {
  std::string kind;
  std::string scenario;
  std::string limits;
  std::string seconds;
  std::string terms;
  std::string speed;
  std::string noise;
  std::string seed;
  std::string out;
  bool run = false;
  CLI::App* command = nullptr;  ///< has the flags for `run`
};

/// The design is the Python package's.
int Excite(const ExciteFlags& flags, const Program& program) {
  std::vector<std::string> words;
  AddFlag("--for", flags.kind, words);
  AddFlag("--scenario", flags.scenario, words);
  AddFlag("--limits", flags.limits, words);
  AddFlag("--seconds", flags.seconds, words);
  AddFlag("--terms", flags.terms, words);
  AddFlag("--speed", flags.speed, words);
  AddFlag("--noise", flags.noise, words);
  AddFlag("--seed", flags.seed, words);
  AddFlag("--out", flags.out, words);
  if (flags.run) words.emplace_back("--run");
  if (program.is_quiet()) words.emplace_back("--quiet");
  const std::vector<std::string> of_run = flags.command->remaining();
  words.insert(words.end(), of_run.begin(), of_run.end());
  BecomePython("identify._excite_program", words, program.host);
}

}  // namespace

void AddExcite(CLI::App& app, Program& program) {
  const auto [excite, flags] =
      AddCommand(app, program, "excite",
                 "Design a motion whose log tells of friction, a load or the links", &Excite);
  flags.command = &excite;
  excite.allow_extras();
  Add(excite, "--for KIND", flags.kind, "What the log is to tell: friction, load or inertia")
      ->required();
  Add(excite, "--scenario FILE", flags.scenario,
      "The robot and what stands around it (default: an arm with its hand over the floor)");
  Add(excite, "--limits FILE", flags.limits, "Lab whose limits the motion keeps");
  Add(excite, "--seconds S=40", flags.seconds, "Duration");
  Add(excite, "--terms N=5", flags.terms, "Harmonics of each joint");
  Add(excite, "--speed SHARE=0.5", flags.speed,
      "Share of the joints' limits of velocity, acceleration and jerk");
  Add(excite, "--noise NM=0.05", flags.noise,
      "Standard deviation of the torque sensors, for what is to be expected");
  Add(excite, "--seed N=1", flags.seed, "Of the search");
  Add(excite, "--out DIR", flags.out, "Folder of trajectory, scenarios and what is to be expected");
  excite.add_flag("--run", flags.run,
                  "Run it then; other flags are those of run: --backend fci --robot HOST");
}

}  // namespace twin::cli
