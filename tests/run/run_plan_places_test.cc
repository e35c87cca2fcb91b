// A motion that the planner makes is the same one wherever the robot is: in this process or served,
// in lockstep or on the wall clock; by torques, and by positions behind the reference generator.

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plugins/backends.h"
#include "run/plan_execution.h"
#include "support/undisturbed.h"
#include "twin/server/served_robot.h"

namespace twin::run::run_plan_places_test {
namespace {

using ::testing::HasSubstr;

enum class Place : std::uint8_t {
  kServedInLockstep,
  kRealtime,
  kServedOnTheWallClock,
};

/// What came of it.
struct Execution {
  RunResult result;
  reference::JointTarget begin;  ///< of the plan
  std::uint64_t touched = 0;
  std::uint64_t looks = 0;
};

class PlanPlacesTest : public ::testing::Test {
 protected:
  PlanPlacesTest() {
    plugins::RegisterMujoco(backends_);
    plugins::RegisterFci(backends_);
    controllers::RegisterControllers(controllers_);
  }

  /// plan_and_execute.yaml, on either interface.
  [[nodiscard]] scenario::Scenario Planned(control::CommandInterface interface) const {
    scenario::Scenario scenario =
        scenario::Load(files_.models / "scenarios" / "plan_and_execute.yaml");
    scenario.motion.interface = interface;
    if (interface == control::CommandInterface::kJointPosition) {
      scenario.controller.type = "joint_trajectory";
      scenario.controller.parameters = {};
      scenario.tick.generator = loop::Generator::kJoint;
    }
    return scenario;
  }

  /// The same for a place where time is the wall's: slowly, since what comes late is held.
  [[nodiscard]] scenario::Scenario OnTheWallClock(control::CommandInterface interface) const {
    scenario::Scenario scenario = Planned(interface);
    scenario.motion.plan->stretch = 2;
    scenario.link = scenario::LinkSection();
    scenario.link.d_INT = Duration::zero();
    return scenario;
  }

  [[nodiscard]] Execution InProcess(const scenario::Scenario& scenario) const {
    test::Watcher watcher;
    run::Run run(scenario, {backends_, controllers_}, files_, &watcher);
    watcher.Watch(*run.connection().truth);
    return Executed(run, watcher);
  }

  /// @param served    the robot's scenario. @param scenario  the client's.
  [[nodiscard]] Execution OverTheWire(const scenario::Scenario& served, scenario::Scenario scenario,
                                      backend::RobotTime time) const {
    test::Watcher watcher;
    server::ServedRobotSettings settings{.takes_free_ports = true, .sink = &watcher};
    if (time == backend::RobotTime::kStates) settings.lockstep = {.freeze_when_idle = true};
    const robot::RobotConfig config = MakeServedConfig(served, files_);
    server::ServedRobot robot(config, robot::MakePlant(config), std::move(settings));
    watcher.Watch(*robot.truth());
    robot.Start();
    scenario.backend = "fci";
    RealtimeConfig remote;
    remote.remote = {.host = "127.0.0.1", .arm_port = robot.arm().port, .time = time};
    remote.checks_start = false;
    Execution execution;
    {
      run::Run run(scenario, {backends_, controllers_}, files_, nullptr, remote);
      execution = Executed(run, watcher);
    }
    robot.End();
    execution.touched = watcher.contacts().cycles();
    execution.looks = watcher.contacts().looks();
    return execution;
  }

  [[nodiscard]] Execution At(Place place, const scenario::Scenario& scenario) const {
    if (place == Place::kServedInLockstep) {
      return OverTheWire(scenario, scenario, backend::RobotTime::kStates);
    }
    if (place == Place::kServedOnTheWallClock) {
      return OverTheWire(scenario, scenario, backend::RobotTime::kWall);
    }
    scenario::Scenario realtime = scenario;
    realtime.drive = scenario::Drive::kRealtime;
    return InProcess(realtime);
  }

