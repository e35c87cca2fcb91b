#include "twin/golden/page.h"

#include <cstdint>
#include <variant>

#include "twin/record/log_reader.h"

namespace twin::golden {
namespace {

void Halve(std::vector<double>& values) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); i += 2) values[kept++] = values[i];
  values.resize(kept);
}

void Halve(JointCurves& curves) {
  Halve(curves.t);
  for (std::size_t joint = 0; joint < kJoints; ++joint) {
    Halve(curves.q[joint]);
    Halve(curves.q_d[joint]);
  }
}

}  // namespace

JointCurves ReadJointCurves(const std::filesystem::path& log) {
  record::LogReader reader(log);
  JointCurves curves;
  std::uint64_t every = 1;
  std::uint64_t cycles = 0;
  record::LogEntry entry;
  while (reader.Next(entry)) {
    const auto* cycle = std::get_if<record::CycleRecord>(&entry);
    if (cycle == nullptr || cycles++ % every != 0) continue;
    curves.t.push_back(ToSeconds(cycle->at.time_since_epoch()));
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      curves.q[joint].push_back(cycle->state.q[joint]);
      curves.q_d[joint].push_back(cycle->state.q_d[joint]);
    }
    if (curves.t.size() < 2 * JointCurves::kMostPoints) continue;
    Halve(curves);
    every *= 2;
  }
  while (curves.t.size() > JointCurves::kMostPoints) Halve(curves);
  return curves;
}

}  // namespace twin::golden
