// INT's sensing and its controllers on the simulated body, whose inertias are not those of INT's
// model and whose joints have friction (profile residual).

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "onboard/arm_samples.h"
#include "plant/plant_fixture.h"
#include "support/dense.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/onboard/cartesian_impedance.h"
#include "twin/onboard/guiding.h"
#include "twin/onboard/joint_impedance.h"
#include "twin/reference/trajectory.h"

namespace twin::onboard::onboard_on_plant_test {
namespace {

using Column = Eigen::Matrix<double, kJoints, 1>;

const model::ArmModel& kArm = model::ArmModel::Panda();
constexpr JointVector kTheta{3000, 3000, 3000, 2500, 2500, 2000, 2000};
constexpr Vector6 kX{1500, 1500, 1500, 100, 100, 100};
constexpr int kPoses = 20;
/// The end effector in the frame of the hand's body.
constexpr Vector3 kHandPoint{0, 0, 0.1034};

Eigen::Map<const Column> Map(const JointVector& v) {
  return Eigen::Map<const Column>(v.data());
}

/// Regular, and well above the floor.
JointVector PoseAboveTheFloor(std::uint64_t index) {
  for (std::uint64_t k = 0;; ++k) {
    const JointVector q = RegularPose(100 * index + k);
    if (kArm.Pose(model::Frame::kEndEffector, q, model::kHandPose)[14] > 0.25) return q;
  }
}

/// A push of 25 N in a direction that is another for every index, from the start on.
plant::Push PushOf(std::uint64_t index, const std::string& body, const Vector3& point) {
  const Random random(77, RandomStream::kTest);
  const double z = 2 * random.Uniform(index, 0) - 1;
  const double a = 6.283185307 * random.Uniform(index, 1);
  const double r = std::sqrt(1 - z * z);
  plant::Push push;
  push.body = body;
  push.point = point;
  push.force = {25 * r * std::cos(a), 25 * r * std::sin(a), 25 * z};
  push.duration = std::chrono::seconds(1000);
  return push;
}

class OnPlantTest : public ::testing::Test {
 protected:
  OnPlantTest() : plant_(plant::MujocoPlant::Create(plant::DefaultOptions())) {}

  void StartAt(const JointVector& q) {
    plant_->Reset(q);
    reference_ = JointReference::Rest(q);
    sensing_.Reset(plant_->sensors(), setup_);
  }
  void Step(const ImpedanceTorque& torque) {
    JointDrive drive{.tau = torque.tau};
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double tau_max = test::PandaLimits().tau_max[i];
      drive.tau[i] = std::clamp(drive.tau[i], -tau_max, tau_max);
    }
    tau_J_d_ = torque.tau_J_d;
    plant_->Step(drive);
    sensing_.Update(plant_->sensors(), setup_, false);
  }
  void StepByJoints() {
    Step(joint_impedance_.Torque(reference_, plant_->sensors(), sensing_.arm(), kArm, setup_));
  }
  void StepByCartesian() {
    const Transform O_T_EE_d = kArm.Pose(model::Frame::kEndEffector, reference_.q_d, setup_.F_T_EE);
    Step(cartesian_impedance_.Torque(reference_, O_T_EE_d, plant_->sensors(), sensing_.arm(), kArm,
                                     setup_));
  }
  Transform O_T_EE() const {
    return kArm.Pose(model::Frame::kEndEffector, plant_->sensors().q, setup_.F_T_EE);
  }

  std::unique_ptr<plant::MujocoPlant> plant_;
  ArmSetup setup_ = HandSetup();
  JointReference reference_;
  JointVector tau_J_d_{};
  Sensing sensing_{PandaSensing()};
  JointImpedance joint_impedance_{kTheta, 1.0, kRotorInertia};
  CartesianImpedance cartesian_impedance_{kX, 1.0, kRotorInertia};
};

TEST_F(OnPlantTest, APushAtTheEndEffectorIsMeasuredWithinFivePercent) {
  for (std::uint64_t pose = 0; pose < kPoses; ++pose) {
    const plant::Push push = PushOf(pose, "panda_hand", kHandPoint);
    plant_->ClearPerturbations();
    plant_->Perturb(push);
    StartAt(PoseAboveTheFloor(pose));
    for (int k = 0; k < 1500; ++k) StepByJoints();
    // The robot pushes back: the sign is that of what it does to its environment.
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      square += std::pow(sensing_.O_F_ext_hat_K()[k] + push.force[k], 2);
      EXPECT_NEAR(sensing_.O_F_ext_hat_K()[3 + k], 0, 0.3) << "moment, pose " << pose;
    }
    EXPECT_LT(std::sqrt(square), 0.05 * 25) << "pose " << pose;
  }
}

