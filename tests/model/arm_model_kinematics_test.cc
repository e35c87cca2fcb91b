#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model_samples.h"
#include "support/realtime_guard.h"
#include "twin/model/arm_model.h"

namespace twin::model::arm_model_kinematics_test {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

constexpr int kSamples = 50;
constexpr std::array kFrames{Frame::kJoint1, Frame::kJoint2, Frame::kJoint3,
                             Frame::kJoint4, Frame::kJoint5, Frame::kJoint6,
                             Frame::kJoint7, Frame::kFlange, Frame::kEndEffector};

/// Calls check(frame, sample) for every frame at every sample.
template <typename Check>
void ForEveryFrame(Check check) {
  for (const Frame frame : kFrames) {
    for (int i = 0; i < kSamples; ++i) {
      SCOPED_TRACE(testing::Message() << "frame " << static_cast<int>(frame) << ", sample " << i);
      check(frame, SampleOf(static_cast<std::uint64_t>(i)));
    }
  }
}

/// Twist of a frame by central differences of its pose along dq, base axes.
Vector6 TwistByDifferences(const ArmModel& arm, Frame frame, const JointVector& q,
                           const JointVector& dq) {
  constexpr double kStep = 1e-6;
  JointVector before = q;
  JointVector after = q;
  for (std::size_t i = 0; i < kJoints; ++i) {
    before[i] -= kStep * dq[i];
    after[i] += kStep * dq[i];
  }
  const Transform X0 = arm.Pose(frame, before, kHandPose);
  const Transform X1 = arm.Pose(frame, after, kHandPose);
  const Transform turn = Multiply(X1, Inverse(X0));  // its rotation: exp([w]x 2 kStep)
  const double scale = 1 / (2 * kStep);
  return {scale * (X1[12] - X0[12]),         scale * (X1[13] - X0[13]),
          scale * (X1[14] - X0[14]),         scale * 0.5 * (turn[6] - turn[9]),
          scale * 0.5 * (turn[8] - turn[2]), scale * 0.5 * (turn[1] - turn[4])};
}

Vector6 Times(const Jacobian& J, const JointVector& dq) {
  Vector6 twist{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (std::size_t k = 0; k < 6; ++k) twist[k] += J[6 * i + k] * dq[i];
  }
  return twist;
}

TEST(ArmModelKinematicsTest, ReadyPosePutsTheHandWhereItIsKnownToBe) {
  const Transform X = ArmModel::Panda().Pose(Frame::kEndEffector, kReady, kHandPose);
  EXPECT_THAT(X, Pointwise(DoubleNear(5e-5),
                           Transform{1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0.3069, 0, 0.4869, 1}));
}

// With all angles zero the arm is a straight column but for the elbow's and the wrist's offsets.
TEST(ArmModelKinematicsTest, ZeroPoseStacksTheLengths) {
  const Transform X = ArmModel::Panda().Pose(Frame::kFlange, JointVector{});
  EXPECT_THAT(X,
              Pointwise(DoubleNear(1e-15), Transform{1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0,  //
                                                     0.088, 0, 0.333 + 0.316 + 0.384 - 0.107, 1}));
}

// The table of the arm's frames, multiplied out row by row with general rotations.
TEST(ArmModelKinematicsTest, JointPosesAreTheProductOfTheDhRows) {
  const double alpha[] = {0, -M_PI_2, M_PI_2, M_PI_2, -M_PI_2, M_PI_2, M_PI_2};
  const double a[] = {0, 0, 0, 0.0825, -0.0825, 0, 0.088};
  const double d[] = {0.333, 0, 0.316, 0, 0.384, 0, 0};
  for (std::uint64_t k = 0; k < kSamples; ++k) {
    const JointVector q = SampleOf(k).q;
    Transform X = kIdentityTransform;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double ca = std::cos(alpha[i]);
      const double sa = std::sin(alpha[i]);
      const double c = std::cos(q[i]);
      const double s = std::sin(q[i]);
      X = Multiply(X, {1, 0, 0, 0, 0, ca, sa, 0, 0, -sa, ca, 0, a[i], 0, 0, 1});
      X = Multiply(X, {c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, d[i], 1});
      EXPECT_THAT(ArmModel::Panda().Pose(kFrames[i], q), Pointwise(DoubleNear(1e-14), X))
          << "joint " << i + 1 << ", sample " << k;
    }
  }
}

TEST(ArmModelKinematicsTest, EndEffectorIsTheFlangeTimesItsPoseThere) {
  const ArmModel& arm = ArmModel::Panda();
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const JointVector q = SampleOf(i).q;
    EXPECT_THAT(arm.Pose(Frame::kEndEffector, q, kHandPose),
                Pointwise(DoubleNear(1e-15), Multiply(arm.Pose(Frame::kFlange, q), kHandPose)));
  }
}

TEST(ArmModelKinematicsTest, ZeroJacobianIsTheDerivativeOfThePose) {
  const ArmModel& arm = ArmModel::Panda();
  ForEveryFrame([&](Frame frame, const Sample& sample) {
    const Jacobian J = arm.ZeroJacobian(frame, sample.q, kHandPose);
    for (std::size_t i = 0; i < kJoints; ++i) {
      JointVector unit{};
      unit[i] = 1;
      EXPECT_THAT(Times(J, unit),
                  Pointwise(DoubleNear(1e-9), TwistByDifferences(arm, frame, sample.q, unit)));
    }
  });
}

