#include "run/drive_setting.h"

#include <algorithm>
#include <optional>

#include "run/start_check.h"
#include "twin/core/error.h"
#include "twin/loop/lockstep_drive.h"
#include "twin/loop/realtime_drive.h"
#include "twin/loop/state_time_drive.h"
#include "twin/rt/event_queue.h"

namespace twin::run {
namespace {

/// Without a state for so long, a robot is given up.
constexpr Duration kTimeout = std::chrono::seconds(1);
/// To see where a robot stands.
constexpr Duration kGlance = std::chrono::milliseconds(20);
/// Longest sleep without a look at what the caller wants.
constexpr Duration kLook = std::chrono::milliseconds(5);

class LockstepSetting final : public DriveSetting {
 public:
  LockstepSetting(const backend::Factory& connect, const robot::RobotConfig& robot,
                  rt::RecordSink* sink)
      : connection_(connect({robot, backend::LockstepHost{events_, drive_.StateReady()}, sink})) {}

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  [[nodiscard]] loop::RunReport Run(const loop::MotionRun& run) override {
    return drive_.Run(events_, run);
  }
  [[nodiscard]] Time Now() const override { return events_.Now(); }

 private:
  void Pass(Time /*limit*/) override { static_cast<void>(events_.RunNext()); }

  // The backend's robot is on the queue and tells the drive: it must go first.
  rt::EventQueue events_;
  loop::LockstepDrive drive_;
  backend::Connection connection_;
};

class RealtimeSetting final : public DriveSetting {
 public:
  RealtimeSetting(const backend::Factory& connect, const robot::RobotConfig& robot,
                  rt::RecordSink* sink, const RealtimeSettings& settings)
      : threads_(settings.threads),
        connection_(connect({robot, backend::RealtimeHost{clock_, settings.robot}, sink})) {}

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  void Begin() override {
    clock_.Restart();
    cycles_.emplace(connection_);
  }
  [[nodiscard]] loop::RunReport Run(const loop::MotionRun& run) override {
    return loop::RunInRealtime(clock_, connection_, run, threads_);
  }
  backend::RobotTimings End() override {
    return cycles_ ? cycles_->End() : backend::RobotTimings();
  }
  [[nodiscard]] Time Now() const override { return clock_.Now(); }

 private:
  void Pass(Time limit) override {
    static_cast<void>(connection_.arrival->AwaitUntil(std::min(limit, clock_.Now() + kLook)));
  }

  MonotonicClock clock_;
  loop::RealtimeThreads threads_;
  backend::Connection connection_;
  std::optional<loop::RobotCycles> cycles_;
};

class RemoteSetting final : public DriveSetting {
 public:
  RemoteSetting(const backend::Factory& connect, const robot::RobotConfig& robot,
                rt::RecordSink* sink, const RealtimeSettings& settings)
      : settings_(settings),
        connection_(connect({robot,
                             backend::RemoteHost{.clock = clock_,
                                                 .address = settings.remote.host,
                                                 .arm_port = settings.remote.arm_port,
                                                 .time = settings.remote.time,
                                                 .capture = settings.remote.capture},
                             sink})) {}

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  [[nodiscard]] std::optional<JointVector> ReadCurrentPosition() override {
    const loop::ListenReport heard = loop::ListenToRobot(
        clock_, *connection_.backend, *connection_.arrival,
        {.span = kGlance, .tolerance = kCycle, .thread = settings_.threads.communication});
    if (heard.states == 0) return std::nullopt;
    return heard.last.q_d;
  }
  [[nodiscard]] bool Check(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                           const JointVector& start, const TellCheck& tell) override {
    StartCheck check{.clock = clock_,
                     .backend = *connection_.backend,
                     .arrival = *connection_.arrival,
                     .time = settings_.remote.time,
                     .listening = {}};
    check.listening.thread = settings_.threads.communication;
    if (scenario.tick.period_tolerance > Duration::zero()) {
      check.listening.tolerance = scenario.tick.period_tolerance;
    }
    checked_ = RunStartCheck(check, scenario, robot, start, tell);
    return checked_;
  }
  void Begin() override {
    if (settings_.remote.checks_start && !checked_) {
      throw RobotFault("the robot is not moved: not all checks before its first motion are well");
    }
    clock_.Restart();
  }
  [[nodiscard]] loop::RunReport Run(const loop::MotionRun& run) override {
    loop::MotionRun remote = run;
    remote.record_states = true;
    loop::RunReport report =
        counts_states() ? loop::RunOnStateTime(clock_, connection_, remote, &timeline_)
                        : loop::RunInRealtime(clock_, connection_, remote, settings_.threads);
    const std::string why = connection_.why_lost ? connection_.why_lost() : "";
    if (!why.empty() && !report.failure.empty()) report.failure += "; " + why;
    return report;
  }
  [[nodiscard]] Time Now() const override { return counts_states() ? timeline_.now : clock_.Now(); }

 private:
  [[nodiscard]] bool counts_states() const {
    return settings_.remote.time == backend::RobotTime::kStates;
  }
  void Pass(Time limit) override {
    const Time look = clock_.Now() + kLook;
    static_cast<void>(
        connection_.arrival->AwaitUntil(counts_states() ? look : std::min(limit, look)));
  }
  void Observe(const RobotState& state) override {
    if (timeline_.first_id == 0) timeline_.first_id = state.message_id;
    const std::uint64_t cycles = state.message_id - timeline_.first_id;
    timeline_.now = Time(kCycle * static_cast<std::int64_t>(cycles));
  }
  [[nodiscard]] Time TimeoutNow() const override { return clock_.Now(); }

  MonotonicClock clock_;
  RealtimeSettings settings_;
  bool checked_ = false;
  loop::StateTimeline timeline_;  ///< of a robot whose time is its states
  backend::Connection connection_;
};

}  // namespace

bool DriveSetting::PassUntil(Time limit, const std::function<bool(const RobotState*)>& done) {
  backend::Backend& backend = *connection().backend;
  Time heard = TimeoutNow();
  Time arrival{};
  // What is queued is old.
  static_cast<void>(backend.Read(backend::ReadRule::kNewest, state_, arrival));
  while (true) {
    const RobotState* read = nullptr;
    switch (backend.Read(backend::ReadRule::kFresh, state_, arrival)) {
      case backend::ReadResult::kPending: break;
      case backend::ReadResult::kLost: {
        const auto& why = connection().why_lost;
        throw RobotFault("the connection to the robot is gone" + (why ? ": " + why() : ""));
      }
      case backend::ReadResult::kState:
        read = &state_;
        heard = TimeoutNow();
        Observe(state_);
        break;
    }
    if (done(read)) return true;
    if (Now() >= limit) return false;
    if (TimeoutNow() - heard > kTimeout) {
      throw RobotFault("no robot state has come for 1 s; is the link losing every state?");
    }
    Pass(limit);
  }
}

std::unique_ptr<DriveSetting> MakeDriveSetting(const scenario::Scenario& scenario,
                                               const backend::Factory& connect,
                                               const robot::RobotConfig& robot,
                                               rt::RecordSink* sink,
                                               const RealtimeSettings& settings) {
  if (scenario.drive == scenario::Drive::kRealtime) {
    return std::make_unique<RealtimeSetting>(connect, robot, sink, settings);
  }
  if (scenario.drive == scenario::Drive::kRemote) {
    return std::make_unique<RemoteSetting>(connect, robot, sink, settings);
  }
  return std::make_unique<LockstepSetting>(connect, robot, sink);
}

}  // namespace twin::run
