#include "twin/core/modes.h"

#include <gtest/gtest.h>

#include <set>
#include <string_view>
#include <utility>

namespace twin::core_modes_test {
namespace {

// Values and names as clients of the real robot have them (libfranka 0.9.2, RobotMode and its
// printing; FCI protocol 5, robot state).
constexpr std::pair<int, std::string_view> kRobotModes[] = {
    {0, "Other"},
    {1, "Idle"},
    {2, "Move"},
    {3, "Guiding"},
    {4, "Reflex"},
    {5, "User stopped"},
    {6, "Automatic error recovery"},
};

TEST(RobotModeTest, HasTheWireValuesAndPrintedNames) {
  for (const auto& [value, name] : kRobotModes) {
    EXPECT_EQ(Name(static_cast<RobotMode>(value)), name) << value;
  }
  EXPECT_EQ(static_cast<int>(RobotMode::kAutomaticErrorRecovery), 6);
}

TEST(MotionGeneratorModeTest, HasTheWireValuesOfTheState) {
  EXPECT_EQ(static_cast<int>(MotionGeneratorMode::kIdle), 0);
  EXPECT_EQ(static_cast<int>(MotionGeneratorMode::kJointPosition), 1);
  EXPECT_EQ(static_cast<int>(MotionGeneratorMode::kJointVelocity), 2);
  EXPECT_EQ(static_cast<int>(MotionGeneratorMode::kCartesianPosition), 3);
  EXPECT_EQ(static_cast<int>(MotionGeneratorMode::kCartesianVelocity), 4);
  EXPECT_EQ(static_cast<int>(MotionGeneratorMode::kNone), 5);
}

TEST(ControllerModeTest, HasTheWireValuesOfTheState) {
  EXPECT_EQ(static_cast<int>(ControllerMode::kJointImpedance), 0);
  EXPECT_EQ(static_cast<int>(ControllerMode::kCartesianImpedance), 1);
  EXPECT_EQ(static_cast<int>(ControllerMode::kExternalController), 2);
  EXPECT_EQ(static_cast<int>(ControllerMode::kOther), 3);
}

template <typename Mode>
void ExpectNamesAreDistinctUpTo(int count) {
  std::set<std::string_view> names;
  for (int value = 0; value < count; ++value) names.insert(Name(static_cast<Mode>(value)));
  EXPECT_EQ(static_cast<int>(names.size()), count);
  EXPECT_FALSE(names.contains("unknown"));
  EXPECT_EQ(Name(static_cast<Mode>(count)), "unknown");
}

TEST(ModeNameTest, EveryModeHasANameOfItsOwnAndNoOtherValueHasOne) {
  ExpectNamesAreDistinctUpTo<RobotMode>(7);
  ExpectNamesAreDistinctUpTo<MotionGeneratorMode>(6);
  ExpectNamesAreDistinctUpTo<ControllerMode>(4);
}

}  // namespace
}  // namespace twin::core_modes_test
