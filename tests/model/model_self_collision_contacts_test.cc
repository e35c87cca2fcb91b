// The capsules of the self-collision check against the shapes of the simulated body.

#include <algorithm>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "model/model_samples.h"
#include "plant/plant_fixture.h"
#include "twin/model/self_collision.h"

namespace twin::model::model_self_collision_contacts_test {
namespace {

using ModelCopy = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

/// The gap between bodies of the arm that the engine sees up to kSeen, else kSeen.
constexpr double kSeen = 0.04;

class Body {
 public:
  Body()
      : plant_(plant::MujocoPlant::Create(Options())),
        model_(mj_copyModel(nullptr, &plant_->model()), &mj_deleteModel),
        data_(mj_makeData(model_.get()), &mj_deleteData) {
    for (int geom = 0; geom < model_->ngeom; ++geom) model_->geom_margin[geom] = kSeen;
  }

  double Gap(const JointVector& q) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      const std::string name = "panda_joint" + std::to_string(i + 1);
      data_->qpos[model_->jnt_qposadr[mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str())]] = q[i];
    }
    mj_fwdPosition(model_.get(), data_.get());
    double gap = kSeen;
    for (int c = 0; c < data_->ncon; ++c) {
      const mjContact& contact = data_->contact[c];
      if (IsOfHand(contact.geom1) && IsOfHand(contact.geom2)) continue;
      gap = std::min(gap, contact.dist);
    }
    return gap;
  }

 private:
  static plant::MujocoPlantOptions Options() {
    plant::MujocoPlantOptions options = plant::BareOptions();
    options.hand = plant::HandKind::kFrankaHand;
    options.scene.clear();
    return options;
  }
  bool IsOfHand(int geom) const {
    const std::string body = mj_id2name(model_.get(), mjOBJ_BODY, model_->geom_bodyid[geom]);
    return body.find("hand") != std::string::npos || body.find("finger") != std::string::npos;
  }

  std::unique_ptr<plant::MujocoPlant> plant_;
  ModelCopy model_;
  Data data_;
};

/// Not near the floor, which is no part of the arm.
bool IsAboveTheFloor(const JointVector& q) {
  for (const Frame frame : {Frame::kJoint4, Frame::kJoint5, Frame::kJoint7, Frame::kFlange}) {
    if (ArmModel::Panda().Pose(frame, q)[14] < 0.25) return false;
  }
  return ArmModel::Panda().Pose(Frame::kEndEffector, q, kHandPose)[14] > 0.25;
}

/// Whether what is near is the hand and the forearm, which the engine's model lets pass.
bool IsHandAtForearm(const JointVector& q) {
  return q[5] < 0.7;
}

TEST(SelfCollisionContactsTest, EveryContactOfTheBodyIsSeen) {
  Body body;
  int contacts = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const JointVector q = SampleOf(i).q;
    if (!IsAboveTheFloor(q)) continue;
    const double gap = body.Gap(q);
    if (gap > 0) continue;
    ++contacts;
    EXPECT_LT(SelfDistance(q, true), 0.01) << "sample " << i << ", the body's gap " << gap;
  }
  EXPECT_GT(contacts, 50);
}

TEST(SelfCollisionContactsTest, WhatIsSeenIsNearForTheBodyToo) {
  Body body;
  int near = 0;
  int far = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const JointVector q = SampleOf(i).q;
    if (!IsAboveTheFloor(q) || IsHandAtForearm(q) || SelfDistance(q, true) >= 0.01) continue;
    ++near;
    if (body.Gap(q) >= kSeen) ++far;
  }
  EXPECT_GT(near, 50);
  EXPECT_LE(far, near / 20) << "capsules that are 4 cm too large somewhere";
}

}  // namespace
}  // namespace twin::model::model_self_collision_contacts_test
