#include "plugins/ros2/gripper_action.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::ros2 {
namespace {

/// Of the opening, m/s: the hand's highest.
constexpr double kSpeed = 0.1;
/// The fingers' position, m, within which a goal is reached: about the hand's own accuracy.
constexpr double kReached = 1e-3;
/// Highest force that the hand applies for long, N (Franka's data sheet).
constexpr double kMostForce = 70;

HandCommand CommandFor(const msg::GripperCommandMessage& wish, const HandState& state) {
  const double most = (state.max_width > 0 ? state.max_width : kHandStroke) / 2;
  // Planners' models open to 0.04 m each, which the fingers reach within less than their tolerance.
  if (!(wish.position >= -kReached && wish.position <= most + kReached) ||
      !std::isfinite(wish.max_effort) || wish.max_effort < 0) {
    throw InputError(fmt::format(
        "position is {} m and max_effort {} N; position is that of one finger, in [0, {:.4f}] m, "
        "and max_effort at least 0",
        wish.position, wish.max_effort, most));
  }
  const double width = 2 * std::clamp(wish.position, 0.0, most);
  if (width >= state.width || wish.max_effort == 0) return hand::Move{width, kSpeed};
  return hand::Grasp{.width = width,
                     .speed = kSpeed,
                     .force = std::min(wish.max_effort, kMostForce),
                     .epsilon_inner = kHandStroke,
                     .epsilon_outer = kHandStroke};
}

}  // namespace

GripperAction::GripperAction(Node& node, const std::string& name, HandCommander& hand,
                             std::function<msg::Time()> now)
    : hand_(hand),
      server_(node, name,
              {.begin = [this](const msg::UUID& id,
                               const GripperCommand::Goal& goal) { Begin(id, goal); },
               .cancel =
                   [this](const msg::UUID& id) {
                     if (id != current_) return;
                     *is_canceled_ = true;
                     hand_.Stop();
                   },
               .now = std::move(now)}) {}

void GripperAction::Begin(const msg::UUID& id, const GripperCommand::Goal& goal) {
  current_ = id;
  auto is_canceled = is_canceled_ = std::make_shared<std::atomic<bool>>(false);
  const msg::GripperCommandMessage wish = goal.command;
  const auto look = [this, id, wish](const HandState& state) {
    const double position = state.width / 2;
    server_.Feedback(id, {.position = position,
                          .effort = state.is_grasped ? wish.max_effort : 0,
                          .stalled = state.is_grasped,
                          .reached_goal = std::abs(position - wish.position) <= kReached});
  };
  const auto end = [this, id, wish, is_canceled](std::optional<HandResult> result,
                                                 const HandState& state, const std::string& why) {
    const double position = state.width / 2;
    const GripperCommand::Result answer{
        .position = position,
        .effort = state.is_grasped ? wish.max_effort : 0,
        .stalled = state.is_grasped,
        .reached_goal = result && std::abs(position - wish.position) <= kReached};
    const bool is_well = result && why.empty() && (answer.reached_goal || answer.stalled);
    server_.Finish(id,
                   *is_canceled ? GoalState::kCanceled
                   : is_well    ? GoalState::kSucceeded
                                : GoalState::kAborted,
                   answer);
    if (!is_well && !*is_canceled)
      server_.Tell(why.empty() ? "the fingers did not get there" : why);
  };
  hand_.Begin({.choose = [wish](const HandState& state) { return CommandFor(wish, state); },
               .look = look,
               .end = end});
}

}  // namespace twin::ros2
