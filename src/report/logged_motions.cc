#include "twin/report/logged_motions.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/record/cycle_record.h"
#include "twin/record/log_reader.h"

namespace twin::report {
namespace {

/// Visitor of a log's records.
class SessionCollector {
 public:
  void operator()(const record::CycleRecord& cycle) {
    const bool moves = cycle.state.robot_mode == RobotMode::kMove;
    if (moves && !moved_) session.motions.emplace_back().begin = cycle.at;
    if (moves) {
      Add(cycle, session.motions.back());
    } else if (moved_) {
      LoggedMotion& motion = session.motions.back();
      motion.errors = cycle.state.errors;
      motion.is_user_stopped = cycle.state.robot_mode == RobotMode::kUserStopped;
    }
    moved_ = moves;
  }
  void operator()(const record::EventRecord& event) { session.events.push_back(event); }
  template <class Other>
  void operator()(const Other& /*record*/) {}

  LoggedSession session;

 private:
  static void Add(const record::CycleRecord& cycle, LoggedMotion& motion) {
    const RobotState& state = cycle.state;
    motion.end = cycle.at;
    if (state.motion_generator_mode != MotionGeneratorMode::kIdle) {
      motion.generator = state.motion_generator_mode;
      motion.controller = state.controller_mode;
    }
    motion.served += cycle.fate == record::CommandFate::kServed ? 1 : 0;
    motion.held += cycle.fate == record::CommandFate::kHeld ? 1 : 0;
    motion.longest_loss = std::max(motion.longest_loss, cycle.lost_in_row);
    double error = motion.peak_error.value_or(0);
    for (std::size_t i = 0; i < kJoints; ++i) {
      error = std::max(error, std::abs(state.q_d[i] - state.q[i]));
      motion.peak_speed = std::max(motion.peak_speed, std::abs(state.dq[i]));
    }
    if (state.controller_mode != ControllerMode::kExternalController) motion.peak_error = error;
  }

  bool moved_ = false;  ///< in the previous cycle
};

/// "127.0.0.1:4033" of "arm: 127.0.0.1:4033 connected; ..."; empty for other lines.
std::string_view ConnectedTo(std::string_view line) {
  constexpr std::string_view kArm = "arm: ";
  if (!line.starts_with(kArm)) return {};
  const std::string_view text = line.substr(kArm.size());
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos) return {};
  return text.substr(space).starts_with(" connected") ? text.substr(0, space) : std::string_view();
}

/// The last motion that began before an event; null: none.
LoggedMotion* LastBefore(std::vector<LoggedMotion>& motions, Time at) {
  const auto next = std::ranges::lower_bound(motions, at, {}, &LoggedMotion::begin);
  return next == motions.begin() ? nullptr : &*std::prev(next);
}

void TellClients(LoggedSession& session) {
  std::string client;
  auto event = session.events.begin();
  for (LoggedMotion& motion : session.motions) {
    for (; event != session.events.end() && event->at <= motion.begin; ++event) {
      if (event->kind != "client") continue;
      const std::string_view connected = ConnectedTo(event->text);
      if (!connected.empty()) client = connected;
    }
    motion.client = client;
  }
}

void TellEnds(LoggedSession& session) {
  for (const record::EventRecord& event : session.events) {
    if (event.kind != "motion" || event.text.starts_with("started")) continue;
    LoggedMotion* motion = LastBefore(session.motions, event.at);
    if (motion != nullptr && motion->how.empty()) motion->how = event.text;
  }
  for (LoggedMotion& motion : session.motions) {
    if (!motion.how.empty()) continue;
    motion.how = motion.errors.any() ? FormatErrors(motion.errors) : "ended";
  }
}

}  // namespace

LoggedSession ReadSession(const std::filesystem::path& log) {
  record::LogReader reader(log);
  SessionCollector collector;
  record::LogEntry entry;
  while (reader.Next(entry)) std::visit(collector, entry);
  LoggedSession session = std::move(collector.session);
  std::ranges::stable_sort(session.events, {}, &record::EventRecord::at);
  TellClients(session);
  TellEnds(session);
  return session;
}

}  // namespace twin::report
