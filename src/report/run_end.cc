#include "report/run_end.h"

#include <deque>
#include <string_view>
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
  explicit EndCollector(const record::RunInfo& run) : ticks_(2 * kTicks) {
    end_.run = run;
    BeginApproach();
  }

  void operator()(const record::CycleRecord& cycle) {
    any_ = true;
    end_.end = ToSeconds(cycle.at.time_since_epoch());
    end_.moved = end_.moved || cycle.state.motion_generator_mode != MotionGeneratorMode::kIdle;
    const bool moves = cycle.state.robot_mode == RobotMode::kMove;
    if (moves && !moved_before_) {
      ++end_.number;
      end_.begin = end_.end;
    }
    moved_before_ = moves;
    end_.fates_told = end_.fates_told || cycle.fate != record::CommandFate::kNone;
    const bool running = end_.last_word.starts_with("started");
    if (running && !end_.user_stopped && cycle.state.robot_mode == RobotMode::kUserStopped) {
      end_.user_stopped = end_.end;
    }
    cycles_.push_back(cycle);
    if (cycles_.size() > RunEnd::kShown + 1) cycles_.pop_front();
    const bool has_error = cycle.state.errors.any();
    if (has_error && !had_error_) AddAbort();
    had_error_ = has_error;
    if (!has_error) end_.approach.Add(cycle);
  }

  void operator()(const record::TickRecord& tick) {
    end_.has_ticks = true;
    end_.filter.Add(tick);
    if (WroteCommand(tick)) {
      any_command_ = true;
      any_cost_ = any_cost_ || tick.written != tick.read;
    }
    while (answered_ < aborts_.size() &&
           tick.message_id > aborts_[answered_].last().state.message_id + kTicks) {
      AddAnswers(aborts_[answered_++]);
    }
    ticks_[tick.message_id % ticks_.size()] = tick;
  }

  void operator()(const record::EventRecord& event) {
    if (event.kind == "motion") {
      end_.last_word = event.text;
      AddGuard(event.text);
    }
    if (event.kind == "session") end_.motion = event.text;
    if (event.kind != "contact") return;
    for (RunEnd& abort : aborts_) {
      if (abort.last().at == event.at) abort.contacts = event.text;
    }
  }

  void operator()(const record::SceneRecord& /*scene*/) {}
  void operator()(const record::PlanRecord& /*plan*/) {}

  [[nodiscard]] bool any() const { return any_; }

  /// Combines cycles and answers, and tells each abort what is known of the whole run.
  [[nodiscard]] std::vector<RunEnd> Finish(bool truncated) {
    // On the robot's time answers take no time; on a clock, each takes some.
    end_.on_robot_time = end_.is_remote() && any_command_ && !any_cost_;
    end_.truncated = truncated;
    end_.aborts = aborts_.size();
    while (answered_ < aborts_.size()) AddAnswers(aborts_[answered_++]);
    if (aborts_.empty()) aborts_.push_back(end_);
    for (RunEnd& abort : aborts_) {
      RunEnd whole = end_;
      whole.number = abort.number;
      whole.begin = abort.begin;
      whole.guard = std::move(abort.guard);
      whole.motion = std::move(abort.motion);
      whole.contacts = std::move(abort.contacts);
      whole.cycles = std::move(abort.cycles);
      whole.approach = abort.approach;
      abort = std::move(whole);
    }
    return std::move(aborts_);
  }

 private:
  void BeginApproach() {
    end_.approach = end_.run.limits ? ApproachTracker(*end_.run.limits) : ApproachTracker();
  }

  /// Of the last cycle.
  void AddAbort() {
    RunEnd& abort = aborts_.emplace_back();
    abort.number = end_.number;
    abort.begin = end_.begin;
    abort.motion = end_.motion;
    abort.approach = end_.approach;
    for (const record::CycleRecord& cycle : cycles_) abort.cycles.push_back({cycle, std::nullopt});
    BeginApproach();
  }

  /// From a server's line about the motion that has just ended.
  void AddGuard(std::string_view line) {
    constexpr std::string_view kGuard = " Guard: ";
    const std::size_t at = line.find(kGuard);
    if (at == std::string_view::npos || aborts_.empty()) return;
    aborts_.back().guard = line.substr(at + kGuard.size());
  }

  void AddAnswers(RunEnd& abort) const {
    for (EndCycle& cycle : abort.cycles) {
      const std::uint64_t answered = cycle.cycle.state.message_id - 1;
      const auto& tick = ticks_[answered % ticks_.size()];
      if (tick && tick->message_id == answered) cycle.answer = tick;
    }
  }

  RunEnd end_;                  ///< of the whole run so far; cycles stay empty
  std::vector<RunEnd> aborts_;  ///< with what differs between them
  std::size_t answered_ = 0;    ///< number of aborts whose cycles have their answers
  std::vector<std::optional<record::TickRecord>> ticks_;  ///< slot = message_id modulo size
  std::deque<record::CycleRecord> cycles_;
  bool moved_before_ = false;
  bool had_error_ = false;
  bool any_ = false;
  bool any_command_ = false;  ///< a tick wrote a command
  bool any_cost_ = false;     ///< such a tick took time
};

}  // namespace

std::vector<RunEnd> ReadEnds(const std::filesystem::path& log) {
  record::LogReader reader(log);
  EndCollector collector(reader.run());
  record::LogEntry entry;
  while (reader.Next(entry)) std::visit(collector, entry);
  if (!collector.any()) {
    throw InputError(fmt::format(
        "{} holds no cycle of the robot, so there is nothing to explain; name the log of a run "
        "that began",
        log.string()));
  }
  return collector.Finish(reader.truncated());
}

}  // namespace twin::report
