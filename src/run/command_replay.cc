#include "twin/run/command_replay.h"

#include <utility>

#include "twin/robot/robot.h"
#include "twin/run/robot_config.h"
#include "twin/scenario/robot_data.h"

namespace twin::run {
namespace {

robot::RobotConfig ReplayConfig(scenario::Scenario scenario, const RunFiles& files,
                                const std::optional<JointVector>& q_start) {
  if (q_start) scenario.robot.q_start = q_start;
  robot::RobotConfig config = MakeRobotConfig(
      scenario, scenario::LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand),
      files);
  config.link = robot::LinkConfig();
  config.link.d_INT = {};
  return config;
}

}  // namespace

class CommandReplay::Impl final : private record::RecordSink, private rt::EventHandler {
 public:
  explicit Impl(const robot::RobotConfig& config)
      : robot_(config, std::move(robot::MakePlant(config).plant), events_, *this, this) {
    robot_.Begin();
  }

  [[nodiscard]] robot::Robot& robot() noexcept { return robot_; }

  const record::CycleRecord& Cycle(const RobotCommand* command) noexcept {
    if (command != nullptr) {
      RobotCommand answer = *command;
      answer.message_id = robot_.state().message_id;
      robot_.Send(answer);  // arrives now, after the last cycle and before the next
    }
    for (ran_ = false; !ran_;) events_.RunNext();
    return record_;
  }

 private:
  void Put(const record::CycleRecord& record) noexcept override {
    record_ = record;
    ran_ = true;
  }
  void Put(const record::TickRecord& /*record*/) noexcept override {}
  /// A state has arrived, which nobody reads.
  void OnEvent(Time /*now*/, std::uint64_t /*message_id*/) noexcept override {}

  rt::EventQueue events_;
  record::CycleRecord record_;
  bool ran_ = false;
  robot::Robot robot_;
};

CommandReplay::CommandReplay(const scenario::Scenario& scenario, const RunFiles& files,
                             const std::optional<JointVector>& q_start)
    : impl_(std::make_unique<Impl>(ReplayConfig(scenario, files, q_start))) {}
CommandReplay::~CommandReplay() = default;

MoveStatus CommandReplay::Start(const MotionModes& modes) noexcept {
  return impl_->robot().Move(modes);
}

void CommandReplay::Stop() noexcept {
  impl_->robot().StopMove();
}

RecoveryStatus CommandReplay::Recover() noexcept {
  return impl_->robot().AutomaticErrorRecovery();
}

const record::CycleRecord& CommandReplay::Cycle(const RobotCommand* command) noexcept {
  return impl_->Cycle(command);
}

}  // namespace twin::run
