// What is promised of commanded poses (VIABILITY.md, "Poses"): speed, acceleration and jerk of
// translation and rotation, whatever is wished and lost; and what is aimed at of the joints.
#include "twin/reference/viable_twist.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "reference/hostile_world.h"
#include "support/panda_limits.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/model/transform.h"
#include "twin/onboard/cartesian_reference.h"
#include "twin/onboard/kinematic_completion.h"
#include "twin/reference/pose_viability_filter.h"

namespace twin::reference::reference_viable_twist_test {
namespace {

using Eigen::Vector3d;

constexpr double kT = kCycleSeconds;
constexpr double kRelative = 1 + 1e-9;

CartesianBound Translation() {
  return test::PandaCartesianLimits().translation;
}

struct Motion {
  Vector3d v = Vector3d::Zero();
  Vector3d a = Vector3d::Zero();

  [[nodiscard]] Motion After(const Vector3d& v_c) const { return {v_c, (v_c - v) / kT}; }
  [[nodiscard]] Motion AfterLoss() const { return {v + kT * a, a}; }
};

/// Wishes that jump about in all directions, most of them far beyond the limits.
class WildWish {
 public:
  explicit WildWish(std::uint64_t seed) : random_(seed, RandomStream::kTest) {}
  Vector3d Next() {
    if (Draw() < 0.02) {
      for (double& value : wish_) value = Draw() - 0.5;
      wish_ *= Draw() < 0.5 ? 1e3 : 4;
    }
    return wish_;
  }

 private:
  double Draw() { return random_.Uniform(++draws_); }
  Random random_;
  std::uint64_t draws_ = 0;
  Vector3d wish_ = Vector3d::Zero();
};

class ViableTwistTest : public ::testing::TestWithParam<int> {};

TEST_P(ViableTwistTest, KeepsItsBoundsWhateverIsWishedAndLost) {
  const CartesianBound bound = Translation();
  const ViableTwist twist(bound, GetParam(), "translation");
  HostileWorld world(GetParam(), 7);
  WildWish wish(7);
  Motion x;
  double fastest = 0;
  for (int k = 0; k < 100000; ++k) {
    const Motion last = x;
    const Vector3d wished = wish.Next();
    x = world.Loses() ? x.AfterLoss() : x.After(twist.Nearest(x.v, x.a, wished));
    fastest = std::max(fastest, x.v.norm());
    ASSERT_LE(x.v.norm(), bound.dp_max * kRelative) << k;
    ASSERT_LE(x.a.norm(), bound.ddp_max * kRelative) << k;
    ASSERT_LE((x.a - last.a).norm() / kT, bound.dddp_max * kRelative) << k;
  }
  EXPECT_GT(fastest, 0.99 * bound.dp_max) << "it never came near its border: nothing was shown";
}

TEST_P(ViableTwistTest, FromAViableStateBrakingIsAlwaysAllowed) {
  const CartesianBound bound = Translation();
  const ViableTwist twist(bound, GetParam(), "translation");
  const Random random(11, RandomStream::kTest);
  std::uint64_t draw = 0;
  const auto in = [&](double most) {
    Vector3d x;
    for (double& value : x) value = most * (2 * random.Uniform(++draw) - 1);
    return x;
  };
  int viable = 0;
  for (int k = 0; k < 20000; ++k) {
    Motion x{in(bound.dp_max), in(bound.ddp_max)};
    if (!twist.Contains(x.v, x.a)) continue;
    ++viable;
    for (int lost = 0; lost <= GetParam(); ++lost, x = x.AfterLoss()) {
      ASSERT_LE(x.v.norm(), bound.dp_max * kRelative);
      // A wish that cannot be met: what comes out then must still be allowed.
      ASSERT_TRUE(twist.Allows(x.v, x.a, twist.Nearest(x.v, x.a, 1e6 * x.v))) << lost;
    }
  }
  EXPECT_GT(viable, 1000);
}

INSTANTIATE_TEST_SUITE_P(Losses, ViableTwistTest, ::testing::Values(0, 3, 19));

TEST(ViableTwistTest, AnAllowedWishPassesAsItIs) {
  const ViableTwist twist(Translation(), 19, "translation");
  const Vector3d v(0.1, 0.2, -0.3);
  const Vector3d wish = v + Vector3d(1e-3, 0, 2e-3);
  EXPECT_EQ(twist.Nearest(v, Vector3d::Zero(), wish), wish);
}

TEST(ViableTwistTest, AWishThatIsNoNumberBrakes) {
  const ViableTwist twist(Translation(), 19, "translation");
  const Vector3d v(0.1, 0, 0);
  const Vector3d nan = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(twist.Nearest(v, Vector3d::Zero(), nan), v);
}

TEST(ViableTwistTest, SlowsToRestWithoutOvershoot) {
  const ViableTwist twist(Translation(), 19, "translation");
  Motion x{{1.0, -0.5, 0.2}, {2, 3, -1}};
  const Vector3d way = x.v.normalized();
  for (int k = 0; k < 1000; ++k) {
    x = x.After(twist.Slowed(x.v, x.a));
    ASSERT_GT(x.v.dot(way), -1e-4) << k;
  }
  EXPECT_LT(x.v.norm(), 1e-9);
}

TEST(ViableTwistTest, RefusesASpeedThatIsGatheredWithinTheLosses) {
  CartesianBound bound = Translation();
  bound.dp_max = 0.3;
  try {
    const ViableTwist twist(bound, 19, "translation");
    FAIL() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("translation: its velocity limit of 0.3"),
              std::string::npos)
        << error.what();
  }
}

/// The robot's side: its own completion of poses, by its own rules for what is lost.
class Robot {
 public:
  Robot() {
    joints_.q_d = {0, -0.4, 0, -2.0, 0, 1.6, 0.785};
    const model::ArmModel& arm = model::ArmModel::Panda();
    pose_ = onboard::CartesianReference::Rest(arm.Pose(model::Frame::kFlange, joints_.q_d),
                                              model::ElbowOf(joints_.q_d));
  }
  [[nodiscard]] RobotState State() const {
    RobotState state;
    state.q_d = joints_.q_d;
    state.dq_d = joints_.dq_d;
    state.ddq_d = joints_.ddq_d;
    state.F_T_EE = kIdentityTransform;
    state.O_T_EE_c = pose_.O_T_EE_c;
    state.O_dP_EE_c = pose_.O_dP_EE_c;
    state.O_ddP_EE_c = pose_.O_ddP_EE_c;
    return state;
  }
  void Take(const Transform& O_T_EE_c) { Complete(pose_.AfterPose(O_T_EE_c)); }
  void Lose() { Complete(pose_.AfterLoss()); }
  [[nodiscard]] const onboard::CartesianReference& pose() const { return pose_; }
  [[nodiscard]] const onboard::JointReference& joints() const { return joints_; }

