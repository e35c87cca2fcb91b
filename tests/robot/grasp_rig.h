#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "support/dense.h"
#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/joint_impedance.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/robot/hand_unit.h"

namespace twin::test {

/// The arm in MuJoCo with its hand, the hand's controller and INT's joint impedance controller, led
/// along Cartesian paths: the tool keeps its orientation, pointing down, the fingers along base x.
class GraspRig {
 public:
  /// @param meshes  the mesh package; empty: primitive shapes.
  explicit GraspRig(const std::string& scene, const std::string& meshes = {}) {
    plant::MujocoPlantOptions options;
    options.mesh_package = meshes;
    options.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
    options.scene = TWIN_SOURCE_DIR "/models/scenes/" + scene;
    plant_ = plant::MujocoPlant::Create(options);
    reference_.q_d = {
        0, -0.785398163397448, 0, -2.356194490192345, 0, 1.570796326794897, -0.785398163397448};
    plant_->Reset(reference_.q_d);
    hand_ = std::make_unique<robot::HandUnit>(*plant_->hand());
    O_T_EE_ = Pose();
  }

  [[nodiscard]] plant::MujocoPlant& plant() { return *plant_; }
  [[nodiscard]] robot::HandUnit& hand() { return *hand_; }
  [[nodiscard]] const HandSensors& fingers() { return plant_->hand()->sensors(); }

  /// One millisecond in which the tool's reference moves with `velocity` (base axes, m/s).
  void Step(const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero()) {
    Lead(velocity);
    hand_->Cycle();
    const model::ArmModel& arm = model::ArmModel::PandaPlant();
    const JointSensors& sensors = plant_->sensors();
    const onboard::ArmSetup setup{.F_T_EE = F_T_EE_, .payload = kHand};
    const auto torque = impedance_.Torque(reference_, sensors, {arm, sensors.q, setup}, arm, setup);
    plant_->Step({.tau = torque.tau});
    ASSERT_EQ(plant_->warning_count(), 0u) << plant_->DescribeWarnings();
  }
  void Wait(int cycles) {
    for (int k = 0; k < cycles; ++k) Step();
  }

  /// Moves the tool to `point` (base, m) along the path of minimum jerk.
  void MoveTo(const Eigen::Vector3d& point, int cycles) {
    const Eigen::Vector3d way = point - Place();
    for (int k = 0; k < cycles; ++k) {
      const double s = (k + 0.5) / cycles;
      Step(30 * s * s * (1 - s) * (1 - s) / (cycles * kCycleSeconds) * way);
    }
  }

  /// Shakes the tool along base y: a sine of 2 Hz, 5 cm from peak to peak, that sets in within a
  /// second. @param observe  called after every cycle.
  void Shake(int cycles, const std::function<void(int)>& observe) {
    constexpr double kOmega = 2 * M_PI * 2;
    for (int k = 0; k < cycles; ++k) {
      const double t = k * kCycleSeconds;
      Step(Eigen::Vector3d(0, 0.025 * std::min(1.0, t) * kOmega * std::cos(kOmega * t), 0));
      observe(k);
    }
  }

  /// Runs a command of the hand to its end, the arm standing still.
  HandResult Run(const HandCommand& command) {
    const HandTicket ticket = hand_->Start(command).ticket;
    EXPECT_NE(ticket, 0u);
    for (int k = 0; k < 10'000; ++k) {
      if (const auto result = hand_->Outcome(ticket)) return *result;
      Step();
    }
    ADD_FAILURE() << Name(command) << " does not end";
    return HandResult::kFail;
  }

  /// Takes the object that lies at (0.5, 0, 0.325) m, and lifts it by 15 cm.
  void PickUp(const hand::Grasp& grasp) {
    MoveTo({0.5, 0, 0.45}, 1500);
    MoveTo({0.5, 0, 0.325}, 1000);
    ASSERT_EQ(Run(grasp), HandResult::kSuccess);
    MoveTo({0.5, 0, 0.475}, 1500);
    Wait(500);
  }

  /// Where a body is in the hand's frame.
  [[nodiscard]] Eigen::Isometry3d InHand(const std::string& body) const {
    return BodyPose("panda_hand").inverse() * BodyPose(body);
  }
  [[nodiscard]] Eigen::Isometry3d BodyPose(const std::string& body) const {
    using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const int id = mj_name2id(&plant_->model(), mjOBJ_BODY, body.c_str());
    EXPECT_GE(id, 0) << body;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Map<const Eigen::Vector3d>(plant_->data().xpos + 3 * id);
    pose.linear() = Eigen::Map<const Matrix>(plant_->data().xmat + 9 * id);
    return pose;
  }

 private:
  using Jacobian = Eigen::Matrix<double, 6, kJoints>;
  using Joints = Eigen::Matrix<double, kJoints, 1>;

  [[nodiscard]] Eigen::Matrix4d Pose() const {
    const Transform pose =
        model::ArmModel::PandaPlant().Pose(model::Frame::kEndEffector, reference_.q_d, F_T_EE_);
    return Eigen::Map<const Eigen::Matrix4d>(pose.data());
  }
  [[nodiscard]] Eigen::Vector3d Place() const { return O_T_EE_.topRightCorner<3, 1>(); }

  /// Moves the reference by one cycle of differential inverse kinematics; what it drifts from the
  /// path is taken back within 50 ms.
  void Lead(const Eigen::Vector3d& velocity) {
    O_T_EE_.topRightCorner<3, 1>() += velocity * kCycleSeconds;
    const Eigen::Matrix4d is = Pose();
    Eigen::Matrix<double, 6, 1> twist;
    twist.head<3>() = velocity + 20 * (O_T_EE_ - is).topRightCorner<3, 1>();
    const Eigen::AngleAxisd turn(
        Eigen::Matrix3d(O_T_EE_.topLeftCorner<3, 3>() * is.topLeftCorner<3, 3>().transpose()));
    twist.tail<3>() = 20 * turn.angle() * turn.axis();
    const model::Jacobian columns = model::ArmModel::PandaPlant().ZeroJacobian(
        model::Frame::kEndEffector, reference_.q_d, F_T_EE_);
    const Eigen::Map<const Jacobian> J(columns.data());
    const Joints dq = DampedLeastSquares(J, twist, 0);
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double dq_i = dq[static_cast<Eigen::Index>(i)];
      reference_.ddq_d[i] = (dq_i - reference_.dq_d[i]) / kCycleSeconds;
      reference_.dq_d[i] = dq_i;
      reference_.q_d[i] += dq_i * kCycleSeconds;
    }
  }

  static constexpr model::Payload kHand{
      .m = 0.73, .F_x_C = {-0.01, 0, 0.03}, .I = {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017}};

  const Transform F_T_EE_{std::cos(M_PI / 4),
                          -std::sin(M_PI / 4),
                          0,
                          0,
                          std::sin(M_PI / 4),
                          std::cos(M_PI / 4),
                          0,
                          0,
                          0,
                          0,
                          1,
                          0,
                          0,
                          0,
                          0.1034,
                          1};
  std::unique_ptr<plant::MujocoPlant> plant_;
  std::unique_ptr<robot::HandUnit> hand_;
  onboard::JointReference reference_;
  onboard::JointImpedance impedance_{
      {3000, 3000, 3000, 2500, 2500, 2000, 2000},
      0.7,
      {0.605721456, 0.605721456, 0.462474144, 0.462474144, 0.205544064, 0.205544064, 0.205544064}};
  Eigen::Matrix4d O_T_EE_;
};

}  // namespace twin::test
