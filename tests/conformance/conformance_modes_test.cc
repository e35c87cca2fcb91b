// Every request in every mode of the robot, through the backend and its panel. What must come of it
// is mode_rules.h, written down from the documents without a look at INT's own table.

#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "conformance/mode_rules.h"
#include "conformance/rig.h"
#include "conformance/trial.h"
#include "twin/core/setting.h"
#include "twin/onboard/mode_table.h"

namespace twin::test::conformance_modes_test {
namespace {

constexpr MotionModes kMotion{ControllerMode::kJointImpedance, MotionGeneratorMode::kJointVelocity};

/// A situation, and how to bring a robot into it.
struct Scene {
  std::string name;
  Situation situation;
  std::function<void(Rig&)> reach;
};

/// A motion in which joint 1 turns at 0.5 rad/s.
void Move(Rig& rig) {
  Trial trial(rig, kMotion);
  ASSERT_TRUE(trial.Start([](const RobotState& start) { return JointPath(start, 0); }, false));
  trial.SpeedUp(0.5, 100);
  ASSERT_EQ(rig.state().robot_mode, RobotMode::kMove);
}

/// Aborted by a step of the commanded velocity.
void Abort(Rig& rig) {
  Move(rig);
  RobotCommand command = rig.Same();
  command.dq_c[0] += 0.1;
  rig.Answer(command);
  ASSERT_EQ(rig.state().robot_mode, RobotMode::kReflex);
}

void AbortAndRest(Rig& rig) {
  Abort(rig);
  ASSERT_TRUE(rig.ComeToRest());
}

std::function<void(Rig&)> Then(std::function<void(Rig&)> first, PanelAction action) {
  return [first = std::move(first), action](Rig& rig) {
    first(rig);
    ASSERT_TRUE(rig.Operate(action)) << rig.refusal();
    rig.Cycle();
  };
}

std::vector<Scene> Scenes() {
  const auto idle = [](Rig&) {};
  const auto braked = Then(idle, PanelAction::kCloseBrakes);
  const auto braked_with_error = Then(AbortAndRest, PanelAction::kCloseBrakes);
  const auto recovering = [](Rig& rig) {
    AbortAndRest(rig);
    ASSERT_TRUE(rig.Recover());
    rig.Cycle();
  };
  return {
      {"idle", {RobotMode::kIdle, true, false, false}, idle},
      {"move", {RobotMode::kMove, false, false, false}, Move},
      {"reflex, coming to rest", {RobotMode::kReflex, false, true, false}, Abort},
      {"reflex", {RobotMode::kReflex, true, true, false}, AbortAndRest},
      {"recovery", {RobotMode::kAutomaticErrorRecovery, true, false, false}, recovering},
      {"guiding",
       {RobotMode::kGuiding, true, false, false},
       Then(idle, PanelAction::kPressGuidingButton)},
      {"guiding with an error",
       {RobotMode::kGuiding, true, true, false},
       Then(AbortAndRest, PanelAction::kPressGuidingButton)},
      {"user stop",
       {RobotMode::kUserStopped, true, false, false},
       Then(idle, PanelAction::kPressUserStop)},
      {"user stop, coming to rest",
       {RobotMode::kUserStopped, false, false, false},
       Then(Move, PanelAction::kPressUserStop)},
      {"user stop with an error",
       {RobotMode::kUserStopped, true, true, false},
       Then(AbortAndRest, PanelAction::kPressUserStop)},
      {"user stop with brakes closed",
       {RobotMode::kUserStopped, true, false, true},
       Then(braked, PanelAction::kPressUserStop)},
      {"brakes closed", {RobotMode::kOther, true, false, true}, braked},
      {"brakes closed with an error", {RobotMode::kOther, true, true, true}, braked_with_error},
  };
}

struct Case {
  Scene scene;
  Ask ask;
  Setting setting;  ///< of kSet
  HarnessCase harness;

