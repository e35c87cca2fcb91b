#include "twin/sweep/merge.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sweep/left_aside.h"
#include "sweep/page.h"
#include "sweep/survival.h"
#include "twin/core/content_hash.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/core/proportion.h"
#include "twin/core/text.h"
#include "twin/record/partial_file.h"
#include "twin/run/result_folder.h"
#include "twin/run/summary.h"
#include "twin/sweep/shard.h"

namespace twin::sweep {
namespace {

namespace fs = std::filesystem;

/// A table, a row after the other. RFC 4180.
class Table {
 public:
  explicit Table(const fs::path& path) : file_(path, record::PartialFile::Leftover::kRemove) {}

  void Add(std::string_view row) {
    constexpr std::size_t kMost = 1 << 16;
    text_ += row;
    text_ += "\r\n";
    if (text_.size() >= kMost) Flush();
  }
  void Finish() {
    Flush();
    file_.Commit();
  }

 private:
  void Flush() {
    file_.Write(std::as_bytes(std::span(text_)));
    text_.clear();
  }

  record::PartialFile file_;
  std::string text_;
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

/// The table of runs.
class RunTable {
 public:
  RunTable(const Sweep& sweep, const fs::path& out) : sweep_(sweep), table_(out / "runs.csv") {
    table_.Add("point,seed" + AxisColumns(sweep) +
               ",outcome,error,cycles_served,cycles_held,final_error_rad,deviation_rad,"
               "deviation_m,duration_s,states_hash,address");
  }

  void Add(const Case& one, const Result& result) {
    table_.Add(fmt::format("{},{}{},{},{},{},{},{},{},{},{:.3f},{},{}", one.point + 1, one.seed,
                           ValueColumns(sweep_, one.values), result.outcome, CsvField(result.error),
                           result.served, result.held, NumberField(result.final_error_rad),
                           NumberField(result.deviation_rad), NumberField(result.deviation_m),
                           result.duration_s, result.states_hash, result.address));
  }
  void Finish() { table_.Finish(); }

 private:
  const Sweep& sweep_;
  Table table_;
};

/// A row per point.
void WritePoints(const Sweep& sweep, const Merged& merged, const fs::path& out) {
  Table table(out / "points.csv");
  table.Add("point" + AxisColumns(sweep) + ",runs,failures,failure_share,least,most");
  for (std::uint64_t point = 0; point < merged.points.size(); ++point) {
    const PointShare& share = merged.points[point];
    table.Add(fmt::format("{}{},{},{},{:.6f},{:.6f},{:.6f}", point + 1,
                          ValueColumns(sweep, sweep.ValuesAt(point)), share.runs, share.failures,
                          share.share(), share.least, share.most));
  }
  table.Finish();
}

/// Reads the results in order.
class Reader {
 public:
  Reader(const Sweep& sweep, const run::RunFiles& files, const fs::path& out)
      : sweep_(sweep), maker_(sweep, files), out_(out), table_(sweep, out), survival_(sweep) {}

  Merged Read() {
    merged_.points.reserve(sweep_.points());
    for (std::uint64_t point = 0; point < sweep_.points(); ++point) ReadPoint(point);
    read_.Sort();
    not_needed_.Sort();
    merged_.left_aside = CountLeftAside(out_, read_, not_needed_);
    RequireAll();
    merged_.survival = survival_.Curves();
    merged_.digest = digest_.Hex().substr(0, 16);
    table_.Finish();
    return std::move(merged_);
  }

