#include "twin/onboard/kinematic_completion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "model/model_samples.h"
#include "support/dense.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/random.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/model/transform.h"

namespace twin::onboard::onboard_kinematic_completion_test {
namespace {

using model::kHandPose;
using model::kReady;
using std::numbers::pi;

constexpr double kT = 1e-3;
constexpr double kFlipAngle = -0.467002423653011;

Transform PoseOf(const JointVector& q) {
  return model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q, kHandPose);
}

double DexterityOf(const JointVector& q, bool joint_3_moves) {
  return model::InverseKinematics(model::ArmModel::Panda().ZeroJacobian(model::Frame::kFlange, q),
                                  {.joint_3_moves = joint_3_moves})
      .dexterity();
}

template <typename Array>
double Largest(const Array& x) {
  double largest = 0;
  for (const double value : x) {
    if (!std::isfinite(value)) return INFINITY;
    largest = std::max(largest, std::abs(value));
  }
  return largest;
}

template <typename Array>
double Apart(const Array& a, const Array& b) {
  Array difference = a;
  for (std::size_t i = 0; i < a.size(); ++i) difference[i] -= b[i];
  return Largest(difference);
}

/// The completion with its memory, as the motion generator keeps it.
struct Follower {
  explicit Follower(const JointVector& q) : joints(JointReference::Rest(q)) {}

  void Follow(const Transform& O_T_EE_c, const std::optional<double>& elbow) {
    step = completion.Complete(joints, step.lag, O_T_EE_c, elbow);
    joints = joints.AfterPosition(step.q_d);
  }

  KinematicCompletion completion{kHandPose};
  JointReference joints;
  KinematicCompletion::Step step;
};

/// A smooth joint path about a random configuration, at rest at t = 0.
struct JointPath {
  explicit JointPath(std::uint64_t index) : center(model::SampleOf(index).q) {
    const Random random(index, RandomStream::kTest);
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      amplitude[i] = 0.3 * (2 * random.Uniform(1, i) - 1);
      rate[i] = 1 + 2 * random.Uniform(2, i);
    }
  }
  [[nodiscard]] JointVector At(int cycle) const {
    const double t = cycle * kT;
    JointVector q = center;
    for (std::size_t i = 0; i < kJoints; ++i) q[i] += amplitude[i] * (1 - std::cos(rate[i] * t));
    return q;
  }
  /// Is the completion exact all along, and a little more?
  [[nodiscard]] bool IsRegular(int cycles, bool joint_3_moves) const {
    for (int k = 0; k <= cycles; k += 20) {
      if (DexterityOf(At(k), joint_3_moves) < 1.3 * KinematicCompletion::kDampedBelow) return false;
    }
    return true;
  }

  JointVector center;
  JointVector amplitude{};
  JointVector rate{};
};

TEST(KinematicCompletionTest, WithAnElbowItFindsTheJointsThatMadeThePose) {
  constexpr int kCycles = 1000;
  int paths = 0;
  for (std::uint64_t index = 0; index < 60; ++index) {
    const JointPath path(index);
    if (!path.IsRegular(kCycles, false)) continue;
    ++paths;
    Follower follower(path.At(0));
    for (int k = 1; k <= kCycles; ++k) {
      const JointVector q = path.At(k);
      follower.Follow(PoseOf(q), q[2]);
      ASSERT_LT(Apart(follower.step.q_d, q), 1e-10) << "path " << index << ", cycle " << k;
      ASSERT_LT(Apart(follower.step.O_T_EE_d, PoseOf(q)), 1e-11);
      ASSERT_EQ(follower.step.q_d[2], q[2]);
      ASSERT_EQ(follower.step.lag, Vector6{});
    }
  }
  EXPECT_GE(paths, 15);
}

TEST(KinematicCompletionTest, ItsRoundingMakesNoJerk) {
  std::uint64_t index = 0;
  while (!JointPath(index).IsRegular(2000, false)) ++index;
  const JointPath path(index);
  Follower follower(path.At(0));
  JointReference exact = JointReference::Rest(path.At(0));
  for (int k = 1; k <= 2000; ++k) {
    const JointVector q = path.At(k);
    exact = exact.AfterPosition(q);
    follower.Follow(PoseOf(q), q[2]);
    // The smallest limit is 3750 rad/s^3.
    ASSERT_LT(Apart(follower.joints.dddq_d, exact.dddq_d), 0.5) << "cycle " << k;
  }
}

