#include "plugins/ros2/trajectory_action.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "plugins/ros2/conversions.h"
#include "twin/core/error.h"
#include "twin/rt/broadcast.h"

namespace twin::ros2 {
namespace {

/// In which a path leads over from the arm's reference to the goal's first point.
constexpr double kOffsetSeconds = 1;

/// What is known of a motion under way.
struct Progress {
  bool has_begun = false;
  twin::Duration at{};
  reference::JointTarget target;
  JointVector q{}, dq{}, tau_J{};  ///< measured in the state that the target answers
  std::size_t violated = kJoints;  ///< joint that left the path's tolerance; kJoints: none
  double distance = 0;             ///< of that joint, rad
};

JointVector Difference(const JointVector& a, const JointVector& b) {
  JointVector difference{};
  for (std::size_t j = 0; j < kJoints; ++j) difference[j] = a[j] - b[j];
  return difference;
}

/// Follows a goal's path, from the arm's reference on, and watches its tolerance.
///
/// Threads, real-time: as Controller.
class PathController final : public control::Controller {
 public:
  PathController(const JointGoal& goal, rt::Broadcast<Progress>& progress)
      : goal_(goal), progress_(progress) {}

  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  void Activate(const RobotState& /*state*/, Time /*now*/) override { start_.reset(); }

  void Update(const RobotState& state, Time now,
              control::ControllerOutput& output) noexcept TWIN_REALTIME override {
    if (!start_) start_ = now;
    Progress progress;
    progress.has_begun = true;
    progress.at = now - *start_;
    progress.target = goal_.trajectory.Sample(progress.at);
    progress.q = state.q;
    progress.dq = state.dq;
    progress.tau_J = state.tau_J;
    const double left = Left(ToSeconds(progress.at));
    for (std::size_t j = 0; j < kJoints; ++j) {
      progress.target.q[j] -= left * goal_.offset[j];
      const double distance = std::abs(state.q[j] - progress.target.q[j]);
      if (distance <= goal_.path.position[j] || failed_) continue;
      failed_ = true;
      progress.violated = j;
      progress.distance = distance;
    }
    output.target.joint = progress.target;
    output.finished = progress.at >= goal_.trajectory.duration();
    output.failed = failed_;
    if (!is_over_) progress_.Publish(progress);
    is_over_ = failed_;
  }

  void Deactivate() noexcept override {}

  [[nodiscard]] std::string Explain() const override {
    const Progress progress = progress_.Read();
    if (progress.violated >= kJoints) return {};
    return fmt::format(
        "joint {} was {:.3g} rad from the path at {:.3f} s; path_tolerance permits "
        "{:.3g} rad",
        progress.violated + 1, progress.distance, ToSeconds(progress.at),
        goal_.path.position[progress.violated]);
  }

 private:
  /// Share of the offset that is left: 1 at first, with two derivatives that vanish at both ends.
  [[nodiscard]] double Left(double t) const noexcept {
    const double span = std::min(kOffsetSeconds, ToSeconds(goal_.trajectory.duration()));
    const double x = std::min(t / span, 1.0);
    return 1 - x * x * x * (10 - x * (15 - 6 * x));
  }

  const JointGoal& goal_;
  rt::Broadcast<Progress>& progress_;
  std::optional<Time> start_;
  bool failed_ = false;
  bool is_over_ = false;  ///< the violation was published
};

}  // namespace

/// One goal.
class TrajectoryAction::Follow final : public ArmWork {
 public:
  Follow(TrajectoryAction& action, const msg::UUID& id, FollowJointTrajectory::Goal&& goal)
      : action_(action), id_(id), wish_(std::move(goal)) {}

  [[nodiscard]] const msg::UUID& id() const noexcept { return id_; }

  void Run(run::Session& session, const scenario::Scenario& client) override {
    const RobotState state = session.ReadState();
    RequireReady(state);
    auto read = ReadGoal(wish_, {.names = action_.names_,
                                 .limits = session.robot().limits,
                                 .q_d = state.q_d,
                                 .now = action_.now_()});
    wish_ = {};
    if (const auto* refusal = std::get_if<GoalRefusal>(&read)) {
      code_ = refusal->code;
      throw InputError(refusal->why);
    }
    goal_.emplace(std::get<JointGoal>(std::move(read)));
    const run::MotionResult result = MoveByOwnController(
        session, run::MotionOn(client, "follow_joint_trajectory",
                               control::CommandInterface::kJointPosition, goal_->trajectory));
    code_ = FollowJointTrajectory::kPathToleranceViolated;
    if (!result.report.failure.empty()) throw RobotFault(result.report.failure);
    code_ = FollowJointTrajectory::kGoalToleranceViolated;
    RequireAtEnd(session, result.report.q_final);
  }

  std::unique_ptr<control::Controller> MakeController(
      const control::ControllerRequest& /*request*/) override {
    return std::make_unique<PathController>(goal_.value(), progress_);
  }

