#include "support/panda_limits.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "support/fr3_limits.h"
#include "twin/scenario/robot_data.h"

namespace twin::test::panda_limits_test {
namespace {

const std::filesystem::path kFile =
    std::filesystem::path(TWIN_SOURCE_DIR) / "models/robots/panda/limits.yaml";

void ExpectSame(const CartesianBound& typed, const CartesianBound& from_file) {
  EXPECT_EQ(typed.dp_max, from_file.dp_max);
  EXPECT_EQ(typed.ddp_max, from_file.ddp_max);
  EXPECT_EQ(typed.dddp_max, from_file.dddp_max);
}

TEST(PandaLimitsTest, OfTheEndEffectorAreThoseOfTheLimitsFile) {
  const CartesianLimits from_file = scenario::LoadCartesianLimits(kFile);
  const CartesianLimits typed = PandaCartesianLimits();
  ExpectSame(typed.translation, from_file.translation);
  ExpectSame(typed.rotation, from_file.rotation);
  ExpectSame(typed.elbow, from_file.elbow);
}

void ExpectSame(const JointLimits& typed, const JointLimits& from_file) {
  EXPECT_EQ(typed.q_min, from_file.q_min);
  EXPECT_EQ(typed.q_max, from_file.q_max);
  EXPECT_EQ(typed.dq_max, from_file.dq_max);
  EXPECT_EQ(typed.ddq_max, from_file.ddq_max);
  EXPECT_EQ(typed.dddq_max, from_file.dddq_max);
  EXPECT_EQ(typed.tau_max, from_file.tau_max);
  EXPECT_EQ(typed.dtau_max, from_file.dtau_max);
  EXPECT_EQ(typed.velocity_offset, from_file.velocity_offset);
  EXPECT_EQ(typed.deceleration, from_file.deceleration);
}

TEST(PandaLimitsTest, AreThoseOfTheLimitsFile) {
  ExpectSame(PandaLimits(), scenario::LoadJointLimits(kFile));
}

TEST(Fr3LimitsTest, AreThoseOfTheLimitsFile) {
  ExpectSame(Fr3Limits(), scenario::LoadJointLimits(std::filesystem::path(TWIN_SOURCE_DIR) /
                                                    "models/robots/fr3/limits.yaml"));
}

}  // namespace
}  // namespace twin::test::panda_limits_test