 private:
  void ReadPoint(std::uint64_t point) {
    PointShare share;
    const std::uint64_t seeds = sweep_.file().seeds;
    for (std::uint64_t i = 0; i < seeds; ++i) {
      const std::uint64_t run = point * seeds + i;
      const Case one = sweep_.CaseAt(run);
      const std::string address = maker_.AddressOf(one);
      std::optional<Result> result = ReadResult(FileOf(out_, address), address);
      if (!result) {
        if (missing_++ == 0) first_ = fmt::format("{}, seed {}", sweep_.NameOf(one), one.seed);
        continue;
      }
      ++share.runs;
      share.failures += result->succeeded() ? 0 : 1;
      Take(run, one, std::move(*result));
      if (share.runs == i + 1 && EndsPoint(sweep_, share.runs, share.failures)) {
        for (std::uint64_t rest = run + 1; rest < (point + 1) * seeds; ++rest) {
          not_needed_.Add(maker_.AddressOf(sweep_.CaseAt(rest)));
        }
        break;
      }
    }
    if (share.runs > 0) {
      std::tie(share.least, share.most) =
          WilsonInterval(static_cast<int>(share.failures), static_cast<int>(share.runs));
    }
    merged_.runs += share.runs;
    merged_.failures += share.failures;
    merged_.points.push_back(share);
  }

  void Take(std::uint64_t run, const Case& one, Result&& result) {
    read_.Add(result.address);
    digest_.Add(result.address);
    digest_.Add(result.states_hash);
    digest_.Add(result.outcome);
    table_.Add(one, result);
    survival_.Add(one, result);
    if (!result.succeeded()) KeepIfWorst({run, std::move(result)});
  }

  /// Of equal ones the first.
  void KeepIfWorst(Row&& row) {
    constexpr std::size_t kMost = 10;
    const auto distance = [](const Row& of) { return of.result.final_error_rad.value_or(0); };
    std::vector<Row>& worst = merged_.worst;
    const auto at =
        std::ranges::upper_bound(worst, distance(row), std::ranges::greater(), distance);
    if (at == worst.end() && worst.size() == kMost) return;
    worst.insert(at, std::move(row));
    if (worst.size() > kMost) worst.pop_back();
  }

  void RequireAll() const {
    if (missing_ == 0) return;
    throw Error(
        fmt::format("{} of {} runs are missing in {}, the first: {}; sweep run carries them out{}",
                    missing_, missing_ + merged_.runs, out_.string(), first_,
                    merged_.left_aside.count() == 0
                        ? ""
                        : fmt::format("; other results there: {}", merged_.left_aside.Text())));
  }

  const Sweep& sweep_;
  CaseMaker maker_;
  const fs::path& out_;
  RunTable table_;
  SurvivalCount survival_;
  Merged merged_;
  ContentHash digest_;
  AddressSet read_;
  AddressSet not_needed_;
  std::uint64_t missing_ = 0;
  std::string first_;
};

std::string SummaryOf(const Sweep& sweep, const Merged& merged) {
  const auto& least = sweep.file().least_success_percent;
  return run::TextOf({{"sweep", sweep.file().name},
                      {"points", merged.points.size()},
                      {"runs", merged.runs},
                      {"failures", merged.failures},
                      {"success_percent", merged.success_percent()},
                      {"wanted_success_percent",
                       least ? nlohmann::ordered_json(*least) : nlohmann::ordered_json()},
                      {"digest", merged.digest},
                      {"version", TWIN_VERSION},
                      {"libm", FormatHash(LibmFingerprint())}});
}

}  // namespace

Merged Merge(const Sweep& sweep, const run::RunFiles& files, const fs::path& out) {
  run::MakeFolder(out);
  Merged merged = Reader(sweep, files, out).Read();
  std::error_code none;
  fs::remove_all(out / "worst", none);
  if (!merged.worst.empty()) run::MakeFolder(out / "worst");
  for (const Row& row : merged.worst) {
    run::WriteWholeFile(out / "worst" / (row.result.address + ".yaml"),
                        scenario::ToYaml(sweep.ScenarioOf(sweep.CaseAt(row.run))));
  }
  WritePoints(sweep, merged, out);
  run::WriteWholeFile(out / "report.html", PageOf(sweep, merged, out));
  run::WriteWholeFile(out / "summary.json", SummaryOf(sweep, merged));
  return merged;
}

}  // namespace twin::sweep
