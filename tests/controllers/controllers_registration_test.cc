#include "controllers/registration.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "twin/core/error.h"

namespace twin::controllers::controllers_registration_test {
namespace {

using control::CommandInterface;
using ::testing::HasSubstr;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1s

constexpr JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
constexpr CommandInterface kInterfaces[] = {
    CommandInterface::kJointPosition, CommandInterface::kJointVelocity,
    CommandInterface::kCartesianPose, CommandInterface::kTorque};

class RegistrationTest : public ::testing::Test {
 protected:
  RegistrationTest() { RegisterControllers(registry_); }

  /// Nothing when it is made; else why not.
  [[nodiscard]] std::string WhyNot(const std::string& type, CommandInterface interface,
                                   bool of_poses = false) const {
    try {
      const auto controller = registry_.Find(type)({.trajectory = trajectory_,
                                                    .interface = interface,
                                                    .poses = of_poses ? &poses_ : nullptr});
      EXPECT_EQ(controller->command_interface(), interface) << type;
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  control::ControllerRegistry registry_;
  const reference::Trajectory trajectory_{
      {{.q = kReady, .at = 0s}, {.q = kReady, .at = 1s}}, {}, twin::test::PandaLimits()};
  const reference::PoseTrajectory poses_{
      {{.at = 0s}, {.at = 1s}}, {}, twin::test::PandaCartesianLimits()};
};

TEST_F(RegistrationTest, EachControllerIsMadeForItsOwnInterfacesOnly) {
  for (const std::string& type : registry_.Names()) {
    int made = 0;
    for (const CommandInterface interface : kInterfaces) {
      const std::string why = WhyNot(type, interface);
      made += why.empty() ? 1 : 0;
      if (!why.empty()) {
        EXPECT_THAT(why, HasSubstr("motion.interface to ")) << type;
      }
    }
    EXPECT_EQ(made, type == "joint_trajectory" ? 3 : 1) << type;
  }
  EXPECT_EQ(registry_.Names().size(), 8u);
}

TEST_F(RegistrationTest, WhoFollowsJointsRefusesPoses) {
  for (const auto& [type, interface] : {
           std::pair<std::string, CommandInterface>("joint_trajectory",
                                                    CommandInterface::kJointPosition),
           {"joint_position", CommandInterface::kJointPosition},
           {"joint_velocity", CommandInterface::kJointVelocity},
           {"joint_trajectory_effort", CommandInterface::kTorque},
           {"joint_effort", CommandInterface::kTorque},
       }) {
    EXPECT_THAT(WhyNot(type, interface, true), HasSubstr("the motion is one of poses")) << type;
  }
  EXPECT_EQ(WhyNot("cartesian_pose", CommandInterface::kJointPosition, true), "");
  EXPECT_EQ(WhyNot("compliance", CommandInterface::kTorque, true), "");
  EXPECT_EQ(WhyNot("gravity_hold", CommandInterface::kTorque, true), "");
}

}  // namespace
}  // namespace twin::controllers::controllers_registration_test