TEST(KinematicCompletionTest, ReachesAStepThatNothingAnnounced) {
  for (std::uint64_t k = 0; k < 200; ++k) {
    const model::Sample sample = model::SampleOf(k);
    if (DexterityOf(sample.q, false) < 1.3 * KinematicCompletion::kDampedBelow) continue;
    JointVector q = sample.q;
    for (std::size_t i = 0; i < kJoints; ++i) q[i] += kT * sample.dq[i];
    for (const bool has_elbow : {false, true}) {
      Follower follower(sample.q);
      follower.Follow(PoseOf(q), has_elbow ? std::optional(q[2]) : std::nullopt);
      EXPECT_LT(Apart(follower.step.O_T_EE_d, PoseOf(q)), 1e-10) << "sample " << k;
    }
  }
}

TEST(KinematicCompletionTest, WithoutAnElbowItReachesThePoseByTheSmallestSteps) {
  constexpr int kCycles = 1000;
  int paths = 0;
  for (std::uint64_t index = 0; index < 60; ++index) {
    const JointPath path(index);
    if (!path.IsRegular(kCycles, true)) continue;
    ++paths;
    Follower follower(path.At(0));
    for (int k = 1; k <= kCycles; ++k) {
      const JointVector before = follower.joints.q_d;
      follower.Follow(PoseOf(path.At(k)), std::nullopt);
      // The elbow goes its own way, and may lead to where the arm is singular.
      if (DexterityOf(before, true) < 1.1 * KinematicCompletion::kDampedBelow) break;
      ASSERT_LT(Apart(follower.step.O_T_EE_d, PoseOf(path.At(k))), 1e-11)
          << "path " << index << ", cycle " << k;
      // Of all steps that reach it, the smallest is orthogonal to the null space.
      const model::Jacobian J =
          model::ArmModel::Panda().ZeroJacobian(model::Frame::kFlange, follower.step.q_d);
      const Eigen::VectorXd null =
          test::NullVector(Eigen::Map<const Eigen::Matrix<double, 6, 7>>(J.data()));
      const Eigen::Map<const Eigen::Matrix<double, 7, 1>> dq(follower.joints.dq_d.data());
      ASSERT_LT(std::abs(null.dot(dq)), 0.02 * dq.norm() + 1e-9);
    }
  }
  EXPECT_GE(paths, 15);
}

TEST(KinematicCompletionTest, RepeatingThePoseOfTheJointsIsExactlyNoMotion) {
  for (std::uint64_t k = 0; k < 300; ++k) {
    const JointVector q = model::SampleOf(k).q;
    for (const bool has_elbow : {false, true}) {
      Follower follower(q);
      if (follower.completion.IsSingular(q)) continue;
      const std::optional<double> elbow = has_elbow ? std::optional(q[2]) : std::nullopt;
      for (int i = 0; i < 3; ++i) {
        follower.Follow(PoseOf(q), elbow);
        ASSERT_EQ(follower.step.q_d, q) << "sample " << k;
        ASSERT_EQ(follower.step.O_T_EE_d, PoseOf(q));
        ASSERT_EQ(follower.step.O_dP_EE_d, Vector6{});
      }
    }
  }
}

TEST(KinematicCompletionTest, ComesToRestExactlyWithThePose) {
  for (const bool has_elbow : {false, true}) {
    Follower follower(kReady);
    Transform X = PoseOf(kReady);
    for (int k = 0; k < 1005; ++k) {
      const double u = 0.5 * (1 - std::cos(pi * std::min(k, 1000) * kT));
      X[13] = 0.2 * u;
      follower.Follow(X, has_elbow ? std::optional(0.1 * u) : std::nullopt);
    }
    EXPECT_TRUE(follower.joints.AtRest());
    EXPECT_LT(Apart(follower.step.O_T_EE_d, X), 1e-12);
  }
}

TEST(KinematicCompletionTest, ItsTwistIsThatOfTheStep) {
  const JointPath path(2);
  Follower follower(path.At(0));
  for (int k = 1; k <= 300; ++k) follower.Follow(PoseOf(path.At(k)), path.At(k)[2]);
  const Vector6 expected = model::ArmModel::Panda().Twist(
      model::Frame::kEndEffector, follower.joints.q_d, follower.joints.dq_d, kHandPose);
  EXPECT_EQ(follower.step.O_dP_EE_d, expected);
  EXPECT_GT(Largest(expected), 0.01);
}

/// From the ready pose outwards beyond reach and back, by 0.6 m in 20 s each; at most 0.047 m/s.
class StretchedTest : public ::testing::TestWithParam<bool> {
 protected:
  static constexpr int kBack = 40000;

