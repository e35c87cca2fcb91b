#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/ros2/action_messages.h"
#include "plugins/ros2/camera_messages.h"
#include "plugins/ros2/cdr.h"
#include "plugins/ros2/franka_messages.h"
#include "plugins/ros2/messages.h"
#include "plugins/ros2/simulation_messages.h"

namespace twin::ros2 {

/// Gives each field of a message a value of its own; sequences 1 to 3 elements, so that alignments
/// differ.
class Filler {
 public:
  void operator()(std::string_view /*name*/, auto& field) { Fill(field); }

  void Fill(Message auto& message) {
    std::remove_cvref_t<decltype(message)>::Visit(message, *this);
  }
  template <Number T>
  void Fill(T& value) {
    value = static_cast<T>(++count_ % 100);
  }
  void Fill(std::string& text) { text = std::string(++count_ % 7, 'x'); }
  template <std::size_t N>
  void Fill(BoundedString<N>& text) {
    Fill(text.text);
  }
  template <typename T, std::size_t N>
  void Fill(std::array<T, N>& elements) {
    for (T& element : elements) Fill(element);
  }
  template <typename T>
  void Fill(std::vector<T>& elements) {
    elements.resize(1 + ++count_ % 3);
    for (T& element : elements) Fill(element);
  }

 private:
  unsigned count_ = 0;
};

template <Message M>
[[nodiscard]] M Filled() {
  M message;
  Filler().Fill(message);
  return message;
}

/// Calls visitor.operator()<M>() for what carries an action's messages.
template <typename A>
void ForEachMessageOfAction(auto&& visitor) {
  visitor.template operator()<typename SendGoal<A>::Request>();
  visitor.template operator()<typename SendGoal<A>::Response>();
  visitor.template operator()<typename GetResult<A>::Request>();
  visitor.template operator()<typename GetResult<A>::Response>();
  visitor.template operator()<FeedbackMessage<A>>();
}

/// Calls visitor.operator()<M>() for each message of all tables.
void ForEachMessageOfAll(auto&& visitor) {
  ForEachMessage(visitor);
  ForEachCameraMessage(visitor);
  ForEachFrankaMessage(visitor);
  ForEachSimulationMessage(visitor);
  visitor.template operator()<msg::UUID>();
  visitor.template operator()<msg::GoalInfo>();
  visitor.template operator()<msg::GoalStatus>();
  visitor.template operator()<msg::GoalStatusArray>();
  visitor.template operator()<msg::JointTolerance>();
  visitor.template operator()<msg::JointComponentTolerance>();
  visitor.template operator()<msg::GripperCommandMessage>();
  visitor.template operator()<CancelGoal::Request>();
  visitor.template operator()<CancelGoal::Response>();
  visitor.template operator()<SetBool::Request>();
  visitor.template operator()<SetBool::Response>();
  visitor.template operator()<Trigger::Request>();
  visitor.template operator()<Trigger::Response>();
  visitor.template operator()<FollowJointTrajectory::Goal>();
  visitor.template operator()<FollowJointTrajectory::Result>();
  visitor.template operator()<FollowJointTrajectory::Feedback>();
  visitor.template operator()<GripperCommand::Goal>();
  visitor.template operator()<GripperCommand::Result>();
  visitor.template operator()<GripperCommand::Feedback>();
  ForEachMessageOfAction<FollowJointTrajectory>(visitor);
  ForEachMessageOfAction<GripperCommand>(visitor);
  ForEachMessageOfAction<msg::Homing>(visitor);
  ForEachMessageOfAction<msg::Move>(visitor);
  ForEachMessageOfAction<msg::Grasp>(visitor);
  ForEachMessageOfAction<msg::ErrorRecovery>(visitor);
  ForEachMessageOfAction<msg::SimulateSteps>(visitor);
}

}  // namespace twin::ros2
