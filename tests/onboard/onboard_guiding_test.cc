#include "twin/onboard/guiding.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "onboard/arm_samples.h"
#include "onboard/control_torque.h"
#include "onboard/rigid_arm.h"
#include "support/dense.h"
#include "support/realtime_guard.h"
#include "twin/model/transform.h"

namespace twin::onboard::onboard_guiding_test {
namespace {

const model::ArmModel& kArm = model::ArmModel::Panda();
constexpr setting::GuidingMode kAllLocked{{false, false, false, false, false, false}, false};
constexpr setting::GuidingMode kAllFree{{true, true, true, true, true, true}, true};

double Largest(const JointVector& a, const JointVector& b = {}) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// An arm that is led.
class Led {
 public:
  explicit Led(const setting::GuidingMode& mode, const JointVector& q = model::kReady)
      : arm_(q, model::kHand, kRotorInertia) {
    guiding_.SetMode(mode);
    guiding_.Begin(q, setup_);
    start_ = Pose();
  }

  void Step(const JointVector& tau_outside = {}) {
    arm_.Step({.tau = ControlTorque(guiding_, arm_.sensors(), setup_).tau}, tau_outside);
  }
  /// A hand pushes EE, base axes, for so many cycles.
  void Push(const Vector6& F, int cycles) {
    for (int k = 0; k < cycles; ++k) Step(TorqueOf(F, arm_.sensors().q));
  }
  Transform Pose() const {
    return kArm.Pose(model::Frame::kEndEffector, arm_.sensors().q, setup_.F_T_EE);
  }
  /// How far EE has come: way and rotation vector in base axes.
  Vector6 Way() const {
    const Transform now = Pose();
    const Eigen::Vector3d turn = model::TurnBetween(start_, now);
    return {now[12] - start_[12],
            now[13] - start_[13],
            now[14] - start_[14],
            turn[0],
            turn[1],
            turn[2]};
  }
  const JointSensors& sensors() const { return arm_.sensors(); }
  Guiding& guiding() { return guiding_; }

 private:
  ArmSetup setup_ = HandSetup();
  Guiding guiding_{kRotorInertia};
  test::RigidArm arm_;
  Transform start_;
};

Vector6 Along(std::size_t axis, double load) {
  Vector6 F{};
  F[axis] = load;
  return F;
}

TEST(GuidingTest, AFreeArmCarriesItsWeightAndStays) {
  Guiding guiding(kRotorInertia);
  guiding.SetMode(kAllFree);
  for (std::uint64_t pose = 0; pose < 20; ++pose) {
    const JointVector q = model::SampleOf(pose).q;
    guiding.Begin(q, HandSetup());
    const ImpedanceTorque torque = ControlTorque(guiding, RestingAt(q), HandSetup());
    EXPECT_LT(Largest(torque.tau_J_d), 1e-9);
    EXPECT_LT(Largest(torque.tau, kArm.Gravity(q, model::kHand)), 1e-9);
  }
}

TEST(GuidingTest, AFreeArmIsLedByASmallForceAndComesToRestWhenLetGo) {
  Led arm(kAllFree);
  arm.Push(Along(1, 5), 600);
  EXPECT_GT(arm.Way()[1], 0.03);
  arm.Push({}, 3000);
  EXPECT_LT(Largest(arm.sensors().dq), 2e-3);
  EXPECT_GT(arm.Way()[1], 0.05);
}

TEST(GuidingTest, ALockedArmHoldsAgainstAPushAlongAnyAxis) {
  for (std::uint64_t pose = 0; pose < 4; ++pose) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        Led arm(kAllLocked, RegularPose(pose));
        arm.Push(Along(axis, sign * 20), 1000);
        for (std::size_t k = 0; k < 3; ++k) EXPECT_LT(std::abs(arm.Way()[k]), 1e-3);
        EXPECT_NEAR(arm.Way()[axis], sign * 20 / 40000, 5e-5);
        EXPECT_LT(Largest(arm.sensors().dq), 1e-3);
        arm.Push({}, 500);
        EXPECT_LT(Largest(arm.sensors().q, RegularPose(pose)), 1e-4) << "back where it began";
      }
    }
  }
}

TEST(GuidingTest, ALockedArmHoldsAgainstATurnAndItsElbowAgainstAPush) {
  Led arm(kAllLocked);
  for (std::size_t axis = 3; axis < 6; ++axis) {
    Led turned(kAllLocked);
    turned.Push(Along(axis, 4), 1000);
    EXPECT_NEAR(turned.Way()[axis], 4.0 / 2000, 2e-4);
  }
  // At the elbow, sideways: 20 N at the arm's joint 4.
  const model::Jacobian J = kArm.ZeroJacobian(model::Frame::kJoint4, model::kReady);
  JointVector tau;
  for (std::size_t i = 0; i < kJoints; ++i) tau[i] = 20 * J[6 * i + 1];
  for (int k = 0; k < 1000; ++k) arm.Step(tau);
  const Transform before = kArm.Pose(model::Frame::kJoint4, model::kReady);
  const Transform now = kArm.Pose(model::Frame::kJoint4, arm.sensors().q);
  EXPECT_LT(std::abs(now[13] - before[13]), 3e-3);
  EXPECT_GT(std::abs(now[13] - before[13]), 1e-5) << "it was pushed";
}

