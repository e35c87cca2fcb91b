#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "model_reference.h"
#include "twin/model/arm_model.h"

// Against values of a second implementation, see tests/data/README.md.
namespace twin::model::arm_model_reference_test {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

class ArmModelReferenceTest : public testing::Test {
 protected:
  const ArmModel& arm_ = ArmModel::Panda();
  const ModelReference reference_;
};

TEST_F(ArmModelReferenceTest, HasSixtySamplesOfEachLoad) {
  std::map<std::string, int> samples;
  for (const auto& sample : reference_.samples()) ++samples[sample.at("load")];
  EXPECT_EQ(samples, (std::map<std::string, int>{{"none", 60}, {"hand", 60}, {"hand+1kg", 60}}));
}

TEST_F(ArmModelReferenceTest, MassMatrixAgrees) {
  reference_.ExpectEverySample(
      "M", [&](const JointVector& q, const JointVector&, const Payload& payload) {
        return arm_.MassMatrix(q, payload);
      });
}

TEST_F(ArmModelReferenceTest, CoriolisTorqueAgrees) {
  reference_.ExpectEverySample(
      "c", [&](const JointVector& q, const JointVector& dq, const Payload& payload) {
        return arm_.Coriolis(q, dq, payload);
      });
}

TEST_F(ArmModelReferenceTest, GravityTorqueAgrees) {
  reference_.ExpectEverySample(
      "g", [&](const JointVector& q, const JointVector&, const Payload& payload) {
        return arm_.Gravity(q, payload);
      });
}

TEST_F(ArmModelReferenceTest, FlangePoseAgrees) {
  reference_.ExpectEverySample("O_T_F",
                               [&](const JointVector& q, const JointVector&, const Payload&) {
                                 return arm_.Pose(Frame::kFlange, q);
                               });
}

TEST_F(ArmModelReferenceTest, FlangeJacobianAgrees) {
  reference_.ExpectEverySample("O_J_F",
                               [&](const JointVector& q, const JointVector&, const Payload&) {
                                 return arm_.ZeroJacobian(Frame::kFlange, q);
                               });
}

// The file gives the heavier load as one body only; the block beside the hand is what its figures
// leave, in round numbers. Centre and products of inertia are not free then.
TEST_F(ArmModelReferenceTest, CombinedPayloadAgrees) {
  const Payload block{1, {0, 0, 0.15}, {0.002, 0, 0, 0, 0.002, 0, 0, 0, 0.001}};
  const Payload total = Combine(reference_.Load("hand"), block);
  const Payload expected = reference_.Load("hand+1kg");
  EXPECT_DOUBLE_EQ(total.m, expected.m);
  EXPECT_THAT(total.F_x_C, Pointwise(DoubleNear(1e-12), expected.F_x_C));
  EXPECT_THAT(total.I, Pointwise(DoubleNear(1e-12), expected.I));
}

// Published with the comparison of parameter sets that chose this one; four digits.
TEST_F(ArmModelReferenceTest, ReadyPoseHasThePublishedFigures) {
  constexpr double kQuarter = 0.78539816339744830962;
  const JointVector q{0, -kQuarter, 0, -3 * kQuarter, 0, 2 * kQuarter, kQuarter};
  const JointVector g = arm_.Gravity(q, {});
  EXPECT_THAT(
      g, Pointwise(DoubleNear(6e-5), JointVector{0, -1.7355, -0.6708, 18.5229, 0.7156, 1.6715, 0}));
  const JointMatrix M = arm_.MassMatrix(q, {});
  JointVector diagonal;
  for (std::size_t i = 0; i < kJoints; ++i) diagonal[i] = M[kJoints * i + i];
  EXPECT_THAT(diagonal, Pointwise(DoubleNear(6e-5), JointVector{0.4354, 1.4469, 0.8686, 0.7845,
                                                                0.0095, 0.0262, 0.0013}));
}

}  // namespace
}  // namespace twin::model::arm_model_reference_test
