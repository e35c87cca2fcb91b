#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands/commands.h"
#include "cli/python_package.h"
#include "cli/shared_flags.h"
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

/// Hands the command over to the Python package, which has the libraries for these formats.
[[noreturn]] void LeaveToPython(const ExportFlags& flags, const Program& program) {
  RefuseIf(flags.format == "rosbag2" && !flags.columns.empty(),
           "--columns is for tables: a bag has messages");
  std::vector<std::string> words{flags.log.string()};
  AddFlag("--out", flags.out.string(), words);
  AddFlag("--columns", fmt::format("{}", fmt::join(flags.columns, ",")), words);
  BecomePython(flags.format, words, program.host);
}

int Export(const ExportFlags& flags, const Program& program) {
  if (flags.describes) {
    Say(stdout, record::DescribeLogTables());
    FinishOutput();
    return kOk;
  }
  if (flags.log.empty()) throw InputError("name a log of a run (run.mcap)");
  if (flags.format == "parquet" || flags.format == "rosbag2") LeaveToPython(flags, program);
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
      AddCommand(app, program, "export",
                 "Write a log as tables (CSV, NumPy, Parquet) or a bag of ROS 2", &Export);
  Add(exported, "log FILE", flags.log, "Log of a run (run.mcap)");
  Add(exported, "--out DIR", flags.out,
      "Folder of the tables (default: named like the format, beside the log)");
  Add(exported, "--format csv|npz|parquet|rosbag2", flags.format,
      "csv; npz for numpy.load; parquet or a bag of ROS 2 (MCAP) by the Python package")
      ->check(CLI::IsMember({"csv", "npz", "parquet", "rosbag2"}).description(""))
      ->capture_default_str();
  Add(exported, "--columns NAMES", flags.columns,
      "Only these, such as q,dq,q_c; each table keeps its time")
      ->delimiter(',');
  exported.add_flag("--describe", flags.describes, "Print tables, columns and units (Markdown)");
}

}  // namespace twin::cli
