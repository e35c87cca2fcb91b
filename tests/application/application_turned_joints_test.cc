// A joint that an operator turns alone stops before it does harm: in the twin, with its compliance.
#include <gtest/gtest.h>

#include "application/random_operators.h"
#include "twin/teleop/motion_guard.h"

namespace twin::application::application_turned_joints_test {
namespace {

using std::chrono::seconds;
using teleop::ActiveBound;
using teleop::Bound;

/// Holds the key of one joint from the first second on.
class HeldJoint final : public teleop::Device {
 public:
  HeldJoint(std::uint8_t joint, double way, Duration holds_for, ActiveBound& felt)
      : way_(way), holds_for_(holds_for), felt_(felt) {
    sample_.joint = joint;
  }

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override {
    const Duration at = now.time_since_epoch();
    ++sample_.sequence;
    sample_.at = now;
    sample_.axes[0] = at > seconds(1) && at < holds_for_ ? way_ : 0;
    sample_.end_presses = at > holds_for_ ? 1 : 0;
    return sample_;
  }
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override {
    if (sample_.axes[0] != 0) felt_ = feedback.limit;
  }
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "a held key"; }

 private:
  const double way_;
  const Duration holds_for_;
  ActiveBound& felt_;  ///< the bound while the key was held last
  teleop::OperatorSample sample_;
};

struct Turned {
  test::Led led;
  ActiveBound felt;
};

Turned Hold(std::uint8_t joint, double way, const std::optional<JointVector>& from = {}) {
  scenario::Scenario scenario = test::DrawnFor(0);
  if (from) scenario.robot.q_start = *from;
  Turned turned;
  turned.led = test::LetLead(scenario, [&](const teleop::DeviceRequest&) {
    return std::make_unique<HeldJoint>(joint, way, seconds(20), turned.felt);
  });
  return turned;
}

TEST(TurnedJointsTest, StopBeforeEitherEndOfTheirRange) {
  for (std::uint8_t joint = 1; joint <= 7; ++joint) {
    for (const double way : {-1.0, 1.0}) {
      const Turned turned = Hold(joint, way);
      EXPECT_EQ(turned.led.failure, "") << "joint " << int{joint} << ", " << way;
      EXPECT_GT(turned.led.margin, teleop::MotionGuard::kJointMargin - 0.02)
          << "joint " << int{joint} << ", " << way;
      EXPECT_NE(turned.felt.bound, Bound::kNone) << "joint " << int{joint} << ", " << way;
    }
  }
}

TEST(TurnedJointsTest, StopBeforeTheFloor) {
  const Turned turned = Hold(2, 1, JointVector{0, 0.3, 0, -2.0, 0, 2.3, 0.785});
  EXPECT_EQ(turned.led.failure, "");
  EXPECT_EQ(turned.felt, ActiveBound{Bound::kScene});
}

TEST(TurnedJointsTest, AreHarmlessUnderRandomKeys) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const test::Led led = test::LetLead(seed, seconds(60), test::Turns::kJoints);
    EXPECT_EQ(led.failure, "") << "operator " << seed;
    EXPECT_GT(led.margin, 0.01) << "operator " << seed;
  }
}

}  // namespace
}  // namespace twin::application::application_turned_joints_test
