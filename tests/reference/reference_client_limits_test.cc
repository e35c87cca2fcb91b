#include "twin/reference/rate_limiter.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "reference/reference_samples.h"
#include "support/panda_limits.h"
#include "twin/core/error.h"

namespace twin::reference::reference_client_limits_test {
namespace {

using testing::AllOf;
using testing::DoubleNear;
using testing::HasSubstr;
using testing::Pointwise;
using testing::ThrowsMessage;

constexpr double kRounding = 1e-9;

void ExpectBound(const CartesianBound& bound, double dp, double ddp, double dddp) {
  EXPECT_NEAR(bound.dp_max, dp, kRounding);
  EXPECT_NEAR(bound.ddp_max, ddp, kRounding);
  EXPECT_NEAR(bound.dddp_max, dddp, kRounding);
}

TEST(ClientLimitsTest, GivesLibfrankasNumbersOfThePandasJoints) {
  const ClientLimits limits = PandaClientLimits();
  EXPECT_THAT(limits.dtau_max, Pointwise(DoubleNear(kRounding), Filled(999.999)));
  EXPECT_THAT(limits.dddq_max,
              Pointwise(DoubleNear(kRounding), JointVector{7499.999, 3749.999, 4999.999, 6249.999,
                                                           7499.999, 9999.999, 9999.999}));
  EXPECT_THAT(limits.ddq_max,
              Pointwise(DoubleNear(kRounding),
                        JointVector{14.999, 7.499, 9.999, 12.499, 14.999, 19.999, 19.999}));
  EXPECT_THAT(limits.dq_max,
              Pointwise(DoubleNear(kRounding), JointVector{2.129003, 2.151503, 2.144003, 2.136503,
                                                           2.564003, 2.549003, 2.549003}));
}

TEST(ClientLimitsTest, GivesLibfrankasNumbersOfThePandasEndEffector) {
  const ClientLimits limits = PandaClientLimits();
  ExpectBound(limits.translation, 1.960003, 12.999, 6499.999);
  ExpectBound(limits.rotation, 2.424003, 24.999, 12499.999);
  ExpectBound(limits.elbow, 2.144003, 9.999, 4999.999);
}

// libfranka's own, which no data of a robot change: the robot may be slower than that.
TEST(ClientLimitsTest, ReckonsFromLibfrankasTranslationalVelocityWhateverTheRobots) {
  CartesianLimits cartesian = test::PandaCartesianLimits();
  ASSERT_EQ(cartesian.translation.dp_max, 1.7);
  for (const double dp_max : {1.0, 3.0}) {
    cartesian.translation.dp_max = dp_max;
    const ClientLimits limits = ClientLimits::Of(test::PandaLimits(), cartesian);
    EXPECT_NEAR(limits.translation.dp_max, 2.0 - 1e-3 - 3 * 1e-3 * (13.0 - 1e-3), kRounding);
  }
}

TEST(ClientLimitsTest, StaysWithinTheRobotsVelocityForThreeLostPackets) {
  const JointLimits robot = test::PandaLimits();
  const ClientLimits client = PandaClientLimits();
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_LT(client.dq_max[j] + 3 * 1e-3 * client.ddq_max[j], robot.dq_max[j]);
  }
}

TEST(ClientLimitsTest, RefusesALimitOfWhichNothingIsLeft) {
  JointLimits joint = test::PandaLimits();
  joint.dq_max[2] = 0.030997;  // 1e-3 and three packets at 9.999 rad/s^2
  EXPECT_THAT([&] { (void)ClientLimits::Of(joint, test::PandaCartesianLimits()); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("dq_max of joint 3 is 0.030997"), HasSubstr("above 0.030997"))));
  joint.dq_max[2] = 0.032;
  EXPECT_NEAR(ClientLimits::Of(joint, test::PandaCartesianLimits()).dq_max[2], 0.001003, kRounding);

  CartesianLimits cartesian = test::PandaCartesianLimits();
  cartesian.elbow.dddp_max = 1e-3;
  EXPECT_THAT([&] { (void)ClientLimits::Of(test::PandaLimits(), cartesian); },
              ThrowsMessage<InputError>(HasSubstr("dddp_max of the elbow is 0.001")));
}

TEST(ClientLimitsTest, RefusesWhatIsNoFiniteNumber) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1.0}) {
    for (const auto field : {&JointLimits::dq_max, &JointLimits::ddq_max, &JointLimits::dddq_max,
                             &JointLimits::dtau_max}) {
      JointLimits joint = test::PandaLimits();
      (joint.*field)[6] = bad;
      EXPECT_THAT([&] { (void)ClientLimits::Of(joint, test::PandaCartesianLimits()); },
                  ThrowsMessage<InputError>(HasSubstr("joint 7")));
    }
    for (const auto field :
         {&CartesianBound::dp_max, &CartesianBound::ddp_max, &CartesianBound::dddp_max}) {
      CartesianLimits cartesian = test::PandaCartesianLimits();
      cartesian.rotation.*field = bad;
      EXPECT_THAT([&] { (void)ClientLimits::Of(test::PandaLimits(), cartesian); },
                  ThrowsMessage<InputError>(HasSubstr("the rotation")));
    }
  }
}

}  // namespace
}  // namespace twin::reference::reference_client_limits_test
