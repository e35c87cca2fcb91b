#include <filesystem>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/result_folder.h"
#include "cli/say.h"
#include "twin/core/error.h"
#include "twin/core/error_catalogue.h"
#include "twin/onboard/mode_table.h"
#include "twin/report/explanation.h"

namespace twin::cli {
namespace {

namespace fs = std::filesystem;

/// The log that the user means: a file, or a run's folder, whose log may not be whole.
fs::path LogOf(const fs::path& named) {
  std::error_code error;
  if (!fs::is_directory(named, error)) return named;
  const ResultFolder results(named);
  if (fs::exists(results.log(), error)) return results.log();
  fs::path partial = PartialOf(results.log());
  if (fs::exists(partial, error)) return partial;
  throw InputError(fmt::format(
      "{} holds no {}; name a run's log, or the folder of a run that kept one (record: true)",
      named.string(), results.log().filename().string()));
}

fs::path FolderOf(const ExplainFlags& flags, const fs::path& log) {
  if (flags.out.empty()) return log.has_parent_path() ? log.parent_path() : fs::path(".");
  std::error_code error;
  fs::create_directories(flags.out, error);
  if (!error) return flags.out;
  throw EnvironmentError(fmt::format("cannot create folder {}: {}; choose another one",
                                     flags.out.string(), error.message()));
}

}  // namespace

ExitCode ExplainCommand(const ExplainFlags& flags) {
  if (flags.errors || flags.modes) {
    Say(stdout, flags.errors ? ErrorCatalogue() : onboard::ModeTable());
    FinishOutput();
    return kOk;
  }
  const fs::path log = LogOf(flags.log);
  const report::Explanation explanation = report::Explain(log);
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
