#include "support/panda_limits.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "twin/scenario/robot_data.h"

namespace twin::test {
namespace {

TEST(PandaLimitsTest, AreThoseOfTheLimitsFile) {
  const std::filesystem::path file =
      std::filesystem::path(TWIN_SOURCE_DIR) / "models/robots/panda/limits.yaml";
  const JointLimits from_file = scenario::LoadJointLimits(file);
  const JointLimits typed = PandaLimits();
  EXPECT_EQ(typed.q_min, from_file.q_min);
  EXPECT_EQ(typed.q_max, from_file.q_max);
  EXPECT_EQ(typed.dq_max, from_file.dq_max);
  EXPECT_EQ(typed.ddq_max, from_file.ddq_max);
  EXPECT_EQ(typed.dddq_max, from_file.dddq_max);
  EXPECT_EQ(typed.tau_max, from_file.tau_max);
  EXPECT_EQ(typed.dtau_max, from_file.dtau_max);
}

}  // namespace
}  // namespace twin::test