  [[nodiscard]] std::string_view Request() const {
    return ask == Ask::kSet ? twin::Name(setting) : Name(ask);
  }
};

/// Makes the request. @returns whether it was accepted.
bool Make(Rig& rig, const Case& test_case) {
  switch (test_case.ask) {
    case Ask::kMove: return rig.Start(kMotion);
    case Ask::kStopMove: rig.Stop(); return true;
    case Ask::kSet: return rig.Configure(test_case.setting);
    case Ask::kAutomaticErrorRecovery: return rig.Recover();
    case Ask::kPressUserStop: return rig.Operate(PanelAction::kPressUserStop);
    case Ask::kReleaseUserStop: return rig.Operate(PanelAction::kReleaseUserStop);
    case Ask::kCloseBrakes: return rig.Operate(PanelAction::kCloseBrakes);
    case Ask::kOpenBrakes: return rig.Operate(PanelAction::kOpenBrakes);
    case Ask::kPressGuidingButton: return rig.Operate(PanelAction::kPressGuidingButton);
    case Ask::kReleaseGuidingButton: return rig.Operate(PanelAction::kReleaseGuidingButton);
  }
  return false;
}

void PrintTo(const Case& test_case, std::ostream* out) {
  *out << test_case.Request() << " in " << test_case.scene.name;
}

/// Each setting with its defaults.
template <std::size_t... kIndex>
std::vector<Setting> Settings(std::index_sequence<kIndex...> /*all*/) {
  return {Setting(std::in_place_index<kIndex>)...};
}

std::vector<Case> Cases() {
  const auto settings = Settings(std::make_index_sequence<std::variant_size_v<Setting>>());
  std::vector<Case> cases;
  for (const HarnessCase& harness : Harnesses()) {
    if (harness.plant_kind != robot::PlantKind::kIdeal) continue;
    for (const Scene& scene : Scenes()) {
      for (std::size_t i = 0; i < kAsks; ++i) {
        const auto ask = static_cast<Ask>(i);
        const auto count = ask == Ask::kSet ? settings.size() : 1;
        for (const Setting& setting : std::span(settings).first(count)) {
          cases.push_back({scene, ask, setting, harness});
        }
      }
    }
  }
  return cases;
}

class ModesTest : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const robot::RobotConfig robot = HarnessRobot(robot::PlantKind::kIdeal);
    rig_.emplace(GetParam().harness.make(robot), robot, true);
    GetParam().scene.reach(*rig_);
  }
  [[nodiscard]] const Situation& situation() const { return GetParam().scene.situation; }

  std::optional<Rig> rig_;
};

TEST_P(ModesTest, TheRequestComesToWhatTheTableSays) {
  ASSERT_EQ(rig_->state().robot_mode, situation().mode);
  ASSERT_EQ(IsAtRest(rig_->state()), situation().at_rest);
  ASSERT_EQ(rig_->state().errors.any(), situation().has_errors);
  const Outcome expected = Expect(situation(), GetParam().ask);
  const RobotState before = rig_->state();
  EXPECT_EQ(Make(*rig_, GetParam()), expected.accepted) << rig_->refusal();
  rig_->Cycle();
  EXPECT_EQ(rig_->state().robot_mode, expected.mode) << Name(rig_->state().robot_mode);
  EXPECT_EQ(rig_->state().motion_generator_mode != MotionGeneratorMode::kIdle,
            expected.mode == RobotMode::kMove);
  const bool recovers = expected.mode == RobotMode::kAutomaticErrorRecovery;
  EXPECT_EQ(rig_->state().errors, recovers ? RobotErrors() : before.errors);
  for (int i = 0; i < 400 && !rig_->finding(); ++i) rig_->Cycle();
  EXPECT_FALSE(rig_->finding()) << *rig_->finding();
}

TEST_P(ModesTest, ARecoveryThatSucceedsLeavesNoErrors) {
  if (GetParam().ask != Ask::kAutomaticErrorRecovery || !Make(*rig_, GetParam())) return;
  rig_->Cycle();
  EXPECT_TRUE(rig_->state().errors.none()) << FormatErrors(rig_->state().errors);
}

TEST_P(ModesTest, ARefusalNamesRequestAndMode) {
  if (Expect(situation(), GetParam().ask).accepted) return;
  ASSERT_FALSE(Make(*rig_, GetParam()));
  EXPECT_NE(rig_->refusal().find(GetParam().Request()), std::string::npos) << rig_->refusal();
  EXPECT_NE(rig_->refusal().find(Name(situation().mode)), std::string::npos) << rig_->refusal();
}