TEST(GuidingTest, OneFreeAxisIsLedWhileTheOthersStay) {
  for (std::size_t axis = 0; axis < 6; ++axis) {
    setting::GuidingMode mode = kAllLocked;
    mode.axes[axis] = true;
    mode.elbow = true;
    Led arm(mode);
    Vector6 F = Along(axis, axis < 3 ? 6 : 1.5);
    F[axis < 3 ? (axis + 1) % 3 : 0] += 20;  // and across, where it is locked
    arm.Push(F, 500);
    const Vector6 way = arm.Way();
    EXPECT_GT(way[axis], axis < 3 ? 0.02 : 0.05) << "axis " << axis;
    for (std::size_t k = 0; k < 6; ++k) {
      if (k == axis) continue;
      EXPECT_LT(std::abs(way[k]), k < 3 ? 1e-3 : 4e-3) << axis << ", " << k;
    }
  }
}

TEST(GuidingTest, WhereTheFreeAxesHaveTakenItTheOthersGoOnHolding) {
  setting::GuidingMode mode = kAllLocked;
  mode.axes[0] = mode.axes[1] = true;  // a plane
  mode.elbow = true;
  Led arm(mode);
  for (int leg = 0; leg < 8; ++leg) {
    const double a = 0.7 * leg;
    arm.Push({8 * std::cos(a), 8 * std::sin(a), leg % 2 == 0 ? 15.0 : -15.0, 0, 0, 0}, 400);
  }
  arm.Push({}, 2000);
  const Vector6 way = arm.Way();
  EXPECT_GT(std::hypot(way[0], way[1]), 0.02);
  EXPECT_LT(std::abs(way[2]), 1e-4);
  for (std::size_t k = 3; k < 6; ++k) EXPECT_LT(std::abs(way[k]), 1e-4);
}

TEST(GuidingTest, AFreeElbowIsLedWhileTheHandStays) {
  setting::GuidingMode mode = kAllLocked;
  for (const bool is_free : {true, false}) {
    mode.elbow = is_free;
    Led arm(mode);
    JointVector last = arm.sensors().q;
    for (int k = 0; k < 1000; ++k) {
      const model::Jacobian J = kArm.ZeroJacobian(model::Frame::kJoint4, arm.sensors().q);
      JointVector tau;
      for (std::size_t i = 0; i < kJoints; ++i) tau[i] = 8 * J[6 * i + 1];
      arm.Step(tau);
      for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_LT(std::abs(arm.Way()[axis]), 1e-3);
    }
    const double moved = Largest(arm.sensors().q, last);
    EXPECT_EQ(moved > 0.1, is_free) << moved;
    EXPECT_EQ(moved < 0.01, !is_free) << moved;
  }
}

TEST(GuidingTest, WithAllAxesFreeALockedElbowMovesOnlyAsTheHandMakesIt) {
  setting::GuidingMode mode = kAllFree;
  mode.elbow = false;
  Led arm(mode);
  double along_null = 0;
  double travelled = 0;
  for (int k = 0; k < 800; ++k) {
    Eigen::VectorXd n = test::NullVector(JacobianOf(arm.sensors().q));
    if (n[2] < 0) n = -n;
    const JointVector before = arm.sensors().q;
    arm.Push({4, 5, -3, 0.3, 0, 0.2}, 1);
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double step = arm.sensors().q[i] - before[i];
      along_null += n[static_cast<int>(i)] * step;
      travelled += std::abs(step);
    }
  }
  EXPECT_GT(travelled, 0.3);
  EXPECT_LT(std::abs(along_null), 0.02);
}

TEST(GuidingTest, AnAxisThatBecomesLockedIsHeldWhereItIs) {
  Led arm(kAllFree);
  arm.Push(Along(2, 10), 500);
  arm.Push({}, 2500);
  const Vector6 there = arm.Way();
  ASSERT_GT(there[2], 0.05);
  arm.guiding().SetMode(kAllLocked);
  arm.Push(Along(2, -20), 1000);
  EXPECT_NEAR(arm.Way()[2], there[2] - 20.0 / 40000, 1e-3);
}

TEST(GuidingTest, BeginsWhereTheArmIs) {
  Led arm(kAllLocked);
  JointVector q = arm.sensors().q;
  q[0] += 0.4;
  q[3] += 0.3;
  arm.guiding().Begin(q, HandSetup());
  const ImpedanceTorque torque = ControlTorque(arm.guiding(), RestingAt(q), HandSetup());
  EXPECT_LT(Largest(torque.tau_J_d), 1e-9);
}

TEST(GuidingTest, StaysFiniteAtSingularPoses) {
  for (const setting::GuidingMode& mode : {kAllLocked, kAllFree}) {
    Led arm(mode, {0, 0, 0, -0.467002423653011, 0, 1.5707963267948966, 0});
    arm.Push({10, 10, -10, 1, 1, 1}, 1000);
    for (const double dq : arm.sensors().dq) EXPECT_LT(std::abs(dq), 3);
  }
}

TEST(GuidingTest, ACycleTakesNoMemory) {
  Guiding guiding(kRotorInertia);
  guiding.SetMode(kAllLocked);
  JointSensors sensors = RestingAt(model::kReady);
  double sum = 0;
  const test::RealtimeGuard guard;
  guiding.Begin(sensors.q, HandSetup());
  for (int k = 0; k < 1000; ++k) {
    sensors.q[1] += 1e-6;
    sum += ControlTorque(guiding, sensors, HandSetup()).tau_J_d[1];
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_LT(sum, 0);
}

}  // namespace
}  // namespace twin::onboard::onboard_guiding_test
