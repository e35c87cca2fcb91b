#include "plugins/emulated/emulated_backend.h"

#include <fmt/format.h>

namespace twin::plugins {

backend::Description DescribeRobot(const std::string& plant_name, const robot::LastMotion& last) {
  backend::Description description;
  description.name = "mujoco";
  description.robot = fmt::format("emulated Panda, {}", plant_name);
  description.last_end = backend::EndOf(last.end);
  for (const Violation& violation : last.violations.items()) {
    description.last_errors.set(static_cast<std::size_t>(violation.error));
    description.violations.push_back(violation);
  }
  return description;
}

}  // namespace twin::plugins
