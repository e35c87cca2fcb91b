#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "loaded_model_library.h"
#include "model_reference.h"
#include "model_samples.h"

// What the library's functions answer when a client calls them. What the file is like, and that a
// foreign process can load it, is check_model_library.py's.
namespace twin::model::model_library_test {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

constexpr std::uint64_t kSamples = 200;
constexpr double kStep = 1e-6;  // of the numeric derivatives

constexpr Frame kFrames[] = {Frame::kJoint1, Frame::kJoint2, Frame::kJoint3,
                             Frame::kJoint4, Frame::kJoint5, Frame::kJoint6,
                             Frame::kJoint7, Frame::kFlange, Frame::kEndEffector};

using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix67 = Eigen::Matrix<double, 6, 7>;

Eigen::Map<const Matrix7> View(const JointMatrix& M) {
  return Eigen::Map<const Matrix7>(M.data());
}
Eigen::Map<const Vector7> View(const JointVector& v) {
  return Eigen::Map<const Vector7>(v.data());
}
Eigen::Map<const Matrix67> View(const Jacobian& J) {
  return Eigen::Map<const Matrix67>(J.data());
}
Eigen::Map<const Eigen::Matrix4d> View(const Transform& X) {
  return Eigen::Map<const Eigen::Matrix4d>(X.data());
}

JointVector Moved(JointVector q, std::size_t joint, double by) {
  q[joint] += by;
  return q;
}

/// An end effector whose frame is the payload's centre of mass.
Transform AtCentreOf(const Payload& payload) {
  Transform F_T_C = kIdentityTransform;
  for (std::size_t k = 0; k < 3; ++k) F_T_C[12 + k] = payload.F_x_C[k];
  return F_T_C;
}

template <typename Array>
void ExpectNear(const Array& actual, const Array& expected, double tolerance, std::uint64_t i) {
  EXPECT_THAT(actual, Pointwise(DoubleNear(tolerance), expected)) << "sample " << i;
}

/// Every function of the library against the model it is built from.
void ExpectSame(const LoadedModelLibrary& library, const ArmModel& arm, double tolerance) {
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const auto [q, dq, ddq] = SampleOf(i);
    for (const Frame frame : kFrames) {
      ExpectNear(library.Pose(frame, q, kHandPose), arm.Pose(frame, q, kHandPose), tolerance, i);
      ExpectNear(library.ZeroJacobian(frame, q, kHandPose), arm.ZeroJacobian(frame, q, kHandPose),
                 tolerance, i);
      ExpectNear(library.BodyJacobian(frame, q, kHandPose), arm.BodyJacobian(frame, q, kHandPose),
                 tolerance, i);
    }
    for (const Payload& payload : {Payload{}, kHand, kLump, Combine(kHand, kLump)}) {
      ExpectNear(library.MassMatrix(q, payload), arm.MassMatrix(q, payload), tolerance, i);
      ExpectNear(library.Coriolis(q, dq, payload), arm.Coriolis(q, dq, payload), tolerance, i);
      ExpectNear(library.Gravity(q, payload, kTilted), arm.Gravity(q, payload, kTilted), tolerance,
                 i);
    }
  }
}

class ModelLibraryTest : public testing::Test {
 protected:
  const LoadedModelLibrary library_{TWIN_MODEL_LIBRARY};
  const ModelReference reference_;
};

TEST_F(ModelLibraryTest, AnswersAsTheModelTheRobotComputesWith) {
  ExpectSame(library_, ArmModel::Panda(), 1e-12);
}

TEST_F(ModelLibraryTest, ThatOfThePlantAnswersAsTheBody) {
  ExpectSame(LoadedModelLibrary(TWIN_MODEL_LIBRARY_PLANT), ArmModel::PandaPlant(), 1e-12);
}

TEST_F(ModelLibraryTest, ReferenceMassMatrixAgrees) {
  reference_.ExpectEverySample(
      "M", [&](const JointVector& q, const JointVector&, const Payload& payload) {
        return library_.MassMatrix(q, payload);
      });
}

TEST_F(ModelLibraryTest, ReferenceCoriolisTorqueAgrees) {
  reference_.ExpectEverySample(
      "c", [&](const JointVector& q, const JointVector& dq, const Payload& payload) {
        return library_.Coriolis(q, dq, payload);
      });
}

