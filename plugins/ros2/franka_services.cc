#include "plugins/ros2/franka_services.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "twin/backend/backend.h"
#include "twin/core/error.h"
#include "twin/core/setting.h"

namespace twin::ros2 {
namespace {

constexpr const char* kBusy = "the arm moves; wait until its goal has ended, or cancel it";

/// Something that takes the robot a moment and does not move it.
class Request final : public ArmWork {
 public:
  using Do = std::function<void(run::Session&)>;
  using End_ = std::function<void(const std::string& why)>;
  Request(Do act, End_ end) : do_(std::move(act)), end_(std::move(end)) {}
  void Run(run::Session& session, const scenario::Scenario& /*client*/) override { do_(session); }
  void End(const std::string& why, bool /*gave_up*/) override { end_(why); }

 private:
  const Do do_;
  const End_ end_;
};

void Ask(ArmCommander& arm, Request::Do act, const Request::End_& end) {
  if (!arm.TryBegin(std::make_shared<Request>(std::move(act), end))) end(kBusy);
}

/// Serves a setter. @param make  makes of S::Request the robot's setting.
template <typename S, typename Make>
void ServeSetter(Node& node, ArmCommander& arm, const char* name, Make make) {
  node.Serve<S>(std::string("service_server/") + name,
                [&arm, make](const typename S::Request& request, const auto& reply) {
                  Ask(
                      arm,
                      [make, request](run::Session& session) {
                        session.connection().backend->Configure(make(request));
                      },
                      [reply](const std::string& why) {
                        typename S::Response response;
                        response.success = why.empty();
                        response.error = why;
                        reply(response);
                      });
                });
}

/// With a threshold of 0 the robot is in a reflex at once, and none can be set in one.
template <typename Thresholds>
void RequireAboveZero(const Thresholds& upper) {
  if (std::ranges::all_of(upper, [](double x) { return x > 0; })) return;
  throw InputError("an upper threshold is 0 or below: the robot would stop by a reflex at once");
}

setting::CollisionBehavior BehaviorOf(const msg::SetFullCollisionBehavior::Request& request) {
  RequireAboveZero(request.upper_torque_thresholds_acceleration);
  RequireAboveZero(request.upper_torque_thresholds_nominal);
  RequireAboveZero(request.upper_force_thresholds_acceleration);
  RequireAboveZero(request.upper_force_thresholds_nominal);
  return {.lower_torque_acc = request.lower_torque_thresholds_acceleration,
          .upper_torque_acc = request.upper_torque_thresholds_acceleration,
          .lower_torque_nominal = request.lower_torque_thresholds_nominal,
          .upper_torque_nominal = request.upper_torque_thresholds_nominal,
          .lower_force_acc = request.lower_force_thresholds_acceleration,
          .upper_force_acc = request.upper_force_thresholds_acceleration,
          .lower_force_nominal = request.lower_force_thresholds_nominal,
          .upper_force_nominal = request.upper_force_thresholds_nominal};
}

/// libfranka's short form: one set of thresholds for both.
setting::CollisionBehavior BehaviorOf(
    const msg::SetForceTorqueCollisionBehavior::Request& request) {
  RequireAboveZero(request.upper_torque_thresholds_nominal);
  RequireAboveZero(request.upper_force_thresholds_nominal);
  return {.lower_torque_acc = request.lower_torque_thresholds_nominal,
          .upper_torque_acc = request.upper_torque_thresholds_nominal,
          .lower_torque_nominal = request.lower_torque_thresholds_nominal,
          .upper_torque_nominal = request.upper_torque_thresholds_nominal,
          .lower_force_acc = request.lower_force_thresholds_nominal,
          .upper_force_acc = request.upper_force_thresholds_nominal,
          .lower_force_nominal = request.lower_force_thresholds_nominal,
          .upper_force_nominal = request.upper_force_thresholds_nominal};
}

HandCommand CommandOf(const msg::Homing::Goal& /*goal*/) {
  return hand::Homing();
}

HandCommand CommandOf(const msg::Move::Goal& goal) {
  return hand::Move{.width = goal.width, .speed = goal.speed};
}

HandCommand CommandOf(const msg::Grasp::Goal& goal) {
  return hand::Grasp{.width = goal.width,
                     .speed = goal.speed,
                     .force = goal.force,
                     .epsilon_inner = goal.epsilon.inner,
                     .epsilon_outer = goal.epsilon.outer};
}

}  // namespace

void Recover(ArmCommander& arm, const std::function<void(const std::string& why)>& end) {
  const auto recover = [](run::Session& session) {
    session.Recover();
    if (session.interrupted()) throw RobotFault("given up for another command");
  };
  Ask(arm, recover, end);
}

FrankaArmServices::FrankaArmServices(Node& node, ArmCommander& arm,
                                     const std::function<msg::Time()>& now)
    : arm_(arm),
      recovery_(node, "action_server/error_recovery",
                {.begin =
                     [this](const msg::UUID& id, const msg::ErrorRecovery::Goal&) {
                       Recover(arm_, [this, id](const std::string& why) {
                         if (!why.empty()) recovery_.Tell(why);
                         recovery_.Finish(
                             id, why.empty() ? GoalState::kSucceeded : GoalState::kAborted, {});
                       });
                     },
                 .cancel = [](const msg::UUID&) {},
                 .now = now}) {
  ServeSetter<msg::SetJointStiffness>(node, arm, "set_joint_stiffness", [](const auto& request) {
    return setting::JointImpedance{request.joint_stiffness};
  });
  ServeSetter<msg::SetCartesianStiffness>(
      node, arm, "set_cartesian_stiffness",
      [](const auto& request) { return setting::CartesianImpedance{request.cartesian_stiffness}; });
  ServeSetter<msg::SetTCPFrame>(node, arm, "set_tcp_frame", [](const auto& request) {
    return setting::EndEffectorFrame{request.transformation};
  });
  ServeSetter<msg::SetStiffnessFrame>(node, arm, "set_stiffness_frame", [](const auto& request) {
    return setting::StiffnessFrame{request.transformation};
  });
  ServeSetter<msg::SetForceTorqueCollisionBehavior>(
      node, arm, "set_force_torque_collision_behavior",
      [](const auto& request) { return BehaviorOf(request); });
  ServeSetter<msg::SetFullCollisionBehavior>(
      node, arm, "set_full_collision_behavior",
      [](const auto& request) { return BehaviorOf(request); });
  ServeSetter<msg::SetLoad>(node, arm, "set_load", [](const auto& request) {
    return setting::Load{.m_load = request.mass,
                         .F_x_Cload = request.center_of_mass,
                         .I_load = request.load_inertia};
  });
}

template <typename A>
struct FrankaHandActions::Action {
  Action(Node& node, const char* name, HandCommander& to, const std::function<msg::Time()>& now)
      : hand(to),
        server(node, std::string("panda_gripper/") + name,
               {.begin = [this](const msg::UUID& id,
                                const typename A::Goal& goal) { Begin(id, goal); },
                .cancel =
                    [this](const msg::UUID& id) {
                      if (id != current) return;
                      *is_canceled = true;
                      hand.Stop();
                    },
                .now = now}) {}

