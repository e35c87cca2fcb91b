#include "twin/core/limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "support/fr3_limits.h"
#include "support/panda_limits.h"
#include "twin/core/error.h"

namespace twin::core_limits_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The text Validate() refuses the limits with; empty when it accepts them.
std::string RefusalOf(const JointLimits& limits) {
  try {
    limits.Validate();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(JointLimitsTest, AcceptsThePanda) {
  EXPECT_EQ(RefusalOf(test::PandaLimits()), "");
}

TEST(JointLimitsTest, RefusesAnEmptyPositionRange) {
  JointLimits limits = test::PandaLimits();
  limits.q_max[3] = limits.q_min[3];
  EXPECT_THAT(RefusalOf(limits), AllOf(HasSubstr("joint 4"), HasSubstr("-3.0718")));
}

TEST(JointLimitsTest, RefusesAPositionThatIsNoNumber) {
  JointLimits limits = test::PandaLimits();
  limits.q_min[0] = kNan;
  EXPECT_THAT(RefusalOf(limits), HasSubstr("joint 1"));
  limits = test::PandaLimits();
  limits.q_max[6] = kInfinity;
  EXPECT_THAT(RefusalOf(limits), HasSubstr("joint 7"));
}

TEST(JointLimitsTest, TheVelocityShrinksTowardsTheEndsWhereItDependsOnThePosition) {
  const JointLimits fr3 = test::Fr3Limits();
  EXPECT_EQ(fr3.VelocityLimit(0, 0, 1), 2.62);
  EXPECT_NEAR(fr3.VelocityLimit(0, fr3.q_max[0] - 0.12, 1), 0.9, 1e-9);
  EXPECT_EQ(fr3.VelocityLimit(0, fr3.q_max[0] - 0.12, -1), 2.62);
  EXPECT_NEAR(fr3.VelocityLimit(0, fr3.q_min[0] + 0.12, -1), 0.9, 1e-9);
  EXPECT_NEAR(fr3.StillZone(0), 0.0075, 1e-12);
  EXPECT_EQ(fr3.VelocityLimit(0, fr3.q_max[0] - 0.0074, 1), 0);
  EXPECT_GT(fr3.VelocityLimit(0, fr3.q_max[0] - 0.0076, 1), 0);
  EXPECT_EQ(test::PandaLimits().StillZone(0), 0);
  EXPECT_EQ(test::PandaLimits().VelocityLimit(0, 2.8, 1), 2.175);
}

struct Magnitude {
  const char* field;
  JointVector JointLimits::*values;
};
void PrintTo(const Magnitude& magnitude, std::ostream* out) {
  *out << magnitude.field;
}

class JointLimitsMagnitudeTest : public testing::TestWithParam<Magnitude> {};

TEST_P(JointLimitsMagnitudeTest, RefusesWhatIsNotAboveZeroAndFinite) {
  for (const double bad : {0.0, -1.0, kNan, kInfinity}) {
    JointLimits limits = test::PandaLimits();
    (limits.*GetParam().values)[4] = bad;
    EXPECT_THAT(RefusalOf(limits), AllOf(HasSubstr(GetParam().field), HasSubstr("joint 5"))) << bad;
  }
}

INSTANTIATE_TEST_SUITE_P(AllFields, JointLimitsMagnitudeTest,
                         testing::Values(Magnitude{"dq_max", &JointLimits::dq_max},
                                         Magnitude{"ddq_max", &JointLimits::ddq_max},
                                         Magnitude{"dddq_max", &JointLimits::dddq_max},
                                         Magnitude{"tau_max", &JointLimits::tau_max},
                                         Magnitude{"dtau_max", &JointLimits::dtau_max}),
                         [](const auto& info) { return std::string(info.param.field); });

}  // namespace
}  // namespace twin::core_limits_test
