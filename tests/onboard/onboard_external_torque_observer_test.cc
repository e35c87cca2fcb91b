#include "twin/onboard/external_torque_observer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "onboard/arm_samples.h"
#include "onboard/rigid_arm.h"
#include "support/realtime_guard.h"
#include "twin/onboard/joint_impedance.h"

namespace twin::onboard::onboard_external_torque_observer_test {
namespace {

constexpr double kT = 1e-3;
constexpr double kGain = 50;
const model::ArmModel& kArm = model::ArmModel::Panda();

double Largest(const JointVector& v) {
  double largest = 0;
  for (const double x : v) largest = std::max(largest, std::abs(x));
  return largest;
}

/// An arm that is driven and watched.
class ExternalTorqueObserverTest : public ::testing::Test {
 protected:
  ExternalTorqueObserverTest() { observer_.Reset(arm_.sensors(), arm_.sensors().q); }

  /// One cycle under gravity compensation and the torque `extra`.
  void Step(const JointVector& extra, const JointVector& tau_outside = {}) {
    JointDrive drive{.tau = kArm.Gravity(arm_.sensors().q, model::kHand)};
    for (std::size_t i = 0; i < kJoints; ++i) drive.tau[i] += extra[i];
    arm_.Step(drive, tau_outside);
    observer_.Update(arm_.sensors(), arm_.sensors().q, model::kHand);
  }
  /// Something that moves all joints.
  static JointVector Wave(int k) {
    JointVector tau;
    for (std::size_t i = 0; i < kJoints; ++i) {
      tau[i] = (i < 4 ? 8 : 2) * std::sin(0.006 * k + 0.9 * static_cast<double>(i));
    }
    return tau;
  }

