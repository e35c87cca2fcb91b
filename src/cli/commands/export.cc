#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "twin/core/error.h"
#include "twin/record/columns.h"
#include "twin/record/export_log.h"

namespace twin::cli {
namespace {

struct ExportFlags {
  std::filesystem::path log;
  std::filesystem::path out;  ///< empty: named like the format, beside the log
  std::string format = "csv";
  std::vector<std::string> columns;  ///< empty: all
  bool describes = false;
};

int Export(const ExportFlags& flags, const Program& /*program*/) {
  if (flags.describes) {
    Say(stdout, record::DescribeLogTables());
    FinishOutput();
    return kOk;
  }
  if (flags.log.empty()) throw InputError("name a log of a run (run.mcap)");
  if (flags.format == "parquet") {
    throw InputError(fmt::format(
        "--format: this program does not write Parquet, the Python package does: pip install "
        "'panda-twin[log]', then python3 -m panda_twin.parquet {}",
        flags.log.string()));
  }
  const std::filesystem::path out =
      flags.out.empty() ? flags.log.parent_path() / flags.format : flags.out;
  const record::LogExport exported = flags.format == "npz"
                                         ? record::ExportNpz(flags.log, out, flags.columns)
                                         : record::ExportCsv(flags.log, out, flags.columns);
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
      AddCommand(app, program, "export", "Write a log as tables: CSV or NumPy archives", &Export);
  Add(exported, "log FILE", flags.log, "Log of a run (run.mcap)");
  Add(exported, "--out DIR", flags.out,
      "Folder of the tables (default: named like the format, beside the log)");
  Add(exported, "--format csv|npz|parquet", flags.format,
      "csv, or npz for numpy.load; parquet tells how the Python package writes it")
      ->check(CLI::IsMember({"csv", "npz", "parquet"}).description(""))
      ->capture_default_str();
  Add(exported, "--columns NAMES", flags.columns,
      "Only these, such as q,dq,q_c; each table keeps its time")
      ->delimiter(',');
  exported.add_flag("--describe", flags.describes, "Print tables, columns and units (Markdown)");
}

}  // namespace twin::cli