  void FollowTo(int cycle) {
    for (; cycle_ < cycle; ++cycle_) {
      commanded_ = PoseOf(kReady);
      commanded_[12] += 0.3 * (1 - std::cos(pi / 20 * std::min(cycle_, kBack) * kT));
      follower_.Follow(commanded_, GetParam() ? std::optional(0.0) : std::nullopt);
      Watch();
    }
  }
  void Watch() {
    const JointReference& joints = follower_.joints;
    jerk_ = std::max(jerk_, Largest(joints.dddq_d));
    for (std::size_t i = 0; i < kJoints; ++i) {
      velocity_ = std::max(velocity_, std::abs(joints.dq_d[i]) / limits_.dq_max[i]);
      acceleration_ = std::max(acceleration_, std::abs(joints.ddq_d[i]) / limits_.ddq_max[i]);
    }
    q4_ = std::max(q4_, joints.q_d[3]);
    const double dexterity = DexterityOf(joints.q_d, !GetParam());
    dexterity_ = std::min(dexterity_, dexterity);
    if (cycle_ < 20000 && dexterity > KinematicCompletion::kDampedBelow * 1.01) {
      exact_until_ = cycle_;
      error_ = std::max(error_, Apart(follower_.step.O_T_EE_d, commanded_));
    }
  }

  Follower follower_{kReady};
  Transform commanded_{};
  JointLimits limits_ = test::PandaLimits();
  int cycle_ = 1;
  int exact_until_ = 0;
  double error_ = 0;
  double jerk_ = 0;
  double velocity_ = 0;
  double acceleration_ = 0;
  double q4_ = -4;
  double dexterity_ = 1;
};

TEST_P(StretchedTest, AMotionBeyondReachIsSmoothAndComesBack) {
  FollowTo(kBack + 3000);
  EXPECT_LT(dexterity_, 0.01);
  EXPECT_LT(q4_, kFlipAngle);
  EXPECT_LT(velocity_, 0.8);
  EXPECT_LT(acceleration_, 0.95);
  EXPECT_LT(jerk_, 600);  // rad/s^3; the smallest limit is 3750
  EXPECT_LT(Apart(follower_.step.O_T_EE_d, commanded_), 1e-11);
  EXPECT_EQ(follower_.step.lag, Vector6{});
  if (GetParam()) {
    EXPECT_LT(Apart(follower_.step.q_d, kReady), 1e-9);
  }
}

TEST_P(StretchedTest, IsExactUntilTheArmIsNearlyStretched) {
  FollowTo(20000);
  EXPECT_LT(error_, 1e-11);
  EXPECT_GT(exact_until_, 10000);
}

TEST_P(StretchedTest, BeyondReachTheArmPointsTowardsThePoseAndKeepsTheOrientation) {
  FollowTo(20000);
  const Vector6 behind = model::Displacement(follower_.step.O_T_EE_d, commanded_);
  EXPECT_GT(behind[0], 0.05);
  for (const std::size_t i : {3, 4, 5}) EXPECT_NEAR(behind[i], 0, 5e-3);
  EXPECT_LT(Apart(follower_.step.lag, behind), 1e-15);
  for (int k = 0; k < 5000; ++k) follower_.Follow(commanded_, follower_.joints.q_d[2]);
  EXPECT_LT(Largest(follower_.joints.dq_d), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Elbow, StretchedTest, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "Commanded" : "Free"; });

TEST(KinematicCompletionTest, AnElbowBeyondWhatThePoseAllowsLeavesThePoseSmoothly) {
  // At the ready pose joint 3 can go to 0.65 rad.
  Follower follower(kReady);
  double jerk = 0;
  double behind = 0;
  for (int k = 1; k <= 43000; ++k) {
    const double elbow = 0.5 * (1 - std::cos(pi / 20 * std::min(k, 40000) * kT));
    follower.Follow(PoseOf(kReady), elbow);
    ASSERT_EQ(follower.step.q_d[2], elbow);
    jerk = std::max(jerk, Largest(follower.joints.dddq_d));
    behind = std::max(behind, Largest(follower.step.lag));
  }
  EXPECT_GT(behind, 0.05);
  EXPECT_LT(jerk, 500);
  EXPECT_LT(Apart(follower.step.O_T_EE_d, PoseOf(kReady)), 1e-11);
}