TEST_F(ModelLibraryTest, ReferenceGravityTorqueAgrees) {
  reference_.ExpectEverySample(
      "g", [&](const JointVector& q, const JointVector&, const Payload& payload) {
        return library_.Gravity(q, payload);
      });
}

TEST_F(ModelLibraryTest, ReferenceFlangePoseAgrees) {
  reference_.ExpectEverySample("O_T_F",
                               [&](const JointVector& q, const JointVector&, const Payload&) {
                                 return library_.Pose(Frame::kFlange, q);
                               });
}

TEST_F(ModelLibraryTest, ReferenceFlangeJacobianAgrees) {
  reference_.ExpectEverySample("O_J_F",
                               [&](const JointVector& q, const JointVector&, const Payload&) {
                                 return library_.ZeroJacobian(Frame::kFlange, q);
                               });
}

// Published for the hand at the pose all examples start from; four digits.
TEST_F(ModelLibraryTest, ReadyPosePutsTheHandWhereItIsKnownToBe) {
  const Transform O_T_EE = library_.Pose(Frame::kEndEffector, kReady, kHandPose);
  EXPECT_NEAR(O_T_EE[12], 0.3069, 6e-5);
  EXPECT_NEAR(O_T_EE[13], 0, 6e-5);
  EXPECT_NEAR(O_T_EE[14], 0.4869, 6e-5);
  EXPECT_NEAR(O_T_EE[10], -1, 1e-12);  // straight down
}

// J from poses alone: column j is how frame n moves and turns when q_j does.
TEST_F(ModelLibraryTest, ZeroJacobianIsTheDerivativeOfThePose) {
  for (std::uint64_t i = 0; i < kSamples / 4; ++i) {
    const JointVector q = SampleOf(i).q;
    for (const Frame frame : kFrames) {
      Matrix67 expected;
      const Eigen::Matrix3d R = View(library_.Pose(frame, q, kHandPose)).topLeftCorner<3, 3>();
      for (std::size_t j = 0; j < kJoints; ++j) {
        const Transform ahead = library_.Pose(frame, Moved(q, j, kStep), kHandPose);
        const Transform behind = library_.Pose(frame, Moved(q, j, -kStep), kHandPose);
        const Eigen::Matrix4d slope = (View(ahead) - View(behind)) / (2 * kStep);
        const Eigen::Matrix3d turn = slope.topLeftCorner<3, 3>() * R.transpose();  // [w]x
        expected.col(static_cast<Eigen::Index>(j)) << slope.topRightCorner<3, 1>(), turn(2, 1),
            turn(0, 2), turn(1, 0);
      }
      const Jacobian J = library_.ZeroJacobian(frame, q, kHandPose);
      EXPECT_LT((View(J) - expected).cwiseAbs().maxCoeff(), 1e-8)
          << "sample " << i << ", frame " << static_cast<int>(frame) + 1;
    }
  }
}

TEST_F(ModelLibraryTest, BodyJacobianIsTheZeroJacobianInTheFramesOwnAxes) {
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const JointVector q = SampleOf(i).q;
    for (const Frame frame : kFrames) {
      const Transform X = library_.Pose(frame, q, kHandPose);
      const Eigen::Matrix3d R_T = View(X).topLeftCorner<3, 3>().transpose();
      const Jacobian zero = library_.ZeroJacobian(frame, q, kHandPose);
      const Jacobian body = library_.BodyJacobian(frame, q, kHandPose);
      Matrix67 expected;
      expected << R_T * View(zero).topRows<3>(), R_T * View(zero).bottomRows<3>();
      EXPECT_LT((View(body) - expected).cwiseAbs().maxCoeff(), 1e-14)
          << "sample " << i << ", frame " << static_cast<int>(frame) + 1;
    }
  }
}

TEST_F(ModelLibraryTest, FirstFrameOnlyTurnsAboutItsOwnAxis) {
  Jacobian expected{};
  expected[5] = 1;  // wz of joint 1
  EXPECT_EQ(library_.BodyJacobian(Frame::kJoint1, kReady), expected);
  EXPECT_EQ(library_.ZeroJacobian(Frame::kJoint1, kReady), expected);
}

