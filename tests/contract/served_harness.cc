#include "contract/served_harness.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <thread>

#include "contract/urgent.h"
#include "plugins/fci/fci_backend.h"
#include "twin/core/clock.h"
#include "twin/robot/lockstep_robot.h"
#include "twin/robot/make_plant.h"
#include "twin/robot/wall_clock_robot.h"
#include "twin/rt/pause.h"
#include "twin/server/server.h"

namespace twin::test {
namespace {

/// Longer than any machine holds up a thread.
constexpr Duration kLong = std::chrono::seconds(30);
/// In lockstep, a motion of a test that has failed need not be waited for.
constexpr Duration kAnswerTimeout = std::chrono::seconds(3);

/// What the robot itself saw.
class Witness final : public rt::RecordSink {
 public:
  void Put(const rt::CycleRecord& record) noexcept override {
    if (record.dropped > 0) late_commands_ = true;
    ++cycles_;
  }
  void Put(const rt::TickRecord&) noexcept override {}

  [[nodiscard]] std::uint64_t cycles() const { return cycles_; }
  /// Whether a command came for a cycle that had passed.
  [[nodiscard]] bool late_commands() const { return late_commands_; }
  void Forget() { late_commands_ = false; }

 private:
  std::atomic<std::uint64_t> cycles_ = 0;
  std::atomic<bool> late_commands_ = false;
};

/// A robot and its server, which both run.
class Service {
 public:
  Service(const robot::RobotConfig& config, backend::RobotTime time, bool freeze,
          rt::RecordSink& sink) {
    auto plant = robot::MakePlant(config).plant;
    if (time == backend::RobotTime::kStates) {
      const robot::LockstepOptions options{.answer_timeout = kAnswerTimeout,
                                           .freeze_when_idle = freeze};
      robot_ = &lockstep_.emplace(config, std::move(plant), port_, port_, clock_,
                                  Urgent("robot", 0), &sink, options);
    } else {
      robot_ =
          &real_time_.emplace(config, std::move(plant), port_, clock_, Urgent("robot", 85), &sink);
    }
    server::ServerConfig served;
    served.arm_port = 0;
    served.hand_port = 0;
    server_.emplace(std::move(served), *robot_, port_, changed_, clock_, [](std::string_view) {});
    robot_->Begin();
    thread_ = std::jthread([this](const std::stop_token& stop) {
      server_->Run([&stop] { return stop.stop_requested(); });
    });
  }
  ~Service() {
    thread_.request_stop();
    changed_.Ring();
    thread_.join();
    robot_->End();
  }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  [[nodiscard]] const server::Server& server() const { return *server_; }

 private:
  const MonotonicClock clock_;
  server::Bell changed_;
  server::UdpPort port_{clock_, 0x7f000001, changed_};
  std::optional<robot::LockstepRobot> lockstep_;
  std::optional<robot::WallClockRobot> real_time_;
  robot::ThreadedRobot* robot_ = nullptr;  ///< the one of the two that is there
  std::optional<server::Server> server_;
  std::jthread thread_;
};

class ServedHarness final : public BackendHarness {
 public:
  ServedHarness(const robot::RobotConfig& robot, backend::RobotTime time, bool freeze)
      : time_(time), config_(robot) {
    if (time == backend::RobotTime::kWall) urgent_.emplace();
    config_.link.d_INT = Duration::zero();  // the whole period is there for the answer
    service_.emplace(config_, time, freeze, witness_);
    connection_ = plugins::ConnectFci(
        {config_,
         backend::RemoteHost{clock_, "127.0.0.1", service_->server().arm().port, HandPort(), time},
         nullptr});
  }

  backend::Backend& backend() override { return *connection_.backend; }
  backend::Hand* hand() override { return connection_.hand; }

  bool AwaitState(RobotState& state, backend::ReadRule rule) override {
    const Time limit = clock_.Now() + kLong;
    Time arrival{};
    while (true) {
      const backend::ReadResult result = backend().Read(rule, state, arrival);
      if (result == backend::ReadResult::kState) break;
      if (result == backend::ReadResult::kLost || clock_.Now() >= limit) return false;
      static_cast<void>(connection_.arrival->AwaitUntil(limit));
    }
    missed_state_ = missed_state_ || state.message_id != last_id_ + 1;
    last_id_ = state.message_id;
    return arrival <= clock_.Now();
  }

  bool AwaitArrivals(int count) override {
    // A cycle that has been recorded has sent its state, but for the last.
    const std::uint64_t enough = witness_.cycles() + static_cast<std::uint64_t>(count) + 1;
    const Time limit = clock_.Now() + kLong;
    while (witness_.cycles() <= enough) {
      if (clock_.Now() >= limit) return false;
      rt::Pause(std::chrono::microseconds(200));
    }
    return true;
  }

  bool by_the_wall_clock() const override { return true; }
  bool waits_for_answers() const override { return time_ == backend::RobotTime::kStates; }
  bool disturbed() override {
    const bool missed_state = missed_state_;
    if (waits_for_answers()) return missed_state;
    // A command that came too late is dropped one or two cycles on.
    RobotState state;
    for (int i = 0; i < 3; ++i) static_cast<void>(AwaitState(state, backend::ReadRule::kNewest));
    return missed_state || witness_.late_commands();
  }
  void ForgetDisturbances() override {
    missed_state_ = false;
    witness_.Forget();
  }

 private:
  [[nodiscard]] std::uint16_t HandPort() const {
    const auto hand = service_->server().hand();
    return hand ? hand->port : std::uint16_t{0};
  }

  std::optional<UrgentHere> urgent_;
  const backend::RobotTime time_;
  const MonotonicClock clock_;
  robot::RobotConfig config_;
  Witness witness_;
  std::optional<Service> service_;
  backend::Connection connection_;
  std::uint64_t last_id_ = 0;
  bool missed_state_ = false;
};

}  // namespace

std::unique_ptr<BackendHarness> MakeServedHarness(const robot::RobotConfig& robot,
                                                  backend::RobotTime time, bool freeze) {
  return std::make_unique<ServedHarness>(robot, time, freeze);
}

}  // namespace twin::test
