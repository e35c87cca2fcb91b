#include "twin/sweep/merge.h"

#include <algorithm>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sweep/page.h"
#include "twin/core/content_hash.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/core/proportion.h"
#include "twin/core/text.h"
#include "twin/run/result_folder.h"
#include "twin/run/summary.h"
#include "twin/sweep/shard.h"

namespace twin::sweep {
namespace {

namespace fs = std::filesystem;

/// Results in the folder, whatever they are of.
std::uint64_t CountResults(const fs::path& out) {
  std::uint64_t count = 0;
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(out / "runs", none)) {
    count += entry.path().extension() == ".json" ? 1 : 0;
  }
  return count;
}

/// Reads the results in order.
class Reader {
 public:
  Reader(const Sweep& sweep, const run::RunFiles& files, const fs::path& out)
      : sweep_(sweep), maker_(sweep, files), out_(out) {}

  Merged Read() {
    for (std::uint64_t point = 0; point < sweep_.points(); ++point) ReadPoint(point);
    const std::uint64_t there = CountResults(out_);
    merged_.left_aside = there - std::min(there, found_);
    RequireAll();
    ContentHash digest;
    for (const Row& row : merged_.rows) {
      digest.Add(row.result.address);
      digest.Add(row.result.states_hash);
      digest.Add(row.result.outcome);
    }
    merged_.digest = digest.Hex().substr(0, 16);
    return std::move(merged_);
  }

 private:
  void ReadPoint(std::uint64_t point) {
    PointShare share;
    const std::uint64_t seeds = sweep_.file().seeds;
    for (std::uint64_t i = 0; i < seeds; ++i) {
      const std::uint64_t run = point * seeds + i;
      const PreparedCase& prepared = maker_.Make(run);
      std::optional<Result> result = ReadResult(FileOf(out_, prepared.address), prepared.address);
      if (!result) {
        if (missing_++ == 0) {
          first_ = fmt::format("{}, seed {}", sweep_.NameOf(prepared.one), prepared.one.seed);
        }
        continue;
      }
      ++found_;
      ++share.runs;
      share.failures += result->succeeded() ? 0 : 1;
      merged_.rows.push_back({run, std::move(*result)});
      if (share.runs == i + 1 && EndsPoint(sweep_, share.runs, share.failures)) break;
    }
    if (share.runs > 0) {
      std::tie(share.least, share.most) =
          WilsonInterval(static_cast<int>(share.failures), static_cast<int>(share.runs));
    }
    merged_.failures += share.failures;
    merged_.points.push_back(share);
  }

  void RequireAll() const {
    if (missing_ == 0) return;
    throw Error(fmt::format(
        "{} of {} runs are missing in {}, the first: {}; sweep run carries them out{}", missing_,
        missing_ + found_, out_.string(), first_,
        merged_.left_aside == 0
            ? ""
            : fmt::format(" ({} results there are of another sweep, or of another version of the "
                          "program or the models)",
                          merged_.left_aside)));
  }

  const Sweep& sweep_;
  CaseMaker maker_;
  const fs::path& out_;
  Merged merged_;
  std::uint64_t found_ = 0;
  std::uint64_t missing_ = 0;
  std::string first_;
};

/// The axes as columns.
std::string AxisColumns(const Sweep& sweep) {
  std::string columns;
  for (const scenario::SweepAxis& axis : sweep.file().axes) columns += ',' + CsvField(axis.key);
  return columns;
}

std::string ValueColumns(const Sweep& sweep, const std::vector<std::string>& values) {
  std::string columns;
  for (std::size_t i = 0; i < values.size(); ++i) {
    columns += ',' + CsvField(sweep.LabelOf(i, values[i]));
  }
  return columns;
}

std::string NumberField(const std::optional<double>& number) {
  return number ? fmt::format("{:.9g}", *number) : "";
}

/// A row per run. RFC 4180, with a header.
std::string RunsCsv(const Sweep& sweep, const Merged& merged) {
  std::string csv = "point,seed" + AxisColumns(sweep) +
                    ",outcome,error,cycles_served,cycles_held,final_error_rad,deviation_rad,"
                    "deviation_m,duration_s,states_hash,address\r\n";
  for (const Row& row : merged.rows) {
    const Case one = sweep.CaseAt(row.run);
    const Result& result = row.result;
    csv += fmt::format("{},{}{},{},{},{},{},{},{},{},{:.3f},{},{}\r\n", one.point + 1, one.seed,
                       ValueColumns(sweep, one.values), result.outcome, CsvField(result.error),
                       result.served, result.held, NumberField(result.final_error_rad),
                       NumberField(result.deviation_rad), NumberField(result.deviation_m),
                       result.duration_s, result.states_hash, result.address);
  }
  return csv;
}

/// A row per point.
std::string PointsCsv(const Sweep& sweep, const Merged& merged) {
  std::string csv = "point" + AxisColumns(sweep) + ",runs,failures,failure_share,least,most\r\n";
  for (std::uint64_t point = 0; point < merged.points.size(); ++point) {
    const PointShare& share = merged.points[point];
    csv += fmt::format("{}{},{},{},{:.6f},{:.6f},{:.6f}\r\n", point + 1,
                       ValueColumns(sweep, sweep.ValuesAt(point)), share.runs, share.failures,
                       share.share(), share.least, share.most);
  }
  return csv;
}

std::string SummaryOf(const Sweep& sweep, const Merged& merged) {
  const auto& least = sweep.file().least_success_percent;
  return run::TextOf({{"sweep", sweep.file().name},
                      {"points", merged.points.size()},
                      {"runs", merged.rows.size()},
                      {"failures", merged.failures},
                      {"success_percent", merged.success_percent()},
                      {"wanted_success_percent",
                       least ? nlohmann::ordered_json(*least) : nlohmann::ordered_json()},
                      {"digest", merged.digest},
                      {"version", TWIN_VERSION},
                      {"libm", FormatHash(LibmFingerprint())}});
}

}  // namespace

Merged ReadAll(const Sweep& sweep, const run::RunFiles& files, const fs::path& out) {
  return Reader(sweep, files, out).Read();
}

void WriteMerged(const Sweep& sweep, const Merged& merged, const fs::path& out) {
  const std::vector<const Row*> worst = WorstOf(merged);
  std::error_code none;
  fs::remove_all(out / "worst", none);
  if (!worst.empty()) run::MakeFolder(out / "worst");
  for (const Row* row : worst) {
    run::WriteWholeFile(out / "worst" / (row->result.address + ".yaml"),
                        scenario::ToYaml(sweep.ScenarioOf(sweep.CaseAt(row->run))));
  }
  run::WriteWholeFile(out / "runs.csv", RunsCsv(sweep, merged));
  run::WriteWholeFile(out / "points.csv", PointsCsv(sweep, merged));
  run::WriteWholeFile(out / "report.html", PageOf(sweep, merged, out));
  run::WriteWholeFile(out / "summary.json", SummaryOf(sweep, merged));
}

}  // namespace twin::sweep
