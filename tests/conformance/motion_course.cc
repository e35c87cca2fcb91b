#include "conformance/motion_course.h"

#include <algorithm>

#include <fmt/format.h>

#include "twin/fci/datagrams.h"

namespace twin::test {
namespace {

bool ShowsMove(const RobotState& state) {
  return state.robot_mode == RobotMode::kMove;
}

/// All of a state but its id.
std::vector<std::byte> ContentOf(const RobotState& state) {
  fci::StateBytes bytes{};
  fci::Encode(state, bytes);
  return {bytes.begin() + sizeof state.message_id, bytes.end()};
}

}  // namespace

MotionCourse CourseOf(const std::vector<RobotState>& all) {
  MotionCourse course;
  const auto first = std::ranges::find_if_not(all, [](const RobotState& state) {
    return state.robot_mode == RobotMode::kIdle;  // a motion may end in the cycle it begins in
  });
  auto last = std::find_if_not(first, all.end(), ShowsMove);
  course.is_over = last != all.end();
  const auto follows = [](const RobotState& a, const RobotState& b) {
    return b.message_id == a.message_id + 1;
  };
  if (first != all.begin() && first != all.end()) {
    course.missed_begin = !follows(*(first - 1), *first);
  }
  if (course.is_over) {
    course.missed_end = last != all.begin() && !follows(*(last - 1), *last);
    ++last;
  }
  course.states.assign(first, last);
  return course;
}

std::optional<std::string> FindDifference(const MotionCourse& here, const MotionCourse& there) {
  if (there.states.size() != here.states.size() || there.is_over != here.is_over) {
    return fmt::format("{} states of the motion in process, {} over the wire", here.states.size(),
                       there.states.size());
  }
  const std::size_t seen = here.states.size() - (there.missed_end ? 1 : 0);
  for (std::size_t i = kUncommanded; i < seen; ++i) {
    if (ContentOf(here.states[i]) != ContentOf(there.states[i])) {
      return fmt::format("state {} of the motion is another one over the wire", i);
    }
  }
  return std::nullopt;
}

}  // namespace twin::test
