// What one update of each controller costs: compliance is to take at most 5 us. The ratio to the
// arm's own Jacobian, measured in the same process, is what a shared machine does not change.

#include <chrono>
#include <memory>
#include <string>

#include <benchmark/benchmark.h>

#include "controllers/registration.h"
#include "support/panda_limits.h"
#include "twin/model/arm_model.h"

namespace twin::controllers {
namespace {

using control::CommandInterface;

constexpr JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
constexpr JointVector kGoal{0.4, -0.6, 0.1, -2.2, 0.1, 1.7, 0.6};

void Update(benchmark::State& bench, const std::string& type, CommandInterface interface) {
  control::ControllerRegistry registry;
  RegisterControllers(registry);
  const reference::Trajectory trajectory({{.q = kReady}, {.q = kGoal}},
                                         {.duration = std::chrono::hours(20)}, test::PandaLimits());
  const auto controller = registry.Find(type)({.trajectory = trajectory,
                                               .interface = interface,
                                               .limits = test::PandaLimits(),
                                               .cartesian = test::PandaCartesianLimits()});
  RobotState state;
  state.q = state.q_d = kReady;
  state.dq = {0.1, -0.1, 0.2, -0.2, 0.3, -0.3, 0.1};
  state.m_ee = 0.73;
  controller->Activate(state, Time());
  control::ControllerOutput output;
  Time now{};
  for (auto _ : bench) {
    controller->Update(state, now, output);
    benchmark::DoNotOptimize(output);
    now += kCycle;
  }
  if (output.failed) bench.SkipWithError("the controller gave up");
}

void BM_Jacobian(benchmark::State& bench) {
  JointVector q = kReady;
  for (auto _ : bench) {
    benchmark::DoNotOptimize(q);
    auto motion = model::ArmModel::Panda().MotionOf(model::Frame::kEndEffector, q);
    benchmark::DoNotOptimize(motion);
  }
}
BENCHMARK(BM_Jacobian);

BENCHMARK_CAPTURE(Update, joint_trajectory, "joint_trajectory", CommandInterface::kJointPosition);
BENCHMARK_CAPTURE(Update, joint_position, "joint_position", CommandInterface::kJointPosition);
BENCHMARK_CAPTURE(Update, joint_velocity, "joint_velocity", CommandInterface::kJointVelocity);
BENCHMARK_CAPTURE(Update, cartesian_pose, "cartesian_pose", CommandInterface::kJointPosition);
BENCHMARK_CAPTURE(Update, joint_trajectory_effort, "joint_trajectory_effort",
                  CommandInterface::kTorque);
BENCHMARK_CAPTURE(Update, compliance, "compliance", CommandInterface::kTorque);
BENCHMARK_CAPTURE(Update, gravity_hold, "gravity_hold", CommandInterface::kTorque);

}  // namespace
}  // namespace twin::controllers
