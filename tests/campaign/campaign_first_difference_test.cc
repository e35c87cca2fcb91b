#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "campaign/first_difference.h"
#include "plugins/backends.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign::campaign_first_difference_test {
namespace {

using ::testing::MatchesRegex;

/// Holds still, but for a torque that after 100 updates is another in each run.
class Forgetful final : public control::Controller {
 public:
  explicit Forgetful(double tau) : tau_(tau) {}

  control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }
  void Activate(const RobotState& /*state*/, Time /*now*/) override {}
  void Update(const RobotState& /*state*/, Time /*now*/,
              control::ControllerOutput& output) noexcept override {
    ++updates_;
    output.target.tau_J_d = {0, 0, updates_ > 100 ? tau_ : 0, 0, 0, 0, 0};
    output.finished = updates_ > 200;
  }
  void Deactivate() noexcept override {}

 private:
  const double tau_;
  int updates_ = 0;
};

/// @param step  of the torque from run to run, Nm.
std::string DifferenceWith(double step) {
  backend::Registry backends;
  plugins::RegisterMujoco(backends);
  control::ControllerRegistry controllers;
  int runs = 0;
  controllers.Add("forgetful", [&](const control::ControllerRequest& /*request*/) {
    return std::make_unique<Forgetful>(step * ++runs);
  });
  const scenario::Scenario world = scenario::Parse(R"(name: forgetful
plant: {kind: ideal}
controller: {type: forgetful}
motion:
  interface: torque
  trajectory: {unit: rad, waypoints: [{q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}, {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}]}
)",
                                                   "forgetful.yaml");
  return FirstDifference(world, {backends, controllers},
                         {TWIN_SOURCE_DIR "/models", {}, {}, false});
}

TEST(FirstDifference, NamesTheFirstStateAndValue) {
  EXPECT_THAT(
      DifferenceWith(0.01),
      MatchesRegex(
          R"(of two more runs, tau_J_d\[2\] of state 1[0-9][0-9] is 0.0[0-9.]* and 0.0[0-9.]*)"));
}

TEST(FirstDifference, SaysThatThereIsNone) {
  EXPECT_EQ(DifferenceWith(0), "two more runs are alike");
}

}  // namespace
}  // namespace twin::campaign::campaign_first_difference_test
