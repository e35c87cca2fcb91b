#include "twin/onboard/cartesian_impedance.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "onboard/arm_samples.h"
#include "onboard/control_torque.h"
#include "onboard/rigid_arm.h"
#include "support/dense.h"
#include "support/realtime_guard.h"
#include "twin/model/transform.h"

namespace twin::onboard::onboard_cartesian_impedance_test {
namespace {

constexpr Vector6 kStiff{3000, 3000, 3000, 300, 300, 300};
constexpr Vector6 kMixed{400, 1500, 800, 40, 120, 75};
const model::ArmModel& kArm = model::ArmModel::Panda();

ArmSetup TiltedSetup() {
  ArmSetup setup = HandSetup();
  setup.EE_T_K = kTiltedK;
  return setup;
}

Transform PoseOfK(const JointVector& q, const ArmSetup& setup) {
  return kArm.Pose(model::Frame::kEndEffector, q, model::Multiply(setup.F_T_EE, setup.EE_T_K));
}

/// From X to Y in the axes of X: way, and rotation vector by a quaternion.
Vector6 Between(const Transform& X, const Transform& Y) {
  const Transform difference = model::Multiply(model::Inverse(X), Y);
  const Eigen::Vector3d turn = model::Log(model::Orientation(difference));
  return {difference[12], difference[13], difference[14], turn[0], turn[1], turn[2]};
}

double Largest(const JointVector& a, const JointVector& b = {}) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// An arm under Cartesian impedance control.
class Controlled {
 public:
  Controlled(const JointVector& q, const Vector6& K_x, const ArmSetup& setup)
      : impedance_(K_x, 1.0, kRotorInertia), setup_(setup), arm_(q, setup.payload, kRotorInertia) {}

  void Step(const JointReference& reference, const JointVector& tau_outside = {}) {
    const JointSensors& sensors = arm_.sensors();
    arm_.Step({.tau = ControlTorque(impedance_, reference, sensors, setup_).tau}, tau_outside);
  }
  const JointSensors& sensors() const { return arm_.sensors(); }
  Transform O_T_K() const { return PoseOfK(sensors().q, setup_); }

