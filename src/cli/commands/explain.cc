#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "twin/core/error.h"
#include "twin/core/error_catalogue.h"
#include "twin/onboard/mode_table.h"
#include "twin/record/log_reader.h"
#include "twin/report/explanation.h"
#include "twin/run/result_folder.h"
#include "twin/run/summary.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

struct ExplainFlags {
  std::filesystem::path log;            ///< or a run's folder; empty with errors or modes
  std::filesystem::path out;            ///< of the page; empty: beside the log
  std::optional<std::uint64_t> motion;  ///< absent: the first error
  bool errors = false;                  ///< the catalogue of errors instead
  bool modes = false;                   ///< what the robot grants in which mode instead
};

namespace fs = std::filesystem;

fs::path FolderOf(const ExplainFlags& flags, const fs::path& log) {
  if (flags.out.empty()) return log.has_parent_path() ? log.parent_path() : fs::path(".");
  run::MakeFolder(flags.out);
  return flags.out;
}

/// Nothing for a scenario that this version does not read.
std::optional<report::ScenarioFacts> FactsOf(const fs::path& log) {
  const record::LogReader reader(log);
  try {
    return run::FactsOf(scenario::Parse(reader.run().scenario_yaml, log));
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// Takes gnuplot along when the user wants to end.
report::Explanation Explained(const fs::path& log, std::optional<std::uint64_t> motion) {
  const InterruptGuard interrupt;
  try {
    return report::Explain(log, FactsOf(log), motion);
  } catch (const EnvironmentError&) {
    interrupt.ThrowIfInterrupted();
    throw;
  }
}

int Explain(const ExplainFlags& flags, const Program& /*program*/) {
  if (flags.log.empty() && !flags.errors && !flags.modes) {
    throw CLI::RequiredError("log, --errors or --modes");
  }
  if (flags.errors || flags.modes) {
    Say(stdout, flags.errors ? ErrorCatalogue() : onboard::ModeTable());
    FinishOutput();
    return kOk;
  }
  const fs::path log = run::FindLog(flags.log);
  const report::Explanation explanation = Explained(log, flags.motion);
  std::string text = explanation.text;
  if (explanation.aborted) {
    const fs::path page = run::ResultFolder(FolderOf(flags, log)).explanation();
    run::WriteWholeFile(page, explanation.page);
    text += fmt::format("  {:<13}{}\n", "page", page.string());
  }
  Say(stdout, text);
  FinishOutput();
  return kOk;
}

}  // namespace

void AddExplain(CLI::App& app, Program& program) {
  const auto [explain, flags] =
      AddCommand(app, program, "explain", "Say how a run ended, and why", &Explain);
  CLI::Option* log =
      Add(explain, "log FILE|DIR", flags.log, "Log of a run, or its folder of results");
  Add(explain, "--out DIR", flags.out, "Folder of the page (default: beside the log)");
  Add(explain, "--motion N", flags.motion,
      "The errors of this motion, counted from 1 over the log (default: the first error)");
  CLI::Option* errors = explain.add_flag("--errors", flags.errors,
                                         "Print all errors of the robot's controller (Markdown)");
  errors->excludes(log);
  explain.add_flag("--modes", flags.modes, "Print what the robot grants in which mode (Markdown)")
      ->excludes(log)
      ->excludes(errors);
}

}  // namespace twin::cli