  test::RigidArm arm_{model::kReady, model::kHand, kRotorInertia};
  ExternalTorqueObserver observer_{model::ArmModel::Panda(), kGain};
};

TEST_F(ExternalTorqueObserverTest, StaysAtZeroWhileTheArmRests) {
  const JointSensors sensors = RestingAt(model::kReady);
  for (int k = 0; k < 100'000; ++k) observer_.Update(sensors, sensors.q, model::kHand);
  EXPECT_LT(Largest(observer_.tau_ext_hat()), 1e-12);
}

TEST_F(ExternalTorqueObserverTest, ShowsNothingWhileNothingTouchesTheMovingArm) {
  double largest = 0;
  double fastest = 0;
  for (int k = 0; k < 3000; ++k) {
    Step(Wave(k));
    largest = std::max(largest, Largest(observer_.tau_ext_hat()));
    fastest = std::max(fastest, Largest(arm_.sensors().dq));
  }
  EXPECT_GT(fastest, 1);
  EXPECT_LT(largest, 1e-9);
}

TEST_F(ExternalTorqueObserverTest, FollowsAStepWithTheTimeConstantOfItsGain) {
  JointSensors sensors = RestingAt(model::kReady);
  const JointVector step{3, -2, 1, 0.5, -0.25, 4, -1};
  for (std::size_t i = 0; i < kJoints; ++i) sensors.tau_J[i] += step[i];
  for (int k = 1; k <= 200; ++k) {
    observer_.Update(sensors, sensors.q, model::kHand);
    const double share = 1 - std::exp(-kGain * kT * k);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(observer_.tau_ext_hat()[i], share * step[i], 1e-9) << "cycle " << k;
    }
  }
}

TEST_F(ExternalTorqueObserverTest, IsPositiveWhereTheArmPushesBack) {
  // The environment pushes joint 1 with -5 Nm; the arm pushes it with +5 Nm.
  for (int k = 0; k < 300; ++k) Step({}, {-5, 0, 0, 0, 0, 0, 0});
  EXPECT_LT(arm_.sensors().dq[0], -0.5);
  EXPECT_NEAR(observer_.tau_ext_hat()[0], 5, 1e-4);
  for (std::size_t i = 1; i < kJoints; ++i) EXPECT_NEAR(observer_.tau_ext_hat()[i], 0, 1e-4);
}

TEST_F(ExternalTorqueObserverTest, SeesAPushWhateverTheArmDoes) {
  const JointVector push{3, -4, 2, 5, -1, 1.5, -0.5};
  for (int k = 0; k < 1000; ++k) Step(Wave(k), push);
  EXPECT_GT(Largest(arm_.sensors().dq), 0.5);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(observer_.tau_ext_hat()[i], -push[i], 1e-9);
}

/// p = M dq.
JointVector Momentum(const JointVector& q, const JointVector& dq) {
  return kArm.InverseDynamics(q, {}, dq, model::kHand, {});
}

/// C^T dq = dT/dq, T = dq^T M dq / 2, by central differences.
JointVector CoriolisTransposed(const JointVector& q, const JointVector& dq) {
  constexpr double kStep = 1e-5;
  const auto energy = [&dq](const JointVector& at) {
    const JointVector p = Momentum(at, dq);
    double T = 0;
    for (std::size_t i = 0; i < kJoints; ++i) T += 0.5 * dq[i] * p[i];
    return T;
  };
  JointVector gradient;
  for (std::size_t i = 0; i < kJoints; ++i) {
    JointVector above = q;
    JointVector below = q;
    above[i] += kStep;
    below[i] -= kStep;
    gradient[i] = (energy(above) - energy(below)) / (2 * kStep);
  }
  return gradient;
}

TEST_F(ExternalTorqueObserverTest, IsTheObserverOfTheGeneralisedMomentum) {
  // r = K (int (tau_J + C^T dq - g - r) dt - p), written out, up to what a cycle of 1 ms blurs.
  const JointVector push{3, -4, 2, 5, -1, 1.5, -0.5};
  JointVector r{};
  JointVector integral{};
  for (int k = 0; k < 900; ++k) {
    const JointVector q = arm_.sensors().q;
    const JointVector dq = arm_.sensors().dq;
    const JointVector tau_outside = k > 400 ? push : JointVector{};
    Step(Wave(k), tau_outside);
    const JointVector C_t_dq = CoriolisTransposed(q, dq);
    const JointVector g = kArm.Gravity(q, model::kHand);
    const JointVector p = Momentum(arm_.sensors().q, arm_.sensors().dq);
    for (std::size_t i = 0; i < kJoints; ++i) {
      integral[i] += kT * (arm_.sensors().tau_J[i] + C_t_dq[i] - g[i] - r[i]);
      r[i] = kGain * (integral[i] - p[i]);
      ASSERT_NEAR(observer_.tau_ext_hat()[i], r[i], 0.15) << "cycle " << k << ", joint " << i + 1;
    }
  }
}

TEST_F(ExternalTorqueObserverTest, ALoadItDoesNotKnowOfShowsAsItsWeight) {
  const model::Payload loaded =
      model::Combine(model::kHand, {1, {0, 0, 0.15}, {0.002, 0, 0, 0, 0.002, 0, 0, 0, 0.002}});
  JointSensors sensors = RestingAt(model::kReady);
  sensors.tau_J = kArm.Gravity(sensors.q, loaded);
  for (int k = 0; k < 1000; ++k) observer_.Update(sensors, sensors.q, model::kHand);
  const JointVector g = kArm.Gravity(sensors.q, model::kHand);
  EXPECT_GT(std::abs(sensors.tau_J[3] - g[3]), 2);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(observer_.tau_ext_hat()[i], sensors.tau_J[i] - g[i], 1e-9);
  }
}

TEST_F(ExternalTorqueObserverTest, ResetForgetsThePushAndTheVelocity) {
  for (int k = 0; k < 300; ++k) Step({}, {5, 0, 0, 0, 0, 0, 0});
  const JointSensors elsewhere = RestingAt({0.5, 0.3, -0.2, -1.5, 0.4, 1.9, 0});
  observer_.Reset(elsewhere, elsewhere.q);
  EXPECT_EQ(observer_.tau_ext_hat(), JointVector{});
  observer_.Update(elsewhere, elsewhere.q, model::kHand);
  EXPECT_LT(Largest(observer_.tau_ext_hat()), 1e-12);
}

TEST_F(ExternalTorqueObserverTest, LeavesOutWhatIsNotFinite) {
  JointSensors sensors = RestingAt(model::kReady);
  sensors.tau_J[0] += 2;
  for (int k = 0; k < 1000; ++k) observer_.Update(sensors, sensors.q, model::kHand);
  JointSensors bad = sensors;
  bad.tau_J.fill(std::numeric_limits<double>::quiet_NaN());
  observer_.Update(bad, bad.q, model::kHand);
  EXPECT_NEAR(observer_.tau_ext_hat()[0], 2, 1e-9);
  bad = sensors;
  bad.dq[2] = std::numeric_limits<double>::infinity();
  observer_.Update(bad, bad.q, model::kHand);
  for (int k = 0; k < 1000; ++k) observer_.Update(sensors, sensors.q, model::kHand);
  EXPECT_NEAR(observer_.tau_ext_hat()[0], 2, 1e-9);
  for (std::size_t i = 1; i < kJoints; ++i) EXPECT_NEAR(observer_.tau_ext_hat()[i], 0, 1e-9);
}

TEST_F(ExternalTorqueObserverTest, TakesNoMemory) {
  const JointSensors sensors = RestingAt(model::kReady);
  const test::RealtimeGuard guard;
  observer_.Reset(sensors, sensors.q);
  for (int k = 0; k < 1000; ++k) observer_.Update(sensors, sensors.q, model::kHand);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::onboard::onboard_external_torque_observer_test