 private:
  void Complete(const onboard::CartesianReference& next) {
    const auto step = completion_.Complete(joints_, lag_, next.O_T_EE_c, {});
    joints_ = joints_.AfterPosition(step.q_d);
    lag_ = step.lag;
    pose_ = next;
  }
  const onboard::KinematicCompletion completion_;
  onboard::KinematicCompletion::Lag lag_{};
  onboard::JointReference joints_;
  onboard::CartesianReference pose_;
};

double Norm(const Vector6& x, std::size_t first) {
  return std::hypot(x[first], x[first + 1], x[first + 2]);
}

void ExpectWithin(const Vector6& x, double CartesianBound::*bound) {
  const CartesianLimits limits = test::PandaCartesianLimits();
  EXPECT_LE(Norm(x, 0), limits.translation.*bound * (1 + 1e-5));
  EXPECT_LE(Norm(x, 3), limits.rotation.*bound * (1 + 1e-5));
}

TEST(PoseViabilityFilterTest, KeepsTheLimitsOfTheEndEffectorWhateverIsWishedAndLost) {
  const PoseViabilityFilter filter(test::PandaCartesianLimits(), test::PandaLimits());
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Robot robot;
    HostileWorld world(19, seed);
    WildWish wish(seed);
    WildWish turn(seed + 100);
    for (int k = 0; k < 1000; ++k) {
      const Transform aim =
          model::Turned(robot.pose().O_T_EE_c, 1e-3 * turn.Next(),
                        model::Position(robot.pose().O_T_EE_c) + 1e-3 * wish.Next());
      if (world.Loses()) {
        robot.Lose();
      } else {
        robot.Take(filter.Next(robot.State(), aim).O_T_EE_c);
      }
      ExpectWithin(robot.pose().O_dP_EE_c, &CartesianBound::dp_max);
      ExpectWithin(robot.pose().O_ddP_EE_c, &CartesianBound::ddp_max);
      ExpectWithin(robot.pose().O_dddP_EE_c, &CartesianBound::dddp_max);
      ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed << ", cycle " << k;
    }
  }
}

TEST(PoseViabilityFilterTest, StopsBeforeALimitOfTheJointsThatComesSlowly) {
  const JointLimits limits = test::PandaLimits();
  const PoseViabilityFilter filter(test::PandaCartesianLimits(), limits);
  Robot robot;
  bool slowed = false;
  for (int k = 0; k < 8000; ++k) {  // turns about the flange's axis at 0.6 rad/s: joint 7's range
    const Vector3d axis(robot.pose().O_T_EE_c[8], robot.pose().O_T_EE_c[9],
                        robot.pose().O_T_EE_c[10]);
    const double rate = 0.6 * std::min(1.0, k / 500.0);
    const auto outcome =
        filter.Next(robot.State(), model::Turned(robot.pose().O_T_EE_c, kT * rate * axis,
                                                 model::Position(robot.pose().O_T_EE_c)));
    slowed = slowed || outcome.active;
    robot.Take(outcome.O_T_EE_c);
    for (std::size_t i = 0; i < kJoints; ++i) {
      ASSERT_GE(robot.joints().q_d[i], limits.q_min[i]) << "joint " << i + 1 << ", cycle " << k;
      ASSERT_LE(robot.joints().q_d[i], limits.q_max[i]) << "joint " << i + 1 << ", cycle " << k;
      ASSERT_LE(std::abs(robot.joints().dq_d[i]), limits.dq_max[i]) << "joint " << i + 1;
      ASSERT_LE(std::abs(robot.joints().ddq_d[i]), limits.ddq_max[i]) << "joint " << i + 1;
    }
  }
  EXPECT_TRUE(slowed);
}

TEST(PoseViabilityFilterTest, AnAdmissiblePosePassesBitForBit) {
  const PoseViabilityFilter filter(test::PandaCartesianLimits(), test::PandaLimits());
  Robot robot;
  const Transform start = robot.pose().O_T_EE_c;
  for (int k = 1; k <= 2000; ++k) {  // there and back, 5 cm, by a smooth law
    const double s = 0.025 * (1 - std::cos(2 * std::numbers::pi * k / 2000.0));
    Transform aim = start;
    aim[12] += s;
    const auto outcome = filter.Next(robot.State(), aim);
    ASSERT_EQ(outcome.O_T_EE_c, aim) << k;
    ASSERT_FALSE(outcome.active) << k;
    robot.Take(outcome.O_T_EE_c);
  }
}

}  // namespace
}  // namespace twin::reference::reference_viable_twist_test
