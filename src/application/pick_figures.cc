#include "application/pick_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <variant>

#include "twin/core/modes.h"
#include "twin/record/log_reader.h"

namespace twin::application {
namespace {

constexpr std::uint64_t kSampleCycles = 5;

/// Takes the states of a log one after the other.
class Collector {
 public:
  Collector(const JointLimits& limits, PickTrace& trace) : limits_(limits), trace_(trace) {}

  void operator()(const rt::CycleRecord& cycle) {
    const RobotState& state = cycle.state;
    if (state.robot_mode == RobotMode::kMove) {
      for (std::size_t i = 0; i < kJoints; ++i) {
        velocity_ = std::max(velocity_, std::abs(state.dq_d[i]) / limits_.dq_max[i]);
        acceleration_ = std::max(acceleration_, std::abs(state.ddq_d[i]) / limits_.ddq_max[i]);
        jerk_ = std::max(jerk_, std::abs(cycle.dddq_d[i]) / limits_.dddq_max[i]);
      }
    }
    if (cycles_++ % kSampleCycles != 0) return;
    trace_.t.push_back(ToSeconds(cycle.at.time_since_epoch()));
    for (std::size_t i = 0; i < 3; ++i) trace_.p[i].push_back(state.O_T_EE[12 + i]);
    trace_.velocity.push_back(std::exchange(velocity_, 0));
    trace_.acceleration.push_back(std::exchange(acceleration_, 0));
    trace_.jerk.push_back(std::exchange(jerk_, 0));
    trace_.force.push_back(-state.O_F_ext_hat_K[2]);
  }
  template <typename Other>
  void operator()(const Other& /*record*/) {}

 private:
  const JointLimits& limits_;
  PickTrace& trace_;
  std::uint64_t cycles_ = 0;
  double velocity_ = 0;
  double acceleration_ = 0;
  double jerk_ = 0;
};

}  // namespace

PickTrace ReadPickTrace(const std::filesystem::path& log, const JointLimits& limits) {
  PickTrace trace;
  record::LogReader reader(log);
  Collector collector(limits, trace);
  record::LogEntry entry;
  while (reader.Next(entry)) std::visit(collector, entry);
  return trace;
}

std::vector<report::Figure> PickFigures(const PickTrace& trace, const plant::ObjectTrack* track) {
  if (trace.t.empty()) return {};
  report::Figure path{.id = "path", .columns = "t [s],x [m],y [m],z [m]"};
  report::Figure limits{.id = "limits", .columns = "t [s],velocity,acceleration,jerk"};
  report::Figure force{.id = "force", .columns = "t [s],force [N]"};
  for (std::size_t i = 0; i < trace.t.size(); ++i) {
    const double t = trace.t[i];
    path.rows.push_back({t, trace.p[0][i], trace.p[1][i], trace.p[2][i]});
    limits.rows.push_back({t, trace.velocity[i], trace.acceleration[i], trace.jerk[i]});
    force.rows.push_back({t, trace.force[i]});
  }
  report::Table object{.columns = "t [s],z [m]"};
  if (track != nullptr) {
    for (const plant::ObjectSample& sample : track->samples) {
      object.rows.push_back({ToSeconds(sample.at.time_since_epoch()), sample.X_WB[14]});
    }
  }
  path.tables["object"] = std::move(object);
  path.values["simulated"] = track == nullptr ? 0 : 1;
  return {std::move(path), std::move(limits), std::move(force)};
}

}  // namespace twin::application