  void Begin(const msg::UUID& id, const typename A::Goal& goal) {
    current = id;
    auto canceled = is_canceled = std::make_shared<std::atomic<bool>>(false);
    const auto end = [this, id, canceled](std::optional<HandResult> result,
                                          const HandState& /*state*/, const std::string& why) {
      typename A::Result answer;
      answer.success = result == HandResult::kSuccess;
      if (!answer.success) answer.error = result ? std::string(Name(*result)) : why;
      server.Finish(id,
                    *canceled        ? GoalState::kCanceled
                    : answer.success ? GoalState::kSucceeded
                                     : GoalState::kAborted,
                    answer);
    };
    hand.Begin({.choose = [goal](const HandState&) { return CommandOf(goal); },
                .look = [](const HandState&) {},
                .end = end});
  }

  HandCommander& hand;
  msg::UUID current;                               ///< of the node's thread
  std::shared_ptr<std::atomic<bool>> is_canceled;  ///< the current one
  ActionServer<A> server;
};

FrankaHandActions::FrankaHandActions(Node& node, HandCommander& hand,
                                     const std::function<msg::Time()>& now)
    : homing_(std::make_shared<Action<msg::Homing>>(node, "homing", hand, now)),
      move_(std::make_shared<Action<msg::Move>>(node, "move", hand, now)),
      grasp_(std::make_shared<Action<msg::Grasp>>(node, "grasp", hand, now)) {}

}  // namespace twin::ros2
