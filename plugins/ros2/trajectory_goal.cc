#include "plugins/ros2/trajectory_goal.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "plugins/ros2/conversions.h"
#include "twin/core/error.h"
#include "twin/core/robot_state.h"

namespace twin::ros2 {
namespace {

using Code = FollowJointTrajectory::Code;

/// Older stamps belong to no present wish.
constexpr twin::Duration kOldest = std::chrono::seconds(1);
/// Between samples of a path that gives velocities.
constexpr twin::Duration kSampling = std::chrono::milliseconds(20);
/// Of waypoints, about 30 minutes at 50 Hz.
constexpr std::size_t kMostPoints = reference::kMaxWaypoints;

[[noreturn]] void Refuse(Code code, std::string why) {
  throw std::pair(code, std::move(why));
}

/// One point, in the arm's order.
struct Point {
  twin::Duration at{};
  JointVector q{};
  std::optional<JointVector> dq;
  std::optional<JointVector> ddq;
};

/// What a client wrote, for messages: cut, and in one line.
std::string Shown(std::string text) {
  constexpr std::size_t kMost = 200;
  if (text.size() > kMost) text.replace(kMost, std::string::npos, "...");
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < ' ' || c == 0x7f; }, '?');
  return text;
}

/// Where each of the arm's joints stands in the goal's order.
std::array<std::size_t, kJoints> OrderOf(const std::vector<std::string>& given,
                                         const JointNames& names) {
  std::array<std::size_t, kJoints> order{};
  for (std::size_t j = 0; j < kJoints; ++j) {
    const auto found = std::ranges::find(given, names[j]);
    if (found == given.end() || given.size() != kJoints) {
      Refuse(
          FollowJointTrajectory::kInvalidJoints,
          fmt::format("joint_names are {}; this arm's are [{}], all of them, in any order",
                      Shown(fmt::format("[{}]", fmt::join(given, ", "))), fmt::join(names, ", ")));
    }
    order[j] = static_cast<std::size_t>(found - given.begin());
  }
  return order;
}

std::optional<JointVector> ValuesOf(const std::vector<double>& given, const char* what,
                                    std::size_t index,
                                    const std::array<std::size_t, kJoints>& order) {
  if (given.empty()) return std::nullopt;
  if (given.size() != kJoints) {
    Refuse(FollowJointTrajectory::kInvalidGoal,
           fmt::format("points[{}].{} has {} values for {} joints", index, what, given.size(),
                       kJoints));
  }
  JointVector values{};
  for (std::size_t j = 0; j < kJoints; ++j) values[j] = given[order[j]];
  if (!IsFinite(values)) {
    Refuse(FollowJointTrajectory::kInvalidGoal,
           fmt::format("points[{}].{} has a value that is not finite", index, what));
  }
  return values;
}

std::vector<Point> PointsOf(const msg::JointTrajectory& trajectory, const JointNames& names) {
  if (trajectory.points.empty()) {
    Refuse(FollowJointTrajectory::kInvalidGoal,
           "the trajectory has no points; to stop the arm, cancel its goal");
  }
  if (trajectory.points.size() > kMostPoints) {
    Refuse(FollowJointTrajectory::kInvalidGoal,
           fmt::format("the trajectory has {} points; {} are permitted", trajectory.points.size(),
                       kMostPoints));
  }
  const auto order = OrderOf(trajectory.joint_names, names);
  std::vector<Point> points;
  for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
    const msg::JointTrajectoryPoint& given = trajectory.points[i];
    const auto q = ValuesOf(given.positions, "positions", i, order);
    if (!q) {
      Refuse(FollowJointTrajectory::kInvalidGoal,
             fmt::format("points[{}] has no positions, which this arm is led by", i));
    }
    points.push_back({.at = FromMessage(given.time_from_start),
                      .q = *q,
                      .dq = ValuesOf(given.velocities, "velocities", i, order),
                      .ddq = ValuesOf(given.accelerations, "accelerations", i, order)});
    if (given.time_from_start.nanosec >= 1'000'000'000) {
      Refuse(FollowJointTrajectory::kInvalidGoal,
             fmt::format("points[{}].time_from_start has {} nanoseconds: a second or more", i,
                         given.time_from_start.nanosec));
    }
    const bool is_in_order =
        i == 0 ? points[0].at >= twin::Duration::zero() : points[i].at > points[i - 1].at;
    if (!is_in_order) {
      Refuse(FollowJointTrajectory::kInvalidGoal,
             fmt::format("points[{}].time_from_start, {} s, is not after the point before it", i,
                         ToSeconds(points[i].at)));
    }
  }
  return points;
}

/// How far a goal's joint is from the arm at its start; refused beyond kGoalStartTolerance.
JointVector OffsetOf(const Point& first, const GoalContext& context) {
  JointVector offset{};
  for (std::size_t j = 0; j < kJoints; ++j) {
    offset[j] = first.q[j] - context.q_d[j];
    if (std::abs(offset[j]) <= kGoalStartTolerance) continue;
    Refuse(
        FollowJointTrajectory::kInvalidGoal,
        fmt::format("{} is at {:.4f} rad, and the trajectory's first point, at time 0, at {:.4f} "
                    "rad; {} rad between them are permitted. Plan from where the arm is",
                    context.names[j], context.q_d[j], first.q[j], kGoalStartTolerance));
  }
  return offset;
}