 private:
  CartesianImpedance impedance_;
  ArmSetup setup_;
  test::RigidArm arm_;
};

TEST(CartesianImpedanceTest, AtRestOnTheReferenceItAppliesGravityAlone) {
  const CartesianImpedance impedance(kStiff, 1.0, kRotorInertia);
  for (std::uint64_t pose = 0; pose < 20; ++pose) {
    const JointVector q = model::SampleOf(pose).q;
    const ImpedanceTorque torque =
        ControlTorque(impedance, JointReference::Rest(q), RestingAt(q), TiltedSetup());
    EXPECT_LT(Largest(torque.tau_J_d), 1e-9);
    EXPECT_LT(Largest(torque.tau, kArm.Gravity(q, model::kHand)), 1e-9);
  }
}

TEST(CartesianImpedanceTest, FeedsTheAccelerationForwardThroughTheInertia) {
  const CartesianImpedance impedance(kStiff, 1.0, kRotorInertia);
  const model::Sample sample = model::SampleOf(4);
  JointReference reference = JointReference::Rest(sample.q);
  reference.dq_d = sample.dq;
  reference.ddq_d = sample.ddq;
  JointSensors sensors = RestingAt(sample.q);
  sensors.dq = sample.dq;
  const ImpedanceTorque torque = ControlTorque(impedance, reference, sensors, HandSetup());
  const JointVector tau =
      kArm.InverseDynamics(sample.q, sample.dq, sample.ddq, model::kHand, {0, 0, 0});
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(torque.tau_J_d[i], tau[i] + kRotorInertia[i] * sample.ddq[i], 1e-9);
  }
}

TEST(CartesianImpedanceTest, AConstantForceDeflectsKByForceThroughStiffness) {
  const ArmSetup setup = TiltedSetup();
  for (std::uint64_t pose = 0; pose < 6; ++pose) {
    const JointVector q = RegularPose(pose);
    for (const Vector6& K_x : {kStiff, kMixed}) {
      for (std::size_t axis = 0; axis < 6; ++axis) {
        Controlled arm(q, K_x, setup);
        const Transform start = arm.O_T_K();
        const Eigen::Matrix3d R = model::Orientation(start).toRotationMatrix();
        const double load = axis < 3 ? 8 : 1;  // along or about an axis of K
        const Eigen::Vector3d direction = load * R.col(static_cast<int>(axis % 3));
        Vector6 F{};
        for (std::size_t k = 0; k < 3; ++k) F[3 * (axis / 3) + k] = direction[static_cast<int>(k)];
        for (int k = 0; k < 500 || (k < 8000 && Largest(arm.sensors().dq) > 1e-5); ++k) {
          arm.Step(JointReference::Rest(q), TorqueOf(F, arm.sensors().q, kTiltedK));
        }
        ASSERT_LT(Largest(arm.sensors().dq), 1e-4);
        const Vector6 way = Between(start, arm.O_T_K());
        const double expected = load / K_x[axis];
        EXPECT_NEAR(way[axis], expected, 0.03 * expected)
            << "pose " << pose << ", axis " << axis << ", K_x " << K_x[axis];
        // Other axes stay, but for what the deflection itself turns.
        for (std::size_t k = 0; k < 3; ++k) {
          if (k == axis % 3) continue;
          EXPECT_NEAR(way[3 * (axis / 3) + k], 0, 0.06 * expected);
        }
      }
    }
  }
}

TEST(CartesianImpedanceTest, FollowsAnAdmissibleReferenceWithoutLag) {
  JointReference reference = JointReference::Rest(model::kReady);
  Controlled arm(model::kReady, kStiff, TiltedSetup());
  double fastest = 0;
  for (int k = 1; k <= 3000; ++k) {
    JointVector q_c = model::kReady;
    const double t = 1e-3 * k;
    for (std::size_t i = 0; i < kJoints; ++i) {
      q_c[i] += 0.3 * (1 - std::cos(2 * t)) * std::cos(static_cast<double>(i)) * 0.5;
    }
    // A start from rest within the jerk's limit.
    for (std::size_t i = 0; i < kJoints; ++i) {
      q_c[i] = model::kReady[i] + (q_c[i] - model::kReady[i]) * std::min(1.0, t * t * t);
    }
    reference = reference.AfterPosition(q_c);
    arm.Step(reference);
    fastest = std::max(fastest, Largest(reference.dq_d));
    ASSERT_LT(Largest(arm.sensors().q, reference.q_d), 2e-3) << "cycle " << k;
  }
  EXPECT_GT(fastest, 0.25);
}

TEST(CartesianImpedanceTest, ADisplacedArmComesBackWithoutRinging) {
  for (std::uint64_t pose = 0; pose < 6; ++pose) {
    const JointVector q_d = RegularPose(pose);
    JointVector q = q_d;
    for (std::size_t i = 0; i < kJoints; ++i) q[i] += (i % 2 == 0 ? 0.02 : -0.02);
    Controlled arm(q, kStiff, HandSetup());
    const Transform goal = PoseOfK(q_d, HandSetup());
    const Vector6 start = Between(arm.O_T_K(), goal);
    double largest = 0;
    for (const double e : start) largest = std::max(largest, std::abs(e));
    double overshoot = 0;
    for (int k = 0; k < 1500; ++k) {
      arm.Step(JointReference::Rest(q_d));
      const Vector6 e = Between(arm.O_T_K(), goal);
      for (std::size_t axis = 0; axis < 6; ++axis) {
        overshoot = std::max(overshoot, -e[axis] * (start[axis] > 0 ? 1 : -1));
      }
    }
    EXPECT_LT(overshoot, 0.35 * largest) << "coupled axes disturb each other, they do not ring";
    EXPECT_LT(Largest(arm.sensors().q, q_d), 1e-3) << "pose " << pose;
    EXPECT_LT(Largest(arm.sensors().dq), 5e-3);
  }
}

TEST(CartesianImpedanceTest, TheElbowComesBackWhileKStaysWhereItIs) {
  const JointVector q_d = RegularPose(1);
  const Eigen::VectorXd n = test::NullVector(JacobianOf(q_d));
  // Along the null space in small steps, so that K stays.
  JointVector q = q_d;
  for (int step = 0; step < 400; ++step) {
    Eigen::VectorXd along = test::NullVector(JacobianOf(q));
    if (along.dot(n) < 0) along = -along;
    for (std::size_t i = 0; i < kJoints; ++i) q[i] += 5e-4 * along[static_cast<int>(i)];
  }
  ASSERT_GT(Largest(q, q_d), 0.08);
  Controlled arm(q, kStiff, HandSetup());
  const Transform goal = PoseOfK(q_d, HandSetup());
  for (int k = 0; k < 2000; ++k) {
    arm.Step(JointReference::Rest(q_d));
    const Vector6 e = Between(arm.O_T_K(), goal);
    for (std::size_t axis = 0; axis < 6; ++axis) ASSERT_LT(std::abs(e[axis]), 2e-3) << k;
  }
  EXPECT_LT(Largest(arm.sensors().q, q_d), 2e-3);
}

TEST(CartesianImpedanceTest, IsBoundedAndFiniteAtSingularPosesAndFarFromTheReference) {
  const CartesianImpedance impedance(kStiff, 1.0, kRotorInertia);
  std::vector<JointVector> poses{{0, 0, 0, -0.0698, 0, 0, 0},
                                 {0, 0, 0, -0.467, 0, 1.5707963, 0},
                                 {0, 0, 0, -1.5707963, 0, 0, 0},
                                 {0.3, 0, 0, -0.467002423653011, 0, 1.8, 0},
                                 {0, -0.5, 0, -2.5, 1.5707963, 0, 0}};
  for (std::uint64_t index = 0; index < 500; ++index) poses.push_back(model::SampleOf(index).q);
  for (const JointVector& q : poses) {
    JointSensors sensors = RestingAt(q);
    for (std::size_t i = 0; i < kJoints; ++i) sensors.dq[i] = i % 2 == 0 ? 1 : -1;
    // 0.1 rad off in every joint: the spring and the damper have a part each.
    JointReference near = JointReference::Rest(q);
    for (double& q_d : near.q_d) q_d += 0.1;
    for (const double tau : ControlTorque(impedance, near, sensors, TiltedSetup()).tau) {
      EXPECT_LT(std::abs(tau), 3000);
    }
    const JointReference far = JointReference::Rest(model::SampleOf(7).q);
    for (const double tau : ControlTorque(impedance, far, sensors, TiltedSetup()).tau) {
      EXPECT_LT(std::abs(tau), 20'000);
    }
  }
}

/// What a joint torque does at EE.
Eigen::Matrix<double, 6, 1> ForceOf(const JointVector& tau, const JointVector& q) {
  using Square = Eigen::Matrix<double, kJoints, kJoints>;
  using Column = Eigen::Matrix<double, kJoints, 1>;
  const model::JointMatrix M_q = kArm.MassMatrix(q, model::kHand);
  Square M = Eigen::Map<const Square>(M_q.data());
  M.diagonal() += Eigen::Map<const Column>(kRotorInertia.data());
  return test::TaskForce(M, JacobianOf(q), Eigen::Map<const Column>(tau.data()));
}

TEST(CartesianImpedanceTest, LeadsBackOverAnyTurn) {
  // EE turned about the axis of joint 7 by up to nearly pi, either way. What acts at EE is K_x
  // times the turn; the null space has no part in it.
  const CartesianImpedance impedance({3000, 3000, 3000, 10, 10, 10}, 1.0, kRotorInertia);
  const JointVector q{0, -0.7853981634, 0, -2.3561944902, 0, 1.5707963268, 0};
  const Eigen::Vector3d axis = JacobianOf(q).col(6).tail<3>();
  for (const double turn : {-3.0, -1.8, -1.4, -1e-3, -1e-9, 0.0, 1e-6, 0.5, 1.4, 1.8, 3.0}) {
    JointReference reference = JointReference::Rest(q);
    reference.q_d[6] += turn;
    const ImpedanceTorque torque = ControlTorque(impedance, reference, RestingAt(q), HandSetup());
    const auto F = ForceOf(torque.tau_J_d, q);
    EXPECT_LT((F.tail<3>() - 10 * turn * axis).norm(), 2e-3 * std::abs(turn) + 1e-9) << turn;
    EXPECT_LT(F.head<3>().norm(), 0.02 * std::abs(turn) + 1e-9) << turn;
  }
}

TEST(CartesianImpedanceTest, HoldsTheStretchedArmAgainstAPush) {
  const JointVector q{0, 0.6, 0, -0.467, 0, 1.8, 0.3};
  ASSERT_GT(WrenchGain(q), 100);
  Controlled arm(q, kStiff, HandSetup());
  const JointVector push{2, -3, 2, 3, 1, -1, 0.5};
  for (int k = 0; k < 4000; ++k) {
    arm.Step(JointReference::Rest(q), push);
    ASSERT_LT(Largest(arm.sensors().q, q), 0.15) << "cycle " << k;
  }
  EXPECT_LT(Largest(arm.sensors().dq), 1e-3);
}

TEST(CartesianImpedanceTest, ACycleTakesNoMemory) {
  const CartesianImpedance impedance(kStiff, 1.0, kRotorInertia);
  JointSensors sensors = RestingAt(model::kReady);
  const JointReference reference = JointReference::Rest(model::kReady);
  double sum = 0;
  const test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) {
    sensors.q[1] += 1e-3;
    sum += ControlTorque(impedance, reference, sensors, TiltedSetup()).tau[1];
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_LT(sum, 0);
}

}  // namespace
}  // namespace twin::onboard::onboard_cartesian_impedance_test
