#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "application/pick.h"
#include "twin/application/application.h"
#include "twin/control/parameters.h"
#include "twin/core/hand_command.h"
#include "twin/core/joint_vector.h"
#include "twin/core/setting.h"
#include "twin/planning/collision_world.h"

namespace twin::application {

/// The steps of picking an object up and putting it down, for the tasks that are made of them. Each
/// is one attempt at a step; a leg is planned again where the arm is not at its planned start.
///
/// Threads: one.
class PickSteps {
 public:
  /// @param controller  parameters of `cartesian_pose`.
  PickSteps(Handling handling, control::Parameters controller);

  /// @param stage  must outlive the steps that follow.
  void Begin(Stage& stage, PickTask task);

  /// Plans all legs.
  StepEnd Plan();
  /// Plans the legs from this one on, from where the arm is.
  StepEnd PlanFrom(Leg leg) { return PlanFrom(leg, Ready()); }
  StepEnd Approach();
  StepEnd Grasp();
  /// Gives INT the object as its load. @pre the hand holds it.
  void Bear();
  StepEnd Lift();
  StepEnd Transfer() { return Carry(kTransfer); }
  StepEnd Place();
  StepEnd Release();
  StepEnd Retreat();

  [[nodiscard]] const Handling& handling() const noexcept { return handling_; }
  [[nodiscard]] const PickPlan& plan() const noexcept { return plan_; }
  [[nodiscard]] PickRecord& record() noexcept { return record_; }
  /// Whether something of the object's width is in the hand.
  [[nodiscard]] bool Holds() const;
  [[nodiscard]] HandState hand_state() const { return session().connection().hand->ReadState(); }
  /// The object's pose in the world where the hand holds it.
  [[nodiscard]] Transform ObjectAt(const Transform& O_T_EE) const;

 private:
  StepEnd PlanFrom(Leg leg, const JointVector& q);
  StepEnd Carry(Leg leg);
  /// Executes a leg; plans it again if the arm is not at its start.
  StepEnd Go(Leg leg);
  StepEnd Follow(const std::string& name, const LegPlan& leg, const JointVector& q);
  /// The motion of a leg from q, which is near its start.
  [[nodiscard]] run::Motion OnPoses(const std::string& name, const LegPlan& leg,
                                    const JointVector& q) const;
  [[nodiscard]] run::Motion OnJoints(const std::string& name, const LegPlan& leg,
                                     const JointVector& q) const;
  /// The arm's position, at rest and ready to move.
  [[nodiscard]] JointVector Ready();
  StepEnd Open();
  [[nodiscard]] setting::Load LoadOfObject() const;
  /// The record of a leg's plan; added when it is the first.
  record::PlanRecord& RecordOf(Leg leg);
  [[nodiscard]] std::vector<Vector3> InWorld(std::vector<Vector3> path) const;
  [[nodiscard]] run::Session& session() const { return stage_->session; }
  void Configure(const setting::Load& load) { session().connection().backend->Configure(load); }
  [[nodiscard]] double opening() const { return planner_->OpeningFor(plan_.grip); }

  const Handling handling_;
  const control::Parameters controller_;
  Stage* stage_ = nullptr;
  std::unique_ptr<planning::CollisionWorld> world_;
  std::optional<PickPlanner> planner_;
  PickPlan plan_;
  PickRecord record_;
  bool is_around_object_ = false;  ///< the open fingers are around it
};

/// A step of a task, of one attempt unless `attempts` says otherwise.
template <typename Task>
[[nodiscard]] TaskStep StepOf(Task& task, const char* name, StepEnd (Task::*act)(),
                              const char* after_failure = "", int attempts = 1) {
  return {name, [&task, act] { return (task.*act)(); }, after_failure, attempts};
}

}  // namespace twin::application
