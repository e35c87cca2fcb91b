#include "twin/core/limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

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