TEST_F(OnPlantTest, APushOnLinkFourShowsAsTheTorqueItMakesAndWhatThatIsAtK) {
  const Vector3 point{-0.03, 0.02, 0.05};
  for (std::uint64_t pose = 0; pose < kPoses; ++pose) {
    const plant::Push push = PushOf(pose, "panda_link4", point);
    plant_->ClearPerturbations();
    plant_->Perturb(push);
    StartAt(PoseAboveTheFloor(pose));
    for (int k = 0; k < 1500; ++k) StepByJoints();
    // The engine's own Jacobian of the point.
    const mjModel& m = plant_->model();
    const mjData& d = plant_->data();
    const int body = mj_name2id(&m, mjOBJ_BODY, "panda_link4");
    mjtNum at[3];
    mju_rotVecMat(at, point.data(), d.xmat + 9 * body);
    mju_addTo3(at, d.xpos + 3 * body);
    std::vector<mjtNum> J(static_cast<std::size_t>(3 * m.nv));
    mj_jac(&m, &d, J.data(), nullptr, at, body);
    Column expected = Column::Zero();
    for (std::size_t i = 0; i < kJoints; ++i) {
      const int dof = m.jnt_dofadr[mj_name2id(&m, mjOBJ_JOINT,
                                              ("panda_joint" + std::to_string(i + 1)).c_str())];
      for (int row = 0; row < 3; ++row) {
        expected[static_cast<int>(i)] -=
            J[static_cast<std::size_t>(row) * static_cast<std::size_t>(m.nv) +
              static_cast<std::size_t>(dof)] *
            push.force[static_cast<std::size_t>(row)];
      }
    }
    const Column seen = Map(sensing_.tau_ext_hat_filtered());
    ASSERT_GT(expected.norm(), 0.3);
    EXPECT_LT((seen - expected).norm(), 0.05 * expected.norm()) << "pose " << pose;
    const Eigen::VectorXd F =
        test::LeastSquares(JacobianOf(plant_->sensors().q).transpose(), expected);
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> O_F(sensing_.O_F_ext_hat_K().data());
    EXPECT_LT((O_F - F).norm(), 0.05 * F.norm() + 0.05) << "pose " << pose;
  }
}

/// How an arm follows a trajectory at a share of every limit.
struct Followed {
  double largest_torque = 0;  ///< of tau_ext_hat, less the friction of its joint, Nm
  double overshoot_q = 0;     ///< |q - q_d|, rad
  double overshoot_dq = 0;    ///< of the speed above the reference's, share of its limit
  bool touched = false;
  Violations violations;
};

/// Points from the middle of the workspace.
reference::Trajectory TrajectoryOf(std::uint64_t index, double share) {
  const Random random(55, RandomStream::kTest);
  const JointVector middle{0, -0.2, 0, -1.7, 0, 1.9, 0.4};
  const JointVector half{1.2, 0.5, 0.9, 0.6, 1.2, 0.8, 1.3};
  std::vector<reference::Waypoint> points(5);
  for (std::size_t p = 0; p < points.size(); ++p) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double u = random.Uniform(10 * index + p, static_cast<std::uint32_t>(i));
      points[p].q[i] = middle[i] + half[i] * (2 * u - 1);
    }
  }
  const reference::Timing timing{
      .velocity_scale = share, .acceleration_scale = share, .jerk_scale = share};
  return {points, timing, test::PandaLimits()};
}

class FollowingTest : public OnPlantTest {
 protected:
  Followed Follow(const reference::Trajectory& trajectory, bool is_cartesian) {
    Followed followed;
    StartAt(trajectory.start());
    const auto cycles = trajectory.duration() / std::chrono::milliseconds(1) + 200;
    for (int k = 1; k <= cycles; ++k) {
      reference_ = reference_.AfterPosition(trajectory.Sample(k * std::chrono::milliseconds(1)).q);
      is_cartesian ? StepByCartesian() : StepByJoints();
      followed.touched = followed.touched || plant_->data().ncon > 0;
      followed.violations.Add(sensing_.CheckMeasured(tau_J_d_, static_cast<std::uint64_t>(k)));
      const JointSensors& sensors = plant_->sensors();
      const JointVector friction = model::ResidualFriction(sensors.dq);
      for (std::size_t i = 0; i < kJoints; ++i) {
        const double torque = std::abs(sensing_.tau_ext_hat_filtered()[i]) - std::abs(friction[i]);
        followed.largest_torque = std::max(followed.largest_torque, torque);
        followed.overshoot_q =
            std::max(followed.overshoot_q, std::abs(sensors.q[i] - reference_.q_d[i]));
        followed.overshoot_dq = std::max(followed.overshoot_dq,
                                         (std::abs(sensors.dq[i]) - std::abs(reference_.dq_d[i])) /
                                             test::PandaLimits().dq_max[i]);
      }
    }
    return followed;
  }
};

