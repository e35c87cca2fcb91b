#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/say.h"
#include "twin/record/export_csv.h"

namespace twin::cli {

ExitCode ExportCommand(const ExportFlags& flags) {
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

}  // namespace twin::cli