TEST_F(ModelLibraryTest, JointsBeyondAFrameDoNotMoveIt) {
  const JointVector q = SampleOf(0).q;
  for (std::size_t n = 0; n < kJoints; ++n) {
    const Jacobian zero = library_.ZeroJacobian(static_cast<Frame>(n), q);
    const Jacobian body = library_.BodyJacobian(static_cast<Frame>(n), q);
    for (std::size_t k = 6 * (n + 1); k < zero.size(); ++k) {
      EXPECT_EQ(zero[k], 0) << "frame " << n + 1;
      EXPECT_EQ(body[k], 0) << "frame " << n + 1;
    }
  }
}

// The arm drifts without torque or gravity: dq^T M dq / 2 must not change, so with
// M ddq = -c the power dq^T (dM/dt) dq / 2 + dq^T M ddq is zero.
TEST_F(ModelLibraryTest, MassMatrixAndCoriolisTorqueKeepTheEnergy) {
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const Sample sample = SampleOf(i);
    const Vector7 v = View(sample.dq);
    const auto energy = [&](double t) {
      JointVector moved = sample.q;
      for (std::size_t j = 0; j < kJoints; ++j) moved[j] += t * sample.dq[j];
      const JointMatrix M = library_.MassMatrix(moved, kLump);
      return 0.5 * v.dot(View(M) * v);
    };
    const JointVector c = library_.Coriolis(sample.q, sample.dq, kLump);
    const double slope = (energy(kStep) - energy(-kStep)) / (2 * kStep);
    EXPECT_NEAR(slope, v.dot(View(c)), 1e-6) << "sample " << i;
  }
}

// Sign and scale of g: what holds the payload up is the slope of its height.
TEST_F(ModelLibraryTest, GravityTorqueHoldsThePayloadUp) {
  const Transform F_T_C = AtCentreOf(kLump);
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const JointVector q = SampleOf(i).q;
    const JointVector with = library_.Gravity(q, kLump);
    const JointVector without = library_.Gravity(q, {});
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double above = library_.Pose(Frame::kEndEffector, Moved(q, j, kStep), F_T_C)[14];
      const double below = library_.Pose(Frame::kEndEffector, Moved(q, j, -kStep), F_T_C)[14];
      EXPECT_NEAR(with[j] - without[j], kLump.m * 9.81 * (above - below) / (2 * kStep), 1e-7)
          << "sample " << i << ", joint " << j + 1;
    }
  }
}

// Published for the arm alone at the ready pose; four digits. Upside down, all of it turns round.
TEST_F(ModelLibraryTest, GravityTorqueHasThePublishedFigures) {
  const JointVector g = library_.Gravity(kReady, {});
  EXPECT_THAT(
      g, Pointwise(DoubleNear(6e-5), JointVector{0, -1.7355, -0.6708, 18.5229, 0.7156, 1.6715, 0}));
  const JointVector hanging = library_.Gravity(kReady, {}, {0, 0, 9.81});
  for (std::size_t j = 0; j < kJoints; ++j) EXPECT_DOUBLE_EQ(hanging[j], -g[j]);
}

// J^T diag(m, R I R^T) J, from the library's own Jacobian of the payload's centre.
TEST_F(ModelLibraryTest, PayloadAddsTheInertiaItsJacobianSays) {
  const Transform F_T_C = AtCentreOf(kLump);
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const JointVector q = SampleOf(i).q;
    const Jacobian columns = library_.BodyJacobian(Frame::kEndEffector, q, F_T_C);
    const auto J = View(columns);
    const Eigen::Map<const Eigen::Matrix3d> I(kLump.I.data());
    const Matrix7 expected = kLump.m * J.topRows<3>().transpose() * J.topRows<3>() +
                             J.bottomRows<3>().transpose() * I * J.bottomRows<3>();
    const Matrix7 added = View(library_.MassMatrix(q, kLump)) - View(library_.MassMatrix(q, {}));
    EXPECT_LT((added - expected).cwiseAbs().maxCoeff(), 1e-13) << "sample " << i;
  }
}

TEST_F(ModelLibraryTest, WhatIsNotFiniteComesBackSo) {
  JointVector q = kReady;
  q[3] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isnan(library_.Gravity(q, {})[1]));
  EXPECT_TRUE(std::isnan(library_.Pose(Frame::kFlange, q)[12]));
}

}  // namespace
}  // namespace twin::model::model_library_test
