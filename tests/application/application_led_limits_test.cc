// Led motion keeps within a lab's limits, whatever the operator does.
#include <array>
#include <chrono>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "application/random_operators.h"
#include "twin/teleop/motion_guard.h"

namespace twin::application::application_led_limits_test {
namespace {

using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 10s

/// Around the whole arm at the usual start.
model::LabLimits Room() {
  return {.regions = {{"room",
                       {model::LimitedPart::kEndEffector, model::LimitedPart::kElbow,
                        model::LimitedPart::kHand},
                       true,
                       model::LimitBox{{-0.22, -0.35, 0.3}, {0.55, 0.35, 0.85}}}}};
}

/// Leads in one direction after half a second, and keeps what the robot said limits it.
class Pusher final : public teleop::Device {
 public:
  Pusher(const Vector6& axes, std::string& said) : axes_(axes), said_(said) {}

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override {
    ++sample_.sequence;
    sample_.at = now;
    const Duration t = now.time_since_epoch();
    sample_.end_presses = t > 10500ms ? 1 : 0;
    sample_.axes = t > 500ms && t <= 10500ms ? axes_ : Vector6{};
    return sample_;
  }
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override {
    if (sample_.end_presses == 0) said_ = teleop::Describe(feedback.limit);
  }
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "a pusher"; }

 private:
  const Vector6 axes_;
  teleop::OperatorSample sample_;
  std::string& said_;
};

TEST(LedLimitsTest, AHandThatPushesAgainstEachWallStaysInside) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vector6 axes{};
      axes[axis] = side;
      std::string said;
      scenario::Scenario scenario = test::DrawnFor(0);
      scenario.limits = Room();
      const test::Led led = test::LetLead(scenario, [&](const teleop::DeviceRequest&) {
        return std::make_unique<Pusher>(axes, said);
      });
      const std::string which = std::string(side < 0 ? "-" : "+") + "xyz"[axis];
      EXPECT_EQ(led.failure, "") << which;
      EXPECT_GT(led.room, 0.5 * teleop::MotionGuard::kRegionMargin) << which;
      EXPECT_LT(led.room, 2 * teleop::MotionGuard::kRegionMargin) << which;  // it came there
      EXPECT_EQ(said, "the lab's limit 'room' ends here") << which;
    }
  }
}

TEST(LedLimitsTest, RandomOperatorsStayInside) {
  for (const std::uint64_t seed : {0, 3, 6, 9}) {  // those who begin at the usual start
    scenario::Scenario scenario = test::DrawnFor(seed);
    scenario.limits = Room();
    const test::Led led = test::LetLead(scenario, [&](const teleop::DeviceRequest&) {
      return std::make_unique<test::RandomOperator>(seed, test::Turns::kNoJoint,
                                                    scenario.base.has_value(), 20s);
    });
    EXPECT_EQ(led.failure, "") << "operator " << seed;
    EXPECT_GT(led.room, 0) << "operator " << seed;
  }
}

}  // namespace
}  // namespace twin::application::application_led_limits_test