 private:
  /// Of what is still running, touched and looks are those so far.
  [[nodiscard]] static Execution Executed(run::Run& run, const test::Watcher& watcher) {
    Execution execution;
    execution.begin = run.trajectory().Sample(Duration::zero());
    execution.result = run.Execute();
    execution.touched = watcher.contacts().cycles();
    execution.looks = watcher.contacts().looks();
    return execution;
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
};

void ExpectSameMotion(const Execution& there, const Execution& here) {
  ASSERT_TRUE(here.result.report.succeeded()) << here.result.report.failure;
  EXPECT_TRUE(there.result.report.succeeded()) << there.result.report.failure;
  EXPECT_EQ(there.result.goal, here.result.goal);
  EXPECT_EQ(there.result.plan->checks, here.result.plan->checks);
  EXPECT_EQ(there.result.plan->waypoints, here.result.plan->waypoints);
  EXPECT_EQ(there.touched, 0u);
  EXPECT_GT(there.looks, 500u);
  constexpr double kGoalTolerance = 0.02;  // of the torque controller, rad
  EXPECT_LT(there.result.final_error, kGoalTolerance);
  EXPECT_NEAR(there.result.final_error, here.result.final_error, 5e-3);
}

class PlanOnInterfaceTest : public PlanPlacesTest,
                            public ::testing::WithParamInterface<control::CommandInterface> {};

TEST_P(PlanOnInterfaceTest, IsTheSameMotionOverTheWireInLockstep) {
  const scenario::Scenario scenario = Planned(GetParam());
  ExpectSameMotion(At(Place::kServedInLockstep, scenario), InProcess(scenario));
}

TEST_P(PlanOnInterfaceTest, IsTheSameMotionOnTheWallClock) {
  const scenario::Scenario scenario = OnTheWallClock(GetParam());
  const Execution here = InProcess(scenario);
  for (const Place place : {Place::kRealtime, Place::kServedOnTheWallClock}) {
    SCOPED_TRACE(static_cast<int>(place));
    twin::test::Undisturbed([&] { ExpectSameMotion(At(place, scenario), here); },
                            [] { return twin::test::kEndsAMotion; }, twin::test::ByWitness(98), 5);
  }
}

INSTANTIATE_TEST_SUITE_P(All, PlanOnInterfaceTest,
                         ::testing::Values(control::CommandInterface::kTorque,
                                           control::CommandInterface::kJointPosition),
                         [](const auto& interface) {
                           return interface.param == control::CommandInterface::kTorque
                                      ? "Torque"
                                      : "JointPosition";
                         });

// An arm that people guided to its start stands a little beside it.
TEST_F(PlanPlacesTest, BeginsWhereTheRobotStandsAndEndsAtTheSameGoal) {
  const scenario::Scenario scenario = Planned(control::CommandInterface::kJointPosition);
  scenario::Scenario beside = scenario;
  for (double& q : *beside.robot.q_start) q += 0.01;
  const Execution there = OverTheWire(beside, scenario, backend::RobotTime::kStates);
  ASSERT_TRUE(there.result.report.succeeded()) << there.result.report.failure;
  EXPECT_EQ(there.begin.q, *beside.robot.q_start);
  EXPECT_EQ(there.result.goal, InProcess(scenario).result.goal);
  EXPECT_LT(there.result.final_error, 5e-3);
  EXPECT_EQ(there.touched, 0u);
}

TEST_F(PlanPlacesTest, RefusesARobotThatStandsElsewhere) {
  const scenario::Scenario scenario = Planned(control::CommandInterface::kJointPosition);
  scenario::Scenario elsewhere = scenario;
  (*elsewhere.robot.q_start)[2] += 0.03;
  try {
    (void)OverTheWire(elsewhere, scenario, backend::RobotTime::kStates);
    FAIL() << "the motion began";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("joint 3"));
  }
}

}  // namespace
}  // namespace twin::run::run_plan_places_test
