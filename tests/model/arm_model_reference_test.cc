#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "twin/model/arm_model.h"

// Against values of a second implementation, see tests/data/README.md.
namespace twin::model {
namespace {

using nlohmann::json;
using testing::DoubleNear;
using testing::Pointwise;

constexpr double kTolerance = 1e-9;

Payload ToPayload(const json& load) {
  if (load.is_null()) return {};
  return {load.at("m").get<double>(), load.at("F_x_C").get<Vector3>(), load.at("I").get<Matrix3>()};
}

class ArmModelReferenceTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::ifstream file(TWIN_SOURCE_DIR "/tests/data/model_reference.json");
    reference_ = json::parse(file);
  }

  /// Compares actual(q, dq, payload) with the field of every sample.
  template <typename Call>
  void ExpectEverySample(const std::string& field, Call actual) const {
    for (std::size_t i = 0; i < reference_.at("samples").size(); ++i) {
      const json& sample = reference_["samples"][i];
      const auto q = sample.at("q").get<JointVector>();
      const auto dq = sample.at("dq").get<JointVector>();
      const auto load = sample.at("load").get<std::string>();
      const auto result = actual(q, dq, ToPayload(reference_.at("loads").at(load)));
      const auto expected = sample.at(field).get<std::remove_cv_t<decltype(result)>>();
      EXPECT_THAT(result, Pointwise(DoubleNear(kTolerance), expected))
          << field << " of sample " << i << ", load " << load;
    }
  }

  const ArmModel& arm_ = ArmModel::Panda();
  static inline json reference_;
};

TEST_F(ArmModelReferenceTest, HasSixtySamplesOfEachLoad) {
  std::map<std::string, int> samples;
  for (const json& sample : reference_.at("samples")) ++samples[sample.at("load")];
  EXPECT_EQ(samples, (std::map<std::string, int>{{"none", 60}, {"hand", 60}, {"hand+1kg", 60}}));
}

TEST_F(ArmModelReferenceTest, MassMatrixAgrees) {
  ExpectEverySample("M", [&](const JointVector& q, const JointVector&, const Payload& payload) {
    return arm_.MassMatrix(q, payload);
  });
}

TEST_F(ArmModelReferenceTest, CoriolisTorqueAgrees) {
  ExpectEverySample("c", [&](const JointVector& q, const JointVector& dq, const Payload& payload) {
    return arm_.Coriolis(q, dq, payload);
  });
}

TEST_F(ArmModelReferenceTest, GravityTorqueAgrees) {
  ExpectEverySample("g", [&](const JointVector& q, const JointVector&, const Payload& payload) {
    return arm_.Gravity(q, payload);
  });
}

TEST_F(ArmModelReferenceTest, FlangePoseAgrees) {
  ExpectEverySample("O_T_F", [&](const JointVector& q, const JointVector&, const Payload&) {
    return arm_.Pose(Frame::kFlange, q);
  });
}

TEST_F(ArmModelReferenceTest, FlangeJacobianAgrees) {
  ExpectEverySample("O_J_F", [&](const JointVector& q, const JointVector&, const Payload&) {
    return arm_.ZeroJacobian(Frame::kFlange, q);
  });
}

// The file gives the heavier load as one body only; the block beside the hand is what its figures
// leave, in round numbers. Centre and products of inertia are not free then.
TEST_F(ArmModelReferenceTest, CombinedPayloadAgrees) {
  const json& loads = reference_.at("loads");
  const Payload block{1, {0, 0, 0.15}, {0.002, 0, 0, 0, 0.002, 0, 0, 0, 0.001}};
  const Payload total = Combine(ToPayload(loads.at("hand")), block);
  const Payload expected = ToPayload(loads.at("hand+1kg"));
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
}  // namespace twin::model
