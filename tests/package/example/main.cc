// Commands a step of 1 mrad to an emulated Panda and prints the error of its controller.
#include <cstdio>

#include "twin/plant/ideal_plant.h"
#include "twin/robot/robot.h"
#include "twin/run/robot_config.h"

struct Client final : twin::rt::EventHandler {  // answers every state
  void OnEvent(twin::Time, std::uint64_t) noexcept override {
    const twin::RobotState& state = robot->states().Take();
    twin::RobotCommand command{.message_id = state.message_id, .q_c = state.q_d};
    if (state.message_id == 100) command.q_c[0] += 0.001;
    robot->Send(command);
  }
  twin::robot::Robot* robot = nullptr;
};

int main() {
  const auto scenario = twin::scenario::Load(MODELS "/scenarios/smoke.yaml");
  const auto config = twin::run::MakeServedConfig(scenario, {.models = MODELS});
  twin::rt::EventQueue events;
  Client client;
  twin::robot::Robot robot(config, std::make_unique<twin::plant::IdealPlant>(), events, client,
                           nullptr);
  client.robot = &robot;
  robot.Begin();
  while (robot.Move({}) != twin::MoveStatus::kMotionStarted) events.RunNext();
  while (robot.mode() != twin::RobotMode::kReflex) events.RunNext();
  const twin::robot::LastMotion motion = robot.last_motion();
  std::puts(Describe(motion.violations.items().front()).c_str());
}
