#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "loop/communication_thread.h"
#include "loop/controller_thread.h"
#include "loop/motion_runner.h"
#include "twin/core/error.h"
#include "twin/loop/drive.h"
#include "twin/rt/host_time.h"

namespace twin::loop {
namespace {

/// Poll period of the supervisor.
constexpr Duration kPollPeriod = std::chrono::milliseconds(5);

/// Reports a setting once if it was refused to both threads.
void AddNew(const std::vector<std::string>& notices, std::vector<std::string>& all) {
  for (const std::string& notice : notices) {
    if (std::ranges::find(all, notice) == all.end()) all.push_back(notice);
  }
}

class RealtimeRunner final : public MotionRunner {
 public:
  RealtimeRunner(const MonotonicClock& clock, const backend::Connection& connection,
                 const MotionRun& run, const DriveThreads& threads)
      : MotionRunner(run), clock_(clock), moving_(clock) {
    loop_ = MakeLoop(run, tick_, exchange_);
    // A simulated robot puts its cycle records itself.
    loop_->RecordStates(connection.robot_time == nullptr);
    communication_.emplace(clock, *loop_, run.backend, *connection.arrival, watch_, moving_,
                           threads.communication);
    if (run.kind == LoopKind::kAsynchronous) {
      controller_.emplace(clock, controller_loop_, watch_, moving_, threads.controller);
    }
  }
  ~RealtimeRunner() override { StopThreads(); }
  RealtimeRunner(const RealtimeRunner&) = delete;
  RealtimeRunner& operator=(const RealtimeRunner&) = delete;

  /// Thread settings that the system did not permit. @pre the motion has ended.
  [[nodiscard]] std::vector<std::string> Notices() const {
    std::vector<std::string> notices = communication_->notices();
    if (controller_) AddNew(controller_->notices(), notices);
    return notices;
  }

 private:
  [[nodiscard]] Time Now() const override { return clock_.Now(); }
  [[nodiscard]] bool PassUntil(Time limit, const std::function<bool()>& done) override {
    while (!done()) {
      if (clock_.Now() >= limit) return false;
      rt::SleepUntil(clock_, clock_.Now() + kPollPeriod);
    }
    return true;
  }
  [[nodiscard]] const RobotState& State() override { return communication_->State(); }
  void Activate(const MotionModes& modes) override {
    DoOnCommunication([&] { loop_->Activate(modes); });
  }
  void StopController() override {
    if (controller_) {
      controller_->Stop();
    } else if (watch_.failure() == LoopFailure::kNone ||
               watch_.failure() == LoopFailure::kInvalidCommand ||
               watch_.failure() == LoopFailure::kLimit) {
      DoOnCommunication([&] { loop_->StopController(); });
    }
  }
  void EndThreads() override { StopThreads(); }

  template <typename Function>
  void DoOnCommunication(Function function) {
    rt::FunctionCall<Function> call(function);
    if (communication_->Execute(call)) return;
    throw EnvironmentError(
        "the communication thread has not run for 1 s; this machine gives it no time (see "
        "panda-twin check)");
  }

  /// Ends both threads; after return no thread puts ticks or calls the controller.
  void StopThreads() {
    if (controller_) controller_->Stop();
    if (communication_) communication_->Stop();
  }

  const MonotonicClock& clock_;
  rt::Signal moving_;
  std::optional<CommunicationThread> communication_;  ///< set by the constructor
  std::optional<ControllerThread> controller_;        ///< asynchronous loop only
};

class RealtimeDrive final : public Drive {
 public:
  RealtimeDrive(const backend::Factory& connect, const robot::RobotConfig& robot,
                record::RecordSink* sink, const DriveThreads& threads)
      : clock_(threads.seat != nullptr ? threads.seat->clock()
                                       : std::make_shared<MonotonicClock>()),
        threads_(threads),
        connection_(connect({robot, backend::WallTime{*clock_, RobotThread(threads)}, sink})) {}
  RealtimeDrive(std::shared_ptr<MonotonicClock> clock, backend::Connection connection,
                const DriveThreads& threads)
      : clock_(std::move(clock)), threads_(threads), connection_(std::move(connection)) {}
  ~RealtimeDrive() override { static_cast<void>(End()); }

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  [[nodiscard]] const MonotonicClock* wall_clock() const noexcept override { return clock_.get(); }
  [[nodiscard]] Time Now() const override { return clock_->Now(); }

  void Begin() override {
    if (threads_.seat == nullptr) clock_->Restart();
    if (connection_.robot_time != nullptr) connection_.robot_time->Begin();
    begun_ = true;
    if (threads_.seat != nullptr) threads_.seat->Begin();
  }
  [[nodiscard]] RunReport Run(const MotionRun& run) override {
    const MotionRun measured = WithoutModels(run);
    RealtimeRunner runner(*clock_, connection_, measured, threads_);
    RunReport report = runner.Run();
    report.notices = runner.Notices();
    return report;
  }
  backend::RobotTimings End() override {
    if (connection_.robot_time == nullptr || !begun_) return {};
    if (threads_.seat != nullptr) EndTogether();
    connection_.robot_time->End();
    return connection_.robot_time->timings();
  }

 private:
  static rt::ThreadSettings RobotThread(const DriveThreads& threads) {
    rt::ThreadSettings settings = threads.robot;
    if (threads.seat != nullptr) settings.shared = &threads.seat->thread();
    return settings;
  }
  void EndTogether() {
    try {
      connection_.robot_time->StandBy();
    } catch (const RobotFault&) {  // the robot's thread does not run; it stops below
    }
    threads_.seat->End();
  }
  void Wait(Time limit) override {
    static_cast<void>(
        connection_.arrival->AwaitUntil(std::min(limit, clock_->Now() + kPollPeriod)));
  }

  /// Outlives the backend.
  const std::shared_ptr<MonotonicClock> clock_;
  const DriveThreads threads_;
  bool begun_ = false;
  backend::Connection connection_;
};

}  // namespace

std::unique_ptr<Drive> MakeRealtimeDrive(const backend::Factory& connect,
                                         const robot::RobotConfig& robot, record::RecordSink* sink,
                                         const DriveThreads& threads) {
  return std::make_unique<RealtimeDrive>(connect, robot, sink, threads);
}

std::unique_ptr<Drive> MakeRemoteDrive(const backend::Factory& connect,
                                       const robot::RobotConfig& robot, record::RecordSink* sink,
                                       const backend::RobotAddress& address,
                                       const DriveThreads& threads) {
  auto clock = std::make_unique<MonotonicClock>();
  backend::Connection connection = connect({robot, backend::RemoteRobot{*clock, address}, sink});
  if (connection.time == backend::RobotTime::kStates) {
    return MakeStateTimeDrive(std::move(clock), std::move(connection));
  }
  return std::make_unique<RealtimeDrive>(std::move(clock), std::move(connection), threads);
}

}  // namespace twin::loop
