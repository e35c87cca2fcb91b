#include "sweep/survival_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace twin::sweep {
namespace {

using Json = nlohmann::ordered_json;

// The picture's coordinates; its frame has the corners (kLeft, kTop) and (kRight, kBottom).
constexpr double kLeft = 50;
constexpr double kRight = 620;
constexpr double kTop = 10;
constexpr double kBottom = 250;
constexpr double kLine = 18;  ///< from one row of text to the next

// Okabe and Ito's, which people who see few colours tell apart.
constexpr std::array<std::string_view, 8> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                   "#e69f00", "#56b4e9", "#000000", "#8a6d00"};

std::string Text(double coordinate) {
  return fmt::format("{:.1f}", coordinate);
}

/// The step between ticks, 1, 2 or 5 times a power of ten: at most eight of them up to `end`.
double TickStep(double end) {
  const double least = end / 8;
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double of : {1.0, 2.0, 5.0}) {
    if (of * power >= least) return of * power;
  }
  return 10 * power;
}

/// @param end  time at the frame's right, s.
double XOf(double time, double end) {
  return kLeft + (kRight - kLeft) * time / end;
}

double YOf(double share) {
  return kBottom - (kBottom - kTop) * share;
}

/// Steps that fall on the same place in the picture are one.
std::string PathOf(const SurvivalCurve& curve, double end) {
  std::string path = fmt::format("M{} {}", Text(kLeft), Text(YOf(1)));
  for (std::size_t i = 0; i < curve.steps.size(); ++i) {
    const std::string x = Text(XOf(curve.steps[i].time_s, end));
    const bool is_last = i + 1 == curve.steps.size();
    if (!is_last && x == Text(XOf(curve.steps[i + 1].time_s, end))) continue;
    path += fmt::format("H{}V{}", x, Text(YOf(curve.steps[i].share)));
  }
  return path + "H" + Text(kRight);
}

Json CurvesJson(const std::vector<SurvivalCurve>& curves, double end) {
  Json json = Json::array();
  double y = kTop + kLine;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const SurvivalCurve& curve = curves[i];
    json.push_back({{"label", curve.label},
                    {"failures", std::to_string(curve.failures)},
                    {"runs", std::to_string(curve.runs)},
                    {"colour", kColours[i % kColours.size()]},
                    {"path", PathOf(curve, end)},
                    {"y", Text(y)},
                    {"line_y", Text(y - 4)}});
    y += kLine;
  }
  return json;
}

Json TimeTicks(double end) {
  const double step = TickStep(end);
  Json ticks = Json::array();
  for (int i = 0; i * step <= end; ++i) {
    ticks.push_back({{"x", Text(XOf(i * step, end))}, {"text", fmt::format("{:.6g}", i * step)}});
  }
  return ticks;
}

Json ShareTicks() {
  Json ticks = Json::array();
  for (int percent = 0; percent <= 100; percent += 25) {
    ticks.push_back({{"y", Text(YOf(percent / 100.0))},
                     {"text_y", Text(YOf(percent / 100.0) + 4)},
                     {"text", std::to_string(percent)}});
  }
  return ticks;
}

}  // namespace

Json SurvivalOnPage(const Sweep& sweep, const Merged& merged) {
  double end = 0;
  for (const SurvivalCurve& curve : merged.survival) end = std::max(end, curve.end_s);
  if (merged.failures == 0 || !(end > 0)) return {};
  return {{"key", merged.survival.size() > 1 ? sweep.file().axes.front().key : ""},
          {"curves", CurvesJson(merged.survival, end)},
          {"times", TimeTicks(end)},
          {"shares", ShareTicks()}};
}

}  // namespace twin::sweep
