#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "plugins/ros2/action_messages.h"
#include "plugins/ros2/node.h"

namespace twin::ros2 {

/// Of a goal: action_msgs/msg/GoalStatus.
enum class GoalState : std::int8_t {
  kUnknown = 0,
  kExecuting = 2,
  kCanceling = 3,
  kSucceeded = 4,
  kCanceled = 5,
  kAborted = 6,
};

/// A server of the action A: three services and two topics. It accepts every goal, since a rejected
/// one can carry no sentence; what is wrong with it is its result.
///
/// Threads: constructor as Node's Serve(); Feedback() and Finish() any. `begin` and `cancel` run on
/// the node's thread.
/// Source: https://design.ros2.org/articles/actions.html, and the names as rcl_action has them.
template <typename A>
class ActionServer {
 public:
  using GoalId = msg::UUID;
  struct Handlers {
    /// A goal to execute; Finish() must follow.
    std::function<void(const GoalId& id, typename A::Goal&& goal)> begin;
    /// Wishes the goal's early end; Finish() must follow as without.
    std::function<void(const GoalId& id)> cancel;
    /// For the stamps of goals.
    std::function<msg::Time()> now;
  };

  ActionServer(Node& node, const std::string& name, Handlers handlers)
      : node_(node),
        name_(node.Resolve(name)),
        handlers_(std::move(handlers)),
        feedback_(node.Advertise<FeedbackMessage<A>>(name + "/_action/feedback", {})),
        status_(node.Advertise<msg::GoalStatusArray>(name + "/_action/status",
                                                     {.is_latched = true, .depth = 1})) {
    node.Serve<SendGoal<A>>(name + "/_action/send_goal",
                            [this](typename SendGoal<A>::Request&& request, const auto& reply) {
                              this->Accept(std::move(request), reply);
                            });
    node.Serve<CancelGoal>(name + "/_action/cancel_goal",
                           [this](const CancelGoal::Request& request, const auto& reply) {
                             reply(this->Cancel(request.goal_info));
                           });
    node.Serve<GetResult<A>>(name + "/_action/get_result",
                             [this](const typename GetResult<A>::Request& request,
                                    const auto& reply) { AnswerResult(request.goal_id, reply); });
    status_->Publish({});
  }
  ActionServer(const ActionServer&) = delete;
  ActionServer& operator=(const ActionServer&) = delete;

  void Feedback(const GoalId& id, typename A::Feedback feedback) {
    if (!feedback_->has_readers()) return;
    feedback_->Publish({.goal_id = id, .feedback = std::move(feedback)});
  }

  void Finish(const GoalId& id, GoalState state, typename A::Result result) {
    node_.Post([this, id, state, result = std::move(result)] {
      Goal* const goal = Find(id);
      if (goal == nullptr || goal->result) return;
      goal->state = state;
      goal->result = result;
      for (const auto& reply : goal->askers) reply(ResponseOf(*goal));
      goal->askers.clear();
      PublishStatus();
    });
  }

  /// Tells people about the action. Threads: any.
  void Tell(std::string_view line) const { node_.Tell(fmt::format("ROS 2: {}: {}", name_, line)); }

 private:
  using ReplyResult = std::function<void(const typename GetResult<A>::Response&)>;
  struct Goal {
    msg::GoalInfo info;
    GoalState state = GoalState::kExecuting;
    std::optional<typename A::Result> result{};
    std::vector<ReplyResult> askers{};  ///< who waits for it
  };
  /// Results that are kept for clients who ask late.
  static constexpr std::size_t kKeptGoals = 100;

  void Accept(typename SendGoal<A>::Request&& request, const auto& reply) {
    typename SendGoal<A>::Response response;
    response.stamp = handlers_.now();
    if (Find(request.goal_id) != nullptr) return reply(response);
    response.accepted = true;
    while (goals_.size() >= kKeptGoals && goals_.front().result) goals_.pop_front();
    goals_.push_back({.info = {.goal_id = request.goal_id, .stamp = response.stamp}});
    reply(response);
    PublishStatus();
    handlers_.begin(request.goal_id, std::move(request.goal));
  }

  [[nodiscard]] CancelGoal::Response Cancel(const msg::GoalInfo& wish) {
    CancelGoal::Response response;
    const bool names_one = wish.goal_id != GoalId();
    const bool has_time = wish.stamp.sec != 0 || wish.stamp.nanosec != 0;
    for (Goal& goal : goals_) {
      const bool is_before = has_time && std::pair(goal.info.stamp.sec, goal.info.stamp.nanosec) <=
                                             std::pair(wish.stamp.sec, wish.stamp.nanosec);
      const bool is_meant =
          goal.info.goal_id == wish.goal_id || is_before || (!names_one && !has_time);
      if (!is_meant || goal.result) continue;
      goal.state = GoalState::kCanceling;
      response.goals_canceling.push_back(goal.info);
      handlers_.cancel(goal.info.goal_id);
    }
    if (names_one && response.goals_canceling.empty()) {
      response.return_code =
          Find(wish.goal_id) == nullptr ? CancelGoal::kUnknownGoal : CancelGoal::kTerminated;
    }
    PublishStatus();
    return response;
  }

  void AnswerResult(const GoalId& id, ReplyResult reply) {
    Goal* const goal = Find(id);
    if (goal == nullptr) return reply({});  // status unknown
    if (goal->result) return reply(ResponseOf(*goal));
    goal->askers.push_back(std::move(reply));
  }

  [[nodiscard]] static typename GetResult<A>::Response ResponseOf(const Goal& goal) {
    return {.status = static_cast<std::int8_t>(goal.state), .result = *goal.result};
  }
  [[nodiscard]] Goal* Find(const GoalId& id) {
    const auto goal =
        std::ranges::find_if(goals_, [&](const Goal& one) { return one.info.goal_id == id; });
    return goal == goals_.end() ? nullptr : &*goal;
  }
  void PublishStatus() {
    msg::GoalStatusArray array;
    for (const Goal& goal : goals_) {
      array.status_list.push_back(
          {.goal_info = goal.info, .status = static_cast<std::int8_t>(goal.state)});
    }
    status_->Publish(array);
  }

  Node& node_;
  const std::string name_;
  const Handlers handlers_;
  const std::unique_ptr<Publisher<FeedbackMessage<A>>> feedback_;
  const std::unique_ptr<Publisher<msg::GoalStatusArray>> status_;
  std::deque<Goal> goals_;  ///< oldest first; of the node's thread
};

}  // namespace twin::ros2
