#include "sweep/survival.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace twin::sweep {
namespace {

bool IsGrouped(const Sweep& sweep) {
  constexpr std::uint64_t kMost = 8;
  const scenario::SweepAxis& first = sweep.file().axes.front();
  if (first.draw || sweep.file().samples) return false;
  return (first.range ? first.range->steps : first.values.size()) <= kMost;
}

}  // namespace

SurvivalCount::SurvivalCount(const Sweep& sweep) : sweep_(sweep), is_grouped_(IsGrouped(sweep)) {}

void SurvivalCount::Add(const Case& one, const Result& result) {
  const std::string label = is_grouped_ ? sweep_.LabelOf(0, one.values.front()) : "all runs";
  auto group = std::ranges::find(groups_, label, &Group::label);
  if (group == groups_.end()) group = groups_.insert(group, {.label = label});
  ++group->runs;
  group->end_s = std::max(group->end_s, result.duration_s);
  if (!result.succeeded()) ++group->failures[std::llround(1e3 * result.duration_s)];
}

std::vector<SurvivalCurve> SurvivalCount::Curves() const {
  std::vector<SurvivalCurve> curves;
  for (const Group& group : groups_) {
    SurvivalCurve curve{
        .label = group.label, .runs = group.runs, .failures = 0, .end_s = group.end_s, .steps = {}};
    for (const auto& [time, failures] : group.failures) {
      curve.failures += failures;
      curve.steps.push_back(
          {static_cast<double>(time) / 1e3,
           1 - static_cast<double>(curve.failures) / static_cast<double>(curve.runs)});
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace twin::sweep
