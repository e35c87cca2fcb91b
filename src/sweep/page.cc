#include "sweep/page.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sweep/survival_page.h"
#include "twin/core/hash.h"
#include "twin/core/text.h"
#include "twin/report/page.h"

namespace twin::sweep {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostPoints = 1000;  ///< on the page; points.csv has all

std::string Percent(double share) {
  return fmt::format("{:.1f}", 100 * share);
}

/// From white to red. @param share  of failures, in [0, 1].
std::string ColourOf(double share) {
  const auto channel = [share](int full) { return std::lround(255 - share * (255 - full)); };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(0xc0), channel(0x27), channel(0x2d));
}

/// Indices of the axes whose values make points.
std::vector<std::size_t> AxesOfPoints(const Sweep& sweep) {
  std::vector<std::size_t> axes;
  for (std::size_t i = 0; i < sweep.file().axes.size(); ++i) {
    if (!sweep.file().axes[i].draw) axes.push_back(i);
  }
  return axes;
}

/// Columns of the last axis, rows of all others together; null unless a grid of at least two axes
/// makes the points.
Json HeatMapOf(const Sweep& sweep, const Merged& merged) {
  const std::vector<std::size_t> axes = AxesOfPoints(sweep);
  if (axes.size() < 2 || sweep.file().samples || merged.points.size() > kMostPoints) return {};
  const std::span down(axes.data(), axes.size() - 1);
  Json columns = Json::array();
  Json rows = Json::array();
  for (std::uint64_t point = 0; point < merged.points.size(); ++point) {
    const std::vector<std::string> values = sweep.ValuesAt(point);
    std::string row;
    for (const std::size_t axis : down) {
      row += (row.empty() ? "" : ", ") + sweep.LabelOf(axis, values[axis]);
    }
    if (rows.empty() || rows.back()["value"] != row) {
      rows.push_back({{"value", row}, {"cells", Json::array()}});
    }
    if (rows.size() == 1) {
      columns.push_back({{"value", sweep.LabelOf(axes.back(), values[axes.back()])}});
    }
    const double share = merged.points[point].share();
    rows.back()["cells"].push_back({{"share", Percent(share)},
                                    {"colour", ColourOf(share)},
                                    {"ink", share > 0.5 ? "#fff" : "#222"}});
  }
  std::string keys;
  for (const std::size_t axis : down) {
    keys += (keys.empty() ? "" : ", ") + sweep.file().axes[axis].key;
  }
  return {{"down", keys},
          {"across", sweep.file().axes[axes.back()].key},
          {"count", columns.size()},
          {"columns", columns},
          {"rows", rows}};
}

Json PointsOnPage(const Sweep& sweep, const Merged& merged) {
  Json points = Json::array();
  for (std::uint64_t i = 0; i < std::min(merged.points.size(), kMostPoints); ++i) {
    const PointShare& point = merged.points[i];
    Json values = Json::array();
    const std::vector<std::string> of_point = sweep.ValuesAt(i);
    for (std::size_t axis = 0; axis < of_point.size(); ++axis) {
      const std::string& value = of_point[axis];
      values.push_back({{"value", value.empty() ? "drawn" : sweep.LabelOf(axis, value)}});
    }
    points.push_back({{"number", i + 1},
                      {"values", values},
                      {"runs", std::to_string(point.runs)},
                      {"failures", std::to_string(point.failures)},
                      {"share", Percent(point.share())},
                      {"least", Percent(point.least)},
                      {"most", Percent(point.most)}});
  }
  return points;
}

Json WorstOnPage(const Sweep& sweep, const Merged& merged, const std::filesystem::path& out) {
  Json worst = Json::array();
  for (const Row& row : merged.worst) {
    const Case one = sweep.CaseAt(row.run);
    const std::filesystem::path file = out / "worst" / (row.result.address + ".yaml");
    const std::filesystem::path log = LogFolderOf(out, row.result.address) / "run.mcap";
    std::error_code none;
    worst.push_back(
        {{"point", sweep.NameOf(one)},
         {"seed", std::to_string(one.seed)},
         {"outcome", row.result.outcome},
         {"error", row.result.error},
         {"log",
          std::filesystem::exists(log, none) ? Json(log.lexically_relative(out).string()) : Json()},
         {"command", fmt::format("panda-twin run {}", InShell(file.string()))}});
  }
  return worst;
}

Json AxesOnPage(const Sweep& sweep) {
  Json axes = Json::array();
  for (const scenario::SweepAxis& axis : sweep.file().axes) axes.push_back({{"key", axis.key}});
  return axes;
}

}  // namespace

std::string PageOf(const Sweep& sweep, const Merged& merged, const std::filesystem::path& out) {
  const scenario::SweepFile& file = sweep.file();
  const auto& least = file.least_success_percent;
  const bool met = !least || merged.success_percent() >= *least;
  std::string demand;
  if (least) demand = fmt::format("; demanded {} %: {}", *least, met ? "met" : "missed");
  std::string shown;
  if (merged.points.size() > kMostPoints) {
    shown = fmt::format("The first {} of {} points; points.csv has all.", kMostPoints,
                        merged.points.size());
  }
  return report::RenderPage(
      "sweep/report", {{"title", file.name},
                       {"description", file.description},
                       {"verdict", !least ? "reported"
                                   : met  ? "met"
                                          : "failed"},
                       {"succeeded", std::to_string(merged.runs - merged.failures)},
                       {"runs", std::to_string(merged.runs)},
                       {"share", fmt::format("{:.1f}", merged.success_percent())},
                       {"demand", demand},
                       {"heat", HeatMapOf(sweep, merged)},
                       {"survival", SurvivalOnPage(sweep, merged)},
                       {"axes", AxesOnPage(sweep)},
                       {"points", PointsOnPage(sweep, merged)},
                       {"shown", shown},
                       {"failed", merged.failures > 0},
                       {"worst", WorstOnPage(sweep, merged, out)},
                       {"facts", report::FactsOf({{"digest", merged.digest},
                                                  {"scenario", file.scenario.string()},
                                                  {"points", std::to_string(merged.points.size())},
                                                  {"seeds of a point", std::to_string(file.seeds)},
                                                  {"panda-twin", TWIN_VERSION},
                                                  {"libm", FormatHash(LibmFingerprint())}})}});
}

}  // namespace twin::sweep
