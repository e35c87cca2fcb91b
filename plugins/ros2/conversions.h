#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "plugins/ros2/messages.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/model/transform.h"

// Between the twin's types and messages. Threads: any.
namespace twin::ros2 {

namespace detail {
template <typename M>
M SecondsAndNanoseconds(twin::Duration span) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(span);
  return {.sec = static_cast<std::int32_t>(seconds.count()),
          .nanosec = static_cast<std::uint32_t>((span - seconds).count())};
}
}  // namespace detail

[[nodiscard]] inline msg::Time ToMessage(Time at) {
  return detail::SecondsAndNanoseconds<msg::Time>(at.time_since_epoch());
}
[[nodiscard]] inline msg::Duration ToMessage(twin::Duration span) {
  return detail::SecondsAndNanoseconds<msg::Duration>(span);
}
[[nodiscard]] inline twin::Duration FromMessage(const msg::Duration& span) {
  return std::chrono::seconds(span.sec) + std::chrono::nanoseconds(span.nanosec);
}
[[nodiscard]] inline Time FromMessage(const msg::Time& stamp) {
  return Time(std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec));
}

[[nodiscard]] inline std::vector<double> ToVector(const JointVector& values) {
  return {values.begin(), values.end()};
}

[[nodiscard]] inline msg::Pose PoseOf(const Transform& T) {
  const auto p = model::Position(T);
  const auto q = model::Orientation(T);
  return {.position = {.x = p.x(), .y = p.y(), .z = p.z()},
          .orientation = {.x = q.x(), .y = q.y(), .z = q.z(), .w = q.w()}};
}

/// A frame in the world, for /tf. @param X_WF  its pose.
[[nodiscard]] inline msg::TransformStamped FrameInWorld(const std::string& frame,
                                                        const Transform& X_WF,
                                                        const msg::Time& stamp) {
  const msg::Pose pose = PoseOf(X_WF);
  return {.header = {.stamp = stamp, .frame_id = "world"},
          .child_frame_id = frame,
          .transform = {
              .translation = {.x = pose.position.x, .y = pose.position.y, .z = pose.position.z},
              .rotation = pose.orientation}};
}

}  // namespace twin::ros2