  void Look() override {
    const Progress progress = progress_.Read();
    if (!progress.has_begun) return;
    FollowJointTrajectory::Feedback feedback;
    feedback.header.stamp = ToMessage(action_.now_());
    feedback.joint_names.assign(action_.names_.begin(), action_.names_.end());
    const msg::Duration at = ToMessage(progress.at);
    feedback.desired = {.positions = ToVector(progress.target.q),
                        .velocities = ToVector(progress.target.dq),
                        .accelerations = ToVector(progress.target.ddq),
                        .effort = {},
                        .time_from_start = at};
    feedback.actual = {.positions = ToVector(progress.q),
                       .velocities = ToVector(progress.dq),
                       .accelerations = {},
                       .effort = ToVector(progress.tau_J),
                       .time_from_start = at};
    feedback.error = {.positions = ToVector(Difference(progress.target.q, progress.q)),
                      .velocities = ToVector(Difference(progress.target.dq, progress.dq)),
                      .accelerations = {},
                      .effort = {},
                      .time_from_start = at};
    action_.server_.Feedback(id_, std::move(feedback));
  }

  void End(const std::string& why, bool gave_up) override {
    FollowJointTrajectory::Result answer{.error_code = why.empty() ? 0 : code_,
                                         .error_string = why};
    GoalState state = why.empty() ? GoalState::kSucceeded : GoalState::kAborted;
    if (gave_up && !why.empty()) {
      state = is_canceled_ ? GoalState::kCanceled : GoalState::kAborted;
      answer = {.error_code = is_canceled_ ? 0 : FollowJointTrajectory::kInvalidGoal,
                .error_string = is_canceled_ ? "canceled; the arm was stopped"
                                             : "preempted by a newer command; the arm was stopped"};
    } else if (!why.empty()) {
      action_.server_.Tell(why);
    }
    action_.server_.Finish(id_, state, answer);
  }

  void Cancel() { is_canceled_ = true; }

 private:
  /// Waits for the end's tolerance as long as the goal says. @throws RobotFault beyond it.
  void RequireAtEnd(run::Session& session, JointVector q) const {
    const JointVector& goal = goal_->trajectory.goal();
    const auto outside = [&](std::size_t j) {
      return !(std::abs(q[j] - goal[j]) <= goal_->end.position[j]);
    };
    const auto first = [&] {
      std::size_t j = 0;
      while (j < kJoints && !outside(j)) ++j;
      return j;
    };
    if (first() < kJoints && goal_->end_time > twin::Duration::zero()) {
      static_cast<void>(session.Wait(goal_->end_time, [&](const RobotState& state) {
        q = state.q;
        return first() == kJoints;
      }));
    }
    const std::size_t joint = first();
    if (joint == kJoints) return;
    throw RobotFault(fmt::format(
        "{} rests {:.4f} rad from the goal; goal_tolerance permits {:.4f} rad",
        action_.names_[joint], std::abs(q[joint] - goal[joint]), goal_->end.position[joint]));
  }

  TrajectoryAction& action_;
  const msg::UUID id_;
  FollowJointTrajectory::Goal wish_;
  std::optional<JointGoal> goal_;
  FollowJointTrajectory::Code code_ = FollowJointTrajectory::kInvalidGoal;
  rt::Broadcast<Progress> progress_;
  std::atomic<bool> is_canceled_{false};
};

TrajectoryAction::TrajectoryAction(Node& node, const std::string& name, ArmCommander& arm,
                                   JointNames names, std::function<Time()> now,
                                   std::function<std::string()> why_not)
    : arm_(arm),
      names_(std::move(names)),
      now_(std::move(now)),
      why_not_(std::move(why_not)),
      server_(node, name,
              {.begin = [this](const msg::UUID& id,
                               FollowJointTrajectory::Goal&& goal) { Begin(id, std::move(goal)); },
               .cancel = [this](const msg::UUID& id) { Cancel(id); },
               .now = [this] { return ToMessage(now_()); }}) {}

TrajectoryAction::~TrajectoryAction() = default;

void TrajectoryAction::Begin(const msg::UUID& id, FollowJointTrajectory::Goal&& goal) {
  const std::string why = why_not_();
  if (!why.empty()) {
    server_.Tell(why);
    return server_.Finish(id, GoalState::kAborted,
                          {.error_code = FollowJointTrajectory::kInvalidGoal, .error_string = why});
  }
  auto follow = std::make_shared<Follow>(*this, id, std::move(goal));
  current_ = follow;
  arm_.Begin(std::move(follow));
}

void TrajectoryAction::Cancel(const msg::UUID& id) {
  const std::shared_ptr<Follow> current = current_.lock();
  if (!current || current->id() != id) return;
  current->Cancel();
  arm_.GiveUp(*current);
}

}  // namespace twin::ros2