TEST(ArmModelKinematicsTest, MotionOfAFrameIsItsPoseAndItsJacobian) {
  const ArmModel& arm = ArmModel::Panda();
  ForEveryFrame([&](Frame frame, const Sample& sample) {
    const FrameMotion motion = arm.MotionOf(frame, sample.q, kHandPose);
    EXPECT_EQ(motion.O_T_frame, arm.Pose(frame, sample.q, kHandPose));
    EXPECT_EQ(motion.J, arm.ZeroJacobian(frame, sample.q, kHandPose));
  });
}

TEST(ArmModelKinematicsTest, TwistIsTheZeroJacobianTimesTheVelocity) {
  const ArmModel& arm = ArmModel::Panda();
  ForEveryFrame([&](Frame frame, const Sample& sample) {
    const Jacobian J = arm.ZeroJacobian(frame, sample.q, kHandPose);
    EXPECT_THAT(arm.Twist(frame, sample.q, sample.dq, kHandPose),
                Pointwise(DoubleNear(1e-14), Times(J, sample.dq)));
  });
}

TEST(ArmModelKinematicsTest, BodyJacobianIsTheZeroJacobianInTheFramesAxes) {
  const ArmModel& arm = ArmModel::Panda();
  ForEveryFrame([&](Frame frame, const Sample& sample) {
    const Transform X = arm.Pose(frame, sample.q, kHandPose);
    const Jacobian zero = arm.ZeroJacobian(frame, sample.q, kHandPose);
    Jacobian expected{};
    for (std::size_t block = 0; block < 2 * kJoints; ++block) {
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t k = 0; k < 3; ++k) {
          expected[3 * block + r] += X[4 * r + k] * zero[3 * block + k];
        }
      }
    }
    EXPECT_THAT(arm.BodyJacobian(frame, sample.q, kHandPose),
                Pointwise(DoubleNear(1e-14), expected));
  });
}

TEST(ArmModelKinematicsTest, ColumnsOfJointsBeyondTheFrameAreZero) {
  const ArmModel& arm = ArmModel::Panda();
  ForEveryFrame([&](Frame frame, const Sample& sample) {
    const Jacobian zero = arm.ZeroJacobian(frame, sample.q, kHandPose);
    const Jacobian body = arm.BodyJacobian(frame, sample.q, kHandPose);
    for (std::size_t j = 6 * (static_cast<std::size_t>(frame) + 1); j < zero.size(); ++j) {
      EXPECT_EQ(zero[j], 0);
      EXPECT_EQ(body[j], 0);
    }
  });
}

TEST(ArmModelKinematicsTest, FirstFrameTurnsAboutItsOwnAxisOnly) {
  Jacobian expected{};
  expected[5] = 1;
  EXPECT_EQ(ArmModel::Panda().BodyJacobian(Frame::kJoint1, SampleOf(0).q), expected);
}

TEST(ArmModelKinematicsTest, OnlyTheEndEffectorReadsItsPose) {
  const ArmModel& arm = ArmModel::Panda();
  ForEveryFrame([&](Frame frame, const Sample& sample) {
    const bool same = arm.Pose(frame, sample.q) == arm.Pose(frame, sample.q, kHandPose);
    EXPECT_EQ(same, frame != Frame::kEndEffector);
  });
}

TEST(ArmModelKinematicsTest, TakesNoMemory) {
  const ArmModel& arm = ArmModel::Panda();
  const Sample sample = SampleOf(0);
  double sum = 0;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    const Configuration q(sample.q);
    sum += arm.Pose(Frame::kEndEffector, q, kHandPose)[12];
    sum += arm.ZeroJacobian(Frame::kEndEffector, q, kHandPose)[0];
    sum += arm.BodyJacobian(Frame::kEndEffector, q, kHandPose)[0];
    sum += arm.Twist(Frame::kEndEffector, q, sample.dq, kHandPose)[0];
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(ElbowOfTest, SignTellsTheSideOfTheLargestExtension) {
  constexpr double kFlip = -0.467002423653011;
  EXPECT_EQ(ElbowOf({0, 0, 0.4, kFlip - 1e-12, 0, 0, 0}), (Elbow{0.4, -1}));
  EXPECT_EQ(ElbowOf({0, 0, 0.4, kFlip, 0, 0, 0}), (Elbow{0.4, 0}));
  EXPECT_EQ(ElbowOf({0, 0, 0.4, kFlip + 1e-12, 0, 0, 0}), (Elbow{0.4, 1}));
}

// Where the constant comes from: shoulder and wrist are farthest apart where their distance, by
// the lengths of upper arm, forearm and elbow offset, has its maximum.
TEST(ElbowOfTest, FlipsWhereTheArmIsLongest) {
  const auto reach = [](double q4) {
    const JointVector q{0, 0, 0, q4, 0, 0, 0};
    const Transform wrist = ArmModel::Panda().Pose(Frame::kJoint6, q);
    return std::hypot(wrist[12], wrist[13], wrist[14] - 0.333);
  };
  constexpr double kFlip = -0.467002423653011;
  constexpr double kStep = 1e-3;
  EXPECT_NEAR((reach(kFlip + kStep) - reach(kFlip - kStep)) / (2 * kStep), 0, 1e-7);
  EXPECT_LT(reach(kFlip + kStep), reach(kFlip));
}

}  // namespace
}  // namespace twin::model::arm_model_kinematics_test
