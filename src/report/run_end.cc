#include "report/run_end.h"

#include <algorithm>
#include <deque>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/record/log_reader.h"

namespace twin::report {
namespace {

/// Largest distance between ticks and their cycles in a log with a ring for each.
constexpr std::size_t kTicks = 4096;

/// Visitor of a log's records.
class EndCollector {
 public:
  explicit EndCollector(RunEnd& end) : end_(end), ticks_(kTicks) {}

  void operator()(const record::CycleRecord& cycle) {
    any_ = true;
    end_.end = ToSeconds(cycle.at.time_since_epoch());
    end_.moved = end_.moved || cycle.state.motion_generator_mode != MotionGeneratorMode::kIdle;
    end_.fates_told = end_.fates_told || cycle.fate != record::CommandFate::kNone;
    const bool running = end_.last_word.starts_with("started");
    if (running && !end_.user_stopped && cycle.state.robot_mode == RobotMode::kUserStopped) {
      end_.user_stopped = end_.end;
    }
    const bool has_error = cycle.state.errors.any();
    if (has_error && !had_error_) ++end_.aborts;
    had_error_ = has_error;
    if (abort_id_) return;
    cycles_.push_back(cycle);
    if (cycles_.size() > RunEnd::kShown + 1) cycles_.pop_front();
    if (has_error) {
      abort_id_ = cycle.state.message_id;
    } else {
      end_.approach.Add(cycle);
    }
  }

  void operator()(const record::TickRecord& tick) {
    end_.has_ticks = true;
    if (WroteCommand(tick)) {
      any_command_ = true;
      any_cost_ = any_cost_ || tick.written != tick.read;
    }
    if (abort_id_ && tick.message_id >= *abort_id_) return;
    ticks_[tick.message_id % kTicks] = tick;
  }

  void operator()(const record::EventRecord& event) {
    if (event.kind == "motion") end_.last_word = event.text;
    if (event.kind == "session" && !abort_id_) end_.motion = event.text;
  }

  void operator()(const record::SceneRecord& /*scene*/) {}
  void operator()(const record::PlanRecord& /*plan*/) {}

  [[nodiscard]] bool any() const { return any_; }

  /// Combines cycles and answers.
  void Finish() {
    // On the robot's time answers take no time; on a clock, each takes some.
    end_.on_robot_time = end_.is_remote() && any_command_ && !any_cost_;
    if (!abort_id_) return;
    for (record::CycleRecord& cycle : cycles_) {
      const std::uint64_t answered = cycle.state.message_id - 1;
      const auto& tick = ticks_[answered % kTicks];
      const bool known = tick && tick->message_id == answered;
      end_.cycles.push_back({cycle, known ? tick : std::nullopt});
    }
  }

 private:
  RunEnd& end_;
  std::vector<std::optional<record::TickRecord>> ticks_;  ///< slot = message_id modulo size
  std::deque<record::CycleRecord> cycles_;
  std::optional<std::uint64_t> abort_id_;
  bool had_error_ = false;
  bool any_ = false;
  bool any_command_ = false;  ///< a tick wrote a command
  bool any_cost_ = false;     ///< such a tick took time
};

}  // namespace

RunEnd ReadEnd(const std::filesystem::path& log) {
  record::LogReader reader(log);
  RunEnd end;
  end.run = reader.run();
  if (end.run.limits) end.approach = ApproachTracker(*end.run.limits);
  EndCollector collector(end);
  record::LogEntry entry;
  while (reader.Next(entry)) std::visit(collector, entry);
  if (!collector.any()) {
    throw InputError(fmt::format(
        "{} holds no cycle of the robot, so there is nothing to explain; name the log of a run "
        "that began",
        log.string()));
  }
  end.truncated = reader.truncated();
  collector.Finish();
  return end;
}

}  // namespace twin::report
