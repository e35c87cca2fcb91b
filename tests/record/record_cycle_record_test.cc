#include "twin/record/cycle_record.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace twin::record::record_cycle_record_test {
namespace {

// Records, states and commands cross rings and thread exchanges by copy of their bytes.
TEST(CycleRecordTest, IsTriviallyCopyableWithAllItHolds) {
  EXPECT_TRUE(std::is_trivially_copyable_v<CycleRecord>);
  EXPECT_TRUE(std::is_trivially_copyable_v<TickRecord>);
  EXPECT_TRUE(std::is_trivially_copyable_v<RobotState>);
  EXPECT_TRUE(std::is_trivially_copyable_v<RobotCommand>);
  EXPECT_TRUE(std::is_trivially_copyable_v<Violation>);
}

TEST(RobotStateTest, StartsAtRestWithGravityDownAndUnitPoses) {
  const RobotState state;
  EXPECT_EQ(state.O_T_EE, kIdentityTransform);
  EXPECT_EQ(state.O_ddP_O, (Vector3{0, 0, -9.81}));
  EXPECT_EQ(state.motion_generator_mode, MotionGeneratorMode::kIdle);
  EXPECT_TRUE(state.errors.none());
}

}  // namespace
}  // namespace twin::record::record_cycle_record_test
