#include <filesystem>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "twin/record/export_csv.h"

namespace twin::cli {
namespace {

struct ExportFlags {
  std::filesystem::path log;
  std::filesystem::path out;  ///< empty: csv beside the log
};

int Export(const ExportFlags& flags, const Program& /*program*/) {
  const std::filesystem::path out = flags.out.empty() ? flags.log.parent_path() / "csv" : flags.out;
  const record::CsvExport exported = record::ExportCsv(flags.log, out);
  Say(stdout, fmt::format("{}: {} cycles, {} ticks, {} events\n", out.string(), exported.cycles,
                          exported.ticks, exported.events));
  if (exported.truncated) {
    Say(stdout, "note: the run was killed before its log was finished; the last part is missing\n");
  }
  FinishOutput();
  return kOk;
}

}  // namespace

void AddExport(CLI::App& app, Program& program) {
  const auto [exported, flags] =
      AddCommand(app, program, "export", "Write a log as CSV tables", &Export);
  Add(exported, "log FILE", flags.log, "Log of a run (run.mcap)")->required();
  Add(exported, "--out DIR", flags.out, "Folder of the tables (default: csv beside the log)");
}

}  // namespace twin::cli
