#include "plant/joint_parameters.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"
#include "twin/plant/friction_law.h"

namespace twin::plant::plant_friction_test {
namespace {

JointVector All(double value) {
  JointVector v{};
  v.fill(value);
  return v;
}

TEST(ResidualFrictionTest, IsZeroAtRest) {
  EXPECT_EQ(ResidualFriction(All(0)), All(0));
}

TEST(ResidualFrictionTest, OpposesMotionAndGrowsWithSpeed) {
  JointVector slower = ResidualFriction(All(-3));
  for (int k = -299; k <= 300; ++k) {
    const double dq = 0.01 * k;
    const JointVector tau = ResidualFriction(All(dq));
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_GE(tau[i] * dq, 0) << "joint " << i + 1 << " at " << dq;
      EXPECT_GE(tau[i], slower[i]) << "joint " << i + 1 << " at " << dq;
    }
    slower = tau;
  }
}

// Between far forward and far backward the sigmoid rises by its height phi1.
TEST(ResidualFrictionTest, SpansPhi1) {
  const JointVector phi1{0.54615, 0.87224, 0.64068, 1.2794, 0.83904, 0.30301, 0.56489};
  const JointVector forward = ResidualFriction(All(50));
  const JointVector backward = ResidualFriction(All(-50));
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(forward[i] - backward[i], phi1[i], 1e-12);
}

TEST(FrictionLawTest, IsGazsSigmoidForHalfItsHeight) {
  FrictionLaw law;
  law.coulomb = {0.273075, 0.43612, 0.32034, 0.6397, 0.41952, 0.151505, 0.282445};
  law.steepness = {5.1181, 9.0657, 10.136, 5.5903, 8.3469, 17.133, 10.336};
  law.shift = {0.039533, 0.025882, -0.04607, 0.036194, 0.026226, -0.021047, 0.0035526};
  for (const double dq : {-2.0, -0.1, 0.0, 0.01, 1.5}) {
    const JointVector expected = ResidualFriction(All(dq));
    const JointVector tau = Friction(law, All(dq));
    for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(tau[i], expected[i], 1e-15);
  }
}

TEST(FrictionLawTest, IsViscousCoulombAndOffsetWhereItIsSteep) {
  FrictionLaw law;
  law.viscous = All(0.2);
  law.coulomb = All(0.5);
  law.offset = All(-0.1);
  EXPECT_NEAR(Friction(law, All(1))[3], 0.2 + 0.5 - 0.1, 1e-12);
  EXPECT_NEAR(Friction(law, All(-1))[3], -0.2 - 0.5 - 0.1, 1e-12);
  EXPECT_EQ(Friction(law, All(0)), law.offset);
  EXPECT_EQ(Friction(FrictionLaw(), All(1)), All(0));
}

TEST(FrictionLawTest, RefusesWhatChattersAndWhatIsOutOfRange) {
  FrictionLaw law;
  law.coulomb = All(0.4);
  law.steepness = All(1000);
  EXPECT_NO_THROW(Validate(law, kArmature));
  EXPECT_EQ(MessageOf<InputError>([&] { Validate(law, {}); }),
            "friction of joint 1: viscous + coulomb * steepness / 2 is 200 Nm s/rad, at which a "
            "joint of 0.041 kg m^2 chatters at 1 kHz; it must be below 82: lower the steepness, or "
            "give the joints their armature");
  law.steepness = All(5000);
  EXPECT_THROW(Validate(law, kArmature), InputError);
  law = {};
  law.viscous[2] = -0.1;
  EXPECT_NE(
      MessageOf<InputError>([&] { Validate(law, kArmature); }).find("friction.viscous of joint 3"),
      std::string::npos);
  law = {};
  law.shift[0] = std::nan("");
  EXPECT_THROW(Validate(law, kArmature), InputError);
}

/// Largest speed of the last second of two, rad/s, after a push on a resting arm held by its
/// gravity torque.
double SpeedAfterPush(const MujocoPlantOptions& options) {
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(kReady);
  double speed = 0;
  for (int k = 0; k < 2000; ++k) {
    JointVector tau = plant->GravityTorque(plant->sensors().q);
    if (k < 20) tau[6] += 1;
    plant->Step({.tau = tau});
    if (k >= 1000) speed = std::max(speed, std::abs(plant->sensors().dq[6]));
  }
  return speed;
}

// The header's bounds: a joint just below comes to rest.
TEST(FrictionLawTest, ComesToRestUpToTheBound) {
  MujocoPlantOptions options = BareOptions();
  options.arm.friction_law.emplace();
  options.arm.friction_law->coulomb = All(0.2);
  options.arm.friction_law->steepness = All(70);
  EXPECT_LT(SpeedAfterPush(options), 1e-6);
  options.armature = true;
  options.arm.friction_law->steepness = All(1900);
  EXPECT_LT(SpeedAfterPush(options), 1e-6);
}

TEST(FrictionLawTest, ActsInThePlantInPlaceOfTheProfile) {
  MujocoPlantOptions options = BareOptions();
  options.friction = FrictionProfile::kResidual;
  const auto residual = MujocoPlant::Create(options);
  options.friction = FrictionProfile::kBreakaway;
  options.arm.friction_law.emplace();
  options.arm.friction_law->coulomb = {0.273075, 0.43612,  0.32034, 0.6397,
                                       0.41952,  0.151505, 0.282445};
  options.arm.friction_law->steepness = {5.1181, 9.0657, 10.136, 5.5903, 8.3469, 17.133, 10.336};
  options.arm.friction_law->shift = {0.039533, 0.025882,  -0.04607, 0.036194,
                                     0.026226, -0.021047, 0.0035526};
  const auto law = MujocoPlant::Create(options);
  for (MujocoPlant* plant : {residual.get(), law.get()}) {
    plant->Reset(kReady);
    for (int k = 0; k < 200; ++k) plant->Step({.tau = {1, -5, 1, 15, 1, 1, 0.1}});
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(law->sensors().q[i], residual->sensors().q[i], 1e-12);
  }
}

}  // namespace
}  // namespace twin::plant::plant_friction_test