TEST(KinematicCompletionTest, ALagDiesOutNoFasterThanItMayAndThenExactly) {
  Follower follower(kReady);
  follower.step.lag = {0.1, 0, 0, 0, 0.2, 0};
  Transform X = PoseOf(kReady);
  X[12] += 0.1;
  X = model::Turned(X, {0, std::asin(0.2), 0}, model::Position(X));
  int cycle = 0;
  while (follower.step.lag != Vector6{} && cycle < 20000) {
    const Vector6 before = follower.step.lag;
    follower.Follow(X, 0.0);
    const double way = before[0] - follower.step.lag[0];
    EXPECT_GT(way, 0);
    EXPECT_LE(way, KinematicCompletion::kCatchUpSpeed * kT);
    EXPECT_LE(way, before[0] * kT / KinematicCompletion::kCatchUpTime + 1e-14);
    ++cycle;
  }
  EXPECT_LT(cycle, 10000);
  follower.Follow(X, 0.0);
  EXPECT_LT(Apart(follower.step.O_T_EE_d, X), 1e-10);
}

TEST(KinematicCompletionTest, HostileInputNeverMakesAnythingThatIsNoNumber) {
  const Random random(11, RandomStream::kTest);
  const JointLimits limits = test::PandaLimits();
  constexpr double kFlips[] = {kFlipAngle, kFlipAngle + 1e-9, 0, pi, -pi};
  for (std::uint64_t k = 0; k < 100'000; ++k) {
    const auto uniform = [&](std::uint32_t draw) { return 2 * random.Uniform(k, draw) - 1; };
    const model::Sample sample = model::SampleOf(k);
    JointReference from = JointReference::Rest(sample.q);
    if (k % 4 == 1) from.q_d[3] = kFlips[k % 5];
    if (k % 4 == 2) from.q_d = {0, k % 8 == 2 ? 0.0 : 0.3, 0, kFlips[k % 5], 0, 0, 0};
    from.dq_d = sample.dq;
    for (std::size_t i = 0; i < kJoints; ++i) from.ddq_d[i] = uniform(50) * limits.ddq_max[i];
    const double reach = std::pow(10, 6 * uniform(1));  // 1 um to 1000 km
    const Eigen::Vector3d phi = pi * Eigen::Vector3d(uniform(2), uniform(3), uniform(4));
    const Eigen::Vector3d p = reach * Eigen::Vector3d(uniform(5), uniform(6), uniform(7));
    const Transform X = model::Pose(model::Exp(phi), p);
    Vector6 lag{};
    if (k % 3 == 0) {
      for (std::uint32_t i = 0; i < 6; ++i) lag[i] = reach * uniform(8 + i);
    }
    const std::optional<double> elbow = k % 2 == 0 ? std::optional(3 * uniform(20)) : std::nullopt;
    const KinematicCompletion completion(k % 5 == 0 ? kIdentityTransform : kHandPose);
    const KinematicCompletion::Step step = completion.Complete(from, lag, X, elbow);
    ASSERT_TRUE(std::isfinite(Largest(step.q_d))) << k;
    ASSERT_TRUE(std::isfinite(Largest(step.O_T_EE_d))) << k;
    ASSERT_TRUE(std::isfinite(Largest(step.O_dP_EE_d))) << k;
    ASSERT_TRUE(std::isfinite(Largest(step.lag))) << k;
  }
}

TEST(KinematicCompletionTest, NoMotionStartsWhereTheArmIsSingular) {
  const KinematicCompletion completion(kHandPose);
  EXPECT_FALSE(completion.IsSingular(kReady));
  int singular = 0;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const JointVector q = model::SampleOf(k).q;
    const model::Jacobian J = model::ArmModel::Panda().ZeroJacobian(model::Frame::kFlange, q);
    const Eigen::VectorXd sigma =
        test::SingularValues(Eigen::Map<const Eigen::Matrix<double, 6, 7>>(J.data()));
    const double s = 1 / sigma.cwiseInverse().norm();
    const bool is_stretched = std::abs(q[3] - kFlipAngle) < KinematicCompletion::kKeptClear;
    const bool expected = s < KinematicCompletion::kSingularBelow || is_stretched;
    EXPECT_EQ(completion.IsSingular(q), expected) << "sample " << k;
    singular += expected ? 1 : 0;
  }
  EXPECT_GT(singular, 10);
  EXPECT_LT(singular, 250);
  EXPECT_TRUE(completion.IsSingular({0, 0.9, 0, kFlipAngle, 0, 1.4, 0}));
  EXPECT_TRUE(completion.IsSingular({}));
}

TEST(KinematicCompletionTest, AllocatesNothing) {
  Follower follower(kReady);
  const test::RealtimeGuard guard;
  for (int k = 1; k <= 1000; ++k) {
    Transform X = PoseOf(kReady);
    X[12] += 0.3 * k * kT;
    follower.Follow(X, k % 200 < 100 ? std::optional(0.0) : std::nullopt);
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts());
}

}  // namespace
}  // namespace twin::onboard::onboard_kinematic_completion_test
