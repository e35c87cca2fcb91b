#include <filesystem>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/result_folder.h"
#include "cli/say.h"
#include "twin/core/error.h"
#include "twin/core/error_catalogue.h"
#include "twin/onboard/mode_table.h"
#include "twin/report/explanation.h"

namespace twin::cli {
namespace {

namespace fs = std::filesystem;

fs::path FolderOf(const ExplainFlags& flags, const fs::path& log) {
  if (flags.out.empty()) return log.has_parent_path() ? log.parent_path() : fs::path(".");
  std::error_code error;
  fs::create_directories(flags.out, error);
  if (!error) return flags.out;
  throw EnvironmentError(fmt::format("cannot create folder {}: {}; choose another one",
                                     flags.out.string(), error.message()));
}

/// Takes gnuplot along when the user wants to end.
report::Explanation Explained(const fs::path& log) {
  const InterruptGuard interrupt;
  try {
    return report::Explain(log);
  } catch (const EnvironmentError&) {
    interrupt.ThrowIfInterrupted();
    throw;
  }
}

}  // namespace

ExitCode ExplainCommand(const ExplainFlags& flags) {
  if (flags.errors || flags.modes) {
    Say(stdout, flags.errors ? ErrorCatalogue() : onboard::ModeTable());
    FinishOutput();
    return kOk;
  }
  const fs::path log = FindLog(flags.log);
  const report::Explanation explanation = Explained(log);
  std::string text = explanation.text;
  if (explanation.aborted) {
    const fs::path page = ResultFolder(FolderOf(flags, log)).explanation();
    WriteWholeFile(page, explanation.page);
    text += fmt::format("  {:<13}{}\n", "page", page.string());
  }
  Say(stdout, text);
  FinishOutput();
  return kOk;
}

}  // namespace twin::cli