/// Cubic, or quintic with accelerations, between two points with velocities.
JointVector Between(const Point& a, const Point& b, twin::Duration at) {
  const double h = ToSeconds(b.at - a.at);
  const double x = ToSeconds(at - a.at);
  const bool is_quintic = a.ddq && b.ddq;
  JointVector q{};
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double v0 = (*a.dq)[j];
    const double v1 = (*b.dq)[j];
    const double slope = (b.q[j] - a.q[j]) / h;
    const std::array<double, 6> c =
        is_quintic
            ? reference::QuinticBetween(a.q[j], v0, (*a.ddq)[j], b.q[j], v1, (*b.ddq)[j], h)
            : std::array{a.q[j], v0, (3 * slope - 2 * v0 - v1) / h, (v0 + v1 - 2 * slope) / (h * h),
                         0.0,    0.0};
    q[j] = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))));
  }
  return q;
}

/// The points, and samples between those with velocities: they say more than the points alone.
std::vector<reference::Waypoint> WaypointsOf(const std::vector<Point>& points) {
  std::vector<reference::Waypoint> waypoints;
  for (std::size_t i = 0; i < points.size(); ++i) {
    waypoints.push_back(
        {.q = points[i].q, .at = points[i].at, .where = fmt::format("points[{}]", i)});
    if (i + 1 == points.size() || !points[i].dq || !points[i + 1].dq) continue;
    const twin::Duration span = points[i + 1].at - points[i].at;
    const auto parts = (span + kSampling / 2) / kSampling;
    if (parts > static_cast<std::int64_t>(kMostPoints - waypoints.size())) {
      Refuse(FollowJointTrajectory::kInvalidGoal, "the trajectory is longer than half an hour");
    }
    for (std::int64_t part = 1; part < parts; ++part) {
      const twin::Duration at = points[i].at + span * part / parts;
      waypoints.push_back({.q = Between(points[i], points[i + 1], at), .at = at});
    }
  }
  return waypoints;
}

void RequireTimely(const msg::Time& stamp, Time now) {
  if (stamp.sec == 0 && stamp.nanosec == 0) return;  // now
  const twin::Duration age = now - FromMessage(stamp);
  if (age > kOldest) {
    Refuse(
        FollowJointTrajectory::kOldHeaderTimestamp,
        fmt::format("header.stamp lies {:.3f} s in the past; {} s are permitted. Give 0 for now, "
                    "and see that both ends use the same clock (use_sim_time)",
                    ToSeconds(age), ToSeconds(kOldest)));
  }
  if (age < -kOldest) {
    Refuse(
        FollowJointTrajectory::kInvalidGoal,
        fmt::format("header.stamp lies {:.3f} s in the future; a goal begins when it comes: give "
                    "0",
                    -ToSeconds(age)));
  }
}

void RequireRest(const Point& last) {
  constexpr double kRest = 1e-3;
  if (!last.dq) return;
  if (std::ranges::all_of(*last.dq, [](double dq) { return std::abs(dq) <= kRest; })) return;
  Refuse(FollowJointTrajectory::kInvalidGoal,
         "the last point has velocities; the arm must rest there: give zeros");
}

/// Of the message: 0 is the default, negative none.
Tolerance ToleranceOf(const std::vector<msg::JointTolerance>& given, const JointNames& names,
                      double usual, const char* what) {
  Tolerance tolerance;
  tolerance.position.fill(usual);
  for (const msg::JointTolerance& one : given) {
    const auto name = std::ranges::find(names, one.name);
    if (name == names.end()) {
      Refuse(FollowJointTrajectory::kInvalidGoal,
             fmt::format("{} names {}, which this arm has not", what, Shown(one.name)));
    }
    if (std::isnan(one.position)) {
      Refuse(FollowJointTrajectory::kInvalidGoal,
             fmt::format("{} of {} is not a number", what, one.name));
    }
    double& position = tolerance.position[static_cast<std::size_t>(name - names.begin())];
    if (one.position > 0) position = one.position;
    if (one.position < 0) position = std::numeric_limits<double>::infinity();
  }
  return tolerance;
}

JointGoal Read(const FollowJointTrajectory::Goal& goal, const GoalContext& context) {
  if (!goal.multi_dof_trajectory.points.empty()) {
    Refuse(FollowJointTrajectory::kInvalidGoal,
           "multi_dof_trajectory: this arm has no such joints");
  }
  std::vector<Point> points = PointsOf(goal.trajectory, context.names);
  RequireTimely(goal.trajectory.header.stamp, context.now);
  RequireRest(points.back());
  JointVector offset{};
  if (points.front().at == twin::Duration::zero()) {
    offset = OffsetOf(points.front(), context);
  } else {
    points.insert(points.begin(), {.at = {}, .q = context.q_d, .dq = JointVector{}, .ddq = {}});
    if (points[1].ddq) points[0].ddq = JointVector{};
  }
  if (points.size() == 1) {
    Refuse(FollowJointTrajectory::kInvalidGoal,
           "the only point is at time 0: it leaves the arm no time; give it a time_from_start");
  }
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  try {
    return {.trajectory = reference::Trajectory(WaypointsOf(points), {}, context.limits),
            .offset = offset,
            .path = ToleranceOf(goal.path_tolerance, context.names, kInfinite, "path_tolerance"),
            .end = ToleranceOf(goal.goal_tolerance, context.names, kInfinite, "goal_tolerance"),
            .end_time = FromMessage(goal.goal_time_tolerance)};
  } catch (const InputError& error) {
    Refuse(FollowJointTrajectory::kInvalidGoal, error.what());
  }
}

}  // namespace

JointNames NamesOf(std::string_view prefix) {
  JointNames names;
  for (std::size_t j = 0; j < kJoints; ++j) names[j] = fmt::format("{}{}", prefix, j + 1);
  return names;
}

std::variant<JointGoal, GoalRefusal> ReadGoal(const FollowJointTrajectory::Goal& goal,
                                              const GoalContext& context) {
  try {
    return Read(goal, context);
  } catch (const std::pair<Code, std::string>& refusal) {
    return GoalRefusal{refusal.first, refusal.second};
  }
}

}  // namespace twin::ros2