TEST_P(ModesTest, IntsOwnTableTellsTheSame) {
  // Ask leaves out the two requests that are answered in every mode.
  const std::size_t ask = static_cast<std::size_t>(GetParam().ask);
  const std::size_t limit = ask >= static_cast<std::size_t>(Ask::kSet) ? 1 : 0;
  const std::size_t model = ask >= static_cast<std::size_t>(Ask::kPressUserStop) ? 1 : 0;
  const auto request = static_cast<onboard::Request>(ask + limit + model);
  ASSERT_EQ(onboard::Name(request), Name(GetParam().ask));
  const onboard::Verdict verdict = onboard::VerdictOn(situation().mode, request);
  const bool granted =
      verdict == onboard::Verdict::kGranted || verdict == onboard::Verdict::kNothingToDo ||
      (verdict == onboard::Verdict::kNothingUnlessError && !situation().has_errors) ||
      (verdict == onboard::Verdict::kGrantedAtRest && situation().at_rest);
  EXPECT_EQ(granted, Expect(situation(), GetParam().ask).accepted) << onboard::Name(verdict);
}

std::string CaseName(const ::testing::TestParamInfo<Case>& info) {
  std::string name = std::string(info.param.Request()) + " in " + info.param.scene.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == ' ' || c == ','; }, '_');
  return name;
}

TEST(SingularStartTest, OnlyMotionsOfJointsBeginThere) {
  constexpr JointVector kNearlyStraight{0, 0.9, 0, -0.477, 0, 1.4, 0};
  for (const HarnessCase& harness : Harnesses()) {
    if (harness.plant_kind != robot::PlantKind::kIdeal) continue;
    for (const auto generator :
         {MotionGeneratorMode::kCartesianPosition, MotionGeneratorMode::kCartesianVelocity}) {
      robot::RobotConfig robot = HarnessRobot(robot::PlantKind::kIdeal);
      robot.q_start = kNearlyStraight;
      Rig rig(harness.make(robot), robot, false);
      EXPECT_FALSE(rig.Start({ControllerMode::kJointImpedance, generator}));
      EXPECT_NE(rig.refusal().find("singular"), std::string::npos) << rig.refusal();
      EXPECT_TRUE(rig.Start(kMotion)) << rig.refusal();
    }
  }
}

TEST(LateStopTest, ARampThatLeavesTheRangeOfAJointAborts) {
  const auto path = [](const RobotState& start) { return JointPath(start, 1); };
  for (const auto& [generator, error] :
       {std::pair(MotionGeneratorMode::kJointVelocity,
                  RobotError::kJointMotionGeneratorPositionLimitsViolation),
        std::pair(MotionGeneratorMode::kCartesianPosition,
                  RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation)}) {
    for (const HarnessCase& harness : Harnesses()) {
      if (harness.plant_kind != robot::PlantKind::kIdeal) continue;
      robot::RobotConfig robot = HarnessRobot(robot::PlantKind::kIdeal);
      double& q_max = robot.onboard.limits.q_max[1];
      q_max = robot.q_start[1] + 0.032;
      Rig rig(harness.make(robot), robot, true);
      Trial trial(rig, {ControllerMode::kJointImpedance, generator});
      ASSERT_TRUE(trial.Start(path, false)) << rig.refusal();
      trial.SpeedUp(0.3, 200);
      rig.Stop();
      for (int k = 0; k < 100 && trial.moves(); ++k) {
        EXPECT_LE(rig.state().q_d[1], q_max);
        rig.Cycle();
      }
      EXPECT_EQ(rig.state().errors, RobotErrors().set(static_cast<std::size_t>(error)));
      EXPECT_GT(rig.state().q_d[1], q_max);
      EXPECT_FALSE(rig.finding()) << *rig.finding();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Table, ModesTest, ::testing::ValuesIn(Cases()), CaseName);

TEST(ModesCoverageTest, EveryModeIsAScene) {
  for (std::size_t mode = 0; mode < kModes; ++mode) {
    bool found = false;
    for (const Scene& scene : Scenes()) {
      found = found || scene.situation.mode == static_cast<RobotMode>(mode);
    }
    EXPECT_TRUE(found) << Name(static_cast<RobotMode>(mode));
  }
}

}  // namespace
}  // namespace twin::test::conformance_modes_test
