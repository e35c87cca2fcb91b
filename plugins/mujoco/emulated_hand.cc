#include "plugins/mujoco/emulated_hand.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::plugins {

void RequireStarted(const HandStart& start, const HandCommand& command) {
  if (!start.bad) return;
  throw InputError(fmt::format("{} rejected: {}", Name(command), Describe(*start.bad)));
}

}  // namespace twin::plugins