TEST_F(FollowingTest, MotionWithoutContactShowsLittleMoreThanFriction) {
  int free = 0;
  for (std::uint64_t index = 0; index < 8; ++index) {
    const Followed followed = Follow(TrajectoryOf(index, 0.8), false);
    if (followed.touched) continue;  // the floor, or the arm itself
    ++free;
    EXPECT_LT(followed.largest_torque, 2) << "trajectory " << index;
    EXPECT_TRUE(followed.violations.empty())
        << Describe(followed.violations.items()[0]) << ", trajectory " << index;
  }
  EXPECT_GE(free, 5);
}

TEST_F(FollowingTest, OvershootStaysFarWithinTheMarginsOfMeasuredLimits) {
  const MeasuredBounds bounds;
  int free = 0;
  for (std::uint64_t index = 0; index < 8; ++index) {
    for (const bool is_cartesian : {false, true}) {
      const Followed followed = Follow(TrajectoryOf(index, 0.99), is_cartesian);
      if (followed.touched) continue;
      ++free;
      EXPECT_LT(followed.overshoot_dq, bounds.velocity_margin * (is_cartesian ? 1 : 0.1)) << index;
      if (is_cartesian) continue;
      EXPECT_LT(followed.overshoot_q, 0.5 * bounds.q_margin_rad) << index;
    }
  }
  EXPECT_GE(free, 10);
}

TEST_F(OnPlantTest, UnderJointImpedanceTheJointsGiveByTorqueThroughStiffness) {
  for (std::uint64_t pose = 0; pose < kPoses; ++pose) {
    const plant::Push push = PushOf(pose, "panda_hand", kHandPoint);
    plant_->ClearPerturbations();
    plant_->Perturb(push);
    StartAt(PoseAboveTheFloor(pose));
    for (int k = 0; k < 2000; ++k) StepByJoints();
    const JointVector tau =
        TorqueOf({push.force[0], push.force[1], push.force[2], 0, 0, 0}, plant_->sensors().q);
    const Column expected = Map(tau).cwiseQuotient(Map(kTheta));
    const Column way = Map(plant_->sensors().q) - Map(reference_.q_d);
    EXPECT_LT((way - expected).norm(), 0.05 * expected.norm()) << "pose " << pose;
  }
}

TEST_F(OnPlantTest, UnderCartesianImpedanceTheEndEffectorGivesByForceThroughStiffness) {
  for (std::uint64_t pose = 0; pose < kPoses; ++pose) {
    const plant::Push push = PushOf(pose, "panda_hand", kHandPoint);
    plant_->ClearPerturbations();
    plant_->Perturb(push);
    StartAt(PoseAboveTheFloor(pose));
    const Eigen::Vector3d start = model::Position(O_T_EE());
    for (int k = 0; k < 4000; ++k) StepByCartesian();
    const Eigen::Vector3d expected = Eigen::Map<const Eigen::Vector3d>(push.force.data()) / kX[0];
    const Eigen::Vector3d way = model::Position(O_T_EE()) - start;
    EXPECT_LT((way - expected).norm(), 0.05 * expected.norm()) << "pose " << pose;
  }
}

TEST_F(OnPlantTest, GuidingHoldsTheLockedAxesAndGivesWayAlongTheFreeOne) {
  for (std::uint64_t pose = 0; pose < 5; ++pose) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      setting::GuidingMode mode{{false, false, false, false, false, false}, true};
      mode.axes[axis] = true;
      Guiding guiding(kRotorInertia);
      guiding.SetMode(mode);
      plant::Push push;
      push.body = "panda_hand";
      push.point = kHandPoint;
      push.force = {14, -14, 14};  // 20 N across
      push.force[axis] = 10;
      push.duration = std::chrono::milliseconds(800);
      plant_->ClearPerturbations();
      plant_->Perturb(push);
      StartAt(PoseAboveTheFloor(pose));
      guiding.Begin(plant_->sensors().q, setup_);
      const Transform start = O_T_EE();
      for (int k = 0; k < 800; ++k) {
        Step(guiding.Torque(plant_->sensors(), sensing_.arm(), kArm, setup_));
        for (std::size_t other = 0; other < 3; ++other) {
          if (other == axis) continue;
          ASSERT_LT(std::abs(O_T_EE()[12 + other] - start[12 + other]), 1e-3)
              << "pose " << pose << ", axis " << axis << ", cycle " << k;
        }
      }
      EXPECT_GT(std::abs(O_T_EE()[12 + axis] - start[12 + axis]), 0.02);
    }
  }
}

}  // namespace
}  // namespace twin::onboard::onboard_on_plant_test
