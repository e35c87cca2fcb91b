#include "twin/onboard/stop_proof.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"

namespace twin::onboard::onboard_stop_proof_test {
namespace {

using model::ArmModel;
using model::Frame;

constexpr JointVector kReady{0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398};

Vector3 EndEffector(const JointVector& q) {
  const Transform T = ArmModel::Panda().Pose(Frame::kEndEffector, q);
  return {T[12], T[13], T[14]};
}

/// The end effector stays within `half` of where it is at the ready pose, in x, y and z.
model::LabLimits BoxAroundReady(double half) {
  const Vector3 centre = EndEffector(kReady);
  model::LimitBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.low[i] = centre[i] - half;
    box.high[i] = centre[i] + half;
  }
  model::LabLimits limits;
  limits.regions.push_back(
      {.name = "box", .parts = {model::LimitedPart::kEndEffector}, .shape = box});
  return limits;
}

std::optional<BrokenLimit> Check(const model::LabLimits& limits, const JointReference& from) {
  return StopProof(test::PandaLimits(), limits, {}).Check(from);
}

/// Least distance of the end effector from the box's border over the stop, at `parts` points of
/// every cycle's way: a second implementation, by sampling.
double LeastOnStop(JointReference from, const model::LabLimits& limits, int parts) {
  double least = std::numeric_limits<double>::infinity();
  while (!from.AtRest()) {
    const JointReference next = StopStep(from, test::PandaLimits());
    for (int part = 0; part <= parts; ++part) {
      JointVector q{};
      for (std::size_t i = 0; i < kJoints; ++i) {
        q[i] = from.q_d[i] + (next.q_d[i] - from.q_d[i]) * part / parts;
      }
      const Vector3 p = EndEffector(q);
      const auto& box = std::get<model::LimitBox>(limits.regions[0].shape);
      for (std::size_t i = 0; i < 3; ++i) {
        least = std::min({least, p[i] - box.low[i], box.high[i] - p[i]});
      }
    }
    from = next;
  }
  return least;
}

JointReference RandomReference(const Random& random, std::uint64_t trial) {
  const JointLimits limits = test::PandaLimits();
  const double speed = random.Uniform(trial, 21);
  JointReference reference;
  for (std::uint32_t i = 0; i < kJoints; ++i) {
    reference.q_d[i] = kReady[i] + 0.1 * (2 * random.Uniform(trial, i) - 1);
    reference.dq_d[i] = speed * limits.dq_max[i] * (2 * random.Uniform(trial, 7 + i) - 1);
    reference.ddq_d[i] = limits.ddq_max[i] * (2 * random.Uniform(trial, 14 + i) - 1);
  }
  return reference;
}

TEST(StopProofTest, WhatIsProvedStaysInsideInAndBetweenTheCycles) {
  const Random random(11, RandomStream::kTest);
  const model::LabLimits limits = BoxAroundReady(0.12);
  const StopProof proof(test::PandaLimits(), limits, {});
  int proved = 0;
  int close = 0;
  for (std::uint64_t trial = 0; trial < 2000; ++trial) {
    const JointReference from = RandomReference(random, trial);
    const double least = LeastOnStop(from, limits, 3);
    const auto breach = proof.Check(from);
    if (!breach) {
      ++proved;
      close += least < 0.02 ? 1 : 0;
      ASSERT_GE(least, 0) << "trial " << trial;
    } else if (breach->kind == LimitKind::kRegion) {
      // Not refused without need: a cycle's way is below 12 mm, and half of it decides.
      ASSERT_LT(least, 6e-3) << "trial " << trial;
    }
  }
  EXPECT_GT(proved, 200);
  EXPECT_GT(close, 20);
}

TEST(StopProofTest, AStopThatEndsOutsideIsRefusedWithItsRegion) {
  // Joint 1 at 1 rad/s needs 1/(2 15) = 0.033 rad, which is 18 mm of the hand at 0.55 m.
  JointReference from = JointReference::Rest(kReady);
  from.dq_d[0] = 1;
  EXPECT_FALSE(Check(BoxAroundReady(0.03), from));
  const auto breach = Check(BoxAroundReady(0.01), from);
  ASSERT_TRUE(breach);
  EXPECT_EQ(breach->kind, LimitKind::kRegion);
  EXPECT_GT(breach->value, breach->bound);
  EXPECT_NE(Describe(BoxAroundReady(0.01), *breach).find("limit \"box\": the end effector"),
            std::string::npos);
}

TEST(StopProofTest, AJointAboveItsCapIsRefusedWithItsSpeed) {
  model::LabLimits limits;
  limits.dq_max = JointVector{1, 1, 1, 1, 1, 1, 0.5};
  JointReference from = JointReference::Rest(kReady);
  from.dq_d[6] = -0.5;
  EXPECT_FALSE(Check(limits, from));
  from.dq_d[6] = -0.51;
  const auto breach = Check(limits, from);
  ASSERT_TRUE(breach);
  EXPECT_EQ(breach->kind, LimitKind::kJointSpeed);
  EXPECT_EQ(breach->axis, 6);
  EXPECT_EQ(breach->value, -0.51);
  EXPECT_EQ(breach->bound, -0.5);
}

TEST(StopProofTest, TheSpeedOfTheEndEffectorIsThatOfJointOneTimesItsLever) {
  const Vector3 p = EndEffector(kReady);
  const double lever = std::hypot(p[0], p[1]);
  model::LabLimits limits;
  limits.v_max = 0.25;
  JointReference from = JointReference::Rest(kReady);
  from.dq_d[0] = 0.2499 / lever;
  EXPECT_FALSE(Check(limits, from));
  from.dq_d[0] = 0.2501 / lever;
  const auto breach = Check(limits, from);
  ASSERT_TRUE(breach);
  EXPECT_EQ(breach->kind, LimitKind::kSpeed);
  EXPECT_NEAR(breach->value, 0.2501, 1e-9);
}

TEST(StopProofTest, AStopBeyondAJointsRangeIsRefused) {
  const JointLimits joints = test::PandaLimits();
  JointReference from = JointReference::Rest(kReady);
  from.q_d[0] = joints.q_max[0] - 0.03;
  from.dq_d[0] = 1;  // needs 0.033 rad
  const auto breach = Check({}, from);
  ASSERT_TRUE(breach);
  EXPECT_EQ(breach->kind, LimitKind::kJointRange);
  EXPECT_EQ(breach->axis, 0);
  EXPECT_GT(breach->value, breach->bound);
  from.q_d[0] -= 0.01;
  EXPECT_FALSE(Check({}, from));
}

TEST(StopProofTest, AllocatesNothing) {
  const Random random(12, RandomStream::kTest);
  const model::LabLimits limits = BoxAroundReady(0.12);
  const StopProof proof(test::PandaLimits(), limits, {});
  int broken = 0;
  const test::RealtimeGuard guard;
  for (std::uint64_t trial = 0; trial < 1000; ++trial) {
    broken += proof.Check(RandomReference(random, trial)) ? 1 : 0;
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
  EXPECT_GT(broken, 0);
}

}  // namespace
}  // namespace twin::onboard::onboard_stop_proof_test
