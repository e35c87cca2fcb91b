#include "twin/loop/robot_listener.h"

#include <algorithm>
#include <utility>

namespace twin::loop {
namespace {

constexpr Duration kSilenceTimeout = std::chrono::seconds(1);

/// Reads and counts states on the listening thread.
class Listener {
 public:
  Listener(const MonotonicClock& clock, backend::Backend& backend, rt::Arrival& arrival,
           const ListenSettings& settings, ListenReport& report)
      : clock_(clock), backend_(backend), arrival_(arrival), settings_(settings), report_(report) {}

  void Run() noexcept {
    Time limit = clock_.Now() + kSilenceTimeout;
    Time read{};
    for (Time now = clock_.Now(); now < limit; now = clock_.Now()) {
      switch (backend_.Read(
          report_.states == 0 ? backend::ReadRule::kFresh : backend::ReadRule::kNewest, state_,
          read)) {
        case backend::ReadResult::kLost: return;
        case backend::ReadResult::kPending: static_cast<void>(arrival_.AwaitUntil(limit)); continue;
        case backend::ReadResult::kState: Count(read); break;
      }
      if (read - first_read_ >= settings_.span) break;
      limit = read + kSilenceTimeout;
    }
    if (report_.last.message_id > first_id_) {
      report_.rate_hz = static_cast<double>(report_.last.message_id - first_id_) /
                        ToSeconds(last_read_ - first_read_);
    }
  }

 private:
  void Count(Time read) noexcept {
    if (report_.states == 0) {
      first_id_ = state_.message_id;
      first_read_ = read;
    } else {
      const std::uint64_t cycles = state_.message_id - report_.last.message_id;
      report_.lost += cycles - 1;
      const Duration deviation = read - last_read_ - kCycle;
      const Duration magnitude = std::max(deviation, -deviation);
      report_.deviation.Add(magnitude);
      if (cycles == 1 && magnitude <= settings_.tolerance) ++report_.in_time;
    }
    ++report_.states;
    report_.last = state_;
    last_read_ = read;
  }

  const MonotonicClock& clock_;
  backend::Backend& backend_;
  rt::Arrival& arrival_;
  const ListenSettings& settings_;
  ListenReport& report_;
  RobotState state_;
  std::uint64_t first_id_ = 0;
  Time first_read_{};
  Time last_read_{};
};

}  // namespace

double ListenReport::success_rate() const noexcept {
  if (states < 2) return 0;
  return static_cast<double>(in_time) / static_cast<double>(states - 1 + lost);
}

ListenReport ListenToRobot(const MonotonicClock& clock, backend::Backend& backend,
                           rt::Arrival& arrival, const ListenSettings& settings) {
  ListenReport report;
  Listener listener(clock, backend, arrival, settings, report);
  rt::StartedThread started = rt::StartThread(
      settings.thread, [&listener](const std::stop_token& /*stop*/) { listener.Run(); });
  started.thread.join();
  report.notices = std::move(started.notices);
  return report;
}

}  // namespace twin::loop
