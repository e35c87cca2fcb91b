#include "twin/run/remote.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"
#include "twin/fci/protocol.h"
#include "twin/run/run.h"

namespace twin::run::run_remote_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kMotion = R"(
name: there
MORE
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]AT0}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]AT1}
)";

std::string Replaced(std::string text, const std::string& what, const std::string& by) {
  return text.replace(text.find(what), what.size(), by);
}

scenario::Scenario Untimed(const std::string& more = "") {
  std::string text = Replaced(kMotion, "MORE", more);
  text = Replaced(text, "AT0", "");
  return scenario::Parse(Replaced(text, "AT1", ""), "there.yaml");
}

scenario::Scenario Timed() {
  std::string text = Replaced(kMotion, "MORE", "");
  text = Replaced(text, "AT0", ", at: 0 s");
  return scenario::Parse(Replaced(text, "AT1", ", at: 2 s"), "there.yaml");
}

scenario::RobotData Panda() {
  return scenario::LoadRobotData(std::filesystem::path(TWIN_SOURCE_DIR) / "models", "panda",
                                 plant::HandKind::kFrankaHand);
}

std::string ErrorOf(const std::string& robot, const std::string& time) {
  try {
    static_cast<void>(ParseRemote(robot, time));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RemoteTest, ReadsAnAddressWithAndWithoutAPort) {
  EXPECT_EQ(ParseRemote("172.16.0.2", "wall").host, "172.16.0.2");
  EXPECT_EQ(ParseRemote("172.16.0.2", "wall").arm_port, fci::kArmPort);
  EXPECT_EQ(ParseRemote("panda.lab:1500", "states").host, "panda.lab");
  EXPECT_EQ(ParseRemote("panda.lab:1500", "states").arm_port, 1500);
  EXPECT_EQ(ParseRemote("a", "auto").time, backend::RobotTime::kAsItSays);
  EXPECT_EQ(ParseRemote("a", "wall").time, backend::RobotTime::kWall);
  EXPECT_EQ(ParseRemote("a", "states").time, backend::RobotTime::kStates);
}

TEST(RemoteTest, NamesWhatIsWrongWithAnAddress) {
  EXPECT_THAT(ErrorOf("", "wall"), HasSubstr("names no host"));
  EXPECT_THAT(ErrorOf(":1337", "wall"), HasSubstr("names no host"));
  for (const char* robot : {"a:", "a:0", "a:65535", "a:99999", "a:-1", "a:13x"}) {
    EXPECT_THAT(ErrorOf(robot, "wall"), HasSubstr("is no port")) << robot;
  }
  EXPECT_THAT(ErrorOf("a", "sundial"), HasSubstr("accepted: auto"));
}

TEST(RemoteTest, ScenariosOfARobotOnTheWireAreDrivenByIt) {
  EXPECT_EQ(Untimed("backend: fci").drive_name(), "remote");
  EXPECT_FALSE(Untimed("backend: fci").is_lockstep());
  EXPECT_THROW(Untimed("backend: fci\ndrive: lockstep"), InputError);
  EXPECT_THROW(Untimed("backend: fci\ndrive: remote"), InputError);
  EXPECT_THROW(Untimed("drive: remote"), InputError);
  EXPECT_EQ(scenario::Parse(scenario::ToYaml(Untimed("backend: fci")), "again.yaml"),
            Untimed("backend: fci"));
}

TEST(RemoteTest, TellsWhatHasNoEffectThere) {
  EXPECT_THAT(WithoutEffectThere(Untimed()), IsEmpty());
  EXPECT_THAT(WithoutEffectThere(Untimed("plant: {kind: ideal}")), Contains(HasSubstr("plant")));
  EXPECT_THAT(WithoutEffectThere(Untimed("link: {state_loss: 1 %}")), Contains(HasSubstr("link")));
  EXPECT_THAT(WithoutEffectThere(Untimed("onboard: {damping_ratio: 0.7}")),
              Contains(HasSubstr("damping_ratio")));
  EXPECT_THAT(
      WithoutEffectThere(Untimed("onboard: {K_theta: {unit: Nm/rad, values: [1000, 1000, 1000, "
                                 "1000, 1000, 1000, 1000]}}")),
      IsEmpty())
      << "it is told the robot";
  EXPECT_THAT(WithoutEffectThere(Untimed("tick: {cost: {constant: 10 us}}")),
              Contains(HasSubstr("tick.cost")));
}

TEST(RemoteTest, AHalvedSpeedDoublesTheTimesAndLeavesThePath) {
  const scenario::RobotData robot = Panda();
  for (scenario::Scenario scenario : {Untimed(), Timed()}) {
    const reference::Trajectory planned = MakeTrajectory(scenario, robot);
    SlowDown(scenario, robot, 0.5);
    const reference::Trajectory slow = MakeTrajectory(scenario, robot);
    EXPECT_NEAR(ToSeconds(slow.duration()), 2 * ToSeconds(planned.duration()), 1e-8);
    for (int percent = 0; percent <= 100; percent += 5) {
      const reference::JointTarget then = planned.Sample(planned.duration() * percent / 100);
      const reference::JointTarget now = slow.Sample(slow.duration() * percent / 100);
      EXPECT_NEAR(now.q[0], then.q[0], 1e-8);
      EXPECT_NEAR(now.dq[0], then.dq[0] / 2, 1e-7);
    }
  }
}

TEST(RemoteTest, FullSpeedChangesNothing) {
  scenario::Scenario scenario = Untimed();
  SlowDown(scenario, Panda(), 1);
  EXPECT_EQ(scenario, Untimed());
}

TEST(RemoteTest, TakesNoSpeedAboveTheScenariosAndNoneThatIsNone) {
  scenario::Scenario scenario = Untimed();
  for (const double share : {0.0, -0.5, 1.01, std::nan("")}) {
    EXPECT_THROW(SlowDown(scenario, Panda(), share), InputError) << share;
  }
}

}  // namespace
}  // namespace twin::run::run_remote_test
