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
  CLI::App* exported = app.add_subcommand("export", "Write a log as CSV tables");
  ExportFlags& flags = SetAction(*exported, program, &Export);
  exported->add_option("log", flags.log, "Log of a run (run.mcap)")->required()->type_name("FILE");
  exported->add_option("--out", flags.out, "Folder of the tables (default: csv beside the log)")
      ->type_name("DIR");
}

}  // namespace twin::cli
